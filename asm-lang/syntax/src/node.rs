//! Builds the nodes of the tree: spans, depths, and what the grammar cannot say.

mod file;

pub(crate) use file::Item;

use crate::MAX_DEPTH;
use crate::ast::*;
use crate::error::{Place, SyntaxError};
use crate::explain::{Explainer, Failure};
use crate::findings::Findings;
use crate::lexer::{self, Token};
use crate::spelling::nearest;
use lalrpop_util::ErrorRecovery;
use source::Span;
use std::cell::RefCell;
use std::convert::Infallible;
use std::sync::Arc;

/// What the parser hands over where it caught an error.
pub(crate) type Caught<'input> = ErrorRecovery<usize, Token<'input>, Infallible>;

/// A location, a variable, or a function applied.
pub(crate) enum Located {
    /// `$v`.
    Variable(Name),
    /// `a.f(t…)`.
    Location { agent: Option<Name>, function: Name, arguments: Vec<Term>, span: Span },
}

impl Located {
    /// As the left side of an update.
    pub(crate) fn assignee(self) -> Assignee {
        match self {
            Self::Variable(name) => Assignee::Variable(name),
            Self::Location { agent, function, arguments, span } => {
                Assignee::Location { agent, function, arguments, span }
            }
        }
    }
}

/// What stands between the brackets of a set, a sequence or a bag.
pub(crate) enum Elements {
    /// `a, b`.
    Listed(Vec<Term>),
    /// `a : b`.
    Interval(Interval),
    /// `$x in D : t`.
    Comprehension(Comprehension),
}

/// The constructors the grammar calls.
pub(crate) struct Nodes<'input, 'run> {
    text: &'input str,
    findings: &'run Findings,
    explainer: RefCell<Explainer<'input, 'run>>,
}

impl<'input, 'run> Nodes<'input, 'run> {
    /// For one run of the parser.
    pub(crate) fn new(
        text: &'input str,
        findings: &'run Findings,
        explainer: Explainer<'input, 'run>,
    ) -> Self {
        Self { text, findings, explainer: RefCell::new(explainer) }
    }

    // ── declarations ──

    /// `main` in front of a rule.
    pub(crate) fn main(&self, start: usize, rule: RuleDeclaration) -> Item {
        let span = self.span(start, start).to(rule.span);
        Item::Main(RuleDeclaration { span, ..rule })
    }

    /// A structured domain standing alone is named by its text.
    pub(crate) fn structured_domain(&self, of: Type) -> Domain {
        let text = self.text.get(of.span.range()).unwrap_or("");
        let name = Name { text: text.into(), span: of.span };
        Domain { name, span: of.span, kind: DomainKind::Structured(of), dynamic: false }
    }

    /// A structured domain.
    pub(crate) fn type_(&self, start: usize, kind: TypeKind, end: usize) -> Type {
        Type { kind, span: self.span(start, end) }
    }

    /// A function; the codomain comes first in `mapping` where it stands alone.
    pub(crate) fn function(
        &self,
        start: usize,
        kind: FunctionKind,
        name: Name,
        mapping: (Type, Option<Type>),
        end: usize,
    ) -> Function {
        let (domain, codomain) = match mapping {
            (codomain, None) => (None, codomain),
            (domain, Some(codomain)) => (Some(domain), codomain),
        };
        Function { name, kind, domain, codomain, span: self.span(start, end) }
    }

    /// `rule foo`: the prefix `r_` is missing.
    pub(crate) fn rule_name_without_prefix(&self, name: Name) -> Name {
        let better = format!("r_{}", name.text);
        self.findings.report(SyntaxError::Misnamed {
            what: "a rule",
            beginning: "`r_`",
            found: (name.text.to_string(), name.span),
            better: Some(better.clone()),
        });
        Name { text: better.into(), span: name.span }
    }

    /// A name after `invariant`, `CTLSPEC` or `LTLSPEC`; AsmetaS wants each to begin its way.
    pub(crate) fn property_name(&self, prefix: &'static str, name: Option<Name>) -> Option<Name> {
        if let Some(name) = name.as_ref().filter(|name| !name.text.starts_with(prefix)) {
            self.findings.report(SyntaxError::PropertyPrefix {
                prefix,
                name: name.text.to_string(),
                at: name.span,
            });
        }
        name
    }

    // ── rules ──

    /// A rule, or `Invalid` where it nests too deep.
    pub(crate) fn rule(&self, start: usize, kind: RuleKind, end: usize) -> Rule {
        let span = self.span(start, end);
        let depth = 1 + rule_depth(&kind);
        if depth > MAX_DEPTH {
            self.findings.report(SyntaxError::TooDeep { at: span });
            return Rule { kind: Box::new(RuleKind::Invalid), span, depth: 1 };
        }
        Rule { kind: Box::new(kind), span, depth }
    }

    /// `choose … do … ifnone …`.
    pub(crate) fn choose(
        &self,
        start: usize,
        (binders, guard): (Vec<Binder>, Option<Term>),
        body: Rule,
        ifnone: Option<Rule>,
        end: usize,
    ) -> Rule {
        self.rule(start, RuleKind::Choose { binders, guard, body, ifnone }, end)
    }

    /// `local f: D [R] S`; several in a row are one rule.
    pub(crate) fn local(
        &self,
        start: usize,
        function: Function,
        init: Rule,
        body: Rule,
        end: usize,
    ) -> Rule {
        let mut functions = vec![(function, init)];
        let body = match *body.kind {
            RuleKind::Local { functions: more, body } => {
                functions.extend(more);
                body
            }
            kind => Rule { kind: Box::new(kind), ..body },
        };
        self.rule(start, RuleKind::Local { functions, body }, end)
    }

    /// A term standing as a rule.
    pub(crate) fn term_as_rule(
        &self,
        start: usize,
        located: Located,
        arguments: Option<Vec<Term>>,
        end: usize,
    ) -> Rule {
        let term = self.located(located);
        let arguments = arguments.unwrap_or_default();
        self.rule(start, RuleKind::Term { term, arguments }, end)
    }

    /// `par … endpar`.
    pub(crate) fn par(&self, start: usize, rules: Vec<Rule>, end: usize) -> Rule {
        self.count_rules("par", &rules, start);
        self.rule(start, RuleKind::Par(rules), end)
    }

    /// `seq … endseq`.
    pub(crate) fn seq(&self, start: usize, rules: Vec<Rule>, end: usize) -> Rule {
        self.count_rules("seq", &rules, start);
        self.rule(start, RuleKind::Seq(rules), end)
    }

    fn count_rules(&self, block: &'static str, rules: &[Rule], start: usize) {
        let count = match rules {
            [] => "no rule",
            [only] if !matches!(*only.kind, RuleKind::Invalid) => "one rule",
            _ => return,
        };
        let at = self.span(start, start + block.len());
        self.findings.report(SyntaxError::FewRules { block, count, at });
    }

    /// One rule, or by mistake several.
    pub(crate) fn block(&self, start: usize, mut rules: Vec<Rule>, end: usize) -> Rule {
        if let [first, second, ..] = rules.as_slice() {
            if let Some((found, meant)) = rules.iter().find_map(misspelled_end) {
                self.findings.report(SyntaxError::UnknownWord { found, meant });
                return self.rule(start, RuleKind::Par(rules), end);
            }
            let all = self.span(start, end);
            let text = self.text.get(all.range()).unwrap_or("").to_owned();
            let (first, second) = (first.span, second.span);
            self.findings.report(SyntaxError::SeveralRules { first, second, all: Some((all, text)) });
            return self.rule(start, RuleKind::Par(rules), end);
        }
        rules.pop().unwrap_or_else(|| self.rule(start, RuleKind::Invalid, end))
    }

    // ── terms ──

    /// A term, or `Invalid` where it nests too deep.
    pub(crate) fn term(&self, start: usize, kind: TermKind, end: usize) -> Term {
        self.spanned_term(kind, self.span(start, end))
    }

    fn spanned_term(&self, kind: TermKind, span: Span) -> Term {
        let depth = 1 + term_depth(&kind);
        if depth > MAX_DEPTH {
            self.findings.report(SyntaxError::TooDeep { at: span });
            return Term { kind: Box::new(TermKind::Invalid), span, depth: 1 };
        }
        Term { kind: Box::new(kind), span, depth }
    }

    /// `left op right`.
    pub(crate) fn binary(&self, left: Term, (operator, at): (Operator, Span), right: Term) -> Term {
        let span = left.span.to(right.span);
        self.spanned_term(TermKind::Binary { operator, at, left, right }, span)
    }

    /// `op operand`.
    pub(crate) fn unary(&self, (operator, at): (Operator, Span), operand: Term) -> Term {
        let span = at.to(operand.span);
        self.spanned_term(TermKind::Unary { operator, at, operand }, span)
    }

    /// A location or a variable as a term.
    pub(crate) fn located(&self, located: Located) -> Term {
        match located {
            Located::Variable(name) => {
                let span = name.span;
                self.spanned_term(TermKind::Variable(name), span)
            }
            Located::Location { agent: None, function, arguments, span } => {
                self.spanned_term(TermKind::Apply { name: function, arguments }, span)
            }
            Located::Location { agent: Some(agent), function, arguments, span } => {
                self.spanned_term(TermKind::Dot { agent, name: function, arguments }, span)
            }
        }
    }

    /// `(t)` is `t`, `(t, u)` a tuple.
    pub(crate) fn tuple(&self, start: usize, mut items: Vec<Term>, end: usize) -> Term {
        match items.pop() {
            Some(only) if items.is_empty() => Term { span: self.span(start, end), ..only },
            last => {
                items.extend(last);
                self.term(start, TermKind::Tuple(items), end)
            }
        }
    }

    /// A set, a sequence or a bag.
    pub(crate) fn collection(
        &self,
        start: usize,
        collection: Collection,
        elements: Elements,
        end: usize,
    ) -> Term {
        let kind = match elements {
            Elements::Listed(items) => TermKind::Listed { collection, items },
            Elements::Interval(interval) => TermKind::Interval { collection, interval },
            Elements::Comprehension(comprehension) => {
                TermKind::Comprehension { collection, comprehension }
            }
        };
        self.term(start, kind, end)
    }

    /// A constant.
    pub(crate) fn literal(&self, start: usize, literal: Literal, end: usize) -> Term {
        self.term(start, TermKind::Literal(literal), end)
    }

    /// `exist`, as AsmetaL before 26.06 wrote it.
    pub(crate) fn old_exists(&self, start: usize, end: usize) {
        self.findings.report(SyntaxError::OldExists { at: self.span(start, end) });
    }

    /// `..`, as old AsmetaL wrote intervals.
    pub(crate) fn old_interval(&self, start: usize, end: usize) {
        self.findings.report(SyntaxError::OldInterval { at: self.span(start, end) });
    }

    /// Digits as a number; `None` beyond 64 bits.
    pub(crate) fn integer(&self, start: usize, digits: &str, end: usize) -> Option<i64> {
        let number = digits.parse().ok();
        if number.is_none() {
            self.findings.report(SyntaxError::TooLarge {
                digits: digits.to_owned(),
                at: self.span(start, end),
            });
        }
        number
    }

    /// Digits, a point and digits as a number.
    pub(crate) fn real(&self, digits: &str) -> Literal {
        Literal::Real(digits.parse().unwrap_or(f64::NAN))
    }

    /// Both parts of a complex number.
    pub(crate) fn complex(&self, text: &str) -> Literal {
        let (real, imaginary) = lexer::complex_parts(text);
        Literal::Complex(real, imaginary)
    }

    /// The one character between the quotes.
    pub(crate) fn char(&self, start: usize, text: &str, end: usize) -> char {
        lexer::unescaped(text).unwrap_or_else(|| {
            self.findings.report(SyntaxError::CharLength {
                text: text.to_owned(),
                at: self.span(start, end),
            });
            char::REPLACEMENT_CHARACTER
        })
    }

    // ── names and places ──

    /// A name.
    pub(crate) fn name(&self, start: usize, text: &str, end: usize) -> Name {
        Name { text: Arc::from(text), span: self.span(start, end) }
    }

    /// A place.
    pub(crate) fn span(&self, start: usize, end: usize) -> Span {
        self.findings.node_built();
        self.findings.span(start, end)
    }

    // ── errors caught by the grammar ──

    /// An item that could not be read.
    pub(crate) fn broken_item(&self, start: usize, caught: Caught<'input>, end: usize) -> Item {
        self.explain(&caught.error, start, end);
        Item::Broken
    }

    /// A rule that could not be read.
    pub(crate) fn broken_rule(&self, start: usize, caught: Caught<'input>, end: usize) -> Rule {
        self.explain(&caught.error, start, end);
        self.rule(start, RuleKind::Invalid, end)
    }

    /// A term that could not be read.
    pub(crate) fn broken_term(&self, start: usize, caught: Caught<'input>, end: usize) -> Term {
        self.explain(&caught.error, start, end);
        self.term(start, TermKind::Invalid, end)
    }

    /// The file the parser gave up.
    pub(crate) fn unread(&self, failure: &Failure<'_>) -> File {
        self.explain(failure, 0, self.text.len());
        file::empty()
    }

    /// Reports an error; what the parser gave up for it reaches from `start` to `end`.
    pub(crate) fn explain(&self, failure: &Failure<'_>, start: usize, end: usize) {
        self.explainer.borrow_mut().explain(failure, start, end);
    }
}

/// A term standing as a rule that is nearly a word of `if`, and that word.
fn misspelled_end(rule: &Rule) -> Option<(Place, String)> {
    let RuleKind::Term { term, .. } = &*rule.kind else { return None };
    let TermKind::Apply { name, .. } = &*term.kind else { return None };
    let meant = nearest(&name.text, ["else", "endif", "otherwise", "endswitch", "endlet"])?;
    Some(((name.text.to_string(), name.span), meant.to_owned()))
}

// ── depths ──

/// The depth of the deepest part.
fn rule_depth(kind: &RuleKind) -> u32 {
    match kind {
        RuleKind::Skip | RuleKind::Invalid => 0,
        RuleKind::Update { target, value } => target_depth(target).max(value.depth),
        RuleKind::Assign { target, arguments, .. } => target_depth(target).max(deepest(arguments)),
        RuleKind::Macro { arguments, .. } | RuleKind::Turbo { arguments, .. } => deepest(arguments),
        RuleKind::Term { term, arguments } => term.depth.max(deepest(arguments)),
        RuleKind::Par(rules) | RuleKind::Seq(rules) => {
            rules.iter().map(|rule| rule.depth).max().unwrap_or(0)
        }
        RuleKind::If { guard, then, otherwise } => {
            guard.depth.max(then.depth).max(optional_rule(otherwise))
        }
        RuleKind::Switch(SwitchRule { subject, cases, otherwise }) => cases
            .iter()
            .map(|(case, body)| case.depth.max(body.depth))
            .fold(subject.depth.max(optional_rule(otherwise)), u32::max),
        RuleKind::Choose { binders, guard, body, ifnone } => {
            ranges(binders).max(optional(guard)).max(body.depth).max(optional_rule(ifnone))
        }
        RuleKind::Forall { binders, guard, body } => {
            ranges(binders).max(optional(guard)).max(body.depth)
        }
        RuleKind::Let { bindings, body } => bound(bindings).max(body.depth),
        RuleKind::Extend { body, .. } | RuleKind::Iterate(body) => body.depth,
        RuleKind::While { guard, body } | RuleKind::WhileRec { guard, body } => {
            guard.depth.max(body.depth)
        }
        RuleKind::Local { functions, body } => {
            functions.iter().map(|(_, init)| init.depth).fold(body.depth, u32::max)
        }
    }
}

fn target_depth(target: &Assignee) -> u32 {
    match target {
        Assignee::Location { arguments, .. } => deepest(arguments),
        Assignee::Variable(_) => 0,
    }
}

/// The depth of the deepest part.
fn term_depth(kind: &TermKind) -> u32 {
    match kind {
        TermKind::Literal(_)
        | TermKind::Variable(_)
        | TermKind::Constant(_)
        | TermKind::RuleRef { .. }
        | TermKind::Domain(_)
        | TermKind::Invalid => 0,
        TermKind::Apply { arguments, .. } | TermKind::Dot { arguments, .. } => deepest(arguments),
        TermKind::Binary { left, right, .. } => left.depth.max(right.depth),
        TermKind::Unary { operand, .. } => operand.depth,
        TermKind::Tuple(items) | TermKind::Listed { items, .. } => deepest(items),
        TermKind::If { guard, then, otherwise } => {
            guard.depth.max(then.depth).max(optional(otherwise))
        }
        TermKind::Switch { subject, cases, otherwise } => {
            pairs(cases).max(subject.depth).max(optional(otherwise))
        }
        TermKind::Let { bindings, body } => bound(bindings).max(body.depth),
        TermKind::Quantified { binders, guard, .. } => ranges(binders).max(optional(guard)),
        TermKind::Interval { interval: Interval { from, to, step }, .. } => {
            from.depth.max(to.depth).max(optional(step))
        }
        TermKind::Comprehension { comprehension, .. } => collected(comprehension),
        TermKind::Map(entries) => pairs(entries),
        TermKind::MapComprehension { comprehension, value } => {
            collected(comprehension).max(value.depth)
        }
    }
}

fn deepest(terms: &[Term]) -> u32 {
    terms.iter().map(|term| term.depth).max().unwrap_or(0)
}

fn pairs(pairs: &[(Term, Term)]) -> u32 {
    pairs.iter().map(|(left, right)| left.depth.max(right.depth)).max().unwrap_or(0)
}

fn bound(bindings: &[(Name, Term)]) -> u32 {
    bindings.iter().map(|(_, value)| value.depth).max().unwrap_or(0)
}

fn ranges(binders: &[Binder]) -> u32 {
    binders.iter().map(|binder| binder.range.depth).max().unwrap_or(0)
}

fn collected(Comprehension { binders, guard, item }: &Comprehension) -> u32 {
    ranges(binders).max(optional(guard)).max(item.depth)
}

fn optional(term: &Option<Term>) -> u32 {
    term.as_ref().map_or(0, |term| term.depth)
}

fn optional_rule(rule: &Option<Rule>) -> u32 {
    rule.as_ref().map_or(0, |rule| rule.depth)
}
