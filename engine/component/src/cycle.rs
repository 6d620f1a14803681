//! The cycle, as a component sees it between the freezing of its inputs and the commit of its outputs.

use std::any::Any;
use std::cell::Cell;
use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::{Datum, Message, Sample};
use asmotion_port::{AnyInput, BufferKind, Flow, InputPort, OutputPort, Time};

use crate::action::CycleAction;
use crate::background::BackgroundWork;
use crate::fault::Fault;
use crate::handle::{In, Out, Property, Provided, Required};
use crate::host::CycleHost;
use crate::losses::Losses;
use crate::operation::{
    CallError, CallId, Operation, OperationSlot, Reply, Request, RequestId, SendStatus,
    ServiceFault, read_checked, unreadable,
};
use crate::peer::PeerStatus;
use crate::property::PropertyValue;
use crate::setup::value_of;

/// The kind of a handle that belongs to another component.
type Foreign = &'static str;

/// Kind of a report with a text for the person who runs the system: a limitation or a degraded mode of the component.
pub const NOTICE_REPORT: &str = "notice";

/// Kind of a report with a line of a log, such as the standard output of a program.
pub const LOG_REPORT: &str = "log";

/// One cycle of one component: freeze inputs, compute, commit all outputs or none.
///
/// No method blocks, looks up a name or sends: samples and calls wait for the end of the cycle.
pub struct Cycle<'a> {
    host: &'a mut dyn CycleHost,
    now: Time,
    number: u64,
    /// The kind of the first foreign handle that was used.
    foreign: Cell<Option<Foreign>>,
    error: Option<Fault>,
    /// `false` while a stopped component serves requests.
    is_running: bool,
}

impl<'a> Cycle<'a> {
    /// Creates the cycle with this number, from 1, at this time. For runtimes, and for tests that drive a component by
    /// hand.
    pub fn new(host: &'a mut dyn CycleHost, now: Time, number: u64) -> Self {
        Self {
            host,
            now,
            number,
            foreign: Cell::new(None),
            error: None,
            is_running: true,
        }
    }

    /// Creates the cycle in which a stopped component answers requests, after `number` cycles. For runtimes and tests.
    pub fn stopped(host: &'a mut dyn CycleHost, now: Time, number: u64) -> Self {
        Self {
            is_running: false,
            ..Self::new(host, now, number)
        }
    }

    /// Returns whether the component runs; `false` in [`Component::serve`](crate::Component::serve), where it writes
    /// nothing.
    pub fn is_running(&self) -> bool {
        self.is_running
    }

    /// The time of this cycle, constant until the next one.
    pub fn now(&self) -> Time {
        self.now
    }

    /// Number of the cycle since the component was built, from 1.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// The newest sample of an input port (TCA `receiveLast`).
    pub fn read<T: Message>(&self, port: In<T>) -> Flow<&T> {
        self.input(port).map_or(Flow::NoData, InputPort::read)
    }

    /// All samples that have arrived since the last cycle, in order of arrival (TCA `receiveAll`).
    pub fn all<T: Message>(&self, port: In<T>) -> &[T] {
        self.input(port).map_or(&[], InputPort::all)
    }

    /// For each sample of [`all`](Self::all), the last time at which its connection allows its use; `None` without a limit. A
    /// component that keeps samples for later cycles discards them after that.
    pub fn expiries<T: Message>(&self, port: In<T>) -> &[Option<Time>] {
        self.any_input(port).map_or(&[], AnyInput::expiries)
    }

    /// Returns whether the input's newest sample is older than its connection's policy allows.
    pub fn is_stale<T: Message>(&self, port: In<T>) -> bool {
        self.any_input(port).is_some_and(AnyInput::is_stale)
    }

    /// Time of the writer's cycle in which the newest sample of an input was written; `None` without a sample.
    pub fn written_at<T: Message>(&self, port: In<T>) -> Option<Time> {
        self.any_input(port).and_then(AnyInput::written_at)
    }

    /// Number of messages lost on the way into an input port before this cycle, since the start of the system: dropped
    /// because a queue was full, missed by the bus, unreadable, or too old.
    pub fn lost<T: Message>(&self, port: In<T>) -> u64 {
        self.any_input(port).map_or(0, AnyInput::lost)
    }

    /// Counts messages that the component has taken from an input port and drops unused.
    pub fn count_lost<T: Message>(&mut self, port: In<T>, count: u64) {
        self.host
            .count_lost(port.position(self.host.owner()), count);
    }

    /// Refuses a sample of an input port that the component cannot use, such as a command for another number of joints. It is
    /// counted among the misfits of the component ([`Losses::misfits`]), and each cause is reported once as a notice; so write
    /// what was expected and what was found, not the sample.
    pub fn refuse<T: Message>(&mut self, port: In<T>, cause: impl Into<String>) {
        let port = port.position(self.host.owner());
        self.host.record(CycleAction::Refuse(port, cause.into()));
    }

    /// The queue that the connections of an input port form together; [`BufferKind::Data`] if one of them keeps only the
    /// newest sample, or if there is none. A component that queues messages itself keeps as many.
    pub fn queue<T: Message>(&self, port: In<T>) -> BufferKind {
        self.any_input(port)
            .map_or(BufferKind::Data, AnyInput::queue)
    }

    /// Writes a sample, which is sent if the cycle succeeds (TCA `send`).
    pub fn write<T: Message>(&mut self, port: Out<T>, sample: T) {
        self.write_aged(port, sample, Duration::ZERO);
    }

    /// Writes a sample as [`write`](Self::write) does, which is this old already: it comes from outside, and has waited there. Age
    /// limits of connections count its age.
    pub fn write_aged<T: Message>(&mut self, port: Out<T>, sample: T, age: Duration) {
        let index = port.position(self.host.owner());
        let output = self.host.output(index);
        match output.and_then(|output| (output as &mut dyn Any).downcast_mut::<OutputPort<T>>()) {
            Some(output) => {
                output.write_aged(sample, age);
                self.host.record(CycleAction::Write(index));
            }
            None => self.record_foreign_handle("output"),
        }
    }

    /// The waiting requests of an operation, each returned once. All but one-way requests need a reply, in this cycle
    /// or a later one.
    pub fn requests<O: Operation>(&mut self, served: Provided<O>) -> Vec<Request<O::Request>> {
        let Some(slot) = self.provided(served) else {
            return Vec::new();
        };
        let waiting = self.host.take_requests(slot);
        let mut requests = Vec::with_capacity(waiting.len());
        for request in waiting {
            match read_checked(request.argument) {
                Ok(argument) => requests.push(Request {
                    id: request.id,
                    argument,
                    caller: request.caller,
                    deadline: request.deadline,
                }),
                Err(error) => {
                    self.record_answer(slot, request.id, Err(unreadable("BAD_ARGUMENT", &error)));
                }
            }
        }
        requests
    }

    /// Requests returned earlier whose callers no longer wait, because they cancelled the call or its deadline has
    /// passed.
    pub fn cancelled<O: Operation>(&self, served: Provided<O>) -> &[RequestId] {
        match self.provided(served) {
            Some(slot) => self.host.cancelled(slot.port),
            None => &[],
        }
    }

    /// Replies to a request. The reply is sent if the cycle succeeds.
    pub fn reply<O: Operation>(
        &mut self,
        served: Provided<O>,
        to: RequestId,
        result: Result<O::Response, ServiceFault>,
    ) {
        if let Some(slot) = self.provided(served) {
            let result = result.map(|response| Arc::new(response) as Arc<dyn Sample>);
            self.record_answer(slot, to, result);
        }
    }

    /// Calls an operation. The call is sent if the cycle succeeds, and its reply arrives in a later cycle. The wire
    /// determines timeout and retries.
    pub fn call<O: Operation>(&mut self, reference: Required<O>, argument: O::Request) -> CallId {
        self.make_call(reference, argument, false)
    }

    /// Calls an operation without a reply.
    pub fn call_one_way<O: Operation>(&mut self, reference: Required<O>, argument: O::Request) {
        self.make_call(reference, argument, true);
    }

    /// Cancels a call: it ends with [`CallError::Cancelled`], and the provider is notified. Does nothing if the call
    /// has ended.
    pub fn cancel(&mut self, call: CallId) {
        self.host.record(CycleAction::Cancel(call));
    }

    /// The calls of an operation that have ended since the last cycle, each returned once.
    pub fn replies<O: Operation>(&mut self, reference: Required<O>) -> Vec<Reply<O::Response>> {
        let Some(slot) = self.required(reference) else {
            return Vec::new();
        };
        let replies = self.host.take_replies(slot);
        replies
            .into_iter()
            .map(|reply| Reply {
                call: reply.call,
                result: reply.result.and_then(read_reply),
            })
            .collect()
    }

    /// Status of one call as of the beginning of the cycle; a result is returned once (RTT `collectIfDone`).
    pub fn collect_if_done<O: Operation>(
        &mut self,
        reference: Required<O>,
        call: CallId,
    ) -> SendStatus<O::Response> {
        let Some(slot) = self.required(reference) else {
            return SendStatus::Unknown;
        };
        let Some(reply) = self.host.take_reply(slot, call) else {
            return if self.host.is_under_way(call) {
                SendStatus::NotReady
            } else {
                SendStatus::Unknown
            };
        };
        match reply.result.and_then(read_reply) {
            Ok(response) => SendStatus::Success(response),
            Err(error) => SendStatus::Failure(error),
        }
    }

    /// The value of a property as of the beginning of the cycle. This copies the value, so read large ones in
    /// [`Component::configure`](crate::Component::configure).
    pub fn property<T: PropertyValue>(&self, property: Property<T>) -> T {
        value_of(&*self.host, property).unwrap_or_else(|| {
            self.record_foreign_handle("property");
            T::initial()
        })
    }

    /// Returns whether anybody uses reports of this kind. A component whose reports are costly makes them only then; it decides
    /// nothing else by this.
    pub fn wants_report(&self, kind: &str) -> bool {
        self.host.wants_report(kind)
    }

    /// Reports data to the observers, also if the cycle fails later. Components do not receive reports.
    pub fn report(&mut self, kind: &'static str, data: Datum) {
        self.host.record(CycleAction::Report(kind, data));
    }

    /// Sets the total number of messages that the component has lost so far, without those counted for an input
    /// ([`count_lost`](Self::count_lost)).
    pub fn set_losses(&mut self, losses: Losses) {
        self.host.set_losses(losses);
    }

    /// The status of another component of the system, at this moment; `None` if it runs in another process, or if there is
    /// none. For components that pass on commands to it.
    pub fn peer(&self, component: &str) -> Option<PeerStatus> {
        self.host.peer(component)
    }

    /// Sets whether the component can reach what it stands for, such as a component of another robot (default: `true`).
    /// Others read it as [`PeerStatus::is_reachable`].
    pub fn set_reachable(&mut self, is_reachable: bool) {
        self.host.set_reachable(is_reachable);
    }

    /// Requests another cycle at once, if the component is event-driven. For components that cannot handle all of their
    /// input in one cycle.
    pub fn request_cycle(&mut self) {
        self.host.record(CycleAction::CycleAgain);
    }

    /// Requests a cycle at this time, if the component is event-driven; at once if the time has passed.
    ///
    /// The earliest of several requests counts. A request ends with the next cycle, whatever triggers it, so a component that
    /// still waits requests a cycle again.
    pub fn request_cycle_at(&mut self, at: Time) {
        self.host.record(CycleAction::CycleAt(at));
    }

    /// Moves the component to [`State::RunTimeError`](crate::State::RunTimeError) after this cycle, which succeeds
    /// otherwise (RTT `error`).
    pub fn error(&mut self, fault: Fault) {
        self.error = Some(fault);
    }

    /// Changes the component's own period, from the next cycle on; zero makes it event-driven.
    pub fn set_period(&mut self, period: Duration) {
        self.host.record(CycleAction::SetPeriod(period));
    }

    /// Sets the duration of this cycle in simulated time, which is compared with the deadline. Simulated time is
    /// constant during a cycle, so it cannot be measured; a live run measures the duration and ignores this.
    pub fn set_duration(&mut self, duration: Duration) {
        self.host.set_duration(duration);
    }

    /// Starts work that takes too long for a cycle, such as reading a file, and returns at once. Check for the result
    /// with [`BackgroundWork::take`] in this cycle and the following ones: in a live run the end of the work triggers a
    /// later cycle; in simulated time the result is available when this returns.
    ///
    /// The work starts even if the cycle fails, so it should change nothing outside of itself.
    pub fn spawn<T: Send + 'static>(
        &mut self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> BackgroundWork<T> {
        BackgroundWork::spawn(self.host.work_place(), work)
    }

    /// Returns whether the component is to stop and its activity allows the interruption of a cycle. A long cycle
    /// checks this now and then and returns early (TCA `mayInterruptIfRunning`); its outputs until then are committed.
    pub fn interrupted(&self) -> bool {
        self.host.is_interrupted()
    }

    /// Ends the cycle. `Ok` contains the error reported with [`Cycle::error`], if any.
    ///
    /// # Errors
    /// [`Fault::ForeignHandle`] if the component used a handle that another one declared.
    pub fn finish(self) -> Result<Option<Fault>, Fault> {
        match self.foreign.get() {
            None => Ok(self.error),
            Some(kind) => Err(Fault::ForeignHandle { kind: kind.into() }),
        }
    }

    fn any_input<T: Message>(&self, port: In<T>) -> Option<&dyn AnyInput> {
        self.host.input(port.position(self.host.owner()))
    }

    fn input<T: Message>(&self, port: In<T>) -> Option<&InputPort<T>> {
        let input = self.any_input(port);
        let input = input.and_then(|input| (input as &dyn Any).downcast_ref());
        if input.is_none() {
            self.record_foreign_handle("input");
        }
        input
    }

    fn provided<O: Operation>(&self, served: Provided<O>) -> Option<OperationSlot> {
        let slot = self.host.provided(served.position(self.host.owner()));
        if slot.is_none() {
            self.record_foreign_handle("service");
        }
        slot
    }

    fn required<O: Operation>(&self, reference: Required<O>) -> Option<OperationSlot> {
        let slot = self.host.required(reference.position(self.host.owner()));
        if slot.is_none() {
            self.record_foreign_handle("reference");
        }
        slot
    }

    fn make_call<O: Operation>(
        &mut self,
        reference: Required<O>,
        argument: O::Request,
        one_way: bool,
    ) -> CallId {
        let call = self.host.next_call();
        if let Some(slot) = self.required(reference) {
            self.host.record(CycleAction::Call {
                slot,
                call,
                argument: Arc::new(argument),
                one_way,
            });
        }
        call
    }

    fn record_answer(
        &mut self,
        slot: OperationSlot,
        to: RequestId,
        result: Result<Arc<dyn Sample>, ServiceFault>,
    ) {
        self.host.record(CycleAction::Answer {
            service: slot.port,
            to,
            result,
        });
    }

    fn record_foreign_handle(&self, kind: Foreign) {
        self.foreign.set(Some(kind));
    }
}

/// Converts a response to the type that the caller expects.
fn read_reply<R: Message>(response: Arc<dyn Sample>) -> Result<R, CallError> {
    read_checked(response).map_err(|error| CallError::Fault(unreadable("BAD_REPLY", &error)))
}
