//! The caller's side: one task with one channel for all calls of a bus.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use amqprs::BasicProperties;
use amqprs::channel::{BasicConsumeArguments, BasicPublishArguments, Channel, ConsumerMessage};
use asmotion_bus::{CallFailure, DeliveryReceipt, IncomingCall, Payload};
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::time::{Instant, MissedTickBehavior, interval, sleep};

use super::message::{self, OutgoingRequest, REPLY_TO};
use crate::channel::{self, AmqpResult, BrokerEvent, ChannelError};
use crate::link::{ConnectionPair, Link};
use crate::wire;

/// Interval at which open calls are checked.
const TICK: Duration = Duration::from_millis(25);
/// Interval at which a provider is asked whether it still knows a call.
const ENQUIRY: Duration = Duration::from_millis(250);
/// Time within which a provider must return after the link was lost.
const GRACE: Duration = Duration::from_secs(5);
/// Share of its timeout for which a call waits for its provider.
const PROVIDER_WAIT: f64 = 0.9;
/// Pause after the broker refused the channel.
const REST: Duration = Duration::from_millis(200);

/// Completion that a call waits for.
pub(crate) enum AwaitedReply {
    /// The reply to a request.
    Answer(IncomingCall),
    /// The confirmation that the provider's queue has the request.
    Delivery(DeliveryReceipt),
}

impl AwaitedReply {
    pub(crate) fn complete(self, result: Result<Payload, CallFailure>) {
        match self {
            Self::Answer(call) => call.complete(result),
            Self::Delivery(delivered) => delivered.complete(result.map(drop)),
        }
    }

    fn is_awaited(&self) -> bool {
        match self {
            Self::Answer(call) => call.is_awaited(),
            Self::Delivery(delivered) => delivered.is_awaited(),
        }
    }

    fn kind(&self) -> &'static str {
        match self {
            Self::Answer(_) => wire::REQUEST,
            Self::Delivery(_) => wire::TELLING,
        }
    }
}

/// A call in progress.
pub(crate) struct OpenCall {
    message: OutgoingRequest,
    awaited: AwaitedReply,
    /// Time of the last enquiry at its provider.
    last_query: Instant,
    /// End of the period after a broken link in which a request without a provider is sent again.
    grace_deadline: Option<Instant>,
    /// End of the wait for a provider that is not there yet; `None` once the request has reached a queue.
    provider_deadline: Option<Instant>,
    /// `true` if the next attempt has to publish the request, because the broker returned it or the link broke.
    unsent: bool,
}

impl OpenCall {
    pub(crate) fn new(message: OutgoingRequest, awaited: AwaitedReply) -> Self {
        // before the timeout, which does not tell a missing provider from a slow one
        let patience = message.timeout.mul_f64(PROVIDER_WAIT);
        Self {
            grace_deadline: None,
            provider_deadline: message.awaits_provider.then(|| Instant::now() + patience),
            message,
            awaited,
            last_query: Instant::now(),
            unsent: false,
        }
    }

    pub(crate) fn complete(self, result: Result<Payload, CallFailure>) {
        self.awaited.complete(result);
    }
}

/// Task that sends all requests of a bus and receives their replies.
pub(crate) struct CallerTask {
    link: Arc<Link>,
    new_calls: UnboundedReceiver<OpenCall>,
    open_calls: HashMap<String, OpenCall>,
}

/// State of one channel.
struct CallerSession {
    channel: Channel,
    exchange: String,
    /// Delivery tag of the last publication.
    tag: u64,
    /// Tags of one-way requests awaiting confirmation, in order, with their ids.
    unconfirmed_one_way: VecDeque<(u64, String)>,
}

impl CallerTask {
    pub(crate) fn new(link: Arc<Link>, new_calls: UnboundedReceiver<OpenCall>) -> Self {
        Self {
            link,
            new_calls,
            open_calls: HashMap::new(),
        }
    }

    pub(crate) async fn run(mut self) {
        let link = Arc::clone(&self.link);
        while let Some(pair) = link.pair().await {
            let end = tokio::select! {
                end = self.session(&pair) => end,
                () = link.wait_until_replaced(&pair) => Err(ChannelError::Lost),
                () = link.wait_until_closing() => break,
            };
            match end {
                Ok(()) => return,
                Err(
                    ChannelError::Closed { reason, .. } | ChannelError::QueueUnreachable { reason },
                ) => {
                    link.report_refusal("calls", reason);
                    self.fail_all();
                    sleep(REST).await;
                }
                Err(ChannelError::ExchangeMissing { reason }) => {
                    link.replace_after_deletion(&pair, &reason).await;
                }
                Err(ChannelError::Cancelled | ChannelError::Lost) => {
                    link.wait_after_error(&pair).await
                }
            }
        }
        self.fail_all();
    }

    /// Fails all open calls.
    fn fail_all(&mut self) {
        for (_, open) in self.open_calls.drain() {
            open.complete(Err(CallFailure::Unavailable));
        }
    }

    async fn session(&mut self, pair: &ConnectionPair) -> Result<(), ChannelError> {
        let lost = |_| ChannelError::Lost;
        let (channel, mut words) = channel::open(&pair.publishers).await.map_err(lost)?;
        let replies = begin(&channel).await;
        let mut answers = replies.map_err(|_| channel::close_reason(&mut words))?;
        let mut session = CallerSession {
            channel,
            exchange: self.link.settings.services(),
            tag: 0,
            unconfirmed_one_way: VecDeque::new(),
        };
        for open in self.open_calls.values_mut() {
            open.grace_deadline = Some(Instant::now() + GRACE);
            open.unsent = true;
        }
        let mut ticks = interval(TICK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let end = tokio::select! {
                opened = self.new_calls.recv() => match opened {
                    Some(open) => self.start_call(open, &mut session).await,
                    None => return Ok(()),
                },
                word = words.recv() => match word {
                    Some(BrokerEvent::Closed { code, reason }) => {
                        return Err(ChannelError::closed(code, reason));
                    }
                    Some(word) => {
                        self.handle(word, &mut session);
                        Ok(())
                    }
                    None => return Err(ChannelError::Lost),
                },
                answer = answers.recv() => match answer {
                    Some(answer) => {
                        self.handle_reply(answer);
                        Ok(())
                    }
                    None => return Err(ChannelError::Lost),
                },
                _ = ticks.tick(), if !self.open_calls.is_empty() => self.check_open_calls(&mut session).await,
            };
            end.map_err(|_| channel::close_reason(&mut words))?;
        }
    }

    async fn start_call(&mut self, open: OpenCall, session: &mut CallerSession) -> AmqpResult<()> {
        let end = session.send(&open).await;
        // a one-way request whose sender no longer waits needs no entry
        if open.awaited.is_awaited() {
            self.open_calls.insert(open.message.id.clone(), open);
        }
        end
    }

    fn handle(&mut self, event: BrokerEvent, session: &mut CallerSession) {
        match event {
            BrokerEvent::Ack { tag, multiple } => {
                for id in session.take_confirmed(tag, multiple) {
                    if let Some(open) = self.open_calls.remove(&id) {
                        open.complete(Ok(Payload::of(asmotion_datum::Datum::Null)));
                    }
                }
            }
            BrokerEvent::Nack { tag, multiple } => {
                for id in session.take_confirmed(tag, multiple) {
                    self.handle_unroutable(&id);
                }
            }
            // a returned message precedes its acknowledgement
            BrokerEvent::Returned { message } => {
                let id = message.unwrap_or_default();
                session
                    .unconfirmed_one_way
                    .retain(|(_, telling)| *telling != id);
                self.handle_unroutable(&id);
            }
            BrokerEvent::Cancelled | BrokerEvent::Closed { .. } => {}
        }
    }

    /// Handles a request that reached no provider.
    fn handle_unroutable(&mut self, id: &str) {
        let Some(mut open) = self.open_calls.remove(id) else {
            return;
        };
        let deadline = open.grace_deadline.max(open.provider_deadline);
        if deadline.is_some_and(|deadline| Instant::now() < deadline) {
            open.unsent = true;
            self.open_calls.insert(id.to_owned(), open);
        } else {
            open.complete(Err(CallFailure::Unavailable));
        }
    }

    fn handle_reply(&mut self, message: ConsumerMessage) {
        let properties = message.basic_properties.unwrap_or_default();
        let id = properties.correlation_id();
        // a reply that is no longer awaited is discarded
        if let Some(open) = id.and_then(|id| self.open_calls.remove(id)) {
            let content = message.content.unwrap_or_default();
            open.complete(message::read_reply(&properties, content));
        }
    }

    /// Cancels calls that were abandoned, resends the unsent ones, and asks providers about the rest.
    async fn check_open_calls(&mut self, session: &mut CallerSession) -> AmqpResult<()> {
        let (awaited, given_up): (HashMap<_, _>, HashMap<_, _>) = self
            .open_calls
            .drain()
            .partition(|(_, open)| open.awaited.is_awaited());
        self.open_calls = awaited;
        for open in given_up.values() {
            if let AwaitedReply::Answer(_) = open.awaited {
                session
                    .send_notice(&open.message, wire::CANCEL, false)
                    .await?;
            }
        }
        for open in self.open_calls.values_mut() {
            if open.unsent {
                open.unsent = false;
                open.last_query = Instant::now();
                session.send(open).await?;
            } else if let AwaitedReply::Answer(_) = open.awaited
                && open.last_query.elapsed() > ENQUIRY
            {
                open.last_query = Instant::now();
                // not returned since it was sent: a provider that is not there any more has left
                open.provider_deadline = None;
                session
                    .send_notice(&open.message, wire::ENQUIRY, true)
                    .await?;
            }
        }
        Ok(())
    }
}

/// Enables confirms for one-way requests, and consumes replies: RabbitMQ requires the consumer on the channel of the
/// requests, before them.
async fn begin(channel: &Channel) -> AmqpResult<UnboundedReceiver<ConsumerMessage>> {
    channel::confirm(channel).await?;
    let mut consume = BasicConsumeArguments::new(REPLY_TO, "");
    consume.auto_ack(true);
    let channel = channel.clone();
    let (_, answers) =
        channel::run_to_completion(async move { channel.basic_consume_rx(consume).await }).await?;
    Ok(answers)
}

impl CallerSession {
    async fn send(&mut self, open: &OpenCall) -> AmqpResult<()> {
        let message = &open.message;
        let kind = open.awaited.kind();
        let bytes = message.bytes.to_vec();
        self.publish(message, message.request(kind), bytes, true)
            .await?;
        if let AwaitedReply::Delivery(_) = open.awaited {
            self.unconfirmed_one_way
                .push_back((self.tag, message.id.clone()));
        }
        Ok(())
    }

    /// Sends a message that refers to a request.
    async fn send_notice(
        &mut self,
        message: &OutgoingRequest,
        kind: &str,
        mandatory: bool,
    ) -> AmqpResult<()> {
        self.publish(message, message.notice(kind), Vec::new(), mandatory)
            .await
    }

    async fn publish(
        &mut self,
        message: &OutgoingRequest,
        properties: BasicProperties,
        bytes: Vec<u8>,
        mandatory: bool,
    ) -> AmqpResult<()> {
        let mut arguments = BasicPublishArguments::new(&self.exchange, &message.key);
        arguments.mandatory(mandatory);
        self.tag += 1;
        self.channel
            .basic_publish(properties, bytes, arguments)
            .await
    }

    /// The one-way requests that a confirm covers.
    fn take_confirmed(&mut self, tag: u64, multiple: bool) -> Vec<String> {
        let from = self
            .unconfirmed_one_way
            .partition_point(|(telling, _)| *telling < tag);
        let first = if multiple { 0 } else { from };
        let last = from
            + usize::from(
                self.unconfirmed_one_way
                    .get(from)
                    .is_some_and(|(one, _)| *one == tag),
            );
        self.unconfirmed_one_way
            .drain(first..last)
            .map(|(_, id)| id)
            .collect()
    }
}
