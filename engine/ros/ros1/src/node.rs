//! The synchronous interface of a node, which delegates to tasks on separate threads.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_bus::{
    AddressQueue, CallFailure, Health, LinkState, Notifier, Payload, PendingCall, QueuePolicy,
    Refusal, Request, SenderId, ServedAddress, Subscription, SubscriptionSender, deadline_after,
};
use asmotion_datum::{Datum, DatumError, ros1};
use tokio::runtime::{Builder, Handle};
use tokio::time::timeout_at;

use crate::caller::{FAILED, RosServiceClient, UNREADABLE};
use crate::context::{Context, MasterAnswer, lock};
use crate::error::RosError;
use crate::graph::RosGraph;
use crate::http::RosUri;
use crate::interface::{ServiceType, TopicType};
use crate::names::RosName;
use crate::parameter::FollowedParameter;
use crate::provider::ProvidedService;
use crate::publication::{Publication, RosPublisherCounts};
use crate::reader::TopicReader;
use crate::registrar::Registrar;
use crate::server::{serve_api, serve_data};
use crate::settings::RosSettings;
use crate::slave::Slave;
use crate::subscription::{RosSubscriptionCounts, TopicSubscription, UnreadableMessages};
use crate::tables::{Tables, entry};
use crate::xmlrpc::XmlRpcValue;

/// Threads of a node.
const WORKERS: usize = 2;
/// Code of a [`Refusal`]: the parameter is not set.
const UNSET: &str = "unset";

/// A node of ROS 1. Dropping it withdraws its registrations and closes its connections.
pub struct RosNode {
    context: Arc<Context>,
    tables: Arc<Tables>,
    tasks: Handle,
    thread: Option<JoinHandle<()>>,
    /// `None` if topics are read by the threads of the node.
    _reader: Option<TopicReader>,
}

/// Publishes one topic. Dropping it ends the publication, after the messages in the queues.
pub struct RosPublisher {
    publication: Arc<Publication>,
    context: Arc<Context>,
    tables: Arc<Tables>,
}

impl RosNode {
    /// Starts a node, which registers in the background and goes on trying forever. [`health`](Self::health) reports the
    /// state.
    ///
    /// # Errors
    /// [`RosError::Name`], or [`RosError::System`] if the system refuses sockets or a thread. A master that does not answer is
    /// not an error.
    pub fn start(settings: RosSettings) -> Result<Self, RosError> {
        let system = |error: std::io::Error| RosError::System(error.to_string());
        let context = Context::new(settings)?;
        let host = &context.settings.host;
        let address: Option<IpAddr> = host.parse().ok();
        let is_local = host == "localhost" || address.is_some_and(|it| it.is_loopback());
        let listen = match (is_local, address) {
            (true, Some(address)) => address,
            (true, None) => Ipv4Addr::LOCALHOST.into(),
            (false, Some(IpAddr::V6(_))) => std::net::Ipv6Addr::UNSPECIFIED.into(),
            (false, Some(IpAddr::V4(_)) | None) => Ipv4Addr::UNSPECIFIED.into(),
        };
        let bind = || {
            let listener = TcpListener::bind(SocketAddr::new(listen, 0))?;
            listener.set_nonblocking(true)?;
            Ok((listener.local_addr()?.port(), listener))
        };
        let (api_port, api) = bind().map_err(system)?;
        let (data_port, data) = bind().map_err(system)?;
        // both are set once, here
        let _ = context.uri.set(RosUri::new(host, api_port));
        let _ = context.port.set(data_port);
        let runtime = Builder::new_multi_thread()
            .worker_threads(WORKERS)
            .thread_name("ros")
            .enable_all()
            .build()
            .map_err(system)?;
        let tasks = runtime.handle().clone();
        let tables = Arc::new(Tables::default());
        let reader = TopicReader::of(&context).map_err(system)?;
        let readers = reader.as_ref().map_or(&tasks, |it| &it.tasks).clone();
        {
            let _inside = runtime.enter();
            let api = tokio::net::TcpListener::from_std(api).map_err(system)?;
            let data = tokio::net::TcpListener::from_std(data).map_err(system)?;
            let slave = Arc::new(Slave {
                context: Arc::clone(&context),
                tables: Arc::clone(&tables),
                tasks: readers.clone(),
            });
            runtime.spawn(serve_api(api, slave));
            runtime.spawn(serve_data(data, Arc::clone(&context), Arc::clone(&tables)));
        }
        let registrar = Registrar::new(Arc::clone(&context), Arc::clone(&tables), readers);
        let thread = std::thread::Builder::new()
            .name("ros".to_owned())
            .spawn(move || {
                runtime.block_on(registrar.run());
                runtime.shutdown_timeout(Duration::from_millis(100));
            })
            .map_err(system)?;
        Ok(Self {
            context,
            tables,
            tasks,
            thread: Some(thread),
            _reader: reader,
        })
    }

    /// Waits until the master knows all that the node takes part in.
    ///
    /// # Errors
    /// [`RosError::Master`] with the reason, if this is not so after `timeout`.
    pub fn await_registered(&self, timeout: Duration) -> Result<(), RosError> {
        let notifier = Arc::new(Notifier::new());
        self.notify_on_change(&notifier);
        let until = deadline_after(timeout);
        let changes = self.context.changes();
        loop {
            let reason = match self.health().link {
                LinkState::Up if self.context.known_changes() >= changes => return Ok(()),
                LinkState::Up => "it has not answered yet".into(),
                LinkState::Blocked { reason } | LinkState::Down { reason } => reason,
            };
            let remaining = until.saturating_duration_since(Instant::now());
            if remaining.is_zero() {
                return Err(RosError::Master {
                    master: self.context.settings.master.to_string(),
                    reason: reason.to_string(),
                });
            }
            notifier.wait(remaining);
        }
    }

    /// The name of the node.
    pub fn name(&self) -> &RosName {
        &self.context.name
    }

    /// The address at which the node is called.
    pub fn uri(&self) -> String {
        self.context.own_uri()
    }

    /// The state: up while the master knows the node.
    pub fn health(&self) -> Health {
        self.context.health()
    }

    /// Notifies `notifier` of every change of [`health`](Self::health) until all other references to it have been dropped.
    pub fn notify_on_change(&self, notifier: &Arc<Notifier>) {
        self.context.watch(notifier);
    }

    /// Creates the publisher of a topic. At most `size` messages wait for each subscriber; then the oldest one is dropped and
    /// counted. A latched topic gives its last message to new subscribers.
    ///
    /// # Errors
    /// [`RosError::Name`], [`RosError::Published`] if there is a publisher.
    pub fn publisher(
        &self,
        topic: &str,
        of: TopicType,
        size: usize,
        is_latched: bool,
    ) -> Result<RosPublisher, RosError> {
        let topic = self.context.name.resolve(topic)?;
        let mut publications = lock(&self.tables.publications);
        if let Some(publication) = publications.get(&topic) {
            return Err(RosError::Published {
                topic: topic.to_string(),
                declared: publication.of.name.to_string(),
                again: of.name.to_string(),
            });
        }
        let publication = Publication::new(topic.clone(), of, size, is_latched);
        let publication = Arc::new(publication);
        publications.insert(topic, Arc::clone(&publication));
        drop(publications);
        self.changed();
        Ok(RosPublisher {
            publication,
            context: Arc::clone(&self.context),
            tables: Arc::clone(&self.tables),
        })
    }

    /// Subscribes to a topic. Each subscription receives every message; all share the connections. Without a type, messages
    /// are read by the definition that their publisher sends.
    ///
    /// The source of an envelope is the name of the publishing node, its payload a datum, and its incarnation and sequence
    /// number the connection and the message on it.
    ///
    /// # Errors
    /// [`RosError::Name`], [`RosError::SubscribedOtherwise`] if there is a subscription with another type.
    pub fn subscribe(
        &self,
        topic: &str,
        of: Option<TopicType>,
        queue: QueuePolicy,
        notifier: Arc<Notifier>,
    ) -> Result<Subscription, RosError> {
        let topic = self.context.name.resolve(topic)?;
        let sender = SubscriptionSender::new(queue, notifier);
        let mut subscriptions = lock(&self.tables.subscriptions);
        let subscription = match subscriptions.get(&topic) {
            Some(subscription) if subscription.of == of => Arc::clone(subscription),
            Some(subscription) => {
                let name = |of: &Option<TopicType>| match of {
                    Some(of) => format!("{} ({})", of.name, of.md5),
                    None => "*".to_owned(),
                };
                return Err(RosError::SubscribedOtherwise {
                    topic: topic.to_string(),
                    declared: name(&subscription.of),
                    again: name(&of),
                });
            }
            None => {
                let subscription = Arc::new(TopicSubscription::new(topic.clone(), of));
                subscriptions.insert(topic.clone(), Arc::clone(&subscription));
                subscription
            }
        };
        subscription.add(sender.clone());
        drop(subscriptions);
        self.changed();
        let (tables, context, observer) = (
            Arc::clone(&self.tables),
            Arc::clone(&self.context),
            sender.clone(),
        );
        Ok(sender.subscription(move || {
            let mut subscriptions = lock(&tables.subscriptions);
            if subscription.remove(&observer) {
                subscription.close();
                subscriptions.remove(&topic);
                context.change();
            }
        }))
    }

    /// Counts of a subscribed topic; `None` if it is not subscribed.
    ///
    /// # Errors
    /// [`RosError::Name`].
    pub fn subscription_counts(
        &self,
        topic: &str,
    ) -> Result<Option<RosSubscriptionCounts>, RosError> {
        let found = self.topic_subscription(topic)?;
        Ok(found.map(|it| it.counts()))
    }

    /// What counts the messages of a subscribed topic that cannot be decoded; `None` if it is not subscribed.
    ///
    /// # Errors
    /// [`RosError::Name`].
    pub fn unreadable_messages(&self, topic: &str) -> Result<Option<UnreadableMessages>, RosError> {
        let found = self.topic_subscription(topic)?;
        Ok(found.map(UnreadableMessages))
    }

    /// The subscription of a topic; `None` if it is not subscribed.
    pub(crate) fn topic_subscription(
        &self,
        topic: &str,
    ) -> Result<Option<Arc<TopicSubscription>>, RosError> {
        let topic = self.context.name.resolve(topic)?;
        let subscriptions = lock(&self.tables.subscriptions);
        Ok(subscriptions.get(&topic).cloned())
    }

    /// Provides a service. At most `size` requests wait. A reply with a [`Refusal`] is an error at the caller, with code and
    /// detail, or with the detail alone if the code is empty.
    ///
    /// # Errors
    /// [`RosError::Name`], [`RosError::Served`] if the node provides it already.
    pub fn serve(
        &self,
        service: &str,
        of: ServiceType,
        size: usize,
        notifier: Arc<Notifier>,
    ) -> Result<ServedAddress, RosError> {
        let name = self.context.name.resolve(service)?;
        let mut services = lock(&self.tables.services);
        if let Some(provided) = services.get(&name) {
            return Err(RosError::Served {
                service: name.to_string(),
                declared: provided.of.name.to_string(),
                again: of.name.to_string(),
            });
        }
        let queue = AddressQueue::new(size, notifier);
        let provided = ProvidedService {
            name: name.clone(),
            of,
            queue: Arc::clone(&queue),
            unreadable: Default::default(),
        };
        services.insert(name.clone(), Arc::new(provided));
        drop(services);
        self.changed();
        let (tables, context) = (Arc::clone(&self.tables), Arc::clone(&self.context));
        Ok(ServedAddress::new(queue, move || {
            lock(&tables.services).remove(&name);
            context.change();
        }))
    }

    /// Creates a client of a service. A persistent client keeps its connection.
    ///
    /// # Errors
    /// [`RosError::Name`]. A service without a provider is not an error.
    pub fn service_client(
        &self,
        service: &str,
        of: ServiceType,
        is_persistent: bool,
    ) -> Result<RosServiceClient, RosError> {
        let name = self.context.name.resolve(service)?;
        let (context, tasks) = (Arc::clone(&self.context), self.tasks.clone());
        Ok(RosServiceClient::new(
            context,
            tasks,
            name,
            of,
            is_persistent,
        ))
    }

    /// Reads a parameter; the call ends with its value, or is refused with the code `unset`.
    ///
    /// # Errors
    /// [`RosError::Name`].
    pub fn parameter(
        &self,
        name: &str,
        timeout: Duration,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, RosError> {
        let name = self.context.name.resolve(name)?;
        let parameters = vec![XmlRpcValue::text(name.as_str())];
        let unset = |reason| (UNSET, reason);
        Ok(self.ask_master("getParam", parameters, unset, timeout, notifier))
    }

    /// Sets a parameter. The call is refused if the parameter server cannot hold the datum. Observers of this node that follow the
    /// parameter do not receive the value.
    ///
    /// # Errors
    /// [`RosError::Name`].
    pub fn set_parameter(
        &self,
        name: &str,
        value: &Datum,
        timeout: Duration,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, RosError> {
        let name = self.context.name.resolve(name)?;
        Ok(match XmlRpcValue::of_datum(value) {
            Ok(value) => {
                if let Some(followed) = entry(&self.tables.parameters, name.as_str()) {
                    followed.note(value.clone());
                }
                let failed = |reason| (FAILED, reason);
                let parameters = vec![XmlRpcValue::text(name.as_str()), value];
                self.ask_master("setParam", parameters, failed, timeout, notifier)
            }
            Err(error) => {
                let (pending, call) = self.pending(timeout, notifier);
                call.reply(Err(Refusal {
                    code: UNREADABLE.to_owned(),
                    detail: error.to_string(),
                }));
                pending
            }
        })
    }

    /// Has a parameter deleted when the node ends, for one that nobody else needs. Does nothing if the master is down then.
    ///
    /// # Errors
    /// [`RosError::Name`].
    pub fn delete_parameter_at_end(&self, name: &str) -> Result<(), RosError> {
        let name = self.context.name.resolve(name)?;
        lock(&self.tables.temporary).insert(name);
        Ok(())
    }

    /// Follows a parameter and the parameters in it: the queue receives its value once the master has told it, and again after
    /// every change; an absent value if the parameter is not set.
    ///
    /// # Errors
    /// [`RosError::Name`].
    pub fn follow_parameter(
        &self,
        name: &str,
        queue: QueuePolicy,
        notifier: Arc<Notifier>,
    ) -> Result<Subscription, RosError> {
        let name = self.context.name.resolve(name)?;
        let sender = SubscriptionSender::new(queue, notifier);
        let mut parameters = lock(&self.tables.parameters);
        let entry = parameters.entry(name.clone());
        let new = || Arc::new(FollowedParameter::new(name.clone()));
        let followed = Arc::clone(entry.or_insert_with(new));
        followed.add(sender.clone());
        drop(parameters);
        self.changed();
        let (tables, context, observer) = (
            Arc::clone(&self.tables),
            Arc::clone(&self.context),
            sender.clone(),
        );
        Ok(sender.subscription(move || {
            let mut parameters = lock(&tables.parameters);
            if followed.remove(&observer) {
                parameters.remove(&name);
                context.change();
            }
        }))
    }

    /// Reads what the master knows. Waits for its answer, so it is not for cycles.
    ///
    /// # Errors
    /// [`RosError::Master`].
    pub fn graph(&self) -> Result<RosGraph, RosError> {
        let context = &self.context;
        let read = async {
            let state = context.master("getSystemState", &[]).await?;
            let types = context.master("getTopicTypes", &[]).await?;
            let wrong = "getSystemState: the answer is not as the API of the master says";
            let graph = RosGraph::of(&state, &types);
            graph.ok_or_else(|| MasterAnswer::None(wrong.to_owned()))
        };
        let read = self.tasks.block_on(read);
        read.map_err(|answer| RosError::Master {
            master: context.settings.master.to_string(),
            reason: answer.reason(),
        })
    }

    fn changed(&self) {
        self.context.change();
    }

    fn pending(
        &self,
        timeout: Duration,
        notifier: Arc<Notifier>,
    ) -> (PendingCall, asmotion_bus::IncomingCall) {
        let origin = SenderId::new(self.context.name.shared(), 0);
        let request = Request::new(origin, Payload::of(Datum::Null), timeout);
        PendingCall::new(request, notifier)
    }

    fn ask_master(
        &self,
        method: &'static str,
        parameters: Vec<XmlRpcValue>,
        refused: fn(String) -> (&'static str, String),
        timeout: Duration,
        notifier: Arc<Notifier>,
    ) -> PendingCall {
        let (pending, call) = self.pending(timeout, notifier);
        let context = Arc::clone(&self.context);
        self.tasks.spawn(async move {
            let answer = context.master(method, &parameters);
            call_ended(call, answer, refused).await;
        });
        pending
    }
}

/// Ends a call with an answer of the master.
async fn call_ended(
    call: asmotion_bus::IncomingCall,
    answer: impl Future<Output = Result<XmlRpcValue, MasterAnswer>>,
    refused: fn(String) -> (&'static str, String),
) {
    let result = match timeout_at(call.deadline.into(), answer).await {
        Ok(Ok(value)) => Ok(Payload::Sample(Arc::new(value.to_datum()))),
        Ok(Err(MasterAnswer::Refused(reason))) => {
            let (code, detail) = refused(reason);
            let code = code.to_owned();
            Err(CallFailure::Refused(Refusal { code, detail }))
        }
        Ok(Err(MasterAnswer::None(_))) => Err(CallFailure::Unavailable),
        Err(_) => Err(CallFailure::Timeout),
    };
    call.complete(result);
}

impl Drop for RosNode {
    fn drop(&mut self) {
        self.context.end();
        if let Some(thread) = self.thread.take() {
            // ends without panicking: it runs only our own code
            let _ = thread.join();
        }
    }
}

impl std::fmt::Debug for RosNode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "node `{}`, {}", self.context.name, self.health().link)
    }
}

impl RosPublisher {
    /// Publishes a message. Never blocks.
    ///
    /// # Errors
    /// The datum does not follow the type of the topic.
    pub fn publish(&self, message: &Datum) -> Result<(), DatumError> {
        let frame = ros1::encode_frame(message, &self.publication.of.schema)?;
        self.publication.send(Arc::new(frame));
        Ok(())
    }

    /// Waits until the messages published so far have been written to the connections of present subscribers, at most until this
    /// time. Returns whether they have.
    pub fn drain(&self, until: Instant) -> bool {
        while !self.publication.is_idle() {
            if Instant::now() >= until {
                return false;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        true
    }

    /// The counts of its messages.
    pub fn counts(&self) -> RosPublisherCounts {
        self.publication.counts()
    }

    /// Messages dropped so far: the field of [`counts`](Self::counts), without a list of the subscribers.
    pub fn dropped(&self) -> u64 {
        self.publication.dropped()
    }
}

impl Drop for RosPublisher {
    fn drop(&mut self) {
        lock(&self.tables.publications).remove(&self.publication.topic);
        self.publication.close();
        self.context.change();
    }
}

impl std::fmt::Debug for RosPublisher {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "publisher of `{}`", self.publication.topic)
    }
}
