//! The roster: the processes that have recently published their presence.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use asmotion_bus::Subscription;
use asmotion_diagnostics::similar;

use crate::error::RemoteError;
use crate::presence::{Presence, PresentComponent, RobotPresence};

/// Time after which a silent process counts as gone. Processes publish their presence once a second.
const SILENT: Duration = Duration::from_millis(2500);

/// Pattern of all presence topics.
pub(crate) const WORDS: &str = "#.presence.*";

/// The processes on the bus, by robot and name.
pub(crate) struct Roster {
    words: Subscription,
    known: BTreeMap<(String, String), (Instant, Presence)>,
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
    pub(crate) fn whole(&self) -> String {
        crate::presence::key(&self.robot, &self.present.name)
    }
}

impl Roster {
    pub(crate) fn new(words: Subscription) -> Self {
        Self {
            words,
            known: BTreeMap::new(),
        }
    }

    /// Reads all waiting messages; if there are none, waits up to `at_most` for one.
    pub(crate) fn listen(&mut self, at_most: Duration) {
        let mut next = self
            .words
            .try_next()
            .or_else(|| self.words.next_within(at_most));
        while let Some(envelope) = next {
            if let Some(word) = RobotPresence::of(&envelope) {
                let process = (word.robot, word.presence.process.clone());
                if word.presence.leaves {
                    self.known.remove(&process)
                } else {
                    self.known.insert(process, (Instant::now(), word.presence))
                };
            }
            next = self.words.try_next();
        }
    }

    /// The processes of a robot, or of all robots.
    pub(crate) fn words(&self, robot: Option<&str>) -> Vec<RobotPresence> {
        let here = self.known.iter().filter(|((of, _), (heard, _))| {
            heard.elapsed() < SILENT && robot.is_none_or(|robot| robot == of)
        });
        let word = |((robot, _), (_, presence)): (&(String, String), &(Instant, Presence))| {
            RobotPresence {
                robot: robot.clone(),
                presence: presence.clone(),
            }
        };
        here.map(word).collect()
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
        self.words(robot).into_iter().flat_map(of).collect()
    }
}

/// The component with this name, optionally with its robot: `rover1.RoverDriver`.
pub(crate) fn named(
    name: &str,
    all: &[ComponentLocation],
) -> Result<ComponentLocation, RemoteError> {
    let is_it = |it: &&ComponentLocation| it.present.name == name || it.whole() == name;
    let named: Vec<&ComponentLocation> = all.iter().filter(is_it).collect();
    match named.as_slice() {
        [one] => Ok((*one).clone()),
        [] => Err(RemoteError::Unknown {
            what: "component",
            name: name.to_owned(),
            nearest: similar(name, all.iter().map(|it| &it.present.name)).cloned(),
        }),
        several => Err(RemoteError::Several {
            name: name.to_owned(),
            candidates: several.iter().map(|it| it.whole()).collect(),
        }),
    }
}
