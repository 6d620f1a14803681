//! Compares the services of other robots that a process calls with the presence of these robots' processes.

use std::sync::Arc;

use asmotion_bus::{Bus, BusError, RobotAddress, Subscription};
use asmotion_network::{AnnouncedOperation, AnnouncedService, RobotService};

use crate::presence::{Presence, PresentComponent, PresentService, RobotPresence, presence_topic};
use crate::remote::listen;

/// The services of other robots that a process calls, and the presence of these robots.
pub(crate) struct RobotWatch {
    robots: Vec<WatchedRobot>,
}

/// A robot, and its services that the process calls.
struct WatchedRobot {
    presences: Subscription,
    services: Vec<Arc<RobotService>>,
}

impl RobotWatch {
    /// Subscribes to the presence of the robots that provide the services.
    pub(crate) fn new(bus: &dyn Bus, services: Vec<Arc<RobotService>>) -> Result<Self, BusError> {
        let mut robots: Vec<WatchedRobot> = Vec::new();
        for service in services {
            service.expect_announcement();
            let is_its = |it: &&mut WatchedRobot| it.services[0].robot() == service.robot();
            match robots.iter_mut().find(is_its) {
                Some(robot) => robot.services.push(service),
                None => {
                    let all = presence_topic("*");
                    let pattern = RobotAddress::new(service.robot(), &all).to_string();
                    robots.push(WatchedRobot {
                        presences: listen(bus, &pattern)?,
                        services: vec![service],
                    });
                }
            }
        }
        Ok(Self { robots })
    }

    /// Compares the services with the presences that have arrived. Calls of services whose presence is overdue no longer wait
    /// for it.
    pub(crate) fn process(&self) {
        for robot in &self.robots {
            while let Some(envelope) = robot.presences.try_next() {
                let Some(RobotPresence { presence, .. }) = RobotPresence::of(&envelope) else {
                    continue;
                };
                for service in &robot.services {
                    compare(service, &presence);
                }
            }
            robot.services.iter().for_each(|it| it.end_wait());
        }
    }
}

/// Compares a service with the presence of a process, if its component runs there.
fn compare(service: &RobotService, presence: &Presence) {
    let mut promoted = presence.promoted.iter();
    let promoted = promoted.find(|it| it.from == service.name());
    let inside = promoted.map_or(service.name(), |it| &it.to);
    let Some((component, name)) = provider(presence, inside) else {
        return;
    };
    if presence.leaves {
        return service.forget();
    }
    match component.services.iter().find(|it| it.name == name) {
        Some(announced) => compare_operations(service, announced),
        None => {
            let known = component.services.iter().map(|it| it.name.clone());
            service.set_missing(&known.collect::<Vec<_>>());
        }
    }
}

/// Returns the component of a `Component.service`, and the name of the service.
fn provider<'p>(
    presence: &'p Presence,
    service: &'p str,
) -> Option<(&'p PresentComponent, &'p str)> {
    let (component, name) = service.split_once('.')?;
    let mut components = presence.components.iter();
    Some((components.find(|it| it.name == component)?, name))
}

fn compare_operations(service: &RobotService, announced: &PresentService) {
    let operations = announced.operations.iter();
    let operations: Vec<AnnouncedOperation<'_>> = operations
        .map(|it| AnnouncedOperation {
            name: &it.name,
            request: &it.request,
            response: &it.response,
        })
        .collect();
    service.compare(&AnnouncedService {
        interface: &announced.interface,
        operations: &operations,
    });
}
