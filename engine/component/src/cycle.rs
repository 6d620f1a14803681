//! The cycle: what a component sees and does between freezing the inputs and committing the outputs.

use std::any::Any;
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use asmotion_datum::{Datum, Message, Sample};

use crate::background::BackgroundWork;
use crate::body::{Action, Body};
use crate::face::Status;
use crate::handle::{In, Out, Property, Provided, Required};
use crate::port::{Flow, Input, Output};
use crate::property::PropertyValue;
use crate::service::{
    CallError, CallId, Operation, Reply, Request, RequestId, SendStatus, ServiceFault, Slot,
    unreadable,
};
use crate::{Fault, Losses, Time};

/// What a handle that was not the component's stands for.
type Foreign = &'static str;

/// One cycle of one component: freeze inputs, compute, commit all outputs or none.
///
/// Nothing here blocks, looks up a name or sends: what is written waits for the end of the cycle.
pub struct Cycle<'a> {
    body: &'a mut Body,
    now: Time,
    number: u64,
    status: &'a Status,
    /// The first handle that was not this component's.
    foreign: Cell<Option<Foreign>>,
    error: Option<Fault>,
}

impl<'a> Cycle<'a> {
    pub(crate) fn new(body: &'a mut Body, now: Time, number: u64, status: &'a Status) -> Self {
        Self {
            body,
            now,
            number,
            status,
            foreign: Cell::new(None),
            error: None,
        }
    }

    /// The time of this cycle; it stands still until the next one.
    pub fn now(&self) -> Time {
        self.now
    }

    /// The cycle's number since the component was built, from 1.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// The newest sample of an input port (TCA `receiveLast`).
    pub fn read<T: Message>(&self, port: In<T>) -> Flow<&T> {
        self.input(port).map_or(Flow::NoData, Input::read)
    }

    /// Every sample that came since the last cycle, in the order in which they came (TCA `receiveAll`).
    pub fn all<T: Message>(&self, port: In<T>) -> &[T] {
        self.input(port).map_or(&[], Input::all)
    }

    /// Whether an input's newest sample is older than its connection promises.
    pub fn is_stale<T: Message>(&self, port: In<T>) -> bool {
        let input = self.body.inputs.get(port.position(self.body.owner));
        input.is_some_and(|input| input.is_stale())
    }

    /// When the newest sample of an input was written: the time of its writer's cycle.
    pub fn written_at<T: Message>(&self, port: In<T>) -> Option<Time> {
        let input = self.body.inputs.get(port.position(self.body.owner));
        input.and_then(|input| input.written_at())
    }

    /// Writes a sample; it leaves when the cycle has succeeded (TCA `send`).
    pub fn write<T: Message>(&mut self, port: Out<T>, sample: T) {
        let output = self.body.outputs.get_mut(port.position(self.body.owner));
        match output.and_then(|output| (&mut **output as &mut dyn Any).downcast_mut::<Output<T>>())
        {
            Some(output) => {
                output.write(sample);
                self.body
                    .journal
                    .push(Action::Write(port.position(self.body.owner)));
            }
            None => self.refuse("output"),
        }
    }

    /// The requests that wait for an operation, each handed over once. All but one-way ones want a reply, in this
    /// cycle or a later one.
    pub fn requests<O: Operation>(&mut self, served: Provided<O>) -> Vec<Request<O::Request>> {
        let Some(slot) = self.provided(served) else {
            return Vec::new();
        };
        let taken = self.body.services[slot.port].take(slot.operation);
        let mut requests = Vec::with_capacity(taken.len());
        for (id, ask) in taken {
            self.body.cause.take(ask.trace);
            match ask.argument.read() {
                Ok(argument) => requests.push(Request {
                    id,
                    argument,
                    caller: ask.caller,
                    deadline: ask.deadline,
                }),
                Err(error) => self.answer(slot, id, Err(unreadable("BAD_ARGUMENT", &error))),
            }
        }
        requests
    }

    /// Requests handed over earlier that nobody waits for any more: cancelled, or past their deadline.
    pub fn cancelled<O: Operation>(&self, served: Provided<O>) -> &[RequestId] {
        match self.provided(served) {
            Some(slot) => self.body.services[slot.port].cancelled(),
            None => &[],
        }
    }

    /// Replies to a request; the reply leaves when the cycle has succeeded.
    pub fn reply<O: Operation>(
        &mut self,
        served: Provided<O>,
        to: RequestId,
        result: Result<O::Response, ServiceFault>,
    ) {
        if let Some(slot) = self.provided(served) {
            let result = result.map(|response| Arc::new(response) as Arc<dyn Sample>);
            self.answer(slot, to, result);
        }
    }

    /// Calls an operation; the call leaves when the cycle has succeeded, its reply comes in a later cycle.
    /// Deadline and retries are the wire's.
    pub fn call<O: Operation>(&mut self, reference: Required<O>, argument: O::Request) -> CallId {
        self.make_call(reference, argument, false)
    }

    /// Calls an operation and wants no reply.
    pub fn call_one_way<O: Operation>(&mut self, reference: Required<O>, argument: O::Request) {
        self.make_call(reference, argument, true);
    }

    /// Takes back a call: it ends with [`CallError::Cancelled`], and the provider is told. One that has ended stays
    /// ended.
    pub fn cancel(&mut self, call: CallId) {
        self.body.journal.push(Action::Cancel(call));
    }

    /// The calls of an operation that ended since the last cycle, each handed over once.
    pub fn replies<O: Operation>(&mut self, reference: Required<O>) -> Vec<Reply<O::Response>> {
        let Some(slot) = self.required(reference) else {
            return Vec::new();
        };
        let ended = self.body.caller.take(slot);
        for ended in &ended {
            self.body.cause.take(ended.cause);
        }
        let read = |response: Arc<dyn Sample>| {
            (response.read()).map_err(|error| CallError::Fault(unreadable("BAD_REPLY", &error)))
        };
        ended
            .into_iter()
            .map(|ended| Reply {
                call: CallId(ended.number),
                result: ended.result.and_then(read),
            })
            .collect()
    }

    /// What has become of one call, as of the beginning of the cycle; handed over once (RTT `collectIfDone`).
    pub fn collect_if_done<O: Operation>(
        &mut self,
        reference: Required<O>,
        call: CallId,
    ) -> SendStatus<O::Response> {
        let Some(slot) = self.required(reference) else {
            return SendStatus::Unknown;
        };
        let Some(ended) = self.body.caller.take_one(slot, call) else {
            let made = |action: &Action| matches!(action, Action::Call { call: made, .. } if *made == call);
            let under_way =
                self.body.caller.is_under_way(call) || self.body.journal.iter().any(made);
            return match under_way {
                true => SendStatus::NotReady,
                false => SendStatus::Unknown,
            };
        };
        self.body.cause.take(ended.cause);
        let read = |response: Arc<dyn Sample>| {
            (response.read()).map_err(|error| CallError::Fault(unreadable("BAD_REPLY", &error)))
        };
        match ended.result.and_then(read) {
            Ok(response) => SendStatus::Success(response),
            Err(error) => SendStatus::Failure(error),
        }
    }

    /// The value of a property, as of the beginning of the cycle: a copy, so big ones are better read in
    /// [`Component::configure`](crate::Component::configure).
    pub fn property<T: PropertyValue>(&self, property: Property<T>) -> T {
        self.body.value(property).unwrap_or_else(|| {
            self.refuse("property");
            T::initial()
        })
    }

    /// Tells the observers something, if the cycle succeeds; nobody else hears of it.
    pub fn report(&mut self, kind: &'static str, what: Datum) {
        self.body.journal.push(Action::Report(kind, what));
    }

    /// Says how many messages the component has lost so far, all in all.
    pub fn set_losses(&mut self, losses: Losses) {
        self.status.set_losses(losses);
    }

    /// Asks for another cycle at once, if the component is event-driven: not all that came could be done in this one.
    pub fn again(&mut self) {
        self.body.journal.push(Action::Again);
    }

    /// Puts the component in [`State::RunTimeError`](crate::State::RunTimeError) after this cycle, which otherwise
    /// counts (RTT `error`).
    pub fn error(&mut self, why: Fault) {
        self.error = Some(why);
    }

    /// Changes the component's own period, from the next cycle on; zero makes it event-driven.
    pub fn set_period(&mut self, period: Duration) {
        self.body.journal.push(Action::SetPeriod(period));
    }

    /// Says how long this cycle's work takes: simulated time, which stands still in a cycle, has no other way to hold
    /// it against its deadline. Live, the clock knows.
    pub fn lasts(&mut self, how_long: Duration) {
        self.body.lasts = how_long;
    }

    /// Starts work that takes too long for a cycle, such as reading a file, and returns at once. Ask for the result with
    /// [`BackgroundWork::take`], in this cycle and the following ones: live it comes to a later cycle, which it
    /// triggers; in simulated time it is there when this returns.
    ///
    /// The work starts even if the cycle fails, so it should change nothing outside of itself.
    pub fn spawn<T: Send + 'static>(
        &mut self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> BackgroundWork<T> {
        BackgroundWork::spawn(&self.body.background, work)
    }

    /// Whether somebody wants the component to stop, and its activity allows to interrupt it: a long cycle asks now
    /// and then, and returns (TCA `mayInterruptIfRunning`). What it wrote until then counts.
    pub fn interrupted(&self) -> bool {
        self.status.interrupt.load(Ordering::Relaxed)
    }

    /// How the cycle ended, beside what it returned.
    pub(crate) fn finish(self) -> Result<Option<Fault>, Fault> {
        match self.foreign.get() {
            None => Ok(self.error),
            Some(kind) => Err(Fault::ForeignHandle { kind: kind.into() }),
        }
    }

    fn input<T: Message>(&self, port: In<T>) -> Option<&Input<T>> {
        let input = self.body.inputs.get(port.position(self.body.owner));
        let input = input.and_then(|input| (&**input as &dyn Any).downcast_ref());
        if input.is_none() {
            self.refuse("input");
        }
        input
    }

    fn provided<O: Operation>(&self, served: Provided<O>) -> Option<Slot> {
        let slot = self
            .body
            .provided
            .get(served.position(self.body.owner))
            .copied();
        if slot.is_none() {
            self.refuse("service");
        }
        slot
    }

    fn required<O: Operation>(&self, reference: Required<O>) -> Option<Slot> {
        let slot = self
            .body
            .required
            .get(reference.position(self.body.owner))
            .copied();
        if slot.is_none() {
            self.refuse("reference");
        }
        slot
    }

    fn make_call<O: Operation>(
        &mut self,
        reference: Required<O>,
        argument: O::Request,
        one_way: bool,
    ) -> CallId {
        let call = self.body.caller.number();
        if let Some(slot) = self.required(reference) {
            self.body.journal.push(Action::Call {
                slot,
                call,
                argument: Arc::new(argument),
                one_way,
            });
        }
        call
    }

    fn answer(&mut self, slot: Slot, to: RequestId, result: Result<Arc<dyn Sample>, ServiceFault>) {
        self.body.journal.push(Action::Answer {
            service: slot.port,
            to,
            result,
        });
    }

    fn refuse(&self, kind: Foreign) {
        self.foreign.set(Some(kind));
    }
}
