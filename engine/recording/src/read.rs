//! Reads recordings.

use std::collections::BTreeMap;
use std::io::Read;

use asmotion_component::Time;
use asmotion_datum::{Datum, DatumError, Schema, Shape};

use crate::write::{COUNT, TIME};

/// The reason that the samples of a port cannot be read from a recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordingError {
    /// Reading failed.
    #[error("cannot be read: {reason}")]
    Unreadable {
        /// Error of the operating system.
        reason: String,
    },
    /// The text is no CSV, or its first column is not the time.
    #[error("this is no recording of `asmotion run --record`: {reason}")]
    Format {
        /// The difference to a recording.
        reason: String,
    },
    /// No column belongs to the port.
    #[error("the recording has no port `{port}`; its columns are {columns}")]
    UnknownPort {
        /// Requested port.
        port: String,
        /// Names of the columns, with commas between them.
        columns: String,
    },
    /// Only the length of a list is recorded.
    #[error("of long lists such as `{list}`, only the length is recorded")]
    LongList {
        /// Port and path of the list.
        list: String,
    },
    /// A sample does not fit the type of the port that it is read for.
    #[error("line {line} has a sample of `{port}` that does not fit: {reason}")]
    Mismatch {
        /// Recorded port.
        port: String,
        /// Line of the file, from 1.
        line: u64,
        /// The first mismatch.
        reason: DatumError,
    },
}

/// Reads the samples of a port, `component.port`, with their times, in order. They are completed by a schema: fields without
/// a value have their initial value, which is also that of an empty text or list, because neither leaves a trace in a
/// recording.
///
/// # Errors
/// The recording has no such port, lacks the elements of one of its lists, or a sample does not fit the schema.
pub fn read_samples(
    recording: impl Read,
    port: &str,
    schema: &Schema,
) -> Result<Vec<(Time, Datum)>, RecordingError> {
    let mut rows = csv::Reader::from_reader(recording);
    let columns = PortColumn::all(rows.headers().map_err(malformed)?, port, schema)?;
    let mut samples = Vec::new();
    for row in rows.records() {
        let row = row.map_err(malformed)?;
        let mut root = Part::default();
        for PortColumn { index, path } in &columns {
            if let Some(cell) = row.get(*index).filter(|cell| !cell.is_empty()) {
                root.insert(path, cell);
            }
        }
        if root.is_empty() {
            continue;
        }
        let at = time(row.get(0).unwrap_or_default())?;
        let sample = schema.complete(root.datum(schema));
        let sample = sample.map_err(|reason| RecordingError::Mismatch {
            port: port.to_owned(),
            line: row.position().map_or(0, csv::Position::line),
            reason,
        })?;
        samples.push((at, sample));
    }
    Ok(samples)
}

/// A column with a part of the samples of the requested port.
struct PortColumn {
    index: usize,
    /// Names of fields and indices of elements; empty if the samples are scalars.
    path: Vec<String>,
}

impl PortColumn {
    /// Finds the columns of a port.
    fn all(
        head: &csv::StringRecord,
        port: &str,
        schema: &Schema,
    ) -> Result<Vec<Self>, RecordingError> {
        if head.get(0) != Some(TIME) {
            let reason = format!("its first column is not `{TIME}`");
            return Err(RecordingError::Format { reason });
        }
        let of_port = head.iter().enumerate().filter_map(|(index, column)| {
            let rest = column.strip_prefix(port)?;
            let path = match rest.strip_prefix('.') {
                Some(path) => path.split('.').map(str::to_owned).collect(),
                None if rest.is_empty() => Vec::new(),
                None => return None,
            };
            Some(Self { index, path })
        });
        let columns: Vec<Self> = of_port.collect();
        if columns.is_empty() {
            let names: Vec<String> = head.iter().skip(1).map(|it| format!("`{it}`")).collect();
            return Err(RecordingError::UnknownPort {
                port: port.to_owned(),
                columns: names.join(", "),
            });
        }
        match columns.iter().find(|it| it.is_length(&columns, schema)) {
            Some(column) => {
                let list = &column.path[..column.path.len() - 1];
                let list = std::iter::once(port).chain(list.iter().map(String::as_str));
                let list = list.collect::<Vec<_>>().join(".");
                Err(RecordingError::LongList { list })
            }
            None => Ok(columns),
        }
    }

    /// Tests whether this is the length of a list, and not a field called `count`. Where the schema does not say it, a record
    /// is assumed to have other fields as well.
    fn is_length(&self, columns: &[Self], schema: &Schema) -> bool {
        let Some((last, list)) = self.path.split_last().filter(|(last, _)| *last == COUNT) else {
            return false;
        };
        let at = list.iter().try_fold(schema, |at, step| at.part(step));
        match at.map(|it| &it.without_option().shape) {
            Some(Shape::List(_) | Shape::Array(..)) => true,
            Some(Shape::Any) | None => {
                let in_list = |it: &&Self| it.path.starts_with(list) && it.path.len() > list.len();
                let mut parts = columns
                    .iter()
                    .filter(in_list)
                    .map(|it| &it.path[list.len()]);
                !list.is_empty() && parts.all(|part| part == last || is_index(part))
            }
            Some(_) => false,
        }
    }
}

/// A part of a sample: a scalar, or a record or list by field or index.
#[derive(Default)]
struct Part<'a> {
    cell: Option<&'a str>,
    parts: BTreeMap<String, Part<'a>>,
}

impl<'a> Part<'a> {
    fn is_empty(&self) -> bool {
        self.cell.is_none() && self.parts.is_empty()
    }

    fn insert(&mut self, path: &[String], cell: &'a str) {
        match path {
            [] => self.cell = Some(cell),
            [first, rest @ ..] => {
                let part = self.parts.entry(first.clone()).or_default();
                part.insert(rest, cell);
            }
        }
    }

    /// Converts cells to data as the schema wants them, as far as they fit; [`Schema::complete`] finds what does not.
    fn datum(&self, schema: &Schema) -> Datum {
        match (&schema.shape, self.cell) {
            (Shape::Option(_), Some("null")) => Datum::Null,
            (Shape::Option(some), _) => self.datum(some),
            (Shape::List(element) | Shape::Array(element, _), None) => self.list(element),
            (Shape::Any, None) if self.parts.keys().all(|name| is_index(name)) => self.list(schema),
            (Shape::Record(fields), None) => {
                Datum::record(self.parts.iter().map(|(name, part)| {
                    let field = fields.iter().find(|field| field.name == *name);
                    let any = Schema::plain(Shape::Any);
                    let part = part.datum(field.map_or(&any, |field| &field.schema));
                    (name.clone(), part)
                }))
            }
            (_, None) => {
                let any = Schema::plain(Shape::Any);
                let fields = self.parts.iter();
                Datum::record(fields.map(|(name, part)| (name.clone(), part.datum(&any))))
            }
            (Shape::Text, Some(cell)) => Datum::text(cell),
            // not by way of an integer, which has no negative zero
            (Shape::F32 | Shape::F64, Some(cell)) => {
                (cell.parse()).map_or_else(|_| Datum::text(cell), Datum::Float)
            }
            (_, Some(cell)) => scalar(cell),
        }
    }

    fn list(&self, element: &Schema) -> Datum {
        let mut elements: Vec<(u64, Datum)> = (self.parts.iter())
            .map(|(index, part)| (index.parse().unwrap_or(u64::MAX), part.datum(element)))
            .collect();
        elements.sort_by_key(|(index, _)| *index);
        Datum::List(elements.into_iter().map(|(_, element)| element).collect())
    }
}

fn is_index(name: &str) -> bool {
    !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_digit())
}

/// The value of a cell whose type is not text: that of a literal, otherwise a text.
fn scalar(cell: &str) -> Datum {
    match cell {
        "null" => Datum::Null,
        "true" => Datum::Bool(true),
        "false" => Datum::Bool(false),
        _ => match (cell.parse(), cell.parse()) {
            (Ok(whole), _) => Datum::Int(whole),
            (_, Ok(float)) => Datum::Float(float),
            _ => Datum::text(cell),
        },
    }
}

/// Parses seconds with up to nine decimals.
fn time(cell: &str) -> Result<Time, RecordingError> {
    let nanos = || {
        let (whole, decimals) = cell.split_once('.').unwrap_or((cell, "0"));
        let is_number = is_index(whole) && is_index(decimals) && decimals.len() <= 9;
        let nanos: i64 = format!("{decimals:0<9}").parse().ok()?;
        let seconds: i64 = whole.parse().ok().filter(|_| is_number)?;
        seconds.checked_mul(1_000_000_000)?.checked_add(nanos)
    };
    let reason = || format!("`{cell}` is no time in seconds");
    nanos()
        .map(Time::from_nanos)
        .ok_or_else(|| RecordingError::Format { reason: reason() })
}

fn malformed(error: csv::Error) -> RecordingError {
    let reason = error.to_string();
    if error.is_io_error() {
        return RecordingError::Unreadable { reason };
    }
    RecordingError::Format { reason }
}
