//! Checks wires and connections between processes: both ends must use a common broker.

use crate::codes::c074::LocalWireAcross;
use crate::codes::c075::NoCommonBroker;
use std::collections::BTreeMap;

use asmotion_diagnostics::{Report, Span};

use super::codec;
use super::scene::{CheckedComposite, nested};
use super::topic::{Role, Topics};
use crate::finding::Findings;
use crate::model::{Component, End, Terminal, Transport, Wire};

pub(crate) fn check(scene: &CheckedComposite<'_>, topics: &Topics, report: &mut Report) {
    let Some(processes) = &scene.processes else {
        return;
    };
    let mut components = scene.parts.iter().map(|part| part.component);
    let mut across = Across {
        scene,
        has_homes: components.any(|it| matches!(home(scene, it), Home::On(_))),
        processes,
        report,
    };
    for wire in &scene.composite.wires {
        if scene.active(&wire.profiles) {
            across.wire(wire);
        }
    }
    for connection in &scene.composite.connections {
        if !scene.active(&connection.profiles) {
            continue;
        }
        for (from, to) in connection
            .from
            .iter()
            .flat_map(|from| connection.to.iter().map(move |to| (from, to)))
        {
            if let (Terminal::Port(from), Terminal::Port(to)) = (from, to) {
                across.connection(from, to);
            }
        }
    }
    for (topic, roles) in topics {
        across.topic(topic, roles);
    }
}

/// Broker assigned to a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Home<'s> {
    On(&'s str),
    Inside,
    /// A nested composite; its inner components determine the broker.
    Nested,
}

impl std::fmt::Display for Home<'_> {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::On(broker) => write!(to, "is on `{broker}`"),
            Self::Inside => to.write_str("has no broker"),
            Self::Nested => to.write_str("is a composite"),
        }
    }
}

/// Returns the broker of a component.
fn home<'s>(scene: &CheckedComposite<'s>, component: &'s Component) -> Home<'s> {
    match (nested(component), scene.member.broker_of(component)) {
        (Some(_), _) => Home::Nested,
        (None, Some(broker)) => Home::On(&broker.value),
        (None, None) => Home::Inside,
    }
}

struct Across<'s, 'r> {
    scene: &'s CheckedComposite<'s>,
    /// A component has a broker. If none has, all use the default broker of the run.
    has_homes: bool,
    processes: &'s BTreeMap<&'s str, &'s str>,
    report: &'r mut Report,
}

impl<'s> Across<'s, '_> {
    /// Returns the processes of two components if they differ.
    fn apart(&self, from: &str, to: &str) -> Option<(String, String)> {
        let (from, to) = (self.processes.get(from)?, self.processes.get(to)?);
        (from != to).then(|| ((*from).to_owned(), (*to).to_owned()))
    }

    /// Returns the broker of a component; `None` if all use the default broker of the run.
    fn home(&self, name: &str) -> Option<Home<'s>> {
        let part = self.scene.parts.named(name)?;
        self.has_homes.then(|| home(self.scene, part.component))
    }

    fn wire(&mut self, wire: &Wire) {
        for service in &wire.services {
            let (from, to) = (&wire.reference.component.value, &service.component.value);
            let Some(processes) = self.apart(from, to) else {
                continue;
            };
            if let Some(binding) = &wire.binding
                && binding.value == Transport::Local
            {
                self.report.found(LocalWireAcross {
                    from: wire.reference.to_string(),
                    to: service.to_string(),
                    processes,
                    at: binding.span,
                });
                continue;
            }
            let inside = [from, to].map(|end| self.home(end)) == [Some(Home::Inside); 2];
            if inside && wire.binding.is_none() && wire.broker.is_none() {
                let what = format!("the wire from `{}` to `{service}`", wire.reference);
                let why = "neither has a broker".to_owned();
                self.no_broker(what, processes, why, wire.reference.span());
            }
        }
    }

    fn connection(&mut self, from: &End, to: &End) {
        let what = format!("the connection from `{from}` to `{to}`");
        self.meet(what, &from.component, &to.component, to.span());
        if self.apart(&from.component, &to.component).is_some() {
            codec::connection(self.scene, from, to, self.report);
        }
    }

    fn topic(&mut self, topic: &str, roles: &[Role]) {
        for publisher in roles.iter().filter(|role| role.published) {
            for subscriber in roles.iter().filter(|role| role.subscribed) {
                if let (Some(from), Some(to)) = (publisher.component(), subscriber.component()) {
                    self.meet(format!("topic `{topic}`"), from, to, subscriber.at);
                }
            }
        }
    }

    /// Checks that two components in different processes share a broker.
    fn meet(&mut self, what: String, from: &str, to: &str, at: Span) {
        let Some(processes) = self.apart(from, to) else {
            return;
        };
        let (Some(one), Some(other)) = (self.home(from), self.home(to)) else {
            return;
        };
        let meet = matches!(one, Home::On(_)) && one == other;
        if !meet && one != Home::Nested && other != Home::Nested {
            let why = format!("`{from}` {one}, `{to}` {other}");
            self.no_broker(what, processes, why, at);
        }
    }

    fn no_broker(&mut self, what: String, processes: (String, String), why: String, at: Span) {
        self.report.found(NoCommonBroker {
            what,
            processes,
            why,
            at,
        });
    }
}
