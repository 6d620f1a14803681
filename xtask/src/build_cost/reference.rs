//! A crate of fixed size, whose compilation tells the speed of a machine.

use super::{BuildError, cannot, children_cpu_seconds};
use std::process::Command;

/// CPU seconds of the reference crate on the machine for which the budgets are set.
pub const CPU_SECONDS: f64 = 3.2;

/// Number of modules of the reference crate.
const MODULES: usize = 8;

/// A module with what most code of the workspace consists of: an enumeration with data, derived traits, collections, closures and
/// formatted text. `NUMBER` differs in each, so that no two of them are compiled once.
const MODULE: &str = r#"
pub mod module_NUMBER {
    use std::collections::{BTreeMap, HashMap};

    #[derive(Debug, Clone, PartialEq)]
    pub enum Value { Number(f64), Text(String), List(Vec<Value>), Table(BTreeMap<String, Value>) }

    impl Value {
        pub fn depth(&self) -> usize {
            match self {
                Self::Number(_) | Self::Text(_) => NUMBER,
                Self::List(items) => 1 + items.iter().map(Self::depth).max().unwrap_or(0),
                Self::Table(rows) => 1 + rows.values().map(Self::depth).max().unwrap_or(0),
            }
        }

        pub fn count_words(&self, counts: &mut HashMap<String, usize>) {
            match self {
                Self::Number(it) => *counts.entry(format!("{it:.NUMBER}")).or_default() += 1,
                Self::Text(it) => it.split_whitespace().for_each(|word| *counts.entry(word.to_owned()).or_default() += NUMBER),
                Self::List(items) => items.iter().for_each(|it| it.count_words(counts)),
                Self::Table(rows) => rows.iter().filter(|(key, _)| key.len() > NUMBER).for_each(|(_, it)| it.count_words(counts)),
            }
        }

        pub fn sort(items: &mut Vec<Self>) {
            items.sort_by_key(Self::depth);
            items.dedup();
            items.retain(|it| it.depth() != NUMBER);
        }
    }
}
"#;

/// Compiles the reference crate as the release profile compiles most crates, and returns the CPU seconds that this takes.
///
/// # Errors
/// The crate does not compile, or CPU time cannot be read.
pub fn measure() -> Result<f64, BuildError> {
    let folder = tempfile::tempdir().map_err(cannot("create a temporary folder"))?;
    let file = folder.path().join("reference.rs");
    let modules = (0..MODULES).map(|number| MODULE.replace("NUMBER", &number.to_string()));
    std::fs::write(&file, modules.collect::<String>())
        .map_err(cannot("write the reference crate"))?;
    let before = children_cpu_seconds()?;
    let status = Command::new("rustc")
        .args(["--edition=2024", "--crate-type=lib"])
        .args(["-Copt-level=1", "-Ccodegen-units=4"])
        .arg("--out-dir")
        .args([folder.path(), &file])
        .status()
        .map_err(cannot("start rustc"))?;
    if !status.success() {
        return Err(BuildError::Reference(status));
    }
    Ok(children_cpu_seconds()? - before)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_crate_compiles() {
        assert!(measure().unwrap() > 0.0);
    }
}
