//! The thread that reads the topics of a node, if its owner has something to do after each message.
//!
//! Its tasks, one for each publisher of each topic, run in a runtime of one thread. Between messages, the thread leaves the
//! runtime to call the owner, whose code may block, or drop the node.

use std::io;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use tokio::runtime::{Builder, Handle};

use crate::context::Context;

/// The thread that reads the topics.
pub(crate) struct TopicReader {
    /// For the tasks that read.
    pub(crate) tasks: Handle,
    context: Arc<Context>,
    thread: Option<JoinHandle<()>>,
}

impl TopicReader {
    /// Starts the thread; `None` if nobody has something to do after reading.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub(crate) fn of(context: &Arc<Context>) -> io::Result<Option<Self>> {
        let Some(after_reading) = context.settings.after_reading.clone() else {
            return Ok(None);
        };
        let runtime = Builder::new_current_thread().enable_all().build()?;
        let (tasks, of_node) = (runtime.handle().clone(), Arc::clone(context));
        let read = move || {
            while runtime.block_on(of_node.has_read()) {
                after_reading();
            }
            runtime.shutdown_timeout(Duration::from_millis(100));
        };
        let thread = std::thread::Builder::new().name("ros topics".to_owned());
        Ok(Some(Self {
            tasks,
            context: Arc::clone(context),
            thread: Some(thread.spawn(read)?),
        }))
    }
}

/// Ends the node, and waits for the thread. Where the thread itself drops the node, it ends later.
impl Drop for TopicReader {
    fn drop(&mut self) {
        self.context.end();
        if let Some(thread) = self.thread.take()
            && thread.thread().id() != std::thread::current().id()
        {
            // ends with a panic if the owner's function panicked
            let _ = thread.join();
        }
    }
}
