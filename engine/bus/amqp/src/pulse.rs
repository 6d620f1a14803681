//! Liveness probes: is the broker there, and does it accept messages?
//!
//! A client that does not announce the capability never receives `connection.blocked`, and heartbeats detect a dead
//! peer only after twice their interval. Each connection is therefore probed. The publishers' connection sends a
//! message that is routed nowhere and must be confirmed: a blocked broker does not confirm it. The consumers'
//! connection asks whether the exchanges still exist: readers learn nothing of the deletion of an exchange otherwise.

use std::time::{Duration, Instant};

use amqprs::BasicProperties;
use amqprs::channel::{BasicPublishArguments, Channel};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::time::{MissedTickBehavior, interval};

use crate::channel::{self, AmqpResult, BrokerEvent};
use crate::link::{ConnectionPair, Link};

/// Probes both connections until one fails. Returns the reason.
pub(crate) async fn watch_connections(link: &Link, pair: &ConnectionPair) -> String {
    let timing = link.settings.timing;
    let (mut publishing, mut consuming) = match (
        PublisherPulse::open(link, pair).await,
        channel::open(&pair.consumers).await,
    ) {
        (Ok(publishing), Ok((channel, events))) => {
            (publishing, ConsumerPulse::new(link, channel, events))
        }
        (Err(error), _) | (_, Err(error)) => return error.to_string(),
    };
    let mut ticks = interval(timing.pulse);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            _ = ticks.tick() => {
                publishing.send().await;
                consuming.send();
            }
            () = publishing.receive() => {}
            deleted = consuming.receive(pair, timing.unnoticed_wait()) => if let Some(reason) = deleted {
                return format!("an exchange was deleted: {reason}");
            },
        }
        let silence = consuming.silence();
        if silence > timing.dead_timeout {
            return format!("the broker is silent for {:?}", timing.dead_timeout);
        }
        let health = if silence > timing.silence_timeout {
            let reason = "the broker does not respond".into();
            asmotion_bus::LinkState::Down { reason }
        } else if publishing.silence() > timing.silence_timeout {
            let reason = "the broker accepts no messages: it is short of memory or disk".into();
            asmotion_bus::LinkState::Blocked { reason }
        } else {
            asmotion_bus::LinkState::Up
        };
        link.set_blocked(health != asmotion_bus::LinkState::Up);
        link.set_health(health);
    }
}

/// Probe of the publishers' connection.
struct PublisherPulse {
    channel: Channel,
    events: UnboundedReceiver<BrokerEvent>,
    exchange: String,
    /// Start of the wait for the last probe's confirmation.
    sent_at: Option<Instant>,
    /// `false` without permission to publish: then no probe is sent.
    is_supported: bool,
}

impl PublisherPulse {
    async fn open(link: &Link, pair: &ConnectionPair) -> AmqpResult<Self> {
        let (channel, words) = channel::open(&pair.publishers).await?;
        channel::confirm(&channel).await?;
        Ok(Self {
            channel,
            events: words,
            exchange: link.settings.services(),
            sent_at: None,
            is_supported: true,
        })
    }

    async fn send(&mut self) {
        if self.sent_at.is_some() || !self.is_supported {
            return;
        }
        // no queue is bound to the empty key
        let arguments = BasicPublishArguments::new(&self.exchange, "");
        let publication =
            self.channel
                .basic_publish(BasicProperties::default(), Vec::new(), arguments);
        if publication.await.is_ok() {
            self.sent_at = Some(Instant::now());
        }
    }

    async fn receive(&mut self) {
        match self.events.recv().await {
            Some(BrokerEvent::Ack { .. } | BrokerEvent::Nack { .. }) => self.sent_at = None,
            Some(BrokerEvent::Closed { .. }) => {
                self.is_supported = false;
                self.sent_at = None;
            }
            Some(BrokerEvent::Returned { .. } | BrokerEvent::Cancelled) => {}
            None => std::future::pending().await,
        }
    }

    fn silence(&self) -> Duration {
        self.sent_at.map_or(Duration::ZERO, |since| since.elapsed())
    }
}

/// Probe of the consumers' connection.
struct ConsumerPulse {
    channel: Channel,
    events: UnboundedReceiver<BrokerEvent>,
    /// The exchanges to ask for, the next one in front.
    exchanges: [String; 2],
    /// Start of the wait for the last probe's reply.
    sent_at: Option<Instant>,
    replies: UnboundedReceiver<()>,
    reply_sender: UnboundedSender<()>,
}

impl ConsumerPulse {
    fn new(link: &Link, channel: Channel, events: UnboundedReceiver<BrokerEvent>) -> Self {
        let (reply_sender, replies) = unbounded_channel();
        let settings = &link.settings;
        Self {
            channel,
            events,
            exchanges: [settings.exchange.clone(), settings.services()],
            sent_at: None,
            replies,
            reply_sender,
        }
    }

    fn send(&mut self) {
        if self.sent_at.is_some() {
            return;
        }
        self.sent_at = Some(Instant::now());
        let (channel, answered) = (self.channel.clone(), self.reply_sender.clone());
        let [exchange, _] = self.exchanges.clone();
        self.exchanges.reverse();
        tokio::spawn(async move {
            // a request that fails counts as one without a reply
            if channel::check_exchange(channel, &exchange).await.is_ok() {
                let _ = answered.send(());
            }
        });
    }

    /// Waits for a reply, which is late after `limit`. Returns the broker's reason if an exchange does not exist.
    async fn receive(&mut self, pair: &ConnectionPair, limit: Duration) -> Option<String> {
        tokio::select! {
            reply = self.replies.recv() => if reply.is_some()
                && let Some(sent_at) = self.sent_at.take()
            {
                pair.record_answer(sent_at, limit);
            },
            event = self.events.recv() => match event {
                Some(BrokerEvent::Closed { reason, .. }) => return Some(reason),
                Some(
                    BrokerEvent::Ack { .. }
                    | BrokerEvent::Nack { .. }
                    | BrokerEvent::Returned { .. }
                    | BrokerEvent::Cancelled,
                ) => {}
                None => std::future::pending().await,
            },
        }
        None
    }

    fn silence(&self) -> Duration {
        self.sent_at.map_or(Duration::ZERO, |since| since.elapsed())
    }
}
