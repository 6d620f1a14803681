//! Steps that do not influence each other: of the orders in which they can happen, one is explored.
//!
//! In each state, the commands of a *stubborn set* are executed (Valmari, "Stubborn sets for reduced state space generation", 1991).
//! With a command that changes the state, the set contains all commands that read or write what it writes, or write what it reads.
//! With one that does not, it contains the commands that write a variable for which it does not. So no command outside the set can
//! influence one of the set before one of the set is executed, and nothing that is stuck is missed.
//!
//! Conditions are evaluated in the states that are explored. A set in which a command writes a variable that a condition reads is
//! therefore not used. Nor is one whose commands lead back to states that were explored before: a command could be put off for ever.
//! A step that fails is found because commands that are put off are nevertheless evaluated, and executed later.

use super::case::Case;
use super::layout::{Field, WordLayout, Words};
use asmotion_ground::GroundTerm;
use std::collections::BTreeSet;

/// Limit for the number of commands, of which each pair is compared.
const MAX_COMMANDS: usize = 4096;

/// Number of commands from which a stubborn set is tried to be built.
const MAX_SEEDS: usize = 8;

/// A set of commands.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct CommandSet(Vec<u64>);

impl CommandSet {
    fn of(count: usize, is_in: impl Fn(usize) -> bool) -> Self {
        let mut words = vec![0; count.div_ceil(64)];
        for index in (0..count).filter(|index| is_in(*index)) {
            if let Some(word) = words.get_mut(index / 64) {
                *word |= 1u64 << (index % 64);
            }
        }
        Self(words)
    }

    fn contains(&self, index: usize) -> bool {
        let word = self.0.get(index / 64).copied().unwrap_or(0);
        word >> (index % 64) & 1 == 1
    }

    fn len(&self) -> u32 {
        self.0.iter().map(|word| word.count_ones()).sum()
    }

    /// Adds other commands; those that are new are also added to `waiting`.
    fn add(&mut self, others: &Self, waiting: &mut Vec<usize>) {
        for (index, (word, other)) in self.0.iter_mut().zip(&others.0).enumerate() {
            let mut new = other & !*word;
            *word |= other;
            while new != 0 {
                waiting.push(index * 64 + new.trailing_zeros() as usize);
                new &= new - 1;
            }
        }
    }
}

/// The variables that a command accesses.
#[derive(Clone, Debug)]
pub(crate) struct CommandAccesses {
    /// Those of which its condition has a set of codes, each with the codes.
    restricted: Vec<(u32, Vec<bool>)>,
    /// Those that decide whether it changes the state, and what it writes.
    reads: BTreeSet<u32>,
    writes: BTreeSet<u32>,
}

impl CommandAccesses {
    /// `reads` returns the variables of a term.
    pub fn of(case: &Case, reads: impl Fn(&GroundTerm) -> Vec<u32>) -> Self {
        let restricted = case.when.codes.iter();
        let writes: BTreeSet<u32> = case.updates.iter().map(|it| it.0).collect();
        let mut read: BTreeSet<u32> = case.when.codes.keys().copied().collect();
        for literal in &case.when.literals {
            read.extend(&literal.variables);
        }
        for (_, term) in &case.updates {
            read.extend(reads(term));
        }
        // it changes the state if what it writes is different
        read.extend(&writes);
        Self {
            restricted: restricted.map(|(it, codes)| (*it, codes.clone())).collect(),
            reads: read,
            writes,
        }
    }

    fn is_dependent(&self, other: &Self) -> bool {
        !self.writes.is_disjoint(&other.reads) || !other.writes.is_disjoint(&self.reads)
    }
}

/// The relation of a command to the others.
#[derive(Clone, Debug)]
struct CommandRelation {
    dependent: CommandSet,
    /// Variables of which its condition has a set of codes, with the commands that write them.
    restricted: Vec<(Field, Vec<bool>, CommandSet)>,
    /// Commands that write a variable that it reads.
    enabling: CommandSet,
    /// `true` if it writes a variable that a condition reads.
    is_visible: bool,
}

/// Which commands influence each other.
#[derive(Clone, Debug)]
pub(crate) struct Independence(Vec<CommandRelation>);

impl Independence {
    /// Compares commands; `None` if there are too many, or if all of them influence each other. `visible` are the variables that
    /// conditions read.
    pub fn of(
        layout: &WordLayout,
        commands: &[CommandAccesses],
        visible: &BTreeSet<u32>,
    ) -> Option<Self> {
        let count = commands.len();
        if count > MAX_COMMANDS {
            return None;
        }
        let writers = |variable: u32| {
            CommandSet::of(count, |other| {
                commands
                    .get(other)
                    .is_some_and(|it| it.writes.contains(&variable))
            })
        };
        let relations = commands.iter().map(|command| CommandRelation {
            dependent: CommandSet::of(count, |other| {
                commands
                    .get(other)
                    .is_some_and(|it| command.is_dependent(it))
            }),
            restricted: command
                .restricted
                .iter()
                .filter_map(|(variable, codes)| {
                    let field = layout.field(*variable)?.clone();
                    Some((field, codes.clone(), writers(*variable)))
                })
                .collect(),
            enabling: CommandSet::of(count, |other| {
                let other = commands.get(other);
                other.is_some_and(|it| !it.writes.is_disjoint(&command.reads))
            }),
            is_visible: !command.writes.is_disjoint(visible),
        });
        let relations: Vec<CommandRelation> = relations.collect();
        let all = |it: &CommandRelation| it.is_visible || it.dependent.len() as usize == count;
        (!relations.iter().all(all)).then_some(Self(relations))
    }

    /// Returns the smallest stubborn set that is found in a state and can be used: which of the commands that change the state
    /// belong to it. `None` if all do. `is_new` tells whether the state to which a command leads was not explored before.
    pub fn stubborn<const W: usize>(
        &self,
        state: &Words<W>,
        changing: &[usize],
        is_new: impl Fn(usize) -> bool,
    ) -> Option<Vec<bool>> {
        let is_changing = CommandSet::of(self.0.len(), |it| changing.binary_search(&it).is_ok());
        let mut best: Option<(usize, Vec<bool>)> = None;
        for seed in changing.iter().take(MAX_SEEDS) {
            let set = self.closed(state, *seed, &is_changing);
            let kept: Vec<bool> = changing.iter().map(|it| set.contains(*it)).collect();
            let size = kept.iter().filter(|it| **it).count();
            let is_smaller = best.as_ref().map_or(changing.len(), |it| it.0) > size;
            let members = || changing.iter().enumerate().filter(|(at, _)| kept[*at]);
            let is_visible = |command: &usize| self.0.get(*command).is_none_or(|it| it.is_visible);
            if is_smaller
                && !members().any(|(_, command)| is_visible(command))
                && members().any(|(at, _)| is_new(at))
            {
                best = Some((size, kept));
            }
        }
        best.map(|(_, kept)| kept)
    }

    /// Returns the stubborn set that contains a command.
    fn closed<const W: usize>(
        &self,
        state: &Words<W>,
        seed: usize,
        is_changing: &CommandSet,
    ) -> CommandSet {
        let mut set = CommandSet::of(self.0.len(), |it| it == seed);
        let mut waiting = vec![seed];
        while let Some(command) = waiting.pop() {
            let Some(relation) = self.0.get(command) else {
                continue;
            };
            if is_changing.contains(command) {
                set.add(&relation.dependent, &mut waiting);
                continue;
            }
            // without a change of this variable, the command does not become possible
            let excluded = relation.restricted.iter().filter(|(field, codes, _)| {
                let code = field.get(state) as usize;
                !codes.get(code).copied().unwrap_or(true)
            });
            let writers = excluded.map(|(_, _, writers)| writers);
            let fewest = writers.min_by_key(|it| it.len());
            set.add(fewest.unwrap_or(&relation.enabling), &mut waiting);
        }
        set
    }
}
