//! Cases compiled to commands: masks and tables over the words of a state.

use super::case::{Case, Closed, Division, NoCases};
use super::condition::{Selection, WordCondition};
use super::condition_index::ConditionIndex;
use super::independence::CommandAccesses;
use super::layout::{Field, WordLayout, Words, union, word_of};
use crate::fair_moves::{FairMoves, MovedSet};
use asmotion_ground::{
    FAULT, GroundAlternative, GroundProgram, GroundTerm, Permitted, UNDEF, evaluate,
};

/// Entry of a table of codes: a machine executes the step.
const MACHINE: u64 = u64::MAX;

/// Entry of a table of codes: the layout has no code for the number.
const WIDER: u64 = u64::MAX - 1;

/// The next code of a variable, computed from the state.
#[derive(Clone, Debug)]
enum NextCode {
    /// The code of another field with the same coding.
    Copy(Field),
    /// The code that a table has for the selected codes.
    Table(Selection, Box<[u64]>),
    /// The value of a term.
    Term(GroundTerm, Permitted),
}

/// The reason for which a command has no successor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoSuccessor {
    /// A machine has to execute the step.
    Machine,
    /// The layout has no code for a number of this variable.
    Wider(u32, i64),
}

/// A step.
#[derive(Clone, Debug)]
pub(crate) struct Command<const W: usize> {
    /// Bits that remain as they are.
    keep: Words<W>,
    /// Bits that are set.
    set: Words<W>,
    computed: Box<[(u32, Field, NextCode)]>,
    needs_machine: bool,
    /// `true` if it updates a variable, even if only to the same value.
    pub has_updates: bool,
    /// Coverage counters that it executes.
    pub counters: Box<[u32]>,
    /// Agents and rules that it moves if it changes the state.
    pub moved: MovedSet,
}

impl<const W: usize> Command<W> {
    fn of(program: &GroundProgram, division: &Division<'_>, case: &Case) -> Self {
        let layout = division.layout;
        let (mut keep, mut set) = ([u64::MAX; W], [0; W]);
        let mut computed = Vec::new();
        let mut needs_machine = case.needs_machine;
        let mut updates: Vec<&(u32, GroundTerm)> = Vec::new();
        for update in &case.updates {
            match updates.iter().find(|known| known.0 == update.0) {
                Some(known) if known.1 == update.1 => {}
                // perhaps a clash, which a machine describes
                Some(_) => needs_machine = true,
                None => updates.push(update),
            }
        }
        for (variable, value) in updates {
            let index = *variable as usize;
            let (Some(field), Some(declared)) =
                (layout.field(*variable), program.variables.get(index))
            else {
                continue;
            };
            let code_of = |number: i64| {
                if number == FAULT || !declared.permitted.accepts(number) {
                    return MACHINE;
                }
                field.code(number).unwrap_or(WIDER)
            };
            let next = match value {
                GroundTerm::Constant(number) if code_of(*number) == MACHINE => {
                    needs_machine = true;
                    continue;
                }
                GroundTerm::Constant(number) if code_of(*number) != WIDER => {
                    for (word, cleared) in keep.iter_mut().zip(field.bits_in::<W>()) {
                        *word &= !cleared;
                    }
                    field.set(&mut set, code_of(*number));
                    continue;
                }
                GroundTerm::Variable(from) => {
                    let source = layout.field(*from);
                    let same = source.filter(|source| {
                        let is_alike = (source.low, source.count) == (field.low, field.count);
                        let fits = |code| code_of(source.number(code)) < WIDER;
                        is_alike
                            && (0..source.codes()).len_at_most(1 << 11)
                            && (0..source.codes()).all(fits)
                    });
                    same.map(|source| NextCode::Copy(source.clone()))
                }
                GroundTerm::Constant(_)
                | GroundTerm::Input(_)
                | GroundTerm::Not(_)
                | GroundTerm::Logic(..)
                | GroundTerm::Quantified(..)
                | GroundTerm::Equal(..)
                | GroundTerm::Compare(..)
                | GroundTerm::Arithmetic(..)
                | GroundTerm::If(..)
                | GroundTerm::Table { .. }
                | GroundTerm::After(..) => None,
            };
            let next = next.unwrap_or_else(|| {
                if !division.is_small(value) {
                    return NextCode::Term(value.clone(), declared.permitted.clone());
                }
                let reads = division.reads(value);
                let codes = division.values(value, &reads).into_iter().map(code_of);
                let codes: Box<[u64]> = codes.collect();
                if codes.contains(&WIDER) {
                    // the number is needed to choose a wider range
                    return NextCode::Term(value.clone(), declared.permitted.clone());
                }
                NextCode::Table(Selection::of(layout, &reads), codes)
            });
            computed.push((*variable, field.clone(), next));
        }
        Self {
            keep,
            set,
            computed: computed.into(),
            needs_machine,
            has_updates: !case.updates.is_empty() || case.needs_machine,
            counters: case.counters.clone().into(),
            moved: 0,
        }
    }

    /// Returns the next state.
    #[inline]
    pub fn next(&self, layout: &WordLayout, state: &Words<W>) -> Result<Words<W>, NoSuccessor> {
        let mut next = *state;
        for (index, word) in next.iter_mut().enumerate() {
            *word = *word & word_of(&self.keep, index) | word_of(&self.set, index);
        }
        if self.needs_machine {
            return Err(NoSuccessor::Machine);
        }
        for (variable, field, code) in &self.computed {
            let code = match code {
                NextCode::Copy(from) => from.get(state),
                NextCode::Table(selection, codes) => {
                    match codes.get(selection.index(state)).copied() {
                        Some(MACHINE) | None => return Err(NoSuccessor::Machine),
                        Some(code) => code,
                    }
                }
                NextCode::Term(term, permitted) => {
                    let mut numbers = Vec::new();
                    layout.decode(state, &mut numbers);
                    let number = evaluate(term, &numbers, &mut Closed);
                    if number == FAULT || !permitted.accepts(number) {
                        return Err(NoSuccessor::Machine);
                    }
                    let code = field.code(number);
                    code.ok_or(NoSuccessor::Wider(*variable, number))?
                }
            };
            field.set(&mut next, code);
        }
        Ok(next)
    }
}

/// Ranges with a known length.
trait LengthLimit {
    fn len_at_most(&self, limit: u64) -> bool;
}

impl LengthLimit for std::ops::Range<u64> {
    fn len_at_most(&self, limit: u64) -> bool {
        self.end.saturating_sub(self.start) <= limit
    }
}

/// The alternatives of a step as code.
pub(crate) struct StepCode<const W: usize> {
    /// Commands with updates, in the order of their alternatives.
    pub commands: Vec<Command<W>>,
    /// Variables that each of `commands` accesses, in the same order.
    pub accesses: Vec<CommandAccesses>,
    /// The conditions under which `commands` are executed.
    pub index: ConditionIndex<W>,
    /// Commands without updates.
    pub idle: Vec<Command<W>>,
    /// The conditions under which `idle` are executed.
    pub idle_index: ConditionIndex<W>,
    /// Alternatives that are executed part by part, each with the number of commands before it.
    pub interpreted: Vec<(usize, GroundAlternative)>,
}

impl<const W: usize> StepCode<W> {
    pub fn of(
        program: &GroundProgram,
        layout: &WordLayout,
        alternatives: &[GroundAlternative],
        fair: &FairMoves,
    ) -> Self {
        let division = Division { layout };
        let (mut conditions, mut idle_conditions) = (Vec::new(), Vec::new());
        let mut code = Self {
            commands: Vec::new(),
            accesses: Vec::new(),
            index: ConditionIndex::default(),
            idle: Vec::new(),
            idle_index: ConditionIndex::default(),
            interpreted: Vec::new(),
        };
        for alternative in alternatives {
            match division.cases(&alternative.guards, &alternative.rule) {
                Ok(cases) => {
                    for case in cases {
                        let mut command = Command::of(program, &division, &case);
                        let chosen = alternative.choices.iter();
                        let chosen = chosen.map(|choice| (choice.origin, &*choice.chosen));
                        command.moved = fair.of_step(chosen, &case.counters);
                        let when = WordCondition::of(&division, &case.when);
                        if command.has_updates {
                            conditions.push(when);
                            code.commands.push(command);
                            let reads = |term: &GroundTerm| division.reads(term);
                            code.accesses.push(CommandAccesses::of(&case, reads));
                        } else {
                            idle_conditions.push(when);
                            code.idle.push(command);
                        }
                    }
                }
                Err(NoCases) => {
                    code.interpreted
                        .push((code.commands.len(), alternative.clone()));
                }
            }
        }
        code.index = ConditionIndex::of(layout, conditions);
        code.idle_index = ConditionIndex::of(layout, idle_conditions);
        code
    }
}

/// The truth value of a condition in a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GroundTruth {
    True,
    False,
    Undef,
    /// A machine has to evaluate it.
    Fault,
}

/// A condition as code.
pub(crate) enum ConditionCode<const W: usize> {
    /// False where one of these holds, otherwise true.
    FalseIf(ConditionIndex<W>),
    /// True where one of these holds, otherwise false.
    TrueIf(ConditionIndex<W>),
    /// Evaluated part by part.
    Term(GroundTerm),
}

/// A condition with the bits that it depends on.
pub(crate) struct CompiledCondition<const W: usize> {
    /// The bits of the variables that it reads.
    pub reads: Words<W>,
    pub code: ConditionCode<W>,
}

impl<const W: usize> CompiledCondition<W> {
    pub fn of(layout: &WordLayout, term: &GroundTerm) -> Self {
        let division = Division { layout };
        let mut reads = [0; W];
        for variable in division.reads(term) {
            if let Some(field) = layout.field(variable) {
                reads = union(&reads, &field.bits_in());
            }
        }
        let conditions = |wanted| {
            let truths = division.truths(term, wanted).ok()?;
            let words = truths.iter().map(|it| WordCondition::of(&division, it));
            (truths.len() <= 128).then(|| ConditionIndex::of(layout, words.collect()))
        };
        // the cases of truth and falsehood tell the values apart only if there is no third
        let code = if division.is_total(term) {
            let (falses, truths) = (conditions(false), conditions(true));
            match (falses, truths) {
                (Some(falses), Some(truths)) if falses.len() <= truths.len() => {
                    ConditionCode::FalseIf(falses)
                }
                (_, Some(truths)) => ConditionCode::TrueIf(truths),
                (Some(falses), None) => ConditionCode::FalseIf(falses),
                (None, None) => ConditionCode::Term(term.clone()),
            }
        } else {
            ConditionCode::Term(term.clone())
        };
        Self { reads, code }
    }

    /// Returns the value in a state.
    pub fn truth(
        &self,
        layout: &WordLayout,
        state: &Words<W>,
        numbers: &mut Vec<i64>,
    ) -> GroundTruth {
        let of = |truth| {
            if truth {
                GroundTruth::True
            } else {
                GroundTruth::False
            }
        };
        match &self.code {
            ConditionCode::FalseIf(any) => of(!any.holds(state)),
            ConditionCode::TrueIf(any) => of(any.holds(state)),
            ConditionCode::Term(term) => {
                layout.decode(state, numbers);
                match evaluate(term, numbers, &mut Closed) {
                    0 => GroundTruth::False,
                    UNDEF => GroundTruth::Undef,
                    FAULT => GroundTruth::Fault,
                    _ => GroundTruth::True,
                }
            }
        }
    }
}
