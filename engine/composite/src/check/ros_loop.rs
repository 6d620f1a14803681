//! Finds circles in which messages go round through topics of ROS and ros-bridges.
//!
//! A bridge does not receive what its own node publishes, and does not return a message to the topic of ROS from which it has
//! brought it. Two bridges do not know of each other, so what one sends to ROS comes back through the other.

use asmotion_diagnostics::Report;

use super::endpoints::PortDirection;
use super::scene::CheckedComposite;
use crate::codes::c187::EndlessCircle;
use crate::finding::Findings;
use crate::model::{Bridge, BridgeKind, Direction, Implementation, MapEntry, RosEntry};

/// A mapping of a topic of the composite and a topic of ROS.
struct Passage<'c> {
    /// Position of the bridge's component.
    component: usize,
    name: &'c str,
    bridge: &'c Bridge,
    topic: String,
    entry: &'c RosEntry,
}

pub(super) fn check(scene: &CheckedComposite<'_>, report: &mut Report) {
    let passages = passages(scene);
    let mut reported = vec![false; passages.len()];
    for start in 0..passages.len() {
        if reported.get(start).copied().unwrap_or(true) {
            continue;
        }
        let Some(circle) = circle(&passages, start) else {
            continue;
        };
        for index in &circle {
            if let Some(is_reported) = reported.get_mut(*index) {
                *is_reported = true;
            }
        }
        let steps: Vec<&Passage<'_>> = circle.iter().filter_map(|it| passages.get(*it)).collect();
        if let [first, .., last] = &*steps {
            let names = steps.iter().map(|it| {
                let (from, to) = match it.entry.direction.value {
                    Direction::ToRos => (&it.topic, &it.entry.ros.value),
                    Direction::FromRos => (&it.entry.ros.value, &it.topic),
                };
                format!("`{}` takes them from `{from}` to `{to}`", it.name)
            });
            report.found(EndlessCircle {
                topic: first.topic.clone(),
                way: names.collect::<Vec<_>>().join(", "),
                at: first.entry.span,
                back: last.entry.span,
            });
        }
    }
}

fn passages<'c>(scene: &'c CheckedComposite<'_>) -> Vec<Passage<'c>> {
    let mut passages = Vec::new();
    for (component, part) in scene.parts.iter().enumerate() {
        let Some(Implementation::Builtin {
            bridge: Some(name), ..
        }) = &part.component.implementation
        else {
            continue;
        };
        let mut bridges = scene.composite.bridges.iter();
        let Some(bridge) = bridges.find(|it| it.name.value == name.value) else {
            continue;
        };
        for entry in &part.component.special.map {
            let MapEntry::Ros(entry) = entry else {
                continue;
            };
            let direction = match entry.direction.value {
                Direction::ToRos => PortDirection::In,
                Direction::FromRos => PortDirection::Out,
            };
            let port = part.face.port(&entry.from.value, direction);
            // a port that is connected directly leads to a component, which may send something else
            if let Some(topic) = port.and_then(|(_, port)| port.topic.clone()) {
                passages.push(Passage {
                    component,
                    name: &part.component.name.value,
                    bridge,
                    topic,
                    entry,
                });
            }
        }
    }
    passages
}

/// Returns whether two bridges lead to the same system of ROS, as far as the composite shows.
fn is_same_system(one: &Bridge, other: &Bridge) -> bool {
    let (master, domain) = (
        |bridge: &Bridge| bridge.master.as_ref().map(|it| it.value.clone()),
        |bridge: &Bridge| bridge.domain.as_ref().map(|it| it.value),
    );
    one.kind.value == other.kind.value
        && match one.kind.value {
            BridgeKind::Ros1 => master(one) == master(other),
            BridgeKind::Ros2 => domain(one) == domain(other),
            BridgeKind::Rosbridge => false,
        }
}

/// Returns whether messages that pass one mapping pass the other one next.
fn follows(one: &Passage<'_>, next: &Passage<'_>) -> bool {
    let is_own = one.component == next.component;
    let is_same_ros =
        one.entry.ros.value == next.entry.ros.value && is_same_system(one.bridge, next.bridge);
    match (one.entry.direction.value, next.entry.direction.value) {
        // a node does not receive its own messages
        (Direction::ToRos, Direction::FromRos) => is_same_ros && !is_own,
        // a bridge does not return a message to where it comes from
        (Direction::FromRos, Direction::ToRos) => {
            one.topic == next.topic && !(is_own && is_same_ros)
        }
        (Direction::ToRos, Direction::ToRos) | (Direction::FromRos, Direction::FromRos) => false,
    }
}

/// The shortest circle that begins with a mapping; `None` if its messages do not return to it.
fn circle(passages: &[Passage<'_>], start: usize) -> Option<Vec<usize>> {
    let mut before: Vec<Option<usize>> = vec![None; passages.len()];
    let mut queue = std::collections::VecDeque::from([start]);
    while let Some(at) = queue.pop_front() {
        let here = passages.get(at)?;
        for (next, passage) in passages.iter().enumerate() {
            if !follows(here, passage) {
                continue;
            }
            if next == start {
                let way = std::iter::successors(Some(at), |it| *before.get(*it)?);
                let mut way: Vec<usize> = way.collect();
                way.reverse();
                return Some(way);
            }
            let known = before.get_mut(next)?;
            if known.is_none() {
                *known = Some(at);
                queue.push_back(next);
            }
        }
    }
    None
}
