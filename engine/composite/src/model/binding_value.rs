//! Reads, resolves and writes the parts of `bind.monitored` and `bind.out` that are not plain tables.

use asmotion_coordinator::{self as coordinator, Case, Constant, Receive};
use asmotion_datum::Datum;
use serde_json::{Value as Json, json};
use toml_edit::Value as Toml;

use super::binding::{Action, Argument, Call, Effect, Monitored, Out, Published, Source};
use super::component::MessagePath;
use super::end_text;
use crate::at::At;
use crate::table::derived::{Keys, Reader};
use crate::table::{
    Key, Lines, Many, Outline, Resolve, Resolver, Table as _, Value, Written, named, present,
    templates,
};
use crate::tree::{Branch, Entry, Node, Table};

/// Checks combinations of keys of a monitored function.
pub(crate) fn monitored(monitored: &mut Monitored, keys: &mut Keys<'_, '_, '_>) {
    keys.either("field", "map", "only one field can be the value");
    if monitored.on_stale.is_some() {
        keys.need("stale_ms", "300");
    }
    let source = match &monitored.from {
        Source::Timer { running, .. } => Some(("timer", running.span)),
        Source::Losses(port) => Some(("lost", port.span)),
        Source::Value(node) => Some(("value", node.span)),
        Source::Port(_) | Source::Request(_) => None,
    };
    if let Some(source) = source {
        let path = |path: &Option<MessagePath>| path.as_ref().map(|path| path.span);
        // expanded composites contain the default
        let receive = monitored.receive.as_ref();
        let receive = receive.filter(|it| it.value != Receive::default());
        let of_messages = [
            ("receive", receive.map(|it| it.span)),
            ("edge", monitored.edge.as_ref().map(|it| it.span)),
            ("field", path(&monitored.field)),
            ("map", path(&monitored.map)),
            ("key", monitored.key.first().map(|it| it.name.span)),
            ("where", monitored.matching.first().map(|it| it.name.span)),
            ("is", monitored.is.first().map(|it| it.span)),
            ("none", monitored.none.as_ref().map(|it| it.span)),
            ("stale_ms", monitored.stale_ms.as_ref().map(|it| it.span)),
        ];
        for (name, at) in of_messages {
            if let Some(at) = at {
                keys.excluded((name, at), source, "it concerns messages");
            }
        }
    }
    // `edge = true` is short for `receive = "edge"`
    let Some(edge) = monitored.edge.as_ref().filter(|edge| edge.value) else {
        return;
    };
    if let Some(receive) = &monitored.receive
        && receive.value != Receive::Edge
    {
        let (first, second) = (("receive", receive.span), ("edge", edge.span));
        let reason = "an edge is true in the step in which a message arrives";
        keys.excluded(first, second, reason);
    }
    monitored.receive = Some(At::new(Receive::Edge, edge.span));
}

/// Checks that a call with outcome literals names the function that receives them.
pub(crate) fn call(call: &mut Call, keys: &mut Keys<'_, '_, '_>) {
    if call.literals().next().is_some() {
        keys.need("event", "\"ev\"");
    }
}

/// Reads `{ topic, publish }` or a table of literals.
impl Value for Out {
    const MANY: Many = Many::Names;

    fn schema(_: &Key) -> Json {
        let action = Action::outline().schema();
        let actions = json!({ "anyOf": [action, { "type": "array", "items": action }] });
        let literals = json!({ "type": "object", "additionalProperties": actions });
        json!({ "anyOf": [literals, Published::outline().schema()] })
    }

    fn table(_: &Key) -> Option<Outline> {
        let mut outline = Published::outline();
        outline.append(Action::outline());
        outline.one_of.insert(0, "topic");
        outline.has_names = true;
        Some(outline)
    }

    fn read(
        reader: &mut Reader<'_>,
        location: &At<String>,
        spec: &Key,
        node: &Node,
    ) -> Option<Self> {
        let Branch::Table(table) = &node.value else {
            let example = "{ topic = \"command\", publish = \"on_update\" }";
            reader.wrong_type(location, "a table", node, example);
            return None;
        };
        let effect = if is_publish(table) {
            Effect::Publish(Published::read(reader, location, spec, node)?)
        } else {
            let entries = table.entries.iter();
            let literals = entries.map(|it| (it.key.clone(), actions(reader, it, spec)));
            Effect::Literals(literals.collect())
        };
        let location = location.clone();
        Some(Self { location, effect })
    }
}

fn actions(reader: &mut Reader<'_>, entry: &Entry, spec: &Key) -> Vec<Action> {
    let items = if let Branch::List(items) = &entry.node.value {
        items.as_slice()
    } else {
        std::slice::from_ref(&entry.node)
    };
    let read = items.iter();
    read.filter_map(|item| Action::read(reader, &entry.key, spec, item))
        .collect()
}

/// Returns whether the table is the short form: literals have tables as values, the keys of the short form have
/// scalars.
fn is_publish(table: &Table) -> bool {
    let entry = table.get("topic").or(table.get("publish"));
    entry.is_some_and(|entry| match entry.node.value {
        Branch::Text(_) | Branch::Integer(_) | Branch::Float(_) | Branch::Boolean(_) => true,
        Branch::Date(_) | Branch::List(_) | Branch::Table(_) => false,
    })
}

impl Resolve for Out {
    type Resolved = coordinator::Out;

    fn resolve(&self, key: &Key, to: &mut Resolver<'_>) -> Option<coordinator::Out> {
        let case = |(literal, actions): &(At<String>, Vec<Action>)| Case {
            literal: literal.value.clone(),
            actions: actions
                .iter()
                .filter_map(|action| action.resolve(key, to))
                .collect(),
        };
        let effect = match &self.effect {
            Effect::Literals(cases) => {
                coordinator::Effect::Literals(cases.iter().map(case).collect())
            }
            Effect::Publish(published) => coordinator::Effect::Publish(published.resolve(key, to)?),
        };
        let location = self.location.value.as_str().into();
        Some(coordinator::Out { location, effect })
    }
}

impl Written for coordinator::Out {
    fn toml(&self) -> Option<Toml> {
        match &self.effect {
            coordinator::Effect::Publish(published) => published.toml(),
            coordinator::Effect::Literals(cases) => {
                let mut keys = Lines::new();
                for case in cases {
                    let actions = match case.actions.as_slice() {
                        [only] => present(only),
                        several => Toml::Array(several.iter().map(present).collect()),
                    };
                    keys.put_some(&case.literal, Some(actions));
                }
                keys.inline()
            }
        }
    }

    fn list(items: &[Self]) -> Option<Toml> {
        named(items.iter().map(|out| (&out.location, out)))
    }
}

/// Reads `"@name.field"`, `"@(term)"`, a record of arguments or a plain value.
impl Value for Argument {
    fn schema(_: &Key) -> Json {
        json!({})
    }

    #[expect(
        clippy::only_used_in_recursion,
        reason = "of the trait; arguments need no more than their node"
    )]
    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        Some(match &node.value {
            Branch::Text(text) if text.starts_with("@@") => {
                let plain = Branch::Text(text[1..].to_owned());
                Self::Value(Node {
                    span: node.span,
                    value: plain,
                })
            }
            Branch::Text(text) if text.starts_with("@(") && text.ends_with(')') => {
                let inner = 2..text.len() - 1;
                let whole = At::new(text.clone(), node.span);
                let span = reader.part(&whole, inner.clone());
                Self::Term(At::new(text[inner].to_owned(), span))
            }
            Branch::Text(text) if text.starts_with('@') => {
                let whole = At::new(text.clone(), node.span);
                let name = At::new(text[1..].to_owned(), reader.part(&whole, 1..text.len()));
                match end_text::path(reader, &name) {
                    Some(mut path) => {
                        let name = path.steps.remove(0);
                        let path = path.steps;
                        Self::Kept { name, path }
                    }
                    None => Self::Value(node.clone()),
                }
            }
            Branch::Table(table) => {
                let fields = table.entries.iter().filter_map(|entry| {
                    let value = Self::read(reader, &entry.key, spec, &entry.node)?;
                    Some((entry.key.clone(), value))
                });
                Self::Record(node.span, fields.collect())
            }
            Branch::Text(_)
            | Branch::Integer(_)
            | Branch::Float(_)
            | Branch::Boolean(_)
            | Branch::Date(_)
            | Branch::List(_) => {
                templates(reader, key, node);
                Self::Value(node.clone())
            }
        })
    }
}

/// An unknown value, which has been reported, is an empty record.
impl Resolve for Argument {
    type Resolved = coordinator::Argument;

    fn resolve(&self, key: &Key, to: &mut Resolver<'_>) -> Option<coordinator::Argument> {
        use coordinator::Argument as Resolved;
        Some(match self {
            Self::Kept { name, path } => {
                let steps: Vec<&str> = path.iter().map(|step| step.value.as_str()).collect();
                Resolved::Kept {
                    name: name.value.clone(),
                    path: (!steps.is_empty()).then(|| steps.join(".")),
                }
            }
            Self::Record(_, fields) => {
                let mut record = Vec::new();
                for (name, field) in fields {
                    record.push((name.value.clone(), field.resolve(key, to)?));
                }
                Resolved::Record(record)
            }
            Self::Term(term) => Resolved::Term(term.value.clone()),
            Self::Value(node) => {
                let value = node.resolve(key, to);
                value.map_or_else(Resolved::default, |value| Resolved::Value(value.into()))
            }
        })
    }
}

/// Omits an empty record, which is the default.
impl Written for coordinator::Argument {
    fn toml(&self) -> Option<Toml> {
        match self {
            Self::Kept { name, path: None } => Some(format!("@{name}").into()),
            Self::Kept {
                name,
                path: Some(path),
            } => Some(format!("@{name}.{path}").into()),
            Self::Record(fields) => fields.toml(),
            Self::Term(term) => Some(format!("@({term})").into()),
            // a leading `@` denotes a kept reply unless it is doubled
            Self::Value(Constant {
                datum: Datum::Text(text),
                secret: false,
            }) if text.starts_with('@') => Some(format!("@{text}").into()),
            Self::Value(constant) => constant.toml(),
        }
    }
}
