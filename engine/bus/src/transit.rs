//! The time that messages wait on their way, measured without comparing clocks.
//!
//! Each message carries the time of its sending by a clock of its process. That clock and the receiver's differ by an unknown
//! amount, which is the same for all messages of a stream. The fastest message shows it: another one waited for as long as it
//! took longer. This includes the time in the broker, in sockets behind a broken link, and in a receiver that was stopped.

use std::time::{Duration, Instant};

/// Time after which the fastest message of a stream is determined anew.
const WINDOW: Duration = Duration::from_secs(10);
/// Part of the time since the fastest message by which the clocks of two machines may have drifted apart: 200 ppm.
const DRIFT: u32 = 5000;

/// The fastest messages of a stream.
#[derive(Debug, Clone, Copy, Default)]
pub struct TransitTimes {
    /// The fastest message since the beginning of the window, and the one of the window before.
    fastest: [Option<FastestMessage>; 2],
}

#[derive(Debug, Clone, Copy)]
struct FastestMessage {
    /// Difference of the receiver's clock and the sender's when it arrived, in nanoseconds.
    offset: i128,
    arrived: Instant,
    /// Beginning of its window.
    window: Instant,
}

impl TransitTimes {
    /// Returns whether a message has shown how the two clocks differ.
    pub fn is_known(&self) -> bool {
        self.fastest.iter().any(Option::is_some)
    }

    /// Returns how long a message waited that was sent at this time, in nanoseconds of the sender's clock, and has arrived
    /// now. The first message of a stream did not wait, as far as this can be seen.
    pub fn waited(&mut self, sent: u64, origin: Instant, now: Instant) -> Duration {
        let offset = now.duration_since(origin).as_nanos() as i128 - i128::from(sent);
        let [current, previous] = &mut self.fastest;
        let window = match *current {
            Some(fastest) if now - fastest.window < WINDOW => fastest.window,
            Some(_) | None => {
                *previous = current.take();
                now
            }
        };
        if current.is_none_or(|fastest| offset < fastest.offset) {
            *current = Some(FastestMessage {
                offset,
                arrived: now,
                window,
            });
        }
        let waits = self.fastest.iter().flatten().map(|fastest| {
            let wait = u64::try_from(offset - fastest.offset).unwrap_or(0);
            Duration::from_nanos(wait).saturating_sub((now - fastest.arrived) / DRIFT)
        });
        waits.max().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Waits of messages that were sent and arrived at these times, in ms; the clocks differ by an hour.
    fn waits(messages: &[(u64, u64)]) -> Vec<u128> {
        let (mut times, origin) = (TransitTimes::default(), Instant::now());
        let waits = messages.iter().map(|(sent, arrived)| {
            let sent = Duration::from_millis(3_600_000 + sent).as_nanos() as u64;
            let now = origin + Duration::from_millis(*arrived);
            times.waited(sent, origin, now).as_millis()
        });
        waits.collect()
    }

    #[test]
    fn what_waited_took_longer_than_the_fastest() {
        let steady = waits(&[(0, 7), (100, 107), (200, 205), (300, 307)]);
        assert_eq!(steady, [0, 0, 0, 1]);
        // four messages that arrive together when the link is back, and one after them
        let held = waits(&[(0, 5), (100, 3000), (200, 3000), (2990, 3000), (3100, 3105)]);
        assert_eq!(held, [0, 2894, 2794, 4, 0]);
    }

    #[test]
    fn a_wait_shows_after_a_long_silence_and_drift_is_no_wait() {
        let hour = 3_600_000;
        // clocks that drift apart by 100 ppm
        assert_eq!(waits(&[(0, 5), (hour, hour + 365)]), [0, 0]);
        assert_eq!(waits(&[(0, 5), (0, hour)]), [0, hour as u128 - 5 - 720]);
    }

    #[test]
    fn a_clock_that_stood_still_is_forgotten_after_two_windows() {
        // the sender's machine slept for a minute
        let messages: Vec<_> = (0..30)
            .map(|n| (n * 1000, n * 1000 + 5 + 60_000 * u64::from(n > 0)))
            .collect();
        let waits = waits(&messages);
        assert_eq!(waits[..2], [0, 59_987]);
        assert!(waits[21..].iter().all(|wait| *wait == 0), "{waits:?}");
    }
}
