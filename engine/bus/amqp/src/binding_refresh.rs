//! Binds a queue again at intervals.
//!
//! A binding disappears with its exchange, without a message to the consumers of the queue, and another process may have
//! declared the exchange again before this one notices. Binding a queue that is bound already changes nothing.

use std::pin::Pin;
use std::time::Duration;

use amqprs::channel::{Channel, QueueBindArguments};
use tokio::time::{Instant, sleep_until};

use crate::channel::{self, AmqpResult};

/// Interval at which a queue is bound again.
const INTERVAL: Duration = Duration::from_secs(1);

/// Keeps one queue bound.
pub(crate) struct BindingRefresh {
    channel: Channel,
    binding: QueueBindArguments,
    due: Instant,
    /// The request on its way.
    request: Option<Pin<Box<dyn Future<Output = AmqpResult<()>> + Send>>>,
}

impl BindingRefresh {
    /// Keeps a queue bound that has just been bound on this channel.
    pub(crate) fn new(channel: &Channel, binding: QueueBindArguments) -> Self {
        Self {
            channel: channel.clone(),
            binding,
            due: Instant::now() + INTERVAL,
            request: None,
        }
    }

    /// Binds the queue again when that is due. Can be dropped and called again without losing a reply.
    pub(crate) async fn refresh(&mut self) -> AmqpResult<()> {
        if self.request.is_none() {
            sleep_until(self.due).await;
            self.due = Instant::now() + INTERVAL;
            let bind = channel::bind(self.channel.clone(), self.binding.clone());
            self.request = Some(Box::pin(bind));
        }
        self.finish().await
    }

    /// Waits for the reply to the request on its way, if there is one.
    pub(crate) async fn finish(&mut self) -> AmqpResult<()> {
        let Some(request) = &mut self.request else {
            return Ok(());
        };
        let end = request.await;
        self.request = None;
        end
    }
}
