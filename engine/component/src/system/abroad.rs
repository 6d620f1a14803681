//! Joining over a bus: to what other processes have, and for them to what is here.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_bus::{Bell, Bus, Sending};

use super::ends::{outputs, references, services};
use super::{BuildError, ComponentId, End, System};
use crate::Wire;
use crate::exchange::Way;
use crate::service::{Inbox, Wiring};

/// What of a system is joined over buses, beside its topics.
#[derive(Default)]
pub(crate) struct Abroad {
    /// The buses of the components, where there are several: by place in the system.
    pub homes: BTreeMap<usize, String>,
    /// Whether topics go over the bus even inside.
    pub topics: bool,
    /// Outputs that inputs of other processes are connected to.
    pub exposed: Vec<(End, Sending)>,
    /// Services that others may call.
    pub offered: Vec<Offered>,
    /// Services of others.
    pub reached: Vec<Reach>,
    /// Rung for everything that comes or waits to go.
    pub bell: Arc<Bell>,
}

/// A service that others may call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Offered {
    pub service: End,
    /// What its addresses begin with.
    pub name: String,
    /// Over which of several buses.
    pub bus: Option<String>,
}

/// A service of others that a reference reaches.
pub(crate) struct Reach {
    pub way: Way,
    /// Over which of several buses.
    pub bus: Option<String>,
}

/// Whether what is on one bus is on this one; where the system has one alone, everything is on it.
pub(crate) fn is_on(bus: Option<&str>, this: Option<&str>) -> bool {
    this.is_none() || bus == this
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

    /// Says on which of several buses a component is: its topics, and its services and references unless they say
    /// otherwise. One that is on none has its topics inside.
    pub fn put_on(&mut self, component: ComponentId, bus: &str) {
        self.abroad.homes.insert(component.0, bus.to_owned());
    }

    /// Lets other processes call a service over the bus of its component.
    pub fn offer(&mut self, service: &str) -> Result<(), BuildError> {
        let end = self.end(service, services)?;
        let bus = self.abroad.homes.get(&end.unit).cloned();
        self.offer_at(service, service, bus.as_deref())
    }

    /// Lets other processes call a service under a name, over one of several buses.
    pub fn offer_at(
        &mut self,
        service: &str,
        name: &str,
        bus: Option<&str>,
    ) -> Result<(), BuildError> {
        let offered = Offered {
            service: self.end(service, services)?,
            name: name.to_owned(),
            bus: bus.map(str::to_owned),
        };
        if !self.abroad.offered.contains(&offered) {
            self.abroad.offered.push(offered);
        }
        Ok(())
    }

    /// Serves over a bus that carries nothing else: a gateway's, say, behind which are those who are on no bus of ours.
    /// Each service has a name there: `("MapServer.maps", "maps")`. Whoever is on a bus as well joins that one first.
    pub fn serve_on(
        &mut self,
        bus: Arc<dyn Bus>,
        offered: &[(&str, &str)],
    ) -> Result<(), BuildError> {
        let offered = offered.iter().map(|(service, name)| {
            Ok(Offered {
                service: self.end(service, services)?,
                name: (*name).to_owned(),
                bus: None,
            })
        });
        let offered: Vec<Offered> = offered.collect::<Result<_, BuildError>>()?;
        if self.exchange.is_none() {
            self.join_buses(Vec::new(), 0)?;
        }
        if let Some(exchange) = &mut self.exchange {
            exchange.serve(&self.units, &offered, bus)?;
        }
        Ok(())
    }

    /// Wires a reference to a service that is offered on the bus, by whichever process. As long as nobody offers it,
    /// calls end with [`CallError::Unavailable`](crate::CallError::Unavailable).
    pub fn reach(&mut self, from: &str, service: &str, wire: Wire) -> Result<(), BuildError> {
        let end = self.end(from, references)?;
        let bus = self.abroad.homes.get(&end.unit).cloned();
        self.reach_over(from, service, wire, bus.as_deref())
    }

    /// The same over one of several buses.
    pub fn reach_over(
        &mut self,
        from: &str,
        service: &str,
        wire: Wire,
        bus: Option<&str>,
    ) -> Result<(), BuildError> {
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
        let bus = bus.map(str::to_owned);
        self.abroad.reached.push(Reach { way, bus });
        let reference = &mut self.units[from.unit].body.references[from.index];
        reference.wirings.push(wiring);
        Ok(())
    }
}
