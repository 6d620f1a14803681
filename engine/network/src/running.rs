//! Ends joined to the buses of a running system.

use std::collections::BTreeSet;
use std::sync::Arc;

use asmotion_bus::{PublishOptions, RobotAddress, ServiceClient};
use asmotion_component::Wire;
use asmotion_component::declaration::{OperationDeclaration, ReferenceDeclaration};
use asmotion_port::Policy;
use asmotion_runtime::{OuterEnd, RequestQueue};

use crate::attachment::Attachment;
use crate::remote::RemoteRoute;
use crate::remote_ends::{
    address, caller_and_service, complete_types, is_on, outer_service, outer_topic,
};
use crate::robot_service::RobotService;
use crate::topics;

/// The buses of a system while it runs. Its methods return how an end is joined to a bus, for a
/// [`Change`](asmotion_runtime::Change); `None` if its component uses no bus.
#[derive(Clone, Default)]
pub struct RunningNetwork {
    attachments: Vec<Arc<Attachment>>,
}

/// A component as others see it: its name outside the system, and the bus that it uses if there are several.
#[derive(Debug, Clone, Copy)]
pub struct OuterName<'a> {
    /// Name outside the system.
    pub id: &'a str,
    /// The bus, if there are several.
    pub bus: Option<&'a str>,
}

impl RunningNetwork {
    pub(crate) fn new(attachments: &[Arc<Attachment>]) -> Self {
        Self {
            attachments: attachments.to_vec(),
        }
    }

    fn on(&self, bus: Option<&str>) -> Option<&Arc<Attachment>> {
        let mut attachments = self.attachments.iter();
        attachments.find(|it| is_on(bus, it.name()))
    }

    /// Returns whether components use this bus, if it is given, or the only one.
    pub fn has(&self, bus: Option<&str>) -> bool {
        self.on(bus).is_some()
    }

    /// Removes names that the same bus would have twice, because it is the only one.
    pub fn distinct(
        &self,
        offers: BTreeSet<(String, Option<String>)>,
    ) -> BTreeSet<(String, Option<String>)> {
        let is_single = self.attachments.iter().any(|it| it.name().is_none());
        let bus = |bus: Option<String>| bus.filter(|_| !is_single);
        offers
            .into_iter()
            .map(|(name, it)| (name, bus(it)))
            .collect()
    }

    /// Publishes an output on a topic.
    pub fn publish(
        &self,
        component: OuterName<'_>,
        output: &str,
        topic: &str,
        options: PublishOptions,
    ) -> Option<OuterEnd> {
        let attachment = Arc::clone(self.on(component.bus)?);
        let (source, topic): (Arc<str>, _) = (component.id.into(), topic.to_owned());
        let outside = outer_topic(&topic);
        Some(OuterEnd::output(
            output,
            outside,
            options.init,
            move |end| {
                let (source, identity) = (Arc::clone(&source), attachment.identity());
                let sender = topics::open(&topic, source, end.schema, end.cause, options, identity);
                sender.map_err(|error| error.to_string())
            },
        ))
    }

    /// Subscribes an input to a topic.
    pub fn subscribe(
        &self,
        component: OuterName<'_>,
        topic: &str,
        input: &str,
        policy: Policy,
    ) -> Option<OuterEnd> {
        let attachment = Arc::clone(self.on(component.bus)?);
        let (reader, topic, kind) = (component.id.to_owned(), topic.to_owned(), policy.kind);
        let outside = outer_topic(&topic);
        Some(OuterEnd::input(input, outside, policy, move |end| {
            let opened = attachment.open_subscription(&reader, &topic, kind, end);
            let opened = opened.map_err(|error| error.to_string())?;
            Ok(Box::new(opened))
        }))
    }

    /// Offers a service under a name.
    pub fn offer(&self, service: &str, name: &str, bus: Option<&str>) -> Option<OuterEnd> {
        let attachment = Arc::clone(self.on(bus)?);
        let (outside, name) = (outer_service(name), name.to_owned());
        Some(OuterEnd::service(service, outside, move |end| {
            let opened = attachment.open_service(&name, &end);
            let opened = opened.map_err(|error| error.to_string())?;
            Ok(Box::new(opened))
        }))
    }

    /// Wires a reference to a service that another process offers.
    pub fn call(&self, caller: OuterCaller<'_>, service: &str) -> Option<OuterEnd> {
        let attachment = Arc::clone(self.on(caller.bus)?);
        let addresses = service.to_owned();
        Some(caller.end(service, move |outer| {
            let address = |operation: &str| address(&addresses, operation);
            let route = outer.route(&attachment, address);
            let queue = Arc::clone(&route.queue);
            attachment.call(route);
            Ok(queue)
        }))
    }

    /// Wires a reference to a service of another robot, which is compared with its announcement
    /// ([`new_robot_services`](Self::new_robot_services)).
    pub fn call_robot(
        &self,
        caller: OuterCaller<'_>,
        service: RobotAddress<'_>,
    ) -> Option<OuterEnd> {
        let attachment = Arc::clone(self.on(caller.bus)?);
        let (robot, name) = (service.robot().to_owned(), service.name().to_owned());
        let from = caller.reference.to_owned();
        let shown = service.to_string();
        Some(caller.end(&shown.clone(), move |outer| {
            let route = outer.route(&attachment, |operation| address(&shown, operation));
            let expected = Arc::new(RobotService::new(
                &from,
                (&robot, &name),
                outer.expected,
                outer.wire.timeout,
                Arc::clone(&attachment.identity().notifier),
            ));
            attachment.expect(&expected);
            let queue = Arc::clone(&route.queue);
            attachment.call(RemoteRoute {
                robot_service: Some(expected),
                ..route
            });
            Ok(queue)
        }))
    }

    /// Wires a reference to a service of another system, given by its URL and by the URL without secrets. `client` returns the
    /// client that calls it. `None` if the system is on no bus.
    pub fn call_external(
        &self,
        caller: OuterCaller<'_>,
        (url, shown): (&str, &str),
        client: impl Fn() -> Result<Arc<dyn ServiceClient>, String> + Send + Sync + 'static,
    ) -> Option<OuterEnd> {
        // the adapter of any bus passes requests on
        let attachment = Arc::clone(self.attachments.first()?);
        let base = url.trim_end_matches('/').to_owned();
        Some(caller.end(shown, move |outer| {
            let client = client()?;
            let route = outer.route(&attachment, |operation| format!("{base}/{operation}"));
            let queue = Arc::clone(&route.queue);
            let route = RemoteRoute {
                is_external: true,
                ..route
            };
            attachment.call_through(client, route);
            Ok(queue)
        }))
    }

    /// Takes the services of other robots to which references have been wired on this bus since the last time, if it is given, or
    /// on the only one. They are to be compared with the announcements of their robots.
    pub fn new_robot_services(&self, bus: Option<&str>) -> Vec<Arc<RobotService>> {
        let attachment = self.on(bus);
        attachment.map_or_else(Vec::new, |it| it.take_expected())
    }
}

/// The operations of service interfaces by the name of the interface; `None` for one that is unknown.
pub type KnownOperations = Arc<dyn Fn(&str) -> Option<Vec<OperationDeclaration>> + Send + Sync>;

/// A reference that is wired to a service outside.
pub struct OuterCaller<'a> {
    /// The reference, for example `Coordinator.maps`.
    pub reference: &'a str,
    /// Timeout, retries and direction of the calls.
    pub wire: Wire,
    /// The bus, if there are several.
    pub bus: Option<&'a str>,
    /// Types of operations that the reference declares without types.
    pub known: KnownOperations,
}

/// A reference while its service is opened.
struct OpeningCaller {
    caller: String,
    shown: String,
    wire: Wire,
    /// The reference, with the types of its interface.
    expected: ReferenceDeclaration,
}

impl OuterCaller<'_> {
    /// Returns the end outside that `open` opens.
    fn end(
        self,
        service: &str,
        open: impl Fn(OpeningCaller) -> Result<Arc<RequestQueue>, String> + Send + Sync + 'static,
    ) -> OuterEnd {
        let Self {
            reference,
            wire,
            known,
            ..
        } = self;
        let (caller, shown) = caller_and_service(reference, service);
        OuterEnd::reference(reference, service.to_owned(), wire, move |declaration| {
            let mut expected = declaration.clone();
            complete_types(
                &mut expected,
                &known(&declaration.interface).unwrap_or_default(),
            );
            open(OpeningCaller {
                caller: caller.clone(),
                shown: shown.clone(),
                wire,
                expected,
            })
        })
    }
}

impl OpeningCaller {
    /// Returns the route to a service whose operations have these addresses.
    fn route(&self, attachment: &Attachment, address: impl Fn(&str) -> String) -> RemoteRoute {
        let operations = self.expected.operations.iter();
        let responses = operations.clone().map(|it| it.response.clone());
        RemoteRoute {
            queue: RequestQueue::remote(Arc::clone(&attachment.identity().notifier)),
            responses: responses.collect(),
            addresses: operations.map(|it| address(&it.name)).collect(),
            caller: self.caller.clone(),
            shown: self.shown.clone(),
            timeout: self.wire.timeout,
            robot_service: None,
            is_external: false,
        }
    }
}
