//! The adapters between a system and its buses.
//!
//! They are used by one thread: the bus thread of a live system, or the simulation's thread. A cycle puts its messages
//! into queues and never waits for a transport. In a live system, incoming messages of topics bypass the bus thread:
//! the receiving thread puts them into their ports ([`crate::subscription`]).

use std::sync::Arc;

use asmotion_bus::{Bus, BusError};
use asmotion_port::Time;
use asmotion_runtime::{
    Adapter, Effects, InjectionPorts, LiveContext, OuterService, System, SystemTopic,
    publish_without_bus,
};

use crate::attachment::{Attachment, is_component_on};
use crate::identity::BusIdentity;
use crate::offered::{self, OfferedOperations};
use crate::remote::RemoteService;
use crate::remote_ends::{OfferedService, RemoteEnds};

/// Connects the remote ends of a system to its buses. Dropping it closes them.
pub(crate) struct BusAdapter {
    attachments: Vec<Arc<Attachment>>,
    /// The topics of components that use no bus, until the state of the bus has been published to them once.
    internal_topics: Option<(Vec<SystemTopic>, InjectionPorts)>,
}

impl BusAdapter {
    /// Connects the collected ends to the buses; a bus without a name gets all of them.
    pub(crate) fn new(
        system: &mut System,
        mut remote_ends: RemoteEnds,
        buses: Vec<(Option<String>, Arc<dyn Bus>)>,
        incarnation: u64,
    ) -> Result<Self, BusError> {
        let name_of = |(name, _): &(Option<String>, _)| name.clone();
        let names: Vec<Option<String>> = buses.iter().map(name_of).collect();
        let mut attachments = Vec::new();
        for (name, bus) in buses {
            let identity = BusIdentity {
                bus,
                incarnation,
                notifier: Arc::clone(system.notifier()),
            };
            let attachment = Attachment::new(system, &mut remote_ends, name.as_deref(), identity)?;
            attachments.push(attachment);
        }
        let homes = &remote_ends.component_buses;
        let is_inside = |component| {
            !names
                .iter()
                .any(|name| is_component_on(homes, component, name.as_deref()))
        };
        let topics = system.topics().iter();
        let inside: Vec<SystemTopic> = topics.map(|topic| topic.filtered(is_inside)).collect();
        let ports = system.injection_topics(&inside);
        Ok(Self {
            attachments,
            internal_topics: Some((inside, ports)),
        })
    }

    /// The ends on each bus.
    pub(crate) fn attachments(&self) -> &[Arc<Attachment>] {
        &self.attachments
    }
}

impl Drop for BusAdapter {
    fn drop(&mut self) {
        self.attachments.iter().for_each(|it| it.close());
    }
}

impl Adapter for BusAdapter {
    fn start_live(&mut self, context: &LiveContext) {
        for attachment in &self.attachments {
            attachment.start_live(context);
        }
    }

    fn deliver(&mut self, now: Time, effects: &mut dyn Effects) {
        if let Some((topics, mut ports)) = self.internal_topics.take() {
            publish_without_bus(&topics, &mut ports, now, effects);
        }
        for attachment in &self.attachments {
            attachment.deliver(now, effects);
        }
    }
}

/// Serves operations on a bus that is used for nothing else.
pub(crate) struct ServingAdapter(OfferedOperations);

impl ServingAdapter {
    pub(crate) fn new(
        system: &System,
        offered: &[OfferedService],
        bus: Arc<dyn Bus>,
    ) -> Result<Self, BusError> {
        let identity = BusIdentity {
            bus,
            // never used: nothing is published
            incarnation: 0,
            notifier: Arc::clone(system.notifier()),
        };
        let mut operations = OfferedOperations::default();
        for offered in offered {
            let (declaration, queue) = system.provided_service(&offered.service);
            let service = OuterService {
                provider: offered.service.component(),
                declaration,
                queue,
            };
            operations.add(offered::open(0, &offered.name, &service, &identity)?);
        }
        Ok(Self(operations))
    }
}

impl Adapter for ServingAdapter {
    fn deliver(&mut self, now: Time, effects: &mut dyn Effects) {
        self.0.deliver(now, effects);
    }
}

/// Calls services of other systems.
pub(crate) struct CallingAdapter(pub Vec<RemoteService>);

impl Adapter for CallingAdapter {
    fn deliver(&mut self, now: Time, effects: &mut dyn Effects) {
        self.0.retain_mut(|remote| remote.deliver(now, effects));
    }
}
