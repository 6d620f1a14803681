//! Steps as CSV: a row for each step, a column for each input and each location.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_coordinator::RecordedCycle;

/// The rows of a table, as far as their values differ from those of the row before.
#[derive(Default)]
pub struct StepTable {
    rows: Vec<TableRow>,
}

struct TableRow {
    time_ns: i64,
    number: u64,
    fault: String,
    /// A machine begins, whose values are all in the row.
    begins: bool,
    inputs: Vec<(String, String)>,
    locations: Vec<(String, String)>,
}

/// The columns before those of inputs and locations.
const FIRST: [&str; 3] = ["time_s", "step", "fault"];

impl StepTable {
    /// Adds a step.
    pub fn add(&mut self, cycle: &RecordedCycle) {
        let begun = cycle.begins.last().map(|begin| &begin.state);
        let begun = begun.into_iter().flatten();
        let begun = begun.map(|(location, value)| (location.clone(), value.clone()));
        let updates = cycle.updates.iter();
        let updates = updates.map(|update| (update.location.clone(), update.after.clone()));
        let inputs = cycle.frame.iter();
        self.rows.push(TableRow {
            time_ns: cycle.time_ns,
            number: cycle.number,
            fault: cycle.fault.clone().unwrap_or_default(),
            begins: !cycle.begins.is_empty(),
            inputs: inputs
                .map(|(name, value)| (name.clone(), value.clone()))
                .collect(),
            locations: begun.chain(updates).collect(),
        });
    }

    /// The table.
    ///
    /// # Errors
    /// It cannot be written to memory.
    pub fn text(&self) -> Result<String, String> {
        let names = |of: &dyn Fn(&TableRow) -> &Vec<(String, String)>| -> BTreeSet<String> {
            let all = self.rows.iter().flat_map(of);
            all.map(|(name, _)| name.clone()).collect()
        };
        let inputs = names(&|row| &row.inputs);
        let locations = &names(&|row| &row.locations) - &inputs;
        let columns: Vec<_> = inputs.iter().chain(&locations).collect();
        let mut table = csv::Writer::from_writer(Vec::new());
        let failed = |error: csv::Error| error.to_string();
        let head = FIRST.into_iter().chain(columns.iter().map(|name| &***name));
        table.write_record(head).map_err(failed)?;
        let mut values: BTreeMap<&str, &str> = BTreeMap::new();
        for row in &self.rows {
            if row.begins {
                values.clear();
            }
            for (name, value) in row.inputs.iter().chain(&row.locations) {
                values.insert(name, value);
            }
            let time = format!("{:.9}", row.time_ns as f64 / 1e9);
            let number = row.number.to_string();
            let first = [time.as_str(), number.as_str(), row.fault.as_str()];
            let cells = columns.iter().map(|name| match values.get(name.as_str()) {
                Some(&"undef") | None => "",
                Some(value) => value,
            });
            table
                .write_record(first.into_iter().chain(cells))
                .map_err(failed)?;
        }
        let bytes = table.into_inner().map_err(|error| error.to_string())?;
        String::from_utf8(bytes).map_err(|error| error.to_string())
    }
}
