//! Services that others on the bus may call: a request goes into the component's inbox like those from inside.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

use asmotion_bus::{BusError, Call, Refusal, Serving};
use asmotion_datum::Schema;

use super::Membership;
use crate::Time;
use crate::outside::Outside;
use crate::service::{AnswerTo, Ask, CallKey, Inbox};
use crate::system::{Offered, address};
use crate::unit::Unit;

/// How many requests of an operation may wait between two deliveries.
const WAITING: usize = 128;

/// All operations on offer.
pub(super) struct Offers {
    operations: Vec<Offer>,
    /// Number of the last request.
    last: u64,
}

/// An operation on offer.
struct Offer {
    /// The provider's place in the system.
    provider: usize,
    inbox: Arc<Inbox>,
    operation: usize,
    /// What it is asked with.
    argument: Schema,
    serving: Serving,
}

impl Offers {
    pub(super) fn new<'o>(
        units: &[Unit],
        offered: impl Iterator<Item = &'o Offered>,
        membership: &Membership,
    ) -> Result<Self, BusError> {
        let mut operations = Vec::new();
        let mut names = BTreeSet::new();
        // offered over several buses that are one here, it is offered once
        for Offered {
            service: end, name, ..
        } in offered.filter(|it| names.insert(&it.name))
        {
            let service = &units[end.unit].body.services[end.index];
            for (operation, declared) in service.declaration.operations.iter().enumerate() {
                let address = address(name, &declared.name);
                let bell = Arc::clone(&membership.bell);
                operations.push(Offer {
                    provider: end.unit,
                    inbox: Arc::clone(&service.inbox),
                    operation,
                    argument: declared.request.clone(),
                    serving: membership.bus.serve(&address, WAITING, bell)?,
                });
            }
        }
        Ok(Self {
            operations,
            last: 0,
        })
    }

    /// Hands over the requests that have come.
    pub(super) fn deliver(&mut self, now: Time, outside: &mut dyn Outside) {
        for offer in &self.operations {
            while let Some(call) = offer.serving.try_next() {
                self.last += 1;
                offer.take(call, self.last, now, outside);
            }
        }
    }
}

impl Offer {
    fn take(&self, call: Call, number: u64, now: Time, outside: &mut dyn Outside) {
        let argument = match call.argument.to_sample(&self.argument) {
            Ok(argument) => argument,
            Err(error) => {
                return call.reply(Err(Refusal {
                    code: "BAD_REQUEST".to_owned(),
                    detail: error.to_string(),
                }));
            }
        };
        let answered = !call.is_one_way();
        let left = call.deadline.saturating_duration_since(Instant::now());
        let ask = Ask {
            // Those from the bus are cancelled by their callers alone, not by number.
            key: CallKey {
                caller: usize::MAX,
                number,
            },
            operation: self.operation,
            argument,
            caller: Arc::clone(&call.origin.source),
            trace: call.trace,
            deadline: answered.then_some(now + left),
            answer_to: answered.then_some(AnswerTo::Bus(Box::new(call))),
        };
        // A caller whose request is not taken learns it when the request is dropped.
        if self.inbox.ask(ask, outside) == Ok(true) {
            outside.trigger(self.provider);
        }
    }
}
