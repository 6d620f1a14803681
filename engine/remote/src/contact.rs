//! The contact of a process with others on the bus: publishes its presence and carries out their orders.

use std::collections::BTreeSet;
use std::sync::Arc;

use asmotion_bus::{
    Bus, BusError, IncomingCall, Notifier, Overflow, Pattern, Payload, PublishOptions, QueuePolicy,
    Refusal, SenderId, ServedAddress, Subscription,
};
use asmotion_datum::{Datum, Schema};
use asmotion_plan::{Part, Plan};
use asmotion_runtime::{Asked, Run};

use crate::last_samples::LastSamples;
use crate::order::{Order, OrderOutcome, control_address};
use crate::order_error::OrderErrorCode;
use crate::presence::presence_topic;
use crate::presence_publisher::PresencePublisher;

/// Capacity of the queue of orders.
const WAITING: usize = 16;

/// The contact of a process over a bus. [`attend`](Self::attend) must be called regularly while the system runs.
pub struct ProcessContact<'p> {
    origin: SenderId,
    herald: PresencePublisher<'p>,
    bus: &'p dyn Bus,
    orders: ServedAddress,
    /// Orders that components have not carried out yet.
    begun: Vec<(IncomingCall, Asked)>,
    newest: LastSamples,
    presences: Subscription,
    /// The processes whose presence has been received, each with its incarnation.
    known: BTreeSet<(Arc<str>, u64)>,
}

impl<'p> ProcessContact<'p> {
    /// Creates the contact. `newest` must be an observer of the system, and no other contact may use it.
    ///
    /// # Errors
    /// An error of the bus, for example a missing permission.
    pub fn new(
        plan: &'p Plan,
        part: Part,
        process: &str,
        bus: &'p dyn Bus,
        incarnation: u64,
        newest: LastSamples,
    ) -> Result<Self, BusError> {
        let notifier = Arc::new(Notifier::new());
        let everyone = Pattern::new(presence_topic("*"));
        let queue = QueuePolicy::All {
            size: 256,
            overflow: Overflow::DropOldest,
        };
        Ok(Self {
            origin: SenderId::new(process, incarnation),
            presences: bus.subscribe(process, &everyone, queue, Arc::clone(&notifier))?,
            herald: PresencePublisher::new(plan, part, process, bus, incarnation)?,
            bus,
            orders: bus.serve(&control_address(process), WAITING, notifier)?,
            begun: Vec::new(),
            newest,
            known: BTreeSet::from([(process.into(), incarnation)]),
        })
    }

    /// Does the work that is due: carries out orders, sends its presence to newcomers, and publishes it once a second.
    pub fn attend(&mut self, run: &mut dyn Run) {
        while let Some(call) = self.orders.try_next() {
            match self.begin(&call, run) {
                Ok(OrderOutcome::Asked(asked)) => self.begun.push((call, asked)),
                Ok(OrderOutcome::Done(answer)) => call.reply(Ok(Payload::of(answer))),
                Ok(OrderOutcome::Watched(port, schema)) => call.reply(self.watch(&port, &schema)),
                Err(refusal) => call.reply(Err(refusal)),
            }
        }
        self.reply();
        self.repeat_for_new_processes();
        self.herald.speak(run);
    }

    /// Replies to the orders that have been carried out, and drops those whose callers no longer wait.
    fn reply(&mut self) {
        for (call, asked) in std::mem::take(&mut self.begun) {
            match asked.try_take() {
                Some(done) => {
                    let done = done.map_err(|error| OrderErrorCode::Refused.refusal(error));
                    call.reply(done.map(|()| Payload::of(Datum::Null)));
                    self.herald.hurry();
                }
                None if call.is_awaited() => self.begun.push((call, asked)),
                None => {}
            }
        }
    }

    /// Publishes the presence early if a new process has appeared, because it may have missed messages published only
    /// once.
    fn repeat_for_new_processes(&mut self) {
        let mut is_new = false;
        while let Some(presence) = self.presences.try_next() {
            is_new |= self.known.insert((presence.source, presence.incarnation));
        }
        if is_new {
            self.bus.repeat();
        }
    }

    /// Publishes that the process leaves.
    pub fn leave(&mut self) {
        self.herald.leave();
    }

    fn begin(&self, call: &IncomingCall, run: &mut dyn Run) -> Result<OrderOutcome, Refusal> {
        let order = call.argument.to_datum();
        let order: Order = order
            .and_then(|order| order.to())
            .map_err(|error| OrderErrorCode::BadRequest.refusal(error))?;
        let begun = order.begin(run, &self.newest);
        begun.map_err(|error| error.reason().refusal(error))
    }

    /// Publishes an output for the duration of a lease. Returns the topic.
    fn watch(&self, port: &str, schema: &Schema) -> Result<Payload, Refusal> {
        let topic = watch_topic(port);
        let publisher = || {
            self.bus
                .publisher(&topic, &self.origin, schema, PublishOptions::state())
        };
        let watched = self.newest.watch(port, publisher);
        watched.map_err(|error| OrderErrorCode::Refused.refusal(error))?;
        Ok(Payload::of(Datum::text(topic)))
    }
}

/// The topic of a watched output, for example `watch.RoverDriver.odom`.
pub(crate) fn watch_topic(port: &str) -> String {
    format!("watch.{port}")
}
