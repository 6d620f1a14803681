//! The verification of a specification: preparation, exploration, verdicts.

use crate::codes::m001::InputWithoutRange;
use crate::codes::m002::TooManyAlternatives;
use crate::codes::m006::NothingAssumed;
use crate::codes::main_rule;
use crate::counterexample::Replay;
use crate::explore::{ExplorationError, Explorer, Incomplete, Progress};
use crate::inputs::InputRanges;
use crate::options::{InputValues, Options};
use crate::preparation::{prepare, report_of};
use crate::property::CheckedProperty;
use crate::transition::SingleMachine;
use crate::verdicts::verdicts;
use asmotion_diagnostics::Finding;
use asmotion_lang::{Diagnostic, Machine, Report, Specification};

/// The result of a verification.
#[derive(Debug)]
pub struct Verification {
    /// The machines of the system; one if a single specification is verified.
    pub machines: Vec<VerifiedMachine>,
    /// The properties with their verdicts: those of the specification in their order, then those that all should have.
    pub properties: Vec<CheckedProperty>,
    /// Number of states.
    pub states: u64,
    /// Number of transitions that update a location, and of initial states.
    pub transitions: u64,
    /// Number of cases, a state with inputs, that an assumption excludes.
    pub excluded: u64,
    /// Texts of the assumptions.
    pub assumptions: Vec<String>,
    /// Greatest number of steps on a shortest path from an initial state.
    pub depth: u32,
    /// The reason for which not all states were explored.
    pub incomplete: Option<Incomplete>,
}

/// A machine of a system.
#[derive(Debug)]
pub struct VerifiedMachine {
    /// Name of the machine in the system; that of the specification if there is only one.
    pub name: String,
    /// Its specification, without the properties and with additions.
    pub specification: Specification,
}

/// The reason for which a specification cannot be verified.
#[derive(Debug)]
pub struct Refusal {
    /// The specification, for rendering the report.
    pub specification: Box<Specification>,
    /// Errors, at least one.
    pub report: Report,
}

/// Verifies a specification. `proceed` is called now and then during the exploration, and ends it by returning `false`.
///
/// # Errors
/// The initial state cannot be computed, a property is no formula, or an input has too many values.
pub fn verify(
    mut specification: Specification,
    options: &Options,
    proceed: &mut dyn FnMut(Progress) -> bool,
) -> Result<Verification, Refusal> {
    let prepared = match prepare(&mut specification, options) {
        Ok(prepared) => prepared,
        Err(report) => return Err(refusal(specification, report)),
    };
    let machine = match specification.machine() {
        Ok(machine) => machine,
        Err(fault) => {
            let diagnostic = specification.explain(&fault);
            return Err(refusal(specification, report_of(diagnostic)));
        }
    };
    let mut ranges = InputRanges::of_program(&machine);
    let mut assumptions = prepared.assumptions.clone();
    for input in &options.inputs {
        ranges.set(input.function, input.values.clone());
        assumptions.push(restriction(&machine, input));
    }
    let keeps_edges = prepared.needs_graph();
    let system = SingleMachine {
        machine,
        ranges: &ranges,
    };
    let explorer = Explorer::new(
        system.clone(),
        &prepared.conditions,
        options.limits,
        keeps_edges,
    );
    let exploration = match explorer.run(proceed) {
        Ok(exploration) => exploration,
        Err(error) => {
            let diagnostic = explain(&specification, &system.machine, error);
            return Err(refusal(specification, report_of(diagnostic)));
        }
    };
    if exploration.initial == 0 {
        let finding = NothingAssumed {
            assumptions: prepared.assumptions,
            at: main_rule(&specification),
        };
        return Err(refusal(specification, report_of(finding.diagnostic())));
    }
    let machines = [VerifiedMachine {
        name: specification.model.name.to_string(),
        specification,
    }];
    let replay = Replay {
        machines: &machines,
        exploration: &exploration,
        system: &system,
    };
    let checked = verdicts(&prepared, &replay, &options.only);
    let [verified] = machines;
    let properties = match checked {
        Ok(properties) => properties,
        Err(error) => {
            let diagnostic = error.diagnostic();
            return Err(refusal(verified.specification, report_of(diagnostic)));
        }
    };
    let (states, depth) = (exploration.states.len() as u64, exploration.depth());
    Ok(Verification {
        machines: vec![verified],
        properties,
        states,
        transitions: exploration.transitions,
        excluded: exploration.excluded,
        assumptions,
        depth,
        incomplete: exploration.incomplete,
    })
}

/// Describes the values of an input.
fn restriction(machine: &Machine, input: &InputValues) -> String {
    let naming = machine.naming();
    let values = input
        .values
        .iter()
        .map(|value| value.show(&naming).to_string());
    let names = &machine.program().symbols.functions;
    let name = names
        .get(input.function.0 as usize)
        .map_or("", |name| &**name);
    format!(
        "{name} in {{{}}}",
        values.collect::<Vec<String>>().join(", ")
    )
}

fn refusal(specification: Specification, report: Report) -> Refusal {
    Refusal {
        specification: Box::new(specification),
        report,
    }
}

fn explain(
    specification: &Specification,
    machine: &Machine,
    error: ExplorationError,
) -> Diagnostic {
    match error {
        ExplorationError::Input(fault) => {
            InputWithoutRange::of(specification, machine, &fault.fault).diagnostic()
        }
        ExplorationError::Alternatives => TooManyAlternatives::of(specification).diagnostic(),
        ExplorationError::Initial(fault) => specification.explain(&fault.fault),
    }
}
