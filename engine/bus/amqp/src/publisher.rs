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
use crate::outbox::{
    EncodedMessage, MessageHeader, NextToSend, OutgoingMessage, PublisherOutbox, REPORT_INTERVAL,
};
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
    is_closed: AtomicBool,
}

impl PublisherShared {
    pub(crate) fn new(sending: PublishOptions) -> Arc<Self> {
        Arc::new(Self {
            outbox: Mutex::new(PublisherOutbox::new(sending)),
            wake: Notify::new(),
            is_closed: AtomicBool::new(false),
        })
    }

    fn outbox(&self) -> MutexGuard<'_, PublisherOutbox> {
        self.outbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends the last message again, if it is retained.
    pub(crate) fn republish_retained(&self, open: bool) {
        if self.outbox().push_retained(open) {
            self.wake.notify_one();
        }
    }

    /// Returns how many messages are still queued or in flight.
    pub(crate) fn pending(&self) -> u64 {
        self.outbox().counts.pending()
    }
}

/// Handle of a publisher, used in the component's thread.
pub(crate) struct AmqpPublisher {
    pub link: Arc<Link>,
    pub shared: Arc<PublisherShared>,
    pub spans: SpanGenerator,
    pub sequence: u64,
}

impl Publisher for AmqpPublisher {
    fn publish_traced(
        &mut self,
        stamp: i64,
        payload: Payload,
        cause: Option<TraceContext>,
    ) -> Result<(), BusError> {
        self.sequence += 1;
        let item = OutgoingMessage {
            header: MessageHeader {
                sequence: self.sequence,
                stamp,
                published: std::time::Instant::now(),
                trace: self.spans.of(self.sequence, cause),
            },
            payload,
        };
        if !self.shared.outbox().push(item, self.link.is_open()) {
            let reason = match self.link.health().link {
                asmotion_bus::LinkState::Up => "the outbox is full".to_owned(),
                asmotion_bus::LinkState::Blocked { reason }
                | asmotion_bus::LinkState::Down { reason } => reason.to_string(),
            };
            return Err(BusError::Disconnected { reason });
        }
        self.shared.wake.notify_one();
        Ok(())
    }

    fn counts(&self) -> PublisherCounts {
        self.shared.outbox().counts
    }
}

impl Drop for AmqpPublisher {
    fn drop(&mut self) {
        self.shared.is_closed.store(true, Ordering::Release);
        self.shared.wake.notify_one();
    }
}

/// Task of a publisher, run on the bus thread.
pub(crate) struct PublisherTask {
    pub link: Arc<Link>,
    pub shared: Arc<PublisherShared>,
    pub key: String,
    pub author: MessageSource,
}

/// State of one channel.
struct PublisherSession {
    channel: Channel,
    events: UnboundedReceiver<BrokerEvent>,
    confirmed: bool,
    /// Delivery tag of the last publication. The broker counts from 1 on each channel, and so do we.
    tag: u64,
    /// The last tag that a barrier covers.
    confirmed_tag: u64,
    /// Time at which the messages after `confirmed_tag` need a barrier.
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
                () = self.link.wait_until_replaced(&pair) => Err(ChannelError::Lost),
                () = self.link.wait_until_closing() => break,
            };
            match end {
                Ok(()) => return,
                Err(
                    ChannelError::Closed { reason, .. } | ChannelError::QueueUnreachable { reason },
                ) => {
                    self.shared.outbox().connection_lost(true);
                    self.link.report_refusal(&self.key, reason);
                    sleep(REFUSED_REST).await;
                }
                Err(ChannelError::ExchangeMissing { reason }) => {
                    self.shared.outbox().connection_lost(false);
                    self.link.replace_after_deletion(&pair, &reason).await;
                }
                Err(ChannelError::Cancelled | ChannelError::Lost) => {
                    self.shared.outbox().connection_lost(false);
                    self.shared.outbox().close();
                    self.link.wait_after_error(&pair).await;
                }
            }
        }
        self.shared.outbox().discard_all();
    }

    /// Publishes on one channel until the handle has been dropped and everything has been delivered.
    async fn session(&self, pair: &ConnectionPair) -> Result<(), ChannelError> {
        let confirmed = self.shared.outbox().is_confirmed();
        let mut session = PublisherSession::open(pair, confirmed).await?;
        // as long as the broker keeps the queues of readers that are away
        session.probe_until += self.link.settings.timing.reply_retention;
        let mut state = self.link.state();
        loop {
            if state.borrow_and_update().open().is_some() {
                if session.retry_at.is_none() {
                    self.send(&mut session).await?;
                }
            } else {
                self.shared.outbox().close();
            }
            self.report_losses();
            if self.shared.is_closed.load(Ordering::Acquire) && self.shared.pending() == 0 {
                // the client closes the channel on drop
                return Ok(());
            }
            tokio::select! {
                word = session.events.recv() => self.handle(word, &mut session)?,
                end = pending_or(&mut session.barrier) => self.barrier_reached(end, &mut session)?,
                () = self.shared.wake.notified() => {}
                _ = state.changed() => {}
                () = sleep_until(session.barrier_due), if session.may_set_barrier() => {
                    session.set_barrier();
                }
                () = sleep(REPORT_INTERVAL), if self.shared.outbox().has_unreported_losses() => {}
                () = sleep_until(session.retry_at.unwrap_or(session.barrier_due)), if session.retry_at.is_some() => {
                    session.retry_at = None;
                }
            }
        }
    }

    /// Reports losses that the component has not learnt of.
    fn report_losses(&self) {
        let losses = self.shared.outbox().losses_to_report();
        if let Some(losses) = losses {
            let what = self.key.clone();
            self.link.report(BusNotice::Undelivered { what, losses });
        }
    }

    /// Sends messages until the window is full.
    async fn send(&self, session: &mut PublisherSession) -> Result<(), ChannelError> {
        loop {
            let next = self.shared.outbox().next();
            let written = match next {
                Some(NextToSend::Resend(written)) => written,
                Some(NextToSend::New(item)) => match self.write(&item) {
                    Ok(written) => written,
                    Err(reason) => {
                        self.shared.outbox().drop_unencodable();
                        let what = self.key.clone();
                        self.link.report(BusNotice::Unwritable { what, reason });
                        continue;
                    }
                },
                None => return Ok(()),
            };
            if !session.channel.is_open() {
                // the client would report success
                self.shared.outbox().push_back_unsent(written);
                return Err(session.why_closed());
            }
            let mut arguments = BasicPublishArguments::new(&self.link.settings.exchange, &self.key);
            arguments.mandatory(session.confirmed);
            if session.tag == session.confirmed_tag {
                session.barrier_due = Instant::now() + BARRIER_AFTER;
            }
            session.tag += 1;
            let written = self.shared.outbox().record_sent(session.tag, written);
            session
                .channel
                .basic_publish(
                    self.author.properties(&written.header),
                    written.bytes.to_vec(),
                    arguments,
                )
                .await
                .map_err(|_| channel::close_reason(&mut session.events))?;
            if session.may_set_barrier() && session.tag >= session.confirmed_tag + BARRIER {
                session.set_barrier();
            }
        }
    }

    fn write(&self, item: &OutgoingMessage) -> Result<EncodedMessage, String> {
        let bytes = item
            .payload
            .encode(self.author.codec, &self.author.schema)
            .map_err(|error| error.to_string())?;
        Ok(EncodedMessage {
            header: item.header,
            bytes,
        })
    }

    fn handle(
        &self,
        event: Option<BrokerEvent>,
        session: &mut PublisherSession,
    ) -> Result<(), ChannelError> {
        let mut outbox = self.shared.outbox();
        match event {
            Some(BrokerEvent::Ack { tag, multiple }) => {
                if outbox.is_probing() && Instant::now() >= session.probe_until {
                    outbox.stop_probing();
                }
                if !outbox.confirm(tag, multiple) {
                    session.retry_at = Some(Instant::now() + UNROUTED_REST);
                }
            }
            Some(BrokerEvent::Nack { tag, multiple }) => outbox.reject(tag, multiple),
            Some(BrokerEvent::Returned { .. }) => outbox.returned(),
            Some(BrokerEvent::Cancelled) => {}
            Some(BrokerEvent::Closed { code, reason }) => {
                return Err(ChannelError::closed(code, reason));
            }
            None => return Err(session.why_closed()),
        }
        Ok(())
    }

    /// Handles the reply to a barrier: all messages before it have arrived.
    fn barrier_reached(
        &self,
        result: AmqpResult<()>,
        session: &mut PublisherSession,
    ) -> Result<(), ChannelError> {
        session.barrier = None;
        result.map_err(|_| channel::close_reason(&mut session.events))?;
        let _ = self.shared.outbox().confirm(session.confirmed_tag, true);
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
            events: words,
            confirmed,
            tag: 0,
            confirmed_tag: 0,
            barrier_due: Instant::now(),
            barrier: None,
            probe_until: Instant::now(),
            retry_at: None,
        })
    }

    /// Returns whether there are messages whose delivery only a barrier can show.
    fn may_set_barrier(&self) -> bool {
        !self.confirmed && self.barrier.is_none() && self.tag > self.confirmed_tag
    }

    fn set_barrier(&mut self) {
        self.confirmed_tag = self.tag;
        self.barrier = Some(Box::pin(channel::barrier(self.channel.clone())));
    }

    fn why_closed(&mut self) -> ChannelError {
        channel::close_reason(&mut self.events)
    }
}

async fn pending_or<T>(future: &mut Option<Pin<Box<dyn Future<Output = T> + Send>>>) -> T {
    match future {
        Some(future) => future.await,
        None => std::future::pending().await,
    }
}
