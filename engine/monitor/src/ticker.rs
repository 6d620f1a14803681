//! The clock of all clients of a kind. Clocks of the same interval tick at the same time: the thread wakes once for all of them, with
//! one timer, and what one client has needed in a tick is there for the next one.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::Notify;
use tokio::time::sleep_until;

/// The shortest interval of a clock. Those of all clocks are multiples of it, so that one wake-up of the thread serves all clients that are
/// due, of whatever kind and rate.
pub(crate) const TICK: Duration = Duration::from_micros(16_667);

/// The shortest interval of a clock at which a rate in Hz is not exceeded.
pub(crate) fn interval_at(hz: f64) -> Duration {
    let ticks = (1.0 / (hz * TICK.as_secs_f64())).ceil();
    // a rate that is no number, or too low for a number of ticks, has the longest interval
    TICK * (ticks.clamp(1.0, 1e6) as u32)
}

/// A client of a ticker, with what all of its clients share.
pub(crate) trait Ticked<S>: Send + Sync {
    /// A tick, if it is due by now. Returns the time of the next one.
    fn tick(&self, now: Instant, shared: &mut S) -> Instant;
}

/// What clients share.
pub(crate) trait Shared: Default + Send + 'static {
    /// The clients tick at this time.
    fn begin(&mut self, now: Instant);
}

/// The clients that tick together.
pub(crate) struct Ticker<S> {
    clients: Mutex<TickedClients<S>>,
    /// Locked before a client, never after it.
    shared: Mutex<S>,
    /// A client is new, or ticks at another time.
    changed: Notify,
}

/// Locked before what they share.
struct TickedClients<S> {
    all: Vec<Arc<dyn Ticked<S>>>,
    /// Whether a task ticks, which it does as long as there are clients.
    is_ticking: bool,
}

/// Lets a client tick as long as this exists.
pub(crate) struct TickGuard<S: Shared> {
    ticker: Arc<Ticker<S>>,
    client: Arc<dyn Ticked<S>>,
}

impl<S: Shared> Ticker<S> {
    pub(crate) fn new() -> Arc<Self> {
        Arc::new(Self {
            clients: Mutex::new(TickedClients {
                all: Vec::new(),
                is_ticking: false,
            }),
            shared: Mutex::default(),
            changed: Notify::new(),
        })
    }

    fn clients(&self) -> MutexGuard<'_, TickedClients<S>> {
        self.clients.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Locks what the clients share.
    pub(crate) fn shared(&self) -> MutexGuard<'_, S> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a client.
    pub(crate) fn add(self: &Arc<Self>, client: Arc<dyn Ticked<S>>) -> TickGuard<S> {
        let mut clients = self.clients();
        clients.all.push(Arc::clone(&client));
        if !std::mem::replace(&mut clients.is_ticking, true) {
            tokio::spawn(Arc::clone(self).run());
        }
        drop(clients);
        self.rearrange();
        TickGuard {
            ticker: Arc::clone(self),
            client,
        }
    }

    /// A client ticks at another time than before.
    pub(crate) fn rearrange(&self) {
        self.changed.notify_one();
    }

    /// Ticks until no client is left.
    async fn run(self: Arc<Self>) {
        while let Some(next) = self.tick() {
            tokio::select! {
                () = sleep_until(next.into()) => {}
                () = self.changed.notified() => {}
            }
        }
    }

    /// Lets the clients tick that are due. Returns the time at which the next one is; `None` without clients.
    fn tick(&self) -> Option<Instant> {
        let now = Instant::now();
        let mut clients = self.clients();
        let mut shared = self.shared();
        shared.begin(now);
        let next = clients.all.iter().map(|it| it.tick(now, &mut shared)).min();
        clients.is_ticking = next.is_some();
        next
    }
}

impl<S: Shared> Drop for TickGuard<S> {
    fn drop(&mut self) {
        let mut clients = self.ticker.clients();
        clients.all.retain(|it| !Arc::ptr_eq(it, &self.client));
        drop(clients);
        self.ticker.rearrange();
    }
}

/// Number of the interval of this length that a time lies in, since the first call. Two times in the same interval have the same number
/// for every client.
pub(crate) fn interval_number(interval: Duration, at: Instant) -> u64 {
    let number = since_beginning(at).as_nanos() / interval.as_nanos().max(1);
    // an interval of a nanosecond lasts for centuries
    u64::try_from(number).unwrap_or(u64::MAX)
}

/// The next tick of a clock of this interval. Missed ticks are not made up for.
pub(crate) fn next_tick(interval: Duration, now: Instant) -> Instant {
    let into = since_beginning(now).as_nanos() % interval.as_nanos().max(1);
    // an interval is shorter than a century
    now + interval.saturating_sub(Duration::from_nanos(u64::try_from(into).unwrap_or(0)))
}

fn since_beginning(at: Instant) -> Duration {
    static BEGUN: OnceLock<Instant> = OnceLock::new();
    at.saturating_duration_since(*BEGUN.get_or_init(|| at))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_clock_ticks_together_with_a_fast_one() {
        let begun = Instant::now();
        let of = |hz| interval_at(hz).as_micros() / TICK.as_micros();
        assert_eq!(
            [60.0, 50.0, 30.0, 20.0, 5.0, 1.0].map(of),
            [1, 2, 2, 3, 12, 60]
        );
        for hz in [30.0, 20.0, 5.0, 1.0] {
            let mut slow = begun;
            for _ in 0..20 {
                slow = next_tick(interval_at(hz), slow);
                let before = slow - Duration::from_nanos(1);
                assert_eq!(next_tick(TICK, before), slow, "{hz} Hz");
            }
        }
    }

    #[test]
    fn clocks_of_an_interval_tick_at_the_same_time() {
        let interval = Duration::from_millis(20);
        let begun = Instant::now();
        let first = next_tick(interval, begun);
        assert!(first > begun && first <= begun + interval);
        let later = first - Duration::from_nanos(1);
        assert_eq!(next_tick(interval, later), first);
        assert_eq!(next_tick(interval, first), first + interval);
        let numbers = [later, first].map(|at| interval_number(interval, at));
        assert_eq!(numbers[0] + 1, numbers[1]);
    }
}
