//! What a run writes down in files: its trace, and the table of its ports.

use std::fs::File;
use std::io;

use asmotion_component::{Event, Time};
use clap::Args;

use crate::record::Record;
use crate::trace::Trace;

/// Which files are wanted.
#[derive(Args, Clone, Default)]
pub struct Wanted {
    /// Writes down what happened, line by line: the same run gives the same bytes.
    #[arg(long, value_name = "FILE")]
    trace: Option<String>,

    /// Writes what ports published as a table (CSV): a row an instant, a column a number, named
    /// `Component.port.field`.
    #[arg(long, value_name = "FILE")]
    record: Option<String>,

    /// Records the ports or topics of this name, in which `*` is any run of characters; without it, all.
    #[arg(long, value_name = "PATTERN", requires = "record")]
    ports: Vec<String>,
}

/// The books, while they are written.
#[derive(Debug, Default)]
pub struct Books {
    trace: Option<(String, Trace)>,
    record: Option<(String, Record)>,
}

impl Wanted {
    /// Opens the books that are wanted.
    pub fn open(&self) -> Books {
        let trace = self.trace.clone();
        let record = self.record.clone();
        Books {
            trace: trace.map(|path| (path, Trace::new())),
            record: record.map(|path| (path, Record::of(&self.ports))),
        }
    }
}

impl Books {
    /// Takes in an event.
    pub fn note(&mut self, at: Time, event: &Event<'_>) {
        if let Some((_, trace)) = &mut self.trace {
            trace.note(at, event);
        }
        if let Some((_, record)) = &mut self.record {
            record.note(at, event);
        }
    }

    /// Writes the files; the patterns of ports that published nothing.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn close(&self) -> Result<Vec<&str>, String> {
        if let Some((path, trace)) = &self.trace {
            std::fs::write(path, trace.text()).map_err(|error| cannot(path, error))?;
        }
        let Some((path, record)) = &self.record else {
            return Ok(Vec::new());
        };
        let file = File::create(path).map_err(|error| cannot(path, error))?;
        let written = record.write(io::BufWriter::new(file));
        written.map_err(|error| cannot(path, error))?;
        Ok(record.silent().collect())
    }
}

fn cannot(path: &str, error: impl std::fmt::Display) -> String {
    format!("cannot write `{path}`: {error}")
}
