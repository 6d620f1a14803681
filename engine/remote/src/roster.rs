//! The roster: the processes that have recently published their presence.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use asmotion_bus::Subscription;
use asmotion_diagnostics::similar;

use crate::error::RemoteError;
use crate::presence::{Presence, PresentComponent, RobotPresence};

/// Time after which a silent process counts as gone. Processes publish their presence once a second.
pub(crate) const SILENT: Duration = Duration::from_millis(2500);

/// Pattern of all presence topics.
pub(crate) const WORDS: &str = "#.presence.*";

/// The processes on the bus, by robot and name.
pub(crate) struct Roster {
    presences: Subscription,
    processes: BTreeMap<(String, String), (Instant, Presence)>,
}

/// A component, with its robot and process.
#[derive(Clone)]
pub(crate) struct ComponentLocation {
    pub robot: String,
    pub process: String,
    pub present: PresentComponent,
}

impl ComponentLocation {
    /// Name with the robot's name as a prefix.
    pub(crate) fn full_name(&self) -> String {
        crate::presence::key(&self.robot, &self.present.name)
    }
}

impl Roster {
    pub(crate) fn new(presences: Subscription) -> Self {
        Self {
            presences,
            processes: BTreeMap::new(),
        }
    }

    /// Reads all waiting messages; if there are none, waits up to `timeout` for one.
    pub(crate) fn listen(&mut self, timeout: Duration) {
        let mut next = self
            .presences
            .try_next()
            .or_else(|| self.presences.next_within(timeout));
        while let Some(envelope) = next {
            if let Some(presence) = RobotPresence::of(&envelope) {
                let process = (presence.robot, presence.presence.process.clone());
                if presence.presence.leaves {
                    self.processes.remove(&process)
                } else {
                    self.processes
                        .insert(process, (Instant::now(), presence.presence))
                };
            }
            next = self.presences.try_next();
        }
    }

    /// The processes of a robot, or of all robots.
    pub(crate) fn presences(&self, robot: Option<&str>) -> Vec<RobotPresence> {
        let of_robot = self.processes.iter().filter(|((of, _), (heard, _))| {
            heard.elapsed() < SILENT && robot.is_none_or(|robot| robot == of)
        });
        let robot_presence =
            |((robot, _), (_, presence)): (&(String, String), &(Instant, Presence))| {
                RobotPresence {
                    robot: robot.clone(),
                    presence: presence.clone(),
                }
            };
        of_robot.map(robot_presence).collect()
    }

    /// The components of a robot, or of all robots.
    pub(crate) fn components(&self, robot: Option<&str>) -> Vec<ComponentLocation> {
        let of = |RobotPresence { robot, presence }: RobotPresence| {
            let process = presence.process;
            let components = presence.components.into_iter();
            components.map(move |present| ComponentLocation {
                robot: robot.clone(),
                process: process.clone(),
                present,
            })
        };
        self.presences(robot).into_iter().flat_map(of).collect()
    }
}

/// The component with this name, optionally with its robot: `rover1.RoverDriver`; otherwise the one with this `id`.
pub(crate) fn find_component(
    name: &str,
    all: &[ComponentLocation],
) -> Result<ComponentLocation, RemoteError> {
    let is_it = |it: &&ComponentLocation| it.present.name == name || it.full_name() == name;
    let mut matches: Vec<&ComponentLocation> = all.iter().filter(is_it).collect();
    if matches.is_empty() {
        let has_id = |it: &&ComponentLocation| {
            it.present.id == name || crate::presence::key(&it.robot, &it.present.id) == name
        };
        matches = all.iter().filter(has_id).collect();
    }
    match matches.as_slice() {
        [one] => Ok((*one).clone()),
        [] => Err(RemoteError::Unknown {
            what: "component",
            name: name.to_owned(),
            nearest: similar(name, all.iter().map(|it| &it.present.name)).cloned(),
        }),
        several => Err(RemoteError::Several {
            name: name.to_owned(),
            candidates: several.iter().map(|it| it.full_name()).collect(),
        }),
    }
}
