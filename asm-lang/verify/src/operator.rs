//! The functions with a meaning in formulas: operators, and functions that are defined by terms with operators.

use asmotion_lang::hir::{Function, FunctionId, Meaning, Model, Term};
use std::collections::BTreeMap;

/// An operator of a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Operator {
    Not,
    And,
    Or,
    Implies,
    Iff,
    /// CTL: `E` and `A` quantify over paths.
    Ex,
    Ax,
    Ef,
    Af,
    Eg,
    Ag,
    Eu,
    Au,
    /// LTL, future.
    Next,
    Globally,
    Finally,
    Until,
    Release,
    /// LTL, past.
    Yesterday,
    WeakYesterday,
    Historically,
    Once,
    Since,
    Triggered,
}

/// The logic of an operator or formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Logic {
    Ctl,
    Ltl,
}

impl Operator {
    /// Returns the logic of a temporal operator; `None` for a Boolean one.
    pub fn logic(self) -> Option<Logic> {
        match self {
            Self::Not | Self::And | Self::Or | Self::Implies | Self::Iff => None,
            Self::Ex
            | Self::Ax
            | Self::Ef
            | Self::Af
            | Self::Eg
            | Self::Ag
            | Self::Eu
            | Self::Au => Some(Logic::Ctl),
            Self::Next
            | Self::Globally
            | Self::Finally
            | Self::Until
            | Self::Release
            | Self::Yesterday
            | Self::WeakYesterday
            | Self::Historically
            | Self::Once
            | Self::Since
            | Self::Triggered => Some(Logic::Ltl),
        }
    }
}

/// The meaning of a function of the libraries in a formula.
pub(crate) enum Meant {
    Operator(Operator),
    /// `exN`, `axN`
    Repeat(Operator),
    /// `!=` or `xor`
    Difference,
}

impl Meant {
    /// Returns the meaning of a function; `None` for one that is no operator.
    pub fn of(function: &Function) -> Option<Self> {
        if !function.library {
            return None;
        }
        Some(match &*function.name {
            "not" => Self::Operator(Operator::Not),
            "and" => Self::Operator(Operator::And),
            "or" => Self::Operator(Operator::Or),
            "implies" => Self::Operator(Operator::Implies),
            "iff" | "=" | "eq" => Self::Operator(Operator::Iff),
            "xor" | "!=" | "neq" => Self::Difference,
            "exN" => Self::Repeat(Operator::Ex),
            "axN" => Self::Repeat(Operator::Ax),
            name => Self::Operator(temporal(name)?),
        })
    }

    fn logic(&self) -> Option<Logic> {
        match self {
            Self::Operator(operator) | Self::Repeat(operator) => operator.logic(),
            Self::Difference => None,
        }
    }
}

/// Returns the temporal operator of a name in the libraries.
fn temporal(name: &str) -> Option<Operator> {
    Some(match name {
        "ex" => Operator::Ex,
        "ax" => Operator::Ax,
        "ef" => Operator::Ef,
        "af" => Operator::Af,
        "eg" => Operator::Eg,
        "ag" => Operator::Ag,
        "eu" => Operator::Eu,
        "au" => Operator::Au,
        "x" => Operator::Next,
        "g" => Operator::Globally,
        "f" => Operator::Finally,
        "u" => Operator::Until,
        "v" => Operator::Release,
        "y" => Operator::Yesterday,
        "z" => Operator::WeakYesterday,
        "h" => Operator::Historically,
        "o" => Operator::Once,
        "s" => Operator::Since,
        "t" => Operator::Triggered,
        _ => return None,
    })
}

/// The temporal functions of a specification with their logic: the operators, and functions whose definitions apply some, such as the
/// patterns of `CTLLibrary`.
pub(crate) struct TemporalFunctions(BTreeMap<FunctionId, Logic>);

impl TemporalFunctions {
    pub fn of(model: &Model) -> Self {
        let functions = || (0..).map(FunctionId).zip(&model.functions);
        let operators = functions().filter_map(|(id, function)| {
            let logic = Meant::of(function)?.logic()?;
            Some((id, logic))
        });
        let mut found = Self(operators.collect());
        if found.0.is_empty() {
            return found;
        }
        loop {
            // a definition may apply functions that are declared later
            let before = found.0.len();
            for (id, function) in functions() {
                if let Meaning::Defined(body) = &function.meaning
                    && !found.0.contains_key(&id)
                    && let Some(logic) = found.logic(&body.root)
                {
                    found.0.insert(id, logic);
                }
            }
            if found.0.len() == before {
                return found;
            }
        }
    }

    /// Returns the logic of the first temporal function in a term; `None` without any.
    pub fn logic(&self, term: &Term) -> Option<Logic> {
        let mut found = None;
        asmotion_lang::ir::visit_terms(term, &mut |part| {
            let function = part.kind.function();
            found = found.or(function.and_then(|function| self.0.get(&function).copied()));
        });
        found
    }
}

#[cfg(test)]
mod tests {
    use super::temporal;

    #[test]
    fn every_temporal_operator_of_the_libraries_has_a_meaning() {
        let named = asmotion_lang::stdlib::TEMPORAL.iter();
        let unknown: Vec<&&str> = named.filter(|name| temporal(name).is_none()).collect();
        assert_eq!(unknown, [&"exN", &"axN", &"ctl", &"ltl"]);
    }
}
