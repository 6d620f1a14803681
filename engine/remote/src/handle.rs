//! Handles of components of a running system.

use std::time::{Duration, Instant};

use asmotion_component::{Declaration, State, Transition};
use asmotion_datum::Datum;
use asmotion_diagnostics::similar;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::call::SendHandle;
use crate::error::RemoteError;
use crate::order::OrderKind;
use crate::presence::{PresentComponent, PresentService, key};
use crate::remote::Remote;
use crate::roster::ComponentLocation;
use crate::watch::OutputWatch;

/// Time for which a long cycle of a component is awaited.
const CYCLE_PATIENCE: Duration = Duration::from_secs(5);

/// Time between two looks at a component in a long cycle.
const BETWEEN_LOOKS: Duration = Duration::from_millis(50);

/// A handle of a component. Remains valid when the component's process is restarted.
#[derive(Clone)]
pub struct RemoteComponent {
    remote: Remote,
    location: ComponentLocation,
}

/// A service of a component.
#[derive(Clone)]
pub struct RemoteServiceHandle {
    component: RemoteComponent,
    present: PresentService,
}

impl Remote {
    /// The components of all running processes.
    pub fn components(&self) -> Vec<RemoteComponent> {
        let found = self.complete_roster().components(self.robot());
        let component = |location| RemoteComponent::new(self.clone(), location);
        found.into_iter().map(component).collect()
    }

    /// The component with a name such as `RoverDriver` or, with the robot, `rover1.RoverDriver`.
    ///
    /// # Errors
    /// An error if no component or several components have this name.
    pub fn component(&self, name: &str) -> Result<RemoteComponent, RemoteError> {
        self.find(name)
            .map(|it| RemoteComponent::new(self.clone(), it))
    }
}

impl RemoteComponent {
    pub(crate) fn new(remote: Remote, location: ComponentLocation) -> Self {
        Self { remote, location }
    }

    /// Name of the component within its robot.
    pub fn name(&self) -> &str {
        &self.location.present.name
    }

    /// Name of the component's robot; empty if the robot has no name.
    pub fn robot(&self) -> &str {
        &self.location.robot
    }

    /// Name of the process that runs the component.
    pub fn process(&self) -> &str {
        &self.location.process
    }

    /// Name with the robot's name as a prefix: `rover1.RoverDriver`.
    pub fn full_name(&self) -> String {
        self.location.full_name()
    }

    /// The component's description as of the lookup: ports, services, references, properties, state, rates.
    pub fn present(&self) -> &PresentComponent {
        &self.location.present
    }

    /// The component's current description. The rate is the last one that was published.
    ///
    /// # Errors
    /// [`RemoteError::Process`] if the component's process does not reply.
    pub fn refresh(&self) -> Result<PresentComponent, RemoteError> {
        let mut present: PresentComponent = self.send_order(OrderKind::State)?.to()?;
        present.rate_hz = self.present().rate_hz;
        Ok(present)
    }

    /// Current state in the life cycle.
    ///
    /// # Errors
    /// [`RemoteError::Process`] if the component's process does not reply.
    pub fn state(&self) -> Result<State, RemoteError> {
        let state = self.refresh()?.state;
        let known = State::ALL.into_iter().find(|it| it.to_string() == state);
        known.ok_or(RemoteError::Unknown {
            what: "state",
            name: state,
            nearest: None,
        })
    }

    /// The component's declaration, with the schemas of all ports, operations and properties.
    ///
    /// # Errors
    /// [`RemoteError::Process`] if the component's process does not reply.
    pub fn declaration(&self) -> Result<Declaration, RemoteError> {
        Ok(self.send_order(OrderKind::Describe)?.to()?)
    }

    /// Makes a transition of the life cycle.
    ///
    /// # Errors
    /// [`RemoteError::Refused`] if RTT's guards refuse the transition or its hook fails.
    pub fn transition(&self, transition: Transition) -> Result<(), RemoteError> {
        let order = match transition {
            Transition::Configure => OrderKind::Configure,
            Transition::Start => OrderKind::Start,
            Transition::Stop => OrderKind::Stop,
            Transition::Cleanup => OrderKind::Cleanup,
            Transition::Recover => OrderKind::Recover,
            Transition::ResetException => OrderKind::Reset,
        };
        self.send_order(order).map(drop)
    }

    /// The properties with their current values. Waits for the end of a long cycle.
    ///
    /// # Errors
    /// [`RemoteError::Process`] if the component's process does not reply, [`RemoteError::Busy`] if the cycle does not end.
    pub fn properties(&self) -> Result<Vec<(String, Datum)>, RemoteError> {
        let until = Instant::now() + CYCLE_PATIENCE;
        loop {
            let properties = self.refresh()?.properties;
            // in the middle of a cycle, none are reported
            if !properties.is_empty() || self.declaration()?.properties.is_empty() {
                return Ok(properties);
            }
            if Instant::now() >= until {
                let component = self.full_name();
                return Err(RemoteError::Busy { component });
            }
            std::thread::sleep(BETWEEN_LOOKS);
        }
    }

    /// The current value of a property.
    ///
    /// # Errors
    /// An error if there is no such property, or if it has another type.
    pub fn get<T: DeserializeOwned>(&self, property: &str) -> Result<T, RemoteError> {
        let properties = self.properties()?;
        let known = properties.iter().find(|(name, _)| name == property);
        let (_, value) = known.ok_or_else(|| RemoteError::Unknown {
            what: "property",
            name: format!("{}.{property}", self.name()),
            nearest: similar(property, properties.iter().map(|(name, _)| name)).cloned(),
        })?;
        Ok(value.to()?)
    }

    /// Sets a property from the component's next cycle on.
    ///
    /// # Errors
    /// An error if there is no such property, or if it does not accept the value.
    pub fn set(&self, property: &str, value: impl Serialize) -> Result<(), RemoteError> {
        self.set_all(vec![(property.to_owned(), Datum::of(&value)?)])
    }

    /// Sets properties from the component's next cycle on, all or none.
    ///
    /// # Errors
    /// An error if one of the properties does not exist or does not accept its value.
    pub fn set_all(&self, values: Vec<(String, Datum)>) -> Result<(), RemoteError> {
        self.send_order(OrderKind::Set(values)).map(drop)
    }

    /// The newest sample of an output.
    ///
    /// # Errors
    /// An error if there is no such output, if it has not written yet, or if it has another type.
    pub fn read<T: DeserializeOwned>(&self, port: &str) -> Result<T, RemoteError> {
        Ok(self.send_order(OrderKind::Read(port.to_owned()))?.to()?)
    }

    /// Injects a message into an input, after a check of its type.
    ///
    /// # Errors
    /// An error if there is no such input, or if it has another type.
    pub fn write(&self, port: &str, message: impl Serialize) -> Result<(), RemoteError> {
        let order = OrderKind::Write(port.to_owned(), Datum::of(&message)?);
        self.send_order(order).map(drop)
    }

    /// Watches an output: receives its newest sample and all later ones.
    ///
    /// # Errors
    /// An error if there is no such output.
    pub fn watch(&self, port: &str) -> Result<OutputWatch, RemoteError> {
        OutputWatch::new(&self.remote, &self.location, port)
    }

    /// A service of the component.
    ///
    /// # Errors
    /// [`RemoteError::Unknown`] if there is no service with this name.
    pub fn service(&self, name: &str) -> Result<RemoteServiceHandle, RemoteError> {
        let services = &self.location.present.services;
        let known = services.iter().find(|service| service.name == name);
        let present = known.ok_or_else(|| RemoteError::Unknown {
            what: "service",
            name: format!("{}.{name}", self.name()),
            nearest: similar(name, services.iter().map(|service| &service.name)).cloned(),
        })?;
        Ok(RemoteServiceHandle {
            component: self.clone(),
            present: present.clone(),
        })
    }

    fn send_order(&self, order: OrderKind) -> Result<Datum, RemoteError> {
        self.remote.order(&self.location, order)
    }
}

impl RemoteServiceHandle {
    /// The service's description: name, interface, operations.
    pub fn present(&self) -> &PresentService {
        &self.present
    }

    /// Calls an operation and waits for the response.
    ///
    /// # Errors
    /// An error if the operation has no provider, the provider replies with a fault, or the time is up.
    pub fn call(
        &self,
        operation: &str,
        argument: Datum,
        timeout: Duration,
    ) -> Result<Datum, RemoteError> {
        self.send(operation, argument, timeout)?.collect()
    }

    /// Calls an operation without waiting. The response is collected, or passed to a listener.
    ///
    /// # Errors
    /// An error of the bus.
    pub fn send(
        &self,
        operation: &str,
        argument: Datum,
        timeout: Duration,
    ) -> Result<SendHandle, RemoteError> {
        let Self { component, present } = self;
        let address = format!("{}.{}.{operation}", component.name(), present.name);
        let address = key(component.robot(), &address);
        component.remote.send(&address, argument, timeout)
    }
}
