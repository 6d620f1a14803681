//! What is known of a running system: who is there, what goes over the topics, and how old each piece of it is.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use asmotion_bus::{Envelope, Link};
use asmotion_datum::{Datum, DatumError};
use asmotion_remote::{Presence, Present, Word};

/// A process speaks once a second; one that has been silent for so long may be gone.
const SILENT: Duration = Duration::from_millis(2500);
/// A topic that has been silent for less is not stale, however fast it was.
const PATIENCE: Duration = Duration::from_secs(1);
/// A topic that has been silent for so many of its gaps is stale.
const GAPS: u32 = 4;
/// Over how many messages a rate is measured.
const WINDOW: usize = 32;

/// What is known. Times are since the monitor began.
#[derive(Clone, Default)]
pub struct Board {
    processes: BTreeMap<(String, String), Process>,
    topics: BTreeMap<String, Topic>,
    /// How the broker is, and since when; unknown at first.
    pub link: Option<(Link, Duration)>,
}

/// A process, as it last spoke.
#[derive(Clone)]
struct Process {
    presence: Presence,
    heard: Duration,
}

/// What is known of a topic.
#[derive(Clone)]
pub struct Topic {
    /// Its key.
    pub name: String,
    /// The type of its messages.
    pub kind: String,
    /// Who sent the last one.
    pub source: String,
    /// The last one, or why it cannot be read.
    pub last: Result<Datum, DatumError>,
    /// How many came.
    pub count: u64,
    /// When the last ones came, oldest first.
    arrivals: VecDeque<Duration>,
}

/// A component and where it is.
pub struct Component<'b> {
    /// The robot, empty if it has no name.
    pub robot: &'b str,
    /// The process.
    pub process: &'b str,
    /// What it last said of itself.
    pub present: &'b Present,
    /// How long its process has been silent, if it is for too long; or that it said its last word.
    pub silence: Option<Silence>,
}

/// Why what is shown may not be so any more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Silence {
    /// Nothing was heard for so long.
    Stale(Duration),
    /// It has ended.
    Left,
}

impl Board {
    /// Takes in a message.
    pub fn hear(&mut self, envelope: &Envelope, now: Duration) {
        if is_presence(&envelope.topic) {
            // what is not ours is none of ours
            if let Some(word) = Word::of(envelope) {
                self.meet(word, now);
            }
            return;
        }
        let content = envelope.payload.to_datum();
        let name = envelope.topic.to_string();
        let topic = self.topics.entry(name).or_insert_with_key(|name| Topic {
            name: name.clone(),
            kind: String::new(),
            source: String::new(),
            last: Ok(Datum::Null),
            count: 0,
            arrivals: VecDeque::new(),
        });
        topic.kind = envelope.type_name.to_string();
        topic.source = envelope.source.to_string();
        topic.last = content;
        topic.count += 1;
        if topic.arrivals.len() == WINDOW {
            topic.arrivals.pop_front();
        }
        topic.arrivals.push_back(now);
    }

    fn meet(&mut self, word: Word, now: Duration) {
        let Word {
            robot,
            mut presence,
        } = word;
        let key = (robot, presence.process.clone());
        if let (true, Some(known)) = (presence.leaves, self.processes.get(&key)) {
            // the last word need not repeat what was there
            presence.components.clone_from(&known.presence.components);
        }
        let heard = now;
        self.processes.insert(key, Process { presence, heard });
    }

    /// Takes in how the broker is.
    pub fn feel(&mut self, link: Link, now: Duration) {
        if self.link.as_ref().is_none_or(|(known, _)| *known != link) {
            self.link = Some((link, now));
        }
    }

    /// How many processes there are.
    pub fn processes(&self) -> usize {
        let there = |process: &&Process| !process.presence.leaves;
        self.processes.values().filter(there).count()
    }

    /// All components, by robot and process, in the order of their composites.
    pub fn components(&self, now: Duration) -> impl Iterator<Item = Component<'_>> {
        self.processes
            .iter()
            .flat_map(move |((robot, name), process)| {
                let silence = process.silence(now);
                let components = process.presence.components.iter();
                components.map(move |present| Component {
                    robot,
                    process: name,
                    present,
                    silence,
                })
            })
    }

    /// All topics, by name.
    pub fn topics(&self) -> impl Iterator<Item = &Topic> {
        self.topics.values()
    }
}

fn is_presence(topic: &str) -> bool {
    let mut words = topic.rsplit('.');
    words.next().is_some() && words.next() == Some("presence")
}

impl Process {
    fn silence(&self, now: Duration) -> Option<Silence> {
        let silent = now.saturating_sub(self.heard);
        match self.presence.leaves {
            true => Some(Silence::Left),
            false => (silent > SILENT).then_some(Silence::Stale(silent)),
        }
    }
}

impl Topic {
    /// Messages a second, of the last ones; none before there are two.
    pub fn rate(&self) -> Option<f64> {
        let gap = self.gap()?.as_secs_f64();
        (gap > 0.0).then(|| 1.0 / gap)
    }

    /// How long ago the last message came.
    pub fn age(&self, now: Duration) -> Duration {
        let last = self.arrivals.back().copied().unwrap_or_default();
        now.saturating_sub(last)
    }

    /// Whether messages came again and again, and come no more.
    pub fn is_stale(&self, now: Duration) -> bool {
        let age = self.age(now);
        let usual = self.gap().map(|gap| gap * GAPS);
        usual.is_some_and(|usual| age > usual.max(PATIENCE))
    }

    fn gap(&self) -> Option<Duration> {
        let (first, last) = (self.arrivals.front()?, self.arrivals.back()?);
        let gaps = u32::try_from(self.arrivals.len() - 1).ok()?;
        last.saturating_sub(*first).checked_div(gaps)
    }
}
