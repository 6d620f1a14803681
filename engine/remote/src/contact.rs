//! The contact of a process with others on the bus: publishes its presence and carries out their orders.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

use asmotion_bus::{
    Bus, BusError, IncomingCall, Notifier, Overflow, Pattern, Payload, PublishOptions, QueuePolicy,
    Refusal, SenderId, ServedAddress, Subscription,
};
use asmotion_component::Time;
use asmotion_datum::{Datum, Schema};
use asmotion_network::RobotService;
use asmotion_plan::{Part, Plan};
use asmotion_runtime::{Asked, Run};

use crate::clock::{ClockOffset, ClockWatch};
use crate::command::{CommandOutcome, CommandRecord};
use crate::last_samples::{LastSamples, now};
use crate::order::{Order, OrderOutcome, control_address};
use crate::order_error::OrderErrorCode;
use crate::presence::{RobotPresence, presence_topic};
use crate::presence_publisher::PresencePublisher;
use crate::robot_watch::RobotWatch;

/// Limit on the commands that the owner has not taken. The newest ones are kept.
const MAX_COMMANDS: usize = 1024;

/// Limit on the length of the words of a command, in characters.
const MAX_WORDS: usize = 400;

/// Capacity of the queue of orders.
const WAITING: usize = 16;

/// The contact of a process over a bus. [`process_orders`](Self::process_orders) must be called regularly while the
/// system runs.
pub struct ProcessContact<'p> {
    origin: SenderId,
    presence_publisher: PresencePublisher<'p>,
    bus: &'p dyn Bus,
    order_address: ServedAddress,
    /// Orders that components have not carried out yet.
    pending_orders: Vec<PendingOrder>,
    /// Commands since the owner took them, with their times.
    commands: VecDeque<(Time, CommandRecord)>,
    keeps_commands: bool,
    /// Number of commands so far.
    command_count: u64,
    last_samples: LastSamples,
    presences: Subscription,
    /// The processes whose presence has been received, each with its incarnation and its version.
    known_processes: BTreeSet<(Arc<str>, u64, u64)>,
    clocks: ClockWatch,
    /// Clocks that differ from ours, not yet taken by the owner.
    wrong_clocks: Vec<ClockOffset>,
    /// Services of other robots.
    robot_watch: RobotWatch,
    /// What is wrong with services of other robots, not yet taken by the owner.
    robot_problems: Vec<String>,
}

/// An order that a component has not carried out yet.
struct PendingOrder {
    call: IncomingCall,
    asked: Asked,
    command: CommandRecord,
}

impl<'p> ProcessContact<'p> {
    /// Creates the contact. `last_samples` must be an observer of the system, and no other contact may use it.
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
            presence_publisher: PresencePublisher::new(plan, part, process, bus, incarnation)?,
            bus,
            order_address: bus.serve(&control_address(process), WAITING, notifier)?,
            pending_orders: Vec::new(),
            commands: VecDeque::new(),
            keeps_commands: true,
            command_count: 0,
            last_samples: newest,
            known_processes: BTreeSet::from([(process.into(), incarnation, 0)]),
            clocks: ClockWatch::default(),
            wrong_clocks: Vec::new(),
            robot_watch: RobotWatch::default(),
            robot_problems: Vec::new(),
        })
    }

    /// Keeps no records of commands, because the caller of this bus, such as the dashboard, keeps them itself.
    #[must_use]
    pub fn without_commands(self) -> Self {
        Self {
            keeps_commands: false,
            ..self
        }
    }

    /// Compares services of other robots, in addition to those before, with what these announce on the bus. Services that nothing
    /// calls any more are forgotten.
    ///
    /// # Errors
    /// An error of the bus, for example a missing permission.
    pub fn watch_robots(&mut self, services: Vec<Arc<RobotService>>) -> Result<(), BusError> {
        self.robot_watch.forget_uncalled();
        self.robot_watch.add(self.bus, services)
    }

    /// Does the work that is due: carries out orders, sends its presence to newcomers, and publishes it once a second.
    pub fn process_orders(&mut self, run: &mut dyn Run) {
        while let Some(call) = self.order_address.try_next() {
            self.process_order(call, run);
        }
        self.reply_to_orders(run.now());
        self.publish_for_new_processes();
        self.robot_problems.extend(self.robot_watch.process());
        self.presence_publisher.publish_if_due(run);
    }

    fn process_order(&mut self, call: IncomingCall, run: &mut dyn Run) {
        let order = match order_of(&call) {
            Ok(order) => order,
            Err(refusal) => return call.reply(Err(refusal)),
        };
        let command = self.command_of(&order, &call);
        let outcome = order.begin(run, &self.last_samples);
        match outcome.map_err(|error| error.reason().refusal(error)) {
            Ok(OrderOutcome::Pending(asked)) => {
                self.note(run.now(), command.clone());
                self.pending_orders.push(PendingOrder {
                    call,
                    asked,
                    command,
                });
            }
            Ok(OrderOutcome::Done(answer)) => {
                if !order.wish.is_question() {
                    let done = command.ended(CommandOutcome::Done, String::new());
                    self.note(run.now(), done);
                }
                call.reply(Ok(Payload::of(answer)));
            }
            Ok(OrderOutcome::Watched(port, schema)) => call.reply(self.watch(&port, &schema)),
            Err(refusal) => {
                if !order.wish.is_question() {
                    let reason = refusal.detail.clone();
                    self.note(run.now(), command.ended(CommandOutcome::Refused, reason));
                }
                call.reply(Err(refusal));
            }
        }
    }

    /// The command that an order is, before it is carried out.
    fn command_of(&mut self, order: &Order, call: &IncomingCall) -> CommandRecord {
        self.command_count += u64::from(!order.wish.is_question());
        CommandRecord {
            number: self.command_count,
            client: call.origin.source.to_string(),
            text: order.to_string().chars().take(MAX_WORDS).collect(),
            ..CommandRecord::default()
        }
    }

    fn note(&mut self, at: Time, command: CommandRecord) {
        if !self.keeps_commands {
            return;
        }
        if self.commands.len() == MAX_COMMANDS {
            self.commands.pop_front();
        }
        self.commands.push_back((at, command));
    }

    /// Takes the commands of others since the last call, each with the time of the run at which it was asked or had ended. Orders
    /// that only ask for something are not among them.
    pub fn take_commands(&mut self) -> Vec<(Time, CommandRecord)> {
        self.commands.drain(..).collect()
    }

    /// Replies to the orders that have been carried out, and drops those whose callers no longer wait.
    fn reply_to_orders(&mut self, now: Time) {
        for pending in std::mem::take(&mut self.pending_orders) {
            let PendingOrder {
                call,
                asked,
                command,
            } = pending;
            match asked.try_take() {
                Some(result) => {
                    let (outcome, reason) = match &result {
                        Ok(()) => (CommandOutcome::Done, String::new()),
                        Err(error) => (CommandOutcome::Refused, error.to_string()),
                    };
                    self.note(now, command.ended(outcome, reason));
                    let done = result.map_err(|error| OrderErrorCode::Refused.refusal(error));
                    call.reply(done.map(|()| Payload::of(Datum::Null)));
                    self.presence_publisher.publish_soon();
                }
                None if call.is_awaited() => self.pending_orders.push(PendingOrder {
                    call,
                    asked,
                    command,
                }),
                None => {
                    let reason = "nobody waited for it any longer".to_owned();
                    self.note(now, command.ended(CommandOutcome::Unknown, reason));
                }
            }
        }
    }

    /// Takes the clocks of other processes of the robot that have been found to differ from ours by more than
    /// [`CLOCK_TOLERANCE`](crate::CLOCK_TOLERANCE). Each process is returned once.
    pub fn take_wrong_clocks(&mut self) -> Vec<ClockOffset> {
        std::mem::take(&mut self.wrong_clocks)
    }

    /// Takes what is wrong with services of other robots that run, but do not have them. Each is returned once.
    pub fn take_robot_problems(&mut self) -> Vec<String> {
        std::mem::take(&mut self.robot_problems)
    }

    /// Sends retained messages again if a new process has appeared, or one has changed to another version: its new inputs may
    /// have missed messages published only once. Compares the clocks of all.
    fn publish_for_new_processes(&mut self) {
        let mut is_new = false;
        while let Some(presence) = self.presences.try_next() {
            self.wrong_clocks
                .extend(self.clocks.record(&presence, now()));
            let version = RobotPresence::of(&presence).map_or(0, |it| it.presence.version);
            is_new |= self
                .known_processes
                .insert((presence.source, presence.incarnation, version));
        }
        if is_new {
            self.bus.republish_retained();
        }
    }

    /// Describes another version of the system from now on: its components, topics, connections and wires.
    pub fn follow(&mut self, plan: &Plan, part: &Part) {
        self.presence_publisher.follow(plan, part);
    }

    /// Notes how the components are at the end of the run, before they are stopped: [`leave`](Self::leave) publishes it.
    pub fn describe_end(&mut self, run: &mut dyn Run) {
        self.presence_publisher.describe_end(run);
    }

    /// Publishes that the process leaves.
    pub fn leave(&mut self) {
        self.presence_publisher.publish_departure();
    }

    /// Publishes an output for the duration of a lease. Returns the topic.
    fn watch(&self, port: &str, schema: &Schema) -> Result<Payload, Refusal> {
        let topic = watch_topic(port);
        let publisher = || {
            self.bus
                .publisher(&topic, &self.origin, schema, PublishOptions::state())
        };
        let watched = self.last_samples.watch(port, publisher);
        watched.map_err(|error| OrderErrorCode::Refused.refusal(error))?;
        Ok(Payload::of(Datum::text(topic)))
    }
}

/// The order of a call.
fn order_of(call: &IncomingCall) -> Result<Order, Refusal> {
    let order = call.argument.to_datum();
    order
        .and_then(|order| order.to())
        .map_err(|error| OrderErrorCode::BadRequest.refusal(error))
}

/// The topic of a watched output, for example `watch.RoverDriver.odom`.
pub(crate) fn watch_topic(port: &str) -> String {
    format!("watch.{port}")
}
