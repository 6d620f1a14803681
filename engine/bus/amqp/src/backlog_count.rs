//! The number of messages that wait in a queue while it is consumed.

use std::pin::Pin;

use amqprs::channel::Channel;

use crate::channel::{self, AmqpResult};

type Request = Pin<Box<dyn Future<Output = AmqpResult<u32>> + Send>>;

/// Asks for the number of messages in a queue, one request at a time.
#[derive(Default)]
pub(crate) struct BacklogCount {
    /// The request on its way.
    request: Option<Request>,
    /// The request after it.
    next: Option<Request>,
}

impl BacklogCount {
    /// Asks for the number of messages in a queue that is consumed on this channel now.
    pub(crate) fn begin(&mut self, channel: &Channel, queue: &str) {
        let (channel, queue) = (channel.clone(), queue.to_owned());
        let request: Request =
            Box::pin(async move { channel::count_waiting(channel, &queue).await });
        // the client fails on two requests of one kind on a channel; the broker may have counted for the one on its way before
        // the messages of which the number is asked now
        if self.request.is_some() {
            self.next = Some(request);
        } else {
            self.request = Some(request);
        }
    }

    /// Waits for the reply to the last request, for ever if there is none. Can be dropped and called again without losing a reply.
    pub(crate) async fn reply(&mut self) -> AmqpResult<u32> {
        loop {
            let Some(request) = &mut self.request else {
                return std::future::pending().await;
            };
            let reply = request.await;
            self.request = self.next.take();
            if reply.is_err() || self.request.is_none() {
                return reply;
            }
        }
    }

    /// Waits for the end of the request on its way, if there is one.
    pub(crate) async fn finish(&mut self) {
        self.next = None;
        if self.request.is_some() {
            let _ = self.reply().await;
        }
    }
}
