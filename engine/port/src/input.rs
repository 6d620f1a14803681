//! Input ports: what came since the last cycle is frozen for the next one.

use std::any::Any;
use std::marker::PhantomData;
use std::sync::Arc;

use asmotion_datum::{Datum, DatumError, Message, Schema};

use crate::channel::{ChannelOpener, InputChannel, OpenerOf, ReadingEnd};
use crate::connection_id::ConnectionId;
use crate::flow::Flow;
use crate::policy::{OnStale, Policy};
use crate::sender::Stamped;
use crate::snapshot::{InputSnapshot, NewestSnapshot, other_links};
use crate::time::Time;

/// An input port at run time. One thread at a time has it: its component's.
pub struct InputPort<T> {
    schema: Schema,
    channels: Vec<InputChannel<T>>,
    /// Samples come since the last cycle, in the order in which they came.
    fresh: Vec<T>,
    /// The newest sample of earlier cycles, while there is no newer one.
    last: Option<T>,
    newest: Option<Newest>,
    stale: bool,
    /// Scratch space of `freeze`.
    arrived: Vec<(ConnectionId, Stamped<T>)>,
}

/// Where the newest sample came from.
#[derive(Clone, Copy)]
struct Newest {
    at: Time,
    connection: ConnectionId,
    /// Whether zeros have taken its place.
    zeroed: bool,
}

impl<T: Message> InputPort<T> {
    /// A port without connections. `schema` is the declared one, which a message type known at run time only needs.
    pub fn new(schema: Schema) -> Self {
        Self {
            schema,
            channels: Vec::new(),
            fresh: Vec::new(),
            last: None,
            newest: None,
            stale: false,
            arrived: Vec::new(),
        }
    }

    /// The newest frozen sample.
    pub fn read(&self) -> Flow<&T> {
        match (self.fresh.last(), &self.last) {
            (Some(sample), _) => Flow::NewData(sample),
            (None, Some(sample)) => Flow::OldData(sample),
            (None, None) => Flow::NoData,
        }
    }

    /// All samples frozen for the present cycle, in the order in which they came.
    pub fn all(&self) -> &[T] {
        &self.fresh
    }

    /// Empties the channels. Returns the number of samples that cannot be read.
    fn collect(&mut self) -> u64 {
        let mut unreadable = 0;
        for channel in &mut self.channels {
            let (arrived, connection) = (&mut self.arrived, channel.connection);
            unreadable += channel.drain(|sample| arrived.push((connection, sample)));
        }
        if self.channels.len() > 1 {
            // Unstable: orders are unique, and no scratch memory is taken.
            (self.arrived).sort_unstable_by_key(|(_, sample)| sample.order);
        }
        for (connection, sample) in self.arrived.drain(..) {
            self.newest = Some(Newest {
                at: sample.at,
                connection,
                zeroed: false,
            });
            self.fresh.push(sample.value);
        }
        // As long as the newest sample is from there, its connection says how old it may grow.
        let newest = self.newest.map(|newest| newest.connection);
        (self.channels)
            .retain(|channel| Some(channel.connection) == newest || !channel.is_abandoned());
        unreadable
    }

    /// Compares the newest sample's age with what its connection promises.
    fn grow_stale(&mut self, now: Time) {
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
                self.fresh.clear();
                self.last = None;
            }
            OnStale::Zero if newest.zeroed => {}
            OnStale::Zero => {
                newest.zeroed = true;
                self.fresh.extend(channel.zero.clone());
            }
        }
    }
}

/// Samples as data.
fn data<'a, T: Message>(
    samples: impl IntoIterator<Item = &'a T>,
) -> Result<Vec<Datum>, DatumError> {
    samples.into_iter().map(Datum::of).collect()
}

/// An input port whose message type the caller does not know.
pub trait AnyInput: Any + Send {
    /// Name and shape of its messages.
    fn schema(&self) -> &Schema;

    /// Opens channels into this port; only this port takes their reading ends.
    fn opener(&self) -> Arc<dyn ChannelOpener>;

    /// Makes what came since the last call visible, and what was visible old. Returns the number of samples that could
    /// not be read.
    fn freeze(&mut self, now: Time) -> u64;

    /// Whether the newest sample is older than its connection promises.
    fn is_stale(&self) -> bool;

    /// When the newest sample was written.
    fn written_at(&self) -> Option<Time>;

    /// Takes the reading end of a connection.
    fn join(&mut self, end: ReadingEnd);

    /// What the port holds, and what waits in its connections, whose writers are at rest.
    ///
    /// # Errors
    /// A sample has no form as data.
    fn snapshot(&mut self) -> Result<InputSnapshot, DatumError>;

    /// Takes over what a port of the same connections held, and empties the connections: what waited in them has to be
    /// sent again ([`AnyOutput::refill`](crate::AnyOutput::refill)).
    ///
    /// # Errors
    /// A sample is of another type, or the port has other connections; the port is then as it was.
    fn restore(&mut self, snapshot: &InputSnapshot) -> Result<(), DatumError>;

    /// The number and the policy of each connection, in order.
    fn connections(&self) -> Vec<(ConnectionId, &Policy)>;

    /// Ends a connection. What came through it is gone, as in RTT: data that nobody renews must not look fresh.
    fn disconnect(&mut self, connection: ConnectionId);
}

impl<T: Message> AnyInput for InputPort<T> {
    fn schema(&self) -> &Schema {
        &self.schema
    }

    fn opener(&self) -> Arc<dyn ChannelOpener> {
        Arc::new(OpenerOf::<T>(PhantomData))
    }

    fn freeze(&mut self, now: Time) -> u64 {
        if let Some(sample) = self.fresh.pop() {
            self.last = Some(sample);
            self.fresh.clear();
        }
        let unreadable = self.collect();
        self.grow_stale(now);
        unreadable
    }

    fn is_stale(&self) -> bool {
        self.stale
    }

    fn written_at(&self) -> Option<Time> {
        self.newest.map(|newest| newest.at)
    }

    fn join(&mut self, end: ReadingEnd) {
        // It came from this port's own opener.
        let channel = end.0.downcast::<InputChannel<T>>();
        self.channels.extend(channel.ok().map(|channel| *channel));
    }

    fn snapshot(&mut self) -> Result<InputSnapshot, DatumError> {
        let channels = self.channels.iter_mut();
        let channels =
            channels.map(|channel| Ok((channel.connection.number(), channel.snapshot()?)));
        Ok(InputSnapshot {
            channels: channels.collect::<Result<_, DatumError>>()?,
            fresh: data(&self.fresh)?,
            last: data(&self.last)?,
            newest: self.newest.map(|newest| NewestSnapshot {
                at: newest.at,
                connection: newest.connection.number(),
                zeroed: newest.zeroed,
            }),
            stale: self.stale,
        })
    }

    fn restore(&mut self, snapshot: &InputSnapshot) -> Result<(), DatumError> {
        let numbers = self.channels.iter().map(|of| of.connection.number());
        if !numbers.eq(snapshot.channels.iter().map(|(number, _)| *number)) {
            return Err(other_links());
        }
        let values = |data: &[Datum]| data.iter().map(Datum::to).collect::<Result<Vec<T>, _>>();
        let (fresh, last) = (values(&snapshot.fresh)?, values(&snapshot.last)?);
        for channel in &mut self.channels {
            channel.empty();
        }
        self.fresh = fresh;
        self.last = last.into_iter().next();
        self.newest = snapshot.newest.as_ref().map(|newest| Newest {
            at: newest.at,
            connection: ConnectionId::new(newest.connection),
            zeroed: newest.zeroed,
        });
        self.stale = snapshot.stale;
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
        if (self.newest).is_some_and(|newest| newest.connection == connection) {
            self.newest = None;
            self.last = None;
            self.fresh.clear();
        }
    }
}
