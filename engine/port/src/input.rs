//! Input ports: the samples that arrive between two cycles are frozen for the next one.

use std::any::Any;
use std::marker::PhantomData;
use std::sync::Arc;
use std::time::Duration;

use asmotion_connection::{BufferKind, prefetch};
use asmotion_datum::{Datum, DatumError, Message, Schema};

use crate::channel::{ChannelOpener, InputChannel, OpenerOf, ReadingEnd};
use crate::connection_id::ConnectionId;
use crate::flow::Flow;
use crate::loss_counter::LossCounter;
use crate::policy::{OnStale, Policy, Sharing};
use crate::queue_gauges::QueueGauges;
use crate::sender::Stamped;
use crate::snapshot::{InputSnapshot, NewestSnapshot, links_mismatch};
use crate::time::Time;

/// An input port at run time. Used by its component's thread only.
pub struct InputPort<T> {
    schema: Arc<Schema>,
    channels: Vec<InputChannel<T>>,
    /// Samples that arrived since the last cycle, in order of arrival.
    new_samples: Vec<T>,
    /// For each new sample, the last time at which it may be used; `None` without a limit.
    expiries: Vec<Option<Time>>,
    /// The newest sample of earlier cycles; `None` while `new_samples` contains a newer one.
    last: Option<T>,
    newest: Option<Newest>,
    stale: bool,
    /// Number of samples discarded because they were too old.
    too_old: u64,
    /// Causes of refusals that have been returned, so that each is reported once.
    known_causes: Vec<String>,
    /// Messages lost on the way into the port.
    losses: LossCounter,
    /// Number of these messages when the port was last frozen.
    lost: u64,
    /// Queues of the connections, for other threads.
    gauges: QueueGauges,
    /// Connections allocate their whole queues when they are joined to the port.
    reserves: bool,
    /// Scratch buffer of `freeze`, kept to avoid allocation.
    received: Vec<(ConnectionId, Stamped<T>)>,
}

/// Number of connections up to which a port has memory for no more than it has.
const FEW_CHANNELS: usize = 4;

/// Limit of remembered causes of refusals; further ones are not reported.
const MAX_CAUSES: usize = 8;

/// Samples that a port refused.
#[derive(Debug, Default, PartialEq)]
pub struct Refusals {
    /// Number of samples that could not be converted to the port's type.
    pub unreadable: u64,
    /// Number of samples with values that cannot be meant.
    pub implausible: u64,
    /// Samples that were too old for their connection when the component could have read them.
    pub too_old: Option<TooOld>,
    /// Causes that this port has not returned before.
    pub new_causes: Vec<String>,
}

/// Samples that a port discarded because they exceeded the age limit of their connection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TooOld {
    /// Number of samples discarded so far.
    pub total: u64,
    /// Age of the last one.
    pub age: Duration,
    /// The age limit of its connection.
    pub limit: Duration,
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
            schema: Arc::new(schema),
            channels: Vec::new(),
            new_samples: Vec::new(),
            expiries: Vec::new(),
            last: None,
            newest: None,
            stale: false,
            too_old: 0,
            known_causes: Vec::new(),
            losses: LossCounter::default(),
            gauges: QueueGauges::default(),
            lost: 0,
            reserves: false,
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
    fn take_received(&mut self, now: Time) -> Refusals {
        let mut refusals = Refusals::default();
        for channel in &mut self.channels {
            // before it is emptied: a writer can write and leave at any time
            channel.has_ended = channel.is_abandoned();
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
            let mut channels = self.channels.iter();
            let channel = channels.find(|channel| channel.connection == connection);
            let limit = channel.and_then(|channel| channel.policy.discarded_after());
            let age = now.since(sample.at);
            if let Some(limit) = limit.filter(|limit| age > *limit) {
                self.too_old += 1;
                let total = self.too_old;
                refusals.too_old = Some(TooOld { total, age, limit });
                // the first sample that a port receives is stale: its policy decides what the component reads instead
                self.newest.get_or_insert(Newest {
                    at: sample.at,
                    connection,
                    zeroed: false,
                });
                continue;
            }
            self.newest = Some(Newest {
                at: sample.at,
                connection,
                zeroed: false,
            });
            self.new_samples.push(sample.value);
            self.expiries.push(limit.map(|limit| sample.at + limit));
        }
        // keep the newest sample's connection, whose policy limits the sample's age
        let newest = self.newest.map(|newest| newest.connection);
        self.channels
            .retain(|channel| Some(channel.connection) == newest || !channel.has_ended);
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
                self.expiries.clear();
                self.last = None;
            }
            OnStale::Zero if newest.zeroed => {}
            OnStale::Zero => {
                newest.zeroed = true;
                self.new_samples.extend(channel.zero.clone());
                self.expiries.resize(self.new_samples.len(), None);
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
    /// [`Message::check`] are refused, as if they had not been written, and so are those that are older than their connection
    /// allows, unless its policy holds stale samples. Returns which samples were refused.
    fn freeze(&mut self, now: Time) -> Refusals;

    /// Discards the samples that have arrived since the last [`freeze`](Self::freeze), except those of connections that keep a
    /// state for new readers ([`Policy::init`](crate::Policy::init)). Returns their number, which is also counted as lost.
    fn discard(&mut self) -> u64;

    /// Remembers why the component refused a sample that it had read. Returns whether the cause is to be reported: each is
    /// reported once, and only the first few of a port.
    fn refuse(&mut self, cause: &str) -> bool;

    /// For each sample that arrived since the last cycle, the last time at which its connection allows its use; `None`
    /// without a limit.
    fn expiries(&self) -> &[Option<Time>];

    /// Returns whether the newest sample is older than its connection's policy allows.
    fn is_stale(&self) -> bool;

    /// Time of the writer's cycle in which the newest sample was written.
    fn written_at(&self) -> Option<Time>;

    /// Number of messages lost on the way into the port, as of the last [`freeze`](Self::freeze): dropped because a
    /// connection was full, missed by the bus, unreadable, or too old.
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

    /// Allocates memory for as many samples as the connections can hold, also those that follow, so that no writer allocates it
    /// while it runs. Called before a run in real time.
    fn reserve(&mut self);

    /// Prefetches what the port points to: the lists of its connections and samples. The port itself should have been
    /// [prefetched](crate::prefetch) a while before.
    fn prefetch_lists(&self);

    /// Prefetches what the connections point to, as [`prefetch_lists`](Self::prefetch_lists) does for the port.
    fn prefetch_queues(&self);
}

impl<T: Message> AnyInput for InputPort<T> {
    fn schema(&self) -> &Schema {
        &self.schema
    }

    fn opener(&self) -> Arc<dyn ChannelOpener> {
        Arc::new(OpenerOf::<T> {
            schema: Arc::clone(&self.schema),
            losses: self.losses.clone(),
            gauges: self.gauges.clone(),
            of: PhantomData,
        })
    }

    fn freeze(&mut self, now: Time) -> Refusals {
        if let Some(sample) = self.new_samples.pop() {
            self.last = Some(sample);
            self.new_samples.clear();
        }
        self.expiries.clear();
        let known_too_old = self.too_old;
        let refusals = self.take_received(now);
        self.losses.add(refusals.unreadable);
        self.losses.add(self.too_old - known_too_old);
        self.lost = self.losses.total();
        self.update_staleness(now);
        refusals
    }

    fn discard(&mut self) -> u64 {
        let channels = self.channels.iter_mut();
        let discarded = channels
            .filter(|channel| !channel.policy.init)
            .map(InputChannel::clear)
            .sum();
        self.losses.add(discarded);
        discarded
    }

    fn refuse(&mut self, cause: &str) -> bool {
        is_new_cause(cause, &mut self.known_causes)
    }

    fn expiries(&self) -> &[Option<Time>] {
        &self.expiries
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
        if let (true, Ok(channel)) = (self.reserves, &channel) {
            channel.reserve();
        }
        if self.channels.len() < FEW_CHANNELS {
            // most ports have one or two; a vector would make room for four
            self.channels.reserve_exact(1);
        }
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
            too_old: self.too_old,
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
        // they belong to the cycle that has ended
        self.expiries.clear();
        self.too_old = snapshot.too_old;
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
            self.expiries.clear();
        }
    }

    fn reserve(&mut self) {
        self.reserves = true;
        self.channels.iter().for_each(InputChannel::reserve);
    }

    fn prefetch_lists(&self) {
        prefetch(&*self.channels);
        prefetch(&*self.new_samples);
        prefetch(&*self.expiries);
        self.losses.prefetch();
    }

    fn prefetch_queues(&self) {
        for channel in &self.channels {
            channel.prefetch();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use asmotion_datum::{DatumProblem, Sample};
    use serde::{Deserialize, Serialize};

    use super::*;

    thread_local! {
        /// Called when a port checks a sample with a negative number.
        static MEANWHILE: RefCell<Option<Box<dyn FnOnce()>>> = const { RefCell::new(None) };
    }

    /// A number that the port refuses if it is negative.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    struct Checked {
        #[serde(default)]
        n: i64,
    }

    impl Message for Checked {
        const NAME: &'static str = "test/Checked";

        fn schema() -> &'static Schema {
            static SCHEMA: std::sync::LazyLock<Schema> =
                std::sync::LazyLock::new(|| Schema::opaque("test/Checked"));
            &SCHEMA
        }

        fn check(&self) -> Result<(), DatumError> {
            if self.n >= 0 {
                return Ok(());
            }
            if let Some(meanwhile) = MEANWHILE.take() {
                meanwhile();
            }
            Err(DatumError::new(DatumProblem::Implausible("negative")))
        }
    }

    fn checked(n: i64) -> Arc<dyn Sample> {
        Arc::new(Checked { n })
    }

    fn at(ms: u64) -> Time {
        Time::ZERO + Duration::from_millis(ms)
    }

    /// A port and the writing end of a connection to it.
    fn joined(policy: &Policy) -> (InputPort<Checked>, Box<dyn crate::AnySender>) {
        let mut port = InputPort::<Checked>::new(Checked::schema().clone());
        let opened = port.opener().open(ConnectionId::new(1), policy, None);
        let Ok((sender, end)) = opened else {
            unreachable!("the policy has no shared queue")
        };
        port.connect(end);
        (port, sender)
    }

    fn read(port: &InputPort<Checked>) -> Vec<i64> {
        port.all().iter().map(|sample| sample.n).collect()
    }

    #[test]
    fn what_a_writer_writes_before_it_leaves_arrives_even_while_the_port_is_read() {
        for policy in [Policy::buffer(4), Policy::data(), Policy::circular(4)] {
            let (mut port, mut sender) = joined(&policy);
            sender.send_sample(checked(-1), at(0), 1).unwrap();
            MEANWHILE.set(Some(Box::new(move || {
                sender.send_sample(checked(7), at(0), 2).unwrap();
            })));
            assert_eq!(port.freeze(at(0)).implausible, 1);
            assert!(read(&port).is_empty());
            port.freeze(at(1));
            assert_eq!(read(&port), [7], "{policy:?}");
            port.freeze(at(2));
            port.disconnect(ConnectionId::new(1));
            assert!(port.connections().is_empty());
        }
    }

    #[test]
    fn samples_that_are_too_old_are_discarded_wherever_they_are_in_the_queue() {
        for (on_stale, expected) in [
            (OnStale::Hold, vec![1, 2, 3]),
            (OnStale::NoData, vec![3]),
            (OnStale::Zero, vec![3]),
        ] {
            let policy = Policy::buffer(4).max_age(Duration::from_millis(100));
            let (mut port, mut sender) = joined(&policy.on_stale(on_stale));
            for (n, written) in [(1, 0), (2, 49), (3, 50)] {
                sender
                    .send_sample(checked(n), at(written), n as u64)
                    .unwrap();
            }
            let refusals = port.freeze(at(150));
            assert_eq!(read(&port), expected, "{on_stale:?}");
            let discarded = 3 - expected.len() as u64;
            assert_eq!(port.lost(), discarded, "{on_stale:?}");
            let limit = Duration::from_millis(100);
            let age = Duration::from_millis(101);
            let total = discarded;
            let reported = (discarded > 0).then_some(TooOld { total, age, limit });
            assert_eq!(refusals.too_old, reported);
            let limits = on_stale != OnStale::Hold;
            let last = limits.then(|| at(150));
            assert_eq!(port.expiries().last(), Some(&last));
        }
    }

    #[test]
    fn a_first_sample_that_is_too_old_is_no_data_or_zero() {
        let limit = Duration::from_millis(100);
        let policy = Policy::data().max_age(limit).on_stale(OnStale::NoData);
        let (mut port, mut sender) = joined(&policy);
        sender.send_sample(checked(1), at(0), 1).unwrap();
        port.freeze(at(101));
        assert_eq!((port.read(), port.is_stale()), (Flow::NoData, true));
        sender.send_sample(checked(2), at(150), 2).unwrap();
        port.freeze(at(160));
        assert_eq!(port.read(), Flow::NewData(&Checked { n: 2 }));
        assert!(!port.is_stale());
    }
}
