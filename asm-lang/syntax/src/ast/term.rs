//! The syntax of terms.

use super::{NameText, Type};
use asmotion_diagnostics::Span;
use std::sync::Arc;

/// A term with its span.
#[derive(Clone, Debug)]
pub struct Term {
    /// Form of the term, with its subterms.
    pub kind: Box<TermKind>,
    /// Span of the term, including its parentheses.
    pub span: Span,
    /// Nesting depth; 1 without subterms. Limited by the parser to `MAX_DEPTH`.
    pub depth: u32,
}

/// The forms of a term.
#[derive(Clone, Debug)]
pub enum TermKind {
    /// A number, string, character, truth value or `undef`.
    Literal(Literal),
    /// `$x`.
    Variable(NameText),
    /// An upper-case name: an enumeration literal or a domain, distinguished by the analysis.
    Constant(NameText),
    /// A function with arguments: `f`, `f(t1, …)`; also an operator in prefix form, `mod(a, b)`.
    Apply {
        /// Name of the function.
        name: NameText,
        /// Arguments; empty without parentheses.
        arguments: Vec<Term>,
    },
    /// A function of an agent: `a.f(t1, …)`.
    Dot {
        /// The agent: `self` or an agent's name.
        agent: NameText,
        /// Name of the function.
        name: NameText,
        /// Arguments other than the agent.
        arguments: Vec<Term>,
    },
    /// Binary operators of equal precedence, applied from left to right: `a op b op c …`.
    Chain {
        /// Leftmost operand.
        first: Term,
        /// The operators with their right operands; at least one.
        links: Vec<ChainLink>,
    },
    /// A unary operator with its operand: `+`, `-`, `not`.
    Unary {
        /// Operator as written; it stands for a standard function.
        operator: Operator,
        /// Span of the operator.
        at: Span,
        /// Operand to the right of the operator.
        operand: Term,
    },
    /// `(t1, t2, …)` with at least two components; `(t)` is `t` itself.
    Tuple(Vec<Term>),
    /// `if g then t else e endif`.
    If {
        /// Guard, a Boolean term.
        guard: Term,
        /// Value for a true guard.
        then: Term,
        /// Value for a false guard; `None` stands for `undef`.
        otherwise: Option<Term>,
    },
    /// `switch t case c: v … otherwise o endswitch`.
    Switch {
        /// Term that the cases are compared with.
        subject: Term,
        /// Cases with their values, in order.
        cases: Vec<(Term, Term)>,
        /// Value for the case that no case matches; `None` stands for `undef`.
        otherwise: Option<Term>,
    },
    /// `let ($x = t, …) in b endlet`; later bindings may use earlier variables.
    Let {
        /// Variables with their values, in order.
        bindings: Vec<(NameText, Term)>,
        /// Term in which the variables are visible.
        body: Term,
    },
    /// `(forall $x in D with g)`, `(exists …)`, `(exists unique …)`.
    Quantified {
        /// Kind of the quantifier.
        quantifier: Quantifier,
        /// Variables with their ranges.
        binders: Vec<Binder>,
        /// The quantified condition; `None` stands for `true`.
        guard: Option<Term>,
    },
    /// A collection of listed elements: `{t, …}`, `[…]`, `<…>`.
    Listed {
        /// Set, sequence or bag.
        collection: Collection,
        /// Terms for the elements.
        items: Vec<Term>,
    },
    /// A collection given by its bounds: `{a : b, s}`, also in `[ ]` and `< >`.
    Interval {
        /// Set, sequence or bag.
        collection: Collection,
        /// First element, bound and step.
        interval: Interval,
    },
    /// A collection by comprehension: `{$x in D | g : t}`, also in `[ ]` and `< >`.
    Comprehension {
        /// Set, sequence or bag.
        collection: Collection,
        /// Variables, guard and element.
        comprehension: Comprehension,
    },
    /// A map of listed entries: `{k -> v, …}`, `{->}`.
    Map(Vec<(Term, Term)>),
    /// A map by comprehension: `{$x in D | g : k -> v}`.
    MapComprehension {
        /// Variables, guard and key.
        comprehension: Comprehension,
        /// Term for the value.
        value: Term,
    },
    /// A rule as a value: `<<r_x(D1, …)>>`.
    RuleRef {
        /// Name of the rule.
        name: NameText,
        /// Domains of the parameters, which select an overload; empty if not given.
        domains: Vec<Type>,
    },
    /// A structured domain as a term. A name alone is a [`TermKind::Constant`].
    Domain(Type),
    /// A term that could not be parsed; the error was reported.
    Invalid,
}

/// A literal as written in the source.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal {
    /// `undef`.
    Undef,
    /// `true`, `false`.
    Bool(bool),
    /// An integer; `None` if it does not fit in 64 bits (the error was reported).
    Integer(Option<i64>),
    /// A natural, written with the suffix `n`; `None` as for integers.
    Natural(Option<i64>),
    /// A real, written with a decimal point.
    Real(f64),
    /// A complex number: real and imaginary part.
    Complex(f64, f64),
    /// `'c'`.
    Char(char),
    /// A string `"text"`: the characters between the quotes, with escapes as written.
    Text(Arc<str>),
}

/// The operators. Each stands for a function of the standard library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// `+`
    Plus,
    /// `-`
    Minus,
    /// `*`
    Mult,
    /// `/`
    Div,
    /// `mod`
    Mod,
    /// `^`
    Pwr,
    /// `=`
    Eq,
    /// `!=`
    Neq,
    /// `<`
    Lt,
    /// `<=`
    Le,
    /// `>`
    Gt,
    /// `>=`
    Ge,
    /// `not`
    Not,
    /// `and`
    And,
    /// `or`
    Or,
    /// `xor`
    Xor,
    /// `implies`
    Implies,
    /// `iff`
    Iff,
}

/// An operator and its right operand in a chain: `op b`.
#[derive(Clone, Debug)]
pub struct ChainLink {
    /// Operator as written; it stands for a standard function.
    pub operator: Operator,
    /// Span of the operator.
    pub at: Span,
    /// Operand to the right of the operator.
    pub operand: Term,
}

impl ChainLink {
    /// Number of links of a chain that the analysis nests in each other; those before them are
    /// bound by a `let`. The depth of a term is computed accordingly.
    pub const NESTED: u32 = 64;
}

impl Operator {
    /// Returns the name of the standard function that the operator stands for.
    pub fn function(self) -> &'static str {
        match self {
            Self::Plus => "plus",
            Self::Minus => "minus",
            Self::Mult => "mult",
            Self::Div => "div",
            Self::Mod => "mod",
            Self::Pwr => "pwr",
            Self::Eq => "eq",
            Self::Neq => "neq",
            Self::Lt => "lt",
            Self::Le => "le",
            Self::Gt => "gt",
            Self::Ge => "ge",
            Self::Not => "not",
            Self::And => "and",
            Self::Or => "or",
            Self::Xor => "xor",
            Self::Implies => "implies",
            Self::Iff => "iff",
        }
    }

    /// Returns the operator as written in source texts.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Plus => "+",
            Self::Minus => "-",
            Self::Mult => "*",
            Self::Div => "/",
            Self::Pwr => "^",
            Self::Eq => "=",
            Self::Neq => "!=",
            Self::Lt => "<",
            Self::Le => "<=",
            Self::Gt => ">",
            Self::Ge => ">=",
            Self::Mod
            | Self::Not
            | Self::And
            | Self::Or
            | Self::Xor
            | Self::Implies
            | Self::Iff => self.function(),
        }
    }

    /// Returns the precedence according to the grammar, from 0 for `implies` to 8 for a sign;
    /// greater binds tighter.
    pub fn strength(self) -> u8 {
        match self {
            Self::Implies | Self::Iff => 0,
            Self::Or | Self::Xor => 1,
            Self::And => 2,
            Self::Eq | Self::Neq | Self::Lt | Self::Le | Self::Gt | Self::Ge => 3,
            Self::Not => 4,
            Self::Plus | Self::Minus => 5,
            Self::Mult | Self::Div | Self::Mod => 6,
            Self::Pwr => 7,
        }
    }
}

/// A variable with its range: `$x in t`.
#[derive(Clone, Debug)]
pub struct Binder {
    /// Variable, including its `$`.
    pub name: NameText,
    /// Term for the range: a set, sequence or bag.
    pub range: Term,
}

/// The kinds of a quantifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantifier {
    /// `forall`
    Forall,
    /// `exists`
    Exists,
    /// `exists unique`
    ExistsUnique,
}

/// The kinds of a collection, by their brackets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Collection {
    /// `{ }`
    Set,
    /// `[ ]`
    Seq,
    /// `< >`
    Bag,
}

/// The bounds of a collection: `from : to, step`.
#[derive(Clone, Debug)]
pub struct Interval {
    /// First element.
    pub from: Term,
    /// Bound, included if a step reaches it.
    pub to: Term,
    /// Step; `None` stands for 1.
    pub step: Option<Term>,
}

/// The inside of a comprehension: `binders | guard : item`.
#[derive(Clone, Debug)]
pub struct Comprehension {
    /// Variables with their ranges.
    pub binders: Vec<Binder>,
    /// Condition on the elements; `None` stands for `true`.
    pub guard: Option<Term>,
    /// Term for each element.
    pub item: Term,
}
