//! The outside's end: systems on a bus, and the way to their components.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

#[cfg(feature = "amqp")]
use asmotion_amqp::{AmqpBus, AmqpSettings};
use asmotion_bus::{
    Bus, BusError, CallFailure, Notifier, Overflow, Pattern, Payload, QueuePolicy, Request,
    SenderId, Subscription,
};
use asmotion_datum::Datum;
use asmotion_diagnostics::similar;
use asmotion_network::call_error;

use crate::call::SendHandle;
use crate::error::RemoteError;
use crate::handle::RemoteComponent;
use crate::order::{Order, OrderKind, control_address};
use crate::presence::{RobotPresence, key};
use crate::roster::{ComponentLocation, Roster, WORDS, named};

/// How long to wait for a broker.
#[cfg(feature = "amqp")]
const CONNECT: Duration = Duration::from_secs(10);
/// How long to listen for who is there: each process speaks once a second.
const LISTEN: Duration = Duration::from_millis(1500);
/// How long an order may take.
const PATIENCE: Duration = Duration::from_secs(10);
/// Who we are on the bus.
const TOOL: &str = "asmotion-tool";

/// The systems on a bus, or one of them. Clones are the same; there may be any number, on any buses.
#[derive(Clone)]
pub struct Remote(Arc<RemoteState>);

struct RemoteState {
    bus: Arc<dyn Bus>,
    /// Of several robots on the bus, the one that is meant.
    robot: Option<String>,
    roster: Mutex<Roster>,
    /// Until then not everybody need have spoken.
    settled: Instant,
}

impl Remote {
    /// The systems on a broker, `amqp://user:password@host:port/vhost`; those of one robot, if it is named.
    ///
    /// # Errors
    /// The address is none, or the broker is not there or does not let us.
    #[cfg(feature = "amqp")]
    pub fn connect(url: &str, robot: Option<&str>) -> Result<Self, RemoteError> {
        let mut settings = AmqpSettings::parse(url)?;
        settings.process = TOOL.to_owned();
        Self::over(Arc::new(AmqpBus::connect(settings, CONNECT)?), robot)
    }

    /// The same on any bus.
    ///
    /// # Errors
    /// The bus does not let us.
    pub fn over(bus: Arc<dyn Bus>, robot: Option<&str>) -> Result<Self, RemoteError> {
        let words = listen(&*bus, WORDS)?;
        Ok(Self(Arc::new(RemoteState {
            bus,
            robot: robot.map(str::to_owned),
            roster: Mutex::new(Roster::new(words)),
            settled: Instant::now() + LISTEN,
        })))
    }

    /// The bus.
    pub fn bus(&self) -> &Arc<dyn Bus> {
        &self.0.bus
    }

    /// All messages of the topics that match a pattern; topics are whole keys, with the robot.
    ///
    /// # Errors
    /// The bus does not let us.
    pub fn listen(&self, pattern: &str) -> Result<Subscription, RemoteError> {
        Ok(listen(&*self.0.bus, pattern)?)
    }

    /// The processes that are there, as they last spoke. The first time it listens until everybody has spoken, for a
    /// second and a half.
    pub fn processes(&self) -> Vec<RobotPresence> {
        self.settled_roster().words(self.robot())
    }

    /// All components that are there.
    pub fn components(&self) -> Vec<RemoteComponent> {
        let found = self.settled_roster().components(self.robot());
        let component = |found| RemoteComponent::new(self.clone(), found);
        found.into_iter().map(component).collect()
    }

    /// The component of a name, `RoverDriver`; where several robots have one, `rover1.RoverDriver`.
    ///
    /// # Errors
    /// There is none of that name, or several.
    pub fn component(&self, name: &str) -> Result<RemoteComponent, RemoteError> {
        self.find(name)
            .map(|it| RemoteComponent::new(self.clone(), it))
    }

    /// Calls an operation, `navigation.MapServer.maps.getMap`, and waits for the answer.
    ///
    /// # Errors
    /// Nobody serves it, the provider refuses, or the time is up.
    pub fn call(
        &self,
        operation: &str,
        argument: Datum,
        patience: Duration,
    ) -> Result<Datum, RemoteError> {
        self.send(operation, argument, patience)?.collect()
    }

    /// Calls an operation, and does not wait: the answer is collected, or told to a listener.
    ///
    /// # Errors
    /// The bus cannot carry it.
    pub fn send(
        &self,
        operation: &str,
        argument: Datum,
        patience: Duration,
    ) -> Result<SendHandle, RemoteError> {
        let request = request(argument, patience);
        let pending = (self.0.bus).call(operation, request, Arc::new(Notifier::new()))?;
        Ok(SendHandle::new(self.clone(), operation, pending))
    }

    /// Has a component's process carry out an order, and says what it answers.
    pub(crate) fn order(
        &self,
        of: &ComponentLocation,
        wish: OrderKind,
    ) -> Result<Datum, RemoteError> {
        let (address, order) = envelope(of, wish)?;
        let request = request(order, PATIENCE);
        let pending = (self.0.bus).call(&address, request, Arc::new(Notifier::new()))?;
        match pending.wait() {
            Ok(answer) => Ok(answer.to_datum()?),
            Err(CallFailure::Refused(refusal)) => Err(refusal.into()),
            Err(failure) => Err(RemoteError::Process {
                process: of.process.clone(),
                source: call_error(failure),
            }),
        }
    }

    /// The same, and nobody waits for the answer.
    pub(crate) fn tell(&self, of: &ComponentLocation, wish: OrderKind) -> Result<(), RemoteError> {
        let (address, order) = envelope(of, wish)?;
        let request = request(order, PATIENCE);
        drop((self.0.bus).tell(&address, request, Arc::new(Notifier::new()))?);
        Ok(())
    }

    /// Where a component is; as soon as it is known.
    pub(crate) fn find(&self, name: &str) -> Result<ComponentLocation, RemoteError> {
        let mut roster = self.roster();
        loop {
            roster.listen(Duration::ZERO);
            let all = roster.components(self.robot());
            let found = named(name, &all);
            let left = self.0.settled.saturating_duration_since(Instant::now());
            // another robot may have one of that name
            let is_sure = |it: &ComponentLocation| self.robot().is_some() || it.whole() == name;
            if left.is_zero() || found.as_ref().is_ok_and(is_sure) {
                return found;
            }
            roster.listen(left);
        }
    }

    /// An operation with a name like this one.
    pub(crate) fn operation_like(&self, name: &str) -> Option<String> {
        let mut known = Vec::new();
        for word in self.processes() {
            for component in &word.presence.components {
                for service in &component.services {
                    let path = word.key(&format!("{}.{}", component.name, service.name));
                    let operations = service.operations.iter();
                    known.extend(operations.map(|operation| format!("{path}.{}", operation.name)));
                }
            }
        }
        similar(name, &known).cloned()
    }

    fn robot(&self) -> Option<&str> {
        self.0.robot.as_deref()
    }

    fn roster(&self) -> MutexGuard<'_, Roster> {
        (self.0.roster)
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Who is there, once everybody has had the time to speak.
    fn settled_roster(&self) -> MutexGuard<'_, Roster> {
        let mut roster = self.roster();
        roster.listen(Duration::ZERO);
        loop {
            let left = self.0.settled.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return roster;
            }
            roster.listen(left);
        }
    }
}

/// All messages of the topics that match a pattern, for a tool.
///
/// # Errors
/// The bus does not let us.
pub fn listen(bus: &dyn Bus, pattern: &str) -> Result<Subscription, BusError> {
    let queue = QueuePolicy::All {
        size: 4096,
        overflow: Overflow::DropOldest,
    };
    let notifier = Arc::new(Notifier::new());
    bus.subscribe("tool", &Pattern::new(pattern), queue, notifier)
}

fn request(argument: Datum, patience: Duration) -> Request {
    Request::new(SenderId::new(TOOL, 0), Payload::of(argument), patience)
}

/// Where an order goes, and what it says.
fn envelope(of: &ComponentLocation, wish: OrderKind) -> Result<(String, Datum), RemoteError> {
    let component = of.present.name.clone();
    let order = Datum::of(&Order { component, wish })?;
    Ok((key(&of.robot, &control_address(&of.process)), order))
}
