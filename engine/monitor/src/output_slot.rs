//! The newest sample of an output, and how regularly it arrives.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use asmotion_component::Time;
use asmotion_datum::Sample;

use crate::rendering;

/// Number of samples over which a rate is measured.
const WINDOW: usize = 32;
/// Number of samples from which an output counts as regular, so that its silence means something.
const REGULAR: usize = 8;
/// Minimum silence after which an output is stale, whatever its rate.
const PATIENCE: Duration = Duration::from_secs(1);
/// Mean interval in seconds of the run from which samples count as events.
const RARE_S: f64 = 0.5;
/// Number of intervals after which a silent output is stale.
const GAPS: u32 = 4;

/// An output of a component.
pub(crate) struct OutputSlot {
    /// Full name, `Component.port`.
    pub name: Arc<str>,
    state: Mutex<OutputState>,
}

#[derive(Default)]
struct OutputState {
    count: u64,
    newest: Option<Arc<NewestSample>>,
    arrivals: VecDeque<(Instant, Time)>,
    topic: Option<Arc<str>>,
}

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
        self.json.get_or_init(|| match self.sample.to_datum() {
            Ok(datum) => rendering::json(&datum).into(),
            Err(error) => {
                let error = rendering::quoted(&error.to_string());
                format!("{{\"error\":{error}}}").into()
            }
        })
    }

    pub(crate) fn kind(&self) -> &'static str {
        self.sample.type_name()
    }
}

impl OutputSlot {
    pub(crate) fn new(name: String) -> Self {
        Self {
            name: name.into(),
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
        state.newest = Some(Arc::new(NewestSample {
            number: state.count,
            at,
            arrived,
            sample,
            json: OnceLock::new(),
        }));
    }

    /// The newest sample, if it is newer than this one.
    pub(crate) fn newer_than(&self, number: u64) -> Option<Arc<NewestSample>> {
        let state = self.state();
        state.newest.clone().filter(|newest| newest.number > number)
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
}
