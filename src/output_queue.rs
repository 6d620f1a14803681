//! Output that never waits for its reader: a queue of lines, which a thread writes.
//!
//! A pipe that nobody reads is full after 64 KiB, and the next write to it waits. A run in real time must not: its components go
//! on, and presence and orders are due. So it drops lines while the queue is full, counts them, and says how many are missing
//! where they would stand.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Size in bytes from which a queue takes no more lines.
const FULL: usize = 1 << 20;
/// Time without any progress after which a reader is not waited for at the end.
const PATIENCE: Duration = Duration::from_secs(5);

/// The lines on their way to an output.
pub struct OutputQueue {
    shared: Arc<SharedQueue>,
}

struct SharedQueue {
    state: Mutex<QueueState>,
    /// There is something to write.
    filled: Condvar,
    /// A line has been written.
    written: Condvar,
    /// The line in place of a number of dropped lines.
    missing: fn(u64) -> String,
}

#[derive(Default)]
struct QueueState {
    lines: VecDeque<String>,
    /// Size of the lines, in bytes.
    bytes: usize,
    /// Number of lines dropped since the last one in the queue. No line follows before the writer has said so.
    dropped: u64,
    /// A line is being written.
    is_writing: bool,
    /// Number of lines written.
    written: u64,
    /// The reader did not read at the end: nothing is written any more.
    is_abandoned: bool,
    /// First error of writing, other than a closed pipe.
    error: Option<io::Error>,
}

impl OutputQueue {
    /// Starts the thread that writes to `output`. `missing` is the line in place of a number of dropped lines.
    ///
    /// # Errors
    /// Fails if the operating system has no thread left.
    pub fn start(
        name: &str,
        output: impl Write + Send + 'static,
        missing: fn(u64) -> String,
    ) -> io::Result<Self> {
        let shared = Arc::new(SharedQueue {
            state: Mutex::default(),
            filled: Condvar::new(),
            written: Condvar::new(),
            missing,
        });
        let writer = shared.clone();
        thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || writer.write_all(output))?;
        Ok(Self { shared })
    }

    /// Adds a line, or drops and counts it if the queue is full.
    pub fn push(&self, line: String) {
        let mut state = self.shared.lock();
        if state.dropped > 0 || state.bytes >= FULL {
            state.dropped += 1;
        } else {
            state.add(line);
        }
        self.shared.filled.notify_one();
    }

    /// Adds a line that matters more than others, such as a part of the summary: also to a queue that is full for others.
    pub fn push_important(&self, line: String) {
        let mut state = self.shared.lock();
        if state.bytes < 2 * FULL {
            if let Some(count) = state.take_dropped() {
                state.add((self.shared.missing)(count));
            }
            state.add(line);
        } else {
            state.dropped += 1;
        }
        self.shared.filled.notify_one();
    }

    /// Waits until all lines are written, as long as the reader goes on reading. Afterwards, without a reader, nothing is
    /// written any more.
    ///
    /// # Errors
    /// The first error of writing since the last call, other than a closed pipe, or that nobody read the output.
    pub fn finish(&self) -> io::Result<()> {
        self.settle();
        self.shared.lock().error.take().map_or(Ok(()), Err)
    }

    /// Waits as [`finish`](Self::finish) does, and keeps its error for later.
    pub fn settle(&self) {
        let mut state = self.shared.lock();
        let mut until = Instant::now() + PATIENCE;
        while !state.is_abandoned && !state.is_idle() {
            let (known, left) = (
                state.written,
                until.saturating_duration_since(Instant::now()),
            );
            if left.is_zero() {
                state.is_abandoned = true;
                let lines = state.lines.len() as u64 + u64::from(state.is_writing) + state.dropped;
                let problem = format!("nobody read the last {lines} lines within {PATIENCE:?}");
                state.error = Some(io::Error::new(io::ErrorKind::TimedOut, problem));
                break;
            }
            let waited = self.shared.written.wait_timeout(state, left);
            (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
            if state.written != known {
                until = Instant::now() + PATIENCE;
            }
        }
    }
}

impl SharedQueue {
    fn lock(&self) -> MutexGuard<'_, QueueState> {
        // its changes are complete even if a thread panicked while it held the lock
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes the lines, for as long as the process lasts.
    fn write_all(&self, mut output: impl Write) {
        loop {
            let line = self.next_line();
            let result = output
                .write_all(line.as_bytes())
                .and_then(|()| output.flush());
            let mut state = self.lock();
            state.is_writing = false;
            state.written += 1;
            if let Err(error) = result
                && error.kind() != io::ErrorKind::BrokenPipe
            {
                state.error.get_or_insert(error);
            }
            self.written.notify_all();
        }
    }

    /// Waits for the next line.
    fn next_line(&self) -> String {
        let mut state = self.lock();
        loop {
            if state.lines.is_empty()
                && let Some(count) = state.take_dropped()
            {
                state.add((self.missing)(count));
            }
            if let Some(line) = state.lines.pop_front().filter(|_| !state.is_abandoned) {
                state.bytes -= line.len();
                state.is_writing = true;
                return line;
            }
            let waited = self.filled.wait(state);
            state = waited.unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl QueueState {
    fn add(&mut self, mut line: String) {
        line.push('\n');
        self.bytes += line.len();
        self.lines.push_back(line);
    }

    fn take_dropped(&mut self) -> Option<u64> {
        let dropped = std::mem::take(&mut self.dropped);
        (dropped > 0).then_some(dropped)
    }

    fn is_idle(&self) -> bool {
        self.lines.is_empty() && self.dropped == 0 && !self.is_writing
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, Sender, channel};

    use super::*;

    /// An output that waits for its reader before each line.
    struct Gate {
        permits: Receiver<()>,
        lines: Sender<String>,
    }

    impl Write for Gate {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            // a reader that has closed the gate
            let closed = |_| io::Error::from(io::ErrorKind::BrokenPipe);
            self.permits.recv().map_err(closed)?;
            let _ = self.lines.send(String::from_utf8(bytes.to_vec()).unwrap());
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn missing(count: u64) -> String {
        format!("missing {count}")
    }

    fn gate() -> (OutputQueue, Sender<()>, Receiver<String>) {
        let (permit, permits) = channel();
        let (lines, written) = channel();
        let queue = OutputQueue::start("gate", Gate { permits, lines }, missing);
        (queue.unwrap(), permit, written)
    }

    #[test]
    fn lines_that_do_not_fit_are_counted_where_they_would_stand() {
        let (queue, permit, written) = gate();
        let line = "x".repeat(FULL / 4);
        // one of them is on its way to the reader
        queue.push("first".to_owned());
        while !queue.shared.lock().is_writing {
            thread::yield_now();
        }
        (0..10).for_each(|_| queue.push(line.clone()));
        (0..6).for_each(|_| permit.send(()).unwrap());
        let read: Vec<_> = (0..6).map(|_| written.recv().unwrap()).collect();
        assert_eq!(read[0], "first\n");
        assert!(read[1..5].iter().all(|it| it.trim_end() == line));
        assert_eq!(read[5], "missing 6\n");
        queue.push("next".to_owned());
        permit.send(()).unwrap();
        assert_eq!(written.recv().unwrap(), "next\n");
        assert!(queue.finish().is_ok());
    }

    #[test]
    fn the_summary_is_in_the_output_even_if_the_queue_is_full() {
        let (queue, permit, written) = gate();
        let line = "x".repeat(FULL);
        (0..3).for_each(|_| queue.push(line.clone()));
        queue.push_important("summary".to_owned());
        let reader = thread::spawn(move || {
            let lines = std::iter::from_fn(|| {
                permit.send(()).ok()?;
                written.recv_timeout(Duration::from_secs(1)).ok()
            });
            lines.collect::<Vec<_>>()
        });
        assert!(queue.finish().is_ok());
        let read = reader.join().unwrap();
        let [.., gap, summary] = &read[..] else {
            panic!("{} lines", read.len());
        };
        assert!(gap.starts_with("missing "), "{gap}");
        assert_eq!(summary, "summary\n");
    }

    #[test]
    fn an_output_that_nobody_reads_does_not_keep_the_process() {
        let (queue, permit, _written) = gate();
        (0..3).for_each(|_| queue.push("line".to_owned()));
        let error = queue.finish().unwrap_err();
        assert_eq!(error.to_string(), "nobody read the last 3 lines within 5s");
        // it was reported, and is not waited for again
        assert!(queue.finish().is_ok());
        drop(permit);
    }

    #[test]
    fn a_closed_output_is_no_error() {
        let (queue, permit, _written) = gate();
        drop(permit);
        (0..3).for_each(|_| queue.push("line".to_owned()));
        assert!(queue.finish().is_ok());
    }
}
