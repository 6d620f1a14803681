//! Builds the nodes of terms.

use super::Nodes;
use crate::ast::*;
use crate::codes::l005::CharLength;
use crate::codes::l006::IntegerTooLarge;
use crate::codes::l039::NestedTooDeep;
use crate::codes::l070::OldExists;
use crate::codes::l071::OldInterval;
use crate::lexer;
use asmotion_diagnostics::Span;

/// The text between the brackets of a collection.
pub(crate) enum Elements {
    /// Listed elements: `a, b`.
    Listed(Vec<Term>),
    /// Bounds: `a : b`.
    Interval(Interval),
    /// Comprehension: `$x in D : t`.
    Comprehension(Comprehension),
}

impl Elements {
    /// Builds the collection.
    pub(crate) fn kind(self, collection: Collection) -> TermKind {
        match self {
            Self::Listed(items) => TermKind::Listed { collection, items },
            Self::Interval(interval) => TermKind::Interval {
                collection,
                interval,
            },
            Self::Comprehension(comprehension) => TermKind::Comprehension {
                collection,
                comprehension,
            },
        }
    }
}

/// Converts the left-hand side of an update to a term.
pub(crate) fn applied(located: Assignee) -> TermKind {
    match located {
        Assignee::Variable(name) => TermKind::Variable(name),
        Assignee::Location {
            agent: None,
            function: name,
            arguments,
            ..
        } => TermKind::Apply { name, arguments },
        Assignee::Location {
            agent: Some(agent),
            function: name,
            arguments,
            ..
        } => TermKind::Dot {
            agent,
            name,
            arguments,
        },
    }
}

impl Nodes<'_, '_> {
    /// Builds a term, or `Invalid` if it is nested too deeply.
    pub(crate) fn term(&self, start: usize, kind: TermKind, end: usize) -> Term {
        self.spanned_term(kind, self.span(start, end))
    }

    pub(super) fn spanned_term(&self, kind: TermKind, span: Span) -> Term {
        let depth = 1 + term_depth(&kind);
        self.bounded(Term {
            kind: Box::new(kind),
            span,
            depth,
        })
    }

    fn bounded(&self, term: Term) -> Term {
        if term.depth <= MAX_DEPTH {
            return term;
        }
        self.findings.report(NestedTooDeep { at: term.span });
        Term {
            kind: Box::new(TermKind::Invalid),
            depth: 1,
            ..term
        }
    }

    /// Builds `left op right`; extends a chain on the left if the operators have equal precedence.
    pub(crate) fn binary(
        &self,
        mut left: Term,
        (operator, at): (Operator, Span),
        operand: Term,
    ) -> Term {
        let span = left.span.to(operand.span);
        let link = ChainLink {
            operator,
            at,
            operand,
        };
        if let TermKind::Chain { first, links } = &mut *left.kind
            && goes_on(first, links, left.span, operator)
        {
            left.depth = if links.len() < ChainLink::NESTED as usize {
                1 + left.depth.max(link.operand.depth)
            } else {
                left.depth.max(ChainLink::NESTED + link.operand.depth)
            };
            left.span = span;
            links.push(link);
            return self.bounded(left);
        }
        let links = vec![link];
        self.spanned_term(TermKind::Chain { first: left, links }, span)
    }

    pub(crate) fn unary(&self, (operator, at): (Operator, Span), operand: Term) -> Term {
        let span = at.to(operand.span);
        self.spanned_term(
            TermKind::Unary {
                operator,
                at,
                operand,
            },
            span,
        )
    }

    /// Builds a location: `f`, `f(t…)`, `a.f(t…)`.
    pub(crate) fn location(
        &self,
        start: usize,
        agent: Option<NameText>,
        function: NameText,
        arguments: Option<Vec<Term>>,
        end: usize,
    ) -> Assignee {
        let arguments = arguments.unwrap_or_default();
        Assignee::Location {
            agent,
            function,
            arguments,
            span: self.span(start, end),
        }
    }

    /// Builds a tuple `(t, u)`, or the term itself from `(t)`.
    pub(crate) fn tuple(&self, start: usize, mut items: Vec<Term>, end: usize) -> Term {
        match items.pop() {
            Some(only) if items.is_empty() => Term {
                span: self.span(start, end),
                ..only
            },
            last => {
                items.extend(last);
                self.term(start, TermKind::Tuple(items), end)
            }
        }
    }

    /// Reports `exist`, the keyword before AsmetaL 26.06.
    pub(crate) fn old_exists(&self, start: usize, end: usize) {
        self.findings.report(OldExists {
            at: self.span(start, end),
        });
    }

    /// Reports `..`, the old notation of intervals.
    pub(crate) fn old_interval(&self, start: usize, end: usize) {
        let blanks = |text: Option<&str>, has: fn(&str) -> bool| text.is_some_and(has);
        let apart = blanks(self.text.get(..start), |text| text.ends_with(' '))
            && blanks(self.text.get(end..), |text| text.starts_with(' '));
        self.findings.report(OldInterval {
            at: self.span(start, end),
            new: if apart { ":" } else { " : " },
        });
    }

    /// Parses digits; reports a number that does not fit in 64 bits and returns `None`.
    pub(crate) fn integer(&self, start: usize, digits: &str, end: usize) -> Option<i64> {
        let number = digits.parse().ok();
        if number.is_none() {
            self.findings.report(IntegerTooLarge {
                digits: digits.to_owned(),
                at: self.span(start, end),
            });
        }
        number
    }

    pub(crate) fn real(&self, digits: &str) -> Literal {
        Literal::Real(digits.parse().unwrap_or(f64::NAN))
    }

    /// Parses a complex number.
    pub(crate) fn complex(&self, text: &str) -> Literal {
        let (real, imaginary) = lexer::complex_parts(text);
        Literal::Complex(real, imaginary)
    }

    /// Parses the single character between quotes.
    pub(crate) fn char(&self, start: usize, text: &str, end: usize) -> char {
        lexer::character(text).unwrap_or_else(|| {
            // an unclosed quote was already reported
            if !self.findings.error_between(start, start) {
                let (text, at) = (text.to_owned(), self.span(start, end));
                self.findings.report(CharLength { text, at });
            }
            char::REPLACEMENT_CHARACTER
        })
    }
}

/// Returns `true` if a chain without brackets continues with an operator of the same precedence.
fn goes_on(first: &Term, links: &[ChainLink], span: Span, next: Operator) -> bool {
    links.last().is_some_and(|last| {
        last.operator.strength() == next.strength()
            && (first.span.start, last.operand.span.end) == (span.start, span.end)
    })
}

/// Returns the depth of the deepest part of a term.
fn term_depth(kind: &TermKind) -> u32 {
    match kind {
        TermKind::Literal(_)
        | TermKind::Variable(_)
        | TermKind::Constant(_)
        | TermKind::RuleRef { .. }
        | TermKind::Domain(_)
        | TermKind::Invalid => 0,
        TermKind::Apply { arguments, .. } | TermKind::Dot { arguments, .. } => deepest(arguments),
        TermKind::Chain { first, links } => {
            let operands = links.iter().map(|link| link.operand.depth);
            operands.fold(first.depth, u32::max)
        }
        TermKind::Unary { operand, .. } => operand.depth,
        TermKind::Tuple(items) | TermKind::Listed { items, .. } => deepest(items),
        TermKind::If {
            guard,
            then,
            otherwise,
        } => guard.depth.max(then.depth).max(optional(otherwise)),
        TermKind::Switch {
            subject,
            cases,
            otherwise,
        } => pairs(cases).max(subject.depth).max(optional(otherwise)),
        TermKind::Let { bindings, body } => bound(bindings).max(body.depth),
        TermKind::Quantified { binders, guard, .. } => ranges(binders).max(optional(guard)),
        TermKind::Interval {
            interval: Interval { from, to, step },
            ..
        } => from.depth.max(to.depth).max(optional(step)),
        TermKind::Comprehension { comprehension, .. } => collected(comprehension),
        TermKind::Map(entries) => pairs(entries),
        TermKind::MapComprehension {
            comprehension,
            value,
        } => collected(comprehension).max(value.depth),
    }
}

pub(super) fn deepest(terms: &[Term]) -> u32 {
    terms.iter().map(|term| term.depth).max().unwrap_or(0)
}

fn pairs(pairs: &[(Term, Term)]) -> u32 {
    pairs
        .iter()
        .map(|(left, right)| left.depth.max(right.depth))
        .max()
        .unwrap_or(0)
}

pub(super) fn bound(bindings: &[(NameText, Term)]) -> u32 {
    bindings
        .iter()
        .map(|(_, value)| value.depth)
        .max()
        .unwrap_or(0)
}

pub(super) fn ranges(binders: &[Binder]) -> u32 {
    binders
        .iter()
        .map(|binder| binder.range.depth)
        .max()
        .unwrap_or(0)
}

fn collected(
    Comprehension {
        binders,
        guard,
        item,
    }: &Comprehension,
) -> u32 {
    ranges(binders).max(optional(guard)).max(item.depth)
}

pub(super) fn optional(term: &Option<Term>) -> u32 {
    term.as_ref().map_or(0, |term| term.depth)
}
