//! Components in other programs, as far as checks are concerned: their declarations, and the types and interfaces that
//! only they know.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use asmotion_component::declaration::{Declaration, OperationDeclaration};
use asmotion_datum::Schema;
use asmotion_diagnostics::Loader;
use asmotion_program::{ProgramCommand, ProgramDeclaration, ProgramError};

use crate::at::At;
use crate::catalogue::{Catalogue, ComponentFactory, RosFolders, RosMessages};
use crate::model::{BridgeKind, BuiltinComponent, Implementation, Process};

/// The declaration of a program, or the reason that there is none.
pub type ProgramAnswer = Result<ProgramDeclaration, ProgramError>;

/// Asks programs for their declarations.
pub trait Programs {
    /// Returns the declaration of a program that implements a component of this name; `None` if it is not asked.
    fn ask(&self, command: &ProgramCommand, component: &str) -> Option<ProgramAnswer>;

    /// Returns the declaration of a component of another robot at this address, `robot://ROBOT/Component`; `None` if the
    /// robot is not asked. `broker` is the broker that the composite names for the component.
    fn ask_robot(&self, _address: &str, _broker: Option<&str>) -> Option<ProgramAnswer> {
        None
    }

    /// Returns whether a process of the composite runs here. The programs of another process can be absent on this machine.
    fn runs(&self, _process: &Process) -> bool {
        true
    }
}

/// Asks no program. The declarations of their components are not verified, and they cannot be started.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoPrograms;

impl Programs for NoPrograms {
    fn ask(&self, _: &ProgramCommand, _: &str) -> Option<ProgramAnswer> {
        None
    }
}

/// Returns the command of a component in the composite at this path; `None` if no program implements it.
pub(crate) fn command_of(
    implementation: &Implementation,
    composite: &str,
) -> Option<ProgramCommand> {
    let Implementation::Process {
        command,
        directory,
        start_timeout_s,
        timeout_s,
    } = implementation
    else {
        return None;
    };
    let seconds = |limit: &Option<At<f64>>, default: f64| {
        Duration::from_secs_f64(limit.as_ref().map_or(default, |limit| limit.value))
    };
    Some(ProgramCommand {
        words: command.iter().map(|word| word.value.clone()).collect(),
        directory: directory_of(directory.as_ref().map(|it| it.value.as_str()), composite),
        start_timeout: seconds(start_timeout_s, Implementation::START_TIMEOUT_S),
        timeout: seconds(timeout_s, Implementation::TIMEOUT_S),
    })
}

/// Returns the address of the component of another robot that a component stands for; `None` for other components.
pub(crate) fn robot_component(implementation: &Implementation) -> Option<&At<String>> {
    match implementation {
        Implementation::Builtin { target, .. }
            if implementation.builtin() == Some(BuiltinComponent::Remote) =>
        {
            target.as_ref()
        }
        Implementation::Builtin { .. }
        | Implementation::Rust(_)
        | Implementation::Asm { .. }
        | Implementation::Composite(_)
        | Implementation::Process { .. }
        | Implementation::Ros { .. }
        | Implementation::Orocos { .. } => None,
    }
}

/// Splits the address of a component of another robot, `robot://ROBOT/Component`.
///
/// # Errors
/// The reason that the text is no such address.
pub fn split_robot_component(address: &str) -> Result<(&str, &str), &'static str> {
    let Some(rest) = address.strip_prefix("robot://") else {
        return Err("does not begin with `robot://`");
    };
    match rest.split_once('/') {
        Some(("", _)) => Err("has no robot"),
        None | Some((_, "")) => Err("has no component"),
        Some((_, component)) if component.contains('.') => {
            Err("names a service; a wire with `binding = \"amqp\"` and this `url` calls it")
        }
        Some((robot, component)) => Ok((robot, component)),
    }
}

/// Returns the working directory of a program: relative to that of its composite, which is the default.
pub fn directory_of(written: Option<&str>, composite: &str) -> PathBuf {
    let beside = Path::new(composite).parent().unwrap_or(Path::new(""));
    let directory = beside.join(written.unwrap_or_default());
    // without the slash at the end that joining an empty path leaves
    directory.components().collect()
}

/// A catalogue together with the types and interfaces that programs of a composite declare, and those that folders of its
/// bridges define.
pub struct ExtendedCatalogue<'a> {
    base: &'a dyn Catalogue,
    /// Types of ROS with those of folders, of each bridge that names some.
    folders: Vec<Rc<dyn RosMessages>>,
    messages: BTreeMap<String, Schema>,
    interfaces: BTreeMap<String, Vec<OperationDeclaration>>,
}

impl<'a> ExtendedCatalogue<'a> {
    /// Adds the types and interfaces of folders and of declarations to a catalogue, which takes precedence.
    pub(crate) fn new<'d>(
        base: &'a dyn Catalogue,
        folders: Vec<Rc<dyn RosMessages>>,
        declarations: impl Iterator<Item = &'d ProgramDeclaration> + Clone,
    ) -> Self {
        let mut messages = BTreeMap::new();
        let mut interfaces: BTreeMap<String, Vec<OperationDeclaration>> = BTreeMap::new();
        for program in declarations.clone() {
            for (name, schema) in program.types() {
                messages
                    .entry(name.to_owned())
                    .or_insert_with(|| schema.clone());
            }
        }
        // all operations of a service are known to its provider, some to its callers
        let services = declarations.clone().flat_map(|it| &it.declaration.services);
        let services = services.map(|it| (&it.interface, &it.operations));
        let references = declarations.flat_map(|it| &it.declaration.references);
        let references = references.map(|it| (&it.interface, &it.operations));
        for (interface, operations) in services.chain(references) {
            let known = interfaces.entry(interface.clone()).or_default();
            for operation in operations {
                if !known.iter().any(|it| it.name == operation.name) {
                    known.push(OperationDeclaration {
                        while_stopped: false,
                        ..operation.clone()
                    });
                }
            }
        }
        Self {
            base,
            folders,
            messages,
            interfaces,
        }
    }
}

impl Catalogue for ExtendedCatalogue<'_> {
    fn components(&self) -> Vec<String> {
        self.base.components()
    }

    fn factory(&self, component: &str) -> Option<ComponentFactory> {
        self.base.factory(component)
    }

    fn declaration(&self, component: &str) -> Option<Arc<Declaration>> {
        self.base.declaration(component)
    }

    fn protocol(&self, component: &str) -> Option<String> {
        self.base.protocol(component)
    }

    fn has(&self, builtin: BuiltinComponent) -> bool {
        self.base.has(builtin)
    }

    fn ros(&self, kind: BridgeKind) -> Option<&dyn RosMessages> {
        self.base.ros(kind)
    }

    fn ros_with(
        &self,
        kind: BridgeKind,
        folders: &[PathBuf],
        loader: &dyn Loader,
    ) -> Option<RosFolders> {
        self.base.ros_with(kind, folders, loader)
    }

    fn way_to_bridges(&self, kind: BridgeKind) -> Option<String> {
        self.base.way_to_bridges(kind)
    }

    fn messages(&self) -> Vec<String> {
        let own = self.messages.keys().cloned();
        self.base.messages().into_iter().chain(own).collect()
    }

    fn schema(&self, message: &str) -> Option<Schema> {
        let own = || self.messages.get(message).cloned();
        let mut folders = self.folders.iter();
        let of_folders = || folders.find_map(|it| Some(it.find(message)?.schema));
        self.base.schema(message).or_else(of_folders).or_else(own)
    }

    fn interfaces(&self) -> Vec<String> {
        let own = self.interfaces.keys().cloned();
        self.base.interfaces().into_iter().chain(own).collect()
    }

    fn operations(&self, interface: &str) -> Option<Vec<OperationDeclaration>> {
        let own = || self.interfaces.get(interface).cloned();
        let mut folders = self.folders.iter();
        let of_folders = || folders.find_map(|it| it.operations()?.interface(interface));
        let of_build = self.base.operations(interface);
        of_build.or_else(of_folders).or_else(own)
    }
}
