//! The provider's side: a task that reads the requests of one address and sends the replies.

use std::collections::HashMap;
use std::pin::pin;
use std::sync::Arc;
use std::time::{Duration, Instant};

use amqprs::BasicProperties;
use amqprs::channel::{
    BasicAckArguments, BasicConsumeArguments, BasicPublishArguments, Channel, ConsumerMessage,
    QueueBindArguments, QueueDeclareArguments,
};
use asmotion_bus::{AddressQueue, CallFailure, Notifier, PendingCall, Request};
use asmotion_datum::Codec;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::sync::oneshot;
use tokio::time::{MissedTickBehavior, interval, sleep};

use super::ended::EndedRequests;
use super::lateness::LatenessEstimate;
use super::message::{self, OutgoingReply};
use crate::binding_refresh::BindingRefresh;
use crate::channel::{self, AmqpResult, BrokerEvent, ChannelError};
use crate::first_declaration::FirstDeclaration;
use crate::link::{ConnectionPair, Link};
use crate::notice::BusNotice;
use crate::wire::{self, Headers};

/// Limit of unacknowledged requests delivered to a provider.
const PREFETCH: u16 = 256;
/// Time before an enquiry about a held request counts: one that comes at once has waited in the same socket.
const LEAST_HELD: Duration = Duration::from_millis(150);
/// Time for which a request waits for an enquiry of its caller; callers enquire four times a second.
const HELD: Duration = Duration::from_secs(1);
/// Interval at which expired requests are removed.
const TICK: Duration = Duration::from_millis(500);
/// Pause before the queue is declared again.
const REST: Duration = Duration::from_millis(100);

/// Address and queue that a provider serves.
pub(crate) struct ProviderSetup {
    pub link: Arc<Link>,
    pub key: String,
    pub queue: String,
    pub size: usize,
    pub requests: Arc<AddressQueue>,
    /// Receives the outcome of the first declaration.
    pub ready: FirstDeclaration,
}

/// Identity of a request. Ids are claims of the sender, so they are compared only among requests of one AMQP user, which the
/// broker verifies: nobody cancels or pre-empts the request of another user.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct RequestId {
    user: String,
    id: String,
}

impl RequestId {
    fn of(properties: &BasicProperties) -> Self {
        let id = properties.correlation_id().or(properties.message_id());
        Self {
            user: properties.user_id().cloned().unwrap_or_default(),
            id: id.cloned().unwrap_or_default(),
        }
    }
}

/// State of a request.
enum RequestState {
    /// Passed to the provider; the reply goes to `reply_to`, with the codec of the request.
    Running {
        pending: PendingCall,
        reply_to: String,
        codec: Codec,
    },
    /// Not executed yet, because its caller may have given up; an enquiry shows that it still waits.
    Held {
        request: Request,
        properties: Box<BasicProperties>,
        since: Instant,
    },
    /// Ended, with the reply that was sent, if there was one.
    Ended(Option<OutgoingReply>),
    /// Ended, with a reply that is no longer remembered. The request is not executed again.
    Forgotten,
}

/// Task that serves one address.
pub(crate) struct ProviderTask {
    setup: ProviderSetup,
    requests: HashMap<RequestId, RequestState>,
    ended: EndedRequests<RequestId>,
    /// Ids of requests that have a reply to be sent.
    ended_calls: UnboundedReceiver<RequestId>,
    lateness: LatenessEstimate,
    end_sender: UnboundedSender<RequestId>,
}

impl ProviderTask {
    pub(crate) fn new(setup: ProviderSetup) -> Self {
        let (end_sender, ended_calls) = unbounded_channel();
        Self {
            setup,
            requests: HashMap::new(),
            ended: EndedRequests::default(),
            lateness: LatenessEstimate::default(),
            ended_calls,
            end_sender,
        }
    }

    /// Serves until `stop` resolves.
    pub(crate) async fn run(mut self, mut stop: oneshot::Receiver<()>) {
        let link = Arc::clone(&self.setup.link);
        let mut unreachable = 0_u32;
        loop {
            let pair = tokio::select! {
                pair = link.pair() => pair,
                _ = &mut stop => return,
            };
            let Some(pair) = pair else { return };
            let end = tokio::select! {
                end = self.session(&pair, &mut stop) => end,
                () = link.wait_until_replaced(&pair) => Err(ChannelError::Lost),
            };
            match end {
                Ok(()) => return,
                Err(broken) if self.setup.ready.report(Err(broken.clone())) => return,
                Err(ChannelError::Closed { reason, .. }) => {
                    link.report_refusal(&self.setup.key, reason);
                    sleep(REST).await;
                }
                Err(ChannelError::QueueUnreachable { reason }) => {
                    unreachable += 1;
                    if unreachable > channel::BRIEFLY_UNREACHABLE {
                        link.report_refusal(&self.setup.key, reason);
                    }
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
    }

    async fn session(
        &mut self,
        pair: &ConnectionPair,
        stop: &mut oneshot::Receiver<()>,
    ) -> Result<(), ChannelError> {
        let lost = |_| ChannelError::Lost;
        let (channel, mut words) = channel::open(&pair.consumers).await.map_err(lost)?;
        // replies are published, on a connection that may be blocked while the consumers' is not
        let (replies, mut refusals) = channel::open(&pair.publishers).await.map_err(lost)?;
        let begun = self.declare(&channel).await;
        let mut requests = begun.map_err(|_| channel::close_reason(&mut words))?;
        self.setup.ready.report(Ok(()));
        let mut ticks = interval(TICK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let link = Arc::clone(&self.setup.link);
        let mut closing = pin!(link.wait_until_closing());
        let mut binding = BindingRefresh::new(&channel, self.binding());
        loop {
            let end = tokio::select! {
                // replies first: a leaving provider rejects the waiting requests before it leaves
                biased;
                id = self.ended_calls.recv() => self.send_reply(id, &replies).await,
                _ = &mut *stop => break,
                () = &mut closing => break,
                word = words.recv() => return Err(broken(word)),
                word = refusals.recv() => return Err(broken(word)),
                request = requests.recv() => match request {
                    Some(request) => self.handle_message(request, &channel, &replies).await,
                    None => return Err(ChannelError::Cancelled),
                },
                _ = ticks.tick(), if !self.requests.is_empty() => {
                    self.evict();
                    Ok(())
                }
                bound = binding.refresh() => bound,
            };
            end.map_err(|_| channel::close_reason(&mut words))?;
        }
        // its reply must not meet the end of the channel
        let _ = binding.finish().await;
        self.reject_remaining(channel, &replies).await;
        Ok(())
    }

    /// Declares the address's queue as exclusive, because an address has one provider.
    async fn declare(&self, channel: &Channel) -> AmqpResult<UnboundedReceiver<ConsumerMessage>> {
        let post = &self.setup;
        let length = post.size.max(PREFETCH.into());
        let arguments = Headers::default()
            .count("x-max-length", length as u64)
            .text("x-overflow", "reject-publish");
        let mut queue = QueueDeclareArguments::new(&post.queue);
        queue.exclusive(true).arguments(arguments.into_table());
        let mut consume = BasicConsumeArguments::new(&post.queue, "");
        consume.manual_ack(true);
        let begun = channel::consume(channel, queue, self.binding(), PREFETCH, consume);
        Ok(begun.await?.messages)
    }

    fn binding(&self) -> QueueBindArguments {
        let exchange = self.setup.link.settings.services();
        QueueBindArguments::new(&self.setup.queue, &exchange, &self.setup.key)
    }

    async fn handle_message(
        &mut self,
        message: ConsumerMessage,
        channel: &Channel,
        replies: &Channel,
    ) -> AmqpResult<()> {
        let properties = message.basic_properties.unwrap_or_default();
        let content = message.content.unwrap_or_default();
        if let Some(answer) = self.handle_request(&properties, content) {
            let reply_to = properties.reply_to().cloned().unwrap_or_default();
            let id = properties.correlation_id().cloned().unwrap_or_default();
            self.send(&answer, &id, &reply_to, replies).await?;
        }
        match message.deliver {
            Some(deliver) => {
                let acknowledgement = BasicAckArguments::new(deliver.delivery_tag(), false);
                channel.basic_ack(acknowledgement).await
            }
            None => Ok(()),
        }
    }

    /// Handles a message and returns the reply to it, if one is already known.
    fn handle_request(
        &mut self,
        properties: &BasicProperties,
        content: Vec<u8>,
    ) -> Option<OutgoingReply> {
        let kind = properties.message_type().map_or("", String::as_str);
        let id = RequestId::of(properties);
        if let Some(known) = self.requests.get_mut(&id) {
            return match (known, kind) {
                (RequestState::Running { pending, .. }, wire::CANCEL) => {
                    pending.cancel();
                    None
                }
                // the link was broken in the meantime: the reply goes to the caller's new channel
                (RequestState::Running { reply_to, .. }, _) => {
                    *reply_to = properties.reply_to().cloned().unwrap_or_default();
                    None
                }
                (RequestState::Held { since, .. }, wire::ENQUIRY) => {
                    if since.elapsed() >= LEAST_HELD {
                        self.start_held(id, properties.reply_to());
                    }
                    None
                }
                (RequestState::Held { .. }, wire::CANCEL) => {
                    self.cancel_held(&id);
                    None
                }
                (RequestState::Held { .. }, _) => None,
                (RequestState::Ended(_) | RequestState::Forgotten, wire::CANCEL) => None,
                (RequestState::Ended(reply), _) => reply.clone(),
                (RequestState::Forgotten, _) => refusal(
                    "REPLY_FORGOTTEN",
                    "executed; its reply was too large to be kept for a repetition".to_owned(),
                ),
            };
        }
        match kind {
            wire::CANCEL => None,
            wire::ENQUIRY => OutgoingReply::of(Err(CallFailure::Unavailable), Codec::default()),
            _ => match message::read_request(properties, content) {
                Ok(request) => {
                    self.receive(id, request, kind == wire::TELLING, properties);
                    None
                }
                Err(reason) => {
                    let what = self.setup.key.clone();
                    let answer = refusal("UNREADABLE", reason.clone());
                    self.setup
                        .link
                        .report(BusNotice::Unreadable { what, reason });
                    answer
                }
            },
        }
    }

    /// Executes a request, or holds it until its caller shows that it still waits. Nobody enquires about a one-way request: it
    /// is dropped only if the caller's clock is known.
    fn receive(
        &mut self,
        id: RequestId,
        mut request: Request,
        one_way: bool,
        properties: &BasicProperties,
    ) {
        let left = self.lateness.time_left(properties, request.timeout);
        if left.is_none() && !one_way {
            let held = RequestState::Held {
                request,
                properties: Box::new(properties.clone()),
                since: Instant::now(),
            };
            self.requests.insert(id, held);
        } else if left.is_none() && self.lateness.knows_clock_of(properties) {
            self.report_late(&request);
        } else {
            request.timeout = left.unwrap_or(request.timeout);
            self.start_request(id, request, one_way, properties.reply_to());
        }
    }

    fn report_late(&self, request: &Request) {
        self.setup.link.report(BusNotice::Late {
            what: self.setup.key.clone(),
            source: request.origin.source.to_string(),
        });
    }

    /// Removes a held request that its caller has cancelled. A caller whose timeout is shorter than the interval of its enquiries
    /// has thereby shown that it had waited until then, so its next request is not held.
    fn cancel_held(&mut self, id: &RequestId) {
        if let Some(RequestState::Held {
            request,
            properties,
            since,
        }) = self.requests.remove(id)
            && since.elapsed() >= LEAST_HELD
        {
            self.record_waiting(&request, &properties, since.elapsed());
        }
    }

    /// Records that the caller of a held request has waited for longer than its clock says.
    fn record_waiting(
        &mut self,
        request: &Request,
        properties: &BasicProperties,
        held_for: Duration,
    ) {
        let timeout = request.timeout;
        let news = self.lateness.record_waiting(properties, timeout, held_for);
        if let Some(difference) = news {
            let source = request.origin.source.to_string();
            self.setup
                .link
                .report(BusNotice::ClockOffset { source, difference });
        }
    }

    /// Executes a request whose caller has shown that it still waits.
    fn start_held(&mut self, id: RequestId, reply_to: Option<&String>) {
        let Some(RequestState::Held {
            mut request,
            properties,
            since,
        }) = self.requests.remove(&id)
        else {
            return;
        };
        self.record_waiting(&request, &properties, since.elapsed());
        request.timeout = request.timeout.saturating_sub(since.elapsed());
        self.start_request(id, request, false, reply_to);
    }

    fn start_request(
        &mut self,
        id: RequestId,
        request: Request,
        one_way: bool,
        reply_to: Option<&String>,
    ) {
        if one_way {
            let (pending, call, _) = PendingCall::one_way(request, Arc::new(Notifier::new()));
            // if the queue rejects the request, it ends it, and its caller does not wait
            let _ = self.setup.requests.push(call);
            self.store_reply(id, None, pending.deadline());
            return;
        }
        let (answering, answered) = (self.end_sender.clone(), id.clone());
        let notifier = Notifier::calling(move || {
            // fails if the task has ended
            let _ = answering.send(answered.clone());
        });
        let codec = message::reply_codec(&request.argument);
        let (pending, call) = PendingCall::new(request, Arc::new(notifier));
        let reply_to = reply_to.cloned().unwrap_or_default();
        let running = RequestState::Running {
            pending,
            reply_to,
            codec,
        };
        self.requests.insert(id, running);
        // if the queue rejects the request, it also replies
        let _ = self.setup.requests.push(call);
    }

    /// Sends the reply to a request, or forgets a cancelled one.
    async fn send_reply(&mut self, id: Option<RequestId>, replies: &Channel) -> AmqpResult<()> {
        let Some(id) = id else { return Ok(()) };
        let Some(RequestState::Running {
            pending,
            reply_to,
            codec,
        }) = self.requests.get(&id)
        else {
            return Ok(());
        };
        let Some(end) = pending.try_take() else {
            return Ok(());
        };
        let (answer, reply_to) = (OutgoingReply::of(end, *codec), reply_to.clone());
        let deadline = pending.deadline();
        self.store_reply(id.clone(), answer.clone(), deadline);
        match answer {
            Some(answer) => self.send(&answer, &id.id, &reply_to, replies).await,
            None => Ok(()),
        }
    }

    async fn send(
        &self,
        answer: &OutgoingReply,
        id: &str,
        reply_to: &str,
        replies: &Channel,
    ) -> AmqpResult<()> {
        if reply_to.is_empty() {
            return Ok(());
        }
        let user = self.setup.link.settings.credentials.user();
        let arguments = BasicPublishArguments::new("", reply_to);
        replies
            .basic_publish(
                answer.properties(id, user),
                answer.bytes.to_vec(),
                arguments,
            )
            .await
    }

    /// Remembers that a request has ended, and with which reply, until its deadline: its caller may send it again until
    /// then.
    fn store_reply(&mut self, id: RequestId, reply: Option<OutgoingReply>, deadline: Instant) {
        let size = reply.as_ref().map_or(0, |reply| reply.bytes.len());
        self.requests.insert(id.clone(), RequestState::Ended(reply));
        let excess = self.ended.add(id, size, deadline, Instant::now());
        if let Some(oldest) = excess.request {
            self.requests.remove(&oldest);
        }
        for id in excess.replies {
            self.requests.insert(id, RequestState::Forgotten);
        }
    }

    /// Ends expired requests, and forgets those that ended and are past their deadline. Reading the result of an expired
    /// call times it out.
    fn evict(&mut self) {
        for id in self.ended.take_expired(Instant::now()) {
            self.requests.remove(&id);
        }
        let mut late = Vec::new();
        self.requests.retain(|_, known| match known {
            RequestState::Running { pending, .. } => !pending.is_expired(),
            RequestState::Held { request, since, .. } => {
                let waits = since.elapsed() < HELD;
                if !waits {
                    late.push(request.clone());
                }
                waits
            }
            RequestState::Ended(_) | RequestState::Forgotten => true,
        });
        for request in &late {
            self.report_late(request);
        }
    }

    /// Deletes the queue, and tells waiting callers that the provider has left.
    async fn reject_remaining(&mut self, channel: Channel, replies: &Channel) {
        channel::delete(channel.clone(), &self.setup.queue).await;
        let known = std::mem::take(&mut self.requests);
        for (id, known) in known {
            if let RequestState::Running {
                reply_to, codec, ..
            } = known
                && let Some(answer) = OutgoingReply::of(Err(CallFailure::Unavailable), codec)
            {
                // a caller that misses this message will ask, and find no provider
                let _ = self.send(&answer, &id.id, &reply_to, replies).await;
            }
        }
    }
}

fn refusal(code: &str, detail: String) -> Option<OutgoingReply> {
    let refusal = asmotion_bus::Refusal {
        code: code.to_owned(),
        detail,
    };
    // a refusal is plain text
    OutgoingReply::of(Err(CallFailure::Refused(refusal)), Codec::default())
}

fn broken(word: Option<BrokerEvent>) -> ChannelError {
    match word {
        Some(BrokerEvent::Closed { code, reason }) => ChannelError::closed(code, reason),
        Some(BrokerEvent::Cancelled) => ChannelError::Cancelled,
        Some(BrokerEvent::Ack { .. } | BrokerEvent::Nack { .. } | BrokerEvent::Returned { .. })
        | None => ChannelError::Lost,
    }
}
