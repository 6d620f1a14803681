//! Numbers of the messages that pass a mapping, for tools that show the bridge.

use std::time::{Duration, Instant};

use asmotion_component::Losses;
use asmotion_datum::Datum;

/// Length of the interval over which a rate is counted.
const INTERVAL: Duration = Duration::from_secs(1);

/// The messages that have passed a mapping.
#[derive(Debug, Default)]
pub(crate) struct Traffic {
    total: u64,
    /// When the interval began that counts now.
    since: Option<Instant>,
    /// Messages in it.
    counted: u64,
    /// Messages in the interval before, and its length.
    before: Option<(u64, Duration)>,
    last: Option<Instant>,
}

impl Traffic {
    /// Counts messages that pass now.
    pub(crate) fn pass(&mut self, messages: u64, now: Instant) {
        if messages == 0 {
            return;
        }
        let since = *self.since.get_or_insert(now);
        let length = now.saturating_duration_since(since);
        if length >= INTERVAL {
            self.before = Some((self.counted, length));
            (self.since, self.counted) = (Some(now), 0);
        }
        self.total += messages;
        self.counted += messages;
        self.last = Some(now);
    }

    /// Messages per second; 0 when none has passed for two intervals.
    fn rate(&self, now: Instant) -> f64 {
        let age = self.last.map(|last| now.saturating_duration_since(last));
        let is_silent = age.is_none_or(|age| age > 2 * INTERVAL);
        let of = |(count, length): (u64, Duration)| count as f64 / length.as_secs_f64();
        self.before.filter(|_| !is_silent).map_or(0.0, of)
    }

    /// The numbers with those that were lost, as the bridge describes itself.
    pub(crate) fn describe(&self, losses: Losses, now: Instant) -> Datum {
        let number = |count: u64| Datum::Int(i64::try_from(count).unwrap_or(i64::MAX));
        let age = self.last.map(|last| now.saturating_duration_since(last));
        // a tenth of a unit is more than a reader needs
        let rounded = |value: f64| Datum::Float((value * 10.0).round() / 10.0);
        Datum::record([
            ("messages", number(self.total)),
            ("per_second", rounded(self.rate(now))),
            (
                "age_s",
                age.map_or(Datum::Null, |age| rounded(age.as_secs_f64())),
            ),
            ("dropped", number(losses.dropped)),
            ("unsuitable", number(losses.misfits)),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_and_ages_are_those_of_the_last_second() {
        let (mut traffic, start) = (Traffic::default(), Instant::now());
        let at = |milliseconds| start + Duration::from_millis(milliseconds);
        for step in 0..=20 {
            traffic.pass(5, at(step * 100));
        }
        let losses = Losses {
            dropped: 3,
            misfits: 1,
        };
        let text = |traffic: &Traffic, now| traffic.describe(losses, at(now)).to_string();
        let found = text(&traffic, 2300);
        for part in [
            "messages: 105",
            "per_second: 50.0",
            "age_s: 0.3",
            "dropped: 3",
            "unsuitable: 1",
        ] {
            assert!(found.contains(part), "{part}: {found}");
        }
        // silence
        let found = text(&traffic, 9000);
        assert!(
            found.contains("per_second: 0.0") && found.contains("age_s: 7.0"),
            "{found}"
        );
        let none = Traffic::default();
        assert!(text(&none, 0).contains("age_s: null"), "{}", text(&none, 0));
    }
}
