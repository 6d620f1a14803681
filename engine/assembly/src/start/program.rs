//! Components in other programs.

use std::time::Duration;

use asmotion_component::{Component, Interface};
use asmotion_plan::Implementation;
use asmotion_program::{ProgramCommand, ProgramComponent};

use super::workshop::Make;

/// Returns the constructor of a component that a program implements.
pub(super) fn make(component: &asmotion_plan::Component) -> Result<Make, String> {
    let (Some(command), Some(declaration)) = (command(component), component.program.clone()) else {
        return Err("its program was not asked for its declaration".to_owned());
    };
    Ok(Box::new(move |interface: &mut Interface| {
        let component = ProgramComponent::new(command, declaration, interface);
        Ok(Box::new(component) as Box<dyn Component>)
    }))
}

/// The command of a component; `None` if no program implements it.
fn command(component: &asmotion_plan::Component) -> Option<ProgramCommand> {
    let Implementation::Process {
        command,
        directory,
        start_timeout_s,
        timeout_s,
    } = &component.implementation
    else {
        return None;
    };
    Some(ProgramCommand {
        words: command.clone(),
        directory: directory.as_deref().unwrap_or_default().into(),
        start_timeout: Duration::from_secs_f64(*start_timeout_s),
        timeout: Duration::from_secs_f64(*timeout_s),
    })
}
