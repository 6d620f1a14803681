//! The link to the broker: two connections, watched, and made again when they break.
//!
//! Publishers and consumers have a connection each: a broker short of memory stops reading from those who publish, and
//! what comes in shall come in all the same.

use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

use amqprs::callbacks::ConnectionCallback;
use amqprs::channel::{
    BasicPublishArguments, Channel, ConfirmSelectArguments, ExchangeDeclareArguments,
};
use amqprs::connection::{Connection, OpenConnectionArguments};
use amqprs::{BasicProperties, Close};
use async_trait::async_trait;
use bus::{Bell, Health};
use tokio::runtime::Handle;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::sync::watch;
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

use crate::backoff::Backoff;
use crate::channel::{self, Ends, Word};
use crate::knock::knock;
use crate::{Notice, Settings};

/// How long a goodbye may take.
const GOODBYE: Duration = Duration::from_secs(1);

/// The two connections of one life of the link.
pub(crate) struct Pair {
    pub publishers: Connection,
    pub consumers: Connection,
}

/// What tasks see of the link.
#[derive(Clone, Default)]
pub(crate) struct State {
    /// The connections, if there are any.
    pub pair: Option<Arc<Pair>>,
    /// Whether the broker takes nothing.
    pub blocked: bool,
    /// Whether the bus is being closed.
    pub closing: bool,
}

impl State {
    /// The connections, if messages go out.
    pub(crate) fn open(&self) -> Option<&Arc<Pair>> {
        self.pair.as_ref().filter(|_| !self.blocked)
    }
}

/// The link, for everybody in the bus.
pub(crate) struct Link {
    pub settings: Settings,
    state: watch::Sender<State>,
    health: Mutex<Health>,
    watchers: Mutex<Vec<Weak<Bell>>>,
    /// How many tasks use the link.
    crew: watch::Sender<usize>,
}

/// A task that uses the link, until it ends.
struct Shift(Arc<Link>);

impl Shift {
    fn new(link: &Arc<Link>) -> Self {
        link.crew.send_modify(|crew| *crew += 1);
        Self(Arc::clone(link))
    }
}

impl Drop for Shift {
    fn drop(&mut self) {
        self.0.crew.send_modify(|crew| *crew -= 1);
    }
}

impl Link {
    pub(crate) fn new(settings: Settings) -> Self {
        let reason = "not connected yet".into();
        Self {
            settings,
            state: watch::Sender::new(State::default()),
            health: Mutex::new(Health::now(bus::Link::Down { reason })),
            watchers: Mutex::default(),
            crew: watch::Sender::new(0),
        }
    }

    /// Runs a task that uses the link; a bus that is closed waits for it.
    pub(crate) fn spawn(
        self: &Arc<Self>,
        tasks: &Handle,
        work: impl Future<Output = ()> + Send + 'static,
    ) {
        let shift = Shift::new(self);
        tasks.spawn(async move {
            work.await;
            drop(shift);
        });
    }

    pub(crate) fn health(&self) -> Health {
        let health = self.health.lock().unwrap_or_else(PoisonError::into_inner);
        health.clone()
    }

    pub(crate) fn watch(&self, bell: &Arc<Bell>) {
        let mut watchers = self.watchers.lock().unwrap_or_else(PoisonError::into_inner);
        watchers.retain(|bell| bell.strong_count() > 0);
        watchers.push(Arc::downgrade(bell));
    }

    /// The state as it is, and as it changes.
    pub(crate) fn state(&self) -> watch::Receiver<State> {
        self.state.subscribe()
    }

    pub(crate) fn is_open(&self) -> bool {
        self.state.borrow().open().is_some()
    }

    pub(crate) fn is_connected(&self) -> bool {
        self.state.borrow().pair.is_some()
    }

    pub(crate) fn note(&self, notice: Notice) {
        (self.settings.notices)(&notice);
    }

    /// Ends the supervisor and everybody who uses the link.
    pub(crate) fn close(&self) {
        self.state.send_modify(|state| state.closing = true);
    }

    /// The next pair of connections. `None` if the bus is closed.
    pub(crate) async fn pair(&self) -> Option<Arc<Pair>> {
        let mut state = self.state();
        let state = state
            .wait_for(|state| state.closing || state.pair.is_some())
            .await
            .ok()?;
        state.pair.clone().filter(|_| !state.closing)
    }

    /// Waits until a pair is of no use any more.
    pub(crate) async fn gone(&self, pair: &Arc<Pair>) {
        let mut state = self.state();
        let same = |current: &Arc<Pair>| Arc::ptr_eq(current, pair);
        // The sender is ours.
        let _ = state
            .wait_for(|state| !state.pair.as_ref().is_some_and(same))
            .await;
    }

    /// Waits until the bus is being closed.
    pub(crate) async fn closing(&self) {
        let mut state = self.state();
        // The sender is ours.
        let _ = state.wait_for(|state| state.closing).await;
    }

    /// Says how it is, to those who ask and to those who listen.
    fn announce(&self, link: bus::Link) {
        let mut health = self.health.lock().unwrap_or_else(PoisonError::into_inner);
        if health.link == link {
            return;
        }
        *health = Health::now(link);
        drop(health);
        let watchers = self.watchers.lock().unwrap_or_else(PoisonError::into_inner);
        for bell in watchers.iter().filter_map(Weak::upgrade) {
            bell.ring();
        }
    }

    fn set_blocked(&self, blocked: bool) {
        let change = |state: &mut State| {
            let changed = state.blocked != blocked;
            state.blocked = blocked;
            changed
        };
        if self.state.send_if_modified(change) {
            self.note(if blocked {
                Notice::Blocked
            } else {
                Notice::Unblocked
            });
        }
    }
}

/// Connects, watches, connects again, until the bus is closed.
pub(crate) async fn supervise(link: Arc<Link>) {
    let timing = link.settings.timing;
    let mut backoff = Backoff::new(timing.first_retry, timing.last_retry, link.settings.seed);
    loop {
        let life = async {
            let reason = match timeout(timing.connect, connect(&link.settings)).await {
                Ok(Ok((pair, closes))) => {
                    backoff.reset();
                    live(&link, pair, closes).await
                }
                Ok(Err(reason)) => reason,
                Err(_) => format!("no answer within {:?}", timing.connect),
            };
            link.announce(bus::Link::Down {
                reason: reason.as_str().into(),
            });
            link.note(Notice::Disconnected { reason });
            sleep(backoff.wait()).await;
        };
        tokio::select! {
            () = life => {}
            () = link.closing() => break,
        }
    }
    let mut crew = link.crew.subscribe();
    // Whoever has not said goodbye by then is not waited for.
    let _ = timeout(GOODBYE, crew.wait_for(|crew| *crew == 0)).await;
    let pair = link.state.send_replace(State {
        closing: true,
        ..State::default()
    });
    if let Some(pair) = pair.pair {
        hang_up(&pair).await;
    }
    let reason = "the bus is closed".into();
    link.announce(bus::Link::Down { reason });
}

/// One life of the connections; why it ended.
async fn live(link: &Link, pair: Pair, mut closes: UnboundedReceiver<String>) -> String {
    let pair = Arc::new(pair);
    link.state.send_modify(|state| {
        state.pair = Some(Arc::clone(&pair));
        state.blocked = false;
    });
    link.announce(bus::Link::Up);
    let broker = link.settings.place();
    link.note(Notice::Connected { broker });
    let reason = tokio::select! {
        biased;
        Some(reason) = closes.recv() => reason,
        reason = watch_over(link, &pair) => reason,
        _ = pair.publishers.listen_network_io_failure() => "the connection broke".to_owned(),
        _ = pair.consumers.listen_network_io_failure() => "the connection broke".to_owned(),
    };
    link.state.send_modify(|state| {
        state.pair = None;
        state.blocked = false;
    });
    tokio::spawn(async move { hang_up(&pair).await });
    reason
}

/// Says goodbye, to whom still listens.
async fn hang_up(pair: &Pair) {
    let both = async {
        // A connection that is gone needs no goodbye.
        let _ = pair.publishers.clone().close().await;
        let _ = pair.consumers.clone().close().await;
    };
    let _ = timeout(GOODBYE, both).await;
}

/// Knocks, opens both connections and declares the exchanges; or says why not.
async fn connect(settings: &Settings) -> Result<(Pair, UnboundedReceiver<String>), String> {
    knock(settings)
        .await
        .map_err(|refusal| refusal.to_string())?;
    let (ear, closes) = unbounded_channel();
    let pair = Pair {
        publishers: open(settings, "publishers", &ear)
            .await
            .map_err(|error| error.to_string())?,
        consumers: open(settings, "consumers", &ear)
            .await
            .map_err(|error| error.to_string())?,
    };
    for (exchange, kind) in [
        (&settings.exchange, "topic"),
        (&settings.services(), "direct"),
    ] {
        declare(&pair.consumers, exchange, kind)
            .await
            .map_err(|error| format!("exchange `{exchange}`: {error}"))?;
    }
    Ok((pair, closes))
}

async fn open(
    settings: &Settings,
    purpose: &str,
    ear: &UnboundedSender<String>,
) -> Ends<Connection> {
    let credentials = &settings.credentials;
    let mut arguments = OpenConnectionArguments::new(
        &settings.host,
        settings.port,
        credentials.user(),
        credentials.password(),
    );
    arguments
        .virtual_host(&settings.vhost)
        .connection_name(&format!("{} ({purpose})", settings.process))
        // At 1 the client would send them without a pause.
        .heartbeat(settings.timing.heartbeat.max(2));
    let connection = Connection::open(&arguments).await?;
    connection.register_callback(Ear(ear.clone())).await?;
    Ok(connection)
}

/// Declares an exchange, or finds it there if we may not.
async fn declare(connection: &Connection, exchange: &str, kind: &str) -> Ends<()> {
    let mut arguments = ExchangeDeclareArguments::new(exchange, kind);
    arguments.durable(true);
    let (channel, _words) = channel::open(connection).await?;
    if channel.exchange_declare(arguments.clone()).await.is_ok() {
        return channel.close().await;
    }
    arguments.passive(true);
    let (channel, _words) = channel::open(connection).await?;
    channel.exchange_declare(arguments).await?;
    channel.close().await
}

/// Hears why the broker closes a connection.
struct Ear(UnboundedSender<String>);

#[async_trait]
impl ConnectionCallback for Ear {
    async fn close(&mut self, _: &Connection, close: Close) -> Ends<()> {
        // Nobody listens to a connection that was given up.
        let _ = self
            .0
            .send(format!("closed by the broker: {}", close.reply_text()));
        Ok(())
    }

    async fn blocked(&mut self, _: &Connection, _: String) {}

    async fn unblocked(&mut self, _: &Connection) {}

    async fn secret_updated(&mut self, _: &Connection) {}
}

/// Feels the pulse of both connections; returns when one is dead.
///
/// The publishers' pulse is a publication that goes nowhere and is confirmed: a broker that takes nothing does not
/// confirm it. The consumers' is a question.
async fn watch_over(link: &Link, pair: &Pair) -> String {
    let timing = link.settings.timing;
    let (mut publishing, mut consuming) = match (
        Publishing::open(link, pair).await,
        channel::open(&pair.consumers).await,
    ) {
        (Ok(publishing), Ok((channel, _))) => (publishing, Asking::new(channel)),
        (Err(error), _) | (_, Err(error)) => return error.to_string(),
    };
    let mut ticks = interval(timing.pulse);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            _ = ticks.tick() => {
                publishing.beat().await;
                consuming.beat();
            }
            () = publishing.listen() => {}
            () = consuming.listen() => {}
        }
        let silence = consuming.silence();
        if silence > timing.dead {
            return format!("the broker is silent for {:?}", timing.dead);
        }
        let health = if silence > timing.silent {
            let reason = "the broker does not answer".into();
            bus::Link::Down { reason }
        } else if publishing.silence() > timing.silent {
            let reason = "the broker takes no messages: it is short of memory or disk".into();
            bus::Link::Blocked { reason }
        } else {
            bus::Link::Up
        };
        link.set_blocked(health != bus::Link::Up);
        link.announce(health);
    }
}

/// The publishers' pulse.
struct Publishing {
    channel: Channel,
    words: UnboundedReceiver<Word>,
    exchange: String,
    /// Since when the last beat waits for its echo.
    waiting: Option<Instant>,
    /// Without permission to publish there is no pulse.
    possible: bool,
}

impl Publishing {
    async fn open(link: &Link, pair: &Pair) -> Ends<Self> {
        let (channel, words) = channel::open(&pair.publishers).await?;
        channel
            .confirm_select(ConfirmSelectArguments::new(false))
            .await?;
        Ok(Self {
            channel,
            words,
            exchange: link.settings.services(),
            waiting: None,
            possible: true,
        })
    }

    async fn beat(&mut self) {
        if self.waiting.is_some() || !self.possible {
            return;
        }
        // Nothing is bound to the empty key.
        let arguments = BasicPublishArguments::new(&self.exchange, "");
        let publication =
            (self.channel).basic_publish(BasicProperties::default(), Vec::new(), arguments);
        if publication.await.is_ok() {
            self.waiting = Some(Instant::now());
        }
    }

    async fn listen(&mut self) {
        match self.words.recv().await {
            Some(Word::Ack { .. } | Word::Nack { .. }) => self.waiting = None,
            Some(Word::Closed { .. }) => {
                self.possible = false;
                self.waiting = None;
            }
            Some(Word::Returned { .. } | Word::Cancelled) => {}
            None => std::future::pending().await,
        }
    }

    fn silence(&self) -> Duration {
        self.waiting.map_or(Duration::ZERO, |since| since.elapsed())
    }
}

/// The consumers' pulse.
struct Asking {
    channel: Channel,
    /// Since when the last question waits for its answer.
    waiting: Option<Instant>,
    answers: UnboundedReceiver<()>,
    answered: UnboundedSender<()>,
}

impl Asking {
    fn new(channel: Channel) -> Self {
        let (answered, answers) = unbounded_channel();
        Self {
            channel,
            waiting: None,
            answers,
            answered,
        }
    }

    fn beat(&mut self) {
        if self.waiting.is_some() {
            return;
        }
        self.waiting = Some(Instant::now());
        let (channel, answered) = (self.channel.clone(), self.answered.clone());
        tokio::spawn(async move {
            // A question that fails is one without answer.
            if channel::barrier(channel).await.is_ok() {
                let _ = answered.send(());
            }
        });
    }

    async fn listen(&mut self) {
        if self.answers.recv().await.is_some() {
            self.waiting = None;
        }
    }

    fn silence(&self) -> Duration {
        self.waiting.map_or(Duration::ZERO, |since| since.elapsed())
    }
}
