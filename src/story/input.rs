//! What the specifications of a composite hear: the messages that are worth telling.

use asmotion_coordinator::{Receive, Source};
use asmotion_datum::Sample;
use asmotion_plan::{Component, End, Plan, Terminal};

use super::message;

/// An input of a specification that a monitored function is bound to.
#[derive(Debug)]
pub(super) struct StoryInput {
    /// The input, `Component.port`.
    place: String,
    /// What it is called: its topic, or its port.
    pub(super) name: String,
    topic: Option<String>,
    /// Who is joined to it directly: component, port.
    writers: Vec<(String, String)>,
    /// The field that tells messages apart, where it does.
    field: Option<String>,
    hears: StoryTrigger,
}

/// What an ear hears.
#[derive(Debug)]
enum StoryTrigger {
    /// Events, each of which is news.
    Events,
    /// A state, which is news when it changes, and its last word.
    State(Option<String>),
}

/// The ears of all specifications; what several hear is told once.
pub(super) fn of(plan: &Plan) -> Vec<StoryInput> {
    let mut ears: Vec<StoryInput> = Vec::new();
    for component in &plan.components {
        let bound = component.binding.iter().flat_map(|it| &it.monitored);
        for monitored in bound {
            let Source::Port(port) = &monitored.from else {
                continue;
            };
            let ear = StoryInput {
                field: monitored.map.clone(),
                hears: match monitored.receive {
                    Receive::Last => StoryTrigger::State(None),
                    Receive::All | Receive::Edge => StoryTrigger::Events,
                },
                ..StoryInput::at(plan, component, port)
            };
            if !ears.iter().any(|known| known.place == ear.place) {
                ears.push(ear);
            }
        }
    }
    ears
}

impl StoryInput {
    fn at(plan: &Plan, component: &Component, port: &str) -> Self {
        let end = |end: &End| end.component == component.name && end.name == port;
        let mut topics = plan.topics.iter();
        let topic = topics.find(|topic| topic.subscribers.iter().any(end));
        let topic = topic.map(|topic| topic.name.clone());
        let joined = plan.connections.iter().filter_map(|it| {
            let (Terminal::Port(from), Terminal::Port(to)) = (&it.from, &it.to) else {
                return None;
            };
            end(to).then(|| (from.component.clone(), from.name.clone()))
        });
        Self {
            place: format!("{}.{port}", component.name),
            name: topic.clone().unwrap_or_else(|| port.to_owned()),
            topic,
            writers: joined.collect(),
            field: None,
            hears: StoryTrigger::Events,
        }
    }

    /// Whether what it hears is a state, of which the last word counts.
    pub(super) fn is_state(&self) -> bool {
        matches!(self.hears, StoryTrigger::State(_))
    }

    /// Whether it hears what leaves this port.
    pub(super) fn hears(&self, component: &str, port: &str, topic: Option<&str>) -> bool {
        let is = |(writer, output): &(String, String)| writer == component && output == port;
        (topic.is_some() && self.topic.as_deref() == topic) || self.writers.iter().any(is)
    }

    /// Whether it hears what comes in there.
    pub(super) fn is_at(&self, place: &str) -> bool {
        self.place == place || self.topic.as_deref() == Some(place)
    }

    /// What a message is called and says, if it is news.
    pub(super) fn news(&mut self, sample: &dyn Sample) -> Option<(String, Option<String>)> {
        let what = message::brief(sample);
        if let StoryTrigger::State(last) = &mut self.hears {
            if last.is_some() && *last == what {
                return None;
            }
            last.clone_from(&what);
        }
        let kind = self
            .field
            .as_ref()
            .and_then(|field| message::field(sample, field));
        let name = match kind {
            Some(kind) => format!("{} {kind}", self.name),
            None => self.name.clone(),
        };
        Some((name, what))
    }
}
