//! Bindings of all locations of a function: `"wants($r)" = { topic = "$r/wants" }` stands for one binding for each
//! element of the domain.
//!
//! A variable whose element a field of the message selects (`key`) is not expanded; its binding remains one.

use std::borrow::Cow;

use asmotion_coordinator::{LocationArgument, LocationName};

use crate::at::At;
use crate::model::binding::{
    Action, Argument, Bind, Call, Effect, Monitored, Out, Published, Source,
};
use crate::model::{End, MessagePath};
use crate::signature::{FunctionInfo, Signature};
use crate::table::NamedValue;
use crate::tree::{Branch, Entry, Node, Table};

/// Limit for the bindings that a single one stands for.
const MAX_EXPANDED: usize = 4096;

/// Replaces each binding with variables by one binding for each combination of elements.
///
/// A binding stays as it is if the domain of a variable has no elements that are known before the run; the check of
/// bindings reports the variables that remain.
pub(crate) fn expand<'b>(bind: &'b Bind, signature: Option<&dyn Signature>) -> Cow<'b, Bind> {
    let names = bind.monitored.iter().map(|it| &it.location);
    let mut names = names.chain(bind.out.iter().map(|it| &it.location));
    let Some(signature) = signature.filter(|_| names.any(|name| name.contains('$'))) else {
        return Cow::Borrowed(bind);
    };
    let monitored = bind.monitored.iter().flat_map(|it| {
        let elements = substitutions(&it.location, &it.key, signature);
        elements.into_iter().map(|elements| elements.monitored(it))
    });
    let out = bind.out.iter().flat_map(|it| {
        let elements = substitutions(&it.location, out_key(it), signature);
        elements.into_iter().map(|elements| elements.out(it))
    });
    Cow::Owned(Bind {
        monitored: monitored.collect(),
        out: out.collect(),
    })
}

/// Returns the key of a publication; empty for actions.
pub(crate) fn out_key(out: &Out) -> &[NamedValue<MessagePath>] {
    match &out.effect {
        Effect::Publish(published) => &published.key,
        Effect::Literals(_) => &[],
    }
}

/// Returns all locations that a name with variables stands for; `None` if the elements of a variable are not known
/// before the run.
pub(crate) fn locations(name: &LocationName, function: &FunctionInfo) -> Option<Vec<String>> {
    let variables = ranges(name, &[], function)?;
    let all = combinations(&variables)?;
    let located = all.iter().map(|elements| elements.text(&name.to_string()));
    Some(located.collect())
}

/// Returns the function that a location belongs to.
pub(crate) fn function_of<'s>(
    name: &LocationName,
    signature: &'s dyn Signature,
) -> Option<&'s FunctionInfo> {
    let mut functions = signature.functions().iter();
    let fits = |it: &&FunctionInfo| {
        it.name == name.function && it.parameters.len() == name.arguments.len()
    };
    let found = functions.find(fits);
    found.or_else(|| signature.function(&name.function))
}

/// Returns the combinations of elements that a location stands for; a single one without elements if it has no variables
/// or cannot be expanded.
fn substitutions(
    location: &At<String>,
    key: &[NamedValue<MessagePath>],
    signature: &dyn Signature,
) -> Vec<Substitution> {
    let name = LocationName::from(location.as_str());
    let function = function_of(&name, signature);
    let ranges = function.and_then(|function| ranges(&name, key, function));
    let all = ranges.and_then(|ranges| combinations(&ranges));
    let all = all.filter(|all| !all.is_empty());
    all.unwrap_or_else(|| vec![Substitution::default()])
}

/// Returns the variables that no key selects, each with the elements of its domain.
fn ranges(
    name: &LocationName,
    key: &[NamedValue<MessagePath>],
    function: &FunctionInfo,
) -> Option<Vec<(String, Vec<String>)>> {
    let mut ranges: Vec<(String, Vec<String>)> = Vec::new();
    for (argument, parameter) in name.arguments.iter().zip(&function.parameters) {
        let LocationArgument::Variable(variable) = argument else {
            continue;
        };
        let is_known = ranges.iter().any(|(known, _)| known == variable);
        if !is_known && !key.iter().any(|it| it.name.value == *variable) {
            ranges.push((variable.clone(), parameter.elements.clone()?));
        }
    }
    Some(ranges)
}

fn combinations(ranges: &[(String, Vec<String>)]) -> Option<Vec<Substitution>> {
    let mut all = vec![Substitution::default()];
    for (variable, elements) in ranges {
        if all.len().saturating_mul(elements.len()) > MAX_EXPANDED {
            return None;
        }
        let longer = |known: Substitution| {
            let extended = elements.iter();
            extended.map(move |element| known.with(variable, element))
        };
        all = all.into_iter().flat_map(longer).collect();
    }
    Some(all)
}

/// The element of each variable.
#[derive(Clone, Default)]
struct Substitution(Vec<(String, String)>);

impl Substitution {
    fn with(&self, variable: &str, element: &str) -> Self {
        let mut pairs = self.0.clone();
        pairs.push((variable.to_owned(), element.to_owned()));
        Self(pairs)
    }

    /// Replaces the variables in a text; `$$` and the names of other variables stay.
    fn text(&self, text: &str) -> String {
        let mut replaced = String::new();
        let mut rest = text;
        while let Some(dollar) = rest.find('$') {
            let (before, from) = rest.split_at(dollar);
            replaced.push_str(before);
            let behind = &from[1..];
            let is_name = |letter: char| letter.is_alphanumeric() || letter == '_';
            let end = behind
                .find(|letter| !is_name(letter))
                .unwrap_or(behind.len());
            let skipped = if behind.starts_with('$') { 1 } else { end };
            let known = self.0.iter().find(|(name, _)| *name == behind[..end]);
            match known {
                Some((_, element)) => replaced.push_str(element),
                None => replaced.push_str(&from[..1 + skipped]),
            }
            rest = &behind[skipped..];
        }
        replaced.push_str(rest);
        replaced
    }

    fn at(&self, text: &At<String>) -> At<String> {
        At::new(self.text(text), text.span)
    }

    fn maybe(&self, text: &Option<At<String>>) -> Option<At<String>> {
        text.as_ref().map(|text| self.at(text))
    }

    fn all(&self, texts: &[At<String>]) -> Vec<At<String>> {
        texts.iter().map(|text| self.at(text)).collect()
    }

    fn end(&self, end: &End) -> End {
        End {
            component: self.at(&end.component),
            name: self.at(&end.name),
        }
    }

    fn path(&self, path: &MessagePath) -> MessagePath {
        MessagePath {
            steps: self.all(&path.steps),
            span: path.span,
        }
    }

    fn key(&self, key: &[NamedValue<MessagePath>]) -> Vec<NamedValue<MessagePath>> {
        let fields = key.iter().map(|field| NamedValue {
            name: field.name.clone(),
            value: self.path(&field.value),
        });
        fields.collect()
    }

    fn node(&self, node: &Node) -> Node {
        let value = match &node.value {
            Branch::Text(text) => Branch::Text(self.text(text)),
            Branch::List(items) => Branch::List(items.iter().map(|item| self.node(item)).collect()),
            Branch::Table(table) => {
                let entries = table.entries.iter().map(|entry| Entry {
                    key: entry.key.clone(),
                    node: self.node(&entry.node),
                });
                let entries = entries.collect();
                Branch::Table(Table { entries })
            }
            Branch::Integer(_) | Branch::Float(_) | Branch::Boolean(_) | Branch::Date(_) => {
                node.value.clone()
            }
        };
        let span = node.span;
        Node { span, value }
    }

    fn monitored(&self, monitored: &Monitored) -> Monitored {
        let path = |path: &Option<MessagePath>| path.as_ref().map(|path| self.path(path));
        let node = |node: &Option<Node>| node.as_ref().map(|node| self.node(node));
        Monitored {
            location: self.at(&monitored.location),
            from: self.source(&monitored.from),
            receive: monitored.receive.clone(),
            edge: monitored.edge.clone(),
            field: path(&monitored.field),
            map: path(&monitored.map),
            key: self.key(&monitored.key),
            matching: self.matching(&monitored.matching),
            is: self.all(&monitored.is),
            none: node(&monitored.none),
            stale_ms: monitored.stale_ms.clone(),
            on_stale: node(&monitored.on_stale),
        }
    }

    fn source(&self, source: &Source) -> Source {
        match source {
            Source::Port(port) => Source::Port(self.at(port)),
            Source::Request(end) => Source::Request(self.end(end)),
            Source::Timer { running, ms } => Source::Timer {
                running: self.at(running),
                ms: ms.clone(),
            },
            Source::Losses(port) => Source::Losses(self.at(port)),
            Source::Value(node) => Source::Value(self.node(node)),
        }
    }

    fn matching(&self, matching: &[NamedValue<Argument>]) -> Vec<NamedValue<Argument>> {
        let matching = matching.iter().map(|field| NamedValue {
            name: self.at(&field.name),
            value: self.argument(&field.value),
        });
        matching.collect()
    }

    fn out(&self, out: &Out) -> Out {
        let effect = match &out.effect {
            Effect::Publish(published) => Effect::Publish(Published {
                port: self.at(&published.port),
                field: published.field.as_ref().map(|path| self.path(path)),
                key: self.key(&published.key),
                when: published.when.clone(),
            }),
            Effect::Literals(cases) => {
                let case = |(literal, actions): &(At<String>, Vec<Action>)| {
                    let actions = actions.iter().map(|action| self.action(action));
                    (self.at(literal), actions.collect())
                };
                Effect::Literals(cases.iter().map(case).collect())
            }
        };
        let location = self.at(&out.location);
        Out { location, effect }
    }

    fn action(&self, action: &Action) -> Action {
        match action {
            Action::Call(call) => Action::Call(Box::new(self.call(call))),
            Action::Publish { port, value } => Action::Publish {
                port: self.at(port),
                value: self.argument(value),
            },
            Action::Cancel(cancel) => Action::Cancel(cancel.clone()),
        }
    }

    fn call(&self, call: &Call) -> Call {
        let faults = call.faults.iter().map(|fault| NamedValue {
            name: fault.name.clone(),
            value: self.at(&fault.value),
        });
        Call {
            operation: self.end(&call.operation),
            with: call.with.as_ref().map(|with| self.argument(with)),
            keep: self.maybe(&call.keep),
            ok: self.maybe(&call.ok),
            failed: self.maybe(&call.failed),
            faults: faults.collect(),
            timeout: self.maybe(&call.timeout),
            unavailable: self.maybe(&call.unavailable),
            event: self.maybe(&call.event),
            reply: self.maybe(&call.reply),
        }
    }

    fn argument(&self, argument: &Argument) -> Argument {
        match argument {
            Argument::Kept { name, path } => Argument::Kept {
                name: self.at(name),
                path: self.all(path),
            },
            Argument::Record(span, fields) => {
                let fields = fields.iter();
                let fields = fields.map(|(name, field)| (name.clone(), self.argument(field)));
                Argument::Record(*span, fields.collect())
            }
            Argument::Term(term) => Argument::Term(self.at(term)),
            Argument::Value(node) => Argument::Value(self.node(node)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Substitution;

    #[test]
    fn it_replaces_whole_names_of_its_variables() {
        let elements = Substitution::default().with("r", "ROB1").with("z", "3");
        let cases = [
            ("$r/wants", "ROB1/wants"),
            ("at($r, $z)", "at(ROB1, 3)"),
            ("$$r costs $", "$$r costs $"),
            ("${properties.r} $room $r", "${properties.r} $room ROB1"),
        ];
        for (text, replaced) in cases {
            assert_eq!(elements.text(text), replaced);
        }
    }
}
