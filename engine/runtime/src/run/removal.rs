//! Removal of components from a running system.

use std::collections::BTreeSet;

use asmotion_component::{AwaitedWriters, Transition};

use super::change::{ChangeError, ChangePlan, UndoStep};
use super::executor::{Act, Executor};
use crate::component_unit::ComponentUnit;
use crate::descriptor::ComponentDescriptor;

/// A component that is to be removed.
pub(super) struct RemovedComponent {
    pub index: usize,
    pub descriptor: ComponentDescriptor,
    /// References wired to it when its removal was planned, with the positions of their components. Wires planned later lead
    /// to a new component with its name.
    callers: Vec<(usize, String)>,
}

impl<E: Executor> ChangePlan<'_, E> {
    /// Plans the removal of a component: its position is vacant, and it leaves its topics.
    pub(super) fn remove(&mut self, component: &str) -> Result<(), ChangeError> {
        let index = self.run.index_of(component)?;
        if self.staged(index).is_some() {
            return Err(ChangeError::Removal {
                component: component.to_owned(),
                reason: "the same change adds it".to_owned(),
            });
        }
        self.leave_topics(index);
        let descriptors = self.run.descriptors();
        let callers = descriptors.iter().enumerate().flat_map(|(caller, it)| {
            callers(it, &descriptors[index]).map(move |reference| (caller, reference))
        });
        let callers = callers.collect();
        let descriptor = &mut self.run.descriptors_mut()[index];
        let vacant = ComponentUnit::vacant(index).descriptor(descriptor.thread);
        let descriptor = std::mem::replace(descriptor, vacant);
        self.removals.push(RemovedComponent {
            index,
            descriptor,
            callers,
        });
        self.undo_steps.push(UndoStep::Unremove);
        Ok(())
    }

    fn leave_topics(&mut self, component: usize) {
        self.save_topics();
        for topic in self.topics() {
            topic.publishers.retain(|end| end.unit != component);
            topic.subscribers.retain(|(end, _)| end.unit != component);
        }
        let (connections, _) = self.run.connections();
        let left =
            connections.remove_by_topic(|_, from, to| [from.unit, to.unit].contains(&component));
        for connection in left {
            self.end_connection(connection);
        }
    }

    /// Checks that no other component needs those to be removed.
    pub(super) fn check_removals(&mut self) -> Result<(), ChangeError> {
        let removed: BTreeSet<usize> = self.removals.iter().map(|it| it.index).collect();
        let (connections, descriptors) = self.run.connections();
        for RemovedComponent {
            index,
            descriptor,
            callers,
        } in &self.removals
        {
            let neighbours = connections.neighbours(*index);
            let neighbours = neighbours.filter(|end| !removed.contains(&end.unit));
            let mut users: BTreeSet<String> = neighbours.map(|end| end.name.clone()).collect();
            let callers = callers.iter().filter(|(it, _)| !removed.contains(it));
            users.extend(callers.map(|(_, reference)| reference.clone()));
            for other in descriptors {
                if other.master == Some(*index) {
                    users.insert(other.name.to_string());
                }
            }
            if !users.is_empty() {
                let users: Vec<_> = users.iter().map(|user| format!("`{user}`")).collect();
                return Err(ChangeError::Removal {
                    component: descriptor.name.to_string(),
                    reason: format!("{} would lose it", users.join(", ")),
                });
            }
        }
        Ok(())
    }

    /// Returns whether the component at this position is to be removed.
    pub(super) fn is_removed(&self, component: usize) -> bool {
        self.removals.iter().any(|it| it.index == component)
    }

    /// Stops the removed components, slaves first, with a last cycle, whose samples still leave. Those that pass on the last
    /// samples of others stop after these.
    pub(super) fn stop_removals(&mut self) {
        let is_last = |it: &RemovedComponent| it.descriptor.awaited_writers != AwaitedWriters::None;
        self.removals
            .sort_by_key(|it| (is_last(it), it.descriptor.master.is_none()));
        let waits = self.removals.iter().any(is_last);
        let patience = self.run.change_timeout();
        for RemovedComponent {
            index, descriptor, ..
        } in &self.removals
        {
            descriptor.allow_interrupt(Transition::Stop);
            if waits {
                // one that is late is removed later
                let _ = self.run.run_on(*index, patience, |unit, now, effects| {
                    unit.remove(now, effects);
                });
            } else {
                let act: Act = Box::new(|unit, now, effects| unit.remove(now, effects));
                self.run.submit(*index, act);
            }
        }
    }

    /// Drops the removed components.
    pub(super) fn vacate_removals(&mut self) {
        for RemovedComponent { index, .. } in std::mem::take(&mut self.removals) {
            let (connections, _) = self.run.connections();
            connections.forget_component(index);
            self.run.injections_mut().close(index);
            self.run.vacate(index);
        }
    }
}

/// The references of a component that are wired to services of another one.
fn callers<'d>(
    component: &'d ComponentDescriptor,
    provider: &'d ComponentDescriptor,
) -> impl Iterator<Item = String> {
    let services = &provider.declaration.services;
    let is_service = |to: &str| {
        let service = to
            .rsplit_once('.')
            .filter(|(name, _)| **name == *provider.name);
        service.is_some_and(|(_, service)| services.iter().any(|it| it.name == service))
    };
    let references = component.declaration.references.iter();
    let wired = references.zip(&component.wired);
    wired
        .filter(move |(_, wired)| wired.iter().any(|(to, _)| is_service(to)))
        .map(|(reference, _)| format!("{}.{}", component.name, reference.name))
}
