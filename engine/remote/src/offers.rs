//! Finds services by their interface, on the bus.

use asmotion_diagnostics::similar;

use crate::error::RemoteError;
use crate::levels::after_component;
use crate::presence::{PresentComponent, key, operations};
use crate::remote::Remote;
use crate::roster::ComponentLocation;

/// A service that a component of a running system provides.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FoundService {
    /// Name of the robot; empty if it has none.
    pub robot: String,
    /// Name of the process.
    pub process: String,
    /// Name of the component.
    pub component: String,
    /// State of the component, for example `Running`.
    pub state: String,
    /// Name of the service within the component.
    pub service: String,
    /// Name of its interface.
    pub interface: String,
}

impl FoundService {
    /// The address on the bus, which an operation's address begins with: `navigation.MapServer.maps`.
    pub fn address(&self) -> String {
        key(&self.robot, &format!("{}.{}", self.component, self.service))
    }
}

impl Remote {
    /// All services with this interface, in the order of robots and processes. The first call waits as
    /// [`processes`](Self::processes) does.
    pub fn services(&self, interface: &str) -> Vec<FoundService> {
        let mut found = self.all_services();
        found.retain(|it| it.interface == interface);
        found
    }

    /// Finds the service with this interface, for example `nav/PlanService`. The first call waits as
    /// [`processes`](Self::processes) does, since there may be two.
    ///
    /// # Errors
    /// An error if no service has the interface, or if several have it.
    pub fn service(&self, interface: &str) -> Result<FoundService, RemoteError> {
        let all = self.all_services();
        let mut found: Vec<_> = all.iter().filter(|it| it.interface == interface).collect();
        match (found.pop(), found.is_empty()) {
            (Some(one), true) => Ok(one.clone()),
            (None, _) => Err(RemoteError::Unknown {
                what: "interface",
                name: interface.to_owned(),
                nearest: similar(interface, all.iter().map(|it| &it.interface)).cloned(),
            }),
            (Some(last), false) => {
                found.push(last);
                Err(RemoteError::Several {
                    name: interface.to_owned(),
                    candidates: found.iter().map(|it| it.address()).collect(),
                })
            }
        }
    }

    /// The address of an operation given by its interface, `nav/PlanService.plan`; an address is returned as it is.
    ///
    /// # Errors
    /// An error if the operation is given by an interface that no service or several services have.
    pub fn operation_address(&self, operation: &str) -> Result<String, RemoteError> {
        let Some((interface, name)) = operation.rsplit_once('.') else {
            return Ok(operation.to_owned());
        };
        // the name of a nested component contains a slash, too
        if !interface.contains('/') || interface.contains('.') {
            return Ok(operation.to_owned());
        }
        match self.service(interface) {
            Ok(service) => Ok(format!("{}.{name}", service.address())),
            Err(RemoteError::Unknown { .. }) if self.is_nested(interface) => {
                Ok(operation.to_owned())
            }
            Err(error) => Err(error),
        }
    }

    /// Returns whether a name begins with that of a composite with components.
    fn is_nested(&self, name: &str) -> bool {
        let components = self.complete_roster().components(self.robot());
        let composite = |name: &str| {
            name.split_once('/')
                .map(|(composite, _)| composite.to_owned())
        };
        let own = composite(name);
        own.is_some()
            && components
                .iter()
                .any(|it| composite(&it.present.name) == own)
    }

    /// The address of an operation given without its robot, `MapServer.maps.getMap` or `maps.getMap` by the name under which the
    /// service is promoted, or without its service, `MapServer.getMap`; `None` if no component has this operation. The levels of a nested component may be separated by dots, as in
    /// `Arm.Driver.getJoints` for `Arm/Driver.state.getJoints`.
    ///
    /// # Errors
    /// An error with the addresses of the candidates if there are several.
    pub fn short_operation_address(&self, operation: &str) -> Result<Option<String>, RemoteError> {
        let components = self.complete_roster().components(self.robot());
        let mut found: Vec<String> = components
            .iter()
            .flat_map(|component| operations_named(component, operation))
            .collect();
        for presence in self.processes() {
            let promoted = operations(&presence)
                .into_iter()
                .filter(|it| it.is_promoted);
            let named = promoted.filter(|it| it.name == operation);
            found.extend(named.map(|it| presence.key(&it.name)));
        }
        found.sort();
        found.dedup();
        if found.len() > 1 {
            return Err(RemoteError::Several {
                name: operation.to_owned(),
                candidates: found,
            });
        }
        Ok(found.pop())
    }

    fn all_services(&self) -> Vec<FoundService> {
        let components = self.complete_roster().components(self.robot());
        components.into_iter().flat_map(services_of).collect()
    }
}

/// The addresses of a component's operations that a name means, which begins with the name or the `id` of the component.
fn operations_named(at: &ComponentLocation, name: &str) -> Vec<String> {
    let PresentComponent { name: own, id, .. } = &at.present;
    let names = [own, id]
        .into_iter()
        .flat_map(|it| [it.clone(), key(&at.robot, it)]);
    let rest = names
        .filter(|it| !it.is_empty())
        .find_map(|it| Some(after_component(name, &it)?.strip_prefix('.')?.to_owned()));
    let Some(rest) = rest else {
        return Vec::new();
    };
    let mut addresses = Vec::new();
    for service in &at.present.services {
        for operation in &service.operations {
            let path = format!("{}.{}", service.name, operation.name);
            if rest == path || rest == operation.name {
                addresses.push(format!("{}.{path}", at.full_name()));
            }
        }
    }
    addresses
}

fn services_of(at: ComponentLocation) -> impl Iterator<Item = FoundService> {
    let ComponentLocation {
        robot,
        process,
        present,
    } = at;
    let (component, state) = (present.name, present.state);
    present
        .services
        .into_iter()
        .map(move |service| FoundService {
            robot: robot.clone(),
            process: process.clone(),
            component: component.clone(),
            state: state.clone(),
            service: service.name,
            interface: service.interface,
        })
}
