//! Ranges of terms and variables: what numbers they can have, and whether they can be undef.

use crate::program::{
    FAULT, GroundCandidate, GroundProgram, GroundRule, GroundTarget, GroundTerm, InputVariable,
    Permitted, Sort, StateVariable, UNDEF,
};
use asmotion_ir::IntegerInterval;

/// Rounds after which a growing range is given up.
const MAX_ROUNDS: usize = 40;

/// Returns `true` unless a term is never undef. Faults are not considered.
pub(crate) fn may_be_undef(
    term: &GroundTerm,
    variables: &[StateVariable],
    inputs: &[InputVariable],
) -> bool {
    let any = |terms: &[&GroundTerm]| {
        terms
            .iter()
            .any(|term| may_be_undef(term, variables, inputs))
    };
    match term {
        GroundTerm::Constant(number) => *number == UNDEF,
        GroundTerm::Variable(index) => variables
            .get(*index as usize)
            .is_none_or(|variable| variable.may_be_undef),
        GroundTerm::Input(index) => inputs
            .get(*index as usize)
            .is_none_or(|input| input.values.contains(&UNDEF)),
        GroundTerm::Equal(..) => false,
        GroundTerm::If(_, then, otherwise) => any(&[then, otherwise]),
        GroundTerm::Table {
            indices,
            elements,
            undefined,
        } => {
            let indices: Vec<&GroundTerm> = indices.iter().map(|index| &index.term).collect();
            let elements: Vec<&GroundTerm> = elements.iter().collect();
            any(&elements) || (any(&indices) && any(&[undefined]))
        }
        GroundTerm::After(_, last) => any(&[last]),
        GroundTerm::Not(_)
        | GroundTerm::Logic(..)
        | GroundTerm::Quantified(..)
        | GroundTerm::Compare(..)
        | GroundTerm::Arithmetic(..) => any(&term.parts()),
    }
}

/// Returns bounds for the numbers of a term that hold in every state. `None` if there are none.
pub(crate) fn permitted_bounds(
    term: &GroundTerm,
    variables: &[StateVariable],
    inputs: &[InputVariable],
) -> Option<(i64, i64)> {
    let of_variable = |variable: &StateVariable| {
        let (low, high) = match &variable.permitted {
            Permitted::All => return None,
            Permitted::Between(low, high) => (*low, *high),
            Permitted::Listed(numbers) => (*numbers.first()?, *numbers.last()?),
        };
        // initial values are not checked
        let initial = variable.initial;
        if initial == UNDEF {
            return Some((low, high));
        }
        Some((low.min(initial), high.max(initial)))
    };
    let found = interval(term, &of_variable, variables, inputs)?;
    (found != IntegerInterval::ANY).then_some((found.low, found.high))
}

/// Returns the interval of a term's numbers besides `undef`; `None` for no number at all.
fn interval(
    term: &GroundTerm,
    of_variable: &dyn Fn(&StateVariable) -> Option<(i64, i64)>,
    variables: &[StateVariable],
    inputs: &[InputVariable],
) -> Option<IntegerInterval> {
    let of = |term: &GroundTerm| interval(term, of_variable, variables, inputs);
    let bounded = |bounds: Option<(i64, i64)>| {
        Some(
            bounds.map_or(IntegerInterval::ANY, |(low, high)| IntegerInterval {
                low,
                high,
            }),
        )
    };
    match term {
        GroundTerm::Constant(UNDEF | FAULT) => None,
        GroundTerm::Constant(number) => Some(IntegerInterval::of(*number)),
        GroundTerm::Variable(index) => {
            bounded(variables.get(*index as usize).and_then(of_variable))
        }
        GroundTerm::Input(index) => {
            let values = inputs.get(*index as usize)?.values.iter();
            let numbers = values.filter(|number| **number != UNDEF);
            let numbers = numbers.map(|number| IntegerInterval::of(*number));
            numbers.reduce(IntegerInterval::or)
        }
        GroundTerm::Not(_)
        | GroundTerm::Logic(..)
        | GroundTerm::Quantified(..)
        | GroundTerm::Equal(..)
        | GroundTerm::Compare(..) => bounded(Some((0, 1))),
        GroundTerm::Arithmetic(operation, left, right) => {
            let (left, right) = (of(left)?, of(right)?);
            let (computed, overflows) = IntegerInterval::computed(*operation, left, right);
            // an overflow is a fault, so the other results lie within 64 bits
            let _ = overflows;
            Some(computed)
        }
        GroundTerm::If(guard, then, otherwise) => {
            let refined = |holds: bool, term: &GroundTerm| {
                let narrow = |variable: &StateVariable| {
                    let known = of_variable(variable);
                    narrowed(guard, holds, variable, variables, known)
                };
                interval(term, &narrow, variables, inputs)
            };
            match (refined(true, then), refined(false, otherwise)) {
                (Some(then), Some(otherwise)) => Some(then.or(otherwise)),
                (then, otherwise) => then.or(otherwise),
            }
        }
        GroundTerm::Table {
            elements,
            undefined,
            ..
        } => {
            let elements = elements.iter().chain([&**undefined]);
            elements.filter_map(of).reduce(IntegerInterval::or)
        }
        GroundTerm::After(_, last) => of(last),
    }
}

/// Returns the bounds of a variable where a guard is true, or false.
fn narrowed(
    guard: &GroundTerm,
    holds: bool,
    variable: &StateVariable,
    variables: &[StateVariable],
    known: Option<(i64, i64)>,
) -> Option<(i64, i64)> {
    use asmotion_ir::{Comparison, Connective};
    let (low, high) = known.unwrap_or((i64::MIN + 2, i64::MAX));
    let is_it = |term: &GroundTerm| {
        matches!(term, GroundTerm::Variable(index)
            if variables.get(*index as usize).is_some_and(|it| it.slot == variable.slot))
    };
    let bounded = match (guard, holds) {
        (GroundTerm::Logic(Connective::And, left, right), true)
        | (GroundTerm::Logic(Connective::Or, left, right), false) => {
            let known = narrowed(left, holds, variable, variables, known);
            return narrowed(right, holds, variable, variables, known);
        }
        (GroundTerm::Not(operand), _) => {
            return narrowed(operand, !holds, variable, variables, known);
        }
        (GroundTerm::Equal(left, right), true) if is_it(left) => match right.constant() {
            Some(number) if number > FAULT => (low.max(number), high.min(number)),
            Some(_) | None => return known,
        },
        (GroundTerm::Compare(comparison, left, right), _) => {
            let (comparison, number) = match (left.constant(), right.constant()) {
                (None, Some(number)) if is_it(left) => (*comparison, number),
                (Some(number), None) if is_it(right) => (mirrored(*comparison), number),
                _ => return known,
            };
            match (comparison, holds) {
                (Comparison::Lt, true) | (Comparison::Ge, false) => {
                    (low, high.min(number.saturating_sub(1)))
                }
                (Comparison::Le, true) | (Comparison::Gt, false) => (low, high.min(number)),
                (Comparison::Gt, true) | (Comparison::Le, false) => {
                    (low.max(number.saturating_add(1)), high)
                }
                (Comparison::Ge, true) | (Comparison::Lt, false) => (low.max(number), high),
            }
        }
        _ => return known,
    };
    // a contradiction means that the branch is not taken; any bounds will do
    if bounded.0 > bounded.1 {
        known
    } else {
        Some(bounded)
    }
}

fn mirrored(comparison: asmotion_ir::Comparison) -> asmotion_ir::Comparison {
    use asmotion_ir::Comparison;
    match comparison {
        Comparison::Lt => Comparison::Gt,
        Comparison::Le => Comparison::Ge,
        Comparison::Gt => Comparison::Lt,
        Comparison::Ge => Comparison::Le,
    }
}

/// An update that a rule can make: variable, value, and the guards above it with the truth values that they have there.
struct PossibleUpdate<'a> {
    variable: u32,
    value: &'a GroundTerm,
    guards: Vec<(&'a GroundTerm, bool)>,
}

/// Estimates the ranges of the variables, and which of them can become undef.
pub(crate) fn estimate(program: &mut GroundProgram) {
    let rule = std::mem::replace(&mut program.rule, GroundRule::Skip);
    let mut updates = Vec::new();
    let mut needs_machine = false;
    collect(&rule, &mut Vec::new(), &mut updates, &mut needs_machine);
    for variable in &mut program.variables {
        // a machine may give any variable any permitted value
        variable.may_be_undef = needs_machine || variable.initial == UNDEF;
    }
    undefined(program, &updates);
    for variable in &mut program.variables {
        let (low, high) = match &variable.permitted {
            Permitted::Between(low, high) => (*low, *high),
            Permitted::Listed(numbers) => match (numbers.first(), numbers.last()) {
                (Some(low), Some(high)) => (*low, *high),
                _ => continue,
            },
            Permitted::All => continue,
        };
        variable.is_bounded = true;
        variable.range = match variable.initial {
            UNDEF => (low, high),
            initial => (low.min(initial), high.max(initial)),
        };
    }
    unbounded(program, &updates, needs_machine);
    program.rule = rule;
}

fn undefined(program: &mut GroundProgram, updates: &[PossibleUpdate<'_>]) {
    loop {
        let mut changed = false;
        for update in updates {
            let may_be = may_be_undef(update.value, &program.variables, &program.inputs);
            if let Some(variable) = program.variables.get_mut(update.variable as usize)
                && may_be
                && !variable.may_be_undef
            {
                variable.may_be_undef = true;
                changed = true;
            }
        }
        if !changed {
            return;
        }
    }
}

/// Estimates the ranges of variables whose functions accept all integers.
fn unbounded(program: &mut GroundProgram, updates: &[PossibleUpdate<'_>], needs_machine: bool) {
    for variable in &mut program.variables {
        if !variable.is_bounded && variable.initial == UNDEF {
            variable.range = (0, 0);
        }
    }
    let mut changed = true;
    let mut rounds = 0;
    while changed && rounds < MAX_ROUNDS {
        changed = false;
        rounds += 1;
        for update in updates {
            let index = update.variable as usize;
            let Some(variable) = program.variables.get(index).filter(|it| !it.is_bounded) else {
                continue;
            };
            let of_variable = |variable: &StateVariable| {
                let mut known = Some(variable.range);
                for (guard, holds) in &update.guards {
                    known = narrowed(guard, *holds, variable, &program.variables, known);
                }
                known
            };
            let found = interval(
                update.value,
                &of_variable,
                &program.variables,
                &program.inputs,
            );
            let Some(found) = found else {
                continue;
            };
            let (low, high) = variable.range;
            let wider = (low.min(found.low), high.max(found.high));
            if wider != variable.range {
                changed = true;
                if let Some(variable) = program.variables.get_mut(index) {
                    variable.range = wider;
                }
            }
        }
    }
    for variable in &mut program.variables {
        // the ranges that the last round left unchanged contain all values
        variable.is_bounded |= !changed && !needs_machine;
        if !variable.is_bounded && variable.sort == Sort::Int {
            let (low, high) = variable.range;
            variable.range = (low.clamp(-128, 0), high.clamp(127, 1 << 15));
            if variable.initial != UNDEF {
                let (low, high) = variable.range;
                variable.range = (low.min(variable.initial), high.max(variable.initial));
            }
        }
    }
}

fn collect<'a>(
    rule: &'a GroundRule,
    guards: &mut Vec<(&'a GroundTerm, bool)>,
    updates: &mut Vec<PossibleUpdate<'a>>,
    needs_machine: &mut bool,
) {
    stacker::maybe_grow(64 * 1024, 1024 * 1024, || match rule {
        GroundRule::Skip => {}
        GroundRule::Machine => *needs_machine = true,
        GroundRule::Update(target, value, _) => {
            let mut add = |variable| {
                updates.push(PossibleUpdate {
                    variable,
                    value,
                    guards: guards.clone(),
                });
            };
            match target {
                GroundTarget::Variable(variable) => add(*variable),
                GroundTarget::Table(_, variables) => variables.iter().copied().for_each(add),
            }
        }
        GroundRule::Par(rules) => {
            for rule in rules {
                collect(rule, guards, updates, needs_machine);
            }
        }
        GroundRule::Seq(rules) => {
            // guards above hold before the sequence, not within it
            for rule in rules {
                collect(rule, &mut Vec::new(), updates, needs_machine);
            }
        }
        GroundRule::If(guard, then, otherwise) => {
            guards.push((guard, true));
            collect(then, guards, updates, needs_machine);
            guards.pop();
            guards.push((guard, false));
            collect(otherwise, guards, updates, needs_machine);
            guards.pop();
        }
        GroundRule::Choose(candidates, otherwise, _) => {
            for GroundCandidate { guard, rule, .. } in candidates {
                guards.push((guard, true));
                collect(rule, guards, updates, needs_machine);
                guards.pop();
            }
            collect(otherwise, guards, updates, needs_machine);
        }
        GroundRule::After(_, rule) | GroundRule::Counted(_, rule) => {
            collect(rule, guards, updates, needs_machine);
        }
    });
}
