//! Publishers.

use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_datum::{Codec, Datum, Schema};

use crate::error::SendError;
use crate::gid::Gid;
use crate::graph::Graph;
use crate::outbox::{Outbox, PublisherCounts};
use crate::participant::Inner;

/// Sends messages to a topic.
pub struct Publisher {
    pub(crate) inner: Arc<Inner>,
    pub(crate) outbox: Arc<Outbox>,
    pub(crate) schema: Schema,
}

impl Publisher {
    /// Sends a message. Never waits: a message that DDS does not take at once is put into a queue, which drops and counts the
    /// oldest when it is full.
    ///
    /// # Errors
    /// The datum does not fit the type, or DDS refuses the message.
    pub fn send(&self, message: &Datum) -> Result<(), SendError> {
        let bytes = Codec::Cdr.encode(message, &self.schema)?;
        self.outbox.send(bytes.into(), None)?;
        if self.outbox.counts().waiting == 0 {
            return Ok(());
        }
        self.inner.reactor.wake();
        Ok(())
    }

    /// Number of subscriptions that match.
    pub fn matches(&self) -> usize {
        self.inner.graph.lock().matches(self.outbox.gid)
    }

    /// Waits until this many subscriptions match, at most for `longest`; returns whether they do.
    pub fn wait_for_matches(&self, count: usize, longest: Duration) -> bool {
        let gid = self.outbox.gid;
        let enough = |graph: &Graph| graph.matches(gid) >= count;
        self.inner.graph.wait(longest, enough)
    }

    /// Waits until the messages sent so far have left, and reliable subscriptions have acknowledged them, at most until this time.
    /// Returns whether they have.
    pub fn drain(&self, until: Instant) -> bool {
        self.outbox.drain(until)
    }

    /// The numbers of messages.
    pub fn counts(&self) -> PublisherCounts {
        self.outbox.counts()
    }

    /// The id of the writer.
    pub fn gid(&self) -> Gid {
        self.outbox.gid
    }
}

impl Drop for Publisher {
    fn drop(&mut self) {
        self.inner.forget(self.outbox.gid);
    }
}
