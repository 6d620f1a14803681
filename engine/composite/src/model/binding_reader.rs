//! Reads the parts of `bind.monitored` and `bind.out` that are not plain tables.

use asmotion_coordinator::Receive;
use serde_json::{Value as Json, json};

use super::binding::{Action, Argument, Call, Effect, Monitored, Out, Published};
use super::end_text;
use crate::at::At;
use crate::table::derived::{Keys, Reader};
use crate::table::{Key, Many, Outline, Table as _, Value, templates};
use crate::tree::{Branch, Entry, Node, Table};

/// Checks combinations of keys of a monitored function.
pub(crate) fn monitored(monitored: &mut Monitored, keys: &mut Keys<'_, '_, '_>) {
    keys.either("field", "map", "only one field can be the value");
    if monitored.on_stale.is_some() {
        keys.need("stale_ms", "300");
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
    let told = [&call.ok, &call.failed, &call.timeout, &call.unavailable];
    if told.iter().any(|literal| literal.is_some()) {
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
        Some(outline)
    }

    fn read(
        reader: &mut Reader<'_>,
        function: &At<String>,
        spec: &Key,
        node: &Node,
    ) -> Option<Self> {
        let Branch::Table(table) = &node.value else {
            let example = "{ topic = \"command\", publish = \"on_update\" }";
            reader.wrong_type(function, "a table", node, example);
            return None;
        };
        let effect = if is_publish(table) {
            Effect::Publish(Published::read(reader, function, spec, node)?)
        } else {
            let entries = table.entries.iter();
            let literals = entries.map(|it| (it.key.clone(), actions(reader, it, spec)));
            Effect::Literals(literals.collect())
        };
        let function = function.clone();
        Some(Self { function, effect })
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

/// Reads `"@name.field"`, a record of arguments or a plain value.
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
