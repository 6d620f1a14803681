//! The ends of a system that use one bus.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_bus::BusError;
use asmotion_port::Time;
use asmotion_runtime::{Effects, LiveContext, System, SystemTopic};

use crate::identity::BusIdentity;
use crate::offered::OfferedOperations;
use crate::remote::{BusClient, CallerIdentity, RemoteService};
use crate::remote_ends::{RemoteEnds, is_on};
use crate::topics::BusTopics;

/// The ends of a system that use one bus.
pub(crate) struct Attachment {
    topics: BusTopics,
    offered: OfferedOperations,
    remote: Vec<RemoteService>,
}

/// Returns whether a component uses this bus.
pub(crate) fn is_component_on(
    buses: &BTreeMap<usize, String>,
    component: usize,
    bus: Option<&str>,
) -> bool {
    is_on(buses.get(&component).map(String::as_str), bus)
}

impl Attachment {
    /// Connects the ends that use the bus with this name, or all ends if it has no name. Removes the remote references
    /// of this bus from `remote_ends`.
    pub(crate) fn new(
        system: &mut System,
        remote_ends: &mut RemoteEnds,
        name: Option<&str>,
        identity: Arc<BusIdentity>,
    ) -> Result<Self, BusError> {
        identity.bus.notify_on_change(&identity.notifier);
        let homes = &remote_ends.component_buses;
        let of_bus =
            |topic: &SystemTopic| topic.filtered(|unit| is_component_on(homes, unit, name));
        let of_bus: Vec<SystemTopic> = system.topics().iter().map(of_bus).collect();
        let exposed = remote_ends.exposed.iter();
        let exposed = exposed.filter(|(end, _)| is_component_on(homes, end.component(), name));
        let topics = BusTopics::new(
            system,
            &of_bus,
            &remote_ends.publish_options,
            exposed,
            &identity,
        )?;
        let offered = remote_ends.offered.iter();
        let offered = offered.filter(|offered| is_on(offered.bus.as_deref(), name));
        let offered = OfferedOperations::new(system, offered, &identity)?;
        let reached = remote_ends
            .remote_references
            .extract_if(.., |it| is_on(it.bus.as_deref(), name));
        let caller = CallerIdentity {
            client: Arc::new(BusClient(Arc::clone(&identity.bus))),
            incarnation: identity.incarnation,
            notifier: Arc::clone(&identity.notifier),
        };
        let remote = reached.map(|it| RemoteService::new(it.route, caller.clone()));
        Ok(Self {
            topics,
            offered,
            remote: remote.collect(),
        })
    }

    /// From now on, receiving threads put messages of topics into ports themselves.
    pub(crate) fn start_live(&self, context: &LiveContext) {
        self.topics.start_live(context);
    }

    /// Moves arrived messages into the system, and waiting ones to the bus.
    pub(crate) fn deliver(&mut self, now: Time, effects: &mut dyn Effects) {
        self.topics.deliver(now, effects);
        for remote in &mut self.remote {
            remote.deliver(now, effects);
        }
        self.offered.deliver(now, effects);
    }
}
