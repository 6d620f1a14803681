//! A process' contact with others on the bus: it says what it is, and does what they want.

use std::collections::BTreeSet;
use std::sync::Arc;

use assembly::order::{Begun, Newest, Order, control_address};
use assembly::presence::presence_topic;
use assembly::{Part, Plan};
use bus::{
    Bell, Bus, BusError, Call, Overflow, Pattern, Payload, Queue, Refusal, Serving, Subscription,
};
use component::{Asked, Run};
use datum::Datum;

use super::herald::Herald;

/// How many orders may wait.
const WAITING: usize = 16;

/// The contact.
pub(super) struct Contact<'p> {
    herald: Herald<'p>,
    bus: &'p dyn Bus,
    orders: Serving,
    /// Orders that components have not carried out yet.
    begun: Vec<(Call, Asked)>,
    newest: Newest,
    presences: Subscription,
    /// The lives of processes that were heard.
    known: BTreeSet<(Arc<str>, u64)>,
}

impl<'p> Contact<'p> {
    pub(super) fn new(
        plan: &'p Plan,
        part: Part,
        process: &str,
        bus: &'p dyn Bus,
        incarnation: u64,
        newest: Newest,
    ) -> Result<Self, BusError> {
        let bell = Arc::new(Bell::new());
        let everyone = Pattern::new(presence_topic("*"));
        let queue = Queue::All {
            size: 256,
            overflow: Overflow::DropOldest,
        };
        Ok(Self {
            presences: bus.subscribe(process, &everyone, queue, Arc::clone(&bell))?,
            herald: Herald::new(plan, part, process, bus, incarnation)?,
            bus,
            orders: bus.serve(&control_address(process), WAITING, bell)?,
            begun: Vec::new(),
            newest,
            known: BTreeSet::from([(process.into(), incarnation)]),
        })
    }

    /// Does what is due: carries out orders, greets newcomers, and speaks.
    pub(super) fn attend(&mut self, run: &mut dyn Run) {
        while let Some(call) = self.orders.try_next() {
            match begin(&call, run, &self.newest) {
                Ok(Begun::Asked(asked)) => self.begun.push((call, asked)),
                Ok(Begun::Done(answer)) => call.reply(Ok(Payload::of(answer))),
                Err(refusal) => call.reply(Err(refusal)),
            }
        }
        self.reply();
        self.greet();
        self.herald.speak(run);
    }

    /// Answers the orders that have been carried out, and forgets those that nobody waits for any more.
    fn reply(&mut self) {
        for (call, asked) in std::mem::take(&mut self.begun) {
            match asked.try_take() {
                Some(done) => {
                    let done = done.map_err(|reason| refusal("REFUSED", reason));
                    call.reply(done.map(|()| Payload::of(Datum::Null)));
                    self.herald.hurry();
                }
                None if call.is_awaited() => self.begun.push((call, asked)),
                None => {}
            }
        }
    }

    /// A process that was not there before has missed what is published once: it is sent again.
    fn greet(&mut self) {
        let mut somebody = false;
        while let Some(presence) = self.presences.try_next() {
            somebody |= (self.known).insert((presence.source, presence.incarnation));
        }
        if somebody {
            self.bus.repeat();
        }
    }

    /// Says the last word.
    pub(super) fn leave(&mut self) {
        self.herald.leave();
    }
}

fn begin(call: &Call, run: &mut dyn Run, newest: &Newest) -> Result<Begun, Refusal> {
    let order = call.argument.to_datum();
    let order: Order = order
        .and_then(|order| order.to())
        .map_err(|error| refusal("BAD_REQUEST", error))?;
    let begun = order.begin(run, newest);
    begun.map_err(|reason| refusal(reason.code(), reason))
}

fn refusal(code: &str, reason: impl ToString) -> Refusal {
    Refusal {
        code: code.to_owned(),
        detail: reason.to_string(),
    }
}
