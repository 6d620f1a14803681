//! Several elements from one: `for = "$r in 1..20"` in a component, a connection, a wire, … stands for one element for each value
//! of `$r`, which is substituted in its names and strings.

mod properties;
mod range;

use std::collections::{BTreeMap, BTreeSet};

use asmotion_diagnostics::{Report, Span};

pub(crate) use self::properties::RangeProperties;
use self::range::{ElementInstance, NodePattern, instances};
use crate::at::At;
use crate::codes::c009::{InvalidName, UnknownVariable};
use crate::codes::c210::InvalidInstances;
use crate::finding::Findings;
use crate::table::{Many, Outline};
use crate::tree::{Branch, Entry, Node, Table};

/// The key that asks for instances.
const FOR: &str = "for";

/// Replaces the elements of a table that have the key `for` by their instances. An element whose instances cannot be determined is
/// reported and left out. `properties` are the values that a range can contain.
pub(crate) fn expand(
    table: &mut Table,
    outline: &Outline,
    properties: &RangeProperties,
    report: &mut Report,
) -> ExpandedElements {
    let mut expansion = Expansion {
        elements: ExpandedElements::default(),
        properties,
        report,
    };
    expansion.table(table, outline);
    expansion.elements
}

/// The elements that have been replaced by their instances.
#[derive(Default)]
pub(crate) struct ExpandedElements {
    /// Their places, each from the name to the last value, with the variables of the `for`, without `$`.
    pub places: Vec<(Span, Vec<String>)>,
    /// The properties on which the number of instances depends.
    pub properties: BTreeSet<String>,
}

struct Expansion<'r> {
    elements: ExpandedElements,
    properties: &'r RangeProperties,
    report: &'r mut Report,
}

impl Expansion<'_> {
    fn table(&mut self, table: &mut Table, outline: &Outline) {
        for Entry { key, node } in &mut table.entries {
            let mut keys = outline.keys.iter().map(|(key, _)| *key);
            let Some(known) = keys.find(|known| known.name == key.value) else {
                continue;
            };
            let Some(inner) = (known.table)(known) else {
                continue;
            };
            let has_instances = inner.keys.iter().any(|(key, _)| key.name == FOR);
            match (&mut node.value, known.many) {
                (Branch::Table(table), None) => self.table(table, &inner),
                (Branch::Table(named), Some(Many::Names)) if has_instances => self.named(named),
                (Branch::List(items), _) if has_instances => {
                    let elements = std::mem::take(items).into_iter();
                    *items = elements.flat_map(|it| self.item(it)).collect();
                }
                (Branch::Table(_) | Branch::List(_), _)
                | (
                    Branch::Text(_)
                    | Branch::Integer(_)
                    | Branch::Float(_)
                    | Branch::Boolean(_)
                    | Branch::Date(_),
                    _,
                ) => {}
            }
        }
    }

    /// Expands the elements of a table of names.
    fn named(&mut self, named: &mut Table) {
        let mut known: BTreeMap<String, Span> = BTreeMap::new();
        for Entry { mut key, node } in std::mem::take(&mut named.entries) {
            let (instances, node) = self.taken(key.span, node);
            let Some(instances) = instances else {
                known.insert(key.value.clone(), key.span);
                named.entries.push(Entry { key, node });
                continue;
            };
            if let Some(first) = instances.first() {
                key.value = with_variable(&key.value, first);
            }
            if let Some(first) = instances.first()
                && let Some(variable) =
                    UnknownVariable::in_text(&first.text(&key.value), first.variables())
            {
                self.report
                    .found(invalid_name(&key.value, key.span, variable));
                continue;
            }
            let Some(pattern) = instances.first().map(|it| NodePattern::new(&node, it)) else {
                continue;
            };
            for instance in &instances {
                let key = At::new(instance.text(&key.value), key.span);
                if let Some(earlier) = known.insert(key.value.clone(), key.span) {
                    self.report.found(InvalidInstances {
                        reason: format!("there are two elements `{}`", key.value),
                        at: key.span,
                        is_malformed: false,
                        earlier: (earlier != key.span).then_some(earlier),
                    });
                    break;
                }
                let node = instance.node(&pattern);
                named.entries.push(Entry { key, node });
            }
        }
    }

    /// Returns the instances of an element of a list.
    fn item(&mut self, item: Node) -> Vec<Node> {
        let at = item.span;
        let (instances, node) = self.taken(at, item);
        let Some(instances) = instances else {
            return vec![node];
        };
        let Some(first) = instances.first() else {
            return Vec::new();
        };
        let pattern = NodePattern::new(&node, first);
        if instances.len() > 1 && pattern.is_fixed() {
            if let Some(unknown) = unknown_variable(&node, first) {
                self.report.found(unknown);
                return Vec::new();
            }
            let reason = format!(
                "`${}` does not occur in it, so that all instances are equal",
                first.first_variable()
            );
            self.report.found(InvalidInstances {
                reason,
                at,
                is_malformed: false,
                earlier: None,
            });
            return vec![node];
        }
        instances.iter().map(|it| it.node(&pattern)).collect()
    }

    /// Takes the key `for` from an element. Returns its instances, `None` if it has no such key, and the rest of the element.
    fn taken(&mut self, at: Span, mut element: Node) -> (Option<Vec<ElementInstance>>, Node) {
        let Branch::Table(table) = &mut element.value else {
            return (None, element);
        };
        let Some(index) = table.entries.iter().position(|it| it.key.value == FOR) else {
            return (None, element);
        };
        let mut range = table.entries.remove(index);
        let place = extent(&element, at.to(range.node.span));
        let used = &mut self.elements.properties;
        let substituted = self.properties.substitute(&mut range.node, used);
        let is_malformed = substituted.is_ok();
        let found = substituted.and_then(|()| instances(&range.node));
        let found = found.unwrap_or_else(|reason| {
            self.report.found(InvalidInstances {
                reason,
                at: range.node.span,
                is_malformed,
                earlier: None,
            });
            Vec::new()
        });
        let variables = found.first().map(ElementInstance::variables);
        let places = &mut self.elements.places;
        places.push((place, variables.unwrap_or_default()));
        (Some(found), element)
    }
}

/// Returns the name of an element with its variable: `R` alone names its instances `R1`, `R2`, …
fn with_variable(name: &str, first: &ElementInstance) -> String {
    if name.contains('$') {
        name.to_owned()
    } else {
        format!("{name}${}", first.first_variable())
    }
}

/// An element with `for` and its instances.
pub(crate) struct ElementInstances<'n> {
    element: &'n Node,
    range: Span,
    instances: Vec<ElementInstance>,
}

impl<'n> ElementInstances<'n> {
    /// Returns the instances of an element; `None` without a valid `for`.
    pub(crate) fn of(element: &'n Node) -> Option<Self> {
        let Branch::Table(table) = &element.value else {
            return None;
        };
        let range = &table.get(FOR)?.node;
        Some(Self {
            element,
            range: range.span,
            instances: instances(range).ok()?,
        })
    }

    /// Returns the names of the instances of an element with this name.
    pub(crate) fn names(&self, name: &str) -> Vec<String> {
        let Some(first) = self.instances.first() else {
            return Vec::new();
        };
        let name = with_variable(name, first);
        self.instances.iter().map(|it| it.text(&name)).collect()
    }

    /// Returns the instances as elements without `for`.
    pub(crate) fn elements(&self) -> Vec<Node> {
        let mut element = self.element.clone();
        if let Branch::Table(table) = &mut element.value {
            table.entries.retain(|it| it.key.value != FOR);
        }
        let Some(first) = self.instances.first() else {
            return Vec::new();
        };
        let pattern = NodePattern::new(&element, first);
        self.instances.iter().map(|it| it.node(&pattern)).collect()
    }

    /// Returns the element with those instances whose index `keeps` accepts; `None` if there are none.
    pub(crate) fn keeping(&self, keeps: impl Fn(usize) -> bool) -> Option<Node> {
        let instances = self.instances.iter().enumerate();
        let kept = instances.filter(|(index, _)| keeps(*index));
        let rows: Vec<Node> = kept.map(|(_, it)| it.row(self.range)).collect();
        if rows.is_empty() {
            return None;
        }
        let mut element = self.element.clone();
        if let Branch::Table(table) = &mut element.value
            && let Some(range) = table.entries.iter_mut().find(|it| it.key.value == FOR)
        {
            range.node.value = Branch::List(rows);
        }
        Some(element)
    }
}

/// Returns the first string of an element with a variable that its `for` does not have.
fn unknown_variable(node: &Node, instance: &ElementInstance) -> Option<InvalidName> {
    match &node.value {
        Branch::Text(text) => {
            let variable = UnknownVariable::in_text(text, instance.variables())?;
            Some(invalid_name(text, node.span, variable))
        }
        Branch::Table(table) => {
            let mut entries = table.entries.iter();
            entries.find_map(|it| unknown_variable(&it.node, instance))
        }
        Branch::List(items) => items.iter().find_map(|it| unknown_variable(it, instance)),
        Branch::Integer(_) | Branch::Float(_) | Branch::Boolean(_) | Branch::Date(_) => None,
    }
}

fn invalid_name(text: &str, at: Span, variable: UnknownVariable) -> InvalidName {
    InvalidName {
        text: text.to_owned(),
        what: "a name",
        rule: "",
        at,
        variable: Some(variable),
    }
}

/// Returns the smallest range that contains `at` and all values of a node in the same file.
fn extent(node: &Node, at: Span) -> Span {
    let inner: Vec<&Node> = match &node.value {
        Branch::Table(table) => table.entries.iter().map(|it| &it.node).collect(),
        Branch::List(items) => items.iter().collect(),
        Branch::Text(_)
        | Branch::Integer(_)
        | Branch::Float(_)
        | Branch::Boolean(_)
        | Branch::Date(_) => Vec::new(),
    };
    let own = if node.span.file == at.file {
        at.to(node.span)
    } else {
        at
    };
    inner.into_iter().fold(own, |at, node| extent(node, at))
}
