//! Output ports: what a cycle writes waits here until the cycle is committed.

use std::any::Any;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use datum::{DatumError, Message, Sample, Schema};

use super::AnySender;
use crate::connection::{Delivery, Sender, Stamped};
use crate::outside::Leaving;
use crate::{Event, Fault, Time};

/// An output port at run time.
pub(crate) struct Output<T> {
    schema: Schema,
    pending: VecDeque<T>,
    links: Vec<(Way<T>, Link)>,
    /// Number of the last sample that left.
    sequence: u64,
}

/// How samples get into a connection.
enum Way<T> {
    /// The reader has the same type: the sample itself.
    Same(Sender<T>),
    /// The reader has another type, or is a bus: the sample behind a pointer, for the other end to read.
    Shared(Box<dyn AnySender>),
}

/// What the writer knows of a connection.
pub(crate) struct Link {
    /// The reader's place in the system.
    pub reader: usize,
    /// The other end's name: `Follower.path`.
    pub to: String,
    /// Whether samples trigger the reader.
    pub trigger: bool,
    pub mandatory: bool,
    pub dropped: Arc<AtomicU64>,
}

impl<T: Message> Output<T> {
    pub(crate) fn new(schema: Schema) -> Self {
        Self {
            schema,
            pending: VecDeque::new(),
            links: Vec::new(),
            sequence: 0,
        }
    }

    pub(crate) fn write(&mut self, sample: T) {
        self.pending.push_back(sample);
    }

    /// Sends one sample through every connection; the last one gets the original, the others get copies.
    fn deliver(&mut self, sample: T, port: &str, leaving: &mut Leaving<'_>) -> Result<(), Fault> {
        let mut result = Ok(());
        let Some((last, others)) = self.links.split_last_mut() else {
            return result;
        };
        let at = leaving.now;
        let order = leaving.outside.next_order();
        for (way, link) in others {
            let delivery = way.copy(&sample, at, order);
            result = result.and(link.settle(delivery, port, leaving));
        }
        let (way, link) = last;
        let delivery = way.hand_over(sample, at, order);
        result.and(link.settle(delivery, port, leaving))
    }
}

impl<T: Message> Way<T> {
    fn copy(&mut self, sample: &T, at: Time, order: u64) -> Result<Delivery, DatumError> {
        match self {
            Self::Same(sender) => Ok(sender.send(Stamped {
                at,
                order,
                value: sample.clone(),
            })),
            Self::Shared(sender) => sender.send_sample(sample.to_shared(), at, order),
        }
    }

    fn hand_over(&mut self, value: T, at: Time, order: u64) -> Result<Delivery, DatumError> {
        match self {
            Self::Same(sender) => Ok(sender.send(Stamped { at, order, value })),
            Self::Shared(sender) => sender.send_sample(Arc::new(value), at, order),
        }
    }
}

impl Link {
    /// To a bus: nobody inside is triggered.
    pub(crate) fn to_bus(to: String) -> Self {
        Self {
            reader: usize::MAX,
            to,
            trigger: false,
            mandatory: false,
            dropped: Arc::default(),
        }
    }

    /// Draws the consequences of a delivery.
    fn settle(
        &self,
        delivery: Result<Delivery, DatumError>,
        port: &str,
        leaving: &mut Leaving<'_>,
    ) -> Result<(), Fault> {
        let stored = !matches!(delivery, Ok(Delivery::DroppedNewest) | Err(_));
        if stored && self.trigger {
            leaving.outside.trigger(self.reader);
        }
        if delivery == Ok(Delivery::Stored) {
            return Ok(());
        }
        let total = self.dropped.fetch_add(1, Ordering::Relaxed) + 1;
        leaving.emit(&Event::Dropped {
            component: leaving.name,
            port,
            to: &self.to,
            total,
            reason: delivery.as_ref().err(),
        });
        if !self.mandatory {
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
        let same = (&*sender as &dyn Any).is::<Sender<T>>();
        let way = if same {
            (sender as Box<dyn Any>)
                .downcast()
                .map(|sender| Way::Same(*sender))
                .ok()
        } else {
            Some(Way::Shared(sender))
        };
        self.links.extend(way.map(|way| (way, link)));
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
