//! The inputs of specifications in a composite, and their messages worth reporting.

use asmotion_coordinator::{Receive, Source};
use asmotion_datum::Sample;
use asmotion_plan::{Component, End, Plan, Terminal};

use super::message;

/// An input of a specification to which a monitored function is bound.
#[derive(Debug)]
pub(super) struct StoryInput {
    /// Full name of the input, `Component.port`.
    port: String,
    /// Displayed name: the topic or, without one, the port.
    pub(super) name: String,
    topic: Option<String>,
    /// Outputs that are connected directly: component, port.
    writers: Vec<(String, String)>,
    /// The field that distinguishes messages, if there is one.
    field: Option<String>,
    receives: StoryTrigger,
}

/// The messages of an input that are worth reporting.
#[derive(Debug)]
enum StoryTrigger {
    /// Events: every message.
    Events,
    /// A state: messages that differ from the last reported one, which is stored here.
    State(Option<String>),
}

/// The inputs of all specifications; an input with several readers is listed once.
pub(super) fn of(plan: &Plan) -> Vec<StoryInput> {
    let mut inputs: Vec<StoryInput> = Vec::new();
    for component in &plan.components {
        let bound = component.binding.iter().flat_map(|it| &it.monitored);
        for monitored in bound {
            let Source::Port(port) = &monitored.from else {
                continue;
            };
            let input = StoryInput {
                field: monitored.map.clone(),
                receives: match monitored.receive {
                    Receive::Last => StoryTrigger::State(None),
                    Receive::All | Receive::Edge => StoryTrigger::Events,
                },
                ..StoryInput::at(plan, component, port)
            };
            if !inputs.iter().any(|existing| existing.port == input.port) {
                inputs.push(input);
            }
        }
    }
    inputs
}

impl StoryInput {
    /// Continues with the last reported message of the same input among those of the previous version.
    pub(super) fn continue_from(&mut self, known: &[Self]) {
        let known = known.iter().find(|known| known.port == self.port);
        if let (StoryTrigger::State(last), Some(StoryTrigger::State(reported))) =
            (&mut self.receives, known.map(|it| &it.receives))
        {
            last.clone_from(reported);
        }
    }

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
            port: format!("{}.{port}", component.name),
            name: topic.clone().unwrap_or_else(|| port.to_owned()),
            topic,
            writers: joined.collect(),
            field: None,
            receives: StoryTrigger::Events,
        }
    }

    /// Name of the component.
    pub(super) fn component(&self) -> &str {
        self.port
            .rsplit_once('.')
            .map_or("", |(component, _)| component)
    }

    /// Returns whether the messages are a state, of which only the newest is relevant.
    pub(super) fn is_state(&self) -> bool {
        matches!(self.receives, StoryTrigger::State(_))
    }

    /// Returns whether the input is connected to this output, directly or through a topic.
    pub(super) fn receives(&self, component: &str, port: &str, topic: Option<&str>) -> bool {
        let is = |(writer, output): &(String, String)| writer == component && output == port;
        (topic.is_some() && self.topic.as_deref() == topic) || self.writers.iter().any(is)
    }

    /// Returns whether this is the input with the given name or topic.
    pub(super) fn is_port(&self, port: &str) -> bool {
        self.port == port || self.topic.as_deref() == Some(port)
    }

    /// The name and the content of a message, if it is worth reporting.
    pub(super) fn describe(&mut self, sample: &dyn Sample) -> Option<(String, Option<String>)> {
        let what = message::brief(sample);
        if let StoryTrigger::State(last) = &mut self.receives {
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
