//! The order in which the components of a system stop together.

use asmotion_component::AwaitedWriters;

use crate::connections::ConnectionTable;
use crate::descriptor::ComponentDescriptor;

/// Returns the running components in the order in which they stop: in reverse order of addition, except that a component stops
/// after the [writers that it awaits](asmotion_component::Component::awaited_writers). Of components that await each other, the
/// one added last stops first.
pub(super) fn stop_order(
    connections: &ConnectionTable,
    descriptors: &[ComponentDescriptor],
) -> Vec<usize> {
    let is_running = |component: &usize| descriptors[*component].status.state().is_running();
    let mut left: Vec<usize> = (0..descriptors.len()).rev().filter(is_running).collect();
    let waits_for = |component: usize, writer: usize| {
        let outputs = &descriptors[writer].declaration.outputs;
        let ends = (writer, component);
        component != writer
            && match descriptors[component].awaited_writers {
                AwaitedWriters::None => false,
                AwaitedWriters::Safe => connections.connects(ends, |it| outputs[it].safe.is_some()),
                AwaitedWriters::All => connections.connects(ends, |_| true),
            }
    };
    let mut order = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let is_ready = |component: &usize| !left.iter().any(|it| waits_for(*component, *it));
        let next = left.iter().position(is_ready).unwrap_or(0);
        order.push(left.remove(next));
    }
    order
}
