//! What can be done to a running system, by what every executor brings.

use std::marker::PhantomData;
use std::sync::atomic::Ordering;
use std::sync::{Arc, mpsc};
use std::time::Duration;

use asmotion_datum::{Datum, Message, Sample};

use super::change::Planning;
use super::{
    Act, Asked, Change, ChangeError, CycleTime, Executor, Losses, Reader, Run, RunError, Sent,
    Writer,
};
use crate::declaration::Declaration;
use crate::outside::Nowhere;
use crate::port::{AnyInput, AnySender, Input, Link, OpenError, Outlet};
use crate::service::{AnswerTo, Ask, CallKey};
use crate::system::{ConnectionId, inputs, outputs, services};
use crate::{
    BuildError, CallError, Event, Fault, LifeCycleError, Operation, Policy, SendStatus, State,
    Time, Transition,
};

impl<E: Executor> Run for E {
    fn now(&self) -> Time {
        self.clock()
    }

    fn run_until(&mut self, until: Time) {
        self.advance(until, None);
    }

    fn run_until_event(
        &mut self,
        limit: Time,
        wanted: &mut dyn FnMut(Time, &Event<'_>) -> bool,
    ) -> bool {
        self.advance(limit, Some(wanted))
    }

    fn inject_sample(
        &mut self,
        at: Time,
        port: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError> {
        let place = self.doors().port(port, &sample)?;
        self.plan(at, place, sample);
        Ok(())
    }

    fn publish_sample(
        &mut self,
        at: Time,
        topic: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError> {
        let place = self.doors().topic(topic, &sample)?;
        self.plan(at, place, sample);
        Ok(())
    }

    fn connect(&mut self, from: &str, to: &str, policy: Policy) -> Result<(), BuildError> {
        let mut planning = Planning::new(self);
        planning.connect(from, to, &policy)?;
        planning.carry_out();
        Ok(())
    }

    fn disconnect(&mut self, from: &str, to: &str) -> Result<(), BuildError> {
        let mut planning = Planning::new(self);
        planning.disconnect(from, to)?;
        planning.carry_out();
        Ok(())
    }

    fn change(&mut self, changes: &[Change]) -> Result<(), ChangeError> {
        Planning::new(self).make(changes)
    }

    fn writer<T: Message>(&mut self, port: &str, policy: Policy) -> Result<Writer<T>, BuildError> {
        let to = self.end(port, inputs)?;
        let (joints, faces) = self.joints();
        let face = &faces[to.unit];
        let taken = &face.declaration.inputs[to.index].schema;
        BuildError::compare(T::schema(), "the writer", taken, &to.name)?;
        let policy = policy.for_outsider();
        let opened = face.inlets[to.index].open(joints.number(), &policy, None);
        let (sender, incoming) = opened.map_err(|error| error.at("the writer", &to.name))?;
        let input = to.index;
        let act: Act = Box::new(move |unit, _, _| unit.body.inputs[input].join(incoming));
        self.post(to.unit, act);
        let outlet =
            Outlet::of(sender).ok_or_else(|| OpenError::OtherType.at("the writer", port))?;
        Ok(Writer {
            port: to.name,
            outlet,
            tell: policy.trigger.then_some(to.unit),
            mandatory: policy.mandatory,
            dropped: 0,
            beyond: self.beyond(),
        })
    }

    fn reader<T: Message>(&mut self, port: &str, policy: Policy) -> Result<Reader<T>, BuildError> {
        let from = self.end(port, outputs)?;
        let (joints, faces) = self.joints();
        let written = &faces[from.unit].declaration.outputs[from.index].schema;
        BuildError::compare(written, &from.name, T::schema(), "the reader")?;
        let connection = joints.number();
        let mut input = Input::<T>::new(T::schema().clone());
        let opened = (input.inlet()).open(connection, &policy.for_outsider(), None);
        let (sender, incoming) = opened.map_err(|error| error.at(&from.name, "the reader"))?;
        input.join(incoming);
        let (bell, link) = Link::to_outside(connection, &policy);
        let dropped = Arc::clone(&link.dropped);
        let act = joining((from.index, connection), sender, link, policy.init);
        self.post(from.unit, act);
        Ok(Reader {
            port: from.name,
            input,
            bell,
            dropped,
            beyond: self.beyond(),
        })
    }

    fn send<O: Operation>(
        &mut self,
        service: &str,
        argument: O::Request,
        patience: Duration,
    ) -> Result<Sent<O>, BuildError> {
        let to = self.end(service, services)?;
        let face = &self.faces()[to.unit];
        let served = &face.declaration.services[to.index].operations;
        let operation = served.iter().position(|served| served.name == O::NAME);
        let Some(operation) = operation else {
            return Err(BuildError::Operation {
                from: "the caller".to_owned(),
                operation: O::NAME.to_owned(),
                to: to.name,
            });
        };
        let beyond = self.beyond();
        let deadline = beyond.now() + patience;
        let (answer, answered) = mpsc::channel();
        let inbox = Arc::clone(&face.inboxes[to.index]);
        let unavailable = answer.clone();
        let posted = inbox.ask(
            Ask {
                // Nobody outside takes back a call: it has a deadline.
                key: CallKey {
                    caller: usize::MAX,
                    number: 0,
                },
                operation,
                argument: Arc::new(argument),
                trace: None,
                caller: Arc::from("outside"),
                deadline: Some(deadline),
                answer_to: Some(AnswerTo::Outside(answer)),
            },
            &mut Nowhere,
        );
        match posted {
            Ok(true) => beyond.news(to.unit),
            Ok(false) => {}
            // The other end is here.
            Err(error) => drop(unavailable.send(Err(error))),
        }
        Ok(Sent {
            answered,
            deadline,
            beyond,
            of: PhantomData,
        })
    }

    fn collect<O: Operation>(&mut self, mut sent: Sent<O>) -> Result<O::Response, CallError> {
        loop {
            match sent.collect_if_done() {
                SendStatus::Success(response) => return Ok(response),
                SendStatus::Failure(error) => return Err(error),
                SendStatus::Unknown => return Err(CallError::Unavailable),
                SendStatus::NotReady => {
                    let mut answered =
                        |_: Time, event: &Event<'_>| matches!(event, Event::Answered { .. });
                    self.advance(sent.deadline, Some(&mut answered));
                }
            }
        }
    }

    fn transition(
        &mut self,
        component: &str,
        transition: Transition,
    ) -> Result<(), LifeCycleError> {
        let index = (self.place_of(component)).map_err(|_| LifeCycleError::Unknown {
            component: component.to_owned(),
        })?;
        let patience = self.patience();
        self.take_through(index, transition, patience)
    }

    fn trigger(&mut self, component: &str) -> Result<(), RunError> {
        let index = self.place_of(component)?;
        self.call(index);
        Ok(())
    }

    fn set_period(&mut self, component: &str, period: Duration) -> Result<(), RunError> {
        let (index, patience) = (self.place_of(component)?, self.patience());
        let set = self.ask(index, patience, move |unit, _, _| unit.set_period(period));
        set.ok_or_else(|| busy(component))
    }

    fn set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<(), RunError> {
        let (index, patience) = (self.place_of(component)?, self.patience());
        let values = values.to_vec();
        let set = self.ask(index, patience, move |unit, now, outside| {
            unit.set_properties(&values, now, outside)
        });
        Ok(set.ok_or_else(|| busy(component))??)
    }

    fn begin_transition(
        &mut self,
        component: &str,
        transition: Transition,
    ) -> Result<Asked, RunError> {
        let index = self.place_of(component)?;
        self.faces()[index].allow_interrupt(transition);
        Ok(self.begin(index, move |unit, now, outside| {
            Ok(unit.transition(transition, now, outside)?)
        }))
    }

    fn begin_set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<Asked, RunError> {
        let (index, values) = (self.place_of(component)?, values.to_vec());
        Ok(self.begin(index, move |unit, now, outside| {
            Ok(unit.set_properties(&values, now, outside)?)
        }))
    }

    fn components(&self) -> Vec<String> {
        let faces = self.faces().iter();
        faces.map(|face| face.name.to_string()).collect()
    }

    fn state(&self, component: &str) -> Option<State> {
        self.face(component).map(|face| face.status.state())
    }

    fn target_state(&self, component: &str) -> Option<State> {
        self.face(component).map(|face| face.status.target())
    }

    fn cycles(&self, component: &str) -> u64 {
        let face = self.face(component);
        face.map_or(0, |face| face.status.cycles.load(Ordering::Relaxed))
    }

    fn period(&self, component: &str) -> Duration {
        let face = self.face(component);
        face.map_or(Duration::ZERO, |face| face.status.period())
    }

    fn overruns(&self, component: &str) -> u64 {
        let face = self.face(component);
        face.map_or(0, |face| face.status.overruns.load(Ordering::Relaxed))
    }

    fn late(&self, component: &str) -> u64 {
        let face = self.face(component);
        face.map_or(0, |face| face.status.late.load(Ordering::Relaxed))
    }

    fn cycle_time(&self, component: &str) -> CycleTime {
        let face = self.face(component);
        face.map(|face| face.status.cycle_time())
            .unwrap_or_default()
    }

    fn losses(&self, component: &str) -> Losses {
        let face = self.face(component);
        face.map(|face| face.status.losses()).unwrap_or_default()
    }

    fn fault(&self, component: &str) -> Option<Fault> {
        (self.face(component)).and_then(|face| face.status.fault().clone())
    }

    fn declaration(&self, component: &str) -> Option<Declaration> {
        self.face(component).map(|face| face.declaration.clone())
    }

    fn properties(&mut self, component: &str) -> Result<Vec<(String, Datum)>, RunError> {
        let (index, patience) = (self.place_of(component)?, self.glance());
        let values = self.ask(index, patience, |unit, _, _| unit.body.values());
        values.ok_or_else(|| busy(component))
    }

    fn stop(&mut self) -> Vec<String> {
        let late = self.stop_all();
        let now = self.clock();
        self.advance(now, None);
        late
    }
}

/// An output gets a connection; and its reader what was last written, if the policy says so.
pub(super) fn joining(
    (output, connection): (usize, ConnectionId),
    sender: Box<dyn AnySender>,
    link: Link,
    init: bool,
) -> Act {
    Box::new(move |unit, _, outside| {
        let output = &mut unit.body.outputs[output];
        output.join(sender, link);
        if init {
            output.greet(connection, outside);
        }
    })
}

pub(super) fn busy(component: &str) -> RunError {
    RunError::Busy {
        component: component.to_owned(),
    }
}
