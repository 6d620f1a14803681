//! The outside end: finds systems on a bus and gives access to their components.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

#[cfg(feature = "amqp")]
use asmotion_amqp::{AmqpBus, AmqpSettings};
use asmotion_bus::{
    Bus, BusError, CallFailure, Notifier, Overflow, Pattern, Payload, PendingCall, QueuePolicy,
    Request, SenderId, Subscription,
};
use asmotion_datum::Datum;
use asmotion_diagnostics::similar;
use asmotion_network::call_error;

use crate::error::RemoteError;
use crate::levels::with_levels_left_out;
use crate::order::{Order, OrderKind, control_address};
use crate::presence::{RobotPresence, key, operations};
use crate::roster::{ComponentLocation, Roster, WORDS, find_component};

/// Timeout of the connection to a broker.
#[cfg(feature = "amqp")]
const CONNECT: Duration = Duration::from_secs(10);
/// Time after which every running process has published its presence, which happens once a second.
const LISTEN: Duration = Duration::from_millis(1500);
/// Time after which no process is taken to run. It is longer than [`LISTEN`], because "nobody is there" on a busy machine, whose
/// only process is late, would be wrong, while a list from which one is missing is corrected by the next.
const NOBODY: Duration = Duration::from_secs(4);
/// Timeout of an order.
const PATIENCE: Duration = Duration::from_secs(10);
/// The sender name of this program on the bus.
const TOOL: &str = "asmotion-tool";

/// The systems on a bus, or one robot among them. Clones share the state; any number may exist, on any buses.
#[derive(Clone)]
pub struct Remote(Arc<RemoteState>);

struct RemoteState {
    bus: Arc<dyn Bus>,
    /// The robot to which lookups are restricted; `None` for all.
    robot: Option<String>,
    roster: Mutex<Roster>,
    /// Time of the connection to the bus.
    connected_at: Instant,
}

impl Remote {
    /// Connects to the systems on a broker, `amqp://user:password@host:port/vhost`, or to one robot if `robot` names
    /// it.
    ///
    /// # Errors
    /// An error if the address is invalid, or if the broker is unreachable or refuses the connection.
    #[cfg(feature = "amqp")]
    pub fn connect(url: &str, robot: Option<&str>) -> Result<Self, RemoteError> {
        let mut settings = AmqpSettings::parse(url)?;
        settings.process = TOOL.to_owned();
        Self::over_bus(Arc::new(AmqpBus::connect(settings, CONNECT)?), robot)
    }

    /// Connects to the systems on any bus, or to one robot if `robot` names it.
    ///
    /// # Errors
    /// An error of the bus.
    pub fn over_bus(bus: Arc<dyn Bus>, robot: Option<&str>) -> Result<Self, RemoteError> {
        let presences = listen(&*bus, WORDS)?;
        Ok(Self(Arc::new(RemoteState {
            bus,
            robot: robot.map(str::to_owned),
            roster: Mutex::new(Roster::new(presences)),
            connected_at: Instant::now(),
        })))
    }

    /// The bus to which this is connected.
    pub fn bus(&self) -> &Arc<dyn Bus> {
        &self.0.bus
    }

    /// Subscribes to all topics that match a pattern. Topics are full routing keys, including the robot.
    ///
    /// # Errors
    /// An error of the bus.
    pub fn listen(&self, pattern: &str) -> Result<Subscription, RemoteError> {
        Ok(listen(&*self.0.bus, pattern)?)
    }

    /// The running processes with their newest presence. The first call waits 1.5 s, until every process has published its
    /// own, and up to 4 s for the first one.
    pub fn processes(&self) -> Vec<RobotPresence> {
        self.complete_roster().presences(self.robot())
    }

    /// The running processes, as [`processes`](Self::processes), but waits until `are_all` accepts them, at most until 4 s after the
    /// connection: on a busy machine, a presence can be late.
    pub fn processes_until(
        &self,
        are_all: impl Fn(&[RobotPresence]) -> bool,
    ) -> Vec<RobotPresence> {
        loop {
            let found = self.processes();
            let remaining = NOBODY.saturating_sub(self.0.connected_at.elapsed());
            if remaining.is_zero() || are_all(&found) {
                return found;
            }
            self.roster().listen(remaining);
        }
    }

    /// Sends an order to a component's process and waits for the reply.
    pub(crate) fn order(
        &self,
        of: &ComponentLocation,
        order: OrderKind,
    ) -> Result<Datum, RemoteError> {
        let (address, order) = envelope(of, order)?;
        let request = request(order, PATIENCE);
        let pending = self
            .0
            .bus
            .call(&address, request, Arc::new(Notifier::new()))?;
        match pending.wait() {
            Ok(answer) => Ok(answer.to_datum()?),
            Err(CallFailure::Refused(refusal)) => Err(refusal.into()),
            Err(failure) => Err(RemoteError::Process {
                process: of.process.clone(),
                source: call_error(failure),
            }),
        }
    }

    /// Sends an order without waiting for the reply.
    pub(crate) fn send_order(
        &self,
        of: &ComponentLocation,
        order: OrderKind,
    ) -> Result<(), RemoteError> {
        let (address, order) = envelope(of, order)?;
        let request = request(order, PATIENCE);
        drop(
            self.0
                .bus
                .call_one_way(&address, request, Arc::new(Notifier::new()))?,
        );
        Ok(())
    }

    /// Sends an order without a reply. Whether it has reached the queue of the component's process shows in the returned call, for
    /// at most this time.
    pub(crate) fn send_within(
        &self,
        of: &ComponentLocation,
        order: OrderKind,
        timeout: Duration,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, RemoteError> {
        let (address, order) = envelope(of, order)?;
        let request = request(order, timeout);
        Ok(self.0.bus.call_one_way(&address, request, notifier)?)
    }

    /// Finds a component, waiting for the presence of its process if need be.
    pub(crate) fn find(&self, name: &str) -> Result<ComponentLocation, RemoteError> {
        let mut roster = self.roster();
        loop {
            roster.listen(Duration::ZERO);
            let all = roster.components(self.robot());
            let location = find_component(name, &all);
            let remaining = self.wait_of(&roster);
            // without the robot's name, a robot whose presence has not arrived yet may have a component with the same
            // name
            let is_sure = |it: &ComponentLocation| self.robot().is_some() || it.full_name() == name;
            if remaining.is_zero() || location.as_ref().is_ok_and(is_sure) {
                return location;
            }
            roster.listen(remaining);
        }
    }

    /// The known operation with the most similar name, or the one that a name means in which levels are left out.
    pub fn similar_operation(&self, name: &str) -> Option<String> {
        let mut known = Vec::new();
        for presence in self.processes() {
            let operations = operations(&presence).into_iter();
            known.extend(operations.map(|it| presence.key(&it.name)));
        }
        match with_levels_left_out(name, &known).as_slice() {
            [only] => Some((*only).clone()),
            [] => similar(name, &known).cloned(),
            several => {
                let nearest = similar(name, several.iter().copied());
                nearest.or(several.first().copied()).cloned()
            }
        }
    }

    /// Full name of the component that provides an operation; `None` unless its presence is known.
    pub(crate) fn provider(&self, operation: &str) -> Option<String> {
        let processes = self.processes();
        let of = |presence: &RobotPresence| {
            let mut operations = operations(presence).into_iter();
            let served = operations.find(|it| presence.key(&it.name) == operation)?;
            Some(presence.key(&served.component))
        };
        processes.iter().find_map(of)
    }

    pub(crate) fn robot(&self) -> Option<&str> {
        self.0.robot.as_deref()
    }

    /// Time for which the presence of further processes is awaited.
    fn wait_of(&self, roster: &Roster) -> Duration {
        let heard = !roster.presences(self.robot()).is_empty();
        let wait = if heard { LISTEN } else { NOBODY };
        wait.saturating_sub(self.0.connected_at.elapsed())
    }

    fn roster(&self) -> MutexGuard<'_, Roster> {
        self.0.roster.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The roster, once every process has had time to publish its presence.
    pub(crate) fn complete_roster(&self) -> MutexGuard<'_, Roster> {
        let mut roster = self.roster();
        roster.listen(Duration::ZERO);
        loop {
            let remaining = self.wait_of(&roster);
            if remaining.is_zero() {
                return roster;
            }
            roster.listen(remaining);
        }
    }
}

/// Subscribes to all topics that match a pattern, with a queue for interactive tools.
///
/// # Errors
/// An error of the bus.
pub fn listen(bus: &dyn Bus, pattern: &str) -> Result<Subscription, BusError> {
    let queue = QueuePolicy::All {
        size: 4096,
        overflow: Overflow::DropOldest,
    };
    let notifier = Arc::new(Notifier::new());
    bus.subscribe("tool", &Pattern::new(pattern), queue, notifier)
}

/// Creates a request of this process.
pub(crate) fn request(argument: Datum, timeout: Duration) -> Request {
    Request::new(SenderId::new(TOOL, 0), Payload::of(argument), timeout)
}

/// The routing key and the content of an order.
fn envelope(of: &ComponentLocation, order: OrderKind) -> Result<(String, Datum), RemoteError> {
    let component = of.present.name.clone();
    let order = Datum::of(&Order {
        component,
        wish: order,
    })?;
    Ok((key(&of.robot, &control_address(&of.process)), order))
}
