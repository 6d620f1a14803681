//! Evaluation of terms and rules, one part after the other. It defines what faster forms have to compute.

use crate::fold::{compared, computed};
use crate::program::{
    FAULT, GroundProgram, GroundRule, GroundTarget, GroundTerm, TableIndex, UNDEF,
};
use asmotion_ir::{Connective, Counter, Quantifier};

/// The nondeterminism of an evaluation: values of inputs, and choices.
pub trait Valuation {
    /// Returns the number of an input variable, the same throughout a step.
    fn input(&mut self, input: u32) -> i64;

    /// Returns the index of the chosen candidate; `count` is at least 1.
    fn choose(&mut self, count: usize) -> usize;
}

/// The updates of a step, and the coverage of its parts.
#[derive(Clone, Debug, Default)]
pub struct GroundUpdates {
    /// Variables with their next numbers, each at most once.
    pub list: Vec<(u32, i64)>,
    /// Executions of each counted part, of all steps executed with this value; its length is the number of counters.
    pub counts: Vec<u64>,
}

/// Evaluates a term in a state, given by the numbers of its variables.
pub fn evaluate(term: &GroundTerm, state: &[i64], valuation: &mut dyn Valuation) -> i64 {
    match term {
        GroundTerm::Constant(number) => *number,
        GroundTerm::Variable(index) => state.get(*index as usize).copied().unwrap_or(FAULT),
        GroundTerm::Input(index) => valuation.input(*index),
        GroundTerm::Not(operand) => match evaluate(operand, state, valuation) {
            0 => 1,
            1 => 0,
            other => other,
        },
        GroundTerm::Logic(connective, left, right) => {
            logic(*connective, left, right, state, valuation)
        }
        GroundTerm::Quantified(quantifier, instances) => {
            quantified(*quantifier, instances, state, valuation)
        }
        GroundTerm::Equal(left, right) => {
            let left = evaluate(left, state, valuation);
            let right = evaluate(right, state, valuation);
            if left == FAULT || right == FAULT {
                FAULT
            } else {
                i64::from(left == right)
            }
        }
        GroundTerm::Compare(comparison, left, right) => {
            let left = evaluate(left, state, valuation);
            compared(*comparison, left, evaluate(right, state, valuation))
        }
        GroundTerm::Arithmetic(operation, left, right) => {
            // the right operand is not evaluated if the left one is undef
            match evaluate(left, state, valuation) {
                UNDEF => UNDEF,
                left => computed(*operation, left, evaluate(right, state, valuation)),
            }
        }
        GroundTerm::If(guard, then, otherwise) => match evaluate(guard, state, valuation) {
            1 => evaluate(then, state, valuation),
            0 => evaluate(otherwise, state, valuation),
            _ => FAULT,
        },
        GroundTerm::Table {
            indices,
            elements,
            undefined,
        } => match position(indices, state, valuation) {
            TablePosition::At(at) => {
                let element = elements.get(at);
                element.map_or(FAULT, |element| evaluate(element, state, valuation))
            }
            TablePosition::Undefined => evaluate(undefined, state, valuation),
            TablePosition::Outside => FAULT,
        },
        GroundTerm::After(first, last) => {
            for term in first {
                if evaluate(term, state, valuation) == FAULT {
                    return FAULT;
                }
            }
            evaluate(last, state, valuation)
        }
    }
}

fn logic(
    connective: Connective,
    left: &GroundTerm,
    right: &GroundTerm,
    state: &[i64],
    valuation: &mut dyn Valuation,
) -> i64 {
    let left = evaluate(left, state, valuation);
    match (connective, left) {
        (_, FAULT) => return FAULT,
        (Connective::And, 0) => return 0,
        (Connective::Or, 1) | (Connective::Implies, 0) => return 1,
        _ => {}
    }
    let right = evaluate(right, state, valuation);
    if right == FAULT {
        return FAULT;
    }
    match connective {
        Connective::And => {
            if left == 1 || right == 0 {
                right
            } else {
                UNDEF
            }
        }
        Connective::Or => {
            if left == 0 || right == 1 {
                right
            } else {
                UNDEF
            }
        }
        Connective::Implies => {
            if left == 1 || right == 1 {
                right
            } else {
                UNDEF
            }
        }
        Connective::Xor | Connective::Iff => {
            if left == UNDEF || right == UNDEF {
                UNDEF
            } else {
                i64::from((left == right) == (connective == Connective::Iff))
            }
        }
    }
}

fn quantified(
    quantifier: Quantifier,
    instances: &[GroundTerm],
    state: &[i64],
    valuation: &mut dyn Valuation,
) -> i64 {
    let (decided_by, enough) = match quantifier {
        Quantifier::Forall => (0, 1),
        Quantifier::Exists => (1, 1),
        Quantifier::ExistsUnique => (1, 2),
    };
    let (mut found, mut is_open) = (0, false);
    for instance in instances {
        let truth = evaluate(instance, state, valuation);
        if truth == FAULT {
            return FAULT;
        }
        is_open |= truth == UNDEF;
        found += u32::from(truth == decided_by);
        if found >= enough {
            break;
        }
    }
    match (quantifier, found) {
        (Quantifier::Forall | Quantifier::Exists, 0) | (Quantifier::ExistsUnique, 0 | 1)
            if is_open =>
        {
            UNDEF
        }
        (Quantifier::Forall, found) => i64::from(found == 0),
        (Quantifier::Exists, found) => i64::from(found > 0),
        (Quantifier::ExistsUnique, found) => i64::from(found == 1),
    }
}

enum TablePosition {
    At(usize),
    Undefined,
    Outside,
}

fn position(indices: &[TableIndex], state: &[i64], valuation: &mut dyn Valuation) -> TablePosition {
    let mut at = 0;
    let mut is_undefined = false;
    for index in indices {
        match evaluate(&index.term, state, valuation) {
            FAULT => return TablePosition::Outside,
            UNDEF => is_undefined = true,
            number => {
                let row = number.checked_sub(index.low);
                let row = row.and_then(|row| u32::try_from(row).ok());
                match row.filter(|row| *row < index.count) {
                    Some(row) => at += row as usize * index.stride as usize,
                    None => return TablePosition::Outside,
                }
            }
        }
    }
    if is_undefined {
        TablePosition::Undefined
    } else {
        TablePosition::At(at)
    }
}

/// A machine has to execute the step.
struct NeedsMachine;

/// Executes the main rule in a state, which is the same afterwards. Returns `false` if a machine has to execute the step: the
/// updates are then incomplete.
pub fn execute(
    program: &GroundProgram,
    rule: &GroundRule,
    state: &mut [i64],
    valuation: &mut dyn Valuation,
    updates: &mut GroundUpdates,
) -> bool {
    updates.list.clear();
    let mut saved = Vec::new();
    let mut execution = Execution {
        program,
        state,
        valuation,
        updates,
        saved: &mut saved,
        layer: 0,
    };
    let done = execution.rule(rule);
    // a failed sequence has left an intermediate state
    for (variable, number) in saved.into_iter().rev() {
        if let Some(known) = state.get_mut(variable as usize) {
            *known = number;
        }
    }
    done.is_ok()
}

struct Execution<'a> {
    program: &'a GroundProgram,
    state: &'a mut [i64],
    valuation: &'a mut dyn Valuation,
    updates: &'a mut GroundUpdates,
    /// Numbers that intermediate states have replaced.
    saved: &'a mut Vec<(u32, i64)>,
    /// Index of the first update of the innermost set.
    layer: usize,
}

impl Execution<'_> {
    fn term(&mut self, term: &GroundTerm) -> Result<i64, NeedsMachine> {
        match evaluate(term, self.state, self.valuation) {
            FAULT => Err(NeedsMachine),
            number => Ok(number),
        }
    }

    fn truth(&mut self, guard: &GroundTerm) -> Result<bool, NeedsMachine> {
        match self.term(guard)? {
            1 => Ok(true),
            0 => Ok(false),
            _ => Err(NeedsMachine),
        }
    }

    fn rule(&mut self, rule: &GroundRule) -> Result<(), NeedsMachine> {
        match rule {
            GroundRule::Skip => Ok(()),
            GroundRule::Machine => Err(NeedsMachine),
            GroundRule::Update(target, value, _) => {
                let value = self.term(value)?;
                let variable = match target {
                    GroundTarget::Variable(variable) => *variable,
                    GroundTarget::Table(indices, variables) => {
                        match position(indices, self.state, self.valuation) {
                            TablePosition::At(at) => *variables.get(at).ok_or(NeedsMachine)?,
                            TablePosition::Undefined | TablePosition::Outside => {
                                return Err(NeedsMachine);
                            }
                        }
                    }
                };
                let declared = self.program.variables.get(variable as usize);
                if !declared.is_some_and(|it| it.permitted.accepts(value)) {
                    return Err(NeedsMachine);
                }
                self.write(variable, value)
            }
            GroundRule::Par(rules) => rules.iter().try_for_each(|rule| self.rule(rule)),
            GroundRule::Seq(rules) => self.sequence(rules),
            GroundRule::If(guard, then, otherwise) => {
                if self.truth(guard)? {
                    self.rule(then)
                } else {
                    self.rule(otherwise)
                }
            }
            GroundRule::Choose(candidates, otherwise, _) => {
                let mut enabled = Vec::new();
                for candidate in candidates {
                    if self.truth(&candidate.guard)? {
                        enabled.push(candidate);
                    }
                }
                if enabled.is_empty() {
                    return self.rule(otherwise);
                }
                let chosen = self.valuation.choose(enabled.len());
                match enabled.get(chosen.min(enabled.len() - 1)) {
                    Some(candidate) => self.rule(&candidate.rule),
                    None => Err(NeedsMachine),
                }
            }
            GroundRule::After(terms, rule) => {
                for term in terms {
                    self.term(term)?;
                }
                self.rule(rule)
            }
            GroundRule::Counted(Counter::Count(counter), rule) => {
                self.count(*counter);
                self.rule(rule)
            }
            GroundRule::Counted(Counter::Rounds { round, none }, rule) => {
                let before = self.counted(*round);
                self.rule(rule)?;
                let rounds = self.counted(*round) - before;
                self.count(none + rounds.min(2) as u32);
                Ok(())
            }
        }
    }

    fn counted(&self, counter: u32) -> u64 {
        let counts = &self.updates.counts;
        counts.get(counter as usize).copied().unwrap_or(0)
    }

    fn count(&mut self, counter: u32) {
        if let Some(count) = self.updates.counts.get_mut(counter as usize) {
            *count += 1;
        }
    }

    /// Adds an update to the innermost set.
    fn write(&mut self, variable: u32, value: i64) -> Result<(), NeedsMachine> {
        let set = self.updates.list.get(self.layer..).unwrap_or_default();
        match set.iter().find(|(known, _)| *known == variable) {
            Some((_, known)) if *known == value => Ok(()),
            Some(_) => Err(NeedsMachine),
            None => {
                self.updates.list.push((variable, value));
                Ok(())
            }
        }
    }

    fn sequence(&mut self, rules: &[GroundRule]) -> Result<(), NeedsMachine> {
        let outer = self.layer;
        let start = self.updates.list.len();
        let saved = self.saved.len();
        for rule in rules {
            self.layer = self.updates.list.len();
            self.rule(rule)?;
            let new = self.updates.list.split_off(self.layer);
            for (variable, value) in new {
                if let Some(known) = self.state.get_mut(variable as usize) {
                    self.saved.push((variable, *known));
                    *known = value;
                }
                // later updates override earlier ones of the sequence
                let set = self.updates.list.get_mut(start..).unwrap_or_default();
                match set.iter_mut().find(|(known, _)| *known == variable) {
                    Some((_, known)) => *known = value,
                    None => self.updates.list.push((variable, value)),
                }
            }
        }
        for (variable, number) in self.saved.drain(saved..).rev() {
            if let Some(known) = self.state.get_mut(variable as usize) {
                *known = number;
            }
        }
        self.layer = outer;
        let net = self.updates.list.split_off(start);
        net.into_iter()
            .try_for_each(|(variable, value)| self.write(variable, value))
    }
}
