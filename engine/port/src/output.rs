//! Output ports: the samples of a cycle wait here until the cycle is committed.

use std::any::Any;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};
use std::time::Duration;

use asmotion_connection::{Notifier, PushOutcome, prefetch};
use asmotion_datum::{Datum, DatumError, Message, Sample, Schema};

use crate::connection_id::ConnectionId;
use crate::loss_counter::LossCounter;
use crate::policy::Policy;
use crate::sender::{AnySender, PortSender, Stamped};
use crate::snapshot::{OutputSnapshot, SampleSnapshot, links_mismatch};
use crate::time::Time;

/// An output port at run time. Used by its component's thread only.
pub struct OutputPort<T> {
    schema: Schema,
    pending: VecDeque<PendingSample<T>>,
    links: Vec<(PortSender<T>, OutputLink)>,
    /// Number of the last sample that was sent.
    sequence: u64,
    /// The last sample that was sent, for new readers (RTT `keepLastWrittenValue`).
    last: Option<Stamped<T>>,
    /// The sample to write after the component's last cycle.
    safe: Option<T>,
}

/// Number of connections up to which a port has memory for no more than it has.
const FEW_LINKS: usize = 4;

/// A sample of a cycle that is not committed yet.
struct PendingSample<T> {
    value: T,
    age: Duration,
}

impl<T> PendingSample<T> {
    fn new(value: T) -> Self {
        let age = Duration::ZERO;
        Self { value, age }
    }
}

/// The writer's record of a connection, or of several that share a queue.
pub struct OutputLink {
    /// The readers inside the system; empty for a link to a bus.
    pub readers: Vec<LinkReader>,
    /// Name of the reading end, for example `Follower.path`.
    pub to: String,
    /// `true` if a sample that cannot be delivered is a fault of the writer.
    pub mandatory: bool,
    /// Position of the shared queue in the connection table; `None` for a queue of its own.
    pub queue: Option<usize>,
    /// Number of samples dropped so far. Written by the writer's thread; readers outside the system may read it.
    pub dropped: Arc<AtomicU64>,
}

/// The writer's record of a reader.
pub struct LinkReader {
    /// The connection; the record is removed with it.
    pub connection: ConnectionId,
    /// The way in which the reader is notified of a new sample.
    pub notification: Notification,
    /// The reader's counter of lost messages.
    pub losses: LossCounter,
}

/// The way in which a reader is notified of a new sample.
pub enum Notification {
    /// Not at all: the reader polls.
    Silent,
    /// The component at this position of the system is triggered.
    Trigger(usize),
    /// A thread outside the system is woken. The reference is weak, so it ends with the reader.
    Notify(Weak<Notifier>),
}

/// The effects of samples that leave an output port, which the runtime turns into events and triggers.
pub trait PortEffects {
    /// Returns the next order number among all samples of the run.
    fn next_order(&mut self) -> u64;

    /// Reports a sample that leaves; `sequence` is its number at this port, from 1, without gaps.
    fn published(&mut self, sequence: u64, sample: &dyn Sample);

    /// Signals new data for the component at this position of the system.
    fn trigger(&mut self, component: usize);

    /// Reports a dropped sample. `reason` is `None` if the connection was full; `total` counts all samples that the
    /// connection has dropped.
    fn dropped(&mut self, to: &str, total: u64, reason: Option<&DatumError>);
}

/// A mandatory connection was full, or could not carry the sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Undelivered {
    /// Name of the connection's reading end.
    pub to: String,
}

impl<T: Message> OutputPort<T> {
    /// Creates a port without connections. `schema` differs from `T`'s own only if the message type is known at run
    /// time.
    pub fn new(schema: Schema) -> Self {
        Self {
            schema,
            pending: VecDeque::new(),
            links: Vec::new(),
            sequence: 0,
            last: None,
            safe: None,
        }
    }

    /// Queues a sample until the cycle is committed.
    pub fn write(&mut self, sample: T) {
        self.pending.push_back(PendingSample::new(sample));
    }

    /// Queues a sample that is this old already. Age limits of connections count its age.
    pub fn write_aged(&mut self, sample: T, age: Duration) {
        let value = sample;
        self.pending.push_back(PendingSample { value, age });
    }

    /// Sends one sample, written at this time, through every connection.
    fn deliver(
        &mut self,
        sample: T,
        at: Time,
        effects: &mut dyn PortEffects,
    ) -> Result<(), Undelivered> {
        self.links.retain(|(_, link)| link.may_have_reader());
        let sample = self.last.insert(Stamped {
            at,
            order: effects.next_order(),
            value: sample,
        });
        let mut result = Ok(());
        for (sender, link) in &mut self.links {
            let delivery = sender.send(sample);
            result = result.and(link.handle_outcome(&delivery, effects));
        }
        result
    }
}

impl OutputLink {
    /// A link out of the system, for example to a bus or a message queue; nothing is triggered there.
    pub fn external(to: String) -> Self {
        Self {
            readers: Vec::new(),
            to,
            mandatory: false,
            queue: None,
            dropped: Arc::default(),
        }
    }

    /// A link to a reader outside the system, and the notifier that its thread waits for.
    pub fn external_reader(connection: ConnectionId, policy: &Policy) -> (Arc<Notifier>, Self) {
        let notifier = Arc::new(Notifier::new());
        let notification = Notification::Notify(Arc::downgrade(&notifier));
        let link = Self {
            readers: vec![LinkReader {
                connection,
                notification,
                losses: LossCounter::default(),
            }],
            mandatory: policy.mandatory,
            ..Self::external("a reader outside".to_owned())
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

    /// Returns whether the link leads out of the system, to the end with this name.
    fn is_outside(&self, to: &str) -> bool {
        self.readers.is_empty() && self.to == to
    }

    /// Returns whether a reader may still exist.
    fn may_have_reader(&self) -> bool {
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

    /// Handles the outcome of a delivery: notifies readers, counts and reports drops.
    fn handle_outcome(
        &self,
        outcome: &Result<PushOutcome, DatumError>,
        effects: &mut dyn PortEffects,
    ) -> Result<(), Undelivered> {
        let stored = matches!(
            outcome,
            Ok(PushOutcome::Stored | PushOutcome::DroppedOldest)
        );
        if stored {
            self.notify(&mut |component| effects.trigger(component));
        }
        if *outcome == Ok(PushOutcome::Stored) {
            return Ok(());
        }
        let total = self.dropped.fetch_add(1, Ordering::Relaxed) + 1;
        for reader in &self.readers {
            reader.losses.add(1);
        }
        effects.dropped(&self.to, total, outcome.as_ref().err());
        if stored || !self.mandatory {
            return Ok(());
        }
        Err(Undelivered {
            to: self.to.clone(),
        })
    }
}

/// An output port without its static message type.
pub trait AnyOutput: Any + Send {
    /// Name and fields of the message type.
    fn schema(&self) -> &Schema;

    /// Adds a connection.
    fn connect(&mut self, sender: Box<dyn AnySender>, link: OutputLink);

    /// Sends the last sample to a new reader (RTT `init`), and triggers it.
    fn replay_last(&mut self, connection: ConnectionId, trigger: &mut dyn FnMut(usize));

    /// Removes a connection.
    fn disconnect(&mut self, connection: ConnectionId);

    /// Sends the last sample through the links out of the system with this name (RTT `init`).
    fn replay_outside(&mut self, to: &str);

    /// Removes the links out of the system with this name.
    fn disconnect_outside(&mut self, to: &str);

    /// Sets the sample to write after the component's last cycle.
    ///
    /// # Errors
    /// An error if the sample does not have the port's type; omitted fields have their initial values.
    fn set_safe(&mut self, sample: &Datum) -> Result<(), DatumError>;

    /// Queues the safe sample. Returns whether the port has one.
    fn write_safe(&mut self) -> bool;

    /// Sends the oldest pending sample.
    ///
    /// # Errors
    /// An error if a mandatory connection did not take the sample; all others have.
    fn flush(&mut self, now: Time, effects: &mut dyn PortEffects) -> Result<(), Undelivered>;

    /// Drops the pending samples, because the cycle failed.
    fn discard(&mut self);

    /// Returns the content of the port between two cycles, when no sample is pending.
    ///
    /// # Errors
    ///
    /// An error if a sample cannot be represented as a datum.
    fn snapshot(&self) -> Result<OutputSnapshot, DatumError>;

    /// Restores the content of a port with the same connections.
    ///
    /// # Errors
    ///
    /// An error if a sample has another type or the port has other connections; the port is then unchanged.
    fn restore(&mut self, snapshot: &OutputSnapshot) -> Result<(), DatumError>;

    /// Sends the unread samples of a connection again, without side effects. Returns whether the connection starts at
    /// this port.
    ///
    /// # Errors
    ///
    /// An error if a sample does not have the type of the connection's reader.
    fn refill(
        &mut self,
        connection: ConnectionId,
        waiting: &[SampleSnapshot],
    ) -> Result<bool, DatumError>;

    /// Returns the links in order of creation.
    fn links(&self) -> Vec<&OutputLink>;

    /// Prefetches what the port points to: the lists of its links and pending samples. The port itself should have been
    /// [prefetched](crate::prefetch) a while before.
    fn prefetch_lists(&self);

    /// Prefetches what the links point to, as [`prefetch_lists`](Self::prefetch_lists) does for the port.
    fn prefetch_queues(&self);
}

impl<T: Message> AnyOutput for OutputPort<T> {
    fn schema(&self) -> &Schema {
        &self.schema
    }

    fn connect(&mut self, sender: Box<dyn AnySender>, link: OutputLink) {
        let existing = self
            .links
            .iter_mut()
            .find(|(_, known)| link.queue.is_some() && known.queue == link.queue);
        match existing {
            Some((_, known)) => known.readers.extend(link.readers),
            None => {
                if self.links.len() < FEW_LINKS {
                    // most ports have one; a vector would make room for four
                    self.links.reserve_exact(1);
                }
                self.links
                    .extend(PortSender::of(sender).map(|sender| (sender, link)));
            }
        }
    }

    fn replay_last(&mut self, connection: ConnectionId, trigger: &mut dyn FnMut(usize)) {
        let new = |link: &OutputLink| {
            link.readers
                .iter()
                .any(|reader| reader.connection == connection)
        };
        let link = self.links.iter_mut().find(|(_, link)| new(link));
        if let (Some((sender, link)), Some(last)) = (link, &self.last)
            && sender.send(last) == Ok(PushOutcome::Stored)
        {
            link.notify(trigger);
        }
    }

    fn disconnect(&mut self, connection: ConnectionId) {
        self.links.retain_mut(|(_, link)| {
            let count = link.readers.len();
            link.readers
                .retain(|reader| reader.connection != connection);
            let lost = link.readers.len() < count;
            !(lost && link.readers.is_empty())
        });
    }

    fn replay_outside(&mut self, to: &str) {
        let Some(last) = &self.last else {
            return;
        };
        for (sender, _) in self
            .links
            .iter_mut()
            .filter(|(_, link)| link.is_outside(to))
        {
            // a bus that does not take the sample counts it itself
            let _ = sender.send(last);
        }
    }

    fn disconnect_outside(&mut self, to: &str) {
        self.links.retain(|(_, link)| !link.is_outside(to));
    }

    fn set_safe(&mut self, sample: &Datum) -> Result<(), DatumError> {
        self.safe = Some(T::of_datum(sample)?);
        Ok(())
    }

    fn write_safe(&mut self) -> bool {
        let safe = self.safe.clone();
        let has_safe = safe.is_some();
        self.pending.extend(safe.map(PendingSample::new));
        has_safe
    }

    fn flush(&mut self, now: Time, effects: &mut dyn PortEffects) -> Result<(), Undelivered> {
        let Some(PendingSample { value, age }) = self.pending.pop_front() else {
            return Ok(());
        };
        self.sequence += 1;
        effects.published(self.sequence, &value);
        self.deliver(value, now - age, effects)
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
            return Err(links_mismatch());
        }
        let last = snapshot.last.first().map(|last| {
            Ok::<_, DatumError>(Stamped {
                at: last.at,
                order: last.order,
                value: T::of_datum(&last.value)?,
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
            // converted to data, since the reader may have another type than this port
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

    fn prefetch_lists(&self) {
        prefetch(&*self.links);
        prefetch(self.pending.as_slices().0);
    }

    fn prefetch_queues(&self) {
        for (sender, link) in &self.links {
            sender.prefetch();
            prefetch(&*link.readers);
        }
    }
}
