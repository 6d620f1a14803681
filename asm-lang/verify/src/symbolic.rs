//! The symbolic engine: sets of states as decision diagrams instead of single states.

mod judge;
mod walk;

use crate::codes::m001::InputWithoutRange;
use crate::codes::m030::NotSymbolic;
use crate::codes::main_rule;
use crate::explore::{Incomplete, Progress};
use crate::fair_moves::FairMoves;
use crate::inputs::InputRanges;
use crate::options::Options;
use crate::preparation::{Prepared, report_of};
use crate::property::CheckedProperty;
use crate::system::VerifiedMachine;
use crate::transition::SingleMachine;
use asmotion_diagnostics::Finding;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::{Machine, Report, Specification};
use asmotion_symbolic::{
    ModelSource, ReachedCounts, SearchLimit, SearchProgress, SymbolicError, SymbolicModel,
};
use judge::SymbolicJudge;
use std::cell::{Cell, RefCell};

/// Memory for diagrams if there is no limit, in bytes.
const MEMORY: u64 = 4 << 30;

/// Bytes of the stack.
const STACK: usize = 128 << 20;

/// The result of an exploration with decision diagrams.
pub(crate) struct Found {
    pub properties: Vec<CheckedProperty>,
    pub states: u64,
    pub transitions: u64,
    pub excluded: u64,
    /// States in which runs end for some inputs.
    pub ends: u64,
    pub depth: u32,
    /// Memory for diagrams, in bytes.
    pub memory: u64,
    pub incomplete: Option<Incomplete>,
    /// `false` if the assumptions exclude the initial state.
    pub has_initial: bool,
}

/// A verification with decision diagrams.
pub(crate) struct Symbolic<'a> {
    pub known: &'a [VerifiedMachine],
    pub properties: &'a Prepared,
    pub options: &'a Options,
    pub machine: &'a Machine,
    pub ranges: &'a InputRanges,
    /// Agents and rules to which fairness is due: none.
    pub fair: &'a FairMoves,
}

impl Symbolic<'_> {
    /// Finds all states and checks the properties.
    ///
    /// # Errors
    /// The specification has no representation as diagrams.
    pub fn run(&self, proceed: &mut dyn FnMut(Progress) -> bool) -> Result<Found, Report> {
        // operations on diagrams recurse once for each variable: they find the stack large enough
        stacker::maybe_grow(STACK / 2, STACK, || self.explore(proceed))
    }

    fn explore(&self, proceed: &mut dyn FnMut(Progress) -> bool) -> Result<Found, Report> {
        let proceed = RefCell::new(proceed);
        let last = Cell::new(Progress {
            states: 1,
            explored: 0,
            transitions: 0,
            depth: 0,
            memory: 0,
        });
        let again = || (proceed.borrow_mut())(last.get());
        let within_operations = |nodes: usize| {
            let memory = nodes as u64 * SymbolicModel::NODE_BYTES;
            last.set(Progress {
                memory,
                ..last.get()
            });
            again()
        };
        let ranges = |function: FunctionId| self.ranges.of(function).ok().map(<[_]>::to_vec);
        let conditions: Vec<_> = self
            .properties
            .conditions
            .terms
            .iter()
            .map(|it| it.term)
            .collect();
        let source = ModelSource {
            machine: self.machine,
            ranges: &ranges,
            conditions: &conditions,
            assumed: &self.properties.conditions.assumed,
            memory: self.options.limits.memory.unwrap_or(MEMORY),
            proceed: &within_operations,
        };
        let model = match SymbolicModel::of(&source) {
            Ok(model) => model,
            Err(SymbolicError::Memory) => return Ok(self.nothing(Incomplete::Memory)),
            Err(SymbolicError::Stopped) => return Ok(self.nothing(Incomplete::Stopped)),
            Err(error) => return Err(self.explain(error)),
        };
        self.judged(&model, &last, &again)
    }

    /// Finds all states and checks the properties in them.
    fn judged(
        &self,
        model: &SymbolicModel<'_>,
        last: &Cell<Progress>,
        again: &dyn Fn() -> bool,
    ) -> Result<Found, Report> {
        let limits = (self.options.limits.states, self.options.limits.depth);
        let mut searching = |search: SearchProgress| {
            last.set(Progress {
                states: search.states,
                explored: search.states,
                transitions: 0,
                depth: search.depth,
                memory: search.memory,
            });
            again()
        };
        let mut reached = match model.reach(limits, &mut searching) {
            Ok(reached) => reached,
            Err(SymbolicError::Memory) => return Ok(self.nothing(Incomplete::Memory)),
            Err(SymbolicError::Stopped) => return Ok(self.nothing(Incomplete::Stopped)),
            Err(error) => return Err(self.explain(error)),
        };
        if reached.rings.is_empty() {
            return Ok(Found {
                has_initial: false,
                ..self.nothing(Incomplete::Depth)
            });
        }
        // a transition led to each of the states that were found, if there is no time to count them
        let states = last.get().states;
        let uncounted = ReachedCounts {
            states: Some(states),
            transitions: Some(states),
            excluded: Some(0),
        };
        let counts = self.sufficed(model.counts(&reached), &mut reached.limit)?;
        let counts = counts.unwrap_or(uncounted);
        let ends = if self.properties.needs_graph() && reached.limit.is_none() {
            self.sufficed(model.ends(&reached), &mut reached.limit)?
        } else {
            None
        };
        // what is said of all states is said only if all were found and counted
        let properties = SymbolicJudge::new(self, model, &reached, again).verdicts()?;
        Ok(Found {
            properties,
            states: counts.states.unwrap_or(u64::MAX),
            transitions: counts.transitions.unwrap_or(u64::MAX),
            excluded: counts.excluded.unwrap_or(0),
            ends: ends.map_or(0, |count| count.unwrap_or(u64::MAX)),
            depth: (reached.rings.len() as u32).saturating_sub(1),
            memory: model.memory(),
            incomplete: reached.limit.map(Incomplete::from),
            has_initial: true,
        })
    }

    /// Returns a result, or notes the limit if the memory or the time was not sufficient for it.
    fn sufficed<T>(
        &self,
        result: Result<T, SymbolicError>,
        limit: &mut Option<SearchLimit>,
    ) -> Result<Option<T>, Report> {
        let reason = match result {
            Ok(result) => return Ok(Some(result)),
            Err(SymbolicError::Memory) => SearchLimit::Memory,
            Err(SymbolicError::Stopped) => SearchLimit::Stopped,
            Err(error) => return Err(self.explain(error)),
        };
        limit.get_or_insert(reason);
        Ok(None)
    }

    /// The result if nothing is known but the initial state.
    fn nothing(&self, reason: Incomplete) -> Found {
        Found {
            properties: judge::unknown(self),
            states: 1,
            transitions: 1,
            excluded: 0,
            ends: 0,
            depth: 0,
            memory: 0,
            incomplete: Some(reason),
            has_initial: true,
        }
    }

    fn system(&self) -> SingleMachine<'_> {
        SingleMachine {
            machine: self.machine.clone(),
            ranges: self.ranges,
        }
    }

    /// Describes the reason for which a specification has no representation.
    fn explain(&self, error: SymbolicError) -> Report {
        let Some(known) = self.known.first() else {
            return Report::new();
        };
        let specification = &known.specification;
        let (origin, construct) = match error {
            SymbolicError::Unsupported { origin, construct } => (origin, construct),
            SymbolicError::Input { origin, function } => {
                let names = &self.machine.program().symbols.functions;
                let name = names.get(function.0 as usize);
                let name = name.map_or_else(String::new, ToString::to_string);
                let finding = InputWithoutRange {
                    location: name.clone(),
                    function: name,
                    at: specification.span(origin),
                    needed: None,
                };
                return report_of(finding.diagnostic());
            }
            SymbolicError::Memory => {
                let construct = "a specification that needs more memory than `--memory`";
                (Default::default(), construct.to_owned())
            }
            SymbolicError::Stopped => (Default::default(), "the rest".to_owned()),
        };
        let at = if origin == Default::default() {
            main_rule(specification)
        } else {
            specification.span(origin)
        };
        report_of(NotSymbolic { construct, at }.diagnostic())
    }
}

/// The refusal of a verification that needs something that diagrams do not represent.
pub(crate) fn refuse(specification: &Specification, construct: &str) -> Report {
    let finding = NotSymbolic {
        construct: construct.to_owned(),
        at: main_rule(specification),
    };
    report_of(finding.diagnostic())
}

impl From<SearchLimit> for Incomplete {
    fn from(limit: SearchLimit) -> Self {
        match limit {
            SearchLimit::States => Self::States,
            SearchLimit::Depth => Self::Depth,
            SearchLimit::Memory => Self::Memory,
            SearchLimit::Stopped => Self::Stopped,
        }
    }
}
