//! Writes the steps of a coordinator in other forms.

mod scenario;
mod table;

use std::path::Path;

use asmotion_coordinator::{MachineOrigin, RecordedCycle};
use asmotion_lang::simulate::Trace;
use asmotion_lang::{Machine, Specification};
use clap::ValueEnum;

use self::scenario::ScenarioSteps;
use self::table::StepTable;
use super::words::seconds;

/// A form for the steps of a coordinator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExportFormat {
    /// An Avalla scenario for `asmotion test`
    Scenario,
    /// A trace for `asmotion sim --replay-inputs`
    Trace,
    /// A table of inputs and locations, with a row for each step
    Csv,
}

/// An export in progress.
pub struct Export {
    form: ExportForm,
    /// The reason that the steps have no such form.
    refused: Option<String>,
    /// The step that failed, after which nothing is exported.
    failed: Option<(u64, String)>,
}

enum ExportForm {
    Scenario(ScenarioSteps),
    Trace(Option<Trace>),
    Csv(StepTable),
}

/// An exported text.
pub struct Exported {
    /// The text.
    pub text: String,
    /// What a user of the text has to know.
    pub warnings: Vec<String>,
}

impl Export {
    /// Begins an export.
    pub fn new(format: ExportFormat) -> Self {
        let form = match format {
            ExportFormat::Scenario => ExportForm::Scenario(ScenarioSteps::default()),
            ExportFormat::Trace => ExportForm::Trace(None),
            ExportFormat::Csv => ExportForm::Csv(StepTable::default()),
        };
        Self {
            form,
            refused: None,
            failed: None,
        }
    }

    /// Adds a step that the machine has just repeated.
    pub fn add(&mut self, cycle: &RecordedCycle, specification: &Specification, machine: &Machine) {
        if let ExportForm::Csv(table) = &mut self.form {
            return table.add(cycle);
        }
        self.refuse(cycle);
        if self.refused.is_some() || self.failed.is_some() {
            return;
        }
        if let Some(fault) = &cycle.fault {
            self.failed = Some((cycle.number, fault.clone()));
            return;
        }
        match &mut self.form {
            ExportForm::Scenario(steps) => steps.add(cycle, specification, machine),
            ExportForm::Trace(trace) => {
                let path = specification.sources.paths().next().unwrap_or_default();
                let comment = format!("asm {path}");
                // a trace begins with the state before the first step
                let initial = specification.machine();
                let initial = initial.as_ref().unwrap_or(machine);
                let begun = || Trace::begin(initial, &comment);
                trace.get_or_insert_with(begun).step(machine);
            }
            ExportForm::Csv(_) => {}
        }
    }

    /// Notes why the steps of one specification, from its initial state, are not all there is.
    fn refuse(&mut self, cycle: &RecordedCycle) {
        let at = seconds(cycle.time_ns);
        let replaced = cycle.begins.iter().any(|begin| match begin.from {
            MachineOrigin::Initial => false,
            MachineOrigin::Predecessor { .. } | MachineOrigin::Frozen => true,
        });
        let has_steps = match &self.form {
            ExportForm::Scenario(steps) => !steps.is_empty(),
            ExportForm::Trace(trace) => trace.is_some(),
            ExportForm::Csv(_) => false,
        };
        let has_steps = has_steps || self.failed.is_some();
        let reason = if !cycle.messages.is_empty() {
            format!(
                "messages of services arrived before {at}, which neither a scenario nor a trace contains"
            )
        } else if let Some(safe) = &cycle.replaced {
            format!("the safe rule `{}` made the step at {at}", safe.rule)
        } else if replaced {
            format!("the specification was replaced before {at}")
        } else if has_steps && !cycle.begins.is_empty() {
            format!("the specification began again before {at}")
        } else {
            return;
        };
        self.refused.get_or_insert(format!(
            "{reason}: `--until` exports the steps before, `--export csv` all"
        ));
    }

    /// The exported text, for a file or for standard output. `machine` is the machine after the last step.
    ///
    /// # Errors
    /// The steps have no such form.
    pub fn finish(
        self,
        file: Option<&Path>,
        machine: Option<&Machine>,
    ) -> Result<Exported, String> {
        if let Some(reason) = self.refused {
            return Err(reason);
        }
        let mut exported = match (self.form, machine) {
            (ExportForm::Scenario(steps), _) if !steps.is_empty() => {
                let file = file.unwrap_or(Path::new("recorded.avalla"));
                steps.text(file, self.failed.as_ref())
            }
            (ExportForm::Trace(Some(trace)), Some(machine)) => Exported {
                text: trace.end(machine, None),
                warnings: Vec::new(),
            },
            (ExportForm::Trace(_) | ExportForm::Scenario(_), _) => {
                return Err("there is no step to export".to_owned());
            }
            (ExportForm::Csv(table), _) => Exported {
                text: table.text()?,
                warnings: Vec::new(),
            },
        };
        if let Some((number, reason)) = &self.failed {
            let failed = format!("step {number} failed and is not part of the export: {reason}");
            exported.warnings.push(failed);
        }
        Ok(exported)
    }
}
