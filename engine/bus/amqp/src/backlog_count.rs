//! The number of messages that wait in a queue while it is consumed.

use std::pin::Pin;

use amqprs::channel::Channel;

use crate::channel::{self, AmqpResult};

/// Asks for the number of messages in a queue, one request at a time.
#[derive(Default)]
pub(crate) struct BacklogCount {
    /// The request on its way.
    request: Option<Pin<Box<dyn Future<Output = AmqpResult<u32>> + Send>>>,
}

impl BacklogCount {
    /// Asks for the number of messages in a queue that is consumed on this channel, unless a request is on its way.
    pub(crate) fn begin(&mut self, channel: &Channel, queue: &str) {
        // the client fails on two requests of one kind on a channel
        if self.request.is_some() {
            return;
        }
        let (channel, queue) = (channel.clone(), queue.to_owned());
        let request = async move { channel::count_waiting(channel, &queue).await };
        self.request = Some(Box::pin(request));
    }

    /// Waits for the reply to the request on its way, for ever if there is none. Can be dropped and called again without losing
    /// a reply.
    pub(crate) async fn reply(&mut self) -> AmqpResult<u32> {
        let Some(request) = &mut self.request else {
            return std::future::pending().await;
        };
        let reply = request.await;
        self.request = None;
        reply
    }

    /// Waits for the end of the request on its way, if there is one.
    pub(crate) async fn finish(&mut self) {
        if self.request.is_some() {
            let _ = self.reply().await;
        }
    }
}
