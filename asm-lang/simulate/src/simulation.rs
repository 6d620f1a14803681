//! A machine that runs alone: what causes its steps, and what is written down about them.

use crate::clock::SimulationClock;
use crate::environment::Script;
use crate::partner::ScriptedPartners;
use crate::random::{Random, Seeded};
use crate::recording::{Recording, Ticks};
use crate::trace::Trace;
use asmotion_machine::{Chooser, Environment, Machine, StepFault};
use std::fmt;

/// What causes the steps of a run: inputs, choices, times.
#[derive(Clone, Debug)]
pub enum Causes {
    /// Inputs by name, step by step; choices by chance.
    Script(Script),
    /// Inputs and choices by chance.
    Random(Box<Random>),
    /// What once was: inputs, choices and times.
    Recording(Recording),
}

impl Causes {
    /// How many steps they are made for; chance has no end.
    pub fn steps(&self) -> Option<u64> {
        match self {
            Self::Script(script) => Some(script.len() as u64),
            Self::Random(_) => None,
            Self::Recording(recording) => Some(recording.steps().len() as u64),
        }
    }
}

/// Why a run ends early.
#[derive(Debug)]
pub enum SimulationError {
    /// A step has no next state.
    Fault(Box<StepFault>),
    /// A recorded step gives values to what is no input of this machine, or no values of theirs.
    Unreadable {
        /// The step.
        step: u64,
        /// What is recorded there.
        lines: Vec<String>,
    },
}

impl From<Box<StepFault>> for SimulationError {
    fn from(fault: Box<StepFault>) -> Self {
        Self::Fault(fault)
    }
}

impl fmt::Display for SimulationError {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fault(fault) => write!(to, "step {} failed", fault.step),
            Self::Unreadable { step, lines } => {
                let lines = lines.join("`, `");
                write!(
                    to,
                    "the recorded step {step} gives inputs that the specification does not have: `{lines}`"
                )
            }
        }
    }
}

/// A machine, what causes its steps, and the trace of them.
pub struct Simulation {
    machine: Machine,
    causes: Causes,
    partners: ScriptedPartners,
    choices: Seeded,
    clock: SimulationClock,
    ticks: Ticks,
    trace: Option<Trace>,
}

impl Simulation {
    /// A run that begins in the state of the machine. The seed decides choices that are not recorded.
    pub fn new(mut machine: Machine, causes: Causes, seed: u64) -> Self {
        let answers = match &causes {
            Causes::Script(script) => script.answers.clone(),
            Causes::Random(_) | Causes::Recording(_) => Vec::new(),
        };
        Self {
            partners: ScriptedPartners::new(answers, &mut machine),
            machine,
            causes,
            choices: Seeded::new(seed),
            clock: SimulationClock::default(),
            ticks: Ticks::default(),
            trace: None,
        }
    }

    /// Lets a clock say when steps are done, where no recording does.
    pub fn timed(mut self, clock: SimulationClock) -> Self {
        self.clock = clock;
        self
    }

    /// Writes down what happens from now on; the trace begins with lines of comment.
    pub fn traced(mut self, comment: &str) -> Self {
        self.trace = Some(Trace::begin(&self.machine, comment));
        self
    }

    /// The machine.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// How many steps are caused.
    pub fn steps(&self) -> Option<u64> {
        self.causes.steps()
    }

    /// Does a step.
    ///
    /// # Errors
    /// There is no next state, or a recorded step that is none of this machine's.
    pub fn step(&mut self) -> Result<(), SimulationError> {
        let done = self.attempt();
        match (&mut self.trace, &done) {
            (Some(trace), Ok(())) => trace.step(&self.machine),
            (Some(trace), Err(SimulationError::Fault(fault))) => trace.fault(&self.machine, fault),
            (Some(_), Err(SimulationError::Unreadable { .. })) | (None, _) => {}
        }
        done
    }

    /// The trace, if one was asked for, of a run that was stopped or was not.
    pub fn into_trace(self, stopped: Option<&StepFault>) -> Option<String> {
        let trace = self.trace?;
        Some(trace.end(&self.machine, stopped))
    }

    fn attempt(&mut self) -> Result<(), SimulationError> {
        let machine = &mut self.machine;
        let choices = &mut self.choices;
        let now_ns = self.clock.now(machine.steps() + 1);
        match &mut self.causes {
            Causes::Script(script) => {
                self.partners.answer(machine);
                step(machine, script, choices, now_ns)?;
                self.partners.hear(machine);
                script.advance();
            }
            Causes::Random(random) => step(machine, &mut **random, choices, now_ns)?,
            Causes::Recording(recording) => {
                let number = machine.steps();
                let recorded = recording.step(number as usize);
                let unreadable = |lines| SimulationError::Unreadable {
                    step: number + 1,
                    lines,
                };
                let mut inputs = recorded
                    .inputs(machine)
                    .map_err(unreadable)?
                    .after(self.ticks);
                let mut choices = recorded.choices();
                let done = step(machine, &mut inputs, &mut choices, recorded.now_ns);
                self.ticks = inputs.ticks();
                done?;
            }
        }
        Ok(())
    }
}

fn step(
    machine: &mut Machine,
    inputs: &mut dyn Environment,
    choices: &mut dyn Chooser,
    now_ns: i64,
) -> Result<(), Box<StepFault>> {
    machine.step(inputs, choices, now_ns).map(|_| ())
}
