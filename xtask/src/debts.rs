//! Debts: the rules of the house that are not kept everywhere yet, and the extent to which they are
//! not.
//!
//! `tests/house.toml` records the debts. `tests/house.rs` fails if a debt has grown, and also if it
//! has shrunk without the record being lowered, so that debts can only decrease.

use crate::arms;
use crate::checkout::Checkout;
use crate::doc_blocks::{self, DocCount};
use std::fmt::Write as _;

/// Path of the record, relative to the root.
pub const RECORD: &str = "tests/house.toml";

/// The debts of all crates.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HouseDebts {
    /// Number of `match` expressions with `_ =>` next to a variant of an enum of this repository.
    pub wildcard_arms: usize,
    /// Number of public functions that return a `Result` without an `# Errors` section.
    pub missing_errors: usize,
}

/// The failure to parse the record.
#[derive(Debug, thiserror::Error)]
pub enum DebtsError {
    /// The record is not valid TOML.
    #[error("{RECORD}: {0}")]
    Toml(#[from] toml::de::Error),
    /// The value of a key has the wrong type.
    #[error("{RECORD}: `{0}` is not a number")]
    Value(String),
}

impl HouseDebts {
    /// Measures the debts of the sources.
    pub fn of(checkout: &Checkout) -> Self {
        let mut docs = DocCount::default();
        for file in &checkout.files {
            doc_blocks::count(file, &mut docs);
        }
        Self {
            wildcard_arms: arms::count(checkout).wildcards.len(),
            missing_errors: docs.unexplained,
        }
    }

    /// Parses a record.
    ///
    /// # Errors
    /// The text is not a valid record.
    pub fn parse(text: &str) -> Result<Self, DebtsError> {
        let record: toml::Table = toml::from_str(text)?;
        let mut debts = Self::default();
        for (key, value) in &record {
            match key.as_str() {
                "wildcard_arms" => debts.wildcard_arms = number(key, value)?,
                "missing_errors" => debts.missing_errors = number(key, value)?,
                _ => return Err(DebtsError::Value(key.clone())),
            }
        }
        Ok(debts)
    }

    /// Formats the record as TOML.
    pub fn to_toml(&self) -> String {
        let mut text = String::from(
            "# Debts that tests/house.rs allows. They only shrink: `cargo xtask debts` lowers them.\n",
        );
        // writing to a string cannot fail
        let _ = writeln!(text, "wildcard_arms = {}", self.wildcard_arms);
        let _ = writeln!(text, "missing_errors = {}", self.missing_errors);
        text
    }

    /// Describes the debts that are greater than recorded, one sentence each.
    pub fn grown(&self, recorded: &Self) -> Vec<String> {
        let mut found = Vec::new();
        if self.wildcard_arms > recorded.wildcard_arms {
            found.push(format!(
                "{} matches have `_ =>` beside a variant of our own, {} before: `cargo xtask wildcards` lists them",
                self.wildcard_arms, recorded.wildcard_arms
            ));
        }
        if self.missing_errors > recorded.missing_errors {
            found.push(format!(
                "{} public functions return a `Result` and have no `# Errors` section, {} before",
                self.missing_errors, recorded.missing_errors
            ));
        }
        found
    }

    /// Returns the lesser of each debt.
    pub fn lowered(&self, recorded: &Self) -> Self {
        Self {
            wildcard_arms: self.wildcard_arms.min(recorded.wildcard_arms),
            missing_errors: self.missing_errors.min(recorded.missing_errors),
        }
    }
}

fn number(key: &str, value: &toml::Value) -> Result<usize, DebtsError> {
    let number = value.as_integer().and_then(|it| usize::try_from(it).ok());
    number.ok_or_else(|| DebtsError::Value(key.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::HouseDebts;

    fn debts(wildcard_arms: usize, missing_errors: usize) -> HouseDebts {
        HouseDebts {
            wildcard_arms,
            missing_errors,
        }
    }

    #[test]
    fn a_record_is_read_as_it_was_written() {
        let written = debts(4, 1);
        let read = HouseDebts::parse(&written.to_toml());
        assert_eq!(read.ok(), Some(written));
    }

    #[test]
    fn growth_is_named_and_not_recorded() {
        let (before, now) = (debts(4, 1), debts(5, 2));
        assert_eq!(now.grown(&before).len(), 2);
        assert_eq!(now.lowered(&before), before);
    }

    #[test]
    fn a_smaller_debt_is_recorded() {
        let (before, now) = (debts(4, 1), debts(3, 1));
        assert!(now.grown(&before).is_empty());
        assert_eq!(now.lowered(&before), now);
    }
}
