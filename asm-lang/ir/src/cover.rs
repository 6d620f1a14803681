//! Coverage: programs that count which of their parts are executed.
//!
//! A program normally has no counters, which keeps its steps fast. [`Program::covered`] inserts
//! them around rules, branches, updates and the bodies of `forall`.

use crate::code::{Rule, RuleNode};
use crate::program::{Origin, Program};
use std::collections::BTreeMap;

/// A part of a program with a coverage counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Counted {
    /// Place of the construct in the sources.
    pub origin: Origin,
    /// The part of the construct.
    pub part: CoveragePoint,
}

/// The kinds of program parts that coverage counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CoveragePoint {
    /// A declared rule; its origin is its name.
    Rule,
    /// An update.
    Update,
    /// `then`
    Then,
    /// `else`, written or implicit.
    Else,
    /// The case with this index, from 0.
    Case(u32),
    /// `otherwise`, written or implicit.
    Otherwise,
    /// A `choose` with at least one candidate.
    Found,
    /// A `choose` without candidates.
    NotFound,
    /// One iteration of a `forall`.
    Round,
    /// A `forall` without iterations.
    None,
    /// A `forall` with exactly one iteration.
    One,
    /// A `forall` with several iterations.
    Many,
}

/// The counters that a rule increments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counter {
    /// Increments the counter with this index.
    Count(u32),
    /// Increments one of three counters, depending on how often the counter of iterations was
    /// incremented while the rule ran.
    Rounds {
        /// Index of the counter of iterations.
        round: u32,
        /// Index of the counter for no iteration; those for one and for several follow it.
        none: u32,
    },
}

impl Program {
    /// Inserts counters. They are listed in the program's `counted`, where a counter's index is its
    /// position.
    #[must_use]
    pub fn covered(mut self) -> Self {
        let mut routines = std::mem::take(&mut self.routines);
        let mut covering = Covering {
            counted: Vec::new(),
            known: BTreeMap::new(),
        };
        for routine in &mut routines {
            covering.rule(&mut routine.code);
            covering.count(&mut routine.code, routine.origin, CoveragePoint::Rule);
        }
        self.routines = routines;
        self.counted = covering.counted;
        self
    }
}

struct Covering {
    counted: Vec<Counted>,
    /// Index of each known counter. A macro may be lowered to several routines, which share their
    /// counters.
    known: BTreeMap<Counted, u32>,
}

impl Covering {
    fn counter(&mut self, origin: Origin, part: CoveragePoint) -> u32 {
        let counted = Counted { origin, part };
        let all = &mut self.counted;
        *self.known.entry(counted).or_insert_with(|| {
            all.push(counted);
            all.len() as u32 - 1
        })
    }

    /// Puts a counter around a rule.
    fn count(&mut self, rule: &mut Rule, origin: Origin, part: CoveragePoint) {
        let counter = Counter::Count(self.counter(origin, part));
        wrap(rule, counter);
    }

    fn rule(&mut self, rule: &mut Rule) {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
            for inner in rule.node.rules_mut() {
                self.rule(inner);
            }
            self.parts(rule);
        });
    }

    fn parts(&mut self, rule: &mut Rule) {
        let origin = rule.origin;
        match &mut *rule.node {
            RuleNode::Update(..) | RuleNode::Assign(Some(_), ..) => {
                self.count(rule, origin, CoveragePoint::Update);
            }
            RuleNode::If(_, then, otherwise) => {
                self.count(then, origin, CoveragePoint::Then);
                self.count(otherwise, origin, CoveragePoint::Else);
            }
            RuleNode::Switch(_, cases, otherwise) => {
                for (index, (_, case)) in cases.iter_mut().enumerate() {
                    self.count(case, origin, CoveragePoint::Case(index as u32));
                }
                self.count(otherwise, origin, CoveragePoint::Otherwise);
            }
            RuleNode::Choose(_, _, body, ifnone) => {
                self.count(body, origin, CoveragePoint::Found);
                self.count(ifnone, origin, CoveragePoint::NotFound);
            }
            RuleNode::Draw(_, body) => self.count(body, origin, CoveragePoint::Found),
            RuleNode::Forall(_, _, body) => {
                self.count(body, origin, CoveragePoint::Round);
                let round = self.counter(origin, CoveragePoint::Round);
                let none = self.counter(origin, CoveragePoint::None);
                self.counter(origin, CoveragePoint::One);
                self.counter(origin, CoveragePoint::Many);
                wrap(rule, Counter::Rounds { round, none });
            }
            RuleNode::Skip
            | RuleNode::Assign(None, ..)
            | RuleNode::Call(..)
            | RuleNode::Act(..)
            | RuleNode::Run(..)
            | RuleNode::RunAgent(..)
            | RuleNode::Par(_)
            | RuleNode::Seq(_)
            | RuleNode::Let(..)
            | RuleNode::Extend(..)
            | RuleNode::While { .. }
            | RuleNode::Local { .. }
            | RuleNode::Watched(_)
            | RuleNode::Counted(..) => {}
        }
    }
}

fn wrap(rule: &mut Rule, counter: Counter) {
    let origin = rule.origin;
    let inner = Rule {
        node: std::mem::replace(&mut rule.node, Box::new(RuleNode::Skip)),
        origin,
    };
    *rule.node = RuleNode::Counted(counter, inner);
}
