//! What an executor brings, and what every one of them does with it.

use std::marker::PhantomData;
use std::sync::atomic::Ordering;
use std::sync::{Arc, mpsc};
use std::time::Duration;

use datum::{Datum, Message, Sample};

use super::{Asked, Beyond, Losses, Reader, Run, RunError, Sent, Watch, Writer};
use crate::declaration::Declaration;
use crate::door::{Doors, Place};
use crate::face::Face;
use crate::outside::{Nowhere, Outside};
use crate::port::{AnyInput, Input, Link, OpenError, Outlet};
use crate::property::suggestion_among;
use crate::service::{AnswerTo, Ask, CallKey};
use crate::system::{End, Joints, Table, find, inputs, outputs, services};
use crate::unit::Unit;
use crate::{
    BuildError, CallError, Event, Fault, LifeCycleError, Operation, Policy, SendStatus, State,
    Time, Transition,
};

/// Something to be done to a component between two of its cycles.
pub(crate) type Act = Box<dyn FnOnce(&mut Unit, Time, &mut dyn Outside) + Send>;

/// Drives the components of a system.
pub(crate) trait Executor {
    /// The present time.
    fn clock(&self) -> Time;

    /// What is known of the components, in order of addition.
    fn faces(&self) -> &[Face];

    /// What joins their ports.
    fn joints(&mut self) -> (&mut Joints, &[Face]);

    /// The ways in for those outside.
    fn doors(&self) -> &Doors;

    /// The system, for those who write and read by themselves.
    fn beyond(&self) -> Arc<dyn Beyond>;

    /// Gives a sample to its place when its time has come.
    fn plan(&mut self, at: Time, place: Place, sample: Arc<dyn Sample>);

    /// Lets time pass, at the longest until then, or until what is watched for has happened. Says whether it has.
    fn advance(&mut self, until: Time, watch: Option<Watch<'_>>) -> bool;

    /// Asks for a cycle of a component.
    fn call(&mut self, component: usize);

    /// How long to wait for a component whose cycle is under way.
    fn patience(&self) -> Duration;

    /// How long to wait for one only to look at it.
    fn glance(&self) -> Duration;

    /// Has something done to a component between two of its cycles; nobody waits for it.
    fn post(&mut self, component: usize, act: Act);

    /// Has something done to a component between two of its cycles, and waits so long for the answer.
    fn ask<R: Send + 'static>(
        &mut self,
        component: usize,
        patience: Duration,
        act: impl FnOnce(&mut Unit, Time, &mut dyn Outside) -> R + Send + 'static,
    ) -> Option<R> {
        let (answer, answered) = mpsc::channel();
        let act: Act = Box::new(move |unit, now, outside| {
            // Whoever has lost patience does not read it.
            let _ = answer.send(act(unit, now, outside));
        });
        self.post(component, act);
        match patience {
            Duration::MAX => answered.recv().ok(),
            patience => answered.recv_timeout(patience).ok(),
        }
    }

    /// The same, to be answered when it is done.
    fn begin(
        &mut self,
        component: usize,
        act: impl FnOnce(&mut Unit, Time, &mut dyn Outside) -> Result<(), RunError> + Send + 'static,
    ) -> Asked {
        let (answer, answered) = mpsc::channel();
        let asked = Asked::of(&self.faces()[component].name, answered);
        let act: Act = Box::new(move |unit, now, outside| {
            // Whoever asked need not read it.
            let _ = answer.send(act(unit, now, outside));
        });
        self.post(component, act);
        asked
    }

    /// Takes a component through a transition.
    fn take_through(
        &mut self,
        component: usize,
        transition: Transition,
        patience: Duration,
    ) -> Result<(), LifeCycleError> {
        let face = &self.faces()[component];
        let name = Arc::clone(&face.name);
        face.allow_interrupt(transition);
        let taken = self.ask(component, patience, move |unit, now, outside| {
            unit.transition(transition, now, outside)
        });
        taken.unwrap_or_else(|| {
            Err(LifeCycleError::Busy {
                component: name.to_string(),
                transition,
            })
        })
    }

    /// Configures everything, one after the other, then starts what runs on start-up. What fails is in the component's
    /// state, and told to the observers.
    fn start_up(&mut self) {
        for component in 0..self.faces().len() {
            if self.faces()[component].configure_on_startup {
                // However long it takes: maps are loaded here.
                let _ = self.take_through(component, Transition::Configure, Duration::MAX);
            }
        }
        for component in 0..self.faces().len() {
            let face = &self.faces()[component];
            if face.run_on_startup && face.status.state() == State::Stopped {
                let patience = self.patience();
                let _ = self.take_through(component, Transition::Start, patience);
            }
        }
    }

    /// Stops what runs, last things first. Names what did not stop in time.
    fn stop_all(&mut self) -> Vec<String> {
        let mut late = Vec::new();
        for component in (0..self.faces().len()).rev() {
            if !self.faces()[component].status.state().is_running() {
                continue;
            }
            let patience = self.patience();
            let stopped = self.take_through(component, Transition::Stop, patience);
            if matches!(stopped, Err(LifeCycleError::Busy { .. })) {
                late.push(self.faces()[component].name.to_string());
            }
        }
        late
    }

    /// A component by name.
    fn face(&self, component: &str) -> Option<&Face> {
        self.faces().iter().find(|face| *face.name == *component)
    }

    /// A component's place by name.
    fn place_of(&self, component: &str) -> Result<usize, RunError> {
        let found = (self.faces().iter()).position(|face| *face.name == *component);
        found.ok_or_else(|| RunError::Unknown {
            what: "component",
            name: component.to_owned(),
            nearest: suggestion_among(component, self.faces().iter().map(|face| &*face.name)),
        })
    }

    /// A port or service by name.
    fn end(&self, path: &str, table: fn(&Declaration) -> Table<'_>) -> Result<End, BuildError> {
        let faces = self.faces().iter();
        find(
            faces.map(|face| (&*face.name, &face.declaration)),
            path,
            table,
        )
    }
}

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
        let (from, to) = (self.end(from, outputs)?, self.end(to, inputs)?);
        let (joints, faces) = self.joints();
        joints.refuse_twice(&from, &to)?;
        let [writer, reader] = [&faces[from.unit], &faces[to.unit]];
        let written = &writer.declaration.outputs[from.index].schema;
        let taken = &reader.declaration.inputs[to.index].schema;
        BuildError::compare(written, &from.name, taken, &to.name)?;
        let threads = [writer.thread, reader.thread];
        let inlet = &reader.inlets[to.index];
        let joint = joints.make((&from, &to), threads, &policy, &**inlet)?;
        joints.remember(joint.connection, from.clone(), to.clone());
        // The reader first, so that nothing is sent to nobody.
        let (input, incoming) = (to.index, joint.incoming);
        let act: Act = Box::new(move |unit, _, _| unit.body.inputs[input].join(incoming));
        self.post(to.unit, act);
        let (output, connection) = (from.index, joint.connection);
        let (sender, link) = (joint.sender, joint.link);
        let act: Act = Box::new(move |unit, _, outside| {
            let output = &mut unit.body.outputs[output];
            output.join(sender, link);
            if policy.init {
                output.greet(connection, outside);
            }
        });
        self.post(from.unit, act);
        Ok(())
    }

    fn disconnect(&mut self, from: &str, to: &str) -> Result<(), BuildError> {
        let (from, to) = (self.end(from, outputs)?, self.end(to, inputs)?);
        let (joints, _) = self.joints();
        let Some(connection) = joints.forget(&from, &to) else {
            return Err(BuildError::NotJoined {
                from: from.name,
                to: to.name,
            });
        };
        let (output, input) = (from.index, to.index);
        let act: Act = Box::new(move |unit, _, _| unit.body.outputs[output].part(connection));
        self.post(from.unit, act);
        let act: Act = Box::new(move |unit, _, _| unit.body.inputs[input].part(connection));
        self.post(to.unit, act);
        Ok(())
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
        let (output, init) = (from.index, policy.init);
        let act: Act = Box::new(move |unit, _, outside| {
            let output = &mut unit.body.outputs[output];
            output.join(sender, link);
            if init {
                output.greet(connection, outside);
            }
        });
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

    fn overruns(&self, component: &str) -> u64 {
        let face = self.face(component);
        face.map_or(0, |face| face.status.overruns.load(Ordering::Relaxed))
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

fn busy(component: &str) -> RunError {
    RunError::Busy {
        component: component.to_owned(),
    }
}
