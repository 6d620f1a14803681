//! The provider's side: a task that reads the requests of one address and sends the replies.

use std::collections::{HashMap, VecDeque};
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use amqprs::BasicProperties;
use amqprs::channel::{
    BasicAckArguments, BasicConsumeArguments, BasicPublishArguments, Channel, ConsumerMessage,
    QueueBindArguments, QueueDeclareArguments,
};
use asmotion_bus::{AddressQueue, CallFailure, Notifier, PendingCall, Request};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::sync::oneshot;
use tokio::time::{MissedTickBehavior, interval, sleep};

use super::message::{self, OutgoingReply};
use crate::channel::{self, AmqpResult, BrokerEvent, ChannelError};
use crate::first_declaration::FirstDeclaration;
use crate::link::{ConnectionPair, Link};
use crate::notice::BusNotice;
use crate::wire::{self, Headers, OwnedName};

/// Limit of unacknowledged requests delivered to a provider.
const PREFETCH: u16 = 256;
/// Limit of remembered requests that have ended. If one arrives again, its reply is sent again without executing it.
const REMEMBERED: usize = 4096;
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

/// State of a request.
enum RequestState {
    /// Passed to the provider; the reply goes to `reply_to`.
    Running {
        pending: PendingCall,
        reply_to: String,
    },
    /// Ended, with the reply that was sent.
    Ended(Option<OutgoingReply>),
}

/// Task that serves one address.
pub(crate) struct ProviderTask {
    setup: ProviderSetup,
    /// By id and the caller's user: a user can neither claim, repeat nor cancel the requests of another.
    requests: HashMap<OwnedName, RequestState>,
    /// Ids of ended requests, oldest first.
    ended_ids: VecDeque<OwnedName>,
    /// Ids of requests that have a reply to be sent.
    ended_calls: UnboundedReceiver<OwnedName>,
    end_sender: UnboundedSender<OwnedName>,
}

impl ProviderTask {
    pub(crate) fn new(setup: ProviderSetup) -> Self {
        let (end_sender, ended_calls) = unbounded_channel();
        Self {
            setup,
            requests: HashMap::new(),
            ended_ids: VecDeque::new(),
            ended_calls,
            end_sender,
        }
    }

    /// Serves until `stop` resolves.
    pub(crate) async fn run(mut self, mut stop: oneshot::Receiver<()>) {
        let link = Arc::clone(&self.setup.link);
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
            };
            end.map_err(|_| channel::close_reason(&mut words))?;
        }
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
        let exchange = post.link.settings.services();
        let binding = QueueBindArguments::new(&post.queue, &exchange, &post.key);
        let mut consume = BasicConsumeArguments::new(&post.queue, "");
        consume.manual_ack(true);
        channel::consume(channel, queue, binding, PREFETCH, consume).await
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
        let id = properties.correlation_id().or(properties.message_id());
        let id = OwnedName::of(properties, id.cloned().unwrap_or_default());
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
                (RequestState::Ended(_), wire::CANCEL) => None,
                (RequestState::Ended(answer), _) => answer.clone(),
            };
        }
        match kind {
            wire::CANCEL => None,
            wire::ENQUIRY => OutgoingReply::of(Err(CallFailure::Unavailable)),
            _ => match message::read_request(properties, content) {
                Ok(Some(request)) => {
                    self.start_request(id, request, kind == wire::TELLING, properties.reply_to());
                    None
                }
                // the caller has stopped waiting
                Ok(None) => None,
                Err(reason) => {
                    let what = self.setup.key.clone();
                    let answer =
                        OutgoingReply::of(Err(CallFailure::Refused(asmotion_bus::Refusal {
                            code: "UNREADABLE".to_owned(),
                            detail: reason.clone(),
                        })));
                    self.setup
                        .link
                        .report(BusNotice::Unreadable { what, reason });
                    answer
                }
            },
        }
    }

    fn start_request(
        &mut self,
        id: OwnedName,
        request: Request,
        one_way: bool,
        reply_to: Option<&String>,
    ) {
        if one_way {
            let (_, call, _) = PendingCall::one_way(request, Arc::new(Notifier::new()));
            // if the queue rejects the request, it ends it, and its caller does not wait
            let _ = self.setup.requests.push(call);
            self.store_reply(id, None);
            return;
        }
        let (answering, answered) = (self.end_sender.clone(), id.clone());
        let notifier = Notifier::calling(move || {
            // fails if the task has ended
            let _ = answering.send(answered.clone());
        });
        let (pending, call) = PendingCall::new(request, Arc::new(notifier));
        let reply_to = reply_to.cloned().unwrap_or_default();
        self.requests
            .insert(id, RequestState::Running { pending, reply_to });
        // if the queue rejects the request, it also replies
        let _ = self.setup.requests.push(call);
    }

    /// Sends the reply to a request, or forgets a cancelled one.
    async fn send_reply(&mut self, id: Option<OwnedName>, replies: &Channel) -> AmqpResult<()> {
        let Some(id) = id else { return Ok(()) };
        let Some(RequestState::Running { pending, reply_to }) = self.requests.get(&id) else {
            return Ok(());
        };
        let Some(end) = pending.try_take() else {
            return Ok(());
        };
        let (answer, reply_to) = (OutgoingReply::of(end), reply_to.clone());
        self.store_reply(id.clone(), answer.clone());
        match answer {
            Some(answer) => self.send(&answer, &id.name, &reply_to, replies).await,
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

    fn store_reply(&mut self, id: OwnedName, answer: Option<OutgoingReply>) {
        self.requests
            .insert(id.clone(), RequestState::Ended(answer));
        self.ended_ids.push_back(id);
        if self.ended_ids.len() > REMEMBERED
            && let Some(oldest) = self.ended_ids.pop_front()
        {
            self.requests.remove(&oldest);
        }
    }

    /// Ends expired requests: reading the result of an expired call times it out.
    fn evict(&mut self) {
        let over = |known: &RequestState| match known {
            RequestState::Running { pending, .. } => pending.is_expired(),
            RequestState::Ended(_) => false,
        };
        let over: Vec<_> = self
            .requests
            .iter()
            .filter(|(_, known)| over(known))
            .map(|(id, _)| id.clone())
            .collect();
        for id in over {
            self.store_reply(id, None);
        }
    }

    /// Deletes the queue, and tells waiting callers that the provider has left.
    async fn reject_remaining(&mut self, channel: Channel, replies: &Channel) {
        channel::delete(channel.clone(), &self.setup.queue).await;
        let known = std::mem::take(&mut self.requests);
        for (id, known) in known {
            if let RequestState::Running { reply_to, .. } = known
                && let Some(answer) = OutgoingReply::of(Err(CallFailure::Unavailable))
            {
                // a caller that misses this message will ask, and find no provider
                let _ = self.send(&answer, &id.name, &reply_to, replies).await;
            }
        }
    }
}

fn broken(word: Option<BrokerEvent>) -> ChannelError {
    match word {
        Some(BrokerEvent::Closed { code, reason }) => ChannelError::Closed { code, reason },
        Some(BrokerEvent::Cancelled) => ChannelError::Cancelled,
        Some(BrokerEvent::Ack { .. } | BrokerEvent::Nack { .. } | BrokerEvent::Returned { .. })
        | None => ChannelError::Lost,
    }
}
