//! The synchronous interface of the bus, which delegates to tasks on a separate thread.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use asmotion_bus::{
    Bus, BusError, Health, Notifier, Pattern, PendingCall, PublishOptions, Publisher, QueuePolicy,
    Request, SenderId, ServedAddress, SpanGenerator, Subscription, SubscriptionSender,
};
use asmotion_datum::Schema;
use tokio::runtime::{Builder, Handle};
use tokio::sync::oneshot;

use crate::channel::ChannelError;
use crate::first_declaration::FirstDeclaration;
use crate::link::Link;
use crate::names::{RoutingNames, check_length};
use crate::publisher::{self, AmqpPublisher, PublisherShared};
use crate::service::Services;
use crate::settings::AmqpSettings;
use crate::wire::MessageSource;
use crate::{subscriber, supervisor};

/// One worker per direction; a single one lowers throughput by a third.
const WORKERS: usize = 2;

/// Distinguishes the buses of one process.
static LIVES: AtomicU64 = AtomicU64::new(1);

/// The bus over RabbitMQ. Dropping it sends pending messages for a while
/// ([`AmqpTiming::drain`](crate::AmqpTiming::drain)) and closes its connections.
pub struct AmqpBus {
    link: Arc<Link>,
    names: RoutingNames,
    /// Unique among all buses; distinguishes restarts of the same process.
    lifetime_id: String,
    /// Numbers publishers and subscriptions; the next one.
    number: AtomicU64,
    publishers: Mutex<Vec<Weak<PublisherShared>>>,
    /// Queues of this process that have the same names in every run.
    returning: Arc<Mutex<BTreeSet<String>>>,
    /// Set when another process uses such a queue.
    has_twin: Arc<AtomicBool>,
    services: Services,
    tasks: Handle,
    thread: Option<JoinHandle<()>>,
}

impl AmqpBus {
    /// Opens a bus, which begins to connect in the background and reconnects forever. [`health`](Bus::health) reports
    /// the state.
    ///
    /// # Errors
    /// [`BusError::InvalidName`] if a name of the process or the virtual host is too long for AMQP,
    /// [`BusError::Disconnected`] if the system refuses a thread. A broker that does not respond is not an error.
    pub fn open(settings: AmqpSettings) -> Result<Self, BusError> {
        for name in [&settings.process, &settings.services(), &settings.vhost] {
            // the longest name derived from it is a queue's, which is truncated
            check_length(name, &format!("{name} (publishers)"))?;
        }
        let disconnected = |error: std::io::Error| BusError::Disconnected {
            reason: error.to_string(),
        };
        let runtime = Builder::new_multi_thread()
            .worker_threads(WORKERS)
            .thread_name("amqp")
            .enable_all()
            .build()
            .map_err(disconnected)?;
        let life = new_lifetime_id();
        let (robot, process) = (settings.robot.clone(), settings.process.clone());
        let names = RoutingNames::new(robot, process, life.clone());
        let link = Arc::new(Link::new(settings));
        let tasks = runtime.handle().clone();
        let supervisor = supervisor::supervise(Arc::clone(&link));
        let thread = std::thread::Builder::new()
            .name("amqp".to_owned())
            .spawn(move || runtime.block_on(supervisor))
            .map_err(disconnected)?;
        let services = Services::new(
            Arc::clone(&link),
            names.clone(),
            life.clone(),
            tasks.clone(),
        );
        Ok(Self {
            link,
            names,
            lifetime_id: life,
            number: AtomicU64::new(1),
            publishers: Mutex::default(),
            returning: Arc::default(),
            has_twin: Arc::default(),
            services,
            tasks,
            thread: Some(thread),
        })
    }

    /// Connects, and returns once the bus is connected.
    ///
    /// # Errors
    /// [`BusError::Refused`] as soon as the broker rejects the credentials or the virtual host,
    /// [`BusError::Disconnected`] if no connection is up after `timeout`.
    pub fn connect(settings: AmqpSettings, timeout: Duration) -> Result<Self, BusError> {
        let bus = Self::open(settings)?;
        let notifier = Arc::new(Notifier::new());
        bus.notify_on_change(&notifier);
        let until = Instant::now() + timeout;
        loop {
            let reason = match bus.health().link {
                asmotion_bus::LinkState::Up => return Ok(bus),
                asmotion_bus::LinkState::Blocked { reason }
                | asmotion_bus::LinkState::Down { reason } => reason,
            };
            if let Some(reason) = reason.strip_prefix("refused: ") {
                let reason = reason.to_owned();
                return Err(BusError::Refused { reason });
            }
            let remaining = until.saturating_duration_since(Instant::now());
            if remaining.is_zero() {
                let reason = reason.to_string();
                return Err(BusError::Disconnected { reason });
            }
            notifier.wait(remaining);
        }
    }

    /// Reserves the queue name of a subscription that is the same in every run of the process.
    fn reserve_queue(
        &self,
        reader: &str,
        pattern: &Pattern,
        policy: QueuePolicy,
    ) -> Option<String> {
        if !self.link.settings.returns || policy == QueuePolicy::Latest {
            return None;
        }
        let mut reserved = lock(&self.returning);
        let mut names = (0..).map_while(|it| self.names.returning_queue(reader, pattern, it));
        names.find(|name| reserved.insert(name.clone()))
    }

    fn next_number(&self) -> u64 {
        self.number.fetch_add(1, Ordering::Relaxed)
    }
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Creates a bus id from time, process and a counter, so that no other bus has it.
fn new_lifetime_id() -> String {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let nanos = now.unwrap_or_default().as_nanos();
    let count = LIVES.fetch_add(1, Ordering::Relaxed);
    format!("{nanos:x}-{:x}-{count:x}", std::process::id())
}

impl Bus for AmqpBus {
    fn publisher(
        &self,
        topic: &str,
        origin: &SenderId,
        schema: &Schema,
        sending: PublishOptions,
    ) -> Result<Box<dyn Publisher>, BusError> {
        let key = self.names.key(topic)?;
        check_length(&schema.name, &schema.name)?;
        let publisher = PublisherShared::new(sending);
        let settings = &self.link.settings;
        let task = publisher::PublisherTask {
            link: Arc::clone(&self.link),
            shared: Arc::clone(&publisher),
            key,
            author: MessageSource {
                max_age: sending.max_age,
                source: Arc::clone(&origin.source),
                incarnation: origin.incarnation,
                stream: format!("{}.{}", self.lifetime_id, self.next_number()),
                clock: settings.clock.clone(),
                user: settings.credentials.user().to_owned(),
                persistent: sending.assurance == asmotion_bus::Assurance::Confirmed,
                codec: sending.codec,
                schema: schema.clone(),
            },
        };
        let mut publishers = lock(&self.publishers);
        publishers.retain(|lane| lane.strong_count() > 0);
        publishers.push(Arc::downgrade(&publisher));
        drop(publishers);
        self.link.spawn(&self.tasks, task.run());
        Ok(Box::new(AmqpPublisher {
            link: Arc::clone(&self.link),
            shared: publisher,
            spans: SpanGenerator::new(&origin.source, origin.incarnation, topic),
            sequence: 0,
        }))
    }

    /// Returns when the broker has declared the queue. Without a broker, returns at once, and the queue is declared
    /// after the connection is made.
    fn subscribe(
        &self,
        reader: &str,
        pattern: &Pattern,
        queue: QueuePolicy,
        notifier: Arc<Notifier>,
    ) -> Result<Subscription, BusError> {
        let key = self.names.binding(pattern)?;
        let sender = SubscriptionSender::new(queue, notifier);
        let (leaving, leave) = oneshot::channel();
        let (ready, told) = FirstDeclaration::new();
        let returning = self.reserve_queue(reader, pattern, queue);
        let (reserved, name) = (Arc::clone(&self.returning), returning.clone());
        let task = subscriber::SubscriberTask {
            link: Arc::clone(&self.link),
            names: self.names.clone(),
            pattern: pattern.clone(),
            key,
            queue: self.names.queue(reader, pattern, self.next_number()),
            returning,
            own_queue: None,
            has_twin: Arc::clone(&self.has_twin),
            policy: queue,
            sender: sender.clone(),
            stop: leave,
            ready,
        };
        let is_open = self.link.is_open();
        self.link.spawn(&self.tasks, task.run());
        if is_open
            && let Ok(Err(ChannelError::Closed { reason, .. })) =
                told.recv_timeout(self.link.settings.timing.connect)
        {
            return Err(BusError::Refused { reason });
        }
        Ok(sender.subscription(move || {
            // fails if the task has already ended
            let _ = leaving.send(());
            if let Some(name) = name {
                lock(&reserved).remove(&name);
            }
        }))
    }

    /// Returns when the broker has declared the request queue. Without a broker, returns at once, and the queue is
    /// declared after the connection is made.
    fn serve(
        &self,
        address: &str,
        size: usize,
        notifier: Arc<Notifier>,
    ) -> Result<ServedAddress, BusError> {
        self.services.serve(address, size, notifier)
    }

    fn call(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        self.services.call(address, request, notifier)
    }

    fn call_one_way(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        self.services.call_one_way(address, request, notifier)
    }

    fn republish_retained(&self) {
        let publishers = lock(&self.publishers);
        for publisher in publishers.iter().filter_map(Weak::upgrade) {
            publisher.republish_retained(self.link.is_open());
        }
    }

    fn health(&self) -> Health {
        self.link.health()
    }

    fn notify_on_change(&self, notifier: &Arc<Notifier>) {
        self.link.notify_on_change(notifier);
    }

    fn drain(&self, at_most: Duration) -> bool {
        let until = Instant::now() + at_most;
        loop {
            let publishers = lock(&self.publishers);
            let open = publishers
                .iter()
                .filter_map(Weak::upgrade)
                .any(|lane| lane.pending() > 0);
            drop(publishers);
            if !open {
                return true;
            }
            if Instant::now() >= until {
                return false;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

impl Drop for AmqpBus {
    fn drop(&mut self) {
        if self.link.is_open() {
            self.drain(self.link.settings.timing.drain);
        }
        self.link.close();
        if let Some(thread) = self.thread.take() {
            // ends without panicking: it runs only our own code
            let _ = thread.join();
        }
    }
}
