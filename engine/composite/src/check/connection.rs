//! Checks connections: direction and type of both ends, a single writer for last-value data, and a writer for every
//! input.

use crate::codes::c040::WrongDirection;
use crate::codes::c041::NoComponentJoined;
use crate::codes::c042::ConnectionMismatch;
use crate::codes::c043::TwoWriters;
use crate::codes::c045::UnconnectedInput;
use crate::codes::c046::OpenInput;
use crate::codes::c047::UnsyncAcrossThreads;
use crate::codes::c049::DuplicateConnection;
use crate::codes::c058::TooManyThreads;
use std::collections::{BTreeMap, BTreeSet};

use asmotion_diagnostics::{Report, Span};

use super::endpoints::{PortDirection, TypeAt};
use super::meant::meant;
use super::scene::{CheckedComponent, CheckedComposite};
use super::wire::own_place;
use super::{policy, queue};
use crate::finding::Findings;
use crate::model::{Connection, ConnectionType, End, Lock, Promoted, Terminal};

/// A connection between a port and a topic.
pub(crate) struct TopicLink {
    pub topic: String,
    /// Source location of the topic name.
    pub at: Span,
    pub port: (String, String),
    pub kind: Option<TypeAt>,
    /// Whether the port publishes to the topic.
    pub published: bool,
}

/// Checks all connections and returns those that connect topics.
pub(crate) fn check(scene: &CheckedComposite<'_>, report: &mut Report) -> Vec<TopicLink> {
    let mut drivers = Drivers::default();
    let mut links = Vec::new();
    for connection in &scene.composite.connections {
        if scene.active(&connection.profiles) {
            self::connection(scene, connection, &mut drivers, &mut links, report);
        }
    }
    for promotion in &scene.composite.promotions {
        if let Promoted::Port(end) = &promotion.what
            && scene.active(&promotion.profiles)
        {
            drivers
                .elsewhere
                .insert((end.component.value.clone(), end.name.value.clone()));
        }
    }
    for part in &scene.parts {
        undriven(part, &drivers, report);
    }
    links
}

/// Writers of the input ports.
#[derive(Default)]
struct Drivers {
    joined: BTreeMap<(String, String), Span>,
    inside: BTreeMap<(String, String), (Span, ConnectionType)>,
    /// Ports written from outside the composite or by a misspelled component; exempt from the check for missing
    /// writers.
    elsewhere: BTreeSet<(String, String)>,
}

fn connection(
    scene: &CheckedComposite<'_>,
    connection: &Connection,
    drivers: &mut Drivers,
    links: &mut Vec<TopicLink>,
    report: &mut Report,
) {
    policy::check(scene, connection, report);
    let before = report.diagnostics.len();
    let from = terminals(scene, &connection.from, PortDirection::Out, report);
    // ends that could not be parsed are missing from the list
    let misnamed = report.diagnostics.len() > before || connection.from.is_empty();
    let to = terminals(scene, &connection.to, PortDirection::In, report);
    let mut repeated = Vec::new();
    for source in &from {
        for target in &to {
            let key = (source.terminal.to_string(), target.terminal.to_string());
            if let Some(first) = drivers.joined.insert(key, target.terminal.span()) {
                let (from, to) = (source.terminal.to_string(), target.terminal.to_string());
                let at = target.terminal.span();
                report.found(DuplicateConnection {
                    from,
                    to,
                    at,
                    first,
                });
                repeated.push(target.terminal.span());
                continue;
            }
            pair(scene, connection, (source, target), links, report);
        }
        if let Some(target) = to.first()
            && let (Some(from), Some(to)) = (beyond(source.terminal), beyond(target.terminal))
        {
            let (from_at, to_at) = (source.terminal.span(), target.terminal.span());
            report.found(NoComponentJoined {
                from,
                from_at,
                to,
                to_at,
            });
        }
    }
    for target in &to {
        let Terminal::Port(end) = target.terminal else {
            continue;
        };
        if repeated.contains(&end.span()) {
            continue;
        }
        for source in &from {
            drive(scene, connection, source, end, drivers, report);
        }
    }
    // do not report these inputs a second time as having no writer
    if misnamed {
        let ends = connection
            .from
            .iter()
            .chain(&connection.to)
            .filter_map(port);
        let written = ends.map(|end| (end.component.value.clone(), end.name.value.clone()));
        drivers.elsewhere.extend(written);
    }
    let exists = |end: &End| {
        let mut found = to.iter().filter_map(|it| port(it.terminal));
        found.any(|found| found.span() == end.span())
    };
    let unknown = connection.to.iter().filter_map(port);
    let unknown = unknown.filter(|end| !exists(end)).filter_map(|end| {
        meant(scene, end, |part| {
            let inputs = part.face.inputs.iter();
            inputs.map(|it| it.name.text.as_str()).collect()
        })
    });
    drivers.elsewhere.extend(unknown);
}

/// Returns the port at an end; `None` if it is not a port.
fn port(terminal: &Terminal) -> Option<&End> {
    match terminal {
        Terminal::Port(end) => Some(end),
        Terminal::Topic(_) | Terminal::Mqueue(_) => None,
    }
}

/// Returns the description of an end that is not a port; `None` for ports.
fn beyond(terminal: &Terminal) -> Option<&'static str> {
    match terminal {
        Terminal::Port(_) => None,
        Terminal::Topic(_) => Some("a topic"),
        Terminal::Mqueue(_) => Some("a message queue"),
    }
}

/// A valid end of a connection: it exists, is active and has the required direction, as far as these are known.
struct JoinedEnd<'s> {
    terminal: &'s Terminal,
    kind: Option<TypeAt>,
}

fn terminals<'s>(
    scene: &CheckedComposite<'_>,
    terminals: &'s [Terminal],
    wanted: PortDirection,
    report: &mut Report,
) -> Vec<JoinedEnd<'s>> {
    let mut joints = Vec::new();
    for terminal in terminals {
        let Terminal::Port(end) = terminal else {
            joints.push(JoinedEnd {
                terminal,
                kind: None,
            });
            continue;
        };
        let Some((part, way, port)) = scene.port(end, wanted, report) else {
            if scene.has_unknown_ports(&end.component) {
                joints.push(JoinedEnd {
                    terminal,
                    kind: None,
                });
            }
            continue;
        };
        if way != wanted {
            report.found(WrongDirection {
                end: end.to_string(),
                is: way.word(),
                use_: match wanted {
                    PortDirection::In => "write",
                    PortDirection::Out => "read",
                },
                at: end.span(),
                declared: port
                    .name
                    .at
                    .filter(|at| at.file == part.component.name.span.file),
            });
            continue;
        }
        joints.push(JoinedEnd {
            terminal,
            kind: port.kind.clone(),
        });
    }
    joints
}

fn pair(
    scene: &CheckedComposite<'_>,
    connection: &Connection,
    (source, target): (&JoinedEnd<'_>, &JoinedEnd<'_>),
    links: &mut Vec<TopicLink>,
    report: &mut Report,
) {
    match (source.terminal, target.terminal) {
        (Terminal::Port(from), Terminal::Port(to)) => {
            threads(scene, connection, from, to, report);
            let (Some(from_kind), Some(to_kind)) = (&source.kind, &target.kind) else {
                return;
            };
            if !scene.types.same(&from_kind.text, &to_kind.text) {
                report.found(ConnectionMismatch {
                    from: from.to_string(),
                    from_kind: from_kind.clone(),
                    from_at: from.span(),
                    to: to.to_string(),
                    to_kind: to_kind.clone(),
                    to_at: to.span(),
                });
            }
        }
        (Terminal::Port(port), Terminal::Topic(topic)) => links.push(TopicLink {
            topic: topic.value.clone(),
            at: topic.span,
            port: (port.component.value.clone(), port.name.value.clone()),
            kind: source.kind.clone(),
            published: true,
        }),
        (Terminal::Topic(topic), Terminal::Port(port)) => links.push(TopicLink {
            topic: topic.value.clone(),
            at: topic.span,
            port: (port.component.value.clone(), port.name.value.clone()),
            kind: target.kind.clone(),
            published: false,
        }),
        (Terminal::Port(_), Terminal::Mqueue(queue)) => {
            queue::check(
                scene,
                (PortDirection::Out, source.kind.as_ref()),
                connection,
                queue,
                report,
            );
        }
        (Terminal::Mqueue(queue), Terminal::Port(_)) => {
            queue::check(
                scene,
                (PortDirection::In, target.kind.as_ref()),
                connection,
                queue,
                report,
            );
        }
        (Terminal::Topic(_) | Terminal::Mqueue(_), Terminal::Topic(_) | Terminal::Mqueue(_)) => {}
    }
}

/// Records the writer of a port; reports a second writer of last-value data.
fn drive(
    scene: &CheckedComposite<'_>,
    connection: &Connection,
    source: &JoinedEnd<'_>,
    to: &End,
    drivers: &mut Drivers,
    report: &mut Report,
) {
    let flow = connection
        .policy
        .kind
        .as_ref()
        .map_or(ConnectionType::Data, |kind| kind.value);
    let key = (to.component.value.clone(), to.name.value.clone());
    let at = source.terminal.span();
    let subscribed = scene
        .parts
        .named(&to.component)
        .and_then(|part| part.face.port(&to.name, PortDirection::In))
        .filter(|(_, port)| port.topic.is_some())
        .and_then(|(_, port)| port.name.at);
    let earlier = match drivers.inside.insert(key, (at, flow)) {
        Some(earlier) => Some(earlier),
        None => subscribed.map(|at| (at, flow)),
    };
    if let Some((first, first_flow)) = earlier
        && (flow == ConnectionType::Data || first_flow == ConnectionType::Data)
    {
        report.found(TwoWriters {
            port: to.to_string(),
            at,
            first,
        });
    }
}

fn undriven(part: &CheckedComponent<'_>, drivers: &Drivers, report: &mut Report) {
    for port in &part.face.inputs {
        let key = (part.component.name.value.clone(), port.name.text.clone());
        let driven = port.topic.is_some()
            || drivers.inside.contains_key(&key)
            || drivers.elsewhere.contains(&key);
        if driven || port.optional {
            continue;
        }
        let (component, port_name) = key;
        let at = own_place(part, port.name.at);
        let kind = port
            .kind
            .as_ref()
            .map_or("any", |kind| &kind.text)
            .to_owned();
        if port.listed {
            report.found(UnconnectedInput {
                component,
                port: port_name,
                kind,
                nested: super::nested(part.component).is_some(),
                at,
            })
        } else {
            report.found(OpenInput {
                component,
                port: port_name,
                kind,
                at,
            })
        }
    }
}

/// Checks the thread count: without a lock, both ends must run in the same thread; other policies limit the number of
/// threads.
fn threads(
    scene: &CheckedComposite<'_>,
    connection: &Connection,
    from: &End,
    to: &End,
    report: &mut Report,
) {
    let policy = &connection.policy;
    let [writer, reader] = [from, to].map(|end| thread(scene, &end.component.value));
    if let Some(lock) = &policy.lock
        && lock.value == Lock::Unsync
        && writer != reader
    {
        report.found(UnsyncAcrossThreads {
            from: from.component.value.clone(),
            to: to.component.value.clone(),
            at: lock.span,
            ends: to.span(),
        });
    }
    let threads = if writer == reader { 1 } else { 2 };
    if let Some(max) = &policy.max_threads
        && max.value < threads
    {
        report.found(TooManyThreads {
            threads,
            max: max.value,
            at: max.span,
            ends: to.span(),
        });
    }
}

/// Returns the component in whose thread the component runs.
fn thread<'s>(scene: &CheckedComposite<'s>, name: &'s str) -> &'s str {
    super::schedule::masters(scene, name).last().unwrap_or(name)
}
