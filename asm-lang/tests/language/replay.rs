//! Equal programs, inputs and choices give equal runs, byte for byte.

use asmotion_lang::simulate::{Random, Recording, Seeded, Trace};
use asmotion_lang::{Chooser, Environment, Machine, Specification, StepFault};

/// The programs whose initial state can be computed.
fn programs() -> impl Iterator<Item = (String, Specification)> {
    let programs = super::programs(&super::folder().join("semantics")).into_iter();
    let opened = programs.map(|(name, text)| {
        let specification = super::opened(&name, &text);
        (name, specification)
    });
    opened.filter(|(_, specification)| specification.machine().is_ok())
}

/// A machine with the record of its run.
struct Run {
    machine: Machine,
    trace: Trace,
    stopped: Option<Box<StepFault>>,
}

impl Run {
    fn of(specification: &Specification) -> Self {
        let machine = specification.machine().unwrap();
        let trace = Trace::begin(&machine, "");
        Self {
            machine,
            trace,
            stopped: None,
        }
    }

    fn step(&mut self, inputs: &mut dyn Environment, choices: &mut dyn Chooser, now_ns: i64) {
        if self.stopped.is_some() {
            return;
        }
        match self.machine.step(inputs, choices, now_ns).map(|_| ()) {
            Ok(()) => self.trace.step(&self.machine),
            Err(fault) => {
                self.trace.fault(&self.machine, &fault);
                self.stopped = Some(fault);
            }
        }
    }

    fn text(self) -> String {
        self.trace.end(&self.machine, self.stopped.as_deref())
    }
}

/// The trace of a run with random inputs and choices.
fn by_chance(specification: &Specification, seed: u64) -> String {
    let mut run = Run::of(specification);
    let mut random = Random::new(specification.program.clone(), &run.machine, seed);
    let mut seeded = Seeded::new(seed);
    for number in 0..30 {
        run.step(&mut random, &mut seeded, number * 100_000_000);
    }
    run.text()
}

#[test]
fn repeats_a_run_with_its_seed() {
    for (name, specification) in programs() {
        assert_eq!(
            by_chance(&specification, 7),
            by_chance(&specification, 7),
            "{name}.asm"
        );
    }
}

#[test]
fn replays_a_trace() {
    for (name, specification) in programs() {
        let recorded = by_chance(&specification, 11);
        let recording = Recording::read(&recorded);
        let mut run = Run::of(&specification);
        for step in recording.steps() {
            let mut inputs = step.inputs(&run.machine).unwrap();
            run.step(&mut inputs, &mut step.choices(), step.now_ns);
        }
        assert_eq!(run.text(), recorded, "{name}.asm");
    }
}

/// A trace of another tool contains no choices. A replay takes the first candidates and reports it.
#[test]
fn writes_down_choices_that_no_trace_has() {
    let mut made = 0;
    for (name, specification) in programs() {
        let recorded = by_chance(&specification, 11);
        let choices = recorded
            .lines()
            .filter(|line| line.starts_with("C "))
            .count();
        let silent = recorded.lines().filter(|line| !line.starts_with("C "));
        let silent: Vec<&str> = silent.collect();
        let recording = Recording::read(&silent.join("\n"));
        let mut run = Run::of(&specification);
        let Some(step) = recording.steps().first() else {
            continue;
        };
        let mut inputs = step.inputs(&run.machine).unwrap();
        run.step(&mut inputs, &mut step.choices(), step.now_ns);
        let replayed = run.text();
        let mut first = replayed.lines().filter(|line| line.starts_with("C "));
        assert!(first.all(|line| line.starts_with("C 0 of ")), "{name}.asm");
        made += usize::from(choices > 0 && replayed.contains("\nC 0 of "));
    }
    assert!(made > 3, "only {made} programs choose");
}
