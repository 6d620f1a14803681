//! Debts: the rules of the house that are not kept everywhere yet, and the extent to which they are
//! not.
//!
//! `tests/house.toml` records the debts. `tests/house.rs` fails if a debt has grown, and also if it
//! has shrunk without the record being lowered, so that debts can only decrease.

use crate::checkout::Checkout;
use crate::modules::CrateModules;
use crate::type_names::{self, NameReuse};
use crate::{graph, modules};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Largest permitted cycle of files.
pub const LARGEST_CYCLE: usize = 5;

/// Permitted percentage of type names with several meanings.
pub const REUSED_NAMES: f64 = 8.0;

/// Path of the record, relative to the root.
pub const RECORD: &str = "tests/house.toml";

/// The debts of one crate.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CrateDebt {
    /// Number of uses of names through `lib.rs` or `main.rs`.
    pub hub_uses: usize,
    /// Number of arrows between first-level modules that have to be reversed to remove all cycles.
    pub climbing: usize,
    /// Sizes of the cycles with more than [`LARGEST_CYCLE`] files, in descending order.
    pub cycles: Vec<usize>,
}

/// The debts of all crates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HouseDebts {
    /// Number of type names with several meanings; 0 if their percentage is at most
    /// [`REUSED_NAMES`].
    pub reused_names: usize,
    /// Crates with a debt, by name.
    pub crates: BTreeMap<String, CrateDebt>,
}

/// The failure to parse the record.
#[derive(Debug, thiserror::Error)]
pub enum DebtsError {
    /// The record is not valid TOML.
    #[error("{RECORD}: {0}")]
    Toml(#[from] toml::de::Error),
    /// The value of a key has the wrong type.
    #[error("{RECORD}: `{0}` is not a number or list of numbers")]
    Value(String),
}

impl HouseDebts {
    /// Measures the debts of the sources.
    pub fn of(checkout: &Checkout) -> Self {
        let reuse = NameReuse::of(&type_names::definitions(checkout));
        let mut crates: BTreeMap<String, CrateDebt> = BTreeMap::new();
        for modules in modules::of(checkout) {
            let debt = crates.entry(modules.name.clone()).or_default();
            debt.add(&modules);
        }
        crates.retain(|_, debt| *debt != CrateDebt::default());
        Self {
            reused_names: if reuse.percent() < REUSED_NAMES {
                0
            } else {
                reuse.reused
            },
            crates,
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
            match value.as_table() {
                Some(table) => {
                    debts.crates.insert(key.clone(), CrateDebt::parse(table)?);
                }
                None => match key.as_str() {
                    "reused_names" => debts.reused_names = number(key, value)?,
                    _ => return Err(DebtsError::Value(key.clone())),
                },
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
        let _ = writeln!(text, "reused_names = {}", self.reused_names);
        for (name, debt) in &self.crates {
            let _ = writeln!(text, "\n[{name}]");
            let _ = writeln!(text, "hub_uses = {}", debt.hub_uses);
            let _ = writeln!(text, "climbing = {}", debt.climbing);
            let _ = writeln!(text, "cycles = {:?}", debt.cycles);
        }
        text
    }

    /// Describes the debts that are greater than recorded, one sentence each.
    pub fn grown(&self, recorded: &Self) -> Vec<String> {
        let mut found = Vec::new();
        if self.reused_names > recorded.reused_names {
            found.push(format!(
                "{} type names have several meanings, {} before: `cargo xtask names` lists them",
                self.reused_names, recorded.reused_names
            ));
        }
        for (name, debt) in &self.crates {
            let before = recorded.crates.get(name).cloned().unwrap_or_default();
            debt.grown(&before, name, &mut found);
        }
        found
    }

    /// Returns the lesser of each debt.
    pub fn lowered(&self, recorded: &Self) -> Self {
        let mut crates = BTreeMap::new();
        for (name, debt) in &self.crates {
            if let Some(before) = recorded.crates.get(name) {
                crates.insert(name.clone(), debt.lowered(before));
            }
        }
        crates.retain(|_, debt| *debt != CrateDebt::default());
        Self {
            reused_names: self.reused_names.min(recorded.reused_names),
            crates,
        }
    }
}

impl CrateDebt {
    fn add(&mut self, modules: &CrateModules) {
        self.hub_uses += modules.hub_uses.len();
        self.climbing += graph::climbing(&modules.room_arrows()).len();
        let cycles = graph::cycles(&modules.arrows());
        let large = cycles
            .iter()
            .map(Vec::len)
            .filter(|files| *files > LARGEST_CYCLE);
        self.cycles.extend(large);
        self.cycles.sort_unstable_by(|a, b| b.cmp(a));
    }

    fn parse(table: &toml::Table) -> Result<Self, DebtsError> {
        let mut debt = Self::default();
        for (key, value) in table {
            match key.as_str() {
                "hub_uses" => debt.hub_uses = number(key, value)?,
                "climbing" => debt.climbing = number(key, value)?,
                "cycles" => {
                    let sizes = value
                        .as_array()
                        .ok_or_else(|| DebtsError::Value(key.clone()))?;
                    debt.cycles = sizes
                        .iter()
                        .map(|size| number(key, size))
                        .collect::<Result<_, _>>()?;
                }
                _ => return Err(DebtsError::Value(key.clone())),
            }
        }
        Ok(debt)
    }

    fn grown(&self, before: &Self, name: &str, found: &mut Vec<String>) {
        if self.hub_uses > before.hub_uses {
            found.push(format!(
                "{name}: {} uses of a name through the root of the crate, {} before: import it from its module; `cargo xtask hubs {name}` lists them",
                self.hub_uses, before.hub_uses
            ));
        }
        if self.climbing > before.climbing {
            found.push(format!(
                "{name}: {} arrows climb between first-level modules, {} before: `cargo xtask cycles {name}` lists them",
                self.climbing, before.climbing
            ));
        }
        if larger(&self.cycles, &before.cycles) {
            found.push(format!(
                "{name}: files in cycles: {:?}, {:?} before: `cargo xtask cycles {name}` lists them",
                self.cycles, before.cycles
            ));
        }
    }

    fn lowered(&self, before: &Self) -> Self {
        Self {
            hub_uses: self.hub_uses.min(before.hub_uses),
            climbing: self.climbing.min(before.climbing),
            cycles: if larger(&self.cycles, &before.cycles) {
                before.cycles.clone()
            } else {
                self.cycles.clone()
            },
        }
    }
}

/// Returns `true` if the large cycles contain more files than before, or the largest cycle has
/// grown.
fn larger(now: &[usize], before: &[usize]) -> bool {
    let files = |sizes: &[usize]| sizes.iter().sum::<usize>();
    files(now) > files(before) || now.first() > before.first()
}

fn number(key: &str, value: &toml::Value) -> Result<usize, DebtsError> {
    let number = value.as_integer().and_then(|it| usize::try_from(it).ok());
    number.ok_or_else(|| DebtsError::Value(key.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::{CrateDebt, HouseDebts};

    fn debts(hub_uses: usize, cycles: &[usize]) -> HouseDebts {
        let debt = CrateDebt {
            hub_uses,
            climbing: 0,
            cycles: cycles.to_vec(),
        };
        HouseDebts {
            reused_names: 3,
            crates: [("one".to_owned(), debt)].into(),
        }
    }

    #[test]
    fn a_record_is_read_as_it_was_written() {
        let written = debts(4, &[9, 6]);
        let read = HouseDebts::parse(&written.to_toml());
        assert_eq!(read.ok(), Some(written));
    }

    #[test]
    fn growth_is_named_and_not_recorded() {
        let (before, now) = (debts(4, &[9, 6]), debts(5, &[16]));
        assert_eq!(now.grown(&before).len(), 2);
        assert_eq!(now.lowered(&before), before);
    }

    #[test]
    fn a_smaller_debt_is_recorded() {
        let (before, now) = (debts(4, &[9, 6]), debts(4, &[8, 7]));
        assert!(now.grown(&before).is_empty());
        assert_eq!(now.lowered(&before), now);
    }

    #[test]
    fn a_crate_without_an_entry_has_no_debt_allowed() {
        let now = debts(1, &[]);
        let before = HouseDebts {
            crates: [].into(),
            ..debts(0, &[])
        };
        assert_eq!(now.grown(&before).len(), 1);
        assert_eq!(now.lowered(&before), before);
    }
}
