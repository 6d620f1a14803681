//! Implements [`Run`] for every executor.

use std::marker::PhantomData;
use std::sync::atomic::Ordering;
use std::sync::{Arc, mpsc};
use std::time::Duration;

use asmotion_component::{
    CallError, Declaration, Fault, LifeCycleError, Losses, Operation, SendStatus, State, ThreadUse,
    Transition,
};
use asmotion_datum::{Datum, Message, Sample};
use asmotion_port::{AnyInput, InputPort, OpenError, OutputLink, Policy, PortSender, Time};

use super::Run;
use super::asked::Asked;
use super::call::SentCall;
use super::change::{Change, ChangeError, ChangePlan};
use super::executor::{Act, Executor, Watch, busy, connect_output};
use super::reader::PortReader;
use super::writer::PortWriter;
use crate::build_error::BuildError;
use crate::component_end::{inputs, outputs, services};
use crate::connections::open_error;
use crate::descriptor::{ComponentDescriptor, CycleTime};
use crate::effects::NoEffects;
use crate::event::{Event, ReportInterest};
use crate::run_error::RunError;
use crate::service::{CallKey, ReplyTo, ServiceRequest};

impl<E: Executor> Run for E {
    fn now(&self) -> Time {
        self.clock()
    }

    fn run_until(&mut self, until: Time) {
        self.advance(until, None);
    }

    fn run_until_event_among(
        &mut self,
        limit: Time,
        reports: ReportInterest,
        predicate: &mut dyn FnMut(Time, &Event<'_>) -> bool,
    ) -> bool {
        let watch = Watch { reports, predicate };
        self.advance(limit, Some(watch))
    }

    fn inject_sample(
        &mut self,
        at: Time,
        port: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError> {
        let target = self.injections().port(port, &sample)?;
        self.schedule_injection(at, target, sample);
        Ok(())
    }

    fn publish_sample(
        &mut self,
        at: Time,
        topic: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError> {
        let target = self.injections().topic(topic, &sample)?;
        self.schedule_injection(at, target, sample);
        Ok(())
    }

    fn connect(&mut self, from: &str, to: &str, policy: Policy) -> Result<(), BuildError> {
        let mut planning = ChangePlan::new(self);
        planning.connect(from, to, &policy)?;
        planning.commit();
        Ok(())
    }

    fn disconnect(&mut self, from: &str, to: &str) -> Result<(), BuildError> {
        let mut planning = ChangePlan::new(self);
        planning.disconnect(from, to)?;
        planning.commit();
        Ok(())
    }

    fn change(&mut self, changes: &[Change]) -> Result<Vec<String>, ChangeError> {
        ChangePlan::new(self).apply(changes)
    }

    fn check_change(&mut self, changes: &[Change]) -> Result<Vec<String>, ChangeError> {
        ChangePlan::new(self).check(changes)
    }

    fn writer<T: Message>(
        &mut self,
        port: &str,
        policy: Policy,
    ) -> Result<PortWriter<T>, BuildError> {
        let to = self.end(port, inputs)?;
        let (connections, descriptors) = self.connections();
        let descriptor = &descriptors[to.unit];
        let taken = &descriptor.declaration.inputs[to.index].schema;
        BuildError::compare(T::schema(), "the writer", taken, &to.name)?;
        let policy = policy.for_external();
        let opened = descriptor.openers[to.index].open(connections.next_id(), &policy, None);
        let (sender, end) = opened.map_err(|error| open_error(error, "the writer", &to.name))?;
        let losses = descriptor.openers[to.index].losses();
        let input = to.index;
        let act: Act = Box::new(move |unit, _, _| unit.body.inputs[input].connect(end));
        self.submit(to.unit, act);
        let sender = PortSender::of(sender)
            .ok_or_else(|| open_error(OpenError::TypeMismatch, "the writer", port))?;
        Ok(PortWriter {
            port: to.name,
            sender,
            trigger: policy.trigger.then_some(to.unit),
            mandatory: policy.mandatory,
            dropped: 0,
            losses,
            handle: self.handle(),
        })
    }

    fn reader<T: Message>(
        &mut self,
        port: &str,
        policy: Policy,
    ) -> Result<PortReader<T>, BuildError> {
        let from = self.end(port, outputs)?;
        let (connections, descriptors) = self.connections();
        let written = &descriptors[from.unit].declaration.outputs[from.index].schema;
        BuildError::compare(written, &from.name, T::schema(), "the reader")?;
        let connection = connections.next_id();
        let mut input = InputPort::<T>::new(T::schema().clone());
        let opened = input
            .opener()
            .open(connection, &policy.for_external(), None);
        let (sender, end) = opened.map_err(|error| open_error(error, &from.name, "the reader"))?;
        input.connect(end);
        let (notifier, link) = OutputLink::external_reader(connection, &policy);
        let dropped = Arc::clone(&link.dropped);
        let act = connect_output((from.index, connection), sender, link, policy.init);
        self.submit(from.unit, act);
        Ok(PortReader {
            port: from.name,
            input,
            notifier,
            dropped,
            handle: self.handle(),
        })
    }

    fn send<O: Operation>(
        &mut self,
        service: &str,
        argument: O::Request,
        patience: Duration,
    ) -> Result<SentCall<O>, BuildError> {
        let to = self.end(service, services)?;
        let descriptor = &self.descriptors()[to.unit];
        let served = &descriptor.declaration.services[to.index].operations;
        let operation = served.iter().position(|served| served.name == O::NAME);
        let Some(operation) = operation else {
            return Err(BuildError::MissingOperation {
                from: "the caller".to_owned(),
                operation: O::NAME.to_owned(),
                to: to.name,
            });
        };
        let handle = self.handle();
        let deadline = handle.now() + patience;
        let (answer, answered) = mpsc::channel();
        let queue = Arc::clone(&descriptor.queues[to.index]);
        let unavailable = answer.clone();
        let posted = queue.send(
            ServiceRequest {
                // calls from outside are never cancelled: they have a deadline instead
                key: CallKey {
                    caller: usize::MAX,
                    number: 0,
                },
                operation,
                argument: Arc::new(argument),
                trace: None,
                awaits_provider: true,
                caller: Arc::from("outside"),
                deadline: Some(deadline),
                reply_to: Some(ReplyTo::External(answer)),
            },
            &mut NoEffects,
        );
        match posted {
            Ok(true) => handle.trigger(to.unit),
            Ok(false) => {}
            // cannot fail: the receiver is alive in this function
            Err(error) => drop(unavailable.send(Err(error))),
        }
        Ok(SentCall {
            reply: answered,
            deadline,
            handle,
            of: PhantomData,
        })
    }

    fn collect<O: Operation>(&mut self, mut sent: SentCall<O>) -> Result<O::Response, CallError> {
        loop {
            match sent.collect_if_done() {
                SendStatus::Success(response) => return Ok(response),
                SendStatus::Failure(error) => return Err(error),
                SendStatus::Unknown => return Err(CallError::Unavailable),
                SendStatus::NotReady => {
                    let mut answered =
                        |_: Time, event: &Event<'_>| matches!(event, Event::Answered { .. });
                    let watch = Watch {
                        reports: ReportInterest::NONE,
                        predicate: &mut answered,
                    };
                    self.advance(sent.deadline, Some(watch));
                }
            }
        }
    }

    fn transition(
        &mut self,
        component: &str,
        transition: Transition,
    ) -> Result<(), LifeCycleError> {
        let index = self
            .index_of(component)
            .map_err(|_| LifeCycleError::Unknown {
                component: component.to_owned(),
            })?;
        let patience = self.change_timeout();
        self.run_transition(index, transition, patience)
    }

    fn inject_fault(&mut self, component: &str, fault: Fault) -> Result<(), RunError> {
        let (index, patience) = (self.index_of(component)?, self.change_timeout());
        let failed = self.run_on(index, patience, move |unit, now, effects| {
            unit.fail(fault, now, effects);
            unit.restart_after_fault(now, effects);
        });
        failed.ok_or_else(|| busy(component))
    }

    fn trigger(&mut self, component: &str) -> Result<(), RunError> {
        let index = self.index_of(component)?;
        self.request_cycle(index);
        Ok(())
    }

    fn set_period(&mut self, component: &str, period: Duration) -> Result<(), RunError> {
        let (index, patience) = (self.index_of(component)?, self.change_timeout());
        let set = self.run_on(index, patience, move |unit, _, _| unit.set_period(period));
        set.ok_or_else(|| busy(component))
    }

    fn set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<(), RunError> {
        let (index, patience) = (self.index_of(component)?, self.change_timeout());
        let values = values.to_vec();
        let set = self.run_on(index, patience, move |unit, now, effects| {
            unit.set_properties(&values, now, effects)
        });
        Ok(set.ok_or_else(|| busy(component))??)
    }

    fn begin_transition(
        &mut self,
        component: &str,
        transition: Transition,
    ) -> Result<Asked, RunError> {
        let index = self.index_of(component)?;
        self.descriptors()[index].allow_interrupt(transition);
        Ok(self.begin_on(index, move |unit, now, effects| {
            Ok(unit.transition(transition, now, effects)?)
        }))
    }

    fn begin_set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<Asked, RunError> {
        let (index, values) = (self.index_of(component)?, values.to_vec());
        Ok(self.begin_on(index, move |unit, now, effects| {
            Ok(unit.set_properties(&values, now, effects)?)
        }))
    }

    fn components(&self) -> Vec<String> {
        let descriptors = self.descriptors().iter();
        descriptors
            .filter(|descriptor| !descriptor.is_vacant())
            .map(|descriptor| descriptor.name.to_string())
            .collect()
    }

    fn state(&self, component: &str) -> Option<State> {
        self.descriptor(component)
            .map(|descriptor| descriptor.status.state())
    }

    fn target_state(&self, component: &str) -> Option<State> {
        self.descriptor(component)
            .map(|descriptor| descriptor.status.target())
    }

    fn cycles(&self, component: &str) -> u64 {
        let descriptor = self.descriptor(component);
        descriptor.map_or(0, |descriptor| {
            descriptor.status.cycles.load(Ordering::Relaxed)
        })
    }

    fn period(&self, component: &str) -> Duration {
        let descriptor = self.descriptor(component);
        descriptor.map_or(Duration::ZERO, |descriptor| descriptor.status.period())
    }

    fn thread_use(&self, component: &str) -> Option<ThreadUse> {
        let descriptor = self.descriptor(component)?;
        self.has_threads().then_some(descriptor.thread_use)
    }

    fn overruns(&self, component: &str) -> u64 {
        let descriptor = self.descriptor(component);
        descriptor.map_or(0, |descriptor| {
            descriptor.status.overruns.load(Ordering::Relaxed)
        })
    }

    fn late(&self, component: &str) -> u64 {
        let descriptor = self.descriptor(component);
        descriptor.map_or(0, |descriptor| {
            descriptor.status.late.load(Ordering::Relaxed)
        })
    }

    fn cycle_time(&self, component: &str) -> CycleTime {
        let descriptor = self.descriptor(component);
        descriptor
            .map(|descriptor| descriptor.status.cycle_time())
            .unwrap_or_default()
    }

    fn losses(&self, component: &str) -> Losses {
        let descriptor = self.descriptor(component);
        descriptor
            .map(ComponentDescriptor::losses)
            .unwrap_or_default()
    }

    fn lost(&self, component: &str) -> Vec<u64> {
        self.descriptor(component)
            .map(|descriptor| descriptor.lost().collect())
            .unwrap_or_default()
    }

    fn refused_requests(&self, component: &str) -> Vec<u64> {
        self.descriptor(component)
            .map(|descriptor| descriptor.refused_requests().collect())
            .unwrap_or_default()
    }

    fn fault(&self, component: &str) -> Option<Fault> {
        self.descriptor(component)
            .and_then(|descriptor| descriptor.status.fault().clone())
    }

    fn declaration(&self, component: &str) -> Option<Declaration> {
        self.descriptor(component)
            .map(|descriptor| Declaration::clone(&descriptor.declaration))
    }

    fn properties(&mut self, component: &str) -> Result<Vec<(String, Datum)>, RunError> {
        let (index, patience) = (self.index_of(component)?, self.inspect_timeout());
        let values = self.run_on(index, patience, |unit, _, _| unit.body.values());
        values.ok_or_else(|| busy(component))
    }

    fn inspect(&mut self, component: &str) -> Result<Vec<(String, Datum)>, RunError> {
        let (index, patience) = (self.index_of(component)?, self.inspect_timeout());
        let description = self.run_on(index, patience, |unit, _, _| unit.inspect());
        description.ok_or_else(|| busy(component))
    }

    fn stop(&mut self) -> Vec<String> {
        let late = self.stop_all();
        let now = self.clock();
        self.advance(now, None);
        late
    }
}
