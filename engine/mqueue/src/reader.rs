//! The receiving end of a queue: an input port to which an Orocos component writes.

use std::sync::Arc;
use std::thread;
use std::time::Duration;

use asmotion_datum::{Datum, DatumError, Sample};
use asmotion_runtime::Source;

use crate::layout::QueueLayout;
use crate::name::QueueName;
use crate::queue::KernelQueue;
use crate::writer::to_datum_error;

/// The meaning of the first message in a queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FirstMessage {
    /// A sample that only shows the layout, as RTT sends it; not data.
    Shape,
    /// Data, like all following messages.
    Data,
}

/// Reads messages. The writer creates the queue; the reader searches for it until it exists, and again when it has been
/// removed.
pub struct QueueReader {
    name: QueueName,
    layout: QueueLayout,
    first: FirstMessage,
    queue: Option<OpenQueue>,
    /// The last problem of the search, so that it is reported once.
    problem: Option<DatumError>,
}

struct OpenQueue {
    queue: KernelQueue,
    buffer: Vec<u8>,
    /// No message has been read from it.
    is_first: bool,
}

/// Period of the search for a queue.
const SEARCH: Duration = Duration::from_millis(50);

impl QueueReader {
    /// Creates a reader. The queue need not exist yet.
    pub fn new(name: QueueName, layout: QueueLayout, first: FirstMessage) -> Self {
        Self {
            name,
            layout,
            first,
            queue: None,
            problem: None,
        }
    }

    /// Waits up to `timeout` for the next message. Returns `None` if there is none.
    pub fn next(&mut self, timeout: Duration) -> Option<Result<Datum, DatumError>> {
        let Some(open) = &mut self.queue else {
            return self.open_queue(timeout).map(Err);
        };
        let mut read = open.read();
        if read == Ok(None) {
            open.queue.wait(timeout);
            read = open.read();
        }
        match read {
            Ok(Some(bytes)) => {
                let is_first = std::mem::replace(&mut open.is_first, false);
                let message = self.layout.decode(open.buffer.get(..bytes).unwrap_or(&[]));
                match (message, self.first) {
                    (Ok(_), FirstMessage::Shape) if is_first => None,
                    (message, _) => Some(message),
                }
            }
            Ok(None) => {
                if open.queue.is_unlinked() {
                    self.queue = None;
                }
                None
            }
            Err(problem) => {
                self.queue = None;
                Some(Err(problem))
            }
        }
    }

    /// Searches for the queue. Returns a problem if it differs from the previous one.
    fn open_queue(&mut self, timeout: Duration) -> Option<DatumError> {
        match KernelQueue::open_existing(&self.name) {
            Ok(Some(queue)) => {
                self.problem = None;
                self.queue = Some(OpenQueue {
                    buffer: vec![0; queue.size()],
                    queue,
                    is_first: true,
                });
                None
            }
            Ok(None) => {
                thread::sleep(timeout.min(SEARCH));
                None
            }
            Err(problem) => {
                thread::sleep(timeout.min(SEARCH));
                let problem = to_datum_error(problem);
                let previous = self.problem.replace(problem.clone());
                (previous.as_ref() != Some(&problem)).then_some(problem)
            }
        }
    }
}

impl OpenQueue {
    fn read(&mut self) -> Result<Option<usize>, DatumError> {
        self.queue.pop(&mut self.buffer).map_err(to_datum_error)
    }
}

impl Source for QueueReader {
    fn name(&self) -> String {
        self.name.to_string()
    }

    fn next(&mut self, at_most: Duration) -> Option<Result<Arc<dyn Sample>, DatumError>> {
        let message = QueueReader::next(self, at_most)?;
        Some(message.map(|datum| Arc::new(datum) as Arc<dyn Sample>))
    }
}
