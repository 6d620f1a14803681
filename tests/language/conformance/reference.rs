//! Repeats the reference's runs with the same inputs and an equivalent clock.

use asmotion_lang::simulate::{RecordedInputs, RecordedStep, Recording, Trace};
use asmotion_lang::{
    Environment, FaultKind, FirstChoice, Loader, Machine, ReadOptions, StepFault, ir, value::Value,
};
use std::path::Path;
use std::sync::Arc;

/// Our trace of a program, with the inputs of the reference's; `None` if we reject the program.
pub fn ours(
    path: &Path,
    reference: &str,
    loader: &dyn Loader,
    options: &ReadOptions,
) -> Option<String> {
    let specification = asmotion_lang::open_with(&path.to_string_lossy(), loader, options).ok()?;
    let mut machine = match specification.machine() {
        Ok(machine) => machine,
        Err(fault) => {
            let kind = if matches!(fault.kind, FaultKind::Invariant { .. }) {
                "@invariant pre"
            } else {
                "@error EXC"
            };
            return Some(format!("@step 1\n{kind}\n@end"));
        }
    };
    let mut trace = Trace::begin(&machine, "");
    let mut stopped: Option<Box<StepFault>> = None;
    let mut clock = Clock::default();
    for step in Recording::read(reference).steps() {
        clock.is_read = false;
        let is_silent = reference.contains("# reader none");
        let mut inputs = Reference::of(step, &machine, &mut clock, is_silent);
        match machine.step(&mut inputs, &mut FirstChoice, 0).map(|_| ()) {
            Ok(()) => trace.step(&machine),
            Err(fault) => {
                trace.fault(&machine, &fault);
                stopped = Some(fault);
                break;
            }
        }
    }
    Some(trace.end(&machine, stopped.as_deref()))
}

/// The reference's clock: in every step that reads it, it advances by one unit of the first function read.
#[derive(Default)]
struct Clock {
    now_ns: i64,
    is_read: bool,
}

impl Clock {
    fn read(&mut self, unit: i64) -> i64 {
        if !self.is_read {
            self.now_ns += unit;
            self.is_read = true;
        }
        self.now_ns / unit
    }
}

/// The inputs that the reference read in a step. Inputs that it did not read, because it visits enumerations in another
/// order, are undef.
struct Reference<'a> {
    inputs: RecordedInputs,
    clock: &'a mut Clock,
    program: Arc<ir::Program>,
    is_silent: bool,
}

impl<'a> Reference<'a> {
    fn of(step: &RecordedStep, machine: &Machine, clock: &'a mut Clock, is_silent: bool) -> Self {
        Self {
            inputs: step.inputs(machine).unwrap(),
            clock,
            program: machine.program().clone(),
            is_silent,
        }
    }
}

impl Environment for Reference<'_> {
    fn read(
        &mut self,
        function: ir::FunctionId,
        arguments: &[Value],
    ) -> Result<Option<Value>, String> {
        if let Some(unit) = self.program.functions[function.0 as usize].clock {
            return Ok(Some(Value::Int(self.clock.read(unit))));
        }
        if self.is_silent {
            Err("this run has no inputs".to_owned())
        } else {
            Ok(self.inputs.read(function, arguments).unwrap_or_default())
        }
    }
}
