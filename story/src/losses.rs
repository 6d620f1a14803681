//! Losses that go on: reported when they begin, and then with their number at growing intervals and when they end.

use std::collections::BTreeMap;
use std::time::Duration;

use asmotion_component::Time;

/// Time from the first report to the second; it doubles with each further one.
const FIRST_INTERVAL: Duration = Duration::from_secs(2);

/// The longest time between two reports.
const LONGEST_INTERVAL: Duration = Duration::from_secs(120);

/// Losses without another one for this time have ended.
const OVER: Duration = Duration::from_secs(10);

/// Where messages are lost: the writer, its port, and the reader.
pub(super) type LossPlace = (String, String, String);

/// The losses that go on, by place.
#[derive(Debug, Default)]
pub(super) struct OngoingLosses(BTreeMap<LossPlace, OngoingLoss>);

#[derive(Debug)]
struct OngoingLoss {
    reported_at: Time,
    interval: Duration,
    last_at: Time,
    /// The last entry, unless it has been reported.
    unreported: Option<String>,
}

impl OngoingLosses {
    /// Returns whether a loss is reported; otherwise its entry is kept.
    pub(super) fn is_due(&mut self, at: Time, place: LossPlace, line: &str) -> bool {
        let Some(loss) = self.0.get_mut(&place) else {
            let loss = OngoingLoss {
                reported_at: at,
                interval: FIRST_INTERVAL,
                last_at: at,
                unreported: None,
            };
            self.0.insert(place, loss);
            return true;
        };
        loss.last_at = at;
        if at.since(loss.reported_at) < loss.interval {
            loss.unreported = Some(line.to_owned());
            return false;
        }
        loss.reported_at = at;
        loss.interval = (2 * loss.interval).min(LONGEST_INTERVAL);
        loss.unreported = None;
        true
    }

    /// Lets time pass. Returns the last entries of losses that have ended, if they have not been reported.
    pub(super) fn ended(&mut self, at: Time) -> Vec<String> {
        let mut ended = Vec::new();
        self.0.retain(|_, loss| {
            let is_over = at.since(loss.last_at) >= OVER;
            if is_over {
                ended.extend(loss.unreported.take());
            }
            !is_over
        });
        ended
    }

    /// The last entries that have not been reported, with their times, for the end of a run.
    pub(super) fn rest(&mut self) -> Vec<(Time, String)> {
        let losses = std::mem::take(&mut self.0).into_values();
        let unreported = losses.filter_map(|loss| Some((loss.last_at, loss.unreported?)));
        let mut unreported: Vec<(Time, String)> = unreported.collect();
        unreported.sort_by_key(|(at, _)| *at);
        unreported
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(to: &str) -> LossPlace {
        ("A".to_owned(), "out".to_owned(), to.to_owned())
    }

    #[test]
    fn losses_are_reported_at_the_beginning_at_growing_intervals_and_at_the_end() {
        let mut losses = OngoingLosses::default();
        let at = |tenths: u64| Time::ZERO + Duration::from_millis(100 * tenths);
        let mut reported = Vec::new();
        for tenths in 0..=600 {
            assert_eq!(losses.ended(at(tenths)), [""; 0]);
            if losses.is_due(at(tenths), place("B"), &format!("{}", tenths + 1)) {
                reported.push(tenths);
            }
        }
        assert_eq!(reported, [0, 20, 60, 140, 300]);
        assert!(losses.is_due(at(601), place("C"), "another place"));
        assert_eq!(losses.ended(at(699)), [""; 0]);
        assert_eq!(losses.ended(at(701)), ["601"]);
        // they have ended, so this is the first one again
        assert!(losses.is_due(at(702), place("B"), "602"));
        assert!(!losses.is_due(at(703), place("B"), "603"));
        assert_eq!(losses.rest(), [(at(703), "603".to_owned())]);
    }
}
