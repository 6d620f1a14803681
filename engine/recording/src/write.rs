//! Writes recordings.

use std::collections::BTreeMap;
use std::io::{Read, Write};

use asmotion_component::Time;
use asmotion_datum::Datum;
use asmotion_runtime::Event;

use crate::pattern::PortPatterns;

/// Name of the first column.
pub(crate) const TIME: &str = "time_s";
/// Last part of the name of a column with the length of a long list.
pub(crate) const COUNT: &str = "count";
/// Maximum length of a list that is recorded by element; of longer lists only the length is recorded.
const WIDE: usize = 64;

/// Values published by ports, by time.
#[derive(Debug)]
pub struct PortRecording {
    patterns: PortPatterns,
    columns: Vec<String>,
    /// Index of each column.
    column_indices: BTreeMap<String, usize>,
    rows: Vec<RecordingRow>,
}

/// Values published at an instant.
#[derive(Debug)]
struct RecordingRow {
    at: Time,
    /// Value of each column, absent if nothing was published.
    cells: BTreeMap<usize, String>,
}

impl PortRecording {
    /// Records the ports and topics that match one of the patterns; without patterns, all of them.
    pub fn of(patterns: &[String]) -> Self {
        Self {
            patterns: PortPatterns::new(patterns),
            columns: Vec::new(),
            column_indices: BTreeMap::new(),
            rows: Vec::new(),
        }
    }

    /// Records an event.
    pub fn note(&mut self, at: Time, event: &Event<'_>) {
        let Event::Published {
            component,
            port,
            topic,
            sample,
            ..
        } = event
        else {
            return;
        };
        let name = format!("{component}.{port}");
        let names: Vec<&str> = [Some(name.as_str()), *topic]
            .into_iter()
            .flatten()
            .collect();
        let is_wanted = self.patterns.select(&names);
        if let (true, Ok(datum)) = (is_wanted, sample.to_datum()) {
            let mut values = Vec::new();
            flatten(&name, &datum, &mut values);
            self.add(at, values);
        }
    }

    /// Patterns of ports that published nothing.
    pub fn unmatched_patterns(&self) -> impl Iterator<Item = &str> {
        self.patterns.unmatched()
    }

    /// Writes the table as CSV: the time in seconds, then the columns in order of first publication.
    ///
    /// # Errors
    /// Fails if writing fails.
    pub fn write(&self, to: impl Write) -> csv::Result<()> {
        let mut table = csv::Writer::from_writer(to);
        self.write_header(&mut table)?;
        self.write_rows(&self.rows, &mut table)?;
        table.flush()?;
        Ok(())
    }

    /// Number of columns so far, without the time.
    pub fn columns(&self) -> usize {
        self.columns.len()
    }

    /// Writes rows for the end of a table with the columns so far, and forgets them. The last row stays: more values of its
    /// instant can follow.
    ///
    /// # Errors
    /// Fails if writing fails.
    pub fn write_complete_rows(&mut self, to: impl Write) -> csv::Result<()> {
        let complete = self.rows.len().saturating_sub(1);
        let rows: Vec<RecordingRow> = self.rows.drain(..complete).collect();
        self.append(&rows, to)
    }

    /// Writes all rows for the end of a table with the columns so far, and forgets them.
    ///
    /// # Errors
    /// Fails if writing fails.
    pub fn write_last_rows(&mut self, to: impl Write) -> csv::Result<()> {
        let rows = std::mem::take(&mut self.rows);
        self.append(&rows, to)
    }

    fn append(&self, rows: &[RecordingRow], to: impl Write) -> csv::Result<()> {
        let mut table = csv::Writer::from_writer(to);
        self.write_rows(rows, &mut table)?;
        table.flush()?;
        Ok(())
    }

    /// Copies a table that was written with fewer columns, with empty cells in the columns that it lacks.
    ///
    /// # Errors
    /// Fails if reading or writing fails.
    pub fn widen(&self, table: impl Read, to: impl Write) -> csv::Result<()> {
        let mut wide = csv::Writer::from_writer(to);
        self.write_header(&mut wide)?;
        let mut row = csv::StringRecord::new();
        let mut table = csv::Reader::from_reader(table);
        while table.read_record(&mut row)? {
            while row.len() <= self.columns.len() {
                row.push_field("");
            }
            wide.write_record(&row)?;
        }
        wide.flush()?;
        Ok(())
    }

    fn write_header(&self, table: &mut csv::Writer<impl Write>) -> csv::Result<()> {
        let columns = self.columns.iter().map(String::as_str);
        table.write_record(std::iter::once(TIME).chain(columns))
    }

    fn write_rows(
        &self,
        rows: &[RecordingRow],
        table: &mut csv::Writer<impl Write>,
    ) -> csv::Result<()> {
        for row in rows {
            let cell = |column| row.cells.get(&column).map_or("", String::as_str);
            let cells = (0..self.columns.len()).map(cell);
            table.write_record(std::iter::once(&*seconds(row.at)).chain(cells))?;
        }
        Ok(())
    }

    /// Adds values to the row of their instant, or to a new row if the columns are already filled.
    fn add(&mut self, at: Time, values: Vec<(String, String)>) {
        let place = |(name, value): (String, String)| (self.column(name), value);
        let values: Vec<(usize, String)> = values.into_iter().map(place).collect();
        let taken = |row: &RecordingRow| {
            values
                .iter()
                .any(|(column, _)| row.cells.contains_key(column))
        };
        let last = self.rows.last_mut();
        match last.filter(|row| row.at == at && !taken(row)) {
            Some(row) => row.cells.extend(values),
            None => self.rows.push(RecordingRow {
                at,
                cells: values.into_iter().collect(),
            }),
        }
    }

    fn column(&mut self, name: String) -> usize {
        *self.column_indices.entry(name).or_insert_with_key(|name| {
            self.columns.push(name.clone());
            self.columns.len() - 1
        })
    }
}

/// Collects the scalar fields of a message with their paths.
fn flatten(path: &str, datum: &Datum, values: &mut Vec<(String, String)>) {
    match datum {
        Datum::Record(fields) => {
            for (name, value) in fields {
                flatten(&format!("{path}.{name}"), value, values);
            }
        }
        Datum::List(_) | Datum::Numbers(_) | Datum::Bytes(_) => {
            let count = datum.count().unwrap_or(0);
            if count > WIDE {
                values.push((format!("{path}.{COUNT}"), count.to_string()));
                return;
            }
            for index in 0..count {
                if let Some(value) = datum.element(index) {
                    flatten(&format!("{path}.{index}"), &value, values);
                }
            }
        }
        Datum::Text(text) => values.push((path.to_owned(), text.clone())),
        Datum::Float(number) => values.push((path.to_owned(), number.to_string())),
        Datum::Null | Datum::Bool(_) | Datum::Int(_) => {
            values.push((path.to_owned(), datum.to_string()));
        }
    }
}

/// Formats seconds exactly, independent of the platform.
fn seconds(at: Time) -> String {
    let nanos = at.nanos();
    let (whole, rest) = (nanos / 1_000_000_000, nanos % 1_000_000_000);
    format!("{whole}.{rest:09}")
}
