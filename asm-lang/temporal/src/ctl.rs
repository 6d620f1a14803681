//! Formulas of computation tree logic (CTL).

use crate::formula::{Formula, Polarity};

/// A CTL formula. Only fair paths count for the path quantifiers.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Ctl {
    /// Holds in every node.
    True,
    /// Holds in no node.
    False,
    /// Holds in the nodes of the set with this index.
    Atom(usize),
    /// Negation.
    Not(Box<Ctl>),
    /// Conjunction; true without operands.
    And(Vec<Ctl>),
    /// Disjunction; false without operands.
    Or(Vec<Ctl>),
    /// Implication.
    Implies(Box<Ctl>, Box<Ctl>),
    /// Equivalence.
    Iff(Box<Ctl>, Box<Ctl>),
    /// `EX` repeated: on some path, after this number of steps.
    Ex(u32, Box<Ctl>),
    /// `AX` repeated: on all paths, after this number of steps.
    Ax(u32, Box<Ctl>),
    /// On some path, now or later.
    Ef(Box<Ctl>),
    /// On all paths, now or later.
    Af(Box<Ctl>),
    /// On some path, now and always.
    Eg(Box<Ctl>),
    /// On all paths, now and always.
    Ag(Box<Ctl>),
    /// On some path, the second formula holds now or later, and the first until then.
    Eu(Box<Ctl>, Box<Ctl>),
    /// On all paths, the second formula holds now or later, and the first until then.
    Au(Box<Ctl>, Box<Ctl>),
    /// On some path, the first formula holds until the second does, or for ever.
    Ew(Box<Ctl>, Box<Ctl>),
    /// On all paths, the first formula holds until the second does, or for ever.
    Aw(Box<Ctl>, Box<Ctl>),
}

macro_rules! constructors {
    (unary: $($unary:ident $unary_variant:ident),*; binary: $($binary:ident $binary_variant:ident),*) => {
        /// Constructors that box their operands.
        impl Ctl {
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
    unary: negation Not, ef Ef, af Af, eg Eg, ag Ag;
    binary: implies Implies, iff Iff, eu Eu, au Au, ew Ew, aw Aw
}

impl Ctl {
    /// Returns [`Self::Ex`].
    #[must_use]
    pub fn ex(steps: u32, operand: Self) -> Self {
        Self::Ex(steps, Box::new(operand))
    }

    /// Returns [`Self::Ax`].
    #[must_use]
    pub fn ax(steps: u32, operand: Self) -> Self {
        Self::Ax(steps, Box::new(operand))
    }
}

impl Formula for Ctl {
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
        Self::ag(Self::negation(self))
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
            Self::Ex(steps, of) => Self::Ex(*steps, operand(of, same)),
            Self::Ax(steps, of) => Self::Ax(*steps, operand(of, same)),
            Self::Ef(of) => Self::Ef(operand(of, same)),
            Self::Af(of) => Self::Af(operand(of, same)),
            Self::Eg(of) => Self::Eg(operand(of, same)),
            Self::Ag(of) => Self::Ag(operand(of, same)),
            Self::Eu(left, right) => Self::Eu(operand(left, same), operand(right, same)),
            Self::Au(left, right) => Self::Au(operand(left, same), operand(right, same)),
            Self::Ew(left, right) => Self::Ew(operand(left, same), operand(right, same)),
            Self::Aw(left, right) => Self::Aw(operand(left, same), operand(right, same)),
        }
    }
}
