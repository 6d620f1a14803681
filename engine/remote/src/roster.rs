//! Who is there: the processes that have been heard lately.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use asmotion_bus::Subscription;
use asmotion_diagnostics::similar;

use crate::error::RemoteError;
use crate::presence::{Presence, PresentComponent, RobotPresence};

/// A process speaks once a second; one that has been silent for so long is not counted.
const SILENT: Duration = Duration::from_millis(2500);

/// The topics of all words.
pub(crate) const WORDS: &str = "#.presence.*";

/// Who is there, by robot and process.
pub(crate) struct Roster {
    words: Subscription,
    known: BTreeMap<(String, String), (Instant, Presence)>,
}

/// A component and where it is.
#[derive(Clone)]
pub(crate) struct ComponentLocation {
    pub robot: String,
    pub process: String,
    pub present: PresentComponent,
}

impl ComponentLocation {
    /// Its name with its robot's before it.
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

    /// Takes in what has come; if nothing has, waits for it so long.
    pub(crate) fn listen(&mut self, at_most: Duration) {
        let mut next = (self.words.try_next()).or_else(|| self.words.next_within(at_most));
        while let Some(envelope) = next {
            if let Some(word) = RobotPresence::of(&envelope) {
                let process = (word.robot, word.presence.process.clone());
                match word.presence.leaves {
                    true => self.known.remove(&process),
                    false => self.known.insert(process, (Instant::now(), word.presence)),
                };
            }
            next = self.words.try_next();
        }
    }

    /// The processes of a robot, or all.
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

    /// The components of a robot, or all.
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

/// The component of a name; before it may stand its robot, `rover1.RoverDriver`.
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
