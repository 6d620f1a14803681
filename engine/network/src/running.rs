//! Ends joined to the buses of a running system.

use std::collections::BTreeSet;
use std::sync::Arc;

use asmotion_bus::PublishOptions;
use asmotion_component::Wire;
use asmotion_port::Policy;
use asmotion_runtime::{OuterEnd, RequestQueue};

use crate::attachment::Attachment;
use crate::remote::RemoteRoute;
use crate::remote_ends::{address, caller_and_service, is_on, outer_service, outer_topic};
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
    pub fn call(
        &self,
        reference: &str,
        service: &str,
        wire: Wire,
        bus: Option<&str>,
    ) -> Option<OuterEnd> {
        let attachment = Arc::clone(self.on(bus)?);
        let (caller, shown) = caller_and_service(reference, service);
        let (outside, service) = (service.to_owned(), service.to_owned());
        Some(OuterEnd::reference(
            reference,
            outside,
            wire,
            move |declaration| {
                let notifier = Arc::clone(&attachment.identity().notifier);
                let queue = RequestQueue::remote(notifier);
                let operations = declaration.operations.iter();
                let responses = operations.clone().map(|it| it.response.clone());
                attachment.call(RemoteRoute {
                    queue: Arc::clone(&queue),
                    responses: responses.collect(),
                    addresses: operations.map(|it| address(&service, &it.name)).collect(),
                    caller: caller.clone(),
                    shown: shown.clone(),
                    timeout: wire.timeout,
                    robot_service: None,
                    is_external: false,
                });
                queue
            },
        ))
    }
}
