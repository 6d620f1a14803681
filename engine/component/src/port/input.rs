//! Input ports: what came since the last cycle is frozen for the next one.

use std::any::Any;
use std::time::Duration;

use datum::{Datum, DatumError, Message, Schema};

use super::{AnySender, Flow};
use crate::Time;
use crate::connection::{OnStale, Policy, Receiver, Stamped, channel};

/// An input port at run time.
pub(crate) struct Input<T> {
    schema: Schema,
    channels: Vec<Incoming<T>>,
    /// Samples come since the last cycle, in the order in which they came.
    fresh: Vec<T>,
    /// The newest sample of earlier cycles, while there is no newer one.
    last: Option<T>,
    newest: Option<Newest>,
    stale: bool,
    /// Scratch space of `freeze`.
    arrived: Vec<(usize, Stamped<T>)>,
}

struct Incoming<T> {
    receiver: Receiver<T>,
    max_age: Option<Duration>,
    on_stale: OnStale,
    /// What stands for a stale sample, if zeros do.
    zero: Option<T>,
}

/// Where the newest sample came from.
#[derive(Clone, Copy)]
struct Newest {
    at: Time,
    channel: usize,
    /// Whether zeros have taken its place.
    zeroed: bool,
}

impl<T: Message> Input<T> {
    pub(crate) fn new(schema: Schema) -> Self {
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

    fn collect(&mut self) {
        for (index, channel) in self.channels.iter_mut().enumerate() {
            let arrived = &mut self.arrived;
            (channel.receiver).drain(|sample| arrived.push((index, sample)));
        }
        if self.channels.len() > 1 {
            // Unstable: orders are unique, and no scratch memory is taken.
            (self.arrived).sort_unstable_by_key(|(_, sample)| sample.order);
        }
        for (channel, sample) in self.arrived.drain(..) {
            self.newest = Some(Newest {
                at: sample.at,
                channel,
                zeroed: false,
            });
            self.fresh.push(sample.value);
        }
    }

    /// Compares the newest sample's age with what its connection promises.
    fn grow_stale(&mut self, now: Time) {
        self.stale = false;
        let Some(newest) = &mut self.newest else {
            return;
        };
        let Some(channel) = self.channels.get(newest.channel) else {
            return;
        };
        let Some(max_age) = channel.max_age else {
            return;
        };
        if now.since(newest.at) <= max_age {
            return;
        }
        self.stale = true;
        match channel.on_stale {
            OnStale::Keep => {}
            OnStale::Forget => {
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

/// An input port whose type is not known here.
pub(crate) trait AnyInput: Any + Send {
    /// Name and shape of what it takes.
    fn schema(&self) -> &Schema;

    /// Makes what came since the last time visible, and what is visible old.
    fn freeze(&mut self, now: Time);

    /// Whether the newest sample is older than its connection promises.
    fn is_stale(&self) -> bool;

    /// When the newest sample was written.
    fn written_at(&self) -> Option<Time>;

    /// Opens another way in.
    fn open(&mut self, policy: &Policy) -> Result<Box<dyn AnySender>, DatumError>;
}

impl<T: Message> AnyInput for Input<T> {
    fn schema(&self) -> &Schema {
        &self.schema
    }

    fn freeze(&mut self, now: Time) {
        if let Some(sample) = self.fresh.pop() {
            self.last = Some(sample);
            self.fresh.clear();
        }
        self.collect();
        self.grow_stale(now);
    }

    fn is_stale(&self) -> bool {
        self.stale
    }

    fn written_at(&self) -> Option<Time> {
        self.newest.map(|newest| newest.at)
    }

    fn open(&mut self, policy: &Policy) -> Result<Box<dyn AnySender>, DatumError> {
        let zero = match policy.on_stale {
            // All fields of a message have an initial value.
            OnStale::Zero => Some(Datum::Record(Vec::new()).to()?),
            OnStale::Keep | OnStale::Forget => None,
        };
        let (sender, receiver) = channel::<T>(policy.kind);
        self.channels.push(Incoming {
            receiver,
            max_age: policy.max_age,
            on_stale: policy.on_stale,
            zero,
        });
        Ok(Box::new(sender))
    }
}
