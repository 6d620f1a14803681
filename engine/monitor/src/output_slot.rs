//! The newest sample of an output, and how regularly it arrives.

use std::any::Any;
use std::borrow::Cow;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use asmotion_component::Time;
use asmotion_datum::{Codec, Datum, DatumError, Sample, Schema};
use asmotion_viewer_encoding::ChannelSchema;

use crate::rendering;

/// Number of samples over which a rate is measured.
const WINDOW: usize = 32;
/// Number of samples from which an output counts as regular, so that its silence means something.
const REGULAR: usize = 8;
/// Minimum silence after which an output is stale, whatever its rate.
const PATIENCE: Duration = Duration::from_secs(1);
/// Mean interval in seconds of the run from which samples count as events.
const RARE_S: f64 = 0.5;
/// Number of recent samples that a viewer receives at once.
const RECENT: usize = 4;
/// Age from which a sample is not recent any more.
const RECENT_AGE: Duration = Duration::from_millis(50);
/// Number of samples that are kept for tabs that receive all of them: those of a second at 500 Hz, for a tab in the background.
const ALL: usize = 512;
/// Interval between two measurements of the size of samples.
const MEASURED: Duration = Duration::from_secs(1);
/// Number of intervals after which a silent output is stale.
const GAPS: u32 = 4;

/// An output of a component.
pub(crate) struct OutputSlot {
    /// Full name, `Component.port`.
    pub name: Arc<str>,
    /// Number of viewers that receive its recent samples.
    recent_followers: AtomicUsize,
    /// Number of tabs that receive all of its samples.
    all_followers: AtomicUsize,
    state: Mutex<OutputState>,
}

/// The samples that a follower receives besides the newest one of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum KeptSamples {
    /// Those shortly before it.
    Recent,
    /// All since the last time.
    All,
}

/// Lets an output keep samples as long as this exists.
pub(crate) struct SlotFollower {
    slot: Arc<OutputSlot>,
    kept: KeptSamples,
}

impl SlotFollower {
    pub(crate) fn new(slot: &Arc<OutputSlot>, kept: KeptSamples) -> Self {
        slot.followers(kept).fetch_add(1, Ordering::Relaxed);
        Self {
            slot: Arc::clone(slot),
            kept,
        }
    }
}

impl Drop for SlotFollower {
    fn drop(&mut self) {
        let followers = self.slot.followers(self.kept);
        followers.fetch_sub(1, Ordering::Relaxed);
    }
}

#[derive(Default)]
struct OutputState {
    count: u64,
    newest: Option<Arc<NewestSample>>,
    /// The newest sample and those before it, as far as followers want them: charts show all, and events arrive in bursts, in which
    /// the newest one would hide the others.
    kept: VecDeque<Arc<NewestSample>>,
    arrivals: VecDeque<(Instant, Time)>,
    topic: Option<Arc<str>>,
    /// Type of the samples for viewers, once one has needed it.
    schema: Option<Arc<ChannelSchema>>,
    /// Size of the last sample that was measured.
    size: Option<MeasuredSize>,
}

/// The size of a sample.
#[derive(Clone, Copy)]
struct MeasuredSize {
    /// Number of the sample.
    of: u64,
    measured: Instant,
    /// Bytes in CBOR, as over a bus.
    bytes: usize,
}

/// Samples since a number, oldest first.
pub(crate) struct SampleBatch {
    pub samples: Vec<Arc<NewestSample>>,
    /// Number of samples since then that are not kept any more.
    pub missed: u64,
}

/// A sample as a message of a channel; `None` if it has no encoding.
type EncodedSample = (Arc<ChannelSchema>, Option<Arc<[u8]>>);

/// A sample, and its JSON once a tab has needed it: it is written once for all tabs.
pub(crate) struct NewestSample {
    /// Number of samples of this output so far.
    pub number: u64,
    /// Time of the run.
    pub at: Time,
    /// Time of arrival.
    pub arrived: Instant,
    sample: Arc<dyn Sample>,
    json: OnceLock<Arc<str>>,
    /// The sample as viewers read it, once one has needed it, and the type of which it was then.
    encoded: OnceLock<EncodedSample>,
}

/// How an output fares.
pub(crate) struct OutputSummary {
    pub name: Arc<str>,
    pub topic: Option<Arc<str>>,
    pub kind: &'static str,
    pub count: u64,
    /// Samples per second of the run over the last samples; `None` before the second one.
    pub rate_hz: Option<f64>,
    /// Size of a sample in bytes, as over a bus; `None` if it has no encoding.
    pub bytes: Option<usize>,
    pub age: Duration,
    /// Whether an output with regular samples has fallen silent.
    pub is_stale: bool,
}

impl NewestSample {
    /// The sample as JSON, or why there is none.
    pub(crate) fn json(&self) -> &Arc<str> {
        self.json.get_or_init(|| match self.datum() {
            Ok(datum) => rendering::json(&datum).into(),
            Err(error) => {
                let error = rendering::quoted(&error.to_string());
                format!("{{\"error\":{error}}}").into()
            }
        })
    }

    /// The sample as a message of this type; `None` if it is not of the type. It is encoded once for all viewers.
    pub(crate) fn encoded(&self, schema: &Arc<ChannelSchema>) -> Option<Arc<[u8]>> {
        let encode = || schema.encode(&*self.sample).map(Arc::from);
        let (of, encoded) = self.encoded.get_or_init(|| (Arc::clone(schema), encode()));
        // a replaced component can write samples of another type
        if **of == **schema {
            encoded.clone()
        } else {
            encode()
        }
    }

    /// The sample as data, which it may be already.
    pub(crate) fn datum(&self) -> Result<Cow<'_, Datum>, DatumError> {
        let sample: &dyn Any = &*self.sample;
        match sample.downcast_ref() {
            Some(datum) => Ok(Cow::Borrowed(datum)),
            None => self.sample.to_datum().map(Cow::Owned),
        }
    }

    pub(crate) fn kind(&self) -> &'static str {
        self.sample.type_name()
    }
}

impl OutputSlot {
    pub(crate) fn new(name: String) -> Self {
        Self {
            name: name.into(),
            recent_followers: AtomicUsize::new(0),
            all_followers: AtomicUsize::new(0),
            state: Mutex::default(),
        }
    }

    fn followers(&self, kept: KeptSamples) -> &AtomicUsize {
        match kept {
            KeptSamples::Recent => &self.recent_followers,
            KeptSamples::All => &self.all_followers,
        }
    }

    /// Number of samples that are kept now.
    fn kept_count(&self) -> usize {
        let is_wanted = |kept| self.followers(kept).load(Ordering::Relaxed) > 0;
        if is_wanted(KeptSamples::All) {
            ALL
        } else if is_wanted(KeptSamples::Recent) {
            RECENT
        } else {
            0
        }
    }

    fn state(&self) -> MutexGuard<'_, OutputState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a sample.
    pub(crate) fn publish(&self, at: Time, topic: Option<&str>, sample: &dyn Sample) {
        let (arrived, sample) = (Instant::now(), sample.to_shared());
        let mut state = self.state();
        state.count += 1;
        if state.arrivals.len() == WINDOW {
            state.arrivals.pop_front();
        }
        state.arrivals.push_back((arrived, at));
        if state.topic.as_deref() != topic {
            state.topic = topic.map(Arc::from);
        }
        let newest = Arc::new(NewestSample {
            number: state.count,
            at,
            arrived,
            sample,
            json: OnceLock::new(),
            encoded: OnceLock::new(),
        });
        let kept = self.kept_count();
        if kept > 0 {
            state.kept.push_back(Arc::clone(&newest));
        }
        while state.kept.len() > kept {
            state.kept.pop_front();
        }
        state.newest = Some(newest);
    }

    /// The topic of the newest sample.
    pub(crate) fn topic(&self) -> Option<Arc<str>> {
        self.state().topic.clone()
    }

    /// The type of the samples for viewers, which is found by its name at the first time; `None` before the first sample.
    pub(crate) fn schema(
        &self,
        find: impl FnOnce(&str) -> ChannelSchema,
    ) -> Option<Arc<ChannelSchema>> {
        let mut state = self.state();
        if state.schema.is_none() {
            let kind = state.newest.as_ref()?.kind();
            state.schema = Some(Arc::new(find(kind)));
        }
        state.schema.clone()
    }

    /// Forgets the type of the samples, because the system has changed.
    pub(crate) fn forget_schema(&self) {
        self.state().schema = None;
    }

    /// The newest sample, if it is newer than this one.
    pub(crate) fn newer_than(&self, number: u64) -> Option<Arc<NewestSample>> {
        let state = self.state();
        state.newest.clone().filter(|newest| newest.number > number)
    }

    /// The recent samples that are newer than this one, at least the newest sample if it is.
    pub(crate) fn recent_newer_than(&self, number: u64) -> Vec<Arc<NewestSample>> {
        let state = self.state();
        let Some(newest) = &state.newest else {
            return Vec::new();
        };
        let is_recent = |it: &&Arc<NewestSample>| {
            it.number > number && newest.arrived.duration_since(it.arrived) < RECENT_AGE
        };
        let from = state.kept.len().saturating_sub(RECENT);
        let recent: Vec<_> = state
            .kept
            .range(from..)
            .filter(is_recent)
            .cloned()
            .collect();
        let is_new = newest.number > number && recent.is_empty();
        if is_new {
            return vec![Arc::clone(newest)];
        }
        recent
    }

    /// All samples that are newer than this one, as far as they are kept; at least the newest sample if it is.
    pub(crate) fn batch_since(&self, number: u64) -> SampleBatch {
        let state = self.state();
        let is_new = |it: &&Arc<NewestSample>| it.number > number;
        let mut samples: Vec<_> = state.kept.iter().filter(is_new).cloned().collect();
        if samples.is_empty() {
            samples.extend(state.newest.iter().filter(is_new).cloned());
        }
        // who has not seen any has missed none
        let next = samples.first().filter(|_| number > 0).map(|it| it.number);
        SampleBatch {
            samples,
            missed: next.map_or(0, |next| next - number - 1),
        }
    }

    /// Returns whether its samples are events, which come less often than once in half a second of the run.
    pub(crate) fn is_rare(&self) -> bool {
        let state = self.state();
        let (Some((_, first)), Some((_, last))) = (state.arrivals.front(), state.arrivals.back())
        else {
            return false;
        };
        let gaps = state.arrivals.len() - 1;
        gaps == 0 || last.since(*first).as_secs_f64() / gaps as f64 > RARE_S
    }

    /// Measures the size of the newest sample, unless that was done within the last second.
    fn measure(&self, now: Instant) {
        let newest = {
            let state = self.state();
            let Some(newest) = &state.newest else {
                return;
            };
            let is_known = state.size.is_some_and(|size| {
                size.of == newest.number || now.saturating_duration_since(size.measured) < MEASURED
            });
            if is_known {
                return;
            }
            Arc::clone(newest)
        };
        // without the lock: a map takes a while
        let bytes = newest.datum().and_then(|datum| {
            let schema = Schema::opaque(newest.kind());
            Codec::Cbor.encode(&datum, &schema)
        });
        self.state().size = bytes.ok().map(|bytes| MeasuredSize {
            of: newest.number,
            measured: now,
            bytes: bytes.len(),
        });
    }

    pub(crate) fn summary(&self, now: Instant) -> Option<OutputSummary> {
        self.measure(now);
        let state = self.state();
        let newest = state.newest.as_ref()?;
        let (first, last) = (state.arrivals.front()?, state.arrivals.back()?);
        let gaps = u32::try_from(state.arrivals.len() - 1).unwrap_or(u32::MAX);
        let run = last.1.since(first.1).as_secs_f64();
        let gap = last.0.duration_since(first.0).checked_div(gaps);
        let age = now.saturating_duration_since(newest.arrived);
        let is_regular = state.arrivals.len() >= REGULAR;
        Some(OutputSummary {
            name: Arc::clone(&self.name),
            topic: state.topic.clone(),
            kind: newest.kind(),
            count: state.count,
            rate_hz: (run > 0.0).then(|| f64::from(gaps) / run),
            bytes: state.size.map(|size| size.bytes),
            age,
            is_stale: is_regular && gap.is_some_and(|gap| age > (gap * GAPS).max(PATIENCE)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_component::Span;
    use asmotion_datum::Datum;

    #[test]
    fn an_output_with_regular_samples_becomes_stale_and_an_event_does_not() {
        let slot = OutputSlot::new("Driver.odom".to_owned());
        assert!(slot.summary(Instant::now()).is_none());
        for tick in 0..3_u64 {
            slot.publish(Time::ZERO + (tick * 20).ms(), None, &Datum::Null);
        }
        let later = Instant::now() + Duration::from_secs(60);
        assert!(!slot.summary(later).unwrap().is_stale);
        for tick in 3..10_u64 {
            slot.publish(Time::ZERO + (tick * 20).ms(), None, &Datum::Null);
        }
        let summary = slot.summary(Instant::now()).unwrap();
        assert!(!summary.is_stale);
        assert_eq!(
            (summary.count, summary.rate_hz.map(f64::round)),
            (10, Some(50.0))
        );
        assert!(slot.summary(later).unwrap().is_stale);
    }

    #[test]
    fn only_the_newest_sample_is_kept() {
        let slot = OutputSlot::new("Driver.odom".to_owned());
        for value in 1..=3 {
            slot.publish(Time::ZERO, None, &Datum::Int(value));
        }
        let newest = slot.newer_than(0).unwrap();
        assert_eq!((newest.number, &**newest.json()), (3, "3"));
        assert!(slot.newer_than(3).is_none());
    }

    #[test]
    fn recent_samples_are_kept_for_followers() {
        let slot = Arc::new(OutputSlot::new("Driver.odom".to_owned()));
        let numbers = |since| {
            let newer = slot.recent_newer_than(since).into_iter();
            newer.map(|it| it.number).collect::<Vec<_>>()
        };
        let publish = || slot.publish(Time::ZERO, None, &Datum::Null);
        (0..3).for_each(|_| publish());
        assert_eq!(numbers(0), [3]);
        let follower = SlotFollower::new(&slot, KeptSamples::Recent);
        (0..6).for_each(|_| publish());
        assert_eq!(numbers(3), [6, 7, 8, 9]);
        assert_eq!(numbers(8), [9]);
        std::thread::sleep(RECENT_AGE);
        publish();
        assert_eq!(numbers(0), [10]);
        drop(follower);
        (0..2).for_each(|_| publish());
        assert_eq!(numbers(0), [12]);
    }

    #[test]
    fn all_samples_are_kept_for_those_who_show_all_and_what_is_gone_is_counted() {
        let slot = Arc::new(OutputSlot::new("Arm.status".to_owned()));
        let publish = |count| (0..count).for_each(|_| slot.publish(Time::ZERO, None, &Datum::Null));
        let batch = |since| {
            let batch = slot.batch_since(since);
            let numbers = batch.samples.iter().map(|it| it.number);
            (numbers.collect::<Vec<_>>(), batch.missed)
        };
        publish(3);
        // nobody has wanted the others
        assert_eq!(batch(0), (vec![3], 0));
        let follower = SlotFollower::new(&slot, KeptSamples::All);
        let viewer = SlotFollower::new(&slot, KeptSamples::Recent);
        publish(7);
        assert_eq!(batch(3), ((4..=10).collect(), 0));
        assert_eq!(batch(10), (Vec::new(), 0));
        // a viewer receives the recent ones all the same
        assert_eq!(slot.recent_newer_than(0).len(), RECENT);
        publish(ALL);
        let (numbers, missed) = batch(8);
        assert_eq!((numbers.len(), numbers[0], missed), (ALL, 11, 2));
        drop(follower);
        publish(1);
        assert_eq!(batch(0).0.len(), RECENT);
        drop(viewer);
        publish(1);
        assert_eq!(batch(0).0.len(), 1);
    }

    #[test]
    fn the_size_of_a_sample_is_that_over_a_bus() {
        let slot = OutputSlot::new("Driver.odom".to_owned());
        slot.publish(Time::ZERO, None, &Datum::text("12345678"));
        let begun = Instant::now();
        // a byte says that it is a text of eight bytes
        assert_eq!(slot.summary(begun).unwrap().bytes, Some(9));
        slot.publish(Time::ZERO, None, &Datum::text("1234"));
        assert_eq!(slot.summary(begun).unwrap().bytes, Some(9));
        assert_eq!(slot.summary(begun + MEASURED).unwrap().bytes, Some(5));
    }
}
