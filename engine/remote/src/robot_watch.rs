//! Compares the services of other robots that a process calls with the presence of these robots' processes.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_bus::{Bus, BusError, RobotAddress, Subscription};
use asmotion_component::{suggestion, suggestion_among};
use asmotion_network::{AnnouncedOperation, AnnouncedService, RobotService};

use crate::presence::{Presence, PresentComponent, PresentService, RobotPresence, presence_topic};
use crate::remote::listen;

/// The services of other robots that a process calls, and the presence of these robots.
#[derive(Default)]
pub(crate) struct RobotWatch {
    robots: Vec<WatchedRobot>,
}

/// A robot, and its services that the process calls.
struct WatchedRobot {
    presences: Subscription,
    services: Vec<WatchedService>,
    /// Names of the components and of the promoted services of each process that runs.
    processes: BTreeMap<String, AnnouncedNames>,
    /// Time of the first announcement of a process.
    heard_at: Option<Instant>,
}

/// A service of a robot that the process calls.
struct WatchedService {
    service: Arc<RobotService>,
    /// It has been reported that no process of the robot has the component.
    is_reported: bool,
}

/// What the name of a service can begin with.
#[derive(Default)]
struct AnnouncedNames {
    components: Vec<String>,
    promoted: Vec<String>,
}

/// Time after the first announcement of a robot within which all its running processes have announced themselves.
const ANNOUNCED: Duration = Duration::from_millis(1500);

impl RobotWatch {
    /// Adds services, and subscribes to the presence of the robots that provide them.
    pub(crate) fn add(
        &mut self,
        bus: &dyn Bus,
        services: Vec<Arc<RobotService>>,
    ) -> Result<(), BusError> {
        for service in services {
            let mut robots = self.robots.iter_mut();
            let known = robots.find(|it| it.services[0].service.robot() == service.robot());
            let watched = WatchedService {
                service: Arc::clone(&service),
                is_reported: false,
            };
            if let Some(robot) = known {
                robot.services.push(watched);
            } else {
                let all = presence_topic("*");
                let pattern = RobotAddress::new(service.robot(), &all).to_string();
                self.robots.push(WatchedRobot {
                    presences: listen(bus, &pattern)?,
                    services: vec![watched],
                    processes: BTreeMap::new(),
                    heard_at: None,
                });
            }
            service.expect_announcement();
        }
        Ok(())
    }

    /// Removes the services that nothing calls any more, and the robots that provide no other.
    pub(crate) fn forget_uncalled(&mut self) {
        for robot in &mut self.robots {
            let services = &mut robot.services;
            services.retain(|it| Arc::strong_count(&it.service) > 1);
        }
        self.robots.retain(|robot| !robot.services.is_empty());
    }

    /// Compares the services with the presences that have arrived. Calls of services whose presence is overdue no longer wait
    /// for it. Returns what is wrong with a service that no process of a running robot has, once.
    pub(crate) fn process(&mut self) -> Vec<String> {
        let mut problems = Vec::new();
        for robot in &mut self.robots {
            while let Some(envelope) = robot.presences.try_next() {
                let Some(RobotPresence { presence, .. }) = RobotPresence::of(&envelope) else {
                    continue;
                };
                for WatchedService { service, .. } in &robot.services {
                    compare(service, &presence);
                }
                robot.note(&presence);
            }
            robot.services.iter().for_each(|it| it.service.end_wait());
            problems.extend(robot.absent_services());
        }
        problems
    }
}

impl WatchedRobot {
    /// Notes the names that a process announces.
    fn note(&mut self, presence: &Presence) {
        if presence.leaves {
            self.processes.remove(&presence.process);
            return;
        }
        self.heard_at.get_or_insert_with(Instant::now);
        let components = presence.components.iter();
        let promoted = presence.promoted.iter();
        let names = AnnouncedNames {
            components: components.map(|it| it.name.clone()).collect(),
            promoted: promoted.map(|it| it.from.clone()).collect(),
        };
        self.processes.insert(presence.process.clone(), names);
    }

    /// Returns what is wrong with the services whose component no process of the robot has, each once.
    fn absent_services(&mut self) -> Vec<String> {
        let is_complete = self.heard_at.is_some_and(|at| at.elapsed() >= ANNOUNCED);
        if !is_complete || self.processes.is_empty() {
            return Vec::new();
        }
        let processes = &self.processes;
        let unreported = self.services.iter_mut().filter(|it| !it.is_reported);
        let absent = unreported.filter_map(|it| {
            let problem = absence(&it.service, processes)?;
            it.is_reported = true;
            Some(problem)
        });
        absent.collect()
    }
}

/// Returns what is wrong with a service if no process of its robot has the component, or promotes it; `None` otherwise.
fn absence(service: &RobotService, processes: &BTreeMap<String, AnnouncedNames>) -> Option<String> {
    let name = service.name();
    let promoted = || processes.values().flat_map(|it| it.promoted.iter());
    if promoted().any(|it| it == name) {
        return None;
    }
    let (what, wanted, known): (_, _, Vec<&String>) = match name.split_once('.') {
        Some((component, _)) => {
            let components = processes.values().flat_map(|it| it.components.iter());
            ("component", component, components.collect())
        }
        None => ("promoted service", name, promoted().collect()),
    };
    if known.iter().any(|it| *it == wanted) {
        return None;
    }
    let (robot, reference) = (service.robot(), service.reference());
    let running: Vec<_> = processes.keys().map(String::as_str).collect();
    let nearest = suggestion_among(wanted, known.into_iter().map(String::as_str));
    let nearest = suggestion(nearest.as_deref());
    Some(format!(
        "`{reference}` calls `robot://{robot}/{name}`: robot `{robot}` runs (`{}`), but has no {what} `{wanted}`{nearest}",
        running.join("`, `")
    ))
}

/// Compares a service with the presence of a process, if its component runs there.
fn compare(service: &RobotService, presence: &Presence) {
    let mut promoted = presence.promoted.iter();
    let promoted = promoted.find(|it| it.from == service.name());
    let inside = promoted.map_or(service.name(), |it| &it.to);
    let Some((component, name)) = provider(presence, inside) else {
        if let Some(address) = address_of_id(presence, inside) {
            service.set_named_by_id(&address);
        }
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

/// Returns the `Component.service` of a service whose component is named by its `id`.
fn address_of_id(presence: &Presence, service: &str) -> Option<String> {
    let has_id = |it: &&PresentComponent| {
        let rest = service.strip_prefix(&it.id);
        !it.id.is_empty() && rest.is_some_and(|rest| rest.starts_with('.'))
    };
    let component = presence.components.iter().find(has_id)?;
    Some(format!(
        "{}{}",
        component.name,
        &service[component.id.len()..]
    ))
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
