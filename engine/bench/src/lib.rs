//! A test bench: drives one component by hand, in virtual time, without a composite.
//!
//! The engine configures and starts the component, freezes its inputs and commits its outputs as in a running system. The
//! test gives samples and answers calls.
//!
//! ```
//! use asmotion_bench::Bench;
//! use asmotion_component::{Component, Cycle, Fault, In, Interface, Out, Ports};
//! # asmotion_datum::message! {
//! #     /// A speed.
//! #     pub struct Speed = "example/Speed" {
//! #         /// m/s
//! #         pub forward: f64,
//! #     }
//! # }
//!
//! #[derive(Ports)]
//! struct LimiterPorts {
//!     /// Requested speed.
//!     requested: In<Speed>,
//!     /// The speed after limiting.
//!     limited: Out<Speed>,
//! }
//!
//! struct Limiter(LimiterPorts);
//!
//! impl Component for Limiter {
//!     fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
//!         if let Some(requested) = cycle.read(self.0.requested).new() {
//!             let forward = requested.forward.min(0.5);
//!             cycle.write(self.0.limited, Speed { forward });
//!         }
//!         Ok(())
//!     }
//! }
//!
//! let mut bench = Bench::new(|interface| Limiter(interface.ports()));
//! let cycle = bench.give("requested", Speed { forward: 2.0 }).cycle()?;
//! assert_eq!(cycle.output::<Speed>("limited"), Some(Speed { forward: 0.5 }));
//! assert_eq!(bench.cycle()?.output::<Speed>("limited"), None);
//! # Ok::<(), asmotion_bench::BenchError>(())
//! ```

mod observed;
mod stand_in;

pub use observed::{BenchCycle, ObservedCall};

use std::fmt;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use asmotion_component::declaration::PortDeclaration;
use asmotion_component::{
    Activity, Component, Fault, Interface, Operation, PropertyError, ServiceFault, State, Time,
    Wire,
};
use asmotion_datum::{Datum, Message, Sample, Schema, Shape};
use asmotion_recording::RecordingError;
use asmotion_runtime::{BuildError, Run, RunError, SentCall, Simulation, System};

use observed::{Recorder, TESTED};
use stand_in::{Answers, StandIn};

/// Name of the component that provides its references.
const STAND_IN: &str = "StandIn";
/// Time between cycles, unless set.
const PERIOD: Duration = Duration::from_millis(10);
/// Time limit of calls from outside, in virtual time.
const PATIENCE: Duration = Duration::from_secs(3600);

/// A component in virtual time, and what its surroundings do.
///
/// Errors of the methods that return the bench itself are kept, and returned by the next [`cycle`](Self::cycle).
pub struct Bench {
    stage: Stage,
    period: Duration,
    recorder: Recorder,
    answers: Answers,
    problem: Option<BenchError>,
    /// Inputs of the component.
    inputs: Vec<PortDeclaration>,
}

enum Stage {
    /// Not configured yet.
    Setup(System),
    Running(Simulation),
    /// The component could not be added; `problem` says why.
    Broken,
}

/// The reason that a bench cannot drive its component.
///
/// `Debug` writes the same text as `Display`: a test that returns an error shows it with `Debug`.
#[derive(Clone, PartialEq, thiserror::Error)]
pub enum BenchError {
    /// The component's declarations contradict each other, or a property is refused before the start.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// There is no such input, service or property, or the value does not fit.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A recording cannot be read.
    #[error("{file}: {error}")]
    Recording {
        /// The file.
        file: String,
        /// The reason.
        error: Box<RecordingError>,
    },
    /// The component does not run: its `configure` or `start` failed, or an earlier cycle.
    #[error("the component does not run, it is {state}{}", reason(fault))]
    NotRunning {
        /// State of the component.
        state: State,
        /// Its newest fault.
        fault: Option<Fault>,
    },
}

impl fmt::Debug for BenchError {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, to)
    }
}

fn reason(fault: &Option<Fault>) -> String {
    fault
        .as_ref()
        .map_or_else(String::new, |fault| format!(": {fault}"))
}

impl Bench {
    /// A bench for the component that `new` declares. The component is configured and started before its first cycle.
    pub fn new<C: Component>(new: impl FnOnce(&mut Interface) -> C) -> Self {
        let (mut system, recorder, answers) = (System::new(), Recorder::new(), Answers::default());
        let added = add(&mut system, new, &answers);
        system.observe(recorder.clone());
        let declaration = system.id(TESTED).and_then(|it| system.declaration(it));
        let inputs = declaration.map_or_else(Vec::new, |it| it.inputs.clone());
        let (stage, problem) = match added {
            Ok(()) => (Stage::Setup(system), None),
            Err(error) => (Stage::Broken, Some(error.into())),
        };
        Self {
            stage,
            period: PERIOD,
            recorder,
            answers,
            problem,
            inputs,
        }
    }

    /// Sets the time between the beginnings of two cycles: 10 ms by default, at least 1 ns.
    pub fn period(&mut self, period: Duration) -> &mut Self {
        self.period = period.max(Duration::from_nanos(1));
        self
    }

    /// Sets a property: before the first cycle as a composite does, later as an operator does.
    pub fn set(&mut self, property: &str, value: impl Into<Datum>) -> &mut Self {
        let value = value.into();
        let result = match &mut self.stage {
            Stage::Setup(system) => system.id(TESTED).map_or(Ok(()), |tested| {
                let set = system.set_property(tested, property, &value);
                set.map_err(|error: PropertyError| RunError::Property(error).into())
            }),
            Stage::Running(run) => run
                .set_properties(TESTED, &[(property.to_owned(), value)])
                .map_err(BenchError::from),
            Stage::Broken => Ok(()),
        };
        self.keep(result)
    }

    /// Gives a sample to an input. Several samples before a cycle arrive in this order.
    pub fn give<T: Message>(&mut self, input: &str, sample: T) -> &mut Self {
        self.give_sample(input, Arc::new(sample))
    }

    /// Gives a sample as a datum, for example one from a recording, to an input.
    pub fn give_datum(&mut self, input: &str, sample: Datum) -> &mut Self {
        self.give_sample(input, Arc::new(sample))
    }

    /// Gives the samples of a port of a recording (`asmotion run --record FILE.csv`) to an input, each in the first cycle at
    /// or after its time. Time begins at zero with the first cycle, on the bench as in a recorded run in virtual time.
    ///
    /// ```no_run
    /// # use std::time::Duration;
    /// # fn test(mut bench: asmotion_bench::Bench) -> Result<(), asmotion_bench::BenchError> {
    /// bench.give_recorded("commands", "arm.csv", "Driver.commands");
    /// let cycles = bench.run_for(Duration::from_secs(5))?;
    /// # Ok(()) }
    /// ```
    pub fn give_recorded(&mut self, input: &str, file: impl AsRef<Path>, port: &str) -> &mut Self {
        let result = self.inject_recorded(input, file.as_ref(), port);
        self.keep(result)
    }

    fn inject_recorded(&mut self, input: &str, file: &Path, port: &str) -> Result<(), BenchError> {
        let declared = self.inputs.iter().find(|declared| declared.name == input);
        // an input that is not declared is found by the injection, which suggests another
        let schema = declared.map_or_else(|| Schema::plain(Shape::Any), |it| it.schema.clone());
        let samples = File::open(file).map_err(|error| RecordingError::Unreadable {
            reason: error.to_string(),
        });
        let samples = samples.and_then(|it| asmotion_recording::read_samples(it, port, &schema));
        let samples = samples.map_err(|error| BenchError::Recording {
            file: file.display().to_string(),
            error: Box::new(error),
        })?;
        for (at, sample) in samples {
            self.inject(input, Some(at), Arc::new(sample))?;
        }
        Ok(())
    }

    fn give_sample(&mut self, input: &str, sample: Arc<dyn Sample>) -> &mut Self {
        let result = self.inject(input, None, sample);
        self.keep(result)
    }

    /// Injects a sample at a time, without one now.
    fn inject(
        &mut self,
        input: &str,
        at: Option<Time>,
        sample: Arc<dyn Sample>,
    ) -> Result<(), BenchError> {
        let Some(run) = self.started() else {
            return Ok(());
        };
        let port = format!("{TESTED}.{input}");
        Ok(run.inject_sample(at.unwrap_or(run.now()), &port, sample)?)
    }

    /// Answers all calls of an operation through a reference, from now on. The answers arrive in the cycle after the call.
    /// Calls without an answer end after a second.
    pub fn answer<O: Operation>(
        &mut self,
        reference: &str,
        mut answer: impl FnMut(O::Request) -> Result<O::Response, ServiceFault> + Send + 'static,
    ) -> &mut Self {
        self.answers.set(reference, O::NAME, move |request| {
            let bad = |code: &str, error: asmotion_datum::DatumError| {
                ServiceFault::new(code, error.to_string())
            };
            let request = O::Request::of_datum(request);
            let response = answer(request.map_err(|error| bad("BAD_ARGUMENT", error))?)?;
            Message::to_datum(&response).map_err(|error| bad("BAD_REPLY", error))
        });
        self
    }

    /// Calls an operation of a service. The component sees the request in its next cycle; the returned handle has its reply.
    ///
    /// # Errors
    /// [`BenchError::Build`] if the component does not provide the operation.
    pub fn call<O: Operation>(
        &mut self,
        service: &str,
        argument: O::Request,
    ) -> Result<SentCall<O>, BenchError> {
        let port = format!("{TESTED}.{service}");
        match self.started() {
            Some(run) => Ok(run.send(&port, argument, PATIENCE)?),
            None => Err(self.take_problem()),
        }
    }

    /// Runs one cycle, lets the period pass, and returns what the component did.
    ///
    /// # Errors
    /// The first error since the last cycle, or [`BenchError::NotRunning`]. A fault of the component in this cycle is not an
    /// error of the bench but [`BenchCycle::fault`].
    pub fn cycle(&mut self) -> Result<BenchCycle, BenchError> {
        let period = self.period;
        let Some(run) = self.started() else {
            return Err(self.take_problem());
        };
        let state = run.state(TESTED).unwrap_or(State::Init);
        if !state.is_running() {
            let fault = run.fault(TESTED);
            return Err(BenchError::NotRunning { state, fault });
        }
        let at = run.now();
        run.trigger(TESTED)?;
        run.run_for(period);
        let state = run.state(TESTED).unwrap_or(State::Init);
        match self.problem.take() {
            Some(problem) => Err(problem),
            None => Ok(self.recorder.take(at, state)),
        }
    }

    /// Runs cycles as long as they begin within a duration, and returns what the component did in each.
    ///
    /// # Errors
    /// As [`cycle`](Self::cycle), for the first cycle that fails.
    pub fn run_for(&mut self, duration: Duration) -> Result<Vec<BenchCycle>, BenchError> {
        let mut cycles = Vec::new();
        let mut passed = Duration::ZERO;
        while passed < duration {
            cycles.push(self.cycle()?);
            passed += self.period;
        }
        Ok(cycles)
    }

    /// Stops the component, and returns what it did in its last cycle.
    ///
    /// # Errors
    /// As [`cycle`](Self::cycle).
    pub fn stop(&mut self) -> Result<BenchCycle, BenchError> {
        let Some(run) = self.started() else {
            return Err(self.take_problem());
        };
        let at = run.now();
        run.stop();
        let state = run.state(TESTED).unwrap_or(State::Init);
        match self.problem.take() {
            Some(problem) => Err(problem),
            None => Ok(self.recorder.take(at, state)),
        }
    }

    /// Starts the component if it has not been started; `None` if it could not be added.
    fn started(&mut self) -> Option<&mut Simulation> {
        if let Stage::Setup(_) = self.stage
            && let Stage::Setup(system) = std::mem::replace(&mut self.stage, Stage::Broken)
        {
            self.stage = Stage::Running(system.simulate());
        }
        match &mut self.stage {
            Stage::Running(run) => Some(run),
            Stage::Setup(_) | Stage::Broken => None,
        }
    }

    fn keep(&mut self, result: Result<(), BenchError>) -> &mut Self {
        if let Err(error) = result {
            self.problem.get_or_insert(error);
        }
        self
    }

    /// The error because of which the component could not be added.
    fn take_problem(&mut self) -> BenchError {
        self.problem.clone().unwrap_or(BenchError::NotRunning {
            state: State::Init,
            fault: None,
        })
    }
}

/// Adds the component, and one that provides its references.
fn add<C: Component>(
    system: &mut System,
    new: impl FnOnce(&mut Interface) -> C,
    answers: &Answers,
) -> Result<(), BuildError> {
    let tested = system.add(TESTED, Activity::manual(), |interface| {
        Box::new(new(interface))
    })?;
    let references = system.declaration(tested).map(|it| it.references.clone());
    let references = references.unwrap_or_default();
    system.add(STAND_IN, Activity::event(), |interface| {
        Box::new(StandIn::new(interface, &references, answers.clone()))
    })?;
    for reference in references {
        let name = reference.name;
        let (from, to) = (format!("{TESTED}.{name}"), format!("{STAND_IN}.{name}"));
        system.wire(&from, &to, Wire::default())?;
    }
    Ok(())
}
