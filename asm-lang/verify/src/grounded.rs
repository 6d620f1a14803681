//! Exploration of a grounded specification: states are words, and steps are commands on them. A machine executes the steps that are
//! not grounded, and those that fail.

mod case;
mod cases;
mod command;
mod condition;
mod condition_index;
mod independence;
mod layout;
mod machine_steps;
mod run;
mod shared_steps;
mod steps;
mod store;
mod stored_words;
mod symmetry;

use crate::explore::{Conditions, Exploration, ExplorationError, ExplorationOptions, Progress};
use crate::fair_moves::FairMoves;
use crate::inputs::InputRanges;
use crate::transition::TransitionSystem;
use asmotion_ground::{
    GroundAlternative, GroundProgram, GroundRule, GroundTerm, GroundingContext, UNDEF,
    accesses_of_rule, accesses_of_term, cone, ground,
};
use asmotion_lang::ir::FunctionId;
use asmotion_lang::{Machine, Value};
use layout::{WordLayout, widen};
use run::{GroundedRun, StoppedRun};
use std::collections::BTreeSet;
use symmetry::Symmetry;

/// Limit for the alternatives of a step that become commands.
const MAX_ALTERNATIVES: usize = 2000;

/// Limit for the attempts with wider and wider ranges.
const MAX_ATTEMPTS: usize = 200;

/// A step of a grounded program.
#[derive(Debug)]
pub(crate) enum GroundedStep {
    /// Its choices as a list; it reads no inputs.
    Alternatives(Vec<GroundAlternative>),
    /// Its rule, executed once for each combination of choices and inputs.
    Rule,
}

/// A grounded program that can be explored.
#[derive(Debug)]
pub(crate) struct Grounded {
    pub program: GroundProgram,
    pub step: GroundedStep,
    /// The conditions of the exploration.
    pub conditions: Vec<GroundTerm>,
    /// `true` if a state is one node for each combination of the inputs that conditions read, and none if an assumption excludes it;
    /// otherwise it is one node.
    pub has_cases: bool,
    /// Names of functions of which locations were left out.
    pub left_out: Vec<String>,
}

impl Grounded {
    /// Grounds a system; `None` if that has no advantage, or if its states are more than locations.
    fn of(
        machine: &Machine,
        ranges: &InputRanges,
        conditions: &Conditions,
        needed: Option<&BTreeSet<usize>>,
    ) -> Option<Self> {
        if !machine.can_revert() {
            return None;
        }
        let context = GroundingContext {
            program: machine.program(),
            initial: machine.slots(),
            extent: &|domain| machine.state().extent(domain).to_vec(),
            inputs: &|function| ranges.of(function).ok().map(<[Value]>::to_vec),
        };
        let mut program = ground(&context).ok()?;
        if program.rule == GroundRule::Machine {
            return None;
        }
        let terms = conditions.terms.iter();
        let terms = terms.map(|it| program.conditions.get(it.term.0 as usize).cloned());
        let mut terms = terms.collect::<Option<Vec<GroundTerm>>>()?;
        let mut left_out = Vec::new();
        if let Some(needed) = needed {
            for (index, term) in terms.iter_mut().enumerate() {
                if !needed.contains(&index) && !conditions.assumed.contains(&index) {
                    *term = GroundTerm::Constant(0);
                }
            }
            left_out = leave_out(machine, &mut program, &terms);
            if left_out.is_empty() {
                return None;
            }
        }
        let mut of_inputs = terms
            .iter()
            .map(|term| !accesses_of_term(term).inputs.is_empty());
        let has_cases = of_inputs.any(|it| it) || !conditions.assumed.is_empty();
        let reads_inputs = !accesses_of_rule(&program.rule).inputs.is_empty();
        let alternatives = program.alternatives(MAX_ALTERNATIVES);
        let step = match alternatives {
            Some(alternatives) if !reads_inputs => GroundedStep::Alternatives(alternatives),
            Some(_) | None => GroundedStep::Rule,
        };
        Some(Self {
            program,
            step,
            conditions: terms,
            has_cases,
            left_out,
        })
    }
}

/// Leaves out the variables on which terms do not depend: they keep their initial values. Returns the names of their functions.
fn leave_out(machine: &Machine, program: &mut GroundProgram, terms: &[GroundTerm]) -> Vec<String> {
    if accesses_of_rule(&program.rule).needs_machine {
        return Vec::new();
    }
    let kept = cone(&program.rule, terms);
    let mut left_out = BTreeSet::new();
    for (index, variable) in (0u32..).zip(&mut program.variables) {
        if !kept.contains(&index) {
            let initial = variable.initial;
            variable.may_be_undef = initial == UNDEF;
            variable.range = if initial == UNDEF {
                (0, 0)
            } else {
                (initial, initial)
            };
            left_out.insert(variable.function);
        }
    }
    program.rule = program.rule.projected(&kept);
    let names = &machine.program().symbols.functions;
    let name = |function: &FunctionId| names.get(function.0 as usize).map(ToString::to_string);
    left_out.iter().filter_map(name).collect()
}

/// Explores a system in its grounded form. `None` if it has none, or if its states turn out to be more than locations.
pub(crate) fn explore<S: TransitionSystem>(
    system: &S,
    conditions: &Conditions,
    options: &ExplorationOptions,
    fair: &FairMoves,
    proceed: &mut dyn FnMut(Progress) -> bool,
) -> Result<Option<Exploration>, ExplorationError> {
    let Some((machine, ranges)) = system.single() else {
        return Ok(None);
    };
    let Some(mut grounded) = Grounded::of(machine, ranges, conditions, options.cone.as_ref())
    else {
        return Ok(None);
    };
    if !fair.is_empty() && matches!(grounded.step, GroundedStep::Rule) {
        return Ok(None);
    }
    // fairness to agents tells apart what symmetry does not
    let symmetry = if options.symmetry && fair.is_empty() && !grounded.has_cases {
        Symmetry::of(machine, &grounded.program, &grounded.conditions)
    } else {
        Symmetry::default()
    };
    for _ in 0..MAX_ATTEMPTS {
        symmetry.align(&mut grounded.program);
        let Some(layout) = WordLayout::of(&grounded.program) else {
            return Ok(None);
        };
        let words = symmetry.in_words(&layout);
        let request = run::RunRequest {
            symmetry: (!symmetry.is_empty()).then_some(&words),
            grounded: &grounded,
            layout: &layout,
            conditions,
            options,
            fair,
        };
        let stopped = match layout.words {
            1 => GroundedRun::<1>::explore(machine, ranges, &request, proceed),
            2 => GroundedRun::<2>::explore(machine, ranges, &request, proceed),
            3 | 4 => GroundedRun::<4>::explore(machine, ranges, &request, proceed),
            _ => GroundedRun::<8>::explore(machine, ranges, &request, proceed),
        };
        match stopped {
            Ok(mut exploration) => {
                exploration.symmetric = symmetry.names();
                exploration.left_out.clone_from(&grounded.left_out);
                return Ok(Some(exploration));
            }
            Err(StoppedRun::Error(error)) => return Err(error),
            Err(StoppedRun::NotGrounded) => return Ok(None),
            Err(StoppedRun::Wider(variable, number)) => {
                let variable = grounded.program.variables.get_mut(variable as usize);
                if !variable.is_some_and(|variable| widen(variable, number)) {
                    return Ok(None);
                }
            }
        }
    }
    Ok(None)
}
