//! Effects of a cycle of a component.

use std::sync::{Arc, Mutex, PoisonError};

use asmotion_component::{Fault, State, Time};
use asmotion_datum::{Datum, Message, Sample};
use asmotion_runtime::{Event, Observer};

/// Name of the component under test.
pub(crate) const TESTED: &str = "Tested";

/// Effects of one cycle of the component under test.
#[derive(Debug, Clone)]
pub struct BenchCycle {
    /// Time of the cycle.
    pub at: Time,
    /// State of the component after the cycle.
    pub state: State,
    /// Calls that it made, without repetitions.
    pub calls: Vec<ObservedCall>,
    /// Its reports: kind and content.
    pub reports: Vec<(String, Datum)>,
    /// Fault of the cycle, whose outputs and calls were then discarded.
    pub fault: Option<Fault>,
    outputs: Vec<(String, Arc<dyn Sample>)>,
}

/// A call of the component under test.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedCall {
    /// Name of the reference.
    pub reference: String,
    /// Name of the operation.
    pub operation: String,
    /// Argument of the call, as data.
    pub argument: Datum,
}

impl BenchCycle {
    fn empty() -> Self {
        Self {
            at: Time::ZERO,
            state: State::Init,
            calls: Vec::new(),
            reports: Vec::new(),
            fault: None,
            outputs: Vec::new(),
        }
    }

    /// The samples written to an output, in order. Samples of another type are left out.
    pub fn outputs<T: Message>(&self, output: &str) -> Vec<T> {
        let of_port = self.outputs.iter().filter(|(port, _)| port == output);
        of_port
            .filter_map(|(_, sample)| Arc::clone(sample).read().ok())
            .collect()
    }

    /// The last sample written to an output.
    pub fn output<T: Message>(&self, output: &str) -> Option<T> {
        self.outputs(output).pop()
    }

    /// Names of the outputs that were written to, in order, with their samples as data.
    pub fn written(&self) -> Vec<(String, Datum)> {
        let samples = self.outputs.iter();
        let samples =
            samples.filter_map(|(port, sample)| Some((port.clone(), sample.to_datum().ok()?)));
        samples.collect()
    }
}

/// Collects the effects of the component under test. Clones share them.
#[derive(Clone)]
pub(crate) struct Recorder(Arc<Mutex<BenchCycle>>);

impl Recorder {
    pub(crate) fn new() -> Self {
        Self(Arc::new(Mutex::new(BenchCycle::empty())))
    }

    /// The effects since the last call.
    pub(crate) fn take(&self, at: Time, state: State) -> BenchCycle {
        let mut cycle = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut taken = std::mem::replace(&mut *cycle, BenchCycle::empty());
        (taken.at, taken.state) = (at, state);
        taken
    }
}

impl Observer for Recorder {
    fn observe(&mut self, _: Time, event: &Event<'_>) {
        let mut cycle = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Event::Published {
            component: TESTED,
            port,
            sample,
            ..
        } = event
        {
            let sample = sample.to_shared();
            cycle.outputs.push(((*port).to_owned(), sample));
        } else if let Event::Called {
            component: TESTED,
            reference,
            operation,
            attempt: 1,
            argument,
            ..
        } = event
        {
            cycle.calls.push(ObservedCall {
                reference: (*reference).to_owned(),
                operation: (*operation).to_owned(),
                argument: argument.to_datum().unwrap_or_default(),
            });
        } else if let Event::Report {
            component: TESTED,
            kind,
            data,
        } = event
        {
            cycle.reports.push(((*kind).to_owned(), (*data).clone()));
        } else if let Event::Fault {
            component: TESTED,
            fault,
        } = event
        {
            cycle.fault = Some((*fault).clone());
        }
    }
}
