//! Compares the clocks of running processes with the clock of this machine.

use std::collections::BTreeMap;
use std::fmt;
use std::time::{Duration, Instant};

use asmotion_bus::{Bus, BusError, Envelope};

use crate::last_samples::now;
use crate::presence::{RobotPresence, key};
use crate::remote::listen;
use crate::roster::WORDS;

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
