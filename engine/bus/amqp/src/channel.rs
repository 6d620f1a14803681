//! Channels, and the events that the broker sends on them, in order.

use std::time::Duration;

use amqprs::callbacks::ChannelCallback;
use amqprs::channel::{
    BasicConsumeArguments, BasicQosArguments, Channel, ConfirmSelectArguments, ConsumerMessage,
    ExchangeDeclareArguments, QueueBindArguments, QueueDeclareArguments, QueueDeleteArguments,
    QueuePurgeArguments,
};
use amqprs::connection::Connection;
use amqprs::{Ack, BasicProperties, Cancel, CloseChannel, Nack, Return};
use async_trait::async_trait;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

/// Result of the AMQP client's calls.
pub(crate) type AmqpResult<T> = Result<T, amqprs::error::Error>;

/// Unsolicited messages from the broker on a channel.
#[derive(Debug)]
pub(crate) enum BrokerEvent {
    /// Confirms this publication, and all before it if `multiple`.
    Ack { tag: u64, multiple: bool },
    /// Rejects this publication, and all before it if `multiple`.
    Nack { tag: u64, multiple: bool },
    /// Returns a mandatory publication that no queue received.
    Returned { message: Option<String> },
    /// A queue being consumed was deleted.
    Cancelled,
    /// The broker closed the channel.
    Closed { code: u16, reason: String },
}

/// Reply code of a channel closed because another connection holds the queue exclusively.
pub(crate) const LOCKED: u16 = 405;
/// Reply code of a channel closed because a queue has a consumer, or other properties than declared.
pub(crate) const PRECONDITION_FAILED: u16 = 406;
/// Reply code of a channel closed because something does not exist.
const NOT_FOUND: u16 = 404;

/// Number of failures to reach a queue after which it is not just being deleted, and they are reported.
pub(crate) const BRIEFLY_UNREACHABLE: u32 = 10;

/// Time between the broker's closing of a channel and our consent. A frame that arrives after the consent is an error of
/// the whole connection; until then the broker ignores it. The tasks that send on the channel learn of the end at once,
/// and have this long to finish the frame they are sending.
const CLOSE_GRACE: Duration = Duration::from_millis(50);

struct ChannelListener(UnboundedSender<BrokerEvent>);

impl ChannelListener {
    /// Forwards an event. Fails if the receiver has been dropped, and the channel with it.
    fn forward(&self, event: BrokerEvent) {
        let _ = self.0.send(event);
    }
}

#[async_trait]
impl ChannelCallback for ChannelListener {
    async fn close(&mut self, channel: &Channel, close: CloseChannel) -> AmqpResult<()> {
        self.forward(BrokerEvent::Closed {
            code: close.reply_code(),
            reason: close.reply_text().to_owned(),
        });
        // the client consents when this returns
        tokio::time::sleep(CLOSE_GRACE).await;
        if channel.is_connection_open() {
            Ok(())
        } else {
            // the connection has been replaced in the meantime, as after the deletion of an exchange: the client's task, which
            // would panic on a connection that is closed, ends without consent
            let reason = "its connection is closed".to_owned();
            Err(amqprs::error::Error::ChannelCloseError(reason))
        }
    }

    async fn cancel(&mut self, _: &Channel, _: Cancel) -> AmqpResult<()> {
        self.forward(BrokerEvent::Cancelled);
        Ok(())
    }

    async fn flow(&mut self, _: &Channel, active: bool) -> AmqpResult<bool> {
        Ok(active)
    }

    async fn publish_ack(&mut self, _: &Channel, ack: Ack) {
        self.forward(BrokerEvent::Ack {
            tag: ack.delivery_tag(),
            multiple: ack.mutiple(),
        });
    }

    async fn publish_nack(&mut self, _: &Channel, nack: Nack) {
        self.forward(BrokerEvent::Nack {
            tag: nack.delivery_tag(),
            multiple: nack.multiple(),
        });
    }

    async fn publish_return(
        &mut self,
        _: &Channel,
        _: Return,
        properties: BasicProperties,
        _: Vec<u8>,
    ) {
        self.forward(BrokerEvent::Returned {
            message: properties.message_id().cloned(),
        });
    }
}

/// Runs a call to the broker to completion even if the caller's future is dropped: the client's own tasks fail if a
/// reply has no receiver.
pub(crate) async fn run_to_completion<T: Send + 'static>(
    request: impl Future<Output = AmqpResult<T>> + Send + 'static,
) -> AmqpResult<T> {
    let broke = |_| amqprs::error::Error::InternalChannelError("the client failed".to_owned());
    tokio::spawn(request).await.map_err(broke)?
}

/// Opens a channel and receives its events.
pub(crate) async fn open(
    connection: &Connection,
) -> AmqpResult<(Channel, UnboundedReceiver<BrokerEvent>)> {
    let connection = connection.clone();
    run_to_completion(async move {
        let channel = connection.open_channel(None).await?;
        let (ear, words) = unbounded_channel();
        channel.register_callback(ChannelListener(ear)).await?;
        Ok((channel, words))
    })
    .await
}

/// Enables publisher confirms on a channel.
pub(crate) async fn confirm(channel: &Channel) -> AmqpResult<()> {
    let channel = channel.clone();
    let confirm = ConfirmSelectArguments::new(false);
    run_to_completion(async move { channel.confirm_select(confirm).await }).await
}

/// A queue that is consumed.
pub(crate) struct Consumption {
    pub messages: UnboundedReceiver<ConsumerMessage>,
    /// Number of messages that were in the queue before.
    pub backlog: u32,
}

/// Declares a queue, binds it and consumes it.
pub(crate) async fn consume(
    channel: &Channel,
    queue: QueueDeclareArguments,
    binding: QueueBindArguments,
    prefetch: u16,
    consume: BasicConsumeArguments,
) -> AmqpResult<Consumption> {
    let channel = channel.clone();
    let prefetch = BasicQosArguments::new(0, prefetch, false);
    run_to_completion(async move {
        let declared = channel.queue_declare(queue).await?;
        channel.queue_bind(binding).await?;
        channel.basic_qos(prefetch).await?;
        let (_, messages) = channel.basic_consume_rx(consume).await?;
        Ok(Consumption {
            messages,
            backlog: declared.map_or(0, |(_, messages, _)| messages),
        })
    })
    .await
}

/// Binds a queue.
pub(crate) async fn bind(channel: Channel, binding: QueueBindArguments) -> AmqpResult<()> {
    run_to_completion(async move { channel.queue_bind(binding).await }).await
}

/// Checks that an exchange exists, for which no permission is needed. If it does not, the broker closes the channel.
pub(crate) async fn check_exchange(channel: Channel, exchange: &str) -> AmqpResult<()> {
    let mut arguments = ExchangeDeclareArguments::new(exchange, "topic");
    arguments.passive(true);
    run_to_completion(async move { channel.exchange_declare(arguments).await }).await
}

/// Returns how many messages wait in a queue that exists. The reply comes after all messages that the broker has delivered on
/// this channel.
pub(crate) async fn count_waiting(channel: Channel, queue: &str) -> AmqpResult<u32> {
    let mut arguments = QueueDeclareArguments::new(queue);
    arguments.passive(true);
    run_to_completion(async move {
        let declared = channel.queue_declare(arguments).await?;
        Ok(declared.map_or(0, |(_, messages, _)| messages))
    })
    .await
}

/// Removes all messages from a queue.
pub(crate) async fn purge(connection: &Connection, queue: &str) -> AmqpResult<()> {
    let (channel, _words) = open(connection).await?;
    let queue = QueuePurgeArguments::new(queue);
    run_to_completion(async move { channel.queue_purge(queue).await.map(drop) }).await
}

/// Deletes a queue that has no reader left. If this fails, the queue expires or disappears with its connection.
pub(crate) async fn delete(channel: Channel, queue: &str) {
    let queue = QueueDeleteArguments::new(queue);
    let _ = run_to_completion(async move {
        channel.queue_delete(queue).await?;
        channel.close().await
    })
    .await;
}

/// Sends a harmless request. Its reply proves that the broker has read everything sent before it on this channel.
pub(crate) async fn barrier(channel: Channel) -> AmqpResult<()> {
    let any = BasicQosArguments::new(0, 0, false);
    run_to_completion(async move { channel.basic_qos(any).await }).await
}

/// Returns why a call on the channel failed, with the broker's reason if it gave one.
pub(crate) fn close_reason(events: &mut UnboundedReceiver<BrokerEvent>) -> ChannelError {
    while let Ok(word) = events.try_recv() {
        if let BrokerEvent::Closed { code, reason } = word {
            return ChannelError::closed(code, reason);
        }
    }
    ChannelError::Lost
}

/// Reason why a channel is unusable.
#[derive(Debug, Clone)]
pub(crate) enum ChannelError {
    /// The broker closed the channel.
    Closed { code: u16, reason: String },
    /// The broker closed the channel because an exchange does not exist.
    ExchangeMissing { reason: String },
    /// The broker closed the channel because it cannot reach a queue: its node is down, or the queue is just being deleted.
    QueueUnreachable { reason: String },
    /// A queue being consumed was deleted.
    Cancelled,
    /// The connection was lost.
    Lost,
}

impl ChannelError {
    /// The error of a channel that the broker closed with this code and reason.
    pub(crate) fn closed(code: u16, reason: String) -> Self {
        if code == NOT_FOUND && reason.contains("no exchange") {
            Self::ExchangeMissing { reason }
        } else if code == NOT_FOUND && reason.contains("down or inaccessible") {
            Self::QueueUnreachable { reason }
        } else {
            Self::Closed { code, reason }
        }
    }
}
