//! Model of a running system: components, topics, and the age of each fact.

use std::borrow::Cow;
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use asmotion_bus::{Envelope, LinkState};
use asmotion_datum::{Datum, DatumError};
use asmotion_remote::{Presence, PresentComponent, RobotPresence};

/// Silence after which a process, which sends once a second, is shown as stale.
const SILENT: Duration = Duration::from_millis(2500);
/// Minimum silence after which a topic is stale, whatever its rate.
const PATIENCE: Duration = Duration::from_secs(1);
/// Number of message intervals after which a silent topic is stale.
const GAPS: u32 = 4;
/// Number of messages over which a rate is measured.
const WINDOW: usize = 32;

/// The model. Times are measured from the start of the monitor.
#[derive(Clone, Default)]
pub struct Board {
    processes: BTreeMap<(String, String), BoardProcess>,
    topics: BTreeMap<String, BoardTopic>,
    /// State of the broker link and time of its last change; unknown at first.
    pub link: Option<(LinkState, Duration)>,
}

/// A process according to its last presence message.
#[derive(Clone)]
struct BoardProcess {
    presence: Presence,
    received_at: Duration,
}

/// Known facts about a topic.
#[derive(Clone)]
pub struct BoardTopic {
    /// Routing key.
    pub name: String,
    /// Message type.
    pub kind: String,
    /// Sender of the last message.
    pub source: String,
    /// Last message, or the reason that it cannot be decoded.
    pub last: Result<Datum, DatumError>,
    /// Number of received messages.
    pub count: u64,
    /// The last messages, oldest first.
    arrivals: VecDeque<Arrival>,
}

/// The arrival of a message.
#[derive(Clone, Copy)]
struct Arrival {
    /// Time of the monitor.
    at: Duration,
    /// Time of sending in nanoseconds of the sender's clock, which is virtual in a simulation.
    stamp_ns: i64,
}

/// A component with its robot and process.
pub struct BoardComponent<'b> {
    /// Name of the robot; can be empty.
    pub robot: &'b str,
    /// Name of the process, as announced on the bus.
    pub process: &'b str,
    /// Description of the component last received from the process.
    pub present: Cow<'b, PresentComponent>,
    /// Set if its process has been silent for too long or has ended.
    pub silence: Option<Silence>,
}

/// Reason why displayed facts can be outdated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Silence {
    /// No message for this time.
    Stale(Duration),
    /// The process has ended.
    Left,
}

impl Board {
    /// Processes a message that is read now. It may be older: where the terminal takes no output, messages wait.
    pub fn receive(&mut self, envelope: &Envelope, now: Duration) {
        let now = now.saturating_sub(envelope.age);
        if is_presence(&envelope.topic) {
            // other programs can publish on the same exchange
            if let Some(presence) = RobotPresence::of(envelope) {
                self.update_process(presence, now);
            }
            return;
        }
        let content = envelope.payload.to_datum();
        let name = envelope.topic.to_string();
        let topic = self
            .topics
            .entry(name)
            .or_insert_with_key(|name| BoardTopic {
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
        topic.arrivals.push_back(Arrival {
            at: now,
            stamp_ns: envelope.stamp,
        });
    }

    fn update_process(&mut self, presence: RobotPresence, now: Duration) {
        let RobotPresence {
            robot,
            mut presence,
        } = presence;
        let key = (robot, presence.process.clone());
        if presence.leaves
            && presence.components.is_empty()
            && let Some(known) = self.processes.get(&key)
        {
            // the last message of a process need not list its components
            presence.components.clone_from(&known.presence.components);
        }
        let received_at = now;
        self.processes.insert(
            key,
            BoardProcess {
                presence,
                received_at,
            },
        );
    }

    /// Records the state of the broker link.
    pub fn set_link(&mut self, link: LinkState, now: Duration) {
        if self.link.as_ref().is_none_or(|(known, _)| *known != link) {
            self.link = Some((link, now));
        }
    }

    /// Number of processes.
    pub fn processes(&self) -> usize {
        let is_present = |process: &&BoardProcess| !process.presence.leaves;
        self.processes.values().filter(is_present).count()
    }

    /// All components by robot and process, in the order of their composites.
    pub fn components(&self, now: Duration) -> impl Iterator<Item = BoardComponent<'_>> {
        self.processes
            .iter()
            .flat_map(move |((robot, name), process)| {
                let silence = process.silence(now);
                let components = process.presence.components.iter();
                components.map(move |present| BoardComponent {
                    robot,
                    process: name,
                    present: Cow::Borrowed(present),
                    silence,
                })
            })
    }

    /// All topics by name.
    pub fn topics(&self) -> impl Iterator<Item = &BoardTopic> {
        self.topics.values()
    }
}

fn is_presence(topic: &str) -> bool {
    let mut segments = topic.rsplit('.');
    segments.next().is_some() && segments.next() == Some("presence")
}

impl BoardProcess {
    fn silence(&self, now: Duration) -> Option<Silence> {
        let silent = now.saturating_sub(self.received_at);
        if self.presence.leaves {
            Some(Silence::Left)
        } else {
            (silent > SILENT).then_some(Silence::Stale(silent))
        }
    }
}

impl BoardTopic {
    /// Messages per second of the sender's clock over the last messages, or of the monitor's clock if the sender gives no
    /// times; `None` before the second message.
    pub fn rate(&self) -> Option<f64> {
        let gap = self.sending_gap().or_else(|| self.gap())?.as_secs_f64();
        (gap > 0.0).then(|| 1.0 / gap)
    }

    /// Mean interval between the times of sending; `None` if they do not increase.
    fn sending_gap(&self) -> Option<Duration> {
        let (first, last) = (self.arrivals.front()?, self.arrivals.back()?);
        let span = u64::try_from(last.stamp_ns.checked_sub(first.stamp_ns)?).ok()?;
        let is_ordered = self.arrivals.iter().is_sorted_by_key(|it| it.stamp_ns);
        let gaps = self.arrivals.len() as u64 - 1;
        let gap = span.checked_div(gaps).filter(|_| is_ordered)?;
        (gap > 0).then(|| Duration::from_nanos(gap))
    }

    /// Time since the last message.
    pub fn age(&self, now: Duration) -> Duration {
        let last = self.arrivals.back().map(|last| last.at);
        now.saturating_sub(last.unwrap_or_default())
    }

    /// Returns `true` if a topic with regular messages has fallen silent.
    pub fn is_stale(&self, now: Duration) -> bool {
        let age = self.age(now);
        let usual = self.gap().map(|gap| gap * GAPS);
        usual.is_some_and(|usual| age > usual.max(PATIENCE))
    }

    fn gap(&self) -> Option<Duration> {
        let (first, last) = (self.arrivals.front()?, self.arrivals.back()?);
        let gaps = u32::try_from(self.arrivals.len() - 1).ok()?;
        last.at.saturating_sub(first.at).checked_div(gaps)
    }
}
