//! Services of others on the bus that a reference reaches: what its component posts is called, what is answered is put
//! into the component's mailbox. To the component, a service beyond the bus is one like another.

use std::sync::Arc;
use std::time::Duration;

use asmotion_bus::{CallFailure, Origin, Payload, Pending, Request, Spans};
use asmotion_datum::{Datum, Message, Sample};

use super::Membership;
use crate::outside::Outside;
use crate::service::{AnswerTo, Ask, CallError, CallKey, Inbox, Post, ServiceFault};
use crate::{Event, Time};

/// The way from a reference to a service beyond the bus.
pub(crate) struct Way {
    /// Where the component leaves its calls.
    pub inbox: Arc<Inbox>,
    /// Of each operation of the reference.
    pub addresses: Vec<String>,
    /// How long a call that nobody waits for may be under way.
    pub timeout: Duration,
}

/// A service that a reference reaches.
pub(super) struct Reached {
    way: Way,
    membership: Arc<Membership>,
    open: Vec<Open>,
    /// One-way calls that found nobody.
    lost: u64,
}

/// A call under way.
struct Open {
    key: CallKey,
    /// Who hears of its end.
    caller: Caller,
    pending: Pending,
}

/// Who hears of a call's end.
enum Caller {
    /// The component, by an answer.
    Waits(AnswerTo),
    /// The observers, if it went nowhere.
    Tells {
        component: Arc<str>,
        address: String,
    },
}

impl Reached {
    pub(super) fn new(way: Way, membership: Arc<Membership>) -> Self {
        Self {
            way,
            membership,
            open: Vec::new(),
            lost: 0,
        }
    }

    /// Sends what was posted, and hands over what was answered.
    pub(super) fn deliver(&mut self, now: Time, outside: &mut dyn Outside) {
        while let Some(post) = self.way.inbox.next() {
            match post {
                Post::Ask(ask) => self.send(ask, now, outside),
                Post::Cancel(key) => self.cancel(key),
            }
        }
        let mut index = 0;
        while let Some(open) = self.open.get(index) {
            match open.pending.try_take() {
                None => index += 1,
                Some(end) => {
                    let Open { key, caller, .. } = self.open.remove(index);
                    self.end(key, caller, end, now, outside);
                }
            }
        }
    }

    fn send(&mut self, ask: Ask, now: Time, outside: &mut dyn Outside) {
        let address = self.way.addresses.get(ask.operation).cloned();
        let address = address.unwrap_or_default();
        let Membership { bus, bell, .. } = &*self.membership;
        let left = ask.deadline.map(|deadline| deadline.since(now));
        let request = Request::new(
            Origin::new(Arc::clone(&ask.caller), self.membership.incarnation),
            Payload::Sample(ask.argument),
            left.unwrap_or(self.way.timeout),
        );
        let spans = Spans::new(&ask.caller, self.membership.incarnation, &address);
        let request = request.within(spans.of(ask.key.number, ask.trace));
        let bell = Arc::clone(bell);
        let (sent, caller) = match ask.answer_to {
            Some(answer_to) => {
                let sent = bus.call(&address, request, bell);
                (sent, Caller::Waits(answer_to))
            }
            None => {
                let sent = bus.tell(&address, request, bell);
                let component = ask.caller;
                (sent, Caller::Tells { component, address })
            }
        };
        let key = ask.key;
        match sent {
            Ok(pending) => self.open.push(Open {
                key,
                caller,
                pending,
            }),
            Err(_) => self.end(key, caller, Err(CallFailure::Unavailable), now, outside),
        }
    }

    fn cancel(&mut self, key: CallKey) {
        let cancelled = self.open.extract_if(.., |open| {
            open.key == key && matches!(open.caller, Caller::Waits(_))
        });
        for open in cancelled {
            open.pending.cancel();
        }
    }

    fn end(
        &mut self,
        key: CallKey,
        caller: Caller,
        end: Result<Payload, CallFailure>,
        now: Time,
        outside: &mut dyn Outside,
    ) {
        match (caller, end) {
            // The caller's own clock ends it, or has it tried again.
            (Caller::Waits(_), Err(CallFailure::Timeout | CallFailure::Cancelled)) => {}
            (Caller::Waits(answer_to), Err(CallFailure::Unavailable)) => {
                answer_to.send(key.number, Err(CallError::Unavailable), outside);
            }
            (Caller::Waits(answer_to), Err(CallFailure::Refused(refusal))) => {
                let fault = ServiceFault::new(refusal.code, refusal.detail);
                answer_to.send(key.number, Err(CallError::Fault(fault)), outside);
            }
            (Caller::Waits(answer_to), Ok(payload)) => {
                answer_to.send(key.number, read(&payload), outside);
            }
            (Caller::Tells { .. }, Ok(_)) => {}
            (Caller::Tells { component, address }, Err(_)) => {
                self.lost += 1;
                outside.emit(
                    now,
                    &Event::Dropped {
                        component: &component,
                        port: "",
                        to: &address,
                        total: self.lost,
                        reason: None,
                    },
                );
            }
        }
    }
}

fn read(payload: &Payload) -> Result<Arc<dyn Sample>, CallError> {
    payload
        .to_sample(Datum::schema())
        .map_err(|error| CallError::Fault(ServiceFault::new("BAD_REPLY", error.to_string())))
}
