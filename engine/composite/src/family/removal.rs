//! Removal of what a composite leaves out of its base.

use crate::instances::ElementInstances;
use crate::tree::{Branch, Entry, Node, Table};

/// Keys of a connection, wire or promotion whose values are no ends of it.
const SETTINGS: [&str; 2] = ["profile", "binding"];

/// Keys that a composite has and its components do not.
const OF_COMPOSITES: [&str; 4] = ["components", "connections", "wires", "promote"];

/// Reason for which an element cannot be removed.
#[derive(Debug, PartialEq)]
pub(super) enum NotRemoved {
    /// There is none. Contains the paths of the elements beside the one that is missing.
    Missing(Vec<String>),
    /// It belongs to the composite in this file, which implements the component at `component`.
    Nested { component: String, file: String },
    /// It is a part of one instance; all instances have it at this path.
    OfInstances(String),
}

impl NotRemoved {
    /// Returns the reason as seen from the table that has the key `key`.
    fn within(self, key: &str) -> Self {
        match self {
            Self::Missing(known) => {
                let known = known.into_iter();
                Self::Missing(known.map(|known| format!("{key}.{known}")).collect())
            }
            Self::Nested { component, file } if component.is_empty() => Self::Nested {
                component: key.to_owned(),
                file,
            },
            Self::Nested { component, file } => Self::Nested {
                component: format!("{key}.{component}"),
                file,
            },
            Self::OfInstances(path) => Self::OfInstances(format!("{key}.{path}")),
        }
    }
}

/// Removes the element at `path`: the names of keys separated by dots, and within a list the value itself or the ends of
/// a table, as in `connections.Joystick.twist -> Rover.twist`.
///
/// # Errors
///
/// There is no such element.
pub(super) fn remove(table: &mut Table, path: &str) -> Result<(), NotRemoved> {
    if let Some(at) = table.entries.iter().position(|it| it.key.value == path) {
        table.entries.remove(at);
        return Ok(());
    }
    let rest = |entry: &Entry| {
        let rest = path.strip_prefix(&entry.key.value)?.strip_prefix('.')?;
        Some(rest.to_owned())
    };
    let mut entries = table.entries.iter_mut();
    let Some((rest, entry)) = entries.find_map(|entry| Some((rest(entry)?, entry))) else {
        return remove_instance(table, path);
    };
    let removed = match &mut entry.node.value {
        Branch::Table(table) => remove(table, &rest),
        Branch::List(items) => remove_from(items, &rest),
        Branch::Text(_)
        | Branch::Integer(_)
        | Branch::Float(_)
        | Branch::Boolean(_)
        | Branch::Date(_) => Err(NotRemoved::Missing(Vec::new())),
    };
    removed.map_err(|reason| reason.within(&entry.key.value))
}

/// Removes an instance of an element with `for`, whose other instances stay.
fn remove_instance(table: &mut Table, path: &str) -> Result<(), NotRemoved> {
    for (at, entry) in table.entries.iter_mut().enumerate() {
        let Some(instances) = ElementInstances::of(&entry.node) else {
            continue;
        };
        let names = instances.names(&entry.key.value);
        if names.iter().any(|name| name == path) {
            match instances.keeping(|index| names.get(index).is_none_or(|name| name != path)) {
                Some(others) => entry.node = others,
                None => drop(table.entries.remove(at)),
            }
            return Ok(());
        }
        let mut parts = names.iter();
        let part = parts.find_map(|name| path.strip_prefix(name)?.strip_prefix('.'));
        if let Some(part) = part {
            return Err(NotRemoved::OfInstances(format!(
                "{}.{part}",
                entry.key.value
            )));
        }
    }
    Err(missing(table, path))
}

/// Returns whether `over`, laid over `table`, replaces all of the element at `path`, so that its removal changes nothing.
pub(super) fn is_overridden(table: &Table, over: &Table, path: &str) -> bool {
    if let (Some(under), Some(over)) = (table.get(path), over.get(path)) {
        return covers(&over.node, &under.node);
    }
    let mut entries = table.entries.iter();
    let found = entries.find_map(|under| {
        let rest = path.strip_prefix(&under.key.value)?.strip_prefix('.')?;
        Some((rest, under, over.get(&under.key.value)?))
    });
    let Some((rest, under, over)) = found else {
        return false;
    };
    match (&under.node.value, &over.node.value) {
        (Branch::Table(under), Branch::Table(over)) => is_overridden(under, over, rest),
        // a value that is no table replaces the one of the base
        (_, _) => true,
    }
}

/// Returns whether `over`, laid over `under`, leaves nothing of it.
fn covers(over: &Node, under: &Node) -> bool {
    let (Branch::Table(under), Branch::Table(over)) = (&under.value, &over.value) else {
        return true;
    };
    under.entries.iter().all(|under| {
        let over = over.get(&under.key.value);
        over.is_some_and(|over| covers(&over.node, &under.node))
    })
}

/// Returns the reason for which a table has no element at `path`.
fn missing(table: &Table, path: &str) -> NotRemoved {
    let implementation = table.get("implementation").map(|it| &it.node.value);
    let mut of_composites = OF_COMPOSITES.iter();
    if of_composites.any(|it| path.split('.').next() == Some(it))
        && let Some(Branch::Table(implementation)) = implementation
        && let Some(file) = implementation.get("composite")
        && let Some(file) = file.node.value.text()
    {
        return NotRemoved::Nested {
            component: String::new(),
            file: file.to_owned(),
        };
    }
    let entries = table.entries.iter();
    NotRemoved::Missing(entries.map(|entry| entry.key.value.clone()).collect())
}

/// Removes the elements of a list that `selector` names: a string by its value, a table by one or two of its ends. A table
/// with lists of ends stands for all pairs of them, and only the named pairs are removed.
fn remove_from(items: &mut Vec<Node>, selector: &str) -> Result<(), NotRemoved> {
    let (first, second) = match selector.split_once(" -> ") {
        Some((first, second)) => (first.trim(), Some(second.trim())),
        None => (selector.trim(), None),
    };
    let mut is_removed = false;
    let mut left = Vec::with_capacity(items.len());
    for item in items.iter() {
        if let Some(rest) = without_instances(item, first, second) {
            is_removed = true;
            left.extend(rest);
            continue;
        }
        let rest = if let Branch::Table(table) = &item.value {
            without(table, first, second).map(|tables| {
                let nodes = tables.into_iter().map(|table| Node {
                    span: item.span,
                    value: Branch::Table(table),
                });
                nodes.collect()
            })
        } else {
            (item.value.text() == Some(selector)).then(Vec::new)
        };
        match rest {
            Some(rest) => {
                is_removed = true;
                left.extend(rest);
            }
            None => left.push(item.clone()),
        }
    }
    if is_removed {
        *items = left;
        return Ok(());
    }
    let known = items.iter().flat_map(|item| {
        if let Branch::Table(table) = &item.value {
            selectors(table, second.is_some())
        } else {
            item.value.text().map(str::to_owned).into_iter().collect()
        }
    });
    Err(NotRemoved::Missing(known.collect()))
}

/// Returns what is left of a table with `for` without the instances that have an end, or a pair of ends. `None` if none has
/// it.
fn without_instances(item: &Node, first: &str, second: Option<&str>) -> Option<Vec<Node>> {
    let instances = ElementInstances::of(item)?;
    let mut changed = Vec::new();
    let mut left = Vec::new();
    for (index, element) in instances.elements().into_iter().enumerate() {
        if let Branch::Table(table) = &element.value
            && let Some(tables) = without(table, first, second)
        {
            changed.push(index);
            left.extend(tables.into_iter().map(|table| Node {
                span: element.span,
                value: Branch::Table(table),
            }));
        }
    }
    if changed.is_empty() {
        return None;
    }
    left.extend(instances.keeping(|index| !changed.contains(&index)));
    Some(left)
}

/// Returns what is left of a table without an end, or without a pair of ends: nothing, the table with fewer ends, or two
/// tables. `None` if it does not have these ends.
fn without(table: &Table, first: &str, second: Option<&str>) -> Option<Vec<Table>> {
    let first_key = key_of(table, first, None)?;
    let Some(second) = second else {
        return Some(table_without(table, first_key, first).into_iter().collect());
    };
    let second_key = key_of(table, second, Some(first_key))?;
    let others = table_without(table, first_key, first);
    let partners = table_without(table, second_key, second);
    Some(match (others, partners) {
        // all pairs of the other ends, and the first end with the other partners
        (Some(others), Some(mut partners)) => {
            if let Some(entry) = partners.entries.get_mut(first_key) {
                entry.node = Node {
                    span: entry.node.span,
                    value: Branch::Text(first.to_owned()),
                };
            }
            vec![others, partners]
        }
        (Some(rest), None) | (None, Some(rest)) => vec![rest],
        (None, None) => Vec::new(),
    })
}

/// Returns the index of the key that has this end, other than `except`.
fn key_of(table: &Table, end: &str, except: Option<usize>) -> Option<usize> {
    let mut entries = table.entries.iter().enumerate();
    let found = entries.find(|(index, entry)| Some(*index) != except && ends(entry).contains(&end));
    found.map(|(index, _)| index)
}

/// Returns the table without an end of a list; `None` if the key has no other end.
fn table_without(table: &Table, key: usize, end: &str) -> Option<Table> {
    let mut table = table.clone();
    let Branch::List(items) = &mut table.entries.get_mut(key)?.node.value else {
        return None;
    };
    items.retain(|item| item.value.text() != Some(end));
    (!items.is_empty()).then_some(table)
}

/// Returns the ends at a key: its string, or the strings in its list.
fn ends(entry: &Entry) -> Vec<&str> {
    if SETTINGS.contains(&entry.key.value.as_str()) {
        return Vec::new();
    }
    let value = &entry.node.value;
    if let Branch::List(items) = value {
        items.iter().filter_map(|item| item.value.text()).collect()
    } else {
        value.text().into_iter().collect()
    }
}

/// Returns the selectors of a table: its first ends, or its pairs of a first and a second end.
fn selectors(table: &Table, in_pairs: bool) -> Vec<String> {
    let mut keys = table.entries.iter().map(ends).filter(|it| !it.is_empty());
    let (first, second) = (keys.next().unwrap_or_default(), keys.next());
    let first = first.into_iter().map(str::to_owned);
    match second {
        Some(second) if in_pairs => first
            .flat_map(|first| second.iter().map(move |end| format!("{first} -> {end}")))
            .collect(),
        Some(_) | None => first.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::parse;
    use asmotion_diagnostics::FileId;

    const TEXT: &str = r#"
[components.Rover]
bind.monitored."wants(ROB1)" = 1
bind.monitored.wants = 2

[components.Arm]
implementation = { composite = "arm.composite.toml" }

[[connections]]
from = "Joystick.twist"
to = ["Rover.twist", "Monitor.command"]
profile = ["lab", "field"]

[[connections]]
from = "Laser.scan"
to = "Monitor.scan"

[[connections]]
from = ["Adapter.event", "Follower.event"]
to = "topic:event"

[[connections]]
from = ["Left.rate", "Right.rate"]
to = ["Odometry.rate", "Monitor.rate"]

[deploy.processes.desk]
components = ["Joystick", "Monitor"]
"#;

    fn table() -> Table {
        let (table, errors) = parse(FileId(0), TEXT);
        assert!(errors.is_empty());
        table
    }

    /// The text after the removal of `path`, as lines.
    fn without(path: &str) -> String {
        let mut table = table();
        remove(&mut table, path).unwrap_or_else(|reason| panic!("{path}: {reason:?}"));
        let mut lines = Vec::new();
        list(&table, "", &mut lines);
        lines.join("\n")
    }

    fn list(table: &Table, prefix: &str, lines: &mut Vec<String>) {
        for entry in &table.entries {
            let path = format!("{prefix}{}", entry.key.value);
            value(&entry.node.value, &path, lines);
        }
    }

    fn value(branch: &Branch, path: &str, lines: &mut Vec<String>) {
        if let Branch::Table(table) = branch {
            list(table, &format!("{path}."), lines);
        } else if let Branch::List(items) = branch {
            let texts: Vec<_> = items.iter().filter_map(|it| it.value.text()).collect();
            if texts.is_empty() {
                let items = items.iter();
                items.for_each(|item| value(&item.value, path, lines));
            } else {
                lines.push(format!("{path} = {}", texts.join(" ")));
            }
        } else {
            lines.push(format!("{path} = {}", branch.text().unwrap_or("1")));
        }
    }

    /// The ends of the connections, as lines.
    fn connections(path: &str) -> String {
        let left = without(path);
        let ends = left
            .lines()
            .filter_map(|it| it.strip_prefix("connections."));
        ends.filter(|it| !it.starts_with("profile"))
            .collect::<Vec<_>>()
            .join("\n")
    }

    #[test]
    fn a_key_is_removed_by_its_path_whatever_its_name_contains() {
        let left = without("components.Rover.bind.monitored.wants(ROB1)");
        assert!(
            left.contains("monitored.wants =") && !left.contains("ROB1"),
            "{left}"
        );
        let left = without("components.Rover");
        assert!(!left.contains("monitored"), "{left}");
    }

    #[test]
    fn a_pair_of_ends_is_removed_and_the_others_stay() {
        let left = connections("connections.Joystick.twist -> Rover.twist");
        assert!(
            left.starts_with("from = Joystick.twist\nto = Monitor.command\n"),
            "{left}"
        );
        let left = connections("connections.Laser.scan -> Monitor.scan");
        assert!(!left.contains("scan"), "{left}");
        let left = connections("connections.Adapter.event -> topic:event");
        assert!(
            left.contains("from = Follower.event\nto = topic:event\n"),
            "{left}"
        );
        let left = connections("connections.Left.rate -> Monitor.rate");
        assert!(
            left.ends_with(
                "from = Right.rate\nto = Odometry.rate Monitor.rate\nfrom = Left.rate\nto = Odometry.rate"
            ),
            "{left}"
        );
    }

    #[test]
    fn an_end_is_removed_with_all_its_pairs_and_the_others_stay() {
        let left = connections("connections.Joystick.twist");
        assert!(
            !left.contains("Joystick") && !left.contains("Rover.twist"),
            "{left}"
        );
        let left = connections("connections.Rover.twist");
        assert!(
            left.starts_with("from = Joystick.twist\nto = Monitor.command\n"),
            "{left}"
        );
        let left = connections("connections.Follower.event");
        assert!(
            left.contains("from = Adapter.event\nto = topic:event\n"),
            "{left}"
        );
    }

    #[test]
    fn two_ends_of_one_side_are_no_pair_and_a_profile_is_no_end() {
        for path in [
            "connections.Adapter.event -> Follower.event",
            "connections.lab",
            "connections.Joystick.twist -> lab",
        ] {
            assert!(remove(&mut table(), path).is_err(), "{path}");
        }
    }

    #[test]
    fn a_word_is_removed_from_a_list() {
        let left = without("deploy.processes.desk.components.Joystick");
        assert!(left.contains("components = Monitor"), "{left}");
        assert!(!left.contains("components = Joystick"), "{left}");
    }

    const INSTANCES: &str = r#"
[components.Rover]
for = "$r in 1..3"
properties = { seed = "$r" }

[components."Arm_$side"]
for = [{ side = "left", x = 1.5 }, { side = "right", x = 2.5 }]

[[connections]]
for = "$r in 1..3"
from = "Rover$r.pose"
to = ["Map.poses", "Log.poses"]
"#;

    /// The text of the elements with `for` after the removal of `path`, with their instances in their place.
    fn instances_without(path: &str) -> Result<String, NotRemoved> {
        let (mut table, errors) = parse(FileId(0), INSTANCES);
        assert!(errors.is_empty());
        remove(&mut table, path)?;
        let mut lines = Vec::new();
        let mut elements = |name: &str, node: &Node| match ElementInstances::of(node) {
            Some(instances) => {
                let names = instances.names(name).into_iter();
                for (name, it) in names.zip(instances.elements()) {
                    value(&it.value, &name, &mut lines);
                }
            }
            None => value(&node.value, name, &mut lines),
        };
        for entry in &table.entries {
            if let Branch::Table(named) = &entry.node.value {
                for it in &named.entries {
                    elements(&it.key.value, &it.node);
                }
            } else if let Branch::List(items) = &entry.node.value {
                items.iter().for_each(|it| elements("", it));
            }
        }
        Ok(lines.join("\n"))
    }

    #[test]
    fn an_instance_is_removed_and_the_others_stay() {
        let left = instances_without("components.Rover2").unwrap();
        assert!(
            left.contains("Rover1.properties.seed") && left.contains("Rover3.properties.seed"),
            "{left}"
        );
        assert!(!left.contains("Rover2.properties"), "{left}");
        let left = instances_without("components.Arm_left").unwrap();
        assert!(left.contains("Rover2"), "{left}");
        let left = instances_without("connections.Rover2.pose").unwrap();
        assert!(!left.contains("from = Rover2.pose"), "{left}");
        assert_eq!(
            left.matches("to = Map.poses Log.poses").count(),
            2,
            "{left}"
        );
        let left = instances_without("connections.Rover2.pose -> Log.poses").unwrap();
        assert_eq!(
            left.matches("to = Map.poses Log.poses").count(),
            2,
            "{left}"
        );
        assert!(left.contains("from = Rover2.pose\n"), "{left}");
        // an end that all instances have
        let left = instances_without("connections.Log.poses").unwrap();
        assert!(
            !left.contains("Log") && left.contains("Rover2.pose"),
            "{left}"
        );
    }

    #[test]
    fn a_part_of_one_instance_is_one_of_all() {
        let reason = instances_without("components.Rover2.properties.seed").unwrap_err();
        let path = "components.Rover.properties.seed".to_owned();
        assert_eq!(reason, NotRemoved::OfInstances(path));
        assert!(matches!(
            instances_without("components.Rover4"),
            Err(NotRemoved::Missing(_))
        ));
    }

    #[test]
    fn a_missing_element_is_reported_with_those_beside_it() {
        let mut table = table();
        let before = table.clone();
        let mut known = |path: &str| match remove(&mut table, path) {
            Err(NotRemoved::Missing(known)) => known,
            other => panic!("{path}: {other:?}"),
        };
        let ends = known("connections.Laser.scam");
        assert_eq!(
            ends[..3],
            [
                "connections.Joystick.twist",
                "connections.Laser.scan",
                "connections.Adapter.event"
            ]
        );
        let pairs = known("connections.Laser.scan -> Rover.twist");
        assert_eq!(
            pairs[1..3],
            [
                "connections.Joystick.twist -> Monitor.command",
                "connections.Laser.scan -> Monitor.scan"
            ]
        );
        assert_eq!(
            known("components.Rower.bind"),
            ["components.Rover", "components.Arm"]
        );
        assert_eq!(table, before, "unchanged");
    }

    #[test]
    fn an_element_of_a_nested_composite_is_reported_with_its_file() {
        let reason = remove(&mut table(), "components.Arm.components.Gripper").unwrap_err();
        let expected = NotRemoved::Nested {
            component: "components.Arm".to_owned(),
            file: "arm.composite.toml".to_owned(),
        };
        assert_eq!(reason, expected);
    }
}
