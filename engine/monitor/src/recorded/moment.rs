//! The messages about the moments of a recorded run.

use std::collections::BTreeMap;
use std::ops::Range;

use asmotion_component::Time;
use serde_json::{Value, json};

use super::{RecordedEntry, RecordedOutput, RecordedSteps, RunMoments};
use crate::log_entry::LogFilter;
use crate::past::{MomentRequest, Past};
use crate::rendering;
use crate::step_guards::KnownStep;

/// Number of steps or entries of a window before its moment, and after it.
const AROUND: (usize, usize) = (400, 200);
/// Limit on the number of those that a long span adds on each side.
const MOST: usize = 2000;
/// Limit on the number of samples of an output in a window, for charts.
const SERIES: usize = 4000;
/// Type of the samples of which a window has all, for charts.
const CHARTED: &str = "youbot/JointStatus";
/// Number of samples over which a rate is measured, as of a running system.
const RATE_SAMPLES: usize = 32;
/// Number of samples from which an output counts as regular, so that its silence means something.
const REGULAR: usize = 8;
/// Number of intervals after which a silent output is stale, but not before [`PATIENCE_S`].
pub(super) const REGULAR_FACTOR: f64 = 4.0;
/// Minimum silence after which an output is stale, in seconds.
pub(super) const PATIENCE_S: f64 = 1.0;

/// Whether something happened up to a time in seconds.
pub(super) fn seconds_until(at: Time, t: f64) -> bool {
    at.seconds() <= t + 1e-9
}

/// The part of a sequence that belongs to a window.
struct WindowRange {
    range: Range<usize>,
    /// Times between which the window need not be replaced, in seconds; infinite at an end of the sequence.
    valid: (f64, f64),
}

/// How an output fares at a time.
#[derive(Debug, PartialEq)]
struct OutputPace {
    /// Time since its newest sample, in seconds; `None` before the first one.
    age_s: Option<f64>,
    /// Mean interval between its last samples, in seconds; `None` before the second one.
    gap_s: Option<f64>,
    /// Whether an output with regular samples has fallen silent.
    is_stale: bool,
}

impl OutputPace {
    /// The pace at a time, from the times of the last samples up to then.
    fn of(recent: &[f64], t: f64) -> Self {
        let age_s = recent.last().map(|last| (t - last).max(0.0));
        let gap_s = match recent {
            [first, .., last] => Some((last - first) / (recent.len() - 1) as f64),
            [_] | [] => None,
        };
        let gap_s = gap_s.filter(|gap| *gap > 0.0);
        let limit = gap_s.map(|gap| (gap * REGULAR_FACTOR).max(PATIENCE_S));
        let is_silent = age_s.zip(limit).is_some_and(|(age, limit)| age > limit);
        Self {
            age_s,
            gap_s,
            is_stale: is_silent && recent.len() >= REGULAR,
        }
    }
}

impl Past for RunMoments {
    fn end(&self) -> Time {
        self.end
    }

    fn known_step(&self, component: &str, number: u64, t: f64) -> Option<KnownStep> {
        let recorded = self.steps.get(component)?;
        let (steps, from) = (&recorded.steps, |at: &Time| at.seconds() < t - 1e-6);
        let first = steps.partition_point(|(at, _)| from(at));
        let near = steps.get(first..)?.iter();
        let mut near = near.take_while(|(at, _)| seconds_until(*at, t + 1e-6));
        let index = first + near.position(|(_, step)| step.number == number)?;
        let (at, record) = steps.get(index)?;
        let before = match recorded.begins.get(&index) {
            Some(begin) => begin.state.clone(),
            None => {
                let state = recorded.state_before(index);
                let values = state.values();
                let owned = values.map(|(location, value)| (location.to_owned(), value.to_owned()));
                owned.collect()
            }
        };
        Some(KnownStep {
            before,
            record: record.clone(),
            at: *at,
        })
    }

    fn moment(&self, request: &MomentRequest<'_>) -> String {
        let t = if request.t.is_finite() {
            request.t
        } else {
            0.0
        };
        let t = t.clamp(0.0, self.end.seconds());
        let samples = request.outputs.iter().filter_map(|name| {
            let sample = self.outputs.get(*name)?.sample(t, request.has.get(*name));
            Some(format!("{}:{sample}", rendering::quoted(name)))
        });
        let samples: Vec<String> = samples.collect();
        let window = if request.window {
            self.window(t, request.span, request.log.as_ref())
        } else {
            Value::Null
        };
        let outputs = self.outputs.iter().map(|(name, it)| it.summary(name, t));
        let outputs: Vec<String> = outputs.collect();
        let components = if request.components {
            self.components.json(t, &self.steps)
        } else {
            "null".to_owned()
        };
        format!(
            "{{\"type\":\"moment\",\"t\":{t},\"outputs\":[{}],\"components\":{components},\"samples\":{{{}}},\"window\":{window}}}",
            outputs.join(","),
            samples.join(",")
        )
    }
}

impl RecordedOutput {
    /// Name, type, and the rate and age at a time as JSON, in the form of a running system.
    fn summary(&self, name: &str, t: f64) -> String {
        let count = self
            .samples
            .partition_point(|(at, _)| seconds_until(*at, t));
        let recent = self.samples.get(count.saturating_sub(RATE_SAMPLES)..count);
        let recent = recent.into_iter().flatten().map(|(at, _)| at.seconds());
        let pace = OutputPace::of(&recent.collect::<Vec<_>>(), t);
        json!({
            "name": name, "type": self.kind, "topic": self.topic, "n": count, "hz": pace.gap_s.map(f64::recip),
            "bytes": count.checked_sub(1).and_then(|last| self.samples.get(last)).map(|(_, data)| data.size()),
            "age_ms": pace.age_s.map(|age| (age * 1000.0).round()), "stale": pace.is_stale,
        })
        .to_string()
    }

    /// The newest sample at a time as JSON: `null` before the first one, without its data if the tab has it.
    fn sample(&self, t: f64, has: Option<&u64>) -> String {
        let number = self
            .samples
            .partition_point(|(at, _)| seconds_until(*at, t));
        let Some((at, data)) = number
            .checked_sub(1)
            .and_then(|last| self.samples.get(last))
        else {
            return "null".to_owned();
        };
        let head = format!("{{\"n\":{number},\"t\":{}", at.seconds());
        if has.is_some_and(|has| *has == number as u64) {
            return head + "}";
        }
        let data = match data.datum() {
            Ok(datum) => rendering::json(&datum),
            Err(error) => format!("{{\"error\":{}}}", rendering::quoted(&error.to_string())),
        };
        let kind = rendering::quoted(&self.kind);
        format!("{head},\"wall\":0,\"type\":{kind},\"data\":{data}}}")
    }

    /// The samples between two times as objects with a time, for charts.
    fn series(&self, (from, to): (f64, f64)) -> Vec<Value> {
        let first = self.samples.partition_point(|(at, _)| at.seconds() < from);
        let samples = self.samples.iter().skip(first);
        let samples = samples.take_while(|(at, _)| at.seconds() <= to);
        let objects = samples.take(SERIES).filter_map(|(at, data)| {
            let text = rendering::json(&data.datum().ok()?);
            let mut object: Value = serde_json::from_str(&text).ok()?;
            object["t"] = json!(at.seconds());
            Some(object)
        });
        objects.collect()
    }
}

impl RunMoments {
    /// Steps, states and entries around a time.
    fn window(&self, t: f64, span: f64, filter: Option<&LogFilter>) -> Value {
        let span = if span.is_finite() {
            span.clamp(1.0, 3600.0)
        } else {
            30.0
        };
        let mut valid = (f64::NEG_INFINITY, f64::INFINITY);
        let mut narrow = |window: &WindowRange| {
            valid = (valid.0.max(window.valid.0), valid.1.min(window.valid.1));
        };
        let (mut history, mut states) = (Vec::new(), BTreeMap::new());
        for (component, recorded) in &self.steps {
            let window = window_range(recorded.steps.len(), t, span, |index| {
                recorded
                    .steps
                    .get(index)
                    .map_or(0.0, |(at, _)| at.seconds())
            });
            states.insert(component, recorded.state_before(window.range.end));
            history.extend(recorded.entries(component, window.range.clone()));
            narrow(&window);
        }
        // of a part of the log, the window has as many entries as of the whole
        let mut entries = |all: &[RecordedEntry]| -> Vec<Value> {
            let takes = |it: &&RecordedEntry| filter.is_none_or(|filter| filter.takes(&it.entry));
            let all: Vec<&RecordedEntry> = all.iter().filter(takes).collect();
            let window = window_range(all.len(), t, span, |index| {
                all.get(index).map_or(0.0, |entry| entry.at.seconds())
            });
            narrow(&window);
            let entries = all.get(window.range).unwrap_or_default().iter();
            // what was written can be read
            let parsed = entries.filter_map(|it| serde_json::from_str(&it.entry.json).ok());
            parsed.collect()
        };
        let (log, calls) = (entries(&self.log), entries(&self.calls));
        let charted = self.outputs.iter().filter(|(_, it)| it.kind == CHARTED);
        let around = (t - span.max(120.0), t + span);
        let series: BTreeMap<_, _> = charted
            .map(|(name, it)| (name, it.series(around)))
            .collect();
        if !series.is_empty() {
            valid = (valid.0.max(t - span / 4.0), valid.1.min(t + span / 4.0));
        }
        let end = self.end.seconds();
        json!({
            "valid": [valid.0.max(-1.0), valid.1.min(end + 1.0)], "states": states, "history": history, "log": log,
            "calls": calls, "series": series, "filter": filter.map(|filter| filter.number),
        })
    }
}

impl RecordedSteps {
    /// Steps in the form of a running system.
    fn entries(&self, component: &str, range: Range<usize>) -> Vec<Value> {
        let first = range.start;
        let steps = self.steps.get(range).unwrap_or_default().iter();
        let entry = |(offset, (at, step)): (usize, &(Time, _))| {
            let index = first + offset;
            let mut entry =
                json!({ "t": at.seconds(), "component": component, "index": index, "step": step });
            // the state before a machine began does not follow from the updates of later steps
            if self.begins.contains_key(&index) {
                entry["before"] = json!(self.state_before(index));
            }
            entry
        };
        steps.enumerate().map(entry).collect()
    }
}

/// The part of a sequence, ordered by time, that belongs to the window around a time.
fn window_range(count: usize, t: f64, span: f64, time: impl Fn(usize) -> f64) -> WindowRange {
    let position = |t: f64| {
        let (mut low, mut high) = (0, count);
        while low < high {
            let middle = usize::midpoint(low, high);
            if time(middle) <= t {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    };
    let now = position(t);
    let before = (now - position(t - span)).clamp(AROUND.0, MOST);
    let after = (position(t + span) - now).clamp(AROUND.1, MOST);
    let (from, to) = (now.saturating_sub(before), (now + after).min(count));
    let low = if from == 0 {
        f64::NEG_INFINITY
    } else {
        time(from + before / 4)
    };
    let high = if to == count {
        f64::INFINITY
    } else {
        time(to - after / 4)
    };
    WindowRange {
        range: from..to,
        valid: (low, high),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_has_the_rate_and_the_age_of_its_time() {
        let never = OutputPace {
            age_s: None,
            gap_s: None,
            is_stale: false,
        };
        assert_eq!(OutputPace::of(&[], 9.0), never);
        let times: Vec<f64> = (0..10).map(|tick| 1.0 + f64::from(tick) * 0.5).collect();
        let pace = |t| OutputPace::of(&times, t);
        assert_eq!(
            (pace(5.75).age_s, pace(5.75).gap_s),
            (Some(0.25), Some(0.5))
        );
        assert_eq!([pace(7.5).is_stale, pace(7.6).is_stale], [false, true]);
        // a few samples do not make an output regular
        assert!(!OutputPace::of(&times[..7], 60.0).is_stale);
    }

    #[test]
    fn a_window_lies_around_its_time_and_says_how_far_it_reaches() {
        // ten a second
        let time = |index: usize| index as f64 / 10.0;
        let window = window_range(10_000, 500.0, 10.0, time);
        assert_eq!(window.range, 4601..5201);
        assert_eq!(window.valid, (470.1, 515.1));
        // a long span has more of them, up to a limit
        let window = window_range(10_000, 500.0, 100.0, time);
        assert_eq!(window.range, 4001..6001);
        let window = window_range(10_000, 500.0, 400.0, time);
        assert_eq!(window.range, 3001..7001);
        // at an end, it is valid up to there
        let window = window_range(10_000, 5.0, 10.0, time);
        assert_eq!((window.range.start, window.valid.0), (0, f64::NEG_INFINITY));
        let window = window_range(10_000, 2000.0, 10.0, time);
        assert_eq!((window.range.end, window.valid.1), (10_000, f64::INFINITY));
        assert_eq!(window_range(0, 1.0, 10.0, time).range, 0..0);
    }
}
