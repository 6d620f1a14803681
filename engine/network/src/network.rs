//! The builder of a system's remote side.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_bus::{Bus, BusError, PublishOptions};
use asmotion_component::Wire;
use asmotion_runtime::{BuildError, ComponentId, RequestQueue, System};

use crate::adapter::{BusAdapter, ServingAdapter};
use crate::ends::{OfferedService, RemoteEnds, RemoteReference, address};
use crate::error::NetworkError;
use crate::remote::RemoteRoute;

/// What of a system is joined over buses, besides its topics: collected first, then joined by [`attach`](Self::attach).
///
/// ```
/// use std::sync::Arc;
///
/// use asmotion_bus::Local;
/// use asmotion_network::Network;
/// use asmotion_runtime::System;
///
/// let mut system = System::new();
/// // … components are added, topics published and subscribed …
/// let mut network = Network::new();
/// network.attach(&mut system, Arc::new(Local::new()), 1)?;
/// let run = system.simulate();
/// # drop(run);
/// # Ok::<(), asmotion_bus::BusError>(())
/// ```
#[derive(Default)]
pub struct Network {
    ends: RemoteEnds,
    /// Whether the system is attached to a bus.
    attached: bool,
}

impl Network {
    /// A network without remote ends.
    pub fn new() -> Self {
        Self::default()
    }

    /// Says how a topic is sent: how sure its messages are to arrive, and what becomes of them while the bus is away.
    /// Nothing changes inside the system.
    pub fn set_sending(&mut self, topic: &str, sending: PublishOptions) {
        self.ends.sending.insert(topic.to_owned(), sending);
    }

    /// Lets inputs of other processes connect to an output: they read its [`port_topic`](crate::port_topic).
    ///
    /// # Errors
    /// There is no such output.
    pub fn expose(
        &mut self,
        system: &System,
        from: &str,
        sending: PublishOptions,
    ) -> Result<(), BuildError> {
        let from = system.output(from)?;
        if self.ends.exposed.iter().all(|(known, _)| *known != from) {
            self.ends.exposed.push((from, sending));
        }
        Ok(())
    }

    /// Says on which of several buses a component is: its topics, and its services and references unless they say
    /// otherwise. The topics of a component on no bus stay inside.
    pub fn put_on(&mut self, component: ComponentId, bus: &str) {
        self.ends.homes.insert(component.position(), bus.to_owned());
    }

    /// Lets other processes call a service over its component's bus.
    ///
    /// # Errors
    /// There is no such service.
    pub fn offer(&mut self, system: &System, service: &str) -> Result<(), BuildError> {
        let end = system.service(service)?;
        let bus = self.ends.homes.get(&end.component()).cloned();
        self.offer_at(system, service, service, bus.as_deref())
    }

    /// Lets other processes call a service under a name, over one of several buses.
    ///
    /// # Errors
    /// There is no such service.
    pub fn offer_at(
        &mut self,
        system: &System,
        service: &str,
        name: &str,
        bus: Option<&str>,
    ) -> Result<(), BuildError> {
        let offered = OfferedService {
            service: system.service(service)?,
            name: name.to_owned(),
            bus: bus.map(str::to_owned),
        };
        if !self.ends.offered.contains(&offered) {
            self.ends.offered.push(offered);
        }
        Ok(())
    }

    /// Wires a reference to a service that another process offers. Calls end with
    /// [`CallError::Unavailable`](asmotion_component::CallError::Unavailable) as long as none does.
    ///
    /// # Errors
    /// There is no such reference, or it has a service already.
    pub fn reach(
        &mut self,
        system: &mut System,
        from: &str,
        service: &str,
        wire: Wire,
    ) -> Result<(), BuildError> {
        let end = system.reference(from)?;
        let bus = self.ends.homes.get(&end.component()).cloned();
        self.reach_over(system, from, service, wire, bus.as_deref())
    }

    /// Wires a reference to a service that another process offers over one of several buses.
    ///
    /// # Errors
    /// There is no such reference, or it has a service already.
    pub fn reach_over(
        &mut self,
        system: &mut System,
        from: &str,
        service: &str,
        wire: Wire,
        bus: Option<&str>,
    ) -> Result<(), BuildError> {
        let from = system.reference(from)?;
        let queue = RequestQueue::remote(Arc::clone(system.notifier()));
        let operations = system.wire_remote(&from, service, wire, Arc::clone(&queue))?;
        let operations = operations.iter();
        let route = RemoteRoute {
            queue,
            addresses: (operations.map(|called| address(service, called))).collect(),
            timeout: wire.timeout,
        };
        let bus = bus.map(str::to_owned);
        self.ends.reached.push(RemoteReference { route, bus });
        Ok(())
    }

    /// Joins the topics declared so far to those of a bus: samples published here go out, samples of others come in, to
    /// each subscriber by its own policy (see [`set_sending`](Self::set_sending)); and with them the remote ends collected
    /// so far. `incarnation` numbers the lives of this process, and no two processes share one: a message that carries it
    /// does not come in again where it was handed over inside.
    ///
    /// # Errors
    /// The bus refuses a topic, a service or a reader.
    pub fn attach(
        &mut self,
        system: &mut System,
        bus: Arc<dyn Bus>,
        incarnation: u64,
    ) -> Result<(), BusError> {
        self.join(system, vec![(None, bus)], incarnation)
    }

    /// Joins several buses by name: a component's ends are joined to the bus it was [put on](Self::put_on), and stay inside
    /// if it is on none. See [`attach`](Self::attach).
    ///
    /// # Errors
    /// A bus refuses a topic, a service or a reader.
    pub fn attach_each(
        &mut self,
        system: &mut System,
        buses: BTreeMap<String, Arc<dyn Bus>>,
        incarnation: u64,
    ) -> Result<(), BusError> {
        let buses = buses.into_iter().map(|(name, bus)| (Some(name), bus));
        self.join(system, buses.collect(), incarnation)
    }

    /// Serves over a bus that carries nothing else, such as a gateway's. Each service has a name there:
    /// `("MapServer.maps", "maps")`. A system that is attached to a bus too must be attached first.
    ///
    /// # Errors
    /// There is no such service, or the bus refuses it.
    pub fn serve_on(
        &mut self,
        system: &mut System,
        bus: Arc<dyn Bus>,
        offered: &[(&str, &str)],
    ) -> Result<(), NetworkError> {
        let offered = offered.iter().map(|(service, name)| {
            Ok(OfferedService {
                service: system.service(service)?,
                name: (*name).to_owned(),
                bus: None,
            })
        });
        let offered: Vec<OfferedService> = offered.collect::<Result<_, BuildError>>()?;
        if !self.attached {
            self.join(system, Vec::new(), 0)?;
        }
        let adapter = ServingAdapter::new(system, &offered, bus)?;
        system.add_adapter(Box::new(adapter));
        Ok(())
    }

    fn join(
        &mut self,
        system: &mut System,
        buses: Vec<(Option<String>, Arc<dyn Bus>)>,
        incarnation: u64,
    ) -> Result<(), BusError> {
        let ends = std::mem::take(&mut self.ends);
        let adapter = BusAdapter::new(system, ends, buses, incarnation)?;
        system.add_adapter(Box::new(adapter));
        self.attached = true;
        Ok(())
    }
}
