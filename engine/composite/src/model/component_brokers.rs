//! The brokers of components.

use std::collections::BTreeSet;

use super::{Component, Composite, Terminal};
use crate::at::At;

/// The brokers of a composite's components, if components name their brokers. A `task` without `broker` is local. An `activity` has
/// no such key, so one connected to a topic uses the composite's only broker.
#[derive(Debug)]
pub struct ComponentBrokers {
    /// The only broker, and the names of the components that are connected to topics; `None` unless there is exactly one broker and a
    /// component names it.
    only: Option<(At<String>, BTreeSet<String>)>,
}

impl ComponentBrokers {
    /// The brokers of the components of a composite.
    pub fn of(composite: &Composite) -> Self {
        let only = match &*composite.brokers {
            [only] if composite.components.iter().any(|it| named(it).is_some()) => {
                Some((only.name.clone(), on_topics(composite)))
            }
            _ => None,
        };
        Self { only }
    }

    /// Returns the broker of a component; `None` if it is local, or if no component names a broker.
    pub fn broker<'c>(&'c self, component: &'c Component) -> Option<&'c At<String>> {
        let only = || {
            let (broker, on_topics) = self.only.as_ref()?;
            let uses_it = component.task.is_none() && on_topics.contains(&component.name.value);
            uses_it.then_some(broker)
        };
        named(component).or_else(only)
    }
}

/// The broker that a component names.
fn named(component: &Component) -> Option<&At<String>> {
    component.pace()?.broker.as_ref()
}

/// The names of the components with a port that a connection joins to a topic.
fn on_topics(composite: &Composite) -> BTreeSet<String> {
    let is_topic = |end: &Terminal| matches!(end, Terminal::Topic(_));
    let joined = composite.connections.iter().flat_map(|it| {
        let sides = [(&it.from, &it.to), (&it.to, &it.from)];
        let joined = sides.into_iter();
        joined.filter(move |(_, others)| others.iter().any(is_topic))
    });
    let ends = joined.flat_map(|(ends, _)| ends.iter());
    let ports = ends.filter_map(|end| match end {
        Terminal::Port(end) => Some(end.component.value.clone()),
        Terminal::Topic(_) | Terminal::Mqueue(_) => None,
    });
    ports.collect()
}
