//! Times in which this process stood still: it was stopped, or its machine was.
//!
//! A message without a time of its sending can have arrived while nobody looked. A thread looks at the clock all the time; where
//! it missed its time by far, everything else in the process stood still, too.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Interval of the looks at the clock.
const LOOK: Duration = Duration::from_millis(25);
/// Shortest time without a look that counts. Schedulers delay threads by some milliseconds as well.
const STANDSTILL: Duration = Duration::from_millis(250);
/// Number of standstills that are remembered.
const REMEMBERED: usize = 64;

/// The standstills of this process since they were first asked for.
#[derive(Debug)]
pub struct Standstills {
    looks: Mutex<Looks>,
}

#[derive(Debug)]
struct Looks {
    last: Instant,
    /// Beginning and end of each standstill, oldest first.
    gaps: VecDeque<(Instant, Instant)>,
}

impl Standstills {
    /// The standstills of this process. The first call starts the thread that looks at the clock; without a thread, no standstill
    /// is seen.
    pub fn of_process() -> &'static Self {
        static OF_PROCESS: OnceLock<Standstills> = OnceLock::new();
        static THREAD: OnceLock<()> = OnceLock::new();
        let standstills = OF_PROCESS.get_or_init(|| Self::beginning_at(Instant::now()));
        THREAD.get_or_init(|| {
            let looks = || {
                loop {
                    thread::sleep(LOOK);
                    drop(standstills.look(Instant::now()));
                }
            };
            // the operating system has no thread left, which other parts report
            let _ = thread::Builder::new()
                .name("standstill".to_owned())
                .spawn(looks);
        });
        standstills
    }

    fn beginning_at(now: Instant) -> Self {
        let looks = Looks {
            last: now,
            gaps: VecDeque::new(),
        };
        Self {
            looks: Mutex::new(looks),
        }
    }

    /// Returns for how long, at most, something has waited that arrived after `since`, and that this process would have noticed at
    /// once if it had not stood still. Zero if it did not.
    pub fn waited(&self, since: Instant) -> Duration {
        self.waited_until(Instant::now(), since)
    }

    fn waited_until(&self, now: Instant, since: Instant) -> Duration {
        let looks = self.look(now);
        let mut gaps = looks.gaps.iter();
        let first = gaps.find(|(_, end)| *end > since);
        first.map_or(Duration::ZERO, |(begin, _)| {
            now.saturating_duration_since(since.max(*begin))
        })
    }

    /// Notes that the process runs at this time.
    fn look(&self, now: Instant) -> MutexGuard<'_, Looks> {
        let mut looks = self.looks.lock().unwrap_or_else(PoisonError::into_inner);
        if now.saturating_duration_since(looks.last) >= STANDSTILL {
            let gap = (looks.last, now);
            looks.gaps.push_back(gap);
            if looks.gaps.len() > REMEMBERED {
                looks.gaps.pop_front();
            }
        }
        looks.last = looks.last.max(now);
        looks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_arrived_during_a_standstill_waited_since_its_beginning_at_most() {
        let origin = Instant::now();
        let at = |ms: u64| origin + Duration::from_millis(ms);
        let standstills = Standstills::beginning_at(origin);
        let waited = |since, now| standstills.waited_until(at(now), at(since)).as_millis();
        // looks that a loaded machine delays are no standstill
        for look in [25, 50, 200, 400] {
            assert_eq!(waited(0, look), 0);
        }
        // stopped from 400 to 3400; nothing was there at 390
        assert_eq!(waited(390, 3400), 3000);
        // taken later, after others
        assert_eq!(waited(390, 3450), 3050);
        // there was nothing left at 3460
        assert_eq!(waited(3460, 3470), 0);
        // of two standstills, it may have arrived in the first
        assert_eq!(waited(3470, 5000), 1530);
        assert_eq!(waited(3460, 7000), 3530);
    }
}
