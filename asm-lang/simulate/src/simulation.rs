//! Simulation: a machine with the source of its inputs, choices and times, and an optional trace.

use crate::clock::SimulationClock;
use crate::constrained_inputs::{ConstrainedInputs, InputValues};
use crate::environment::Script;
use crate::partner::ScriptedPartners;
use crate::random::{Random, Seeded};
use crate::recording::{Recording, Ticks};
use crate::trace::Trace;
use asmotion_machine::{Chooser, Environment, Machine, StepFault};
use std::fmt;

/// The source of a run's inputs, choices and times.
#[derive(Clone, Debug)]
pub enum Causes {
    /// Scripted inputs; choices by seed.
    Script(Script),
    /// Inputs and choices by seed.
    Random(Box<Random>),
    /// Recorded inputs, choices and times.
    Recording(Recording),
}

impl Causes {
    /// Returns the number of steps provided; `None` for random inputs, which are unlimited.
    pub fn steps(&self) -> Option<u64> {
        match self {
            Self::Script(script) => Some(script.len() as u64),
            Self::Random(_) => None,
            Self::Recording(recording) => Some(recording.steps().len() as u64),
        }
    }
}

/// The reason that a simulation cannot execute a step.
#[derive(Debug)]
pub enum SimulationError {
    /// The step has no next state.
    Fault(Box<StepFault>),
    /// A recorded step names no input of this machine, or gives one an invalid value.
    Unreadable {
        /// Number of the step, from 1.
        step: u64,
        /// The invalid lines of the recording.
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
                    "recorded step {step} has inputs that the specification does not declare: `{lines}`"
                )
            }
        }
    }
}

/// A run: a machine, the source of its inputs, and its trace.
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
    /// Creates a run that starts in the state of the machine. The seed determines choices that are
    /// not recorded.
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

    /// Sets the clock for steps whose time is not recorded. Default: [`SimulationClock::Virtual`].
    pub fn timed(mut self, clock: SimulationClock) -> Self {
        self.clock = clock;
        self
    }

    /// Starts a trace; `comment` becomes comment lines at its head.
    pub fn traced(mut self, comment: &str) -> Self {
        self.trace = Some(Trace::begin(&self.machine, comment));
        self
    }

    /// Returns the machine in its current state.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Returns the number of steps that the source provides.
    pub fn steps(&self) -> Option<u64> {
        self.causes.steps()
    }

    /// Executes a step and adds it to the trace.
    ///
    /// # Errors
    /// The step has no next state, or its recording does not fit this machine.
    pub fn step(&mut self) -> Result<(), SimulationError> {
        let done = self.attempt();
        match (&mut self.trace, &done) {
            (Some(trace), Ok(())) => trace.step(&self.machine),
            (Some(trace), Err(SimulationError::Fault(fault))) => trace.fault(&self.machine, fault),
            (Some(_), Err(SimulationError::Unreadable { .. })) | (None, _) => {}
        }
        done
    }

    /// Returns the trace, if one was started. `stopped` is the fault that ended the run, if any.
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
                self.partners.deliver_replies(machine);
                step(machine, script, choices, now_ns)?;
                self.partners.schedule_replies(machine);
                script.advance();
            }
            Causes::Random(random) => {
                let drawn = random.constrained_inputs(machine, &InputValues::new(), now_ns)?;
                let mut inputs = ConstrainedInputs::new(drawn, &mut **random);
                step(machine, &mut inputs, choices, now_ns)?;
            }
            Causes::Recording(recording) => {
                let number = machine.steps();
                let recorded = recording.step(number as usize);
                let unreadable = |lines| SimulationError::Unreadable {
                    step: number + 1,
                    lines,
                };
                let delivered = recorded.deliver(machine);
                delivered.map_err(|message| unreadable(vec![message.0]))?;
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
