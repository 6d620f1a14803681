//! A component of a running system, as if it were here.

use std::time::Duration;

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

/// A component of a running system. It stays the same component when its process is started again.
#[derive(Clone)]
pub struct RemoteComponent {
    remote: Remote,
    found: ComponentLocation,
}

/// A service of a component.
#[derive(Clone)]
pub struct RemoteServiceHandle {
    component: RemoteComponent,
    present: PresentService,
}

impl RemoteComponent {
    pub(crate) fn new(remote: Remote, found: ComponentLocation) -> Self {
        Self { remote, found }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.found.present.name
    }

    /// Its robot; empty if that has no name.
    pub fn robot(&self) -> &str {
        &self.found.robot
    }

    /// The process it runs in.
    pub fn process(&self) -> &str {
        &self.found.process
    }

    /// Its name with its robot's before it, `rover1.RoverDriver`.
    pub fn whole_name(&self) -> String {
        self.found.whole()
    }

    /// What it was when it was looked up: ports, services, references, properties, state, rates.
    pub fn present(&self) -> &PresentComponent {
        &self.found.present
    }

    /// What it is now, with the rate that it was last heard to have.
    ///
    /// # Errors
    /// Its process does not answer.
    pub fn look(&self) -> Result<PresentComponent, RemoteError> {
        let mut present: PresentComponent = self.order(OrderKind::Look)?.to()?;
        present.rate_hz = self.present().rate_hz;
        Ok(present)
    }

    /// Its state in its life cycle, now.
    ///
    /// # Errors
    /// Its process does not answer.
    pub fn state(&self) -> Result<State, RemoteError> {
        let state = self.look()?.state;
        let known = State::ALL.into_iter().find(|it| it.to_string() == state);
        known.ok_or(RemoteError::Unknown {
            what: "state",
            name: state,
            nearest: None,
        })
    }

    /// What it declares, with the shape of every port, operation and property.
    ///
    /// # Errors
    /// Its process does not answer.
    pub fn declaration(&self) -> Result<Declaration, RemoteError> {
        Ok(self.order(OrderKind::Describe)?.to()?)
    }

    /// Takes it through a transition of its life cycle.
    ///
    /// # Errors
    /// RTT's guards refuse it, or its hook fails.
    pub fn transition(&self, transition: Transition) -> Result<(), RemoteError> {
        let wish = match transition {
            Transition::Configure => OrderKind::Configure,
            Transition::Start => OrderKind::Start,
            Transition::Stop => OrderKind::Stop,
            Transition::Cleanup => OrderKind::Cleanup,
            Transition::Recover => OrderKind::Recover,
            Transition::ResetException => OrderKind::Reset,
        };
        self.order(wish).map(drop)
    }

    /// Its properties with their present values.
    ///
    /// # Errors
    /// Its process does not answer.
    pub fn properties(&self) -> Result<Vec<(String, Datum)>, RemoteError> {
        Ok(self.look()?.properties)
    }

    /// The present value of a property.
    ///
    /// # Errors
    /// It has no such property, or one of another type.
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

    /// Sets a property from its next cycle on.
    ///
    /// # Errors
    /// It has no such property, or that takes no such value.
    pub fn set(&self, property: &str, value: impl Serialize) -> Result<(), RemoteError> {
        self.set_all(vec![(property.to_owned(), Datum::of(&value)?)])
    }

    /// Sets properties from its next cycle on, all or none.
    ///
    /// # Errors
    /// It has not all of these properties, or one takes no such value.
    pub fn set_all(&self, values: Vec<(String, Datum)>) -> Result<(), RemoteError> {
        self.order(OrderKind::Set(values)).map(drop)
    }

    /// What left an output last.
    ///
    /// # Errors
    /// It has no such output, nothing has left it yet, or it is of another type.
    pub fn read<T: DeserializeOwned>(&self, port: &str) -> Result<T, RemoteError> {
        Ok(self.order(OrderKind::Read(port.to_owned()))?.to()?)
    }

    /// Gives a message to an input, checked against its type.
    ///
    /// # Errors
    /// It has no such input, or that takes another type.
    pub fn write(&self, port: &str, message: impl Serialize) -> Result<(), RemoteError> {
        let wish = OrderKind::Write(port.to_owned(), Datum::of(&message)?);
        self.order(wish).map(drop)
    }

    /// All that leaves an output from now on, and what left it last.
    ///
    /// # Errors
    /// It has no such output.
    pub fn watch(&self, port: &str) -> Result<OutputWatch, RemoteError> {
        OutputWatch::new(&self.remote, &self.found, port)
    }

    /// A service.
    ///
    /// # Errors
    /// It has none of that name.
    pub fn service(&self, name: &str) -> Result<RemoteServiceHandle, RemoteError> {
        let services = &self.found.present.services;
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

    fn order(&self, wish: OrderKind) -> Result<Datum, RemoteError> {
        self.remote.order(&self.found, wish)
    }
}

impl RemoteServiceHandle {
    /// What it is: name, interface, operations.
    pub fn present(&self) -> &PresentService {
        &self.present
    }

    /// Calls an operation, and waits for the answer.
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
        let Self { component, present } = self;
        let address = format!("{}.{}.{operation}", component.name(), present.name);
        let address = key(component.robot(), &address);
        component.remote.send(&address, argument, patience)
    }
}
