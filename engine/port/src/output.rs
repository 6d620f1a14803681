//! Output ports: what a cycle writes waits here until the cycle is committed.

use std::any::Any;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};

use asmotion_connection::{Notifier, PushOutcome};
use asmotion_datum::{DatumError, Message, Sample, Schema};

use crate::connection_id::ConnectionId;
use crate::policy::Policy;
use crate::sender::{AnySender, PortSender, Stamped};
use crate::snapshot::{OutputSnapshot, SampleSnapshot, other_links};
use crate::time::Time;

/// An output port at run time. One thread at a time has it: its component's.
pub struct OutputPort<T> {
    schema: Schema,
    pending: VecDeque<T>,
    links: Vec<(PortSender<T>, OutputLink)>,
    /// Number of the last sample that left.
    sequence: u64,
    /// The last sample that left, for readers to come (RTT `keepLastWrittenValue`).
    last: Option<Stamped<T>>,
}

/// What the writer knows of a connection, or of several that share a queue.
pub struct OutputLink {
    /// The readers inside the system; none for a link to a bus.
    pub readers: Vec<LinkReader>,
    /// The other end's name: `Follower.path`.
    pub to: String,
    /// Whether a sample that is not delivered is a fault of the writer.
    pub mandatory: bool,
    /// The shared queue's position in the table of connections.
    pub queue: Option<usize>,
    /// Samples dropped so far. Counted by the writer's thread; readers outside of the system may look at it.
    pub dropped: Arc<AtomicU64>,
}

/// The reading end of a connection, as the writer knows it.
pub struct LinkReader {
    /// Ends with this connection.
    pub connection: ConnectionId,
    /// How the reader learns of a new sample.
    pub notification: Notification,
}

/// How a reader learns that there is something to read.
pub enum Notification {
    /// It looks by itself.
    Silent,
    /// The component at this position of the system is triggered.
    Trigger(usize),
    /// A thread outside of the system is woken, as long as its reader exists.
    Notify(Weak<Notifier>),
}

/// What follows from the samples that leave an output port. The runtime turns these into events and triggers.
pub trait PortEffects {
    /// The next position among all samples of the run.
    fn next_order(&mut self) -> u64;

    /// A sample leaves; `sequence` is its number at this port, from 1, without gaps.
    fn published(&mut self, sequence: u64, sample: &dyn Sample);

    /// Something new is there for the component at this position of the system.
    fn trigger(&mut self, component: usize);

    /// A connection was full, or could not carry the sample for this reason. `total` counts all that it has dropped.
    fn dropped(&mut self, to: &str, total: u64, reason: Option<&DatumError>);
}

/// A mandatory connection was full, or could not carry the sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Undelivered {
    /// The connection's other end.
    pub to: String,
}

impl<T: Message> OutputPort<T> {
    /// A port without connections. `schema` is the declared one, which a message type known at run time only needs.
    pub fn new(schema: Schema) -> Self {
        Self {
            schema,
            pending: VecDeque::new(),
            links: Vec::new(),
            sequence: 0,
            last: None,
        }
    }

    /// Keeps a sample until the cycle is committed.
    pub fn write(&mut self, sample: T) {
        self.pending.push_back(sample);
    }

    /// Sends one sample through every connection.
    fn deliver(
        &mut self,
        sample: T,
        now: Time,
        effects: &mut dyn PortEffects,
    ) -> Result<(), Undelivered> {
        self.links.retain(|(_, link)| link.is_there());
        let sample = self.last.insert(Stamped {
            at: now,
            order: effects.next_order(),
            value: sample,
        });
        let mut result = Ok(());
        for (sender, link) in &mut self.links {
            let delivery = sender.send(sample);
            result = result.and(link.settle(&delivery, effects));
        }
        result
    }
}

impl OutputLink {
    /// A link to something outside of the system, which no trigger reaches: a bus, a message queue.
    pub fn to_outside(to: String) -> Self {
        Self {
            readers: Vec::new(),
            to,
            mandatory: false,
            queue: None,
            dropped: Arc::default(),
        }
    }

    /// A link to a reader outside of the system, and the notifier that its thread waits on.
    pub fn to_reader(connection: ConnectionId, policy: &Policy) -> (Arc<Notifier>, Self) {
        let notifier = Arc::new(Notifier::new());
        let notification = Notification::Notify(Arc::downgrade(&notifier));
        let link = Self {
            readers: vec![LinkReader {
                connection,
                notification,
            }],
            mandatory: policy.mandatory,
            ..Self::to_outside("a reader outside".to_owned())
        };
        (notifier, link)
    }

    /// Returns whether all readers are components of the system.
    pub fn is_inside(&self) -> bool {
        let inside = |reader: &LinkReader| match &reader.notification {
            Notification::Silent | Notification::Trigger(_) => true,
            Notification::Notify(_) => false,
        };
        !self.readers.is_empty() && self.readers.iter().all(inside)
    }

    /// Whether anything may still read.
    fn is_there(&self) -> bool {
        let gone = |reader: &LinkReader| match &reader.notification {
            Notification::Notify(notifier) => notifier.strong_count() == 0,
            Notification::Silent | Notification::Trigger(_) => false,
        };
        self.readers.is_empty() || !self.readers.iter().all(gone)
    }

    fn notify(&self, trigger: &mut dyn FnMut(usize)) {
        for reader in &self.readers {
            match &reader.notification {
                Notification::Silent => {}
                Notification::Trigger(component) => trigger(*component),
                Notification::Notify(notifier) => {
                    if let Some(notifier) = notifier.upgrade() {
                        notifier.notify();
                    }
                }
            }
        }
    }

    /// Draws the consequences of a delivery.
    fn settle(
        &self,
        delivery: &Result<PushOutcome, DatumError>,
        effects: &mut dyn PortEffects,
    ) -> Result<(), Undelivered> {
        let stored = matches!(
            delivery,
            Ok(PushOutcome::Stored | PushOutcome::DroppedOldest)
        );
        if stored {
            self.notify(&mut |component| effects.trigger(component));
        }
        if *delivery == Ok(PushOutcome::Stored) {
            return Ok(());
        }
        let total = self.dropped.fetch_add(1, Ordering::Relaxed) + 1;
        effects.dropped(&self.to, total, delivery.as_ref().err());
        if stored || !self.mandatory {
            return Ok(());
        }
        Err(Undelivered {
            to: self.to.clone(),
        })
    }
}

/// An output port whose message type the caller does not know.
pub trait AnyOutput: Any + Send {
    /// Name and shape of its messages.
    fn schema(&self) -> &Schema;

    /// Adds a connection.
    fn join(&mut self, sender: Box<dyn AnySender>, link: OutputLink);

    /// Sends the last written sample to a reader that is new (RTT `init`), and triggers it.
    fn replay_last(&mut self, connection: ConnectionId, trigger: &mut dyn FnMut(usize));

    /// Ends a connection.
    fn disconnect(&mut self, connection: ConnectionId);

    /// Sends the oldest pending sample.
    ///
    /// # Errors
    /// A mandatory connection did not take it. The others have.
    fn flush(&mut self, now: Time, effects: &mut dyn PortEffects) -> Result<(), Undelivered>;

    /// Forgets what is pending: the cycle failed.
    fn discard(&mut self);

    /// What the port holds between two cycles, when nothing is pending.
    ///
    /// # Errors
    /// A sample has no form as data.
    fn snapshot(&self) -> Result<OutputSnapshot, DatumError>;

    /// Takes over what a port of the same connections held.
    ///
    /// # Errors
    /// A sample is of another type, or the port has other connections; the port is then as it was.
    fn restore(&mut self, snapshot: &OutputSnapshot) -> Result<(), DatumError>;

    /// Sends again what waited in a connection, without effects. Returns whether the connection leads from here.
    ///
    /// # Errors
    /// A sample is of another type than the connection's reader.
    fn refill(
        &mut self,
        connection: ConnectionId,
        waiting: &[SampleSnapshot],
    ) -> Result<bool, DatumError>;

    /// The links, in order.
    fn links(&self) -> Vec<&OutputLink>;
}

impl<T: Message> AnyOutput for OutputPort<T> {
    fn schema(&self) -> &Schema {
        &self.schema
    }

    fn join(&mut self, sender: Box<dyn AnySender>, link: OutputLink) {
        let known = (self.links.iter_mut())
            .find(|(_, known)| link.queue.is_some() && known.queue == link.queue);
        match known {
            Some((_, known)) => known.readers.extend(link.readers),
            None => self
                .links
                .extend(PortSender::of(sender).map(|sender| (sender, link))),
        }
    }

    fn replay_last(&mut self, connection: ConnectionId, trigger: &mut dyn FnMut(usize)) {
        let new =
            |link: &OutputLink| (link.readers.iter()).any(|reader| reader.connection == connection);
        let link = self.links.iter_mut().find(|(_, link)| new(link));
        if let (Some((sender, link)), Some(last)) = (link, &self.last)
            && sender.send(last) == Ok(PushOutcome::Stored)
        {
            link.notify(trigger);
        }
    }

    fn disconnect(&mut self, connection: ConnectionId) {
        self.links.retain_mut(|(_, link)| {
            let before = link.readers.len();
            link.readers
                .retain(|reader| reader.connection != connection);
            let lost = link.readers.len() < before;
            !(lost && link.readers.is_empty())
        });
    }

    fn flush(&mut self, now: Time, effects: &mut dyn PortEffects) -> Result<(), Undelivered> {
        let Some(sample) = self.pending.pop_front() else {
            return Ok(());
        };
        self.sequence += 1;
        effects.published(self.sequence, &sample);
        self.deliver(sample, now, effects)
    }

    fn discard(&mut self) {
        self.pending.clear();
    }

    fn snapshot(&self) -> Result<OutputSnapshot, DatumError> {
        let last = self.last.iter().map(SampleSnapshot::of);
        let dropped = self.links.iter();
        Ok(OutputSnapshot {
            sequence: self.sequence,
            last: last.collect::<Result<_, _>>()?,
            dropped: dropped
                .map(|(_, link)| link.dropped.load(Ordering::Relaxed))
                .collect(),
        })
    }

    fn restore(&mut self, snapshot: &OutputSnapshot) -> Result<(), DatumError> {
        if snapshot.dropped.len() != self.links.len() {
            return Err(other_links());
        }
        let last = snapshot.last.first().map(|last| {
            Ok::<_, DatumError>(Stamped {
                at: last.at,
                order: last.order,
                value: last.value.to()?,
            })
        });
        self.last = last.transpose()?;
        self.sequence = snapshot.sequence;
        for ((_, link), dropped) in self.links.iter().zip(&snapshot.dropped) {
            link.dropped.store(*dropped, Ordering::Relaxed);
        }
        self.pending.clear();
        Ok(())
    }

    fn refill(
        &mut self,
        connection: ConnectionId,
        waiting: &[SampleSnapshot],
    ) -> Result<bool, DatumError> {
        let leads = |link: &OutputLink| link.readers.iter().any(|it| it.connection == connection);
        let Some((sender, _)) = self.links.iter_mut().find(|(_, link)| leads(link)) else {
            return Ok(false);
        };
        for sample in waiting {
            // as data: the reader may have another type than this port
            let value = Arc::new(sample.value.clone());
            match sender {
                PortSender::Same(sender) => sender.send_sample(value, sample.at, sample.order),
                PortSender::Shared(sender) => sender.send_sample(value, sample.at, sample.order),
            }?;
        }
        Ok(true)
    }

    fn links(&self) -> Vec<&OutputLink> {
        self.links.iter().map(|(_, link)| link).collect()
    }
}
