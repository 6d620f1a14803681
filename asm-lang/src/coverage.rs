//! Coverage: the rules, branches, updates and iterations of a specification that were executed.

use crate::specification::Specification;
use asmotion_diagnostics::Span;
use asmotion_hir::{RuleKind, RuleTerm};
use asmotion_ir::CoveragePoint;
use asmotion_machine::Machine;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Coverage by file, accumulated over several runs.
#[derive(Clone, Debug, Default)]
pub struct Coverage {
    /// The files of the specification by path, without libraries.
    pub files: BTreeMap<String, FileCoverage>,
}

/// Coverage of a file.
#[derive(Clone, Debug)]
pub struct FileCoverage {
    /// Text of the file.
    pub text: Arc<str>,
    /// Its rules, by the byte offset of their names.
    pub rules: BTreeMap<u32, RuleCoverage>,
}

/// Coverage of a rule.
#[derive(Clone, Debug)]
pub struct RuleCoverage {
    /// Declared name, with its prefix `r_`.
    pub name: String,
    /// Line of its declaration, from 1.
    pub line: usize,
    /// Number of calls.
    pub calls: u64,
    /// Its parts, by byte offset and kind.
    pub parts: BTreeMap<(u32, CoveragePoint), PointCoverage>,
}

/// Coverage of a part of a rule.
#[derive(Clone, Copy, Debug)]
pub struct PointCoverage {
    /// Line of its first character, from 1.
    pub line: usize,
    /// Number of executions.
    pub count: u64,
}

impl Specification {
    /// Returns the number of calls of the rules with this name, in a machine with coverage
    /// counters.
    pub fn calls(&self, rule: &str, machine: &Machine) -> u64 {
        let named = |place: Span| {
            let mut rules = self.model.rules.iter();
            rules.any(|known| known.span == place && &*known.name == rule)
        };
        let counted = self.program.counted.iter().zip(machine.counts());
        let calls = counted.filter(|(counted, _)| {
            counted.part == CoveragePoint::Rule && named(self.span(counted.origin))
        });
        calls.map(|(_, count)| count).sum()
    }
}

impl Coverage {
    /// Returns the coverage of a specification lowered with counters; `counts` are those of a
    /// machine.
    pub fn of(specification: &Specification, counts: &[u64]) -> Self {
        let counted = specification.program.counted.iter().zip(counts);
        let mut ran: BTreeMap<(Span, CoveragePoint), u64> = BTreeMap::new();
        for (counted, count) in counted {
            *ran.entry((specification.span(counted.origin), counted.part))
                .or_default() += count;
        }
        let mut coverage = Self::default();
        for rule in specification
            .model
            .rules
            .iter()
            .filter(|rule| !rule.library)
        {
            coverage.rule(rule, &ran, specification);
        }
        coverage
    }

    fn rule(
        &mut self,
        rule: &asmotion_hir::Rule,
        ran: &BTreeMap<(Span, CoveragePoint), u64>,
        specification: &Specification,
    ) {
        let sources = &specification.sources;
        let line = |span: Span| sources.position(span.file, span.start).0;
        let count = |span, part| ran.get(&(span, part)).copied().unwrap_or(0);
        let mut parts = BTreeMap::new();
        if let Some(body) = &rule.body {
            asmotion_ir::visit_rules(&body.root, &mut |rule| {
                for part in parts_of(rule) {
                    let (line, count) = (line(rule.span), count(rule.span, part));
                    parts.insert((rule.span.start, part), PointCoverage { line, count });
                }
            });
        }
        let covered = RuleCoverage {
            name: rule.name.to_string(),
            line: line(rule.span),
            calls: count(rule.span, CoveragePoint::Rule),
            parts,
        };
        let path = sources.path(rule.span.file).to_owned();
        let file = self.files.entry(path).or_insert_with(|| FileCoverage {
            text: sources.shared_text(rule.span.file),
            rules: BTreeMap::new(),
        });
        file.rules.insert(rule.span.start, covered);
    }

    /// Adds the coverage of another run.
    pub fn add(&mut self, other: Self) {
        for (path, file) in other.files {
            let Some(known) = self.files.get_mut(&path) else {
                self.files.insert(path, file);
                continue;
            };
            for (place, rule) in file.rules {
                match known.rules.get_mut(&place) {
                    Some(known) => known.add(&rule),
                    None => {
                        known.rules.insert(place, rule);
                    }
                }
            }
        }
    }
}

impl RuleCoverage {
    fn add(&mut self, other: &Self) {
        self.calls += other.calls;
        for (place, part) in &other.parts {
            if let Some(known) = self.parts.get_mut(place) {
                known.count += part.count;
            }
        }
    }

    /// Returns the number of executed branches and of all branches of `if`, `switch` and `choose`.
    pub fn branches(&self) -> (usize, usize) {
        self.counts_of(|part| {
            matches!(
                part,
                CoveragePoint::Then
                    | CoveragePoint::Else
                    | CoveragePoint::Case(_)
                    | CoveragePoint::Otherwise
                    | CoveragePoint::Found
                    | CoveragePoint::NotFound
            )
        })
    }

    /// Returns the number of executed updates and of all updates.
    pub fn updates(&self) -> (usize, usize) {
        self.counts_of(|part| part == CoveragePoint::Update)
    }

    /// Returns the number of `forall` rules observed with no iteration, with one and with several,
    /// followed by the number of all `forall` rules.
    pub fn rounds(&self) -> ([usize; 3], usize) {
        let of = |point| self.counts_of(|part| part == point);
        let (none, all) = of(CoveragePoint::None);
        (
            [none, of(CoveragePoint::One).0, of(CoveragePoint::Many).0],
            all,
        )
    }

    fn counts_of(&self, predicate: impl Fn(CoveragePoint) -> bool) -> (usize, usize) {
        let parts = self.parts.iter().filter(|((_, part), _)| predicate(*part));
        let (mut ran, mut all) = (0, 0);
        for (_, part) in parts {
            all += 1;
            ran += usize::from(part.count > 0);
        }
        (ran, all)
    }
}

/// Returns the coverage points of a rule, without those of the rules in it.
fn parts_of(rule: &RuleTerm) -> Vec<CoveragePoint> {
    match &*rule.kind {
        RuleKind::Update(..) | RuleKind::Assign(..) => vec![CoveragePoint::Update],
        RuleKind::If(..) => vec![CoveragePoint::Then, CoveragePoint::Else],
        RuleKind::Switch(_, cases, _) => {
            let cases = (0..cases.len() as u32).map(CoveragePoint::Case);
            cases.chain([CoveragePoint::Otherwise]).collect()
        }
        RuleKind::Choose(..) => vec![CoveragePoint::Found, CoveragePoint::NotFound],
        RuleKind::Forall(..) => vec![
            CoveragePoint::Round,
            CoveragePoint::None,
            CoveragePoint::One,
            CoveragePoint::Many,
        ],
        RuleKind::Skip
        | RuleKind::Call(..)
        | RuleKind::Run(..)
        | RuleKind::Par(_)
        | RuleKind::Seq(_)
        | RuleKind::Let(..)
        | RuleKind::Extend(..)
        | RuleKind::While(..)
        | RuleKind::WhileRec(..)
        | RuleKind::Iterate(_)
        | RuleKind::Local(_)
        | RuleKind::Invalid => Vec::new(),
    }
}
