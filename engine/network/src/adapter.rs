//! The adapters between a system and its buses.
//!
//! One thread has them: the bus thread of a live system, or the simulation's. A cycle leaves what it sends in a queue and
//! waits for no transport. In a live system messages of topics need not wait for that thread: the thread that brings one
//! puts it into its port ([`crate::subscription`]).

use std::sync::Arc;

use asmotion_bus::{Bus, BusError};
use asmotion_port::Time;
use asmotion_runtime::{
    Adapter, Effects, InjectionPorts, LiveContext, System, SystemTopic, publish_without_bus,
};

use crate::attachment::{Attachment, is_here};
use crate::ends::{OfferedService, RemoteEnds};
use crate::identity::BusIdentity;
use crate::offered::OfferedOperations;

/// Joins the remote ends of a system to its buses.
pub(crate) struct BusAdapter {
    attachments: Vec<Attachment>,
    /// The topics of components that are on no bus, until they have been told that none is gone.
    inside: Option<(Vec<SystemTopic>, InjectionPorts)>,
}

impl BusAdapter {
    /// Joins what was collected to the buses; everything to a bus without a name.
    pub(crate) fn new(
        system: &mut System,
        mut ends: RemoteEnds,
        buses: Vec<(Option<String>, Arc<dyn Bus>)>,
        incarnation: u64,
    ) -> Result<Self, BusError> {
        let named = |(name, _): &(Option<String>, _)| name.clone();
        let names: Vec<Option<String>> = buses.iter().map(named).collect();
        let mut attachments = Vec::new();
        for (name, bus) in buses {
            let identity = Arc::new(BusIdentity {
                bus,
                incarnation,
                notifier: Arc::clone(system.notifier()),
            });
            let attachment = Attachment::new(system, &mut ends, name.as_deref(), identity)?;
            attachments.push(attachment);
        }
        let homes = &ends.homes;
        let is_inside = |component| {
            !names
                .iter()
                .any(|name| is_here(homes, component, name.as_deref()))
        };
        let topics = system.topics().iter();
        let inside: Vec<SystemTopic> = topics.map(|topic| topic.filtered(is_inside)).collect();
        let ports = system.injection_topics(&inside);
        Ok(Self {
            attachments,
            inside: Some((inside, ports)),
        })
    }
}

impl Adapter for BusAdapter {
    fn go_live(&mut self, context: &LiveContext) {
        for attachment in &self.attachments {
            attachment.go_live(context);
        }
    }

    fn deliver(&mut self, now: Time, effects: &mut dyn Effects) {
        if let Some((topics, mut ports)) = self.inside.take() {
            publish_without_bus(&topics, &mut ports, now, effects);
        }
        for attachment in &mut self.attachments {
            attachment.deliver(now, effects);
        }
    }
}

/// Serves operations on a bus that carries nothing else.
pub(crate) struct ServingAdapter(OfferedOperations);

impl ServingAdapter {
    pub(crate) fn new(
        system: &System,
        offered: &[OfferedService],
        bus: Arc<dyn Bus>,
    ) -> Result<Self, BusError> {
        let identity = BusIdentity {
            bus,
            // it publishes nothing
            incarnation: 0,
            notifier: Arc::clone(system.notifier()),
        };
        OfferedOperations::new(system, offered.iter(), &identity).map(Self)
    }
}

impl Adapter for ServingAdapter {
    fn deliver(&mut self, now: Time, effects: &mut dyn Effects) {
        self.0.deliver(now, effects);
    }
}
