//! Values of terms and variables during grounding.

use crate::program::{FAULT, GroundTerm, Sort, UNDEF};
use asmotion_value::Value;

/// The meaning of a term in an environment of known variables.
#[derive(Clone, Debug)]
pub(crate) enum KnownTerm {
    /// The same value in every state.
    Value(Value),
    /// A scalar that depends on the state or on inputs.
    Term(GroundTerm, Sort),
    /// A tuple of which a component depends on the state or on inputs.
    Tuple(Vec<KnownTerm>),
    /// Only a machine can evaluate it.
    Unknown,
}

impl KnownTerm {
    /// Returns the term with its sort; `undef` fits every sort. `None` if it is no scalar.
    pub fn scalar(self) -> Option<(GroundTerm, Option<Sort>)> {
        match self {
            Self::Value(value) => {
                let (sort, number) = Sort::number(&value)?;
                Some((GroundTerm::Constant(number), sort))
            }
            Self::Term(term, sort) => Some((term, Some(sort))),
            Self::Tuple(_) | Self::Unknown => None,
        }
    }

    /// Returns the term if its values are of this sort, otherwise one that needs a machine.
    pub fn of_sort(self, wanted: Sort) -> GroundTerm {
        match self.scalar() {
            Some((term, sort)) if sort.is_none_or(|sort| sort == wanted) => term,
            Some(_) | None => GroundTerm::Constant(FAULT),
        }
    }

    /// Returns a term as a meaning; a constant becomes a value.
    pub fn of(term: GroundTerm, sort: Sort) -> Self {
        match term {
            GroundTerm::Constant(FAULT) => Self::Unknown,
            GroundTerm::Constant(UNDEF) => Self::Value(Value::Undef),
            GroundTerm::Constant(number) => Self::Value(sort.value(number)),
            GroundTerm::Variable(_)
            | GroundTerm::Input(_)
            | GroundTerm::Not(_)
            | GroundTerm::Logic(..)
            | GroundTerm::Quantified(..)
            | GroundTerm::Equal(..)
            | GroundTerm::Compare(..)
            | GroundTerm::Arithmetic(..)
            | GroundTerm::If(..)
            | GroundTerm::Table { .. }
            | GroundTerm::After(..) => Self::Term(term, sort),
        }
    }
}
