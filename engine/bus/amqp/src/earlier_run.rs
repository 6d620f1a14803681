//! The event queue that an earlier run of a process has left at the broker.
//!
//! In a process that [returns](crate::AmqpSettings::returns), the event queue of a port has the same name in every run. A run
//! that has crashed leaves its queue, which the broker keeps for a while and fills. The next run takes it over: what waits in
//! it was sent before this run began, so it is discarded and counted, and never delivered. Emptying the queue, instead of
//! deleting it, loses no message that comes afterwards.

use std::time::Duration;

use amqprs::channel::{QueueDeclareArguments, QueueDeleteArguments, QueuePurgeArguments};
use amqprs::connection::Connection;
use tokio::time::{Instant, sleep};

use crate::channel::{self, ChannelError, LOCKED, PRECONDITION_FAILED};

/// Interval at which a queue with a consumer is examined.
const LOOK: Duration = Duration::from_millis(20);

/// Outcome of taking a queue over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Takeover {
    /// The queue has no consumer, and this number of messages were discarded.
    Emptied(u32),
    /// Another process consumes the queue, or the broker cannot reach it.
    InUse,
}

/// Takes a queue over: declares and empties it, unless it has a consumer for longer than `patience`. The consumer of a process
/// that has been killed disappears when the broker notices the end of its connection.
///
/// # Errors
/// The broker refuses it, or the connection was lost.
pub(crate) async fn take_over(
    connection: &Connection,
    (queue, declare): (&str, &QueueDeclareArguments),
    patience: Duration,
) -> Result<Takeover, ChannelError> {
    let until = Instant::now() + patience;
    loop {
        let taken = try_take_over(connection, queue, declare.clone()).await?;
        if taken != Takeover::InUse || Instant::now() >= until {
            return Ok(taken);
        }
        sleep(LOOK).await;
    }
}

async fn try_take_over(
    connection: &Connection,
    queue: &str,
    declare: QueueDeclareArguments,
) -> Result<Takeover, ChannelError> {
    let (channel, mut words) = channel::open(connection)
        .await
        .map_err(|_| ChannelError::Lost)?;
    let purge = QueuePurgeArguments::new(queue);
    let taken = channel::run_to_completion(async move {
        let declared = channel.queue_declare(declare).await?;
        let taken = match declared {
            Some((_, _, 1..)) => Takeover::InUse,
            Some((_, _, 0)) | None => {
                Takeover::Emptied(channel.queue_purge(purge).await?.unwrap_or_default())
            }
        };
        channel.close().await?;
        Ok(taken)
    });
    match taken.await {
        Ok(taken) => Ok(taken),
        Err(_) => match channel::close_reason(&mut words) {
            // the queue of an earlier version of the composite
            ChannelError::Closed { code, .. } if code == PRECONDITION_FAILED => {
                delete(connection, queue).await
            }
            ChannelError::Closed { code, .. } if code == LOCKED => Ok(Takeover::InUse),
            // its last consumer is deleting it, or its node is down
            ChannelError::QueueUnreachable { .. } => Ok(Takeover::InUse),
            error @ (ChannelError::Closed { .. }
            | ChannelError::ExchangeMissing { .. }
            | ChannelError::Cancelled
            | ChannelError::Lost) => Err(error),
        },
    }
}

/// Deletes a queue without a consumer, whose length or policy was another one.
async fn delete(connection: &Connection, queue: &str) -> Result<Takeover, ChannelError> {
    let (channel, mut words) = channel::open(connection)
        .await
        .map_err(|_| ChannelError::Lost)?;
    let mut unused = QueueDeleteArguments::new(queue);
    unused.if_unused(true);
    let deleted = channel::run_to_completion(async move {
        let deleted = channel.queue_delete(unused).await?;
        channel.close().await?;
        Ok(deleted)
    });
    match deleted.await {
        Ok(deleted) => Ok(Takeover::Emptied(deleted.unwrap_or_default())),
        Err(_) => match channel::close_reason(&mut words) {
            ChannelError::Closed { code, .. } if code == PRECONDITION_FAILED => Ok(Takeover::InUse),
            ChannelError::QueueUnreachable { .. } => Ok(Takeover::InUse),
            error @ (ChannelError::Closed { .. }
            | ChannelError::ExchangeMissing { .. }
            | ChannelError::Cancelled
            | ChannelError::Lost) => Err(error),
        },
    }
}
