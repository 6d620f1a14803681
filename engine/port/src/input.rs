//! Input ports: the samples that arrive between two cycles are frozen for the next one.

use std::any::Any;
use std::marker::PhantomData;
use std::sync::Arc;

use asmotion_connection::BufferKind;
use asmotion_datum::{Datum, DatumError, Message, Schema};

use crate::channel::{ChannelOpener, InputChannel, OpenerOf, ReadingEnd};
use crate::connection_id::ConnectionId;
use crate::flow::Flow;
use crate::loss_counter::LossCounter;
use crate::policy::{OnStale, Policy, Sharing};
use crate::sender::Stamped;
use crate::snapshot::{InputSnapshot, NewestSnapshot, links_mismatch};
use crate::time::Time;

/// An input port at run time. Used by its component's thread only.
pub struct InputPort<T> {
    schema: Schema,
    channels: Vec<InputChannel<T>>,
    /// Samples that arrived since the last cycle, in order of arrival.
    new_samples: Vec<T>,
    /// The newest sample of earlier cycles; `None` while `new_samples` contains a newer one.
    last: Option<T>,
    newest: Option<Newest>,
    stale: bool,
    /// Causes of refusals that have been returned, so that each is reported once.
    known_causes: Vec<String>,
    /// Messages lost on the way into the port.
    losses: LossCounter,
    /// Number of these messages when the port was last frozen.
    lost: u64,
    /// Scratch buffer of `freeze`, kept to avoid allocation.
    received: Vec<(ConnectionId, Stamped<T>)>,
}

/// Limit of remembered causes of refusals; further ones are not reported.
const MAX_CAUSES: usize = 8;

/// Samples that a port refused.
#[derive(Debug, Default, PartialEq)]
pub struct Refusals {
    /// Number of samples that could not be converted to the port's type.
    pub unreadable: u64,
    /// Number of samples with values that cannot be meant.
    pub implausible: u64,
    /// Causes that this port has not returned before.
    pub new_causes: Vec<String>,
}

impl Refusals {
    fn add(&mut self, cause: &DatumError, known: &mut Vec<String>) {
        self.implausible += 1;
        let cause = cause.to_string();
        if is_new_cause(&cause, known) {
            self.new_causes.push(cause);
        }
    }
}

/// Remembers a cause. Returns whether it is to be reported.
fn is_new_cause(cause: &str, known: &mut Vec<String>) -> bool {
    let is_new = known.len() < MAX_CAUSES && !known.iter().any(|it| it == cause);
    if is_new {
        known.push(cause.to_owned());
    }
    is_new
}

/// Origin of the newest sample.
#[derive(Clone, Copy)]
struct Newest {
    at: Time,
    connection: ConnectionId,
    /// Set once zeros have replaced the stale sample.
    zeroed: bool,
}

impl<T: Message> InputPort<T> {
    /// Creates a port without connections. `schema` differs from `T`'s own only if the message type is known at run
    /// time.
    pub fn new(schema: Schema) -> Self {
        Self {
            schema,
            channels: Vec::new(),
            new_samples: Vec::new(),
            last: None,
            newest: None,
            stale: false,
            known_causes: Vec::new(),
            losses: LossCounter::default(),
            lost: 0,
            received: Vec::new(),
        }
    }

    /// The newest frozen sample.
    pub fn read(&self) -> Flow<&T> {
        match (self.new_samples.last(), &self.last) {
            (Some(sample), _) => Flow::NewData(sample),
            (None, Some(sample)) => Flow::OldData(sample),
            (None, None) => Flow::NoData,
        }
    }

    /// All samples frozen for the current cycle, in order of arrival.
    pub fn all(&self) -> &[T] {
        &self.new_samples
    }

    /// Empties the channels. Returns which samples were refused.
    fn take_received(&mut self) -> Refusals {
        let mut refusals = Refusals::default();
        for channel in &mut self.channels {
            let (arrived, connection) = (&mut self.received, channel.connection);
            refusals.unreadable += channel.drain(|sample| arrived.push((connection, sample)));
        }
        if self.channels.len() > 1 {
            // order numbers are unique, and the unstable sort needs no scratch memory
            self.received
                .sort_unstable_by_key(|(_, sample)| sample.order);
        }
        for (connection, sample) in self.received.drain(..) {
            if let Err(cause) = sample.value.check() {
                refusals.add(&cause, &mut self.known_causes);
                continue;
            }
            self.newest = Some(Newest {
                at: sample.at,
                connection,
                zeroed: false,
            });
            self.new_samples.push(sample.value);
        }
        // keep the newest sample's connection, whose policy limits the sample's age
        let newest = self.newest.map(|newest| newest.connection);
        self.channels
            .retain(|channel| Some(channel.connection) == newest || !channel.is_abandoned());
        refusals
    }

    /// Compares the age of the newest sample with the limit of its connection, and applies `on_stale`.
    fn update_staleness(&mut self, now: Time) {
        self.stale = false;
        let Some(newest) = &mut self.newest else {
            return;
        };
        let mut channels = self.channels.iter();
        let Some(channel) = channels.find(|channel| channel.connection == newest.connection) else {
            return;
        };
        let Some(max_age) = channel.policy.max_age else {
            return;
        };
        if now.since(newest.at) <= max_age {
            return;
        }
        self.stale = true;
        match channel.policy.on_stale {
            OnStale::Hold => {}
            OnStale::NoData => {
                self.new_samples.clear();
                self.last = None;
            }
            OnStale::Zero if newest.zeroed => {}
            OnStale::Zero => {
                newest.zeroed = true;
                self.new_samples.extend(channel.zero.clone());
            }
        }
    }
}

/// Converts samples to data.
fn data<'a, T: Message>(
    samples: impl IntoIterator<Item = &'a T>,
) -> Result<Vec<Datum>, DatumError> {
    samples.into_iter().map(Datum::of).collect()
}

/// An input port without its static message type.
pub trait AnyInput: Any + Send {
    /// Name and fields of the message type.
    fn schema(&self) -> &Schema;

    /// Opens channels into this port; their reading ends can be joined to this port only.
    fn opener(&self) -> Arc<dyn ChannelOpener>;

    /// Makes the samples that arrived since the last call visible, and marks earlier ones as old. Samples whose values fail
    /// [`Message::check`] are refused, as if they had not been written. Returns which samples were refused.
    fn freeze(&mut self, now: Time) -> Refusals;

    /// Remembers why the component refused a sample that it had read. Returns whether the cause is to be reported: each is
    /// reported once, and only the first few of a port.
    fn refuse(&mut self, cause: &str) -> bool;

    /// Returns whether the newest sample is older than its connection's policy allows.
    fn is_stale(&self) -> bool;

    /// Time of the writer's cycle in which the newest sample was written.
    fn written_at(&self) -> Option<Time>;

    /// Number of messages lost on the way into the port, as of the last [`freeze`](Self::freeze): dropped because a
    /// connection was full, missed by the bus, or unreadable.
    fn lost(&self) -> u64;

    /// The queue that the declared connections form together: the newest sample if one of them keeps no more, or if there is
    /// none.
    fn queue(&self) -> BufferKind;

    /// Adds the reading end of a connection.
    fn connect(&mut self, end: ReadingEnd);

    /// Returns the content of the port and the unread samples of its connections, whose writers must be idle.
    ///
    /// # Errors
    ///
    /// An error if a sample cannot be represented as a datum.
    fn snapshot(&mut self) -> Result<InputSnapshot, DatumError>;

    /// Restores the content of a port with the same connections, and empties the connections. Their unread samples must
    /// be sent again with [`AnyOutput::refill`](crate::AnyOutput::refill).
    ///
    /// # Errors
    ///
    /// An error if a sample has another type or the port has other connections; the port is then unchanged.
    fn restore(&mut self, snapshot: &InputSnapshot) -> Result<(), DatumError>;

    /// Returns the identifier and the policy of each connection, in order of creation.
    fn connections(&self) -> Vec<(ConnectionId, &Policy)>;

    /// Removes a connection. Its samples are lost, as in RTT: data that are no longer renewed must not look fresh.
    fn disconnect(&mut self, connection: ConnectionId);
}

impl<T: Message> AnyInput for InputPort<T> {
    fn schema(&self) -> &Schema {
        &self.schema
    }

    fn opener(&self) -> Arc<dyn ChannelOpener> {
        Arc::new(OpenerOf::<T> {
            losses: self.losses.clone(),
            of: PhantomData,
        })
    }

    fn freeze(&mut self, now: Time) -> Refusals {
        if let Some(sample) = self.new_samples.pop() {
            self.last = Some(sample);
            self.new_samples.clear();
        }
        let refusals = self.take_received();
        self.losses.add(refusals.unreadable);
        self.lost = self.losses.total();
        self.update_staleness(now);
        refusals
    }

    fn refuse(&mut self, cause: &str) -> bool {
        is_new_cause(cause, &mut self.known_causes)
    }

    fn is_stale(&self) -> bool {
        self.stale
    }

    fn written_at(&self) -> Option<Time> {
        self.newest.map(|newest| newest.at)
    }

    fn lost(&self) -> u64 {
        self.lost
    }

    fn queue(&self) -> BufferKind {
        let declared = self.channels.iter().filter(|channel| channel.declared);
        let (mut size, mut common, mut is_circular) = (0_usize, 0, false);
        for policy in declared.map(|channel| &channel.policy) {
            match policy.kind {
                BufferKind::Data => return BufferKind::Data,
                BufferKind::Buffer(_) => {}
                BufferKind::Circular(_) => is_circular = true,
            }
            match policy.sharing {
                Sharing::PerInput => common = common.max(policy.kind.size()),
                Sharing::PerConnection | Sharing::PerOutput | Sharing::Shared => {
                    size = size.saturating_add(policy.kind.size());
                }
            }
        }
        match size.saturating_add(common) {
            0 => BufferKind::Data,
            size if is_circular => BufferKind::Circular(size),
            size => BufferKind::Buffer(size),
        }
    }

    fn connect(&mut self, end: ReadingEnd) {
        // succeeds: the end was made by this port's own opener
        let channel = end.channel.downcast::<InputChannel<T>>();
        self.channels
            .extend(channel.ok().map(|channel| InputChannel {
                declared: end.declared,
                ..*channel
            }));
    }

    fn snapshot(&mut self) -> Result<InputSnapshot, DatumError> {
        let channels = self.channels.iter_mut();
        let channels =
            channels.map(|channel| Ok((channel.connection.number(), channel.snapshot()?)));
        Ok(InputSnapshot {
            channels: channels.collect::<Result<_, DatumError>>()?,
            fresh: data(&self.new_samples)?,
            last: data(&self.last)?,
            newest: self.newest.map(|newest| NewestSnapshot {
                at: newest.at,
                connection: newest.connection.number(),
                zeroed: newest.zeroed,
            }),
            stale: self.stale,
            lost: self.losses.total(),
            causes: self.known_causes.clone(),
        })
    }

    fn restore(&mut self, snapshot: &InputSnapshot) -> Result<(), DatumError> {
        let numbers = self.channels.iter().map(|of| of.connection.number());
        if !numbers.eq(snapshot.channels.iter().map(|(number, _)| *number)) {
            return Err(links_mismatch());
        }
        let values = |data: &[Datum]| data.iter().map(Datum::to).collect::<Result<Vec<T>, _>>();
        let (fresh, last) = (values(&snapshot.fresh)?, values(&snapshot.last)?);
        for channel in &mut self.channels {
            channel.clear();
        }
        self.new_samples = fresh;
        self.last = last.into_iter().next();
        self.newest = snapshot.newest.as_ref().map(|newest| Newest {
            at: newest.at,
            connection: ConnectionId::new(newest.connection),
            zeroed: newest.zeroed,
        });
        self.stale = snapshot.stale;
        self.losses.set(snapshot.lost);
        self.lost = snapshot.lost;
        self.known_causes.clone_from(&snapshot.causes);
        Ok(())
    }

    fn connections(&self) -> Vec<(ConnectionId, &Policy)> {
        let channels = self.channels.iter();
        channels
            .map(|channel| (channel.connection, &channel.policy))
            .collect()
    }

    fn disconnect(&mut self, connection: ConnectionId) {
        self.channels
            .retain(|channel| channel.connection != connection);
        if self
            .newest
            .is_some_and(|newest| newest.connection == connection)
        {
            self.newest = None;
            self.last = None;
            self.new_samples.clear();
        }
    }
}
