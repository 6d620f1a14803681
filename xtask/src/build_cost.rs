//! Reads the recorded cost of cold builds.

use crate::table::Rows;
use std::path::Path;

/// Written by `build-cost`; one table for each set of features.
const RECORD: &str = "docs/build-cost.toml";

/// A row for each recorded set of features; none where nothing is recorded.
pub fn rows(root: &Path) -> Rows {
    let text = std::fs::read_to_string(root.join(RECORD)).unwrap_or_default();
    let Ok(record) = toml::from_str::<toml::Table>(&text) else {
        return Rows::new();
    };
    let sets = record.iter().filter_map(|(set, values)| {
        let seconds = values.as_table()?.get("cpu_seconds")?;
        let seconds = seconds
            .as_float()
            .or_else(|| seconds.as_integer().map(|it| it as f64))?;
        Some((
            format!("cold build, `{set}`, CPU seconds"),
            format!("{seconds:.0}"),
        ))
    });
    sets.collect()
}
