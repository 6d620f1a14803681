//! Formulas of linear temporal logic (LTL) with past operators.

use crate::formula::{Formula, Polarity};

/// An LTL formula, which holds or not at a position of an infinite path.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Ltl {
    /// Holds everywhere.
    True,
    /// Holds nowhere.
    False,
    /// Holds in the nodes of the set with this index.
    Atom(usize),
    /// Negation.
    Not(Box<Ltl>),
    /// Conjunction; true without operands.
    And(Vec<Ltl>),
    /// Disjunction; false without operands.
    Or(Vec<Ltl>),
    /// Implication.
    Implies(Box<Ltl>, Box<Ltl>),
    /// Equivalence.
    Iff(Box<Ltl>, Box<Ltl>),
    /// `X`: at the next position.
    Next(Box<Ltl>),
    /// `F`: now or later.
    Finally(Box<Ltl>),
    /// `G`: now and always.
    Globally(Box<Ltl>),
    /// `U`: the second formula holds now or later, and the first until then.
    Until(Box<Ltl>, Box<Ltl>),
    /// `V`: the second formula holds up to and including the position at which the first does, or for ever.
    Release(Box<Ltl>, Box<Ltl>),
    /// `W`: the first formula holds until the second does, or for ever.
    WeakUntil(Box<Ltl>, Box<Ltl>),
    /// `Y`: at the previous position, which exists.
    Yesterday(Box<Ltl>),
    /// `Z`: at the previous position, if it exists.
    WeakYesterday(Box<Ltl>),
    /// `O`: now or earlier.
    Once(Box<Ltl>),
    /// `H`: now and at all earlier positions.
    Historically(Box<Ltl>),
    /// `S`: the second formula holds now or held earlier, and the first has held since then.
    Since(Box<Ltl>, Box<Ltl>),
    /// `T`: the second formula has held since the first did, inclusively, or always.
    Triggered(Box<Ltl>, Box<Ltl>),
}

macro_rules! constructors {
    (unary: $($unary:ident $unary_variant:ident),*; binary: $($binary:ident $binary_variant:ident),*) => {
        /// Constructors that box their operands.
        impl Ltl {
            $(
                #[doc = concat!("Returns [`Self::", stringify!($unary_variant), "`].")]
                #[must_use]
                pub fn $unary(operand: Self) -> Self {
                    Self::$unary_variant(Box::new(operand))
                }
            )*
            $(
                #[doc = concat!("Returns [`Self::", stringify!($binary_variant), "`].")]
                #[must_use]
                pub fn $binary(left: Self, right: Self) -> Self {
                    Self::$binary_variant(Box::new(left), Box::new(right))
                }
            )*
        }
    };
}

constructors! {
    unary: negation Not, next Next, finally Finally, globally Globally, yesterday Yesterday, weak_yesterday WeakYesterday,
        once Once, historically Historically;
    binary: implies Implies, iff Iff, until Until, release Release, weak_until WeakUntil, since Since, triggered Triggered
}

impl Formula for Ltl {
    fn constant(value: bool) -> Self {
        if value { Self::True } else { Self::False }
    }

    fn as_atom(&self) -> Option<usize> {
        if let Self::Atom(atom) = self {
            return Some(*atom);
        }
        None
    }

    fn antecedent(&self) -> Option<&Self> {
        if let Self::Implies(antecedent, _) = self {
            return Some(antecedent);
        }
        None
    }

    fn never(self) -> Self {
        Self::globally(Self::negation(self))
    }

    fn with_operands(&self, replace: &mut dyn FnMut(&Self, Polarity) -> Self) -> Self {
        let mut operand = |of: &Self, polarity| Box::new(replace(of, polarity));
        let (same, opposite) = (Polarity::Positive, Polarity::Negative);
        match self {
            Self::True => Self::True,
            Self::False => Self::False,
            Self::Atom(atom) => Self::Atom(*atom),
            Self::Not(of) => Self::Not(operand(of, opposite)),
            Self::And(parts) => Self::And(parts.iter().map(|it| replace(it, same)).collect()),
            Self::Or(parts) => Self::Or(parts.iter().map(|it| replace(it, same)).collect()),
            Self::Implies(left, right) => {
                Self::Implies(operand(left, opposite), operand(right, same))
            }
            Self::Iff(left, right) => Self::Iff(
                operand(left, Polarity::Mixed),
                operand(right, Polarity::Mixed),
            ),
            Self::Next(of) => Self::Next(operand(of, same)),
            Self::Finally(of) => Self::Finally(operand(of, same)),
            Self::Globally(of) => Self::Globally(operand(of, same)),
            Self::Yesterday(of) => Self::Yesterday(operand(of, same)),
            Self::WeakYesterday(of) => Self::WeakYesterday(operand(of, same)),
            Self::Once(of) => Self::Once(operand(of, same)),
            Self::Historically(of) => Self::Historically(operand(of, same)),
            Self::Until(left, right) => Self::Until(operand(left, same), operand(right, same)),
            Self::Release(left, right) => Self::Release(operand(left, same), operand(right, same)),
            Self::WeakUntil(left, right) => {
                Self::WeakUntil(operand(left, same), operand(right, same))
            }
            Self::Since(left, right) => Self::Since(operand(left, same), operand(right, same)),
            Self::Triggered(left, right) => {
                Self::Triggered(operand(left, same), operand(right, same))
            }
        }
    }
}
