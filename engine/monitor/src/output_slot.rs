//! The newest sample of an output, and how regularly it arrives.

use std::any::Any;
use std::borrow::Cow;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use asmotion_component::Time;
use asmotion_datum::{Datum, DatumError, Sample};
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
/// Number of recent samples that are kept for viewers.
const RECENT: usize = 4;
/// Age from which a sample is not recent any more.
const RECENT_AGE: Duration = Duration::from_millis(50);
/// Number of intervals after which a silent output is stale.
const GAPS: u32 = 4;

/// An output of a component.
pub(crate) struct OutputSlot {
    /// Full name, `Component.port`.
    pub name: Arc<str>,
    /// Number of viewers that receive its recent samples.
    followers: AtomicUsize,
    state: Mutex<OutputState>,
}

/// Lets an output keep its recent samples as long as this exists.
pub(crate) struct SlotFollower(Arc<OutputSlot>);

impl SlotFollower {
    pub(crate) fn new(slot: &Arc<OutputSlot>) -> Self {
        slot.followers.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(slot))
    }
}

impl Drop for SlotFollower {
    fn drop(&mut self) {
        self.0.followers.fetch_sub(1, Ordering::Relaxed);
    }
}

#[derive(Default)]
struct OutputState {
    count: u64,
    newest: Option<Arc<NewestSample>>,
    /// The newest sample and those shortly before it, if there are followers: events arrive in bursts, in which the newest one
    /// would hide the others.
    recent: VecDeque<Arc<NewestSample>>,
    arrivals: VecDeque<(Instant, Time)>,
    topic: Option<Arc<str>>,
    /// Type of the samples for viewers, once one has needed it.
    schema: Option<Arc<ChannelSchema>>,
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
            followers: AtomicUsize::new(0),
            state: Mutex::default(),
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
        if self.followers.load(Ordering::Relaxed) == 0 {
            state.recent.clear();
        } else {
            if state.recent.len() == RECENT {
                state.recent.pop_front();
            }
            let is_recent =
                |it: &Arc<NewestSample>| arrived.duration_since(it.arrived) < RECENT_AGE;
            state.recent.retain(is_recent);
            state.recent.push_back(Arc::clone(&newest));
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
    pub(crate) fn all_newer_than(&self, number: u64) -> Vec<Arc<NewestSample>> {
        let state = self.state();
        let newest = state.newest.iter().filter(|_| state.recent.is_empty());
        let newer = state.recent.iter().chain(newest);
        newer.filter(|it| it.number > number).cloned().collect()
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

    pub(crate) fn summary(&self, now: Instant) -> Option<OutputSummary> {
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
            let newer = slot.all_newer_than(since).into_iter();
            newer.map(|it| it.number).collect::<Vec<_>>()
        };
        let publish = || slot.publish(Time::ZERO, None, &Datum::Null);
        (0..3).for_each(|_| publish());
        assert_eq!(numbers(0), [3]);
        let follower = SlotFollower::new(&slot);
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
}
