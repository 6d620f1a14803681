//! Which rules, branches, updates and rounds of a specification ran.

use crate::Specification;
use asmotion_diagnostics::Span;
use asmotion_hir::{RuleKind, RuleTerm};
use asmotion_ir::Part;
use asmotion_machine::Machine;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What ran, by file; that of several runs adds up.
#[derive(Clone, Debug, Default)]
pub struct Coverage {
    /// The files of the specifications, libraries left out.
    pub files: BTreeMap<String, Covered>,
}

/// What of a file ran.
#[derive(Clone, Debug)]
pub struct Covered {
    /// The text.
    pub text: Arc<str>,
    /// Its rules, by their places.
    pub rules: BTreeMap<u32, CoveredRule>,
}

/// What of a rule ran.
#[derive(Clone, Debug)]
pub struct CoveredRule {
    /// Its name.
    pub name: String,
    /// The line it begins in.
    pub line: usize,
    /// How often it ran.
    pub calls: u64,
    /// What it consists of.
    pub parts: BTreeMap<(u32, Part), CoveredPart>,
}

/// A part of a rule.
#[derive(Clone, Copy, Debug)]
pub struct CoveredPart {
    /// The line it begins in.
    pub line: usize,
    /// How often it ran.
    pub count: u64,
}

impl Specification {
    /// How often the rules of a name were called, by a machine whose program counts.
    pub fn calls(&self, rule: &str, machine: &Machine) -> u64 {
        let named = |place: Span| {
            let mut rules = self.model.rules.iter();
            rules.any(|known| known.span == place && &*known.name == rule)
        };
        let counted = self.program.counted.iter().zip(machine.counts());
        let calls = counted
            .filter(|(counted, _)| counted.part == Part::Rule && named(self.span(counted.origin)));
        calls.map(|(_, count)| count).sum()
    }
}

impl Coverage {
    /// What ran of a specification whose program counts.
    pub fn of(specification: &Specification, counts: &[u64]) -> Self {
        let counted = specification.program.counted.iter().zip(counts);
        let mut ran: BTreeMap<(Span, Part), u64> = BTreeMap::new();
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
        ran: &BTreeMap<(Span, Part), u64>,
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
                    parts.insert((rule.span.start, part), CoveredPart { line, count });
                }
            });
        }
        let covered = CoveredRule {
            name: rule.name.to_string(),
            line: line(rule.span),
            calls: count(rule.span, Part::Rule),
            parts,
        };
        let path = sources.path(rule.span.file).to_owned();
        let file = self.files.entry(path).or_insert_with(|| Covered {
            text: sources.shared_text(rule.span.file),
            rules: BTreeMap::new(),
        });
        file.rules.insert(rule.span.start, covered);
    }

    /// Adds what ran in another run.
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

impl CoveredRule {
    fn add(&mut self, other: &Self) {
        self.calls += other.calls;
        for (place, part) in &other.parts {
            if let Some(known) = self.parts.get_mut(place) {
                known.count += part.count;
            }
        }
    }

    /// How many branches ran, and how many there are: of `if`, `switch` and `choose`.
    pub fn branches(&self) -> (usize, usize) {
        self.ran(|part| {
            matches!(
                part,
                Part::Then
                    | Part::Else
                    | Part::Case(_)
                    | Part::Otherwise
                    | Part::Found
                    | Part::NotFound
            )
        })
    }

    /// How many updates ran, and how many there are.
    pub fn updates(&self) -> (usize, usize) {
        self.ran(|part| part == Part::Update)
    }

    /// Of how many `forall` rules it was seen that they go round not at all, once, several times; and
    /// how many there are.
    pub fn rounds(&self) -> ([usize; 3], usize) {
        let of = |wanted| self.ran(|part| part == wanted);
        let (none, all) = of(Part::None);
        ([none, of(Part::One).0, of(Part::Many).0], all)
    }

    fn ran(&self, wanted: impl Fn(Part) -> bool) -> (usize, usize) {
        let parts = self.parts.iter().filter(|((_, part), _)| wanted(*part));
        let (mut ran, mut all) = (0, 0);
        for (_, part) in parts {
            all += 1;
            ran += usize::from(part.count > 0);
        }
        (ran, all)
    }
}

/// What is counted of a rule itself, rules in it left out.
fn parts_of(rule: &RuleTerm) -> Vec<Part> {
    match &*rule.kind {
        RuleKind::Update(..) | RuleKind::Assign(..) => vec![Part::Update],
        RuleKind::If(..) => vec![Part::Then, Part::Else],
        RuleKind::Switch(_, cases, _) => {
            let cases = (0..cases.len() as u32).map(Part::Case);
            cases.chain([Part::Otherwise]).collect()
        }
        RuleKind::Choose(..) => vec![Part::Found, Part::NotFound],
        RuleKind::Forall(..) => vec![Part::Round, Part::None, Part::One, Part::Many],
        _ => Vec::new(),
    }
}
