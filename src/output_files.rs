//! Files written during a run: the trace and the table of port values.

use std::fs::File;
use std::io;

use asmotion_component::Time;
use asmotion_recording::PortRecording;
use asmotion_runtime::Event;
use clap::Args;

use crate::trace::MissionTrace;

/// Options that select the files to write.
#[derive(Args, Clone, Default)]
pub struct OutputArguments {
    /// Writes a trace of the run, one event a line; equal runs give equal bytes
    #[arg(long, value_name = "FILE")]
    trace: Option<String>,

    /// Writes the values of ports as a table (CSV): a row for each instant, a column for each number, named
    /// `Component.port.field`
    #[arg(long, value_name = "FILE")]
    record: Option<String>,

    /// Ports or topics to record; `*` matches any characters [default: all]
    #[arg(long, value_name = "PATTERN", requires = "record")]
    ports: Vec<String>,
}

/// The files being written.
#[derive(Debug, Default)]
pub struct OutputFiles {
    trace: Option<(String, MissionTrace)>,
    record: Option<(String, PortRecording)>,
}

impl OutputArguments {
    /// Creates the requested files in memory.
    pub fn open(&self) -> OutputFiles {
        let trace = self.trace.clone();
        let record = self.record.clone();
        OutputFiles {
            trace: trace.map(|path| (path, MissionTrace::new())),
            record: record.map(|path| (path, PortRecording::of(&self.ports))),
        }
    }
}

impl OutputFiles {
    /// Records an event.
    pub fn note(&mut self, at: Time, event: &Event<'_>) {
        if let Some((_, trace)) = &mut self.trace {
            trace.note(at, event);
        }
        if let Some((_, record)) = &mut self.record {
            record.note(at, event);
        }
    }

    /// Writes the files. Returns the patterns of ports that published nothing.
    ///
    /// # Errors
    /// Fails if a file cannot be written.
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
        Ok(record.unmatched_patterns().collect())
    }
}

fn cannot(path: &str, error: impl std::fmt::Display) -> String {
    format!("cannot write `{path}`: {error}")
}
