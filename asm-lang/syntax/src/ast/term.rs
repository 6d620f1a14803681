//! Terms as written.

use super::{NameText, Type};
use asmotion_diagnostics::Span;
use std::sync::Arc;

/// A term and where it stands.
#[derive(Clone, Debug)]
pub struct Term {
    /// What it is.
    pub kind: Box<TermKind>,
    /// Where it stands, brackets included.
    pub span: Span,
    /// How deep it nests: 1 without subterms. The parser bounds it (`MAX_DEPTH`).
    pub depth: u32,
}

/// The forms of a term.
#[derive(Clone, Debug)]
pub enum TermKind {
    /// A constant.
    Literal(Literal),
    /// `$x`.
    Variable(NameText),
    /// A name that begins upper-case: an enumeration literal or a domain, decided later.
    Constant(NameText),
    /// `f`, `f(t1, …)`; also prefix use of an operator, `mod(a, b)`.
    Apply {
        /// The function.
        name: NameText,
        /// The arguments; empty without brackets.
        arguments: Vec<Term>,
    },
    /// `a.f(t1, …)`.
    Dot {
        /// The agent: `self` or an agent's name.
        agent: NameText,
        /// The function.
        name: NameText,
        /// The arguments after the agent.
        arguments: Vec<Term>,
    },
    /// `a op b op c …`: operators of one strength, from left to right.
    Chain {
        /// The first operand.
        first: Term,
        /// What follows it; at least one link.
        links: Vec<ChainLink>,
    },
    /// `op operand`: `+`, `-`, `not`.
    Unary {
        /// The operator.
        operator: Operator,
        /// Where the operator stands.
        at: Span,
        /// Its operand.
        operand: Term,
    },
    /// `(t1, t2, …)`; at least two components, `(t)` is `t`.
    Tuple(Vec<Term>),
    /// `if g then t else e endif`.
    If {
        /// The guard.
        guard: Term,
        /// Its value where the guard holds.
        then: Term,
        /// Its value otherwise; `undef` without.
        otherwise: Option<Term>,
    },
    /// `switch t case c: v … otherwise o endswitch`.
    Switch {
        /// What is compared.
        subject: Term,
        /// The cases, in order.
        cases: Vec<(Term, Term)>,
        /// Its value where no case matches; `undef` without.
        otherwise: Option<Term>,
    },
    /// `let ($x = t, …) in b endlet`; later bindings see earlier ones.
    Let {
        /// The bindings, in order.
        bindings: Vec<(NameText, Term)>,
        /// The value.
        body: Term,
    },
    /// `(forall $x in D with g)`, `(exists …)`, `(exists unique …)`.
    Quantified {
        /// Which one.
        quantifier: Quantifier,
        /// The variables.
        binders: Vec<Binder>,
        /// The guard; `true` without.
        guard: Option<Term>,
    },
    /// `{t, …}`, `[…]`, `<…>` with the elements listed.
    Listed {
        /// Set, sequence or bag.
        collection: Collection,
        /// The elements.
        items: Vec<Term>,
    },
    /// `{a : b, s}`, also in `[ ]` and `< >`.
    Interval {
        /// Set, sequence or bag.
        collection: Collection,
        /// The bounds and the step.
        interval: Interval,
    },
    /// `{$x in D | g : t}`, also in `[ ]` and `< >`.
    Comprehension {
        /// Set, sequence or bag.
        collection: Collection,
        /// What is collected.
        comprehension: Comprehension,
    },
    /// `{k -> v, …}`, `{->}`.
    Map(Vec<(Term, Term)>),
    /// `{$x in D | g : k -> v}`.
    MapComprehension {
        /// The binders, the guard and the key.
        comprehension: Comprehension,
        /// The value.
        value: Term,
    },
    /// `<<r_x(D1, …)>>`.
    RuleRef {
        /// The rule.
        name: NameText,
        /// The parameter domains that pick an overload.
        domains: Vec<Type>,
    },
    /// A structured domain as a term (a plain name is [`TermKind::Constant`]).
    Domain(Type),
    /// What could not be parsed; an error was reported.
    Invalid,
}

/// A constant as written.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal {
    /// `undef`.
    Undef,
    /// `true`, `false`.
    Bool(bool),
    /// Digits; `None` where they do not fit 64 bits (an error was reported).
    Integer(Option<i64>),
    /// Digits and `n`.
    Natural(Option<i64>),
    /// Digits, a point, digits.
    Real(f64),
    /// Real and imaginary part.
    Complex(f64, f64),
    /// `'c'`.
    Char(char),
    /// `"text"`, the characters between the quotes kept raw.
    Text(Arc<str>),
}

/// The operators; each is sugar for a function of the standard library.
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

/// `op b` in a chain.
#[derive(Clone, Debug)]
pub struct ChainLink {
    /// The operator.
    pub operator: Operator,
    /// Where the operator stands.
    pub at: Span,
    /// Its right operand.
    pub operand: Term,
}

impl ChainLink {
    /// So many links of a chain nest in each other when they are resolved; what goes before them has
    /// a name then. The depth of a term counts them so.
    pub const NESTED: u32 = 64;
}

impl Operator {
    /// The standard function it stands for.
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

    /// How it is written.
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

    /// How tight it holds its operands together, as the grammar has it: from 0 for `implies` to 8 for
    /// a sign.
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

/// `$x in t`.
#[derive(Clone, Debug)]
pub struct Binder {
    /// The variable, with its `$`.
    pub name: NameText,
    /// Its range.
    pub range: Term,
}

/// Which quantifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantifier {
    /// `forall`
    Forall,
    /// `exists`
    Exists,
    /// `exists unique`
    ExistsUnique,
}

/// The brackets of a collection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Collection {
    /// `{ }`
    Set,
    /// `[ ]`
    Seq,
    /// `< >`
    Bag,
}

/// `from : to, step`.
#[derive(Clone, Debug)]
pub struct Interval {
    /// The first element.
    pub from: Term,
    /// The bound, included when reached.
    pub to: Term,
    /// The step; 1 without.
    pub step: Option<Term>,
}

/// `binders | guard : item`.
#[derive(Clone, Debug)]
pub struct Comprehension {
    /// The variables.
    pub binders: Vec<Binder>,
    /// The guard; `true` without.
    pub guard: Option<Term>,
    /// What is collected.
    pub item: Term,
}
