//! The caller's side: calls are outstanding until an answer, a cancellation or the deadline ends them.

use std::sync::Arc;

use asmotion_bus::Trace;
use asmotion_datum::Sample;
use crossbeam_queue::ArrayQueue;

use super::reference::{Reference, Slot, names, wire_of, wiring};
use super::{Answer, AnswerTo, Ask, CallError, CallId, CallKey, Post};
use crate::cause::Cause;
use crate::outside::{Leaving, Outside};
use crate::{Event, Time};

/// How many calls of one component may be under way; more find the provider unavailable.
const UNDER_WAY: usize = 128;

/// Where answers wait for their caller, shared with its providers.
pub(crate) struct Mailbox {
    queue: ArrayQueue<Answer>,
    /// The caller's place in the system.
    component: usize,
}

impl Mailbox {
    /// Leaves an answer. Should the box be full, the caller meets its deadline instead.
    pub(crate) fn put(&self, answer: Answer, outside: &mut dyn Outside) {
        if self.queue.push(answer).is_ok() {
            outside.trigger(self.component);
        }
    }
}

/// All calls of one component.
pub(crate) struct Caller {
    mailbox: Arc<Mailbox>,
    outstanding: Vec<Outstanding>,
    /// Ended, for the next cycle to see.
    ended: Vec<Ended>,
    /// Ended, and seen by the present cycle.
    frozen: Vec<Ended>,
    /// Number of the last call.
    last: u64,
    /// One-way calls that found nobody.
    lost: u64,
    /// What the present cycle follows from.
    cause: Arc<Cause>,
}

struct Outstanding {
    number: u64,
    slot: Slot,
    attempt: u32,
    /// When the attempt has waited long enough; or, when it has, when the next one is made.
    deadline: Time,
    /// Whether it rests between two attempts.
    resting: bool,
    /// Kept for another attempt.
    argument: Arc<dyn Sample>,
    /// What the cycle that made it followed from.
    cause: Option<Trace>,
}

/// The end of a call.
pub(crate) struct Ended {
    pub number: u64,
    slot: Slot,
    /// What the cycle that made it followed from.
    pub cause: Option<Trace>,
    pub result: Result<Arc<dyn Sample>, CallError>,
}

impl Caller {
    pub(crate) fn new(component: usize, cause: Arc<Cause>) -> Self {
        Self {
            mailbox: Arc::new(Mailbox {
                queue: ArrayQueue::new(UNDER_WAY),
                component,
            }),
            outstanding: Vec::new(),
            ended: Vec::new(),
            frozen: Vec::new(),
            last: 0,
            lost: 0,
            cause,
        }
    }

    /// A number for a call that a cycle is about to make.
    pub(crate) fn number(&mut self) -> CallId {
        self.last += 1;
        CallId(self.last)
    }

    /// Makes a call that a cycle has committed.
    pub(crate) fn call(
        &mut self,
        references: &[Reference],
        slot: Slot,
        number: u64,
        argument: Arc<dyn Sample>,
        one_way: bool,
        leaving: &mut Leaving<'_>,
    ) {
        let wire = wire_of(references, slot);
        let one_way = one_way || wire.one_way;
        let call = Outstanding {
            number,
            slot,
            attempt: 1,
            deadline: leaving.now + wire.timeout,
            resting: false,
            argument,
            cause: self.cause.present(),
        };
        if one_way {
            return self.tell(references, &call, leaving);
        }
        let full = self.outstanding.len() + self.ended.len() + self.frozen.len() >= UNDER_WAY;
        if full {
            return self.end(references, &call, Err(CallError::Unavailable), leaving);
        }
        match self.post(references, &call, leaving) {
            Ok(()) => self.await_until(call, leaving),
            Err(error) => self.failed(references, call, error, leaving),
        }
    }

    /// Tells every service; what one does not hear is counted.
    fn tell(&mut self, references: &[Reference], call: &Outstanding, leaving: &mut Leaving<'_>) {
        let (port, _) = announce(references, call, leaving);
        let wirings = references.get(call.slot.port).map(|it| &*it.wirings);
        let wirings = wirings.unwrap_or_default();
        let mut lose = |to: &str, leaving: &mut Leaving<'_>| {
            self.lost += 1;
            leaving.emit(&Event::Dropped {
                component: leaving.name,
                port,
                to,
                total: self.lost,
                reason: None,
            });
        };
        if wirings.is_empty() {
            lose("", leaving);
        }
        for wiring in wirings {
            let told = wiring
                .operations
                .get(call.slot.operation)
                .map(|operation| wiring.ask(question(call, *operation, None, leaving), leaving));
            if !matches!(told, Some(Ok(()))) {
                lose(&wiring.to, leaving);
            }
        }
    }

    /// One attempt.
    fn post(
        &self,
        references: &[Reference],
        call: &Outstanding,
        leaving: &mut Leaving<'_>,
    ) -> Result<(), CallError> {
        announce(references, call, leaving);
        let wiring = wiring(references, call.slot).ok_or(CallError::Unavailable)?;
        let operation = wiring.operations.get(call.slot.operation);
        let operation = *operation.ok_or(CallError::Unavailable)?;
        let answer_to = AnswerTo::Here(Arc::clone(&self.mailbox));
        let ask = question(call, operation, Some(answer_to), leaving);
        wiring.ask(ask, leaving)
    }

    /// Takes back a call; the provider is told. A call that has ended stays ended.
    pub(crate) fn cancel(
        &mut self,
        references: &[Reference],
        call: CallId,
        leaving: &mut Leaving<'_>,
    ) {
        let found = self.outstanding.iter().position(|one| one.number == call.0);
        let Some(call) = found.map(|index| self.outstanding.remove(index)) else {
            return;
        };
        tell_cancelled(references, &call, leaving);
        let cancelled = Err(CallError::Cancelled);
        self.end(references, &call, cancelled, leaving);
    }

    /// Ends the calls through a reference, whose service goes; that is told.
    pub(crate) fn part(
        &mut self,
        references: &[Reference],
        reference: usize,
        leaving: &mut Leaving<'_>,
    ) {
        let through = |call: &mut Outstanding| call.slot.port == reference;
        let ended: Vec<_> = self.outstanding.extract_if(.., through).collect();
        for call in ended {
            tell_cancelled(references, &call, leaving);
            self.end(references, &call, Err(CallError::Unavailable), leaving);
        }
    }

    /// Ends what has been answered and what has waited too long. Says whether anything waits for the next cycle.
    pub(crate) fn settle(&mut self, references: &[Reference], leaving: &mut Leaving<'_>) -> bool {
        for _ in 0..self.mailbox.queue.len() {
            let Some(answer) = self.mailbox.queue.pop() else {
                break;
            };
            // An answer to a call that has ended is too late.
            let found = (self.outstanding.iter()).position(|one| one.number == answer.number);
            if let Some(index) = found {
                let call = self.outstanding.remove(index);
                match answer.result {
                    Err(CallError::Unavailable) if !call.resting => {
                        self.failed(references, call, CallError::Unavailable, leaving);
                    }
                    result => self.end(references, &call, result, leaving),
                }
            }
        }
        let now = leaving.now;
        while let Some(index) = self.outstanding.iter().position(|one| one.deadline <= now) {
            let call = self.outstanding.remove(index);
            self.expire(references, call, leaving);
        }
        !self.ended.is_empty()
    }

    /// An attempt has waited long enough, or rested.
    fn expire(&mut self, references: &[Reference], call: Outstanding, leaving: &mut Leaving<'_>) {
        if call.resting {
            return self.try_again(references, call, leaving);
        }
        if wire_of(references, call.slot).cancel_on_timeout {
            tell_cancelled(references, &call, leaving);
        }
        self.failed(references, call, CallError::Timeout, leaving);
    }

    /// An attempt got no answer: another one, at once or after a rest, or the end. Who found nobody tries again only
    /// after a rest: at once, nobody would be there again.
    fn failed(
        &mut self,
        references: &[Reference],
        mut call: Outstanding,
        error: CallError,
        leaving: &mut Leaving<'_>,
    ) {
        let wire = wire_of(references, call.slot);
        let rest = wire.rest_after(call.attempt);
        let in_vain = error == CallError::Unavailable && rest.is_zero();
        if call.attempt > wire.retries || in_vain {
            return self.end(references, &call, Err(error), leaving);
        }
        if rest.is_zero() {
            return self.try_again(references, call, leaving);
        }
        call.resting = true;
        call.deadline = leaving.now + rest;
        self.await_until(call, leaving);
    }

    fn try_again(
        &mut self,
        references: &[Reference],
        mut call: Outstanding,
        leaving: &mut Leaving<'_>,
    ) {
        call.attempt += 1;
        call.resting = false;
        call.deadline = leaving.now + wire_of(references, call.slot).timeout;
        match self.post(references, &call, leaving) {
            Ok(()) => self.await_until(call, leaving),
            Err(error) => self.failed(references, call, error, leaving),
        }
    }

    fn await_until(&mut self, call: Outstanding, leaving: &mut Leaving<'_>) {
        leaving.outside.wake_at(leaving.me, call.deadline);
        self.outstanding.push(call);
    }

    fn end(
        &mut self,
        references: &[Reference],
        call: &Outstanding,
        result: Result<Arc<dyn Sample>, CallError>,
        leaving: &mut Leaving<'_>,
    ) {
        let (reference, operation) = names(references, call.slot);
        leaving.emit(&Event::Replied {
            component: leaving.name,
            reference,
            operation,
            call: CallId(call.number),
            result: result.as_deref(),
        });
        self.ended.push(Ended {
            number: call.number,
            slot: call.slot,
            cause: call.cause,
            result,
        });
        leaving.outside.trigger(leaving.me);
    }

    /// What has ended becomes visible to the cycle that begins.
    pub(crate) fn freeze(&mut self) {
        self.frozen.append(&mut self.ended);
    }

    /// Hands over the ended calls of an operation.
    pub(crate) fn take(&mut self, slot: Slot) -> Vec<Ended> {
        if self.frozen.is_empty() {
            return Vec::new();
        }
        self.frozen
            .extract_if(.., |ended| ended.slot == slot)
            .collect()
    }

    /// Hands over one ended call of an operation.
    pub(crate) fn take_one(&mut self, slot: Slot, call: CallId) -> Option<Ended> {
        let found =
            (self.frozen.iter()).position(|ended| ended.slot == slot && ended.number == call.0)?;
        Some(self.frozen.remove(found))
    }

    /// Whether a call has not come to its end, or to where a cycle can see it.
    pub(crate) fn is_under_way(&self, call: CallId) -> bool {
        let outstanding = self.outstanding.iter().map(|one| one.number);
        let ended = self.ended.iter().map(|one| one.number);
        outstanding.chain(ended).any(|number| number == call.0)
    }

    /// Forgets all calls: the component ends running, and nobody waits for the answers.
    pub(crate) fn abandon(&mut self, references: &[Reference], leaving: &mut Leaving<'_>) {
        for call in std::mem::take(&mut self.outstanding) {
            tell_cancelled(references, &call, leaving);
        }
        self.ended.clear();
        self.frozen.clear();
    }

    /// The next deadline.
    pub(crate) fn deadline(&self) -> Option<Time> {
        self.outstanding.iter().map(|call| call.deadline).min()
    }
}

/// Tells the observers of an attempt; says which reference and operation it is of.
fn announce<'r>(
    references: &'r [Reference],
    call: &Outstanding,
    leaving: &mut Leaving<'_>,
) -> (&'r str, &'r str) {
    let (reference, operation) = names(references, call.slot);
    leaving.emit(&Event::Called {
        component: leaving.name,
        reference,
        operation,
        call: CallId(call.number),
        attempt: call.attempt,
        argument: &*call.argument,
    });
    (reference, operation)
}

/// What a service is asked; without a return address it is told.
fn question(
    call: &Outstanding,
    operation: usize,
    answer_to: Option<AnswerTo>,
    leaving: &Leaving<'_>,
) -> Ask {
    Ask {
        key: CallKey {
            caller: leaving.me,
            number: call.number,
        },
        operation,
        argument: Arc::clone(&call.argument),
        caller: Arc::clone(leaving.name),
        deadline: answer_to.is_some().then_some(call.deadline),
        trace: call.cause,
        answer_to,
    }
}

fn tell_cancelled(references: &[Reference], call: &Outstanding, leaving: &mut Leaving<'_>) {
    let Some(wiring) = wiring(references, call.slot) else {
        return;
    };
    let key = CallKey {
        caller: leaving.me,
        number: call.number,
    };
    // A provider that cannot be told is not at work on it either, or will see the deadline.
    if wiring.inbox.post(Post::Cancel(key)).is_ok() {
        wiring.trigger(leaving);
    }
}
