//! Coverage: programs that count which of their parts are executed.
//!
//! A program normally has no counters, which keeps its steps fast. [`Program::covered`] inserts
//! them around rules, branches, updates and the bodies of `forall`.

use crate::code::{Rule, RuleNode};
use crate::counter::{Counted, Counter, CoveragePoint};
use crate::id::Origin;
use crate::program::Program;
use std::collections::BTreeMap;

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
