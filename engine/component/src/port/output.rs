//! Output ports: what a cycle writes waits here until the cycle is committed.

use std::any::Any;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};

use asmotion_bus::Bell;
use asmotion_connection::Delivery;
use asmotion_datum::{DatumError, Message, Sample, Schema};

use super::channel::Stamped;
use super::{AnySender, Outlet};
use crate::outside::{Leaving, Outside};
use crate::system::ConnectionId;
use crate::{Event, Fault, Policy};

/// An output port at run time.
pub(crate) struct Output<T> {
    schema: Schema,
    pending: VecDeque<T>,
    links: Vec<(Outlet<T>, Link)>,
    /// Number of the last sample that left.
    sequence: u64,
    /// The last sample that left, for readers to come (RTT `keepLastWrittenValue`).
    last: Option<Stamped<T>>,
}

/// What the writer knows of a connection, or of several that have a queue in common.
pub(crate) struct Link {
    /// Who may read; nobody inside, for a link to a bus.
    pub readers: Vec<Reader>,
    /// The other end's name: `Follower.path`.
    pub to: String,
    pub mandatory: bool,
    /// The queue, if it is one that connections have in common.
    pub queue: Option<usize>,
    pub dropped: Arc<AtomicU64>,
}

/// The reading end of a connection, as the writer knows it.
pub(crate) struct Reader {
    pub connection: ConnectionId,
    pub news: News,
}

/// How a reader learns that there is something to read.
pub(crate) enum News {
    /// It looks by itself.
    Silent,
    /// The component at this place of the system is triggered.
    Trigger(usize),
    /// Somebody outside listens, as long as somebody is there.
    Bell(Weak<Bell>),
}

impl<T: Message> Output<T> {
    pub(crate) fn new(schema: Schema) -> Self {
        Self {
            schema,
            pending: VecDeque::new(),
            links: Vec::new(),
            sequence: 0,
            last: None,
        }
    }

    pub(crate) fn write(&mut self, sample: T) {
        self.pending.push_back(sample);
    }

    /// Sends one sample through every connection.
    fn deliver(&mut self, sample: T, port: &str, leaving: &mut Leaving<'_>) -> Result<(), Fault> {
        self.links.retain(|(_, link)| link.is_there());
        let sample = self.last.insert(Stamped {
            at: leaving.now,
            order: leaving.outside.next_order(),
            value: sample,
        });
        let mut result = Ok(());
        for (outlet, link) in &mut self.links {
            let delivery = outlet.send(sample);
            result = result.and(link.settle(delivery, port, leaving));
        }
        result
    }
}

impl Link {
    /// To a bus: nobody inside is triggered.
    pub(crate) fn to_bus(to: String) -> Self {
        Self {
            readers: Vec::new(),
            to,
            mandatory: false,
            queue: None,
            dropped: Arc::default(),
        }
    }

    /// To a reader outside of the system, and the bell that is rung for it.
    pub(crate) fn to_outside(connection: ConnectionId, policy: &Policy) -> (Arc<Bell>, Self) {
        let bell = Arc::new(Bell::new());
        let news = News::Bell(Arc::downgrade(&bell));
        let link = Self {
            readers: vec![Reader { connection, news }],
            mandatory: policy.mandatory,
            ..Self::to_bus("a reader outside".to_owned())
        };
        (bell, link)
    }

    /// Whether anybody may still read.
    fn is_there(&self) -> bool {
        let gone = |reader: &Reader| match &reader.news {
            News::Bell(bell) => bell.strong_count() == 0,
            News::Silent | News::Trigger(_) => false,
        };
        self.readers.is_empty() || !self.readers.iter().all(gone)
    }

    /// Tells the readers that there is something.
    fn tell(&self, outside: &mut dyn Outside) {
        for reader in &self.readers {
            match &reader.news {
                News::Silent => {}
                News::Trigger(component) => outside.trigger(*component),
                News::Bell(bell) => {
                    if let Some(bell) = bell.upgrade() {
                        bell.ring();
                    }
                }
            }
        }
    }

    /// Draws the consequences of a delivery.
    fn settle(
        &self,
        delivery: Result<Delivery, DatumError>,
        port: &str,
        leaving: &mut Leaving<'_>,
    ) -> Result<(), Fault> {
        if delivery == Ok(Delivery::Stored) {
            self.tell(leaving.outside);
            return Ok(());
        }
        let stored = delivery == Ok(Delivery::DroppedOldest);
        if stored {
            self.tell(leaving.outside);
        }
        let total = self.dropped.fetch_add(1, Ordering::Relaxed) + 1;
        leaving.emit(&Event::Dropped {
            component: leaving.name,
            port,
            to: &self.to,
            total,
            reason: delivery.as_ref().err(),
        });
        if stored || !self.mandatory {
            return Ok(());
        }
        Err(Fault::NotDelivered {
            port: port.to_owned(),
            to: self.to.clone(),
        })
    }
}

/// An output port whose type is not known here.
pub(crate) trait AnyOutput: Any + Send {
    /// Name and shape of what it gives.
    fn schema(&self) -> &Schema;

    /// Joins it to a way into an input port.
    fn join(&mut self, sender: Box<dyn AnySender>, link: Link);

    /// Sends what was last written to a reader that is new (RTT `init`).
    fn greet(&mut self, connection: ConnectionId, outside: &mut dyn Outside);

    /// Ends a connection.
    fn part(&mut self, connection: ConnectionId);

    /// Sends the oldest pending sample.
    fn flush(
        &mut self,
        port: &str,
        topic: Option<&str>,
        leaving: &mut Leaving<'_>,
    ) -> Result<(), Fault>;

    /// Forgets what is pending: the cycle failed.
    fn discard(&mut self);
}

impl<T: Message> AnyOutput for Output<T> {
    fn schema(&self) -> &Schema {
        &self.schema
    }

    fn join(&mut self, sender: Box<dyn AnySender>, link: Link) {
        let known = (self.links.iter_mut())
            .find(|(_, known)| link.queue.is_some() && known.queue == link.queue);
        match known {
            Some((_, known)) => known.readers.extend(link.readers),
            None => self
                .links
                .extend(Outlet::of(sender).map(|outlet| (outlet, link))),
        }
    }

    fn greet(&mut self, connection: ConnectionId, outside: &mut dyn Outside) {
        let new = |link: &Link| (link.readers.iter()).any(|reader| reader.connection == connection);
        let link = self.links.iter_mut().find(|(_, link)| new(link));
        if let (Some((outlet, link)), Some(last)) = (link, &self.last)
            && outlet.send(last) == Ok(Delivery::Stored)
        {
            link.tell(outside);
        }
    }

    fn part(&mut self, connection: ConnectionId) {
        self.links.retain_mut(|(_, link)| {
            let before = link.readers.len();
            link.readers
                .retain(|reader| reader.connection != connection);
            let lost = link.readers.len() < before;
            !(lost && link.readers.is_empty())
        });
    }

    fn flush(
        &mut self,
        port: &str,
        topic: Option<&str>,
        leaving: &mut Leaving<'_>,
    ) -> Result<(), Fault> {
        let Some(sample) = self.pending.pop_front() else {
            return Ok(());
        };
        self.sequence += 1;
        leaving.emit(&Event::Published {
            component: leaving.name,
            port,
            topic,
            sequence: self.sequence,
            sample: &sample as &dyn Sample,
        });
        self.deliver(sample, port, leaving)
    }

    fn discard(&mut self) {
        self.pending.clear();
    }
}
