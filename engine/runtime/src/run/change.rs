//! Changes of a running system, all or none. All changes are checked first; then they are made, each component's
//! between two of its cycles.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use asmotion_component::Wire;
use asmotion_datum::Datum;
use asmotion_port::{ConnectionId, Policy};

use super::addition::{ComponentAddition, StagedComponent};
use super::executor::{Act, Executor, busy, connect_output};
use super::removal::RemovedComponent;
use super::replacement::Replacement;
use crate::added_ports::{AddedPorts, FormerPorts};
use crate::build_error::BuildError;
use crate::component_end::{ComponentEnd, inputs, outputs, references, services};
use crate::connections::{HeldEnd, RemovedConnection};
use crate::injection::InjectionPort;
use crate::outer_end::OuterEnd;
use crate::run_error::RunError;
use crate::service::Wiring;
use crate::system::operation_indices;
use crate::topic::SystemTopic;

/// A change of a running system.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    /// Connects an output to an input.
    Connect {
        /// The output, as `component.port`.
        from: String,
        /// The input, as `component.port`.
        to: String,
        /// Policy of the new connection.
        policy: Policy,
    },
    /// Removes the connection of an output and an input.
    Disconnect {
        /// The output, as `component.port`.
        from: String,
        /// The input, as `component.port`.
        to: String,
    },
    /// Wires a reference to a service, or a one-way reference to another service.
    Wire {
        /// The reference, as `component.reference`.
        reference: String,
        /// The service, as `component.service`.
        service: String,
        /// Timeout, retries and direction of the calls.
        wire: Wire,
    },
    /// Removes a service from a reference; calls under way end as unavailable.
    Unwire {
        /// The reference, as `component.reference`.
        reference: String,
        /// The service, as `component.service`.
        service: String,
    },
    /// Sets properties of a component.
    Set {
        /// Name of the component.
        component: String,
        /// Names and new values of the properties.
        values: Vec<(String, Datum)>,
    },
    /// Changes the period of a component; zero makes it event-driven.
    SetPeriod {
        /// Name of the component.
        component: String,
        /// The new period.
        period: Duration,
    },
    /// Publishes an output on a topic, to all its subscribers. An output publishes on one topic at most.
    Publish {
        /// The output, as `component.port`.
        output: String,
        /// Name of the topic.
        topic: String,
    },
    /// Takes an output off its topic.
    Unpublish {
        /// The output, as `component.port`.
        output: String,
        /// Name of the topic.
        topic: String,
    },
    /// Subscribes an input to a topic, with all its publishers.
    Subscribe {
        /// The input, as `component.port`.
        input: String,
        /// Name of the topic.
        topic: String,
        /// Policy of the connection of each publisher.
        policy: Policy,
    },
    /// Ends the subscription of an input.
    Unsubscribe {
        /// The input, as `component.port`.
        input: String,
        /// Name of the topic.
        topic: String,
    },
    /// Replaces a component by another one, which continues in its state
    /// ([`take_over`](asmotion_component::Component::take_over)); one that is not configured begins anew. Their declarations are the
    /// same, except that the new one can have more ports and references, and call more operations; later changes of the list
    /// connect and wire them. What it does not have stays, without a use. An operation that it calls in addition through a
    /// reference with a service reaches the service once later changes of the list have wired the reference again.
    Replace {
        /// Name of the component.
        component: String,
        /// The new component.
        by: Replacement,
    },
    /// Stops a component with a last cycle, cleans it up and removes it. Impossible while connections or slaves of others need
    /// it after all changes of the same list, or references of others are wired to it. It leaves its topics, and its name is
    /// free again.
    Remove {
        /// Name of the component.
        component: String,
    },
    /// Adds a component. It is configured and, if it runs on startup, started before anything else is changed; if that
    /// fails, nothing is. The changes that follow in the list can connect and wire it.
    Add {
        /// Name of the component.
        component: String,
        /// The new component.
        by: ComponentAddition,
    },
    /// Joins an end of a component to the outside, such as a topic of a bus.
    Join(OuterEnd),
    /// Parts an end of a component from the outside. Calls under way end as unavailable.
    Part(OuterEnd),
}

/// The reason that a running system could not be changed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ChangeError {
    /// The changed system would be inconsistent.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A component refuses the change, or is busy.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A component cannot be replaced.
    #[error("`{component}` cannot be replaced: {reason}")]
    Replacement {
        /// Name of the component.
        component: String,
        /// The reason of the new component.
        reason: String,
    },
    /// A component cannot be added.
    #[error("`{component}` cannot be added: {reason}")]
    Addition {
        /// Name of the component.
        component: String,
        /// Human-readable reason.
        reason: String,
    },
    /// An end cannot be joined to the outside.
    #[error("`{end}` cannot be joined to {outside}: {reason}")]
    Joining {
        /// The end in the system, as `component.port`.
        end: String,
        /// Name of the end outside.
        outside: String,
        /// Human-readable reason.
        reason: String,
    },
    /// A component cannot be removed.
    #[error("`{component}` cannot be removed: {reason}")]
    Removal {
        /// Name of the component.
        component: String,
        /// Human-readable reason.
        reason: String,
    },
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connect { from, to, .. } => write!(f, "`{from}` is connected to `{to}`"),
            Self::Disconnect { from, to } => write!(f, "`{from}` is disconnected from `{to}`"),
            Self::Wire {
                reference, service, ..
            } => write!(f, "`{reference}` is wired to `{service}`"),
            Self::Unwire { reference, service } => {
                write!(f, "`{reference}` is unwired from `{service}`")
            }
            Self::Set { component, values } => {
                let values = values.iter();
                let values: Vec<_> = values
                    .map(|(name, value)| format!("{name} = {value}"))
                    .collect();
                write!(f, "`{component}` has {}", values.join(", "))
            }
            Self::SetPeriod { component, period } if period.is_zero() => {
                write!(f, "`{component}` is event-driven")
            }
            Self::SetPeriod { component, period } => {
                write!(f, "`{component}` cycles every {period:?}")
            }
            Self::Publish { output, topic } => {
                write!(f, "`{output}` is published on topic `{topic}`")
            }
            Self::Unpublish { output, topic } => {
                write!(f, "`{output}` is no longer published on topic `{topic}`")
            }
            Self::Subscribe { input, topic, .. } => {
                write!(f, "`{input}` subscribes to topic `{topic}`")
            }
            Self::Unsubscribe { input, topic } => {
                write!(f, "`{input}` no longer subscribes to topic `{topic}`")
            }
            Self::Replace { component, by } => write!(f, "`{component}` runs {}", by),
            Self::Remove { component } => write!(f, "`{component}` is removed"),
            Self::Add { component, by } => write!(f, "`{component}` is added and runs {by}"),
            Self::Join(outer) => write!(f, "{outer}"),
            Self::Part(outer) => outer.write_parted(f),
        }
    }
}

/// The checked changes, none of which has reached a component yet.
pub(super) struct ChangePlan<'r, E: Executor> {
    pub(super) run: &'r mut E,
    /// First phase: inputs get new connections, so that every sample written afterwards has a reader.
    pub(super) attach_steps: Vec<(usize, Act)>,
    /// Second phase: everything else.
    pub(super) update_steps: Vec<(usize, Act)>,
    /// Last phase: inputs lose connections, which no writer uses any more by then.
    pub(super) detach_steps: Vec<DetachStep>,
    /// Steps that restore the tables of the executor if a later change is impossible.
    pub(super) undo_steps: Vec<UndoStep>,
    /// Replacements, in order, applied before everything else.
    pub(super) replacements: Vec<(usize, Replacement)>,
    /// New components, in order, which no other component uses before all changes are made.
    pub(super) additions: Vec<StagedComponent>,
    /// Components to be removed, whose positions are vacant already.
    pub(super) removals: Vec<RemovedComponent>,
    /// Ends to be joined to the outside, where nothing has been opened yet.
    pub(super) joined: Vec<(ComponentEnd, OuterEnd)>,
    /// Ends to be parted, each with its name outside.
    pub(super) parted: Vec<(ComponentEnd, String)>,
    /// What has been opened outside for this change.
    pub(super) opened: Vec<HeldEnd>,
    /// Ports that replacements have in addition, by component.
    pub(super) extensions: Vec<(usize, AddedPorts)>,
    /// Connections from outside into new inputs of running components.
    pub(super) injections: Vec<InjectionPort>,
    /// Connections from outside into running components by a topic.
    pub(super) topic_injections: Vec<(String, InjectionPort)>,
    /// Topics and the names of the inputs that no longer subscribe to them.
    pub(super) unsubscribed: Vec<(String, String)>,
}

/// Removes a connection from an input.
pub(super) struct DetachStep {
    pub(super) reader: usize,
    /// The writer, if the connection has a queue of its own. If the writer is removed, its last samples still arrive: the
    /// input drops the connection once it has read them.
    pub(super) writer: Option<usize>,
    pub(super) act: Act,
}

/// A change of the executor's tables that is to be undone if a later change is impossible.
pub(super) enum UndoStep {
    Forget(ComponentEnd, ComponentEnd),
    ForgetByTopic(ConnectionId),
    Restore(RemovedConnection),
    /// The services of a reference: component, reference, and what they were.
    Rewire(usize, usize, Vec<(String, Wire)>),
    Topics(Vec<SystemTopic>),
    /// Removes the ports and references that a component was to get.
    Unextend(usize, FormerPorts),
    /// Removes the last addition.
    Unadd,
    /// Puts the last removed component back.
    Unremove,
}

impl<'r, E: Executor> ChangePlan<'r, E> {
    pub(super) fn new(run: &'r mut E) -> Self {
        Self {
            run,
            attach_steps: Vec::new(),
            update_steps: Vec::new(),
            detach_steps: Vec::new(),
            undo_steps: Vec::new(),
            replacements: Vec::new(),
            additions: Vec::new(),
            removals: Vec::new(),
            joined: Vec::new(),
            parted: Vec::new(),
            opened: Vec::new(),
            extensions: Vec::new(),
            injections: Vec::new(),
            topic_injections: Vec::new(),
            unsubscribed: Vec::new(),
        }
    }

    /// Makes all of these changes, or none of them. Returns the notes of the new components.
    pub(super) fn apply(mut self, changes: &[Change]) -> Result<Vec<String>, ChangeError> {
        let planned = self.plan_all(changes);
        let opened = planned.and_then(|()| self.open_outside());
        let prepared = opened.and_then(|()| self.prepare_additions());
        match prepared.and_then(|()| self.replace_all()) {
            Ok(notes) => {
                self.commit();
                Ok(notes)
            }
            Err(error) => {
                self.abandon_additions();
                self.roll_back();
                Err(error)
            }
        }
    }

    /// Checks whether these changes are possible now. Returns the notes of the new components.
    pub(super) fn check(mut self, changes: &[Change]) -> Result<Vec<String>, ChangeError> {
        let planned = self.plan_all(changes);
        let checked = planned.and_then(|()| self.check_replacements());
        self.roll_back();
        checked
    }

    fn plan_all(&mut self, changes: &[Change]) -> Result<(), ChangeError> {
        changes.iter().try_for_each(|change| self.plan(change))?;
        self.check_removals()
    }

    fn plan(&mut self, change: &Change) -> Result<(), ChangeError> {
        match change {
            Change::Connect { from, to, policy } => Ok(self.connect(from, to, policy)?),
            Change::Disconnect { from, to } => Ok(self.disconnect(from, to)?),
            Change::Wire {
                reference,
                service,
                wire,
            } => self.wire(reference, service, *wire),
            Change::Unwire { reference, service } => self.unwire(reference, service),
            Change::Set { component, values } => Ok(self.set(component, values)?),
            Change::SetPeriod { component, period } => {
                let (index, period) = (self.run.index_of(component)?, *period);
                let act: Act = Box::new(move |unit, _, _| unit.set_period(period));
                self.update_steps.push((index, act));
                Ok(())
            }
            Change::Publish { output, topic } => {
                let output = self.run.end(output, outputs)?;
                self.publish(output, topic)
            }
            Change::Unpublish { output, topic } => {
                let output = self.run.end(output, outputs)?;
                Ok(self.unpublish(&output, topic)?)
            }
            Change::Subscribe {
                input,
                topic,
                policy,
            } => {
                let input = self.run.end(input, inputs)?;
                self.subscribe(topic, input, policy)
            }
            Change::Unsubscribe { input, topic } => {
                let input = self.run.end(input, inputs)?;
                Ok(self.unsubscribe(&input, topic)?)
            }
            Change::Replace { component, by } => self.replacement(component, by),
            Change::Remove { component } => self.remove(component),
            Change::Add { component, by } => self.add(component, by),
            Change::Join(outer) => self.join(outer),
            Change::Part(outer) => self.part(outer),
        }
    }

    /// Plans a new connection.
    pub(super) fn connect(
        &mut self,
        from: &str,
        to: &str,
        policy: &Policy,
    ) -> Result<(), BuildError> {
        let (from, to) = (self.run.end(from, outputs)?, self.run.end(to, inputs)?);
        let (connections, _) = self.run.connections();
        connections.check_unconnected(&from, &to)?;
        let connection = self.open_connection(&from, &to, policy)?;
        let (connections, _) = self.run.connections();
        connections.insert(connection, from.clone(), to.clone());
        self.undo_steps.push(UndoStep::Forget(from, to));
        Ok(())
    }

    /// Plans a connection of a publisher to a subscriber of a topic, unless an adapter connects them.
    pub(super) fn connect_by_topic(
        &mut self,
        from: &ComponentEnd,
        to: &ComponentEnd,
        policy: &Policy,
    ) -> Result<(), BuildError> {
        let (connections, _) = self.run.connections();
        if connections.topics_outside {
            return self.compare(from, to);
        }
        let connection = self.open_connection(from, to, policy)?;
        let (connections, _) = self.run.connections();
        connections.insert_by_topic(connection, from.clone(), to.clone());
        self.undo_steps.push(UndoStep::ForgetByTopic(connection));
        Ok(())
    }

    /// Opens a connection that is not in the table yet, and plans how its ends are joined to their ports.
    fn open_connection(
        &mut self,
        from: &ComponentEnd,
        to: &ComponentEnd,
        policy: &Policy,
    ) -> Result<ConnectionId, BuildError> {
        self.compare(from, to)?;
        let (connections, descriptors) = self.run.connections();
        let [writer, reader] = [&descriptors[from.unit], &descriptors[to.unit]];
        let threads = [writer.thread, reader.thread];
        let opener = &reader.openers[to.index];
        let connection = connections.open((from, to), threads, policy, &**opener)?;
        let (input, reading_end) = (to.index, connection.reading_end);
        let act: Act = Box::new(move |unit, _, _| unit.body.inputs[input].connect(reading_end));
        self.attach_steps.push((to.unit, act));
        let end = (from.index, connection.connection);
        let act = connect_output(end, connection.sender, connection.link, policy.init);
        self.update_steps.push((from.unit, act));
        Ok(connection.connection)
    }

    /// Compares the types of an output and an input.
    fn compare(&self, from: &ComponentEnd, to: &ComponentEnd) -> Result<(), BuildError> {
        let descriptors = self.run.descriptors();
        let written = &descriptors[from.unit].declaration.outputs[from.index].schema;
        let taken = &descriptors[to.unit].declaration.inputs[to.index].schema;
        BuildError::compare(written, &from.name, taken, &to.name)
    }

    /// Plans the removal of a connection.
    pub(super) fn disconnect(&mut self, from: &str, to: &str) -> Result<(), BuildError> {
        let (from, to) = (self.run.end(from, outputs)?, self.run.end(to, inputs)?);
        let (connections, _) = self.run.connections();
        let Some(removed) = connections.remove(&from, &to) else {
            return Err(BuildError::NotConnected {
                from: from.name,
                to: to.name,
            });
        };
        self.end_connection(removed);
        Ok(())
    }

    /// Plans how a connection that is no longer in the table is removed from its ports.
    pub(super) fn end_connection(&mut self, removed: RemovedConnection) {
        let connection = removed.connection();
        let (from, to) = removed.ends();
        let (output, input) = (from.index, to.index);
        let act: Act = Box::new(move |unit, _, _| unit.body.outputs[output].disconnect(connection));
        self.update_steps.push((from.unit, act));
        self.detach_steps.push(DetachStep {
            reader: to.unit,
            writer: (!removed.is_shared()).then_some(from.unit),
            act: Box::new(move |unit, _, _| unit.body.inputs[input].disconnect(connection)),
        });
        self.undo_steps.push(UndoStep::Restore(removed));
    }

    fn wire(&mut self, reference: &str, service: &str, wire: Wire) -> Result<(), ChangeError> {
        let from = self.run.end(reference, references)?;
        let to = self.run.end(service, services)?;
        self.add_wire(&from, &to.name, wire)?;
        let descriptors = self.run.descriptors();
        let required = &descriptors[from.unit].declaration.references[from.index];
        let provided = &descriptors[to.unit].declaration.services[to.index];
        let wiring = Wiring {
            operations: operation_indices((required, &from), (provided, &to))?,
            queue: Arc::clone(&descriptors[to.unit].queues[to.index]),
            to: to.name,
            provider: Some(to.unit),
            wire,
        };
        let index = from.index;
        let act: Act = Box::new(move |unit, _, _| unit.body.references[index].add(wiring));
        self.update_steps.push((from.unit, act));
        Ok(())
    }

    /// Records a service of a reference, if the reference can have it too.
    pub(super) fn add_wire(
        &mut self,
        from: &ComponentEnd,
        to: &str,
        wire: Wire,
    ) -> Result<(), BuildError> {
        let wires = self.wires(from);
        let in_the_way = |(name, other): &&(String, Wire)| {
            let are_told = other.one_way && wire.one_way;
            name == to || other.alternative == wire.alternative && !are_told
        };
        if let Some((taken, _)) = wires.iter().find(in_the_way) {
            let (end, to) = (from.name.clone(), format!("`{taken}`"));
            return Err(BuildError::AlreadyConnected { end, to });
        }
        wires.push((to.to_owned(), wire));
        Ok(())
    }

    pub(super) fn unwire(&mut self, reference: &str, service: &str) -> Result<(), ChangeError> {
        let from = self.run.end(reference, references)?;
        let wires = self.wires(&from);
        let Some(index) = wires.iter().position(|(name, _)| name == service) else {
            let (from, to) = (from.name, service.to_owned());
            return Err(BuildError::NotConnected { from, to }.into());
        };
        wires.remove(index);
        let (index, service) = (from.index, service.to_owned());
        let act: Act = Box::new(move |unit, now, effects| {
            unit.unwire(index, &service, now, effects);
        });
        self.update_steps.push((from.unit, act));
        Ok(())
    }

    /// The services of a reference, including the changes planned so far.
    fn wires(&mut self, from: &ComponentEnd) -> &mut Vec<(String, Wire)> {
        let wired = &mut self.run.descriptors_mut()[from.unit].wired[from.index];
        let before = UndoStep::Rewire(from.unit, from.index, wired.clone());
        self.undo_steps.push(before);
        wired
    }

    fn set(&mut self, component: &str, values: &[(String, Datum)]) -> Result<(), RunError> {
        let (index, patience) = (self.run.index_of(component)?, self.run.change_timeout());
        let (values, tried) = (values.to_vec(), values.to_vec());
        if let Some(staged) = self.staged(index) {
            staged.unit.body.check(component, &tried)?;
        } else {
            let result = self.run.run_on(index, patience, move |unit, _, _| {
                unit.body.check(&unit.name, &tried)
            });
            result.ok_or_else(|| busy(component))??;
        }
        let act: Act = Box::new(move |unit, now, effects| {
            // cannot fail: the values were checked when the change was planned, and declarations do not change
            let _ = unit.set_properties(&values, now, effects);
        });
        self.update_steps.push((index, act));
        Ok(())
    }

    /// Makes the changes phase by phase; within a phase, all changes of a component between the same two cycles.
    pub(super) fn commit(mut self) {
        let attach_steps = std::mem::take(&mut self.attach_steps);
        self.submit_all(attach_steps);
        let update_steps = std::mem::take(&mut self.update_steps);
        self.submit_all(update_steps);
        self.close_outside();
        self.stop_removals();
        let mut detach_steps = std::mem::take(&mut self.detach_steps);
        detach_steps.retain(|step| !step.writer.is_some_and(|writer| self.is_removed(writer)));
        let detach_steps = detach_steps.into_iter().map(|step| (step.reader, step.act));
        self.submit_all(detach_steps.collect());
        self.vacate_removals();
        self.adopt_additions();
        self.follow_injections();
        self.begin_outside();
    }

    /// Submits the steps of each component together; those of components that are removed have no effect.
    fn submit_all(&mut self, steps: Vec<(usize, Act)>) {
        let mut each: BTreeMap<usize, Vec<Act>> = BTreeMap::new();
        for (unit, act) in steps {
            if !self.is_removed(unit) {
                each.entry(unit).or_default().push(act);
            }
        }
        for (unit, acts) in each {
            let all: Act = Box::new(move |unit, now, effects| {
                acts.into_iter().for_each(|act| act(unit, now, effects));
            });
            self.run.submit(unit, all);
        }
    }

    /// Restores the tables of the executor. No component that runs has been changed yet.
    fn roll_back(mut self) {
        for undo in std::mem::take(&mut self.undo_steps).into_iter().rev() {
            let (connections, _) = self.run.connections();
            match undo {
                UndoStep::Forget(from, to) => drop(connections.remove(&from, &to)),
                UndoStep::ForgetByTopic(connection) => {
                    drop(connections.remove_by_topic(|known, _, _| known == connection));
                }
                UndoStep::Restore(removed) => connections.reinsert(removed),
                UndoStep::Topics(before) => connections.topics = before,
                UndoStep::Unextend(component, former) => {
                    let descriptor = &mut self.run.descriptors_mut()[component];
                    former.restore(Arc::make_mut(&mut descriptor.declaration));
                    descriptor.openers.truncate(former.inputs);
                    descriptor.wired.truncate(former.references.len());
                }
                UndoStep::Rewire(unit, reference, before) => {
                    self.run.descriptors_mut()[unit].wired[reference] = before;
                }
                UndoStep::Unadd => drop(self.run.descriptors_mut().pop()),
                UndoStep::Unremove => {
                    if let Some(RemovedComponent {
                        index, descriptor, ..
                    }) = self.removals.pop()
                    {
                        self.run.descriptors_mut()[index] = descriptor;
                    }
                }
            }
        }
    }
}
