//! A publisher: its handle in the component's thread, and its task, which owns a channel.
//!
//! Delivery is detected in one of two ways. With confirms, the broker acknowledges each message. Without them, the task
//! occasionally sets a barrier: a request on the same channel, whose reply proves that all messages before it were
//! read. In both cases the messages in flight are limited to the outbox's window.

use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use amqprs::channel::{BasicPublishArguments, Channel};
use asmotion_bus::{
    BusError, Payload, PublishOptions, Publisher, PublisherCounts, SpanGenerator, TraceContext,
};
use tokio::sync::Notify;
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::time::{Instant, sleep, sleep_until};

use crate::channel::{self, AmqpResult, BrokerEvent, ChannelError};
use crate::link::{ConnectionPair, Link};
use crate::notice::BusNotice;
use crate::outbox::{EncodedMessage, NextToSend, OutgoingMessage, PublisherOutbox};
use crate::wire::MessageSource;

/// Number of unacknowledged messages after which a barrier is set.
const BARRIER: u64 = 256;
/// Time after which a barrier is set even for fewer messages.
const BARRIER_AFTER: Duration = Duration::from_millis(250);
/// Pause after the broker refused a channel.
const REFUSED_REST: Duration = Duration::from_millis(200);
/// Pause before a message is sent again that no queue received.
const UNROUTED_REST: Duration = Duration::from_millis(50);

/// State shared by a publisher's handle and its task.
pub(crate) struct PublisherShared {
    outbox: Mutex<PublisherOutbox>,
    /// Notified when there is a message to send, or the handle is dropped.
    wake: Notify,
    /// Set when the handle is dropped; the task ends once everything is delivered.
    left: AtomicBool,
}

impl PublisherShared {
    pub(crate) fn new(sending: PublishOptions) -> Arc<Self> {
        Arc::new(Self {
            outbox: Mutex::new(PublisherOutbox::new(sending)),
            wake: Notify::new(),
            left: AtomicBool::new(false),
        })
    }

    fn outbox(&self) -> MutexGuard<'_, PublisherOutbox> {
        self.outbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends the last message again, if it is retained.
    pub(crate) fn repeat(&self, open: bool) {
        if self.outbox().repeat(open) {
            self.wake.notify_one();
        }
    }

    /// Returns how many messages are still queued or in flight.
    pub(crate) fn open(&self) -> u64 {
        self.outbox().sent.open()
    }
}

/// Handle of a publisher, used in the component's thread.
pub(crate) struct AmqpPublisher {
    pub link: Arc<Link>,
    pub lane: Arc<PublisherShared>,
    pub spans: SpanGenerator,
    pub sequence: u64,
}

impl Publisher for AmqpPublisher {
    fn publish_within(
        &mut self,
        stamp: i64,
        payload: Payload,
        cause: Option<TraceContext>,
    ) -> Result<(), BusError> {
        self.sequence += 1;
        let item = OutgoingMessage {
            sequence: self.sequence,
            stamp,
            payload,
            trace: self.spans.of(self.sequence, cause),
        };
        if !self.lane.outbox().put(item, self.link.is_open()) {
            let reason = match self.link.health().link {
                asmotion_bus::LinkState::Up => "the outbox is full".to_owned(),
                asmotion_bus::LinkState::Blocked { reason }
                | asmotion_bus::LinkState::Down { reason } => reason.to_string(),
            };
            return Err(BusError::Disconnected { reason });
        }
        self.lane.wake.notify_one();
        Ok(())
    }

    fn sent(&self) -> PublisherCounts {
        self.lane.outbox().sent
    }
}

impl Drop for AmqpPublisher {
    fn drop(&mut self) {
        self.lane.left.store(true, Ordering::Release);
        self.lane.wake.notify_one();
    }
}

/// Task of a publisher, run on the bus thread.
pub(crate) struct PublisherTask {
    pub link: Arc<Link>,
    pub lane: Arc<PublisherShared>,
    pub key: String,
    pub author: MessageSource,
}

/// State of one channel.
struct PublisherSession {
    channel: Channel,
    words: UnboundedReceiver<BrokerEvent>,
    confirmed: bool,
    /// Delivery tag of the last publication. The broker counts from 1 on each channel, and so do we.
    tag: u64,
    /// The last tag that a barrier covers.
    covered: u64,
    /// Time at which the messages after `covered` need a barrier.
    barrier_due: Instant,
    barrier: Option<Pin<Box<dyn Future<Output = AmqpResult<()>> + Send>>>,
    /// Time until which a publisher whose readers are not back holds its messages.
    probe_until: Instant,
    /// Time at which a message that no queue received is sent again.
    retry_at: Option<Instant>,
}

impl PublisherTask {
    pub(crate) async fn run(self) {
        while let Some(pair) = self.link.pair().await {
            let end = tokio::select! {
                end = self.session(&pair) => end,
                () = self.link.replaced(&pair) => Err(ChannelError::Lost),
                () = self.link.closing() => break,
            };
            match end {
                Ok(()) => return,
                Err(ChannelError::Closed { reason, .. }) => {
                    self.lane.outbox().broke(true);
                    self.link.refused(&self.key, reason);
                    sleep(REFUSED_REST).await;
                }
                Err(ChannelError::Cancelled | ChannelError::Lost) => {
                    self.lane.outbox().broke(false);
                    self.lane.outbox().close();
                    self.link.rest(&pair).await;
                }
            }
        }
        self.lane.outbox().give_up();
    }

    /// Publishes on one channel until the handle has been dropped and everything has been delivered.
    async fn session(&self, pair: &ConnectionPair) -> Result<(), ChannelError> {
        let confirmed = self.lane.outbox().is_confirmed();
        let mut session = PublisherSession::open(pair, confirmed).await?;
        // as long as the broker keeps the queues of readers that are away
        session.probe_until += self.link.settings.timing.remembered;
        let mut state = self.link.state();
        loop {
            if state.borrow_and_update().open().is_some() {
                if session.retry_at.is_none() {
                    self.send(&mut session).await?;
                }
            } else {
                self.lane.outbox().close();
            }
            if self.lane.left.load(Ordering::Acquire) && self.lane.open() == 0 {
                // the client closes the channel on drop
                return Ok(());
            }
            tokio::select! {
                word = session.words.recv() => self.handle(word, &mut session)?,
                end = pending_or(&mut session.barrier) => self.pass(end, &mut session)?,
                () = self.lane.wake.notified() => {}
                _ = state.changed() => {}
                () = sleep_until(session.barrier_due), if session.may_set_barrier() => {
                    session.set_barrier();
                }
                () = sleep_until(session.retry_at.unwrap_or(session.barrier_due)), if session.retry_at.is_some() => {
                    session.retry_at = None;
                }
            }
        }
    }

    /// Sends messages until the window is full.
    async fn send(&self, session: &mut PublisherSession) -> Result<(), ChannelError> {
        loop {
            let next = self.lane.outbox().next();
            let written = match next {
                Some(NextToSend::Again(written)) => written,
                Some(NextToSend::Fresh(item)) => match self.write(&item) {
                    Ok(written) => written,
                    Err(reason) => {
                        self.lane.outbox().unwritable();
                        let what = self.key.clone();
                        self.link.note(BusNotice::Unwritable { what, reason });
                        continue;
                    }
                },
                None => return Ok(()),
            };
            if !session.channel.is_open() {
                // the client would report success
                self.lane.outbox().stayed(written);
                return Err(session.why_closed());
            }
            let mut arguments = BasicPublishArguments::new(&self.link.settings.exchange, &self.key);
            arguments.mandatory(session.confirmed);
            if session.tag == session.covered {
                session.barrier_due = Instant::now() + BARRIER_AFTER;
            }
            session.tag += 1;
            let written = self.lane.outbox().went(session.tag, written);
            session
                .channel
                .basic_publish(*written.properties, written.bytes.to_vec(), arguments)
                .await
                .map_err(|_| channel::why(&mut session.words))?;
            if session.may_set_barrier() && session.tag >= session.covered + BARRIER {
                session.set_barrier();
            }
        }
    }

    fn write(&self, item: &OutgoingMessage) -> Result<EncodedMessage, String> {
        let bytes = item
            .payload
            .encode(self.author.codec, &self.author.schema)
            .map_err(|error| error.to_string())?;
        let properties = self
            .author
            .properties(item.sequence, item.stamp, item.trace);
        let properties = Box::new(properties);
        Ok(EncodedMessage { properties, bytes })
    }

    fn handle(
        &self,
        word: Option<BrokerEvent>,
        session: &mut PublisherSession,
    ) -> Result<(), ChannelError> {
        let mut outbox = self.lane.outbox();
        match word {
            Some(BrokerEvent::Ack { tag, multiple }) => {
                if outbox.is_probing() && Instant::now() >= session.probe_until {
                    outbox.stop_probing();
                }
                if !outbox.arrived(tag, multiple) {
                    session.retry_at = Some(Instant::now() + UNROUTED_REST);
                }
            }
            Some(BrokerEvent::Nack { tag, multiple }) => outbox.refused(tag, multiple),
            Some(BrokerEvent::Returned { .. }) => outbox.returned(),
            Some(BrokerEvent::Cancelled) => {}
            Some(BrokerEvent::Closed { code, reason }) => {
                return Err(ChannelError::Closed { code, reason });
            }
            None => return Err(session.why_closed()),
        }
        Ok(())
    }

    /// Handles the reply to a barrier: all messages before it have arrived.
    fn pass(
        &self,
        end: AmqpResult<()>,
        session: &mut PublisherSession,
    ) -> Result<(), ChannelError> {
        session.barrier = None;
        end.map_err(|_| channel::why(&mut session.words))?;
        let _ = self.lane.outbox().arrived(session.covered, true);
        Ok(())
    }
}

impl PublisherSession {
    async fn open(pair: &ConnectionPair, confirmed: bool) -> Result<Self, ChannelError> {
        let lost = |_| ChannelError::Lost;
        let (channel, words) = channel::open(&pair.publishers).await.map_err(lost)?;
        if confirmed {
            channel::confirm(&channel).await.map_err(lost)?;
        }
        Ok(Self {
            channel,
            words,
            confirmed,
            tag: 0,
            covered: 0,
            barrier_due: Instant::now(),
            barrier: None,
            probe_until: Instant::now(),
            retry_at: None,
        })
    }

    /// Returns whether there are messages whose delivery only a barrier can show.
    fn may_set_barrier(&self) -> bool {
        !self.confirmed && self.barrier.is_none() && self.tag > self.covered
    }

    fn set_barrier(&mut self) {
        self.covered = self.tag;
        self.barrier = Some(Box::pin(channel::barrier(self.channel.clone())));
    }

    fn why_closed(&mut self) -> ChannelError {
        channel::why(&mut self.words)
    }
}

async fn pending_or<T>(future: &mut Option<Pin<Box<dyn Future<Output = T> + Send>>>) -> T {
    match future {
        Some(future) => future.await,
        None => std::future::pending().await,
    }
}
