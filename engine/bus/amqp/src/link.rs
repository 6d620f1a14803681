//! The link to the broker: its connections, its health, and the tasks that use it.
//!
//! Publishers and consumers have a connection each: a broker short of memory stops reading from connections that
//! publish, and incoming messages must not be affected.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

use amqprs::connection::Connection;
use asmotion_bus::{Health, Notifier};
use tokio::runtime::Handle;
use tokio::sync::watch;
use tokio::time::timeout;

use crate::channel;
use crate::notice::BusNotice;
use crate::settings::AmqpSettings;

/// Pause before a retry on a healthy link.
const REST: Duration = Duration::from_millis(500);
/// Time limit for an orderly close.
const GOODBYE: Duration = Duration::from_secs(1);
/// Limit on channels closed by the broker: the client has 2047 channel numbers, and never reuses such a number.
const REFUSALS: usize = 1000;
/// Number of consecutive short-lived connections, each to a responding broker, after which a waiting message is
/// suspected of crashing the client.
const POISON: usize = 8;

/// A pair of connections to the broker, opened and closed together.
pub(crate) struct ConnectionPair {
    pub publishers: Connection,
    pub consumers: Connection,
    /// The broker's answers on the consumers' connection.
    answers: watch::Sender<ProbeAnswers>,
}

/// The broker's answers to the probes of a consumers' connection.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ProbeAnswers {
    /// Time at which the last probe that the broker has answered was sent. The broker sent everything that arrives now after that
    /// time, but what arrived earlier may still be on its way through the client.
    pub last: Instant,
    /// Number of answers that came late: after a silence of the broker or the link, or after this process was stopped.
    pub silences: u64,
    /// Time at which the probe was sent that was the last answered one before the last silence.
    pub before_silence: Instant,
}

/// State of the link as its tasks see it.
#[derive(Clone, Default)]
pub(crate) struct LinkStatus {
    /// The current connections; `None` while disconnected.
    pub pair: Option<Arc<ConnectionPair>>,
    /// The broker accepts no messages.
    pub blocked: bool,
    /// The bus is closing.
    pub closing: bool,
}

impl LinkStatus {
    /// The connections, if messages can be published on them.
    pub(crate) fn open(&self) -> Option<&Arc<ConnectionPair>> {
        self.pair.as_ref().filter(|_| !self.blocked)
    }
}

/// The link, shared by the bus and all its tasks.
pub(crate) struct Link {
    pub settings: AmqpSettings,
    state: watch::Sender<LinkStatus>,
    health: Mutex<Health>,
    watchers: Mutex<Vec<Weak<Notifier>>>,
    /// Number of tasks that use the link.
    task_count: watch::Sender<usize>,
    /// Number of channels that the broker has closed on the current connections.
    refusals: AtomicUsize,
    /// Reason for which the current connections have to be replaced although they work.
    replacement: watch::Sender<Option<String>>,
    /// Number of consecutive connections that failed while reading shortly after they were opened.
    short_connections: AtomicUsize,
}

/// Counts a task that uses the link, until it is dropped.
struct TaskGuard(Arc<Link>);

impl TaskGuard {
    fn new(link: &Arc<Link>) -> Self {
        link.task_count.send_modify(|crew| *crew += 1);
        Self(Arc::clone(link))
    }
}

impl Drop for TaskGuard {
    fn drop(&mut self) {
        self.0.task_count.send_modify(|crew| *crew -= 1);
    }
}

impl Link {
    pub(crate) fn new(settings: AmqpSettings) -> Self {
        let reason = "not connected yet".into();
        Self {
            settings,
            state: watch::Sender::new(LinkStatus::default()),
            health: Mutex::new(Health::now(asmotion_bus::LinkState::Down { reason })),
            watchers: Mutex::default(),
            task_count: watch::Sender::new(0),
            refusals: AtomicUsize::new(0),
            replacement: watch::Sender::new(None),
            short_connections: AtomicUsize::new(0),
        }
    }

    /// Spawns a task that uses the link; a closing bus waits for its end.
    pub(crate) fn spawn(
        self: &Arc<Self>,
        tasks: &Handle,
        work: impl Future<Output = ()> + Send + 'static,
    ) {
        let shift = TaskGuard::new(self);
        tasks.spawn(async move {
            work.await;
            drop(shift);
        });
    }

    pub(crate) fn health(&self) -> Health {
        let health = self.health.lock().unwrap_or_else(PoisonError::into_inner);
        health.clone()
    }

    pub(crate) fn notify_on_change(&self, notifier: &Arc<Notifier>) {
        let mut watchers = self.watchers.lock().unwrap_or_else(PoisonError::into_inner);
        watchers.retain(|notifier| notifier.strong_count() > 0);
        watchers.push(Arc::downgrade(notifier));
    }

    /// Subscribes to the state of the link.
    pub(crate) fn state(&self) -> watch::Receiver<LinkStatus> {
        self.state.subscribe()
    }

    pub(crate) fn is_open(&self) -> bool {
        self.state.borrow().open().is_some()
    }

    pub(crate) fn is_connected(&self) -> bool {
        self.state.borrow().pair.is_some()
    }

    pub(crate) fn report(&self, notice: BusNotice) {
        (self.settings.notices)(&notice);
    }

    /// Ends the supervisor and all tasks that use the link.
    pub(crate) fn close(&self) {
        self.state.send_modify(|state| state.closing = true);
    }

    /// Waits for connections. Returns `None` if the bus is closing.
    pub(crate) async fn pair(&self) -> Option<Arc<ConnectionPair>> {
        let mut state = self.state();
        let state = state
            .wait_for(|state| state.closing || state.pair.is_some())
            .await
            .ok()?;
        state.pair.clone().filter(|_| !state.closing)
    }

    /// Waits until this pair of connections is no longer the current one.
    pub(crate) async fn wait_until_replaced(&self, pair: &Arc<ConnectionPair>) {
        let mut state = self.state();
        let same = |current: &Arc<ConnectionPair>| Arc::ptr_eq(current, pair);
        // never fails: `self` owns the sender
        let _ = state
            .wait_for(|state| !state.pair.as_ref().is_some_and(same))
            .await;
    }

    /// Called after an error on a pair: waits until the supervisor has replaced the pair, or for a short pause if the
    /// pair is healthy.
    pub(crate) async fn wait_after_error(&self, pair: &Arc<ConnectionPair>) {
        let _ = timeout(REST, self.wait_until_replaced(pair)).await;
    }

    /// Waits until the bus is closing.
    pub(crate) async fn wait_until_closing(&self) {
        let mut state = self.state();
        // never fails: `self` owns the sender
        let _ = state.wait_for(|state| state.closing).await;
    }

    /// Reports that the broker has closed a channel, and counts it.
    pub(crate) fn report_refusal(&self, what: &str, reason: String) {
        let what = what.to_owned();
        self.report(BusNotice::Refused { what, reason });
        if self.refusals.fetch_add(1, Ordering::Relaxed) == REFUSALS {
            let reason = "the broker refused too many channels of the connection";
            self.replacement.send_replace(Some(reason.to_owned()));
        }
    }

    /// Called when an exchange turns out to be missing on a pair: requests new connections, which declare the exchanges
    /// and everything bound to them, and waits for them.
    pub(crate) async fn replace_after_deletion(&self, pair: &Arc<ConnectionPair>, reason: &str) {
        let is_current = |state: &LinkStatus| {
            let current = state.pair.as_ref();
            current.is_some_and(|current| Arc::ptr_eq(current, pair))
        };
        if is_current(&self.state.borrow()) {
            let reason = format!("an exchange was deleted: {reason}");
            self.replacement.send_replace(Some(reason));
        }
        self.wait_after_error(pair).await;
    }

    /// Records the end of a pair of connections: `failed_while_reading` if reading failed shortly after they were
    /// opened.
    pub(crate) fn record_end(&self, failed_while_reading: bool) {
        let count = self.short_connections.load(Ordering::Relaxed);
        let now = if failed_while_reading { count + 1 } else { 0 };
        self.short_connections.store(now, Ordering::Relaxed);
    }

    /// Returns whether a waiting message seems to crash the client each time it is delivered.
    pub(crate) fn is_poisoned(&self) -> bool {
        self.short_connections.load(Ordering::Relaxed) >= POISON
    }

    /// Waits until the current connections have to be replaced although they work. Returns the reason.
    pub(crate) async fn wait_for_replacement(&self) -> String {
        let mut replacement = self.replacement.subscribe();
        let reason = replacement.wait_for(Option::is_some).await;
        // never fails: `self` owns the sender
        reason
            .ok()
            .and_then(|reason| reason.clone())
            .unwrap_or_default()
    }

    /// Publishes new connections to the tasks.
    pub(crate) fn set_connections(&self, pair: &Arc<ConnectionPair>) {
        self.refusals.store(0, Ordering::Relaxed);
        self.replacement.send_replace(None);
        self.state.send_modify(|state| {
            state.pair = Some(Arc::clone(pair));
            state.blocked = false;
        });
        self.set_health(asmotion_bus::LinkState::Up);
        let broker = self.settings.location();
        self.report(BusNotice::Connected { broker });
    }

    /// Removes the current connections and returns them.
    pub(crate) fn take_connections(&self) -> Option<Arc<ConnectionPair>> {
        let mut connections = None;
        self.state.send_modify(|state| {
            connections = state.pair.take();
            state.blocked = false;
        });
        connections
    }

    /// Waits until no task uses the link, at most for [`GOODBYE`].
    pub(crate) async fn wait_until_unused(&self) {
        let mut task_count = self.task_count.subscribe();
        let _ = timeout(GOODBYE, task_count.wait_for(|crew| *crew == 0)).await;
    }

    /// Publishes a new state: sets the health and notifies the watchers.
    pub(crate) fn set_health(&self, link: asmotion_bus::LinkState) {
        let mut health = self.health.lock().unwrap_or_else(PoisonError::into_inner);
        if health.link == link {
            return;
        }
        *health = Health::now(link);
        drop(health);
        let watchers = self.watchers.lock().unwrap_or_else(PoisonError::into_inner);
        for notifier in watchers.iter().filter_map(Weak::upgrade) {
            notifier.notify();
        }
    }

    pub(crate) fn set_blocked(&self, blocked: bool) {
        let change = |state: &mut LinkStatus| {
            let changed = state.blocked != blocked;
            state.blocked = blocked;
            changed
        };
        if self.state.send_if_modified(change) {
            self.report(if blocked {
                BusNotice::Blocked
            } else {
                BusNotice::Unblocked
            });
        }
    }
}

impl ProbeAnswers {
    /// Nothing was on its way at this time.
    pub(crate) fn beginning_at(now: Instant) -> Self {
        Self {
            last: now,
            silences: 0,
            before_silence: now,
        }
    }

    /// Records that the broker has now answered a probe that was sent at `sent_at`. Returns whether that ends a silence.
    pub(crate) fn record(&mut self, sent_at: Instant, limit: Duration, now: Instant) -> bool {
        let is_late = now.saturating_duration_since(self.last) > limit;
        if is_late {
            self.silences += 1;
            self.before_silence = self.last;
        }
        self.last = sent_at;
        is_late
    }
}

impl ConnectionPair {
    /// A pair that has just been opened.
    pub(crate) fn new(publishers: Connection, consumers: Connection) -> Self {
        Self {
            publishers,
            consumers,
            answers: watch::Sender::new(ProbeAnswers::beginning_at(Instant::now())),
        }
    }

    /// The answers so far. A change is a silence that has ended.
    pub(crate) fn answers(&self) -> watch::Receiver<ProbeAnswers> {
        self.answers.subscribe()
    }

    /// Records that the broker has answered a probe that was sent at this time. The answer is late if the one before was to a probe
    /// sent longer than `limit` ago.
    pub(crate) fn record_answer(&self, sent_at: Instant, limit: Duration) {
        self.answers
            .send_if_modified(|answers| answers.record(sent_at, limit, Instant::now()));
    }

    /// Closes both connections, with a time limit in case the broker does not respond.
    pub(crate) async fn close(&self) {
        let (publishers, consumers) = (self.publishers.clone(), self.consumers.clone());
        let both = channel::run_to_completion(async move {
            publishers.close().await?;
            consumers.close().await
        });
        // fails or times out if the connection is gone already
        let _ = timeout(GOODBYE, both).await;
    }
}
