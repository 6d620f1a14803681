//! Joining over a bus: to what other processes have, and for them to what is here.

use std::sync::Arc;

use bus::{Bell, Sending};

use super::join::{outputs, references, services};
use super::{BuildError, End, System};
use crate::Wire;
use crate::exchange::Way;
use crate::service::{Inbox, Wiring};

/// What of a system is joined over a bus, beside its topics.
#[derive(Default)]
pub(crate) struct Abroad {
    /// Whether topics go over the bus even inside.
    pub topics: bool,
    /// Outputs that inputs of other processes are connected to.
    pub exposed: Vec<(End, Sending)>,
    /// Services that others may call.
    pub offered: Vec<End>,
    /// Services of others.
    pub reached: Vec<Way>,
    /// Rung for everything that comes or waits to go.
    pub bell: Arc<Bell>,
}

/// The topic of an output that inputs of other processes are connected to: `port.RoverDriver.odom`.
pub fn port_topic(output: &str) -> String {
    format!("port.{output}")
}

/// Where an operation of a service is called: `TrajectoryPlanner.planning.plan`.
pub(crate) fn address(service: &str, operation: &str) -> String {
    format!("{service}.{operation}")
}

impl System {
    /// From now on topics join their ports over the bus alone, those inside too: for a run that tries the bus.
    pub fn topics_abroad(&mut self) {
        self.abroad.topics = true;
    }

    /// Lets inputs of other processes connect to an output: they read its [`port_topic`].
    pub fn expose(&mut self, from: &str, sending: Sending) -> Result<(), BuildError> {
        let from = self.end(from, outputs)?;
        if self.abroad.exposed.iter().all(|(known, _)| *known != from) {
            self.abroad.exposed.push((from, sending));
        }
        Ok(())
    }

    /// Lets other processes call a service.
    pub fn offer(&mut self, service: &str) -> Result<(), BuildError> {
        let service = self.end(service, services)?;
        if !self.abroad.offered.contains(&service) {
            self.abroad.offered.push(service);
        }
        Ok(())
    }

    /// Wires a reference to a service that is offered on the bus, by whichever process. As long as nobody offers it,
    /// calls end with [`CallError::Unavailable`](crate::CallError::Unavailable).
    pub fn reach(&mut self, from: &str, service: &str, wire: Wire) -> Result<(), BuildError> {
        let from = self.end(from, references)?;
        let operations = &self
            .open_reference(&from, service, wire)?
            .declaration
            .operations;
        let addresses = operations
            .iter()
            .map(|called| address(service, &called.name));
        let way = Way {
            inbox: Inbox::beyond(Arc::clone(&self.abroad.bell)),
            addresses: addresses.collect(),
            timeout: wire.timeout,
        };
        let wiring = Wiring {
            inbox: Arc::clone(&way.inbox),
            to: service.to_owned(),
            provider: None,
            operations: (0..way.addresses.len()).collect(),
            wire,
        };
        self.abroad.reached.push(way);
        let reference = &mut self.units[from.unit].body.references[from.index];
        reference.wirings.push(wiring);
        Ok(())
    }
}
