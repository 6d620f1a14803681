//! The receiving end of a queue: an input port of ours that an Orocos component writes to.

use std::sync::Arc;
use std::thread;
use std::time::Duration;

use asmotion_datum::{Datum, DatumError, Sample};
use asmotion_runtime::Source;

use crate::layout::QueueLayout;
use crate::name::QueueName;
use crate::queue::KernelQueue;
use crate::writer::told;

/// What the first message of a queue is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FirstMessage {
    /// A sample that shows the reader what samples are like, as RTT sends it: no data.
    Shape,
    /// Data, like those after it.
    Data,
}

/// Reads messages. The writer makes the queue; as long as there is none, and when it was removed, one is looked for.
pub struct QueueReader {
    name: QueueName,
    layout: QueueLayout,
    first: FirstMessage,
    queue: Option<OpenQueue>,
    /// What was wrong the last time a queue was looked for, so that it is told once.
    problem: Option<DatumError>,
}

struct OpenQueue {
    queue: KernelQueue,
    buffer: Vec<u8>,
    /// Whether nothing was read from it.
    fresh: bool,
}

/// How often a queue is looked for.
const SEARCH: Duration = Duration::from_millis(50);

impl QueueReader {
    /// A reader of a queue that need not be there yet.
    pub fn new(name: QueueName, layout: QueueLayout, first: FirstMessage) -> Self {
        Self {
            name,
            layout,
            first,
            queue: None,
            problem: None,
        }
    }

    /// The next message, waited for so long at most. `None` if none came.
    pub fn next(&mut self, at_most: Duration) -> Option<Result<Datum, DatumError>> {
        let Some(open) = &mut self.queue else {
            return self.search(at_most).map(Err);
        };
        let mut read = open.read();
        if read == Ok(None) {
            open.queue.wait(at_most);
            read = open.read();
        }
        match read {
            Ok(Some(bytes)) => {
                let fresh = std::mem::replace(&mut open.fresh, false);
                let message = self.layout.decode(open.buffer.get(..bytes).unwrap_or(&[]));
                match (message, self.first) {
                    (Ok(_), FirstMessage::Shape) if fresh => None,
                    (message, _) => Some(message),
                }
            }
            Ok(None) => {
                if open.queue.is_gone() {
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

    /// Looks for the queue; a problem that is new is told.
    fn search(&mut self, at_most: Duration) -> Option<DatumError> {
        match KernelQueue::find(&self.name) {
            Ok(Some(queue)) => {
                self.problem = None;
                self.queue = Some(OpenQueue {
                    buffer: vec![0; queue.size()],
                    queue,
                    fresh: true,
                });
                None
            }
            Ok(None) => {
                thread::sleep(at_most.min(SEARCH));
                None
            }
            Err(problem) => {
                thread::sleep(at_most.min(SEARCH));
                let problem = told(problem);
                let known = self.problem.replace(problem.clone());
                (known.as_ref() != Some(&problem)).then_some(problem)
            }
        }
    }
}

impl OpenQueue {
    fn read(&mut self) -> Result<Option<usize>, DatumError> {
        self.queue.pop(&mut self.buffer).map_err(told)
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
