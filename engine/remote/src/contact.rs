//! A process' contact with others on the bus: it says what it is, and does what they want.

use std::collections::BTreeSet;
use std::sync::Arc;

use asmotion_assembly::{Part, Plan};
use asmotion_bus::{
    Bus, BusError, Call, Notifier, Origin, Overflow, Pattern, Payload, Queue, Refusal, Sending,
    Serving, Subscription,
};
use asmotion_datum::{Datum, Schema};
use asmotion_runtime::{Asked, Run};

use crate::herald::Herald;
use crate::{Begun, Newest, Order, Reason, control_address, presence_topic};

/// How many orders may wait.
const WAITING: usize = 16;

/// The contact of a process over a bus: attended to again and again while the system runs.
pub struct Contact<'p> {
    origin: Origin,
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
    /// A contact. What leaves the outputs is seen by `newest`, an observer of the system that no other contact has.
    ///
    /// # Errors
    /// The bus does not let us.
    pub fn new(
        plan: &'p Plan,
        part: Part,
        process: &str,
        bus: &'p dyn Bus,
        incarnation: u64,
        newest: Newest,
    ) -> Result<Self, BusError> {
        let notifier = Arc::new(Notifier::new());
        let everyone = Pattern::new(presence_topic("*"));
        let queue = Queue::All {
            size: 256,
            overflow: Overflow::DropOldest,
        };
        Ok(Self {
            origin: Origin::new(process, incarnation),
            presences: bus.subscribe(process, &everyone, queue, Arc::clone(&notifier))?,
            herald: Herald::new(plan, part, process, bus, incarnation)?,
            bus,
            orders: bus.serve(&control_address(process), WAITING, notifier)?,
            begun: Vec::new(),
            newest,
            known: BTreeSet::from([(process.into(), incarnation)]),
        })
    }

    /// Does what is due: carries out orders, greets newcomers, and speaks.
    pub fn attend(&mut self, run: &mut dyn Run) {
        while let Some(call) = self.orders.try_next() {
            match self.begin(&call, run) {
                Ok(Begun::Asked(asked)) => self.begun.push((call, asked)),
                Ok(Begun::Done(answer)) => call.reply(Ok(Payload::of(answer))),
                Ok(Begun::Watched(port, schema)) => call.reply(self.watch(&port, &schema)),
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
                    let done = done.map_err(|error| Reason::Refused.refusal(error));
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
    pub fn leave(&mut self) {
        self.herald.leave();
    }

    fn begin(&self, call: &Call, run: &mut dyn Run) -> Result<Begun, Refusal> {
        let order = call.argument.to_datum();
        let order: Order = order
            .and_then(|order| order.to())
            .map_err(|error| Reason::BadRequest.refusal(error))?;
        let begun = order.begin(run, &self.newest);
        begun.map_err(|error| error.reason().refusal(error))
    }

    /// Has an output published for a while; says on which topic.
    fn watch(&self, port: &str, schema: &Schema) -> Result<Payload, Refusal> {
        let topic = watch_topic(port);
        let publisher = || (self.bus).publisher(&topic, &self.origin, schema, Sending::state());
        let watched = self.newest.watch(port, publisher);
        watched.map_err(|error| Reason::Refused.refusal(error))?;
        Ok(Payload::of(Datum::text(topic)))
    }
}

/// Where a watched output is published: `watch.RoverDriver.odom`.
pub(crate) fn watch_topic(port: &str) -> String {
    format!("watch.{port}")
}
