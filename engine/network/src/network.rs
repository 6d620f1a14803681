//! The builder of a system's remote side.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_bus::{Bus, BusError, PublishOptions, RobotAddress, ServiceClient};
use asmotion_component::Wire;
use asmotion_component::declaration::{OperationDeclaration, ReferenceDeclaration};
use asmotion_runtime::{BuildError, ComponentId, RequestQueue, System};

use crate::adapter::{BusAdapter, CallingAdapter, ServingAdapter};
use crate::error::NetworkError;
use crate::remote::{CallerIdentity, RemoteRoute, RemoteService};
use crate::remote_ends::{
    OfferedService, RemoteEnds, RemoteReference, address, caller_and_service, complete_types, is_on,
};
use crate::robot_service::RobotService;
use crate::running::RunningNetwork;

/// A reference to a service of another system.
struct ExternalReference {
    /// The reference, for example `Coordinator.maps`.
    from: String,
    url: String,
    route: RemoteRoute,
}

/// The remote ends of a system, collected first and then connected to buses by [`attach`](Self::attach).
///
/// ```
/// use std::sync::Arc;
///
/// use asmotion_bus::LocalBus;
/// use asmotion_network::Network;
/// use asmotion_runtime::System;
///
/// let mut system = System::new();
/// // … components are added, topics published and subscribed …
/// let mut network = Network::new();
/// network.attach(&mut system, Arc::new(LocalBus::new()), 1)?;
/// let run = system.simulate();
/// # drop(run);
/// # Ok::<(), asmotion_bus::BusError>(())
/// ```
#[derive(Default)]
pub struct Network {
    remote_ends: RemoteEnds,
    /// References to services of other systems, until their clients are [connected](Self::connect_clients).
    external: Vec<ExternalReference>,
    /// Services of other robots, each with its bus if there are several.
    robot_services: Vec<(Option<String>, Arc<RobotService>)>,
    /// The system is attached to a bus.
    attached: bool,
    running: RunningNetwork,
}

impl Network {
    /// Creates a network without remote ends.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the publishing options of a topic: delivery guarantee, and treatment of messages while the bus is down.
    /// Delivery within the system is not affected.
    pub fn set_publish_options(&mut self, topic: &str, options: PublishOptions) {
        self.remote_ends
            .publish_options
            .insert(topic.to_owned(), options);
    }

    /// Publishes an output for inputs of other processes, which read its [`port_topic`](crate::port_topic).
    ///
    /// # Errors
    /// An error if there is no such output.
    pub fn expose(
        &mut self,
        system: &System,
        from: &str,
        options: PublishOptions,
    ) -> Result<(), BuildError> {
        let from = system.output(from)?;
        if self
            .remote_ends
            .exposed
            .iter()
            .all(|(known, _)| *known != from)
        {
            self.remote_ends.exposed.push((from, options));
        }
        Ok(())
    }

    /// Assigns a component to one of several buses, for its topics and, unless specified otherwise, its services and
    /// references. The topics of a component without a bus stay within the system.
    pub fn assign_bus(&mut self, component: ComponentId, bus: &str) {
        self.remote_ends
            .component_buses
            .insert(component.position(), bus.to_owned());
    }

    /// Offers a service to other processes over its component's bus.
    ///
    /// # Errors
    /// An error if there is no such service.
    pub fn offer(&mut self, system: &System, service: &str) -> Result<(), BuildError> {
        let end = system.service(service)?;
        let bus = self
            .remote_ends
            .component_buses
            .get(&end.component())
            .cloned();
        self.offer_as(system, service, service, bus.as_deref())
    }

    /// Offers a service to other processes under a name, over one of several buses.
    ///
    /// # Errors
    /// An error if there is no such service.
    pub fn offer_as(
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
        if !self.remote_ends.offered.contains(&offered) {
            self.remote_ends.offered.push(offered);
        }
        Ok(())
    }

    /// Wires a reference to a service that another process offers. Calls end with
    /// [`CallError::Unavailable`](asmotion_component::CallError::Unavailable) while there is no provider.
    ///
    /// # Errors
    /// An error if there is no such reference, or if it has a service already.
    pub fn wire_remote(
        &mut self,
        system: &mut System,
        from: &str,
        service: &str,
        wire: Wire,
    ) -> Result<(), BuildError> {
        let end = system.reference(from)?;
        let bus = self
            .remote_ends
            .component_buses
            .get(&end.component())
            .cloned();
        self.wire_remote_over(system, from, service, wire, bus.as_deref(), &|_| None)
    }

    /// Wires a reference to a service that another process offers over one of several buses. `known` returns the operations of
    /// an interface, whose types apply to operations that the reference declares without types.
    ///
    /// # Errors
    /// An error if there is no such reference, or if it has a service already.
    pub fn wire_remote_over(
        &mut self,
        system: &mut System,
        from: &str,
        service: &str,
        wire: Wire,
        bus: Option<&str>,
        known: &dyn Fn(&str) -> Option<Vec<OperationDeclaration>>,
    ) -> Result<(), BuildError> {
        let address = |operation: &str| address(service, operation);
        let expected = expected_operations(system, from, known)?;
        let mut route = remote_route(system, from, service, wire, address)?;
        let operations = expected.operations.into_iter();
        route.responses = operations.map(|it| it.response).collect();
        let bus = bus.map(str::to_owned);
        self.remote_ends
            .remote_references
            .push(RemoteReference { route, bus });
        Ok(())
    }

    /// Wires a reference to a service of another robot on one of several buses. Calls wait for a provider that is not there
    /// yet, as with [`wire_remote`](Self::wire_remote), and end with a fault if they do not fit the service that its
    /// process announces to [`robot_services`](Self::robot_services). `known` returns the operations of an interface, whose
    /// types apply to operations that the reference declares without types.
    ///
    /// # Errors
    /// An error if there is no such reference, or if it has a service already.
    pub fn wire_to_robot(
        &mut self,
        system: &mut System,
        from: &str,
        service: RobotAddress<'_>,
        wire: Wire,
        bus: Option<&str>,
        known: &dyn Fn(&str) -> Option<Vec<OperationDeclaration>>,
    ) -> Result<(), BuildError> {
        let expected = expected_operations(system, from, known)?;
        let shown = service.to_string();
        let address = |operation: &str| address(&shown, operation);
        let mut route = remote_route(system, from, &shown, wire, address)?;
        let names = (service.robot(), service.name());
        let expected = Arc::new(RobotService::new(
            from,
            names,
            expected,
            wire.timeout,
            Arc::clone(system.notifier()),
        ));
        route.robot_service = Some(Arc::clone(&expected));
        let bus = bus.map(str::to_owned);
        self.robot_services.push((bus.clone(), expected));
        let reference = RemoteReference { route, bus };
        self.remote_ends.remote_references.push(reference);
        Ok(())
    }

    /// Returns the services of other robots that are called over the bus with this name, or all without a name.
    pub fn robot_services(&self, bus: Option<&str>) -> Vec<Arc<RobotService>> {
        let services = self.robot_services.iter();
        let on_bus = services.filter(|(of, _)| is_on(of.as_deref(), bus));
        on_bus.map(|(_, service)| Arc::clone(service)).collect()
    }

    /// Wires a reference to a service of another system: operation `getMap` has the address `URL/getMap`. Calls time out
    /// until its client is [connected](Self::connect_clients). `shown` is the URL without secrets. `known` returns the
    /// operations of an interface; a response that is not of their type ends the call with a fault.
    ///
    /// # Errors
    /// An error if there is no such reference, or if it has a service already.
    pub fn wire_external(
        &mut self,
        system: &mut System,
        from: &str,
        (url, shown): (&str, &str),
        wire: Wire,
        known: &dyn Fn(&str) -> Option<Vec<OperationDeclaration>>,
    ) -> Result<(), BuildError> {
        let base = url.trim_end_matches('/');
        let address = |operation: &str| format!("{base}/{operation}");
        let expected = expected_operations(system, from, known)?;
        let mut route = remote_route(system, from, shown, wire, address)?;
        let operations = expected.operations.into_iter();
        route.responses = operations.map(|it| it.response).collect();
        route.is_external = true;
        self.external.push(ExternalReference {
            from: from.to_owned(),
            url: url.to_owned(),
            route,
        });
        Ok(())
    }

    /// Connects each reference that is [wired to another system](Self::wire_external) to the client that `client` returns
    /// for the reference and the URL; without a client its calls time out. If the system is attached to a bus too, call [`attach`](Self::attach) first.
    /// `incarnation` must be unique among all processes and restarts.
    ///
    /// # Errors
    /// An error if a bus refuses the system's topics.
    pub fn connect_clients(
        &mut self,
        system: &mut System,
        mut client: impl FnMut(&str, &str) -> Option<Arc<dyn ServiceClient>>,
        incarnation: u64,
    ) -> Result<(), BusError> {
        if self.external.is_empty() {
            return Ok(());
        }
        if !self.attached {
            self.add_bus_adapter(system, Vec::new(), incarnation)?;
        }
        let external = std::mem::take(&mut self.external);
        let services = external.into_iter().filter_map(|it| {
            let identity = CallerIdentity {
                client: client(&it.from, &it.url)?,
                incarnation,
                notifier: Arc::clone(system.notifier()),
            };
            Some(RemoteService::new(it.route, identity))
        });
        let adapter = CallingAdapter(services.collect());
        system.add_adapter(Box::new(adapter));
        Ok(())
    }

    /// Connects the topics declared so far, and the remote ends collected so far, to a bus. Samples published in the
    /// system are sent (see [`set_publish_options`](Self::set_publish_options)), and samples of other processes go to
    /// each subscriber according to its policy. `incarnation` must be unique among all processes and restarts: messages
    /// that carry it were delivered within the system, and are not delivered again.
    ///
    /// # Errors
    /// An error if the bus refuses a publisher, a subscription or a service.
    pub fn attach(
        &mut self,
        system: &mut System,
        bus: Arc<dyn Bus>,
        incarnation: u64,
    ) -> Result<(), BusError> {
        self.add_bus_adapter(system, vec![(None, bus)], incarnation)
    }

    /// Connects the system to several buses by name: a component's ends use the bus it was [put on](Self::assign_bus),
    /// and stay within the system if it has none. See [`attach`](Self::attach).
    ///
    /// # Errors
    /// An error if a bus refuses a publisher, a subscription or a service.
    pub fn attach_each(
        &mut self,
        system: &mut System,
        buses: BTreeMap<String, Arc<dyn Bus>>,
        incarnation: u64,
    ) -> Result<(), BusError> {
        let buses = buses.into_iter().map(|(name, bus)| (Some(name), bus));
        self.add_bus_adapter(system, buses.collect(), incarnation)
    }

    /// Offers services on a bus that is used for nothing else, such as a gateway's. Each service has a name there, for
    /// example `("MapServer.maps", "maps")`. If the system is attached to another bus too, call
    /// [`attach`](Self::attach) first.
    ///
    /// # Errors
    /// An error if there is no such service, or if the bus refuses it.
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
            self.add_bus_adapter(system, Vec::new(), 0)?;
        }
        let adapter = ServingAdapter::new(system, &offered, bus)?;
        system.add_adapter(Box::new(adapter));
        Ok(())
    }

    /// Returns the buses of the system, to which ends are joined while it runs; none before it is
    /// [attached](Self::attach).
    pub fn running(&self) -> RunningNetwork {
        self.running.clone()
    }

    fn add_bus_adapter(
        &mut self,
        system: &mut System,
        buses: Vec<(Option<String>, Arc<dyn Bus>)>,
        incarnation: u64,
    ) -> Result<(), BusError> {
        let ends = std::mem::take(&mut self.remote_ends);
        let adapter = BusAdapter::new(system, ends, buses, incarnation)?;
        self.running = RunningNetwork::new(adapter.attachments());
        system.add_adapter(Box::new(adapter));
        self.attached = true;
        Ok(())
    }
}

/// Wires a reference to a queue of requests for a remote service.
fn remote_route(
    system: &mut System,
    from: &str,
    service: &str,
    wire: Wire,
    address: impl Fn(&str) -> String,
) -> Result<RemoteRoute, BuildError> {
    let (caller, shown) = caller_and_service(from, service);
    let from = system.reference(from)?;
    let queue = RequestQueue::remote(Arc::clone(system.notifier()));
    let operations = system.wire_remote(&from, service, wire, Arc::clone(&queue))?;
    let operations = operations.iter();
    Ok(RemoteRoute {
        queue,
        addresses: operations.map(|called| address(called)).collect(),
        caller,
        shown,
        timeout: wire.timeout,
        robot_service: None,
        responses: Vec::new(),
        is_external: false,
    })
}

/// Returns the declaration of a reference, given as `Component.reference`, whose operations have the types of its interface.
fn expected_operations(
    system: &System,
    from: &str,
    known: &dyn Fn(&str) -> Option<Vec<OperationDeclaration>>,
) -> Result<ReferenceDeclaration, BuildError> {
    let end = system.reference(from)?;
    let mut expected = system.required_service(&end).clone();
    let known = known(&expected.interface).unwrap_or_default();
    complete_types(&mut expected, &known);
    Ok(expected)
}
