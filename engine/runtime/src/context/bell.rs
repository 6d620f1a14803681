//! Wakes executor threads for components, without a lock: a bit for each component group and one for each idle thread.

use std::cell::{Cell, RefCell};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::Thread;

use crate::growing_table::GrowingTable;

/// Number of bits in a word.
const BITS: usize = 64;

thread_local! {
    /// The bell of the turn that this thread runs; `None` outside of turns.
    static TURN_OF: RefCell<Option<Arc<ExecutorBell>>> = const { RefCell::new(None) };
    /// The turn has woken a seat, and no thread was unparked for it.
    static HAS_NOTED: Cell<bool> = const { Cell::new(false) };
}

/// Tells executor threads which seats have work. A seat is the place of a component and its slaves among the executor
/// threads. Any thread wakes a seat, also one with a real-time priority, which must not wait for an executor thread.
///
/// A thread that becomes idle sets its bit in `idle`, looks at `woken` once more, and only then parks. A thread that wakes a
/// seat sets a bit in `woken` before it looks for an idle thread. All these accesses are `SeqCst`, so that in their single
/// order one of the two sees the other's bit: the idle thread does not park, or it is unparked. No wake-up is lost.
///
/// A thread that wakes a seat in a turn of its own unparks nobody: it looks at `woken` after the turn, and runs the seat itself.
/// This saves a system call, and a second thread that would find nothing. Cycles wake others at their end, so this delays
/// nothing; before a slave's cycle, [`ring_for_noted`] makes up for it.
#[derive(Default)]
pub(crate) struct ExecutorBell {
    /// The seats with new commands, data or requests. Taken by executor threads.
    woken: BitTable,
    /// The threads that are parked or about to park, by number. A bit is cleared by whoever unparks the thread, or by
    /// the thread itself.
    idle: BitTable,
    /// The threads by number; set once, before the thread becomes idle for the first time.
    threads: Handles,
}

/// Bits by position.
struct BitTable(GrowingTable<AtomicU64>);

struct Handles(GrowingTable<OnceLock<Thread>>);

impl Default for BitTable {
    fn default() -> Self {
        Self(GrowingTable::with_room(1))
    }
}

impl Default for Handles {
    fn default() -> Self {
        Self(GrowingTable::with_room(1))
    }
}

impl BitTable {
    /// Sets a bit. Returns whether it was clear.
    fn set(&self, position: usize) -> bool {
        self.change(position, |word, bit| {
            word.fetch_or(bit, Ordering::SeqCst) & bit == 0
        })
    }

    /// Clears a bit. Returns whether it was set.
    fn clear(&self, position: usize) -> bool {
        self.change(position, |word, bit| {
            word.fetch_and(!bit, Ordering::SeqCst) & bit != 0
        })
    }

    fn change(&self, position: usize, change: impl Fn(&AtomicU64, u64) -> bool) -> bool {
        let word = self.0.get(position / BITS);
        word.is_some_and(|word| change(word, 1 << (position % BITS)))
    }

    /// Takes the lowest bit that is set.
    fn take_one(&self) -> Option<usize> {
        for (number, word) in self.0.iter().enumerate() {
            loop {
                let bits = word.load(Ordering::SeqCst);
                if bits == 0 {
                    break;
                }
                let position = number * BITS + lowest(bits);
                if self.clear(position) {
                    return Some(position);
                }
            }
        }
        None
    }

    /// Clears all bits, and passes the positions of those that were set to `taken`.
    fn take_all(&self, mut taken: impl FnMut(usize)) {
        for (number, word) in self.0.iter().enumerate() {
            if word.load(Ordering::SeqCst) == 0 {
                continue;
            }
            let mut bits = word.swap(0, Ordering::SeqCst);
            while bits != 0 {
                taken(number * BITS + lowest(bits));
                bits &= bits - 1;
            }
        }
    }

    fn is_empty(&self) -> bool {
        let mut words = self.0.iter();
        words.all(|word| word.load(Ordering::SeqCst) == 0)
    }
}

/// Position of the lowest bit of a word that is not zero.
fn lowest(bits: u64) -> usize {
    usize::try_from(bits.trailing_zeros()).unwrap_or_default()
}

impl ExecutorBell {
    /// Makes room for a seat. Called before it is woken.
    pub(crate) fn add_seat(&self, seat: usize) {
        self.woken.0.extend_to(seat / BITS);
    }

    /// Makes room for a thread. Called before it is started.
    pub(crate) fn add_thread(&self, number: usize) {
        self.idle.0.extend_to(number / BITS);
        self.threads.0.extend_to(number);
    }

    /// Records the handle of a thread. Called once, by the thread itself.
    pub(crate) fn set_thread(&self, number: usize, thread: Thread) {
        if let Some(handle) = self.threads.0.get(number) {
            // never set twice: numbers are not reused
            let _ = handle.set(thread);
        }
    }

    /// Announces work for a seat.
    pub(crate) fn wake(&self, seat: usize) {
        // whoever has set the bit before has rung, is about to, or looks after its turn
        if !self.woken.set(seat) {
            return;
        }
        if self.is_in_turn() {
            HAS_NOTED.set(true);
        } else {
            self.ring();
        }
    }

    /// Announces work for a seat without waking a thread: the current one looks at the seats next.
    pub(crate) fn note(&self, seat: usize) {
        self.woken.set(seat);
    }

    /// Runs a turn in the current thread, which looks at the seats afterwards.
    pub(crate) fn during_turn<T>(self: &Arc<Self>, turn: impl FnOnce() -> T) -> T {
        /// Ends the turn, also after a panic.
        struct TurnEnd;
        impl Drop for TurnEnd {
            fn drop(&mut self) {
                TURN_OF.take();
                HAS_NOTED.set(false);
            }
        }
        let _end = TurnEnd;
        TURN_OF.set(Some(Arc::clone(self)));
        turn()
    }

    /// Returns whether the current thread runs a turn of these executor threads.
    fn is_in_turn(&self) -> bool {
        TURN_OF.with_borrow(|it| it.as_ref().is_some_and(|it| std::ptr::eq(&**it, self)))
    }

    /// Unparks an idle thread. Returns `false` if there is none.
    pub(crate) fn ring(&self) -> bool {
        let Some(number) = self.idle.take_one() else {
            return false;
        };
        self.unpark(number);
        true
    }

    pub(crate) fn unpark(&self, number: usize) {
        let handle = self.threads.0.get(number).and_then(OnceLock::get);
        if let Some(thread) = handle {
            thread.unpark();
        }
    }

    /// Takes the seats that have been woken.
    pub(crate) fn take_woken(&self, taken: impl FnMut(usize)) {
        self.woken.take_all(taken);
    }

    /// Runs `park` in the thread with this number unless a seat has been woken; a seat that is woken meanwhile unparks the
    /// thread, or another idle one.
    pub(crate) fn while_idle(&self, number: usize, park: impl FnOnce()) {
        self.idle.set(number);
        if self.woken.is_empty() {
            park();
        }
        self.idle.clear(number);
    }
}

/// Unparks a thread for the seats that the current turn has woken, if any, because it goes on.
pub(crate) fn ring_for_noted() {
    if HAS_NOTED.take() {
        TURN_OF.with_borrow(|it| it.as_ref().map(|it| it.ring()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, AtomicUsize};

    /// Seats that are woken by several threads, each counted until its executor thread has seen it.
    #[test]
    fn no_wake_up_is_lost() {
        const SEATS: usize = 130;
        const ROUNDS: usize = 4_000;
        let bell = Arc::new(ExecutorBell::default());
        bell.add_seat(SEATS);
        let work: Arc<Vec<AtomicUsize>> =
            Arc::new((0..SEATS).map(|_| AtomicUsize::new(0)).collect());
        let ended = Arc::new(AtomicBool::new(false));
        let done = Arc::new(AtomicUsize::new(0));
        let executors: Vec<_> = (0..3)
            .map(|number| {
                bell.add_thread(number);
                let (bell, work) = (Arc::clone(&bell), Arc::clone(&work));
                let (ended, done) = (Arc::clone(&ended), Arc::clone(&done));
                std::thread::spawn(move || {
                    bell.set_thread(number, std::thread::current());
                    while !ended.load(Ordering::SeqCst) {
                        let mut taken = 0;
                        bell.take_woken(|seat| taken += work[seat].swap(0, Ordering::SeqCst));
                        done.fetch_add(taken, Ordering::SeqCst);
                        // without a timeout: only the bell ends it
                        bell.while_idle(number, std::thread::park);
                    }
                })
            })
            .collect();
        let wakers: Vec<_> = (0..2)
            .map(|waker| {
                let (bell, work, done) = (Arc::clone(&bell), Arc::clone(&work), Arc::clone(&done));
                std::thread::spawn(move || {
                    for round in 0..ROUNDS {
                        let seat = (round * 7 + waker * 61) % SEATS;
                        work[seat].fetch_add(1, Ordering::SeqCst);
                        bell.wake(seat);
                        // lets the executors become idle now and then, which is when a wake-up could be lost
                        if round % 16 == 0 {
                            while done.load(Ordering::SeqCst) < round {
                                std::thread::yield_now();
                            }
                        }
                    }
                })
            })
            .collect();
        for waker in wakers {
            waker.join().unwrap();
        }
        while done.load(Ordering::SeqCst) < 2 * ROUNDS {
            std::thread::yield_now();
        }
        ended.store(true, Ordering::SeqCst);
        for (number, executor) in executors.into_iter().enumerate() {
            bell.unpark(number);
            executor.join().unwrap();
        }
        assert_eq!(done.load(Ordering::SeqCst), 2 * ROUNDS);
    }
}
