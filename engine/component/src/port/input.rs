//! Input ports: what came since the last cycle is frozen for the next one.

use std::any::Any;
use std::marker::PhantomData;
use std::sync::Arc;

use asmotion_datum::{Message, Schema};

use super::Flow;
use super::channel::{Incoming, Inlet, Of, Stamped, Way};
use crate::Time;
use crate::policy::OnStale;
use crate::system::ConnectionId;

/// An input port at run time.
pub(crate) struct Input<T> {
    schema: Schema,
    ways: Vec<Way<T>>,
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

impl<T: Message> Input<T> {
    pub(crate) fn new(schema: Schema) -> Self {
        Self {
            schema,
            ways: Vec::new(),
            fresh: Vec::new(),
            last: None,
            newest: None,
            stale: false,
            arrived: Vec::new(),
        }
    }

    pub(crate) fn read(&self) -> Flow<&T> {
        match (self.fresh.last(), &self.last) {
            (Some(sample), _) => Flow::NewData(sample),
            (None, Some(sample)) => Flow::OldData(sample),
            (None, None) => Flow::NoData,
        }
    }

    pub(crate) fn all(&self) -> &[T] {
        &self.fresh
    }

    /// Takes in what has come. Counts what cannot be read.
    fn collect(&mut self) -> u64 {
        let mut unreadable = 0;
        for way in &mut self.ways {
            let (arrived, connection) = (&mut self.arrived, way.connection);
            unreadable += way.drain(|sample| arrived.push((connection, sample)));
        }
        if self.ways.len() > 1 {
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
        (self.ways).retain(|way| Some(way.connection) == newest || !way.is_abandoned());
        unreadable
    }

    /// Compares the newest sample's age with what its connection promises.
    fn grow_stale(&mut self, now: Time) {
        self.stale = false;
        let Some(newest) = &mut self.newest else {
            return;
        };
        let mut ways = self.ways.iter();
        let Some(way) = ways.find(|way| way.connection == newest.connection) else {
            return;
        };
        let Some(max_age) = way.policy.max_age else {
            return;
        };
        if now.since(newest.at) <= max_age {
            return;
        }
        self.stale = true;
        match way.policy.on_stale {
            OnStale::Hold => {}
            OnStale::NoData => {
                self.fresh.clear();
                self.last = None;
            }
            OnStale::Zero if newest.zeroed => {}
            OnStale::Zero => {
                newest.zeroed = true;
                self.fresh.extend(way.zero.clone());
            }
        }
    }
}

/// An input port whose type is not known here.
pub(crate) trait AnyInput: Any + Send {
    /// Name and shape of what it takes.
    fn schema(&self) -> &Schema;

    /// Its type, to open ways into it.
    fn inlet(&self) -> Arc<dyn Inlet>;

    /// Makes what came since the last time visible, and what is visible old. Says how many samples could not be read.
    fn freeze(&mut self, now: Time) -> u64;

    /// Whether the newest sample is older than its connection promises.
    fn is_stale(&self) -> bool;

    /// When the newest sample was written.
    fn written_at(&self) -> Option<Time>;

    /// Takes the reading end of a connection.
    fn join(&mut self, incoming: Incoming);

    /// Ends a connection. What came through it is gone, as in RTT: old data of nobody looks like good data.
    fn part(&mut self, connection: ConnectionId);
}

impl<T: Message> AnyInput for Input<T> {
    fn schema(&self) -> &Schema {
        &self.schema
    }

    fn inlet(&self) -> Arc<dyn Inlet> {
        Arc::new(Of::<T>(PhantomData))
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

    fn join(&mut self, incoming: Incoming) {
        // It came from this port's own inlet.
        let way = incoming.0.downcast::<Way<T>>();
        self.ways.extend(way.ok().map(|way| *way));
    }

    fn part(&mut self, connection: ConnectionId) {
        self.ways.retain(|way| way.connection != connection);
        if (self.newest).is_some_and(|newest| newest.connection == connection) {
            self.newest = None;
            self.last = None;
            self.fresh.clear();
        }
    }
}
