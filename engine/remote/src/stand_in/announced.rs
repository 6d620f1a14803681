//! The announcement of a component by another robot, and its comparison with the one that a system was started with.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use asmotion_component::declaration::{Declaration, PortDeclaration};

use crate::error::RemoteError;
use crate::handle::RemoteComponent;
use crate::remote::Remote;

/// A component of another robot, as it was announced when the system was opened.
#[derive(Clone, Debug)]
pub struct RobotComponent {
    /// Name of the robot.
    pub robot: String,
    /// Name of the component within the robot.
    pub component: String,
    /// Its ports and services.
    pub declaration: Declaration,
    /// Names of the ports and services that the system uses.
    pub used: BTreeSet<String>,
}

impl RobotComponent {
    /// Compares the parts of the interface that the system uses with a new announcement.
    ///
    /// # Errors
    /// The first difference, in words.
    pub(super) fn check(&self, announced: &Declaration) -> Result<(), String> {
        let ports = [
            ("input", &self.declaration.inputs, &announced.inputs),
            ("output", &self.declaration.outputs, &announced.outputs),
        ];
        for (kind, expected, announced) in ports {
            for port in expected.iter().filter(|it| self.used.contains(&it.name)) {
                self.check_port(kind, port, announced)?;
            }
        }
        let services = &self.declaration.services;
        for service in services.iter().filter(|it| self.used.contains(&it.name)) {
            let known = announced.services.iter().find(|it| it.name == service.name);
            for operation in &service.operations {
                let known =
                    known.and_then(|it| it.operations.iter().find(|it| it.name == operation.name));
                let Some(known) = known else {
                    let name = format!("{}.{}", service.name, operation.name);
                    return Err(self.changed(&format!("no operation `{name}`")));
                };
                let request = operation.request.compare(&known.request);
                let response = operation.response.compare(&known.response);
                if let Err(difference) = request.and(response) {
                    let name = format!("{}.{}", service.name, operation.name);
                    return Err(self.changed(&format!(
                        "an operation `{name}` of another type: {difference}"
                    )));
                }
            }
        }
        Ok(())
    }

    fn check_port(
        &self,
        kind: &str,
        port: &PortDeclaration,
        announced: &[PortDeclaration],
    ) -> Result<(), String> {
        let name = &port.name;
        match announced.iter().find(|it| it.name == *name) {
            None => Err(self.changed(&format!("no {kind} `{name}`"))),
            Some(known) => port.schema.compare(&known.schema).map_err(|difference| {
                self.changed(&format!("an {kind} `{name}` of another type: {difference}"))
            }),
        }
    }

    fn changed(&self, what: &str) -> String {
        let Self {
            robot, component, ..
        } = self;
        format!(
            "OTHER_INTERFACE: `{component}` of robot `{robot}` has restarted with {what}; start this system again, so that it \
             adapts"
        )
    }
}

impl Remote {
    /// Waits until a robot announces a component, and returns its declaration. `waits` is called about every 0.2 s with the
    /// reason while the component is not there; `false` ends the wait.
    ///
    /// # Errors
    /// The reason that the declaration is unknown: the robot or component is not there, or there are several.
    pub fn announced_component(
        &self,
        robot: &str,
        component: &str,
        patience: Duration,
        mut waits: impl FnMut(&str) -> bool,
    ) -> Result<Declaration, String> {
        let until = Instant::now() + patience;
        loop {
            let components = self.components();
            let of_robot: Vec<&RemoteComponent> =
                components.iter().filter(|it| it.robot() == robot).collect();
            let found: Vec<_> = of_robot
                .iter()
                .filter(|it| it.name() == component)
                .collect();
            let reason = match found.as_slice() {
                [one] => match one.declaration() {
                    Ok(declaration) => return Ok(declaration),
                    Err(error @ RemoteError::Process { .. }) => error.to_string(),
                    Err(error) => return Err(error.to_string()),
                },
                [] => absent(robot, component, &components, &of_robot),
                several => {
                    let processes: Vec<String> = several
                        .iter()
                        .map(|it| format!("`{}`", it.process()))
                        .collect();
                    return Err(format!(
                        "the processes {} of robot `{robot}` all have a component `{component}`",
                        processes.join(" and ")
                    ));
                }
            };
            if Instant::now() >= until || !waits(&reason) {
                return Err(reason);
            }
            std::thread::sleep(Duration::from_millis(200));
        }
    }
}

/// The reason that a component is not found.
fn absent(
    robot: &str,
    component: &str,
    all: &[RemoteComponent],
    of_robot: &[&RemoteComponent],
) -> String {
    let list = |names: BTreeSet<&str>| {
        let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
        names.join(", ")
    };
    if !of_robot.is_empty() {
        let components = of_robot.iter().map(|it| it.name()).collect();
        return format!(
            "robot `{robot}` has no component `{component}`, only {}",
            list(components)
        );
    }
    let robots: BTreeSet<&str> = all.iter().map(|it| it.robot()).collect();
    if robots.is_empty() {
        return format!("robot `{robot}` is not on the broker, and no other one is");
    }
    format!(
        "robot `{robot}` is not on the broker, only {}",
        list(robots)
    )
}
