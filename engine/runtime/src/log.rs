//! An in-memory log of a run, for tests and inspection.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use asmotion_datum::{Message, Sample};
use asmotion_port::Time;

use crate::event::{Event, Observer};

/// An observer that keeps all events. Clones share the log: pass one to the system and keep another.
#[derive(Debug, Clone, Default)]
pub struct Log {
    entries: Arc<Mutex<Vec<LogEntry>>>,
}

#[derive(Debug)]
struct LogEntry {
    at: Time,
    line: String,
    published: Option<(String, Arc<dyn Sample>)>,
}

impl Log {
    /// Creates an empty log.
    pub fn new() -> Self {
        Self::default()
    }

    /// All events as lines: `0.05 s Follower.twist #1 = {…}`.
    pub fn lines(&self) -> Vec<String> {
        let entries = self.entries();
        entries
            .iter()
            .map(|entry| format!("{} {}", entry.at, entry.line))
            .collect()
    }

    /// The lines that contain this text.
    pub fn lines_with(&self, text: &str) -> Vec<String> {
        let mut lines = self.lines();
        lines.retain(|line| line.contains(text));
        lines
    }

    /// The samples that left an output, `component.port`, with their times. Samples of another type are left out.
    pub fn samples<T: Message>(&self, output: &str) -> Vec<(Time, T)> {
        let entries = self.entries();
        let of_output = entries.iter().filter_map(|entry| {
            let (name, sample) = entry.published.as_ref()?;
            let sample = (name == output).then(|| Arc::clone(sample).read())?;
            Some((entry.at, sample.ok()?))
        });
        of_output.collect()
    }

    fn entries(&self) -> MutexGuard<'_, Vec<LogEntry>> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for Log {
    fn observe(&mut self, at: Time, event: &Event<'_>) {
        let mut published = None;
        if let Event::Published {
            component,
            port,
            sample,
            ..
        } = event
        {
            published = Some((format!("{component}.{port}"), sample.to_shared()));
        }
        self.entries().push(LogEntry {
            at,
            line: event.to_string(),
            published,
        });
    }
}
