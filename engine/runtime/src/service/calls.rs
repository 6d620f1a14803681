//! The caller's side of services: a call is outstanding until a reply, a cancellation or the deadline ends it.

mod freeze;

use std::sync::Arc;

use asmotion_bus::TraceContext;
use asmotion_component::{CallError, CallId, OperationSlot};
use asmotion_datum::Sample;
use asmotion_port::Time;

pub(crate) use self::freeze::FrozenCalls;
use super::message::{
    CallKey, ComponentReply, ProviderMessage, ReplyQueue, ReplyTo, ServiceRequest, UNDER_WAY,
};
use super::reference::{
    RequiredReference, Wiring, first_alternative, next_alternative, path_names, wire_of, wiring_of,
};
use crate::cause::CycleCause;
use crate::effects::ComponentEffects;
use crate::event::Event;

/// All calls that one component has made.
pub(crate) struct OutgoingCalls {
    reply_queue: Arc<ReplyQueue>,
    outstanding: Vec<OutstandingCall>,
    /// Calls that have ended and become visible in the next cycle.
    ended: Vec<EndedCall>,
    /// Calls that have ended and are visible in the current cycle.
    frozen: Vec<EndedCall>,
    /// Number of the newest call.
    last_number: u64,
    /// Number of one-way calls that a provider could not take.
    lost_calls: u64,
    /// The trace that the current cycle continues.
    cause: Arc<CycleCause>,
}

struct OutstandingCall {
    number: u64,
    slot: OperationSlot,
    attempt: u32,
    /// The alternative of the reference that the current attempt is at.
    alternative: u32,
    /// Time at which the current attempt ends, whatever alternative it is at.
    attempt_end: Time,
    /// Time at which the current attempt times out or, while `waits_for_retry`, the next one begins.
    deadline: Time,
    /// The last attempt has failed, and the next one has not begun.
    waits_for_retry: bool,
    /// Kept for retries.
    argument: Arc<dyn Sample>,
    /// Trace of the cycle that made the call.
    cause: Option<TraceContext>,
}

/// A call that has ended.
pub(crate) struct EndedCall {
    pub number: u64,
    slot: OperationSlot,
    /// Trace of the cycle that made the call.
    pub cause: Option<TraceContext>,
    pub result: Result<Arc<dyn Sample>, CallError>,
}

impl OutgoingCalls {
    pub(crate) fn new(component: usize, cause: Arc<CycleCause>) -> Self {
        Self {
            reply_queue: Arc::new(ReplyQueue::new(component)),
            outstanding: Vec::new(),
            ended: Vec::new(),
            frozen: Vec::new(),
            last_number: 0,
            lost_calls: 0,
            cause,
        }
    }

    /// Allocates the memory for replies now, instead of in the cycle that makes the first call.
    pub(crate) fn allocate(&self) {
        self.reply_queue.queue();
    }

    /// Returns a fresh number for a call that the current cycle makes.
    pub(crate) fn next_id(&mut self) -> CallId {
        self.last_number += 1;
        CallId(self.last_number)
    }

    /// Makes a call of a cycle that has been committed.
    pub(crate) fn call(
        &mut self,
        references: &[RequiredReference],
        slot: OperationSlot,
        number: u64,
        argument: Arc<dyn Sample>,
        one_way: bool,
        effects: &mut ComponentEffects<'_>,
    ) {
        let alternative = first_alternative(references, slot);
        let wire = wire_of(references, slot, alternative);
        let one_way = one_way || wire.one_way;
        let attempt_end = effects.now + wire.timeout;
        let call = OutstandingCall {
            number,
            slot,
            attempt: 1,
            alternative,
            attempt_end,
            deadline: attempt_end,
            waits_for_retry: false,
            argument,
            cause: self.cause.current(),
        };
        if one_way {
            return self.send_one_way(references, &call, effects);
        }
        let full = self.outstanding.len() + self.ended.len() + self.frozen.len() >= UNDER_WAY;
        if full {
            return self.end(references, &call, Err(CallError::Unavailable), effects);
        }
        match self.send_request(references, &call, effects) {
            Ok(()) => self.add_outstanding(call, effects),
            Err(error) => self.handle_failure(references, call, error, effects),
        }
    }

    /// Sends a one-way call to every service of the first alternative that takes it, and counts those that could not.
    fn send_one_way(
        &mut self,
        references: &[RequiredReference],
        call: &OutstandingCall,
        effects: &mut ComponentEffects<'_>,
    ) {
        let (port, _) = emit_called(references, call, effects);
        let wirings = references.get(call.slot.port).map(|it| &*it.wirings);
        let wirings = wirings.unwrap_or_default();
        let mut lost = vec![""];
        for services in wirings.chunk_by(|one, next| one.wire.alternative == next.wire.alternative)
        {
            lost = not_taken(services, call, effects);
            if lost.len() < services.len() {
                break;
            }
        }
        for to in lost {
            self.lost_calls += 1;
            effects.emit(&Event::Dropped {
                component: effects.name,
                port,
                to,
                total: self.lost_calls,
                reason: None,
            });
        }
    }

    /// Makes one attempt of a call.
    fn send_request(
        &self,
        references: &[RequiredReference],
        call: &OutstandingCall,
        effects: &mut ComponentEffects<'_>,
    ) -> Result<(), CallError> {
        let (port, _) = emit_called(references, call, effects);
        let wiring = wiring_of(references, call.slot, call.alternative);
        let wiring = wiring.ok_or(CallError::Unavailable)?;
        let operation = wiring.operations.get(call.slot.operation);
        let operation = *operation.ok_or(CallError::Unavailable)?;
        let reply_to = ReplyTo::Component(ComponentReply(Arc::clone(&self.reply_queue)));
        let mut request = request(call, operation, Some(reply_to), effects);
        let next = next_alternative(references, call.slot, call.alternative);
        request.awaits_provider = next.is_none();
        let sent = wiring.send(request, effects);
        if sent == Err(CallError::Unavailable) {
            // the provider runs, and its queue is full
            effects.emit(&Event::Dropped {
                component: effects.name,
                port,
                to: &wiring.to,
                total: wiring.queue.refused(),
                reason: None,
            });
        }
        sent
    }

    /// Cancels a call and notifies the provider. Does nothing if the call has ended.
    pub(crate) fn cancel(
        &mut self,
        references: &[RequiredReference],
        call: CallId,
        effects: &mut ComponentEffects<'_>,
    ) {
        let index = self.outstanding.iter().position(|one| one.number == call.0);
        let Some(call) = index.map(|index| self.outstanding.remove(index)) else {
            return;
        };
        notify_cancelled(references, &call, effects);
        let cancelled = Err(CallError::Cancelled);
        self.end(references, &call, cancelled, effects);
    }

    /// Ends the calls at an alternative of a reference whose service is removed; the service gets cancellations.
    pub(crate) fn disconnect(
        &mut self,
        references: &[RequiredReference],
        reference: usize,
        alternative: u32,
        effects: &mut ComponentEffects<'_>,
    ) {
        let through = |call: &mut OutstandingCall| {
            call.slot.port == reference && call.alternative == alternative
        };
        let ended: Vec<_> = self.outstanding.extract_if(.., through).collect();
        for call in ended {
            notify_cancelled(references, &call, effects);
            self.end(references, &call, Err(CallError::Unavailable), effects);
        }
    }

    /// Ends the calls that have a reply or have timed out. Returns whether any result waits for the next cycle.
    pub(crate) fn process_replies(
        &mut self,
        references: &[RequiredReference],
        effects: &mut ComponentEffects<'_>,
    ) -> bool {
        if self.last_number == 0 {
            // a component that has never called has no queue
            return false;
        }
        let queue = Arc::clone(&self.reply_queue);
        for _ in 0..queue.queue().len() {
            let Some(answer) = queue.queue().pop() else {
                break;
            };
            // without a match, the reply is to a call that has ended: too late
            let index = self
                .outstanding
                .iter()
                .position(|one| one.number == answer.number);
            if let Some(index) = index {
                let call = self.outstanding.remove(index);
                match answer.result {
                    Err(error)
                        if (error.is_without_provider() || error == CallError::Timeout)
                            && !call.waits_for_retry =>
                    {
                        self.handle_failure(references, call, error, effects);
                    }
                    result => self.end(references, &call, result, effects),
                }
            }
        }
        let now = effects.now;
        while let Some(index) = self.outstanding.iter().position(|one| one.deadline <= now) {
            let call = self.outstanding.remove(index);
            self.expire(references, call, effects);
        }
        !self.ended.is_empty()
    }

    /// Handles a call whose attempt has timed out or whose rest is over.
    fn expire(
        &mut self,
        references: &[RequiredReference],
        call: OutstandingCall,
        effects: &mut ComponentEffects<'_>,
    ) {
        if call.waits_for_retry {
            return self.retry(references, call, effects);
        }
        if wire_of(references, call.slot, call.alternative).cancel_on_timeout {
            notify_cancelled(references, &call, effects);
        }
        self.handle_failure(references, call, CallError::Timeout, effects);
    }

    /// Handles a failed attempt: goes on with the next alternative if this one has no provider, retries at once, retries
    /// after a rest, or ends the call. Without a provider a retry always rests first, because an immediate one would fail
    /// the same way.
    fn handle_failure(
        &mut self,
        references: &[RequiredReference],
        mut call: OutstandingCall,
        error: CallError,
        effects: &mut ComponentEffects<'_>,
    ) {
        let next = next_alternative(references, call.slot, call.alternative);
        if let Some(next) = next.filter(|_| error.is_without_provider()) {
            return self.fail_over(references, call, next, effects);
        }
        let wire = wire_of(references, call.slot, call.alternative);
        let delay = wire.retry_delay(call.attempt);
        let in_vain = error.is_without_provider() && delay.is_zero();
        if call.attempt > wire.retries || in_vain {
            return self.end(references, &call, Err(error), effects);
        }
        if delay.is_zero() {
            return self.retry(references, call, effects);
        }
        call.waits_for_retry = true;
        call.deadline = effects.now + delay;
        self.add_outstanding(call, effects);
    }

    /// Continues an attempt with another alternative.
    fn fail_over(
        &mut self,
        references: &[RequiredReference],
        mut call: OutstandingCall,
        next: u32,
        effects: &mut ComponentEffects<'_>,
    ) {
        call.alternative = next;
        let timeout = wire_of(references, call.slot, next).timeout;
        call.deadline = call.attempt_end.min(effects.now + timeout);
        match self.send_request(references, &call, effects) {
            Ok(()) => self.add_outstanding(call, effects),
            Err(error) => self.handle_failure(references, call, error, effects),
        }
    }

    fn retry(
        &mut self,
        references: &[RequiredReference],
        mut call: OutstandingCall,
        effects: &mut ComponentEffects<'_>,
    ) {
        call.attempt += 1;
        call.waits_for_retry = false;
        call.alternative = first_alternative(references, call.slot);
        call.attempt_end = effects.now + wire_of(references, call.slot, call.alternative).timeout;
        call.deadline = call.attempt_end;
        match self.send_request(references, &call, effects) {
            Ok(()) => self.add_outstanding(call, effects),
            Err(error) => self.handle_failure(references, call, error, effects),
        }
    }

    fn add_outstanding(&mut self, call: OutstandingCall, effects: &mut ComponentEffects<'_>) {
        effects.effects.wake_at(effects.component, call.deadline);
        self.outstanding.push(call);
    }

    fn end(
        &mut self,
        references: &[RequiredReference],
        call: &OutstandingCall,
        result: Result<Arc<dyn Sample>, CallError>,
        effects: &mut ComponentEffects<'_>,
    ) {
        let (reference, operation) = path_names(references, call.slot);
        effects.emit(&Event::Replied {
            component: effects.name,
            reference,
            operation,
            call: CallId(call.number),
            result: result.as_deref(),
        });
        self.ended.push(EndedCall {
            number: call.number,
            slot: call.slot,
            cause: call.cause,
            result,
        });
        effects.effects.trigger(effects.component);
    }

    /// Makes ended calls visible to the cycle that begins.
    pub(crate) fn freeze(&mut self) {
        self.frozen.append(&mut self.ended);
    }

    /// Removes and returns the ended calls of an operation.
    pub(crate) fn take(&mut self, slot: OperationSlot) -> Vec<EndedCall> {
        if self.frozen.is_empty() {
            return Vec::new();
        }
        self.frozen
            .extract_if(.., |ended| ended.slot == slot)
            .collect()
    }

    /// Removes and returns one ended call of an operation.
    pub(crate) fn take_reply(&mut self, slot: OperationSlot, call: CallId) -> Option<EndedCall> {
        let index = self
            .frozen
            .iter()
            .position(|ended| ended.slot == slot && ended.number == call.0)?;
        Some(self.frozen.remove(index))
    }

    /// Returns whether a call is outstanding, or has ended but is not visible to a cycle yet.
    pub(crate) fn is_under_way(&self, call: CallId) -> bool {
        let outstanding = self.outstanding.iter().map(|one| one.number);
        let ended = self.ended.iter().map(|one| one.number);
        outstanding.chain(ended).any(|number| number == call.0)
    }

    /// Cancels and forgets all calls, because the component stops running.
    pub(crate) fn abandon(
        &mut self,
        references: &[RequiredReference],
        effects: &mut ComponentEffects<'_>,
    ) {
        for call in std::mem::take(&mut self.outstanding) {
            notify_cancelled(references, &call, effects);
        }
        self.ended.clear();
        self.frozen.clear();
    }

    /// The earliest deadline of all outstanding calls.
    pub(crate) fn deadline(&self) -> Option<Time> {
        self.outstanding.iter().map(|call| call.deadline).min()
    }
}

/// Reports an attempt to the observers. Returns the names of its reference and operation.
fn emit_called<'r>(
    references: &'r [RequiredReference],
    call: &OutstandingCall,
    effects: &mut ComponentEffects<'_>,
) -> (&'r str, &'r str) {
    let (reference, operation) = path_names(references, call.slot);
    effects.emit(&Event::Called {
        component: effects.name,
        reference,
        operation,
        call: CallId(call.number),
        attempt: call.attempt,
        argument: &*call.argument,
    });
    (reference, operation)
}

/// The request of an attempt; without a return address, the call is one-way.
fn request(
    call: &OutstandingCall,
    operation: usize,
    reply_to: Option<ReplyTo>,
    effects: &ComponentEffects<'_>,
) -> ServiceRequest {
    ServiceRequest {
        key: CallKey {
            caller: effects.component,
            number: call.number,
        },
        operation,
        argument: Arc::clone(&call.argument),
        caller: Arc::clone(effects.name),
        deadline: reply_to.is_some().then_some(call.deadline),
        trace: call.cause,
        awaits_provider: true,
        reply_to,
    }
}

/// Sends a one-way call to services. Returns those that could not take it.
fn not_taken<'r>(
    services: &'r [Wiring],
    call: &OutstandingCall,
    effects: &mut ComponentEffects<'_>,
) -> Vec<&'r str> {
    let mut lost = Vec::new();
    for wiring in services {
        let operation = wiring.operations.get(call.slot.operation);
        let sent = operation
            .map(|operation| wiring.send(request(call, *operation, None, effects), effects));
        if !matches!(sent, Some(Ok(()))) {
            lost.push(&*wiring.to);
        }
    }
    lost
}

fn notify_cancelled(
    references: &[RequiredReference],
    call: &OutstandingCall,
    effects: &mut ComponentEffects<'_>,
) {
    let Some(wiring) = wiring_of(references, call.slot, call.alternative) else {
        return;
    };
    let key = CallKey {
        caller: effects.component,
        number: call.number,
    };
    // fails if the provider is stopped or its queue is full; a request that it already has ends at its deadline
    if wiring.queue.push(ProviderMessage::Cancel(key)).is_ok() {
        wiring.trigger(effects);
    }
}
