//! A direct rule that gives up: the step is evaluated again, and a rule that gives up too often is not tried any more.

#![allow(
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by panicking"
)]

use asmotion_lang::ir::{Origin, Program};
use asmotion_lang::machine::back_end::{
    DirectResult, DirectRule, DirectStep, NativeCompiler, NativeRule, NoNativeCode,
};
use asmotion_lang::simulate::Seeded;
use asmotion_lang::{BackEnd, FirstChoice, MemoryFiles, NoInputs, Specification, Value};
use asmotion_native::Cranelift;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

const STEPS: u64 = 400;

const DRAWING: &str = "asm drawing
import StandardLibrary
signature:
  domain Side subsetof Integer
  controlled n: Integer
  controlled drawn: Side -> Integer
definitions:
  domain Side = {0 : 1}
  main rule r_Main = par
    n := (n * 3 + 1) mod 97
    choose $s in Side with drawn($s) < 1000 do drawn($s) := drawn($s) + 1
  endpar
default init s0:
  function n = 0
  function drawn($s in Side) = 0
";

/// Compiles direct rules that give up periodically.
#[derive(Debug)]
struct Hesitant {
    /// The rule gives up each step whose number is divisible by this.
    period: u64,
    is_fitting: bool,
    /// Number of steps that the rule was tried for.
    tried: Arc<AtomicU64>,
    /// Number of states that the rule was asked about.
    asked: Arc<AtomicU64>,
}

struct HesitantRule {
    rule: Box<dyn DirectRule>,
    period: u64,
    is_fitting: bool,
    tried: Arc<AtomicU64>,
    asked: Arc<AtomicU64>,
}

impl NativeCompiler for Hesitant {
    fn compile(&self, program: &Program) -> Result<Box<dyn NativeRule>, NoNativeCode> {
        Cranelift.compile(program)
    }

    fn compile_direct(&self, program: &Program, slots: &[Value]) -> Option<Box<dyn DirectRule>> {
        Some(Box::new(HesitantRule {
            rule: Cranelift.compile_direct(program, slots)?,
            period: self.period,
            is_fitting: self.is_fitting,
            tried: self.tried.clone(),
            asked: self.asked.clone(),
        }))
    }
}

impl DirectRule for HesitantRule {
    fn collect(&self, step: &mut DirectStep<'_>) -> DirectResult {
        let number = self.tried.fetch_add(1, Ordering::Relaxed) + 1;
        if !number.is_multiple_of(self.period) {
            return self.rule.collect(step);
        }
        // what the part of a rule before its end may leave behind
        step.choose(2, Origin::default());
        for count in step.counters() {
            *count += 1;
        }
        DirectResult::GaveUp
    }

    fn fits(&self, slots: &[Value]) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed);
        self.is_fitting && self.rule.fits(slots)
    }
}

fn drawing(is_covered: bool) -> Specification {
    let mut files = MemoryFiles::new();
    files.add("drawing.asm", DRAWING);
    let opened = asmotion_lang::open("drawing.asm", &files);
    let mut specification = opened.unwrap_or_else(|failure| panic!("{failure}"));
    if is_covered {
        specification.lower_covered().unwrap();
    }
    specification
}

/// Compares [`STEPS`] steps with those of closures. Returns how often the rule was tried, and how often it was asked about a
/// state.
fn use_of(period: u64, is_fitting: bool, is_covered: bool) -> (u64, u64) {
    let specification = drawing(is_covered);
    let (tried, asked) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicU64::new(0)));
    let compiler = Box::leak(Box::new(Hesitant {
        period,
        is_fitting,
        tried: tried.clone(),
        asked: asked.clone(),
    }));
    let mut closures = specification.machine().unwrap();
    closures.set_back_end(BackEnd::Closures).unwrap();
    // a machine of its own, because clones share compiled code
    let mut direct = specification.machine().unwrap();
    direct.set_native_compiler(compiler);
    direct.set_back_end(BackEnd::Native).unwrap();
    let (mut one, mut other) = (Seeded::new(3), Seeded::new(3));
    for now in 0..STEPS as i64 {
        closures.step(&mut NoInputs, &mut one, now).unwrap();
        direct.step(&mut NoInputs, &mut other, now).unwrap();
        let (expected, done) = (closures.last_step(), direct.last_step());
        let context = format!("period {period}, step {now}");
        assert_eq!(done.updates(), expected.updates(), "{context}");
        assert_eq!(done.before(), expected.before(), "{context}");
        assert_eq!(done.choices(), expected.choices(), "{context}");
        assert_eq!(done.number(), expected.number(), "{context}");
        assert_eq!(done.now_ns(), now, "{context}");
        assert_eq!(direct.snapshot(), closures.snapshot(), "{context}");
        assert_eq!(direct.counts(), closures.counts(), "{context}");
    }
    let counts = direct.counts();
    assert_eq!(counts.contains(&STEPS), is_covered, "{counts:?}");
    let load = |number: &AtomicU64| number.load(Ordering::Relaxed);
    (load(&tried), load(&asked))
}

#[test]
fn a_rule_that_gives_up_too_often_is_not_tried_again() {
    // more than 64 steps, and more than one in four
    for (period, expected) in [(1, 65), (3, 195), (4, STEPS), (7, STEPS)] {
        for is_covered in [false, true] {
            let (tried, _) = use_of(period, true, is_covered);
            assert_eq!(tried, expected, "period {period}, covered: {is_covered}");
        }
    }
}

#[test]
fn a_rule_that_never_fits_the_state_is_not_asked_again() {
    assert_eq!(use_of(1, false, false), (0, 65));
    // it is asked once, before the first step: steps lead to no state that it does not fit
    assert_eq!(use_of(STEPS + 1, true, false), (STEPS, 1));
}

#[test]
fn a_first_choice_is_not_recorded() {
    for back_end in [BackEnd::Closures, BackEnd::Native] {
        let mut machine = drawing(false).machine().unwrap();
        machine.set_back_end(back_end).unwrap();
        for number in 1..=3 {
            let step = machine.step(&mut NoInputs, &mut FirstChoice, 0).unwrap();
            assert_eq!(step.choices(), [], "{back_end:?}");
            assert_eq!(step.updates().len(), 2, "{back_end:?}");
            assert_eq!(step.number(), number, "{back_end:?}");
        }
    }
}
