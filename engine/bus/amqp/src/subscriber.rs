//! A subscription: a task that owns a channel and a queue, and fills the reader's queue.
//!
//! The reader's queue bounds, conflates and counts; the broker's queue does the same for messages not yet delivered.
//! A state topic has a queue of length 1 and at most one unacknowledged message, so that the newest message is always
//! the next. Event topics have a durable queue with its own name, which survives a restart of the broker and a broken
//! connection.

use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use amqprs::channel::{
    BasicAckArguments, BasicConsumeArguments, Channel, ConsumerMessage, QueueBindArguments,
    QueueDeclareArguments,
};
use asmotion_bus::{Overflow, Pattern, QueuePolicy, SubscriptionSender};
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::sync::oneshot;
use tokio::time::{Instant, sleep, sleep_until};

use crate::arrivals::Arrivals;
use crate::backlog_count::BacklogCount;
use crate::binding_refresh::BindingRefresh;
use crate::channel::{self, AmqpResult, BrokerEvent, ChannelError, Consumption};
use crate::earlier_run::{self, Takeover};
use crate::first_declaration::FirstDeclaration;
use crate::link::{ConnectionPair, Link};
use crate::names::RoutingNames;
use crate::notice::BusNotice;
use crate::wire::{self, Headers};

/// Limit of unacknowledged events.
const PREFETCH: u16 = 1024;
/// Limit on the number of messages taken in one pass.
const TAKEN: usize = 64;
/// Delay before an event is acknowledged together with later ones, so that handling it is not delayed.
const ACKNOWLEDGED_AFTER: Duration = Duration::from_millis(1);
/// Number of unacknowledged events at which the acknowledgement is sent immediately.
const OWED: u64 = 256;
/// Longest wait for the end of another consumer of a queue that has the same name in every run of the process.
const TWIN: Duration = Duration::from_millis(500);
/// Pause before a queue is declared again.
const REST: Duration = Duration::from_millis(100);

/// Task of a subscription, run on the bus thread.
pub(crate) struct SubscriberTask {
    pub link: Arc<Link>,
    pub names: RoutingNames,
    pub pattern: Pattern,
    /// Binding key on the topic exchange.
    pub key: String,
    /// Name of the queue at the broker.
    pub queue: String,
    /// Name of the queue in every run of the process, until it has been taken over from an earlier run.
    pub returning: Option<String>,
    /// Name of the queue if the one that has been taken over turns out to be used by another process.
    pub own_queue: Option<String>,
    /// Set when another process uses such a queue, so that the other subscriptions do not wait for it.
    pub has_twin: Arc<AtomicBool>,
    pub policy: QueuePolicy,
    pub sender: SubscriptionSender,
    /// Resolved when the subscription is dropped.
    pub stop: oneshot::Receiver<()>,
    /// Receives the outcome of the first declaration.
    pub ready: FirstDeclaration,
}

fn now() -> std::time::Instant {
    Instant::now().into_std()
}

/// Delivery tags handed on but not yet acknowledged.
#[derive(Default)]
struct PendingAcknowledgement {
    last: u64,
    acknowledged: u64,
    /// Time at which the acknowledgement must be sent.
    due: Option<Instant>,
}

impl PendingAcknowledgement {
    fn count(&self) -> u64 {
        self.last.saturating_sub(self.acknowledged)
    }

    /// Waits until the acknowledgement is due.
    async fn wait_until_due(&self) {
        match self.due {
            Some(due) => sleep_until(due).await,
            None => std::future::pending().await,
        }
    }

    async fn send(&mut self, channel: &Channel) -> AmqpResult<()> {
        self.due = None;
        if self.count() > 0 {
            self.acknowledged = self.last;
            let all = BasicAckArguments::new(self.last, true);
            channel.basic_ack(all).await?;
        }
        Ok(())
    }
}

impl SubscriberTask {
    pub(crate) async fn run(mut self) {
        let mut arrivals = Arrivals::beginning_at(now());
        let link = Arc::clone(&self.link);
        let mut unreachable = 0_u32;
        while let Some(pair) = link.pair().await {
            let end = tokio::select! {
                end = self.session(&pair, &mut arrivals) => end,
                () = link.wait_until_replaced(&pair) => Err(ChannelError::Lost),
            };
            if let (Err(ChannelError::Closed { .. }), Some(own)) = (&end, self.own_queue.take()) {
                // refused to a second consumer; any other refusal comes again
                self.queue = own;
                continue;
            }
            match end {
                Ok(()) => return,
                Err(broken) if self.ready.report(Err(broken.clone())) => return,
                Err(ChannelError::Closed { reason, .. }) => {
                    link.report_refusal(self.pattern.as_str(), reason);
                    sleep(REST).await;
                }
                Err(ChannelError::Cancelled) => link.report(BusNotice::Refused {
                    what: self.pattern.to_string(),
                    reason: "its queue was deleted".to_owned(),
                }),
                Err(ChannelError::QueueUnreachable { reason }) => {
                    unreachable += 1;
                    if unreachable > channel::BRIEFLY_UNREACHABLE {
                        link.report_refusal(self.pattern.as_str(), reason);
                    }
                    sleep(REST).await;
                }
                Err(ChannelError::ExchangeMissing { reason }) => {
                    link.replace_after_deletion(&pair, &reason).await;
                }
                Err(ChannelError::Lost) => link.wait_after_error(&pair).await,
            }
        }
    }

    /// Consumes one queue until the subscription is dropped.
    async fn session(
        &mut self,
        pair: &ConnectionPair,
        arrivals: &mut Arrivals,
    ) -> Result<(), ChannelError> {
        let (channel, mut words) = channel::open(&pair.consumers)
            .await
            .map_err(|_| ChannelError::Lost)?;
        if self.link.is_poisoned() && channel::purge(&pair.consumers, &self.queue).await.is_ok() {
            let what = self.pattern.to_string();
            let reason = "the client failed on it repeatedly; the waiting messages were discarded";
            self.link.report(BusNotice::Unreadable {
                what,
                reason: reason.to_owned(),
            });
        }
        self.take_over(pair).await?;
        let begun = self.declare(&channel).await;
        let begun = begun.map_err(|_| channel::close_reason(&mut words))?;
        let mut answers = pair.answers();
        arrivals.begin_session(begun.backlog, *answers.borrow_and_update(), now());
        let mut messages = begun.messages;
        self.own_queue = None;
        self.ready.report(Ok(()));
        let link = Arc::clone(&self.link);
        let mut closing = pin!(link.wait_until_closing());
        let mut owed = PendingAcknowledgement::default();
        let mut binding = BindingRefresh::new(&channel, self.binding());
        let mut count = BacklogCount::default();
        let limit = link.settings.timing.unnoticed_wait();
        loop {
            tokio::select! {
                _ = &mut self.stop => break,
                () = &mut closing => break,
                word = words.recv() => match word {
                    Some(BrokerEvent::Closed { code, reason }) => {
                        return Err(ChannelError::closed(code, reason));
                    }
                    Some(BrokerEvent::Cancelled) => return Err(ChannelError::Cancelled),
                    Some(BrokerEvent::Ack { .. } | BrokerEvent::Nack { .. } | BrokerEvent::Returned { .. }) => {}
                    None => return Err(ChannelError::Lost),
                },
                message = messages.recv() => {
                    let Some(message) = message else {
                        return Err(ChannelError::Cancelled);
                    };
                    if arrivals.compare_with_answers(*answers.borrow(), limit, now()) {
                        count.begin(&channel, &self.queue);
                    }
                    owed.last = owed.last.max(self.take_batch(message, &mut messages, arrivals));
                    // for a state, the broker sends the next message only after this acknowledgement
                    if self.policy == QueuePolicy::Latest || owed.count() >= OWED {
                        owed.send(&channel).await.map_err(|_| channel::close_reason(&mut words))?;
                        arrivals.record_acknowledgement(now());
                    } else {
                        owed.due.get_or_insert_with(|| Instant::now() + ACKNOWLEDGED_AFTER);
                    }
                }
                () = owed.wait_until_due() => {
                    owed.send(&channel).await.map_err(|_| channel::close_reason(&mut words))?;
                    arrivals.record_acknowledgement(now());
                }
                // without a message: the next one has not waited, unless it is counted
                ended = answers.changed() => {
                    ended.map_err(|_| ChannelError::Lost)?;
                    if arrivals.compare_with_answers(*answers.borrow(), limit, now()) {
                        count.begin(&channel, &self.queue);
                    }
                }
                waiting = count.reply() => {
                    let waiting = waiting.map_err(|_| channel::close_reason(&mut words))?;
                    arrivals.limit_backlog(messages.len() as u64 + u64::from(waiting));
                }
                bound = binding.refresh() => bound.map_err(|_| channel::close_reason(&mut words))?,
            }
        }
        // their replies must not meet the end of the channel
        let _ = binding.finish().await;
        count.finish().await;
        // messages already passed on must not be delivered again to the next subscription; a closed channel accepts
        // nothing
        let _ = owed.send(&channel).await;
        self.end(channel).await;
        Ok(())
    }

    /// Takes the queue of an earlier run over, and counts what is discarded. With a second process of the same name, each has a
    /// queue of its own.
    async fn take_over(&mut self, pair: &ConnectionPair) -> Result<(), ChannelError> {
        let Some(name) = self.returning.clone() else {
            return Ok(());
        };
        let patience = if self.has_twin.load(Ordering::Relaxed) {
            Duration::ZERO
        } else {
            TWIN
        };
        let queue = self.queue_arguments(&name);
        match earlier_run::take_over(&pair.consumers, (&name, &queue), patience).await? {
            Takeover::Emptied(discarded) => {
                self.sender.set_discarded(discarded.into());
                self.own_queue = Some(std::mem::replace(&mut self.queue, name));
            }
            Takeover::InUse => self.has_twin.store(true, Ordering::Relaxed),
        }
        self.returning = None;
        Ok(())
    }

    fn queue_arguments(&self, name: &str) -> QueueDeclareArguments {
        let mut queue = QueueDeclareArguments::new(name);
        let (length, overflow) = match self.policy {
            QueuePolicy::Latest => {
                queue.exclusive(true).auto_delete(true);
                (1, Overflow::DropOldest)
            }
            QueuePolicy::All { size, overflow } => {
                queue.durable(true);
                (size.max(PREFETCH.into()), overflow)
            }
        };
        let remembered = self.link.settings.timing.reply_retention.as_millis();
        let arguments = Headers::default()
            .count("x-max-length", length as u64)
            .number("x-expires", i64::try_from(remembered).unwrap_or(i64::MAX))
            .text(
                "x-overflow",
                match overflow {
                    Overflow::DropOldest => "drop-head",
                    Overflow::DropNewest => "reject-publish",
                },
            );
        queue.arguments(arguments.into_table());
        queue
    }

    async fn declare(&self, channel: &Channel) -> AmqpResult<Consumption> {
        let queue = self.queue_arguments(&self.queue);
        let prefetch = match self.policy {
            QueuePolicy::Latest => 1,
            QueuePolicy::All { .. } => PREFETCH,
        };
        // exclusive: messages that an earlier consumer of ours still holds would be redelivered behind newer ones
        let mut consume = BasicConsumeArguments::new(&self.queue, "");
        consume.manual_ack(true).exclusive(true);
        channel::consume(channel, queue, self.binding(), prefetch, consume).await
    }

    fn binding(&self) -> QueueBindArguments {
        let exchange = &self.link.settings.exchange;
        QueueBindArguments::new(&self.queue, exchange, &self.key)
    }

    /// Passes on a message and those waiting behind it. Returns the last delivery tag.
    fn take_batch(
        &self,
        first: ConsumerMessage,
        messages: &mut UnboundedReceiver<ConsumerMessage>,
        arrivals: &mut Arrivals,
    ) -> u64 {
        let mut last = 0;
        let mut next = Some(first);
        for _ in 0..TAKEN {
            let Some(message) = next else { break };
            last = self.deliver(message, arrivals).unwrap_or(last);
            next = messages.try_recv().ok();
        }
        match next {
            Some(message) => self.deliver(message, arrivals).unwrap_or(last),
            None => last,
        }
    }

    /// Passes on one message. Returns its delivery tag.
    fn deliver(&self, message: ConsumerMessage, arrivals: &mut Arrivals) -> Option<u64> {
        let deliver = message.deliver?;
        let properties = message.basic_properties.unwrap_or_default();
        let topic = self.names.topic(deliver.routing_key());
        let identity = wire::identity(&properties, topic);
        let is_new = arrivals.repeats.is_new(&identity);
        let waited = arrivals.waited(&identity, wire::sent(&properties), now());
        let repeats = &mut arrivals.repeats;
        if !is_new {
            self.sender.count_duplicate();
            return Some(deliver.delivery_tag());
        }
        if let Some(jump) = repeats.take_jump() {
            self.link.report(BusNotice::SequenceJump {
                topic: topic.to_owned(),
                user: jump.user,
                from: jump.from,
                to: jump.to,
            });
        }
        if self.policy != QueuePolicy::Latest {
            self.sender.set_missed(repeats.missed());
        }
        match wire::payload(&properties, message.content.unwrap_or_default()) {
            Ok(payload) => {
                let mut envelope = wire::envelope(topic, &properties, payload);
                envelope.age = envelope.age.saturating_add(waited);
                self.sender.push(envelope);
            }
            Err(reason) => {
                self.sender.count_unreadable();
                let what = topic.to_owned();
                self.link.report(BusNotice::Unreadable { what, reason });
            }
        }
        Some(deliver.delivery_tag())
    }

    /// Deletes the queue when the subscription ends.
    async fn end(&self, channel: Channel) {
        channel::delete(channel, &self.queue).await;
    }
}
