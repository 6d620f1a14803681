//! Compares the clocks of running processes with the clock of this machine.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_bus::{Bus, BusError, Envelope};

use crate::last_samples::now;
use crate::presence::{RobotPresence, key};
use crate::remote::listen;
use crate::roster::WORDS;

/// Difference between two clocks that is reported; synchronised clocks differ by some milliseconds.
pub const CLOCK_TOLERANCE: Duration = Duration::from_millis(500);

/// What to do about clocks that differ.
pub const CLOCK_REMEDY: &str = "synchronise the clocks of all machines, with chrony or systemd-timesyncd: `timedatectl` shows whether they are;\nthe times in messages, logs and recordings of the two differ by as much; ages and deadlines of messages do not depend on them";

/// The clock of a process, compared with the clock of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClockOffset {
    /// Routing key of the process: its robot and its name.
    pub process: String,
    /// Time by which its clock is ahead, in nanoseconds; negative if it is behind. The time that a message takes makes it smaller.
    pub ahead: i64,
}

impl ClockOffset {
    /// Returns whether the clocks differ by more than `tolerance`.
    pub fn is_beyond(&self, tolerance: Duration) -> bool {
        self.difference() > tolerance
    }

    fn difference(&self) -> Duration {
        Duration::from_nanos(self.ahead.unsigned_abs())
    }
}

impl fmt::Display for ClockOffset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let direction = if self.ahead < 0 { "behind" } else { "ahead of" };
        write!(
            f,
            "the clock of process `{}` is {:.1} s {direction} that of this machine",
            self.process,
            self.difference().as_secs_f64()
        )
    }
}

/// Compares clocks by the presence messages that arrive within `time`; a process publishes one each second. Of several
/// messages, the fastest counts. The processes are in the order of their names.
///
/// # Errors
/// An error of the bus.
pub fn clock_offsets(bus: &dyn Bus, time: Duration) -> Result<Vec<ClockOffset>, BusError> {
    let presences = listen(bus, WORDS)?;
    let end = Instant::now() + time;
    let mut ahead: BTreeMap<String, i64> = BTreeMap::new();
    while let Some(envelope) = presences.next_within(end.saturating_duration_since(Instant::now()))
    {
        let received = now();
        if let Some(RobotPresence { robot, presence }) = RobotPresence::of(&envelope)
            && !presence.leaves
        {
            let offset = offset(&envelope, received);
            let known = ahead.entry(key(&robot, &presence.process));
            known
                .and_modify(|known| *known = offset.max(*known))
                .or_insert(offset);
        }
    }
    let offsets = ahead.into_iter();
    Ok(offsets
        .map(|(process, ahead)| ClockOffset { process, ahead })
        .collect())
}

/// Time by which the clock of a message's sender seems to be ahead, in nanoseconds.
fn offset(envelope: &Envelope, received: i64) -> i64 {
    let age = i64::try_from(envelope.age.as_nanos()).unwrap_or(i64::MAX);
    let sent = envelope.stamp.saturating_add(age);
    sent.saturating_sub(received)
}

/// Messages of a process after the fastest of which its clock is known to be behind: a slow message looks like a clock that is
/// behind, and never like one that is ahead.
const ENOUGH: u32 = 4;

/// The clocks of the other processes of a robot, by their presence messages.
#[derive(Debug, Default)]
pub(crate) struct ClockWatch {
    clocks: BTreeMap<Arc<str>, WatchedClock>,
}

#[derive(Debug)]
struct WatchedClock {
    /// Time by which it seems to be ahead, in nanoseconds, by the fastest message.
    ahead: i64,
    messages: u32,
    is_reported: bool,
}

impl ClockWatch {
    /// Records a presence message. Returns the difference of its sender's clock the first time it exceeds the tolerance.
    pub(crate) fn record(&mut self, presence: &Envelope, received: i64) -> Option<ClockOffset> {
        // within a process there is one clock, and a sender may leave out its time
        if presence.clock.is_empty() || presence.stamp == 0 {
            return None;
        }
        let ahead = offset(presence, received);
        let known = self.clocks.entry(Arc::clone(&presence.source));
        let clock = known.or_insert(WatchedClock {
            ahead,
            messages: 0,
            is_reported: false,
        });
        clock.ahead = clock.ahead.max(ahead);
        clock.messages = clock.messages.saturating_add(1);
        let is_certain = clock.ahead > 0 || clock.messages >= ENOUGH;
        let offset = ClockOffset {
            process: presence.source.to_string(),
            ahead: clock.ahead,
        };
        if clock.is_reported || !is_certain || !offset.is_beyond(CLOCK_TOLERANCE) {
            return None;
        }
        clock.is_reported = true;
        Some(offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_bus::Payload;
    use asmotion_datum::Datum;

    const SECOND: i64 = 1_000_000_000;

    fn presence(source: &str, stamp: i64, clock: &str) -> Envelope {
        Envelope {
            topic: "presence".into(),
            source: source.into(),
            incarnation: 1,
            sequence: 1,
            stamp,
            clock: clock.into(),
            age: Duration::from_secs(2),
            trace: None,
            type_name: "".into(),
            payload: Payload::of(Datum::Null),
        }
    }

    #[test]
    fn a_clock_is_reported_once_ahead_at_once_and_behind_after_a_fast_message() {
        let received = 1000 * SECOND;
        let reported = |offsets_s: &[i64]| {
            let mut watch = ClockWatch::default();
            let offsets = offsets_s.iter().map(|offset_s| {
                let sent = received - 2 * SECOND + offset_s * SECOND;
                let news = watch.record(&presence("station", sent, "wall:b"), received);
                news.map(|it| it.ahead / SECOND)
            });
            offsets.collect::<Vec<_>>()
        };
        assert_eq!(reported(&[30, 30]), [Some(30), None]);
        assert_eq!(
            reported(&[-9, -7, -8, -7, -7]),
            [None, None, None, Some(-7), None]
        );
        // three messages have waited
        assert_eq!(reported(&[-9, -7, -8, 0, -9]), [None; 5]);
    }

    #[test]
    fn a_sender_in_the_same_process_and_one_without_a_time_have_no_clock() {
        let mut watch = ClockWatch::default();
        for (stamp, clock) in [(900 * SECOND, ""), (0, "wall:b")] {
            for _ in 0..2 * ENOUGH {
                let presence = presence("station", stamp, clock);
                assert_eq!(watch.record(&presence, 1000 * SECOND), None);
            }
        }
    }
}
