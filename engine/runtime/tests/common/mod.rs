//! Messages, operations and a component made of closures, for tests.
#![allow(dead_code, missing_docs, clippy::unwrap_used, reason = "tests")]

use asmotion_component::{Component, Cycle, Fault, Interface, Operation};

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

/// Number of attempts of a test in real time.
const ATTEMPTS: u32 = 5;

/// Runs a test in real time until it passes, at most five times. A busy machine delays threads now and then; an executor that
/// is wrong fails every attempt.
///
/// # Panics
/// Panics like the last attempt.
pub fn in_real_time(attempt: impl Fn()) {
    for number in 1..=ATTEMPTS {
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(&attempt));
        match result {
            Ok(()) => return,
            Err(problem) if number == ATTEMPTS => std::panic::resume_unwind(problem),
            // the load can pass in the meantime
            Err(_) => std::thread::sleep(std::time::Duration::from_millis(200) * number),
        }
    }
}
