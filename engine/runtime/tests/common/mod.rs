//! Messages, operations and a component made of closures, for tests.
#![allow(dead_code, missing_docs, clippy::unwrap_used, reason = "tests")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_component::{Component, Cycle, Fault, Interface, Operation};
use asmotion_runtime::{Live, Run};

asmotion_datum::message! {
    #[derive(Copy)]
    pub struct Number = "test/Number" {
        pub n: i64,
    }

    /// A velocity command.
    #[derive(Copy)]
    pub struct Twist = "test/Twist" {
        pub linear: f64,
        pub angular: f64,
    }

    pub struct Words = "test/Words" {
        pub words: String,
    }
}

pub fn number(n: i64) -> Number {
    Number { n }
}

/// Doubles a number.
pub struct Double;

impl Operation for Double {
    type Request = Number;
    type Response = Number;
    const INTERFACE: &'static str = "test/Arithmetic";
    const NAME: &'static str = "double";
}

/// Spells a number.
pub struct Spell;

impl Operation for Spell {
    type Request = Number;
    type Response = Words;
    const INTERFACE: &'static str = "test/Arithmetic";
    const NAME: &'static str = "spell";
}

/// A component whose cycle is a closure.
pub struct Behaviour<F>(pub F);

impl<F: FnMut(&mut Cycle<'_>) -> Result<(), Fault> + Send + 'static> Component for Behaviour<F> {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        (self.0)(cycle)
    }
}

/// A constructor from a closure that declares ports and returns the cycle.
pub fn behaviour<F>(
    declare: impl FnOnce(&mut Interface) -> F,
) -> impl FnOnce(&mut Interface) -> Box<dyn Component>
where
    F: FnMut(&mut Cycle<'_>) -> Result<(), Fault> + Send + 'static,
{
    move |interface| Box::new(Behaviour(declare(interface)))
}

/// Counts up, one a cycle, from 1, on output `n`.
pub fn counter() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    burst(1)
}

/// Counts up from 1 on output `n`, `size` samples a cycle.
pub fn burst(size: i64) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(move |interface| {
        let out = interface.output::<Number>("n", "the count");
        let mut n = 0;
        move |cycle| {
            for _ in 0..size {
                n += 1;
                cycle.write(out, number(n));
            }
            Ok(())
        }
    })
}

/// Provides `double` on service `sums`; replies in the cycle that sees the request.
pub fn doubler() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let double = interface.serve::<Double>("sums", "doubles");
        move |cycle| {
            for request in cycle.requests(double) {
                let n = request.argument.n * 2;
                cycle.reply(double, request.id, Ok(number(n)));
            }
            Ok(())
        }
    })
}

/// Number of attempts of a test in real time that count.
const ATTEMPTS: u32 = 5;

/// Time after which all attempts count.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs a test in real time until it passes, at most five times. A busy machine delays threads now and then; an executor that
/// is wrong fails every attempt. For a minute, an attempt does not count if a thread beside it that only sleeps was late too.
///
/// # Panics
/// Panics like the last attempt.
pub fn in_real_time(attempt: impl Fn()) {
    let begun = Instant::now();
    let mut counted = 0;
    loop {
        let control = Control::start();
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(&attempt));
        let is_busy = control.was_late();
        let Err(problem) = result else { return };
        counted += u32::from(!is_busy || begun.elapsed() > PATIENCE);
        if counted == ATTEMPTS {
            std::panic::resume_unwind(problem);
        }
        // the load can pass in the meantime
        std::thread::sleep(Duration::from_millis(200) * counted.max(1));
    }
}

/// A thread that sleeps again and again, to tell a busy machine from a late executor.
struct Control {
    end: Arc<AtomicBool>,
    /// The number of its sleeps, and of those that took longer than they should.
    thread: JoinHandle<(u32, u32)>,
}

impl Control {
    fn start() -> Self {
        let end = Arc::new(AtomicBool::new(false));
        let stop = Arc::clone(&end);
        let thread = std::thread::spawn(move || {
            let (mut sleeps, mut late) = (0, 0);
            let nap = Duration::from_millis(5);
            while !stop.load(Ordering::Relaxed) {
                let begun = Instant::now();
                std::thread::sleep(nap);
                sleeps += 1;
                late += u32::from(begun.elapsed() > nap + Duration::from_millis(1));
            }
            (sleeps, late)
        });
        Self { end, thread }
    }

    /// Whether more than one sleep in fifty was late.
    fn was_late(self) -> bool {
        self.end.store(true, Ordering::Relaxed);
        let (sleeps, late) = self.thread.join().unwrap();
        late * 50 > sleeps
    }
}

/// Runs a live system until a condition holds.
///
/// # Panics
/// Panics if it does not hold within ten seconds.
#[track_caller]
pub fn run_until(run: &mut Live, condition: impl Fn(&Live) -> bool) {
    let begun = Instant::now();
    while !condition(run) {
        assert!(begun.elapsed() < Duration::from_secs(10), "not in time");
        run.run_for(Duration::from_millis(5));
    }
}
