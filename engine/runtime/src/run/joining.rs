//! Ends of a running system that are joined to the outside, or parted from it.
//!
//! Everything outside is opened after a list of changes has been checked, and before a component changes. Messages from outside
//! wait there until all changes have been made.

use std::sync::Arc;

use asmotion_port::{AnySender, ConnectionId, OutputLink, Policy, ReadingEnd};

use super::change::{ChangeError, ChangePlan, DetachStep};
use super::executor::{Act, Executor};
use crate::component_end::{ComponentEnd, inputs, outputs, references, services};
use crate::connections::HeldEnd;
use crate::injection::InjectionPort;
use crate::opened_end::OpenedEnd;
use crate::outer_end::{OuterEnd, OuterInput, OuterOpener, OuterOutput, OuterService};
use crate::service::Wiring;

impl<E: Executor> ChangePlan<'_, E> {
    /// Plans that an end is joined to the outside.
    pub(super) fn join(&mut self, outer: &OuterEnd) -> Result<(), ChangeError> {
        let end = self.outer_end(outer)?;
        if let OuterOpener::Reference { wire, .. } = &outer.opener {
            self.add_wire(&end, &outer.outside, *wire)?;
        }
        self.joined.push((end, outer.clone()));
        Ok(())
    }

    /// Plans that an end is parted from the outside.
    pub(super) fn part(&mut self, outer: &OuterEnd) -> Result<(), ChangeError> {
        let end = self.outer_end(outer)?;
        match &outer.opener {
            OuterOpener::Output { .. } => {
                let (index, to) = (end.index, outer.outside.clone());
                let act: Act =
                    Box::new(move |unit, _, _| unit.body.outputs[index].disconnect_outside(&to));
                self.update_steps.push((end.unit, act));
            }
            OuterOpener::Input { .. } => {
                let (connections, _) = self.run.connections();
                let held = connections.outer_end(&end, &outer.outside);
                let Some(connection) = held.and_then(|it| it.connection) else {
                    return Err(not_joined(outer));
                };
                let index = end.index;
                self.detach_steps.push(DetachStep {
                    reader: end.unit,
                    writer: None,
                    act: Box::new(move |unit, _, _| unit.body.inputs[index].disconnect(connection)),
                });
                self.parted.push((end, outer.outside.clone()));
            }
            OuterOpener::Service(_) => self.parted.push((end, outer.outside.clone())),
            OuterOpener::Reference { .. } => self.unwire(&outer.end, &outer.outside)?,
        }
        Ok(())
    }

    /// The end of the component.
    fn outer_end(&self, outer: &OuterEnd) -> Result<ComponentEnd, ChangeError> {
        let table = match &outer.opener {
            OuterOpener::Output { .. } => outputs,
            OuterOpener::Input { .. } => inputs,
            OuterOpener::Service(_) => services,
            OuterOpener::Reference { .. } => references,
        };
        Ok(self.run.end(&outer.end, table)?)
    }

    /// Opens the planned ends outside, and plans how they are connected to those of the components.
    pub(super) fn open_outside(&mut self) -> Result<(), ChangeError> {
        for (end, outer) in std::mem::take(&mut self.joined) {
            if let Err(reason) = self.open(&end, &outer) {
                let (component, _) = crate::component_end::split(&end.name);
                let (component, outside) = (component.to_owned(), outer.outside);
                return Err(if self.staged(end.unit).is_some() {
                    ChangeError::Addition { component, reason }
                } else {
                    let end = end.name;
                    ChangeError::Joining {
                        end,
                        outside,
                        reason,
                    }
                });
            }
        }
        Ok(())
    }

    fn open(&mut self, end: &ComponentEnd, outer: &OuterEnd) -> Result<(), String> {
        match &outer.opener {
            OuterOpener::Output { init, open } => {
                let descriptor = &self.run.descriptors()[end.unit];
                let sender = open(OuterOutput {
                    schema: &descriptor.declaration.outputs[end.index].schema,
                    cause: Arc::clone(&descriptor.cause),
                })?;
                self.connect_outside(end, (sender, outer.outside.clone()), *init);
            }
            OuterOpener::Input { policy, open } => {
                let (port, reading_end) = self.injection(end, policy)?;
                let connection = port.connection();
                let descriptor = &self.run.descriptors()[end.unit];
                let opened = open(OuterInput {
                    port,
                    schema: &descriptor.declaration.inputs[end.index].schema,
                    cause: Arc::clone(&descriptor.cause),
                })?;
                self.hold(end, outer, Some(connection), opened);
                let index = end.index;
                let act: Act =
                    Box::new(move |unit, _, _| unit.body.inputs[index].connect(reading_end));
                self.attach_steps.push((end.unit, act));
            }
            OuterOpener::Service(open) => {
                let descriptor = &self.run.descriptors()[end.unit];
                let opened = open(OuterService {
                    provider: end.unit,
                    declaration: &descriptor.declaration.services[end.index],
                    queue: Arc::clone(&descriptor.queues[end.index]),
                })?;
                self.hold(end, outer, None, opened);
            }
            OuterOpener::Reference { wire, open } => {
                let descriptor = &self.run.descriptors()[end.unit];
                let declaration = &descriptor.declaration.references[end.index];
                let wiring = Wiring {
                    queue: open(declaration)?,
                    to: outer.outside.clone(),
                    provider: None,
                    operations: (0..declaration.operations.len()).collect(),
                    wire: *wire,
                };
                let index = end.index;
                let act: Act = Box::new(move |unit, _, _| unit.body.references[index].add(wiring));
                self.update_steps.push((end.unit, act));
            }
        }
        Ok(())
    }

    /// Plans that an output sends its samples outside, too; with `init`, the newest one at once.
    fn connect_outside(
        &mut self,
        end: &ComponentEnd,
        (sender, outside): (Box<dyn AnySender>, String),
        init: bool,
    ) {
        let index = end.index;
        let act: Act = Box::new(move |unit, _, _| {
            let output = &mut unit.body.outputs[index];
            output.connect(sender, OutputLink::external(outside.clone()));
            if init {
                output.replay_outside(&outside);
            }
        });
        self.update_steps.push((end.unit, act));
    }

    /// Opens a connection from outside into an input, which its component's thread connects.
    pub(super) fn injection(
        &mut self,
        end: &ComponentEnd,
        policy: &Policy,
    ) -> Result<(InjectionPort, ReadingEnd), String> {
        let (connections, descriptors) = self.run.connections();
        let descriptor = &descriptors[end.unit];
        let expected = descriptor.declaration.inputs[end.index].schema.to_string();
        let opener = &*descriptor.openers[end.index];
        let opened = InjectionPort::opened(end, expected, policy, connections.next_id(), opener);
        let reason = "its type has no zeros, which `on_stale = \"zero\"` asks for";
        opened.ok_or_else(|| reason.to_owned())
    }

    fn hold(
        &mut self,
        end: &ComponentEnd,
        outer: &OuterEnd,
        connection: Option<ConnectionId>,
        opened: Box<dyn OpenedEnd>,
    ) {
        self.opened.push(HeldEnd {
            end: end.clone(),
            outside: outer.outside.clone(),
            connection,
            opened,
        });
    }

    /// Closes what is held outside for removed components and parted ends.
    pub(super) fn close_outside(&mut self) {
        let removed: Vec<usize> = self.removals.iter().map(|it| it.index).collect();
        let parted = std::mem::take(&mut self.parted);
        let (connections, _) = self.run.connections();
        connections.outer_ends.retain(|held| {
            let is_parted = |(end, outside): &(ComponentEnd, String)| {
                held.end == *end && held.outside == *outside
            };
            !removed.contains(&held.end.unit) && !parted.iter().any(is_parted)
        });
    }

    /// Lets messages from outside pass through the new ends.
    pub(super) fn begin_outside(&mut self) {
        let mut opened = std::mem::take(&mut self.opened);
        opened.iter_mut().for_each(|held| held.opened.begin());
        let (connections, _) = self.run.connections();
        connections.outer_ends.extend(opened);
    }
}

fn not_joined(outer: &OuterEnd) -> ChangeError {
    ChangeError::Joining {
        end: outer.end.clone(),
        outside: outer.outside.clone(),
        reason: "it was not joined to it".to_owned(),
    }
}
