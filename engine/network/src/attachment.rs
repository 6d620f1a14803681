//! The ends of a system that use one bus.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use asmotion_bus::{BusError, ServiceClient};
use asmotion_component::HEALTH_TOPIC;
use asmotion_port::{BufferKind, Policy, Time};
use asmotion_runtime::{
    ComponentEnd, Effects, InjectionPort, InjectionPorts, LiveContext, OpenedEnd, OuterInput,
    OuterService, System, SystemTopic,
};

use crate::health::HealthPublisher;
use crate::identity::BusIdentity;
use crate::offered::{self, OfferedOperation, OfferedOperations};
use crate::remote::{BusClient, CallerIdentity, RemoteRoute, RemoteService};
use crate::remote_ends::{OfferedService, RemoteEnds, is_on, outer_service, outer_topic};
use crate::robot_service::RobotService;
use crate::subscription::TopicSubscription;
use crate::topics;

/// The ends of a system that use one bus.
///
/// Two threads use it: the one that calls the adapter delivers, the owner's adds and removes ends while the system runs. The owner
/// opens and closes ends at the bus without holding the lock, because that can wait for a broker.
pub(crate) struct Attachment {
    /// Name of the bus; `None` if it is the only one, which all ends use.
    name: Option<String>,
    identity: BusIdentity,
    /// Messages of this incarnation are skipped: they were sent by this process and delivered within it.
    own_incarnation: Option<u64>,
    /// Set when the system goes live; from then on, receiving threads put messages into ports.
    live: OnceLock<LiveContext>,
    /// Number of the newest offered service.
    last_offer: AtomicU64,
    ends: Mutex<AttachedEnds>,
}

/// The ends that the adapter serves.
struct AttachedEnds {
    subscriptions: Vec<TopicSubscription>,
    offered: OfferedOperations,
    remote: Vec<RemoteService>,
    /// Services of other robots that are not compared with their announcements yet.
    expected: Vec<Arc<RobotService>>,
    health: HealthPublisher,
    /// Injection ports of the subscribers of [`HEALTH_TOPIC`].
    health_ports: InjectionPorts,
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
        identity: BusIdentity,
    ) -> Result<Arc<Self>, BusError> {
        identity.bus.notify_on_change(&identity.notifier);
        let homes = &remote_ends.component_buses;
        let of_bus =
            |topic: &SystemTopic| topic.filtered(|unit| is_component_on(homes, unit, name));
        let of_bus: Vec<SystemTopic> = system.topics().iter().map(of_bus).collect();
        let exposed = remote_ends.exposed.iter();
        let exposed = exposed.filter(|(end, _)| is_component_on(homes, end.component(), name));
        topics::publish_all(
            system,
            &of_bus,
            &remote_ends.publish_options,
            exposed,
            &identity,
        )?;
        let is_health = |topic: &&SystemTopic| topic.name == HEALTH_TOPIC;
        let health: Vec<SystemTopic> = of_bus.iter().filter(is_health).cloned().collect();
        let own = (!system.leaves_topics_to_adapters()).then_some(identity.incarnation);
        let attachment = Arc::new(Self {
            name: name.map(str::to_owned),
            identity,
            own_incarnation: own,
            live: OnceLock::new(),
            last_offer: AtomicU64::new(0),
            ends: Mutex::new(AttachedEnds {
                subscriptions: Vec::new(),
                offered: OfferedOperations::default(),
                remote: Vec::new(),
                expected: Vec::new(),
                health: HealthPublisher::new(&health),
                health_ports: system.injection_topics(&health),
            }),
        });
        for topic in of_bus.iter().filter(|topic| !is_health(topic)) {
            for (end, policy) in &topic.subscribers {
                attachment.subscribe(system, &topic.name, end, policy)?;
            }
        }
        let offered = remote_ends.offered.iter();
        for it in offered.filter(|offered| is_on(offered.bus.as_deref(), name)) {
            attachment.offer(system, it)?;
        }
        let reached = remote_ends
            .remote_references
            .extract_if(.., |it| is_on(it.bus.as_deref(), name));
        reached.for_each(|it| attachment.call(it.route));
        Ok(attachment)
    }

    /// Name of the bus; `None` if it is the only one.
    pub(crate) fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// The bus, and the identity of the process on it.
    pub(crate) fn identity(&self) -> &BusIdentity {
        &self.identity
    }

    fn lock(&self) -> MutexGuard<'_, AttachedEnds> {
        self.ends.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// From now on, receiving threads put messages of topics into ports themselves.
    pub(crate) fn start_live(&self, context: &LiveContext) {
        for subscription in &self.lock().subscriptions {
            subscription.start_live(context);
        }
        // never set twice: a system goes live once
        let _ = self.live.set(context.clone());
    }

    /// Moves arrived messages into the system, and waiting ones to the bus.
    pub(crate) fn deliver(&self, now: Time, effects: &mut dyn Effects) {
        let AttachedEnds {
            subscriptions,
            offered,
            remote,
            health,
            health_ports,
            ..
        } = &mut *self.lock();
        health.publish(|| self.identity.bus.health(), health_ports, now, effects);
        for subscription in subscriptions {
            subscription.deliver(now, effects);
        }
        remote.retain_mut(|remote| remote.deliver(now, effects));
        offered.deliver(now, effects);
    }

    /// Closes all ends, because the system ends.
    pub(crate) fn close(&self) {
        let mut ends = self.lock();
        let subscriptions = std::mem::take(&mut ends.subscriptions);
        let offered = std::mem::take(&mut ends.offered);
        let remote = std::mem::take(&mut ends.remote);
        drop(ends);
        drop((subscriptions, offered, remote));
    }

    /// Subscribes an input, before the system runs.
    fn subscribe(
        self: &Arc<Self>,
        system: &mut System,
        topic: &str,
        input: &ComponentEnd,
        policy: &Policy,
    ) -> Result<(), BusError> {
        // fails for a policy that an earlier check excludes
        let Some(port) = system.injection_port(input, policy) else {
            return Ok(());
        };
        let connection = port.connection();
        let outer = OuterInput {
            port,
            schema: system.input_schema(input),
            cause: system.cycle_cause(input),
        };
        let reader = system.external_name(input);
        let mut opened = self.open_subscription(&reader, topic, policy.kind, outer)?;
        opened.begin();
        let outside = outer_topic(topic);
        system.hold_end(input, outside, Some(connection), Box::new(opened));
        Ok(())
    }

    /// Subscribes an input to a topic. `reader` is the name of its component outside. If the input is subscribed already with the
    /// same queue, the new connection takes its messages over.
    pub(crate) fn open_subscription(
        self: &Arc<Self>,
        reader: &str,
        topic: &str,
        kind: BufferKind,
        input: OuterInput<'_>,
    ) -> Result<AttachedSubscription, BusError> {
        let attachment = Arc::downgrade(self);
        let suits = |it: &&TopicSubscription| it.suits((reader, topic), input.port.name(), kind);
        let known = self.lock().subscriptions.iter().find(suits).cloned();
        if let Some(subscription) = known {
            subscription.set_successor(true);
            return Ok(AttachedSubscription {
                attachment,
                subscription,
                successor: Some(input.port),
            });
        }
        let own = self.own_incarnation;
        let subscription = TopicSubscription::new(reader, topic, kind, input, own, &self.identity)?;
        Ok(AttachedSubscription {
            attachment,
            subscription,
            successor: None,
        })
    }

    /// Offers a service, before the system runs. A service offered over several buses may be listed twice for the same bus.
    fn offer(
        self: &Arc<Self>,
        system: &mut System,
        offered: &OfferedService,
    ) -> Result<(), BusError> {
        let OfferedService {
            service: end, name, ..
        } = offered;
        if self.lock().offered.has(name) {
            return Ok(());
        }
        let (declaration, queue) = system.provided_service(end);
        let mut opened = self.open_service(
            name,
            &OuterService {
                provider: end.component(),
                declaration,
                queue,
            },
        )?;
        opened.begin();
        system.hold_end(end, outer_service(name), None, Box::new(opened));
        Ok(())
    }

    /// Offers a service under a name.
    pub(crate) fn open_service(
        self: &Arc<Self>,
        name: &str,
        service: &OuterService<'_>,
    ) -> Result<AttachedService, BusError> {
        let offer = self.last_offer.fetch_add(1, Ordering::Relaxed) + 1;
        Ok(AttachedService {
            attachment: Arc::downgrade(self),
            operations: offered::open(offer, name, service, &self.identity)?,
            offer,
        })
    }

    /// Calls a service of another process. The end is closed once the reference is gone and its calls have ended.
    pub(crate) fn call(&self, route: RemoteRoute) {
        let client = BusClient(Arc::clone(&self.identity.bus));
        self.call_through(Arc::new(client), route);
    }

    /// Calls a service as [`call`](Self::call) does, through this client.
    pub(crate) fn call_through(&self, client: Arc<dyn ServiceClient>, route: RemoteRoute) {
        let caller = CallerIdentity {
            client,
            incarnation: self.identity.incarnation,
            notifier: Arc::clone(&self.identity.notifier),
        };
        let remote = RemoteService::new(route, caller);
        self.lock().remote.push(remote);
    }

    /// Adds a service of another robot that is to be compared with its announcement.
    pub(crate) fn expect(&self, service: &Arc<RobotService>) {
        self.lock().expected.push(Arc::clone(service));
    }

    /// Takes the services that have been added by [`expect`](Self::expect).
    pub(crate) fn take_expected(&self) -> Vec<Arc<RobotService>> {
        std::mem::take(&mut self.lock().expected)
    }
}

/// A subscription of an input.
pub(crate) struct AttachedSubscription {
    attachment: Weak<Attachment>,
    subscription: TopicSubscription,
    /// The connection that takes over the messages of another one of the same input, until it [begins](OpenedEnd::begin).
    successor: Option<InjectionPort>,
}

impl OpenedEnd for AttachedSubscription {
    fn begin(&mut self) {
        let Some(attachment) = self.attachment.upgrade() else {
            return;
        };
        if let Some(port) = self.successor.take() {
            self.subscription.continue_through(port);
            return;
        }
        if let Some(context) = attachment.live.get() {
            self.subscription.start_live(context);
        }
        let subscription = self.subscription.clone();
        attachment.lock().subscriptions.push(subscription);
        // messages may have arrived already
        self.subscription.notify();
    }
}

impl Drop for AttachedSubscription {
    fn drop(&mut self) {
        if self.successor.is_some() {
            // the change was refused, and the other connection stays
            self.subscription.set_successor(false);
            return;
        }
        if self.subscription.pause() {
            return;
        }
        if let Some(attachment) = self.attachment.upgrade() {
            let subscriptions = &mut attachment.lock().subscriptions;
            subscriptions.retain(|it| !it.is_same(&self.subscription));
        }
    }
}

/// An offered service.
pub(crate) struct AttachedService {
    attachment: Weak<Attachment>,
    /// Number of the service in the attachment.
    offer: u64,
    /// Its operations until they [begin](OpenedEnd::begin).
    operations: Vec<OfferedOperation>,
}

impl OpenedEnd for AttachedService {
    fn begin(&mut self) {
        let operations = std::mem::take(&mut self.operations);
        if let Some(attachment) = self.attachment.upgrade() {
            attachment.lock().offered.add(operations);
            attachment.identity.notifier.notify();
        }
    }
}

impl Drop for AttachedService {
    fn drop(&mut self) {
        if let Some(attachment) = self.attachment.upgrade() {
            // the lock is released first: the bus may wait until the address is free
            let closed = attachment.lock().offered.remove(self.offer);
            drop(closed);
        }
    }
}
