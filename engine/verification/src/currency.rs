//! Messages that belong to the last one that the verified specification has published: `where` in a binding, and echoes in
//! protocols.

use crate::actor::{Actor, ActorInput, word};
use crate::rename::label;
use asmotion_coordinator::Argument;
use asmotion_coordinator::Receive;

/// A port of the verified specification whose messages others repeat.
#[derive(Clone, Debug, PartialEq)]
struct TrackedPort {
    port: String,
    /// Path of the field that is repeated.
    path: String,
}

/// An input of another component that repeats fields of messages.
#[derive(Clone, Debug, PartialEq)]
struct TrackedInput {
    component: String,
    input: String,
}

/// The messages whose origin is tracked.
#[derive(Clone, Debug, Default)]
pub(crate) struct Currency {
    ports: Vec<TrackedPort>,
    inputs: Vec<TrackedInput>,
}

/// A condition on a message.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MessageCondition {
    pub term: Option<String>,
    /// `true` if the message may be refused for reasons that are not known.
    pub is_uncertain: bool,
}

impl Currency {
    /// Determines what is tracked: the ports named in `where`, and all inputs that others repeat.
    pub fn of(actors: &[Actor]) -> Self {
        let mut found = Self::default();
        let first = actors.iter().take(1).flat_map(|it| &it.inputs);
        for (_, argument) in first.flat_map(|it| &it.matching) {
            if let Argument::Kept { name, path } = argument {
                let tracked = TrackedPort {
                    port: name.clone(),
                    path: path.clone().unwrap_or_default(),
                };
                if !found.ports.contains(&tracked) {
                    found.ports.push(tracked);
                }
            }
        }
        if found.ports.is_empty() {
            return found;
        }
        for actor in actors.iter().skip(1) {
            for echo in &actor.echoes {
                let tracked = TrackedInput {
                    component: actor.component.clone(),
                    input: echo.input.clone(),
                };
                if !found.inputs.contains(&tracked) {
                    found.inputs.push(tracked);
                }
            }
        }
        found
    }

    /// The functions that the environment needs.
    pub fn flags(&self) -> Vec<String> {
        let flags = self.ports.iter().flat_map(|port| {
            let inputs = self.inputs.iter();
            inputs.map(|input| flag(port, &input.component, &input.input))
        });
        flags.collect()
    }

    /// Rules for a new message on a port: those before it do not count any more.
    pub fn forget(&self, port: &str, actor: &Actor) -> Vec<String> {
        let ports = self.ports.iter().filter(|it| it.port == port);
        let mut rules: Vec<String> = ports
            .flat_map(|port| {
                let inputs = self.inputs.iter();
                inputs
                    .map(|input| format!("{} := false", flag(port, &input.component, &input.input)))
            })
            .collect();
        let refers = |argument: &Argument| match argument {
            Argument::Kept { name, .. } => name == port,
            Argument::Record(_) | Argument::Value(_) | Argument::Term(_) => false,
        };
        let inputs = actor.inputs.iter().filter(|it| it.receive == Receive::All);
        let waiting = inputs.filter(|it| it.matching.iter().any(|(_, value)| refers(value)));
        rules.extend(waiting.map(|it| format!("waiting_{} := []", word(actor, it))));
        rules
    }

    /// Rules for a message that reaches an input.
    pub fn pass_on(
        &self,
        from: &Actor,
        at: usize,
        output: &str,
        to: &Actor,
        input: &str,
    ) -> Vec<String> {
        let is_tracked = |it: &&TrackedInput| it.component == to.component && it.input == input;
        let Some(tracked) = self.inputs.iter().find(is_tracked) else {
            return Vec::new();
        };
        let rules = self.ports.iter().map(|port| {
            let flag_of = |component: &str, input: &str| flag(port, component, input);
            let target = flag_of(&tracked.component, &tracked.input);
            if at == 0 {
                return format!("{target} := {}", port.port == output);
            }
            let echo = from
                .echoes
                .iter()
                .find(|it| it.output == output && it.field == port.path);
            match echo {
                Some(echo) => format!("{target} := {}", flag_of(&from.component, &echo.input)),
                None => format!("choose $belongs in Boolean do {target} := $belongs"),
            }
        });
        rules.collect()
    }

    /// The condition under which an input accepts a message.
    pub fn condition(
        &self,
        to: usize,
        input: &ActorInput,
        from: Option<(&Actor, &str)>,
    ) -> MessageCondition {
        let mut condition = MessageCondition::default();
        if to > 0 {
            condition.is_uncertain = !input.matching.is_empty();
            return condition;
        }
        let mut terms = Vec::new();
        for (field, argument) in &input.matching {
            let term = match (argument, from) {
                (Argument::Kept { name, path }, Some((actor, output))) => {
                    let path = path.clone().unwrap_or_default();
                    let mut echoes = actor.echoes.iter();
                    let echo = echoes.find(|it| {
                        it.output == output && it.field == *field && it.input_field == path
                    });
                    let port = self
                        .ports
                        .iter()
                        .find(|it| it.port == *name && it.path == path);
                    echo.zip(port)
                        .map(|(echo, port)| flag(port, &actor.component, &echo.input))
                }
                (_, _) => None,
            };
            match term {
                Some(term) => terms.push(term),
                None => condition.is_uncertain = true,
            }
        }
        condition.term = (!terms.is_empty()).then(|| terms.join(" and "));
        condition
    }
}

fn flag(port: &TrackedPort, component: &str, input: &str) -> String {
    let path = label(&port.path);
    format!(
        "current_{}_{path}_{}_{}",
        label(&port.port),
        label(component),
        label(input)
    )
}
