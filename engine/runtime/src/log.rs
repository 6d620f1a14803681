//! A log of a run in memory, for tests and for looking back.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use asmotion_datum::{Message, Sample};
use asmotion_port::Time;

use crate::event::{Event, Observer};

/// An observer that keeps what happened. Clones share it: give one to the system, keep one.
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
    /// An empty log.
    pub fn new() -> Self {
        Self::default()
    }

    /// Every event as a line: `0.05 s Follower.twist #1 = {…}`.
    pub fn lines(&self) -> Vec<String> {
        let entries = self.entries();
        (entries.iter())
            .map(|entry| format!("{} {}", entry.at, entry.line))
            .collect()
    }

    /// The lines that contain a text.
    pub fn lines_with(&self, text: &str) -> Vec<String> {
        let mut lines = self.lines();
        lines.retain(|line| line.contains(text));
        lines
    }

    /// What left an output, `Component.port`, and when.
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
