//! Checks the policies of connections: keys without effect, in combination and at the ends that they connect.

use std::borrow::Cow;
use std::collections::BTreeMap;

use asmotion_datum::{Shape, Word as _};
use asmotion_diagnostics::{Report, Span};

use super::endpoints::PortDirection;
use super::scene::{CheckedComposite, processes};
use crate::at::At;
use crate::codes::c004::MissingKey;
use crate::codes::c044::QueueWithoutSize;
use crate::codes::c048::IdleKey;
use crate::finding::Findings;
use crate::model::{
    Connection, ConnectionType, Delivery, End, Implementation, OnStale, Policy, Sharing, Terminal,
};

pub(super) fn check(scene: &CheckedComposite<'_>, connection: &Connection, report: &mut Report) {
    combinations(&connection.policy, report);
    polls(scene, connection, report);
    last_value(scene, connection, report);
    held(scene, connection, report);
    at_ends(scene, connection, report);
}

/// Reports keys that have no effect in combination.
fn combinations(policy: &Policy, report: &mut Report) {
    let kind = policy
        .kind
        .as_ref()
        .map_or(ConnectionType::Data, |kind| kind.value);
    match (kind, &policy.size) {
        (ConnectionType::Buffer | ConnectionType::Circular, None) => {
            let at = policy.kind.as_ref().map_or(policy.span, |kind| kind.span);
            let kind = kind.word();
            report.found(QueueWithoutSize { kind, at });
        }
        (ConnectionType::Data, Some(size)) => {
            idle("size", size.span, "only a queue has a size", report)
        }
        (ConnectionType::Buffer | ConnectionType::Circular, Some(_))
        | (ConnectionType::Data, None) => {}
    }
    if let (Some(on_stale), None) = (&policy.on_stale, &policy.max_age_ms) {
        idle(
            "on_stale",
            on_stale.span,
            "`max_age_ms` is missing, so nothing gets stale",
            report,
        );
    }
    let delivery = policy.delivery.as_ref();
    if let (Some(delivery), None) = (delivery, &policy.poll_ms)
        && delivery.value == Delivery::Poll
    {
        report.found(MissingKey {
            key: "poll_ms",
            of: "a connection that is polled",
            at: delivery.span,
            example: "50".to_owned(),
        });
    }
}

/// Reports keys of polling that change nothing.
fn polls(scene: &CheckedComposite<'_>, connection: &Connection, report: &mut Report) {
    let policy = &connection.policy;
    let delivery = policy.delivery.as_ref();
    let Some(delivery) = delivery.filter(|it| it.value == Delivery::Poll) else {
        if let Some(poll_ms) = &policy.poll_ms {
            let reason = "only `delivery = \"poll\"` has an interval";
            idle("poll_ms", poll_ms.span, reason, report);
        }
        return;
    };
    let has_pace = |terminal: &Terminal| {
        let Terminal::Port(end) = terminal else {
            return false;
        };
        let component = scene.member.component(&end.component);
        component.is_some_and(CheckedComposite::has_pace)
    };
    if !connection.to.is_empty() && connection.to.iter().all(has_pace) {
        let reason = "the reader has a period or a master, and reads in each of its cycles";
        idle("delivery", delivery.span, reason, report);
    }
}

/// Reports keys of queues at a connection that keeps the last value.
fn last_value(scene: &CheckedComposite<'_>, connection: &Connection, report: &mut Report) {
    let policy = &connection.policy;
    let kind = policy
        .kind
        .as_ref()
        .map_or_else(ConnectionType::default, |it| it.value);
    if let Some(buffer) = &policy.buffer
        && kind == ConnectionType::Data
        && buffer.value != Sharing::PerConnection
    {
        let reason = "only a queue can be shared";
        idle("buffer", buffer.span, reason, report);
    }
    let overwrites = match kind {
        ConnectionType::Data => "the last value is overwritten, so no write fails",
        ConnectionType::Circular => "the oldest message is overwritten, so no write fails",
        ConnectionType::Buffer => return,
    };
    if let Some(mandatory) = is_set(policy.mandatory.as_ref())
        && routes(scene, connection).iter().any(|it| it.has_writer())
        && !converts(scene, connection)
    {
        idle("mandatory", mandatory, overwrites, report);
    }
}

/// Reports an age limit of a reader that uses stale messages all the same, and cannot see that they are: a specification. A
/// message queue discards them itself.
fn held(scene: &CheckedComposite<'_>, connection: &Connection, report: &mut Report) {
    let policy = &connection.policy;
    let is_held = policy
        .on_stale
        .as_ref()
        .is_none_or(|it| it.value == OnStale::Hold);
    let is_specification = |terminal: &Terminal| {
        let Terminal::Port(end) = terminal else {
            return false;
        };
        let component = scene.member.component(&end.component);
        let made_of = component.and_then(|it| it.implementation.as_ref());
        matches!(made_of, Some(Implementation::Asm { .. }))
    };
    let is_from_queue = |terminal: &Terminal| matches!(terminal, Terminal::Mqueue(_));
    if let Some(max_age) = &policy.max_age_ms
        && is_held
        && !connection.to.is_empty()
        && connection.to.iter().all(is_specification)
        && !connection.from.iter().any(is_from_queue)
    {
        let reason = "a specification does not see the age of a message: `on_stale = \"no_data\"` discards old ones, and `stale_ms` of its binding replaces their value";
        idle("max_age_ms", max_age.span, reason, report);
    }
}

/// Returns whether a message may not fit the type of its reader, so that a write can fail in any case: the type of an end is not
/// known.
fn converts(scene: &CheckedComposite<'_>, connection: &Connection) -> bool {
    let is_open = |end: &End, way: PortDirection| {
        let part = scene.parts.named(&end.component);
        let kind = part.and_then(|part| part.face.port(&end.name, way)?.1.kind.as_ref());
        let schema = kind.and_then(|kind| scene.types.schema(&kind.text));
        schema.is_none_or(|schema| schema.shape == Shape::Any)
    };
    let is_open = |terminal: &Terminal, way: PortDirection| match terminal {
        Terminal::Port(end) => is_open(end, way),
        Terminal::Topic(_) | Terminal::Mqueue(_) => false,
    };
    let mut from = connection.from.iter();
    let mut to = connection.to.iter();
    from.any(|it| is_open(it, PortDirection::Out)) || to.any(|it| is_open(it, PortDirection::In))
}

/// The way of a message through a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Route {
    /// Between ports of a process.
    Within,
    /// Between ports of different processes.
    Across,
    FromTopic,
    ToTopic,
    FromQueue,
    ToQueue,
}

impl Route {
    /// Returns whether a writer of this process writes into the queue of the reader.
    fn has_writer(self) -> bool {
        matches!(self, Self::Within | Self::FromTopic)
    }

    /// Returns whether the reader of the connection is a port of this process.
    fn has_reader(self) -> bool {
        !matches!(self, Self::ToTopic | Self::ToQueue)
    }

    fn reason(self) -> &'static str {
        match self {
            Self::Within => "the connection is within a process",
            Self::Across => "the ends are in different processes",
            Self::FromTopic => "the message comes from a topic",
            Self::ToTopic => "each reader of the topic has its own policy, at `from = \"topic:…\"`",
            Self::FromQueue => "the writer is outside, at a message queue",
            Self::ToQueue => "the reader is outside, at a message queue",
        }
    }
}

/// The routes of a connection. Components of a nested composite are in one process.
fn routes(scene: &CheckedComposite<'_>, connection: &Connection) -> Vec<Route> {
    let deploy = scene.composite.deploy.as_ref();
    let processes = deploy.map_or_else(BTreeMap::new, processes);
    let process = |end: &End| processes.get(end.component.value.as_str());
    let route = |from: &Terminal, to: &Terminal| match (from, to) {
        (Terminal::Port(from), Terminal::Port(to)) if process(from) == process(to) => {
            Some(Route::Within)
        }
        (Terminal::Port(_), Terminal::Port(_)) => Some(Route::Across),
        (Terminal::Port(_), Terminal::Topic(_)) => Some(Route::ToTopic),
        (Terminal::Port(_), Terminal::Mqueue(_)) => Some(Route::ToQueue),
        (Terminal::Topic(_), Terminal::Port(_)) => Some(Route::FromTopic),
        (Terminal::Mqueue(_), Terminal::Port(_)) => Some(Route::FromQueue),
        (Terminal::Topic(_) | Terminal::Mqueue(_), Terminal::Topic(_) | Terminal::Mqueue(_)) => {
            None
        }
    };
    let from = connection.from.iter();
    let pairs = from.flat_map(|from| connection.to.iter().map(move |to| (from, to)));
    pairs.filter_map(|(from, to)| route(from, to)).collect()
}

/// A key, its place if it is written, and whether it has an effect on a route.
type EndKey = (&'static str, Option<Span>, fn(Route) -> bool);

/// Reports keys that have no effect at the ends of the connection.
fn at_ends(scene: &CheckedComposite<'_>, connection: &Connection, report: &mut Report) {
    let policy = &connection.policy;
    let routes = routes(scene, connection);
    let Some(first) = routes.first() else {
        return;
    };
    let has_queue = policy
        .kind
        .as_ref()
        .is_some_and(|it| it.value != ConnectionType::Data);
    let buffer = policy
        .buffer
        .as_ref()
        .filter(|it| has_queue && it.value != Sharing::PerConnection);
    let max_age = policy.max_age_ms.as_ref();
    let on_stale = policy.on_stale.as_ref().filter(|_| max_age.is_some());
    let keys: [EndKey; 8] = [
        (
            "mandatory",
            is_set(policy.mandatory.as_ref()),
            Route::has_writer,
        ),
        ("buffer", buffer.map(|it| it.span), Route::has_writer),
        (
            "max_threads",
            policy.max_threads.as_ref().map(|it| it.span),
            Route::has_writer,
        ),
        ("pull", is_set(policy.pull.as_ref()), Route::has_reader),
        (
            "lock",
            policy.lock.as_ref().map(|it| it.span),
            Route::has_reader,
        ),
        (
            "delivery",
            policy.delivery.as_ref().map(|it| it.span),
            Route::has_reader,
        ),
        ("on_stale", on_stale.map(|it| it.span), Route::has_reader),
        ("max_age_ms", max_age.map(|it| it.span), |it| {
            it != Route::ToTopic
        }),
    ];
    for (key, at, has_effect) in keys {
        if let Some(at) = at
            && !routes.iter().any(|it| has_effect(*it))
        {
            idle(key, at, first.reason(), report);
        }
    }
    of_queues(policy, &routes, report);
}

/// Reports `data_size` unless a message queue is written, and `init` if one is an end.
fn of_queues(policy: &Policy, routes: &[Route], report: &mut Report) {
    let is_read = routes.contains(&Route::FromQueue);
    let is_written = routes.contains(&Route::ToQueue);
    if let Some(size) = &policy.data_size
        && !is_written
    {
        let reason = if is_read {
            "the writer of a queue decides the size of its messages"
        } else {
            "only messages of a queue `mqueue:/name` have a size"
        };
        idle("data_size", size.span, reason, report);
    }
    if let Some(init) = is_set(policy.init.as_ref())
        && (is_read || is_written)
    {
        let reason = "messages of a queue are not repeated for new readers";
        idle("init", init, reason, report);
    }
}

/// Returns the place of a key that is `true`.
fn is_set(key: Option<&At<bool>>) -> Option<Span> {
    key.filter(|it| it.value).map(|it| it.span)
}

fn idle(key: &'static str, at: Span, reason: &'static str, report: &mut Report) {
    report.found(IdleKey {
        key: Cow::Borrowed(key),
        at,
        reason,
    });
}
