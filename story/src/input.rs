//! The inputs of specifications in a composite, and their messages worth reporting.

use std::collections::BTreeMap;

use asmotion_coordinator::{Monitored, Receive, Source};
use asmotion_datum::Sample;
use asmotion_plan::{End, Plan, Terminal};

use crate::message;

/// An input of a specification to which a monitored function is bound.
#[derive(Debug)]
pub(super) struct StoryInput {
    /// Full name of the input, `Component.port`.
    port: String,
    /// Displayed name: the topic or, without one, the port.
    pub(super) name: String,
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

/// The inputs of all specifications, found by what they receive: a system can have thousands.
#[derive(Debug, Default)]
pub(super) struct StoryInputs {
    /// An input with several readers is listed once.
    all: Vec<StoryInput>,
    /// Positions by full name.
    by_port: BTreeMap<String, usize>,
    /// Positions by topic, ascending.
    by_topic: BTreeMap<String, Vec<usize>>,
    /// Positions by the full name of an output that is connected directly, ascending.
    by_writer: BTreeMap<String, Vec<usize>>,
}

/// Origins of the messages of inputs, by their ends.
struct InputOrigins<'p> {
    topics: BTreeMap<(&'p str, &'p str), &'p str>,
    writers: BTreeMap<(&'p str, &'p str), Vec<&'p End>>,
}

impl<'p> InputOrigins<'p> {
    fn of(plan: &'p Plan) -> Self {
        let mut origins = Self {
            topics: BTreeMap::new(),
            writers: BTreeMap::new(),
        };
        for topic in &plan.topics {
            for end in &topic.subscribers {
                let key = (end.component.as_str(), end.name.as_str());
                origins.topics.entry(key).or_insert(&topic.name);
            }
        }
        for connection in &plan.connections {
            if let (Terminal::Port(from), Terminal::Port(to)) = (&connection.from, &connection.to) {
                let key = (to.component.as_str(), to.name.as_str());
                origins.writers.entry(key).or_default().push(from);
            }
        }
        origins
    }
}

impl StoryInputs {
    /// The inputs of a plan.
    pub(super) fn of(plan: &Plan) -> Self {
        let origins = InputOrigins::of(plan);
        let mut inputs = Self::default();
        for component in &plan.components {
            let bound = component.binding.iter().flat_map(|it| &it.monitored);
            for monitored in bound {
                if let Source::Port(port) = &monitored.from {
                    inputs.add(&component.name, port, monitored, &origins);
                }
            }
        }
        inputs
    }

    fn add(
        &mut self,
        component: &str,
        port: &str,
        monitored: &Monitored,
        origins: &InputOrigins<'_>,
    ) {
        let full_name = format!("{component}.{port}");
        if self.by_port.contains_key(&full_name) {
            return;
        }
        let position = self.all.len();
        let topic = origins.topics.get(&(component, port)).copied();
        if let Some(topic) = topic {
            let readers = self.by_topic.entry(topic.to_owned()).or_default();
            readers.push(position);
        }
        for writer in origins
            .writers
            .get(&(component, port))
            .into_iter()
            .flatten()
        {
            let writer = format!("{}.{}", writer.component, writer.name);
            self.by_writer.entry(writer).or_default().push(position);
        }
        self.by_port.insert(full_name.clone(), position);
        self.all.push(StoryInput {
            port: full_name,
            name: topic.unwrap_or(port).to_owned(),
            field: monitored.map.clone(),
            receives: match monitored.receive {
                Receive::Last => StoryTrigger::State(None),
                Receive::All | Receive::Edge => StoryTrigger::Events,
            },
        });
    }

    /// The inputs whose messages are events: a summary mentions no others.
    pub(super) fn events(self) -> Self {
        let Self {
            all,
            mut by_port,
            mut by_topic,
            mut by_writer,
        } = self;
        let is_event = |position: &usize| all.get(*position).is_some_and(|it| !it.is_state());
        by_port.retain(|_, position| is_event(position));
        for by in [&mut by_topic, &mut by_writer] {
            by.retain(|_, positions| {
                positions.retain(is_event);
                !positions.is_empty()
            });
        }
        Self {
            all,
            by_port,
            by_topic,
            by_writer,
        }
    }

    /// Continues with the last reported messages of the same inputs of the previous version.
    pub(super) fn continue_from(&mut self, known: &Self) {
        for input in &mut self.all {
            let known = known.by_port.get(&input.port).and_then(|it| known.get(*it));
            if let (StoryTrigger::State(last), Some(StoryTrigger::State(reported))) =
                (&mut input.receives, known.map(|it| &it.receives))
            {
                last.clone_from(reported);
            }
        }
    }

    /// Positions of the inputs that are connected to this output, directly or through a topic, ascending.
    pub(super) fn of_output(&self, component: &str, port: &str, topic: Option<&str>) -> Vec<usize> {
        let on_topic = topic.and_then(|topic| self.by_topic.get(topic));
        let mut found = on_topic.cloned().unwrap_or_default();
        if !self.by_writer.is_empty()
            && let Some(direct) = self.by_writer.get(&format!("{component}.{port}"))
        {
            found.extend(direct);
            found.sort_unstable();
            found.dedup();
        }
        found
    }

    /// Positions of the inputs with this full name or topic, ascending.
    pub(super) fn of_place(&self, place: &str) -> Vec<usize> {
        let mut found = self.by_topic.get(place).cloned().unwrap_or_default();
        found.extend(self.by_port.get(place));
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The input at this position.
    pub(super) fn get(&self, position: usize) -> Option<&StoryInput> {
        self.all.get(position)
    }

    /// The input at this position.
    pub(super) fn get_mut(&mut self, position: usize) -> Option<&mut StoryInput> {
        self.all.get_mut(position)
    }
}

impl StoryInput {
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

    /// The name and the content of a message, if it is worth reporting.
    pub(super) fn describe(&mut self, sample: &dyn Sample) -> Option<(String, Option<String>)> {
        let what = message::brief(sample);
        if let StoryTrigger::State(last) = &mut self.receives {
            if last.is_some() && *last == what {
                return None;
            }
            last.clone_from(&what);
        }
        Some((self.name_of(sample), what))
    }

    /// The name under which a message is counted.
    pub(super) fn name_of(&self, sample: &dyn Sample) -> String {
        let kind = self
            .field
            .as_ref()
            .and_then(|field| message::field(sample, field));
        match kind {
            Some(kind) => format!("{} {kind}", self.name),
            None => self.name.clone(),
        }
    }
}
