//! The queue between the recorder and the thread that writes: bounded by the bytes that wait.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use asmotion_viewer_encoding::ChannelSchema;

use super::options::Overflow;

/// Capacity of the queue, in bytes of messages.
const CAPACITY: usize = 64 << 20;

/// Number of bytes at which the writer is woken before its time.
const URGENT: usize = CAPACITY / 4;

/// Work for the writer.
#[derive(Debug)]
pub(super) enum WriterJob {
    /// A message of a channel.
    Message {
        channel: u32,
        /// Time of the run, in nanoseconds.
        at_ns: u64,
        sequence: u32,
        data: Vec<u8>,
    },
    /// Describes the channel with this number, before its first message.
    Channel { channel: u32, about: ChannelAbout },
    /// A text to attach.
    Attachment { text: AttachedText },
}

/// A text that belongs to a recording.
#[derive(Clone, Debug)]
pub(super) struct AttachedText {
    pub name: String,
    pub text: String,
    /// Time of the run from which on it holds, in nanoseconds.
    pub at_ns: u64,
}

/// The description of a channel.
#[derive(Clone, Debug)]
pub(super) struct ChannelAbout {
    pub topic: String,
    pub schema: ChannelSchema,
    pub facts: Vec<(&'static str, String)>,
}

impl WriterJob {
    fn size(&self) -> usize {
        const OVERHEAD: usize = 64;
        OVERHEAD
            + match self {
                Self::Message { data, .. } => data.len(),
                Self::Channel { about, .. } => about.schema.definition().len(),
                Self::Attachment { text } => text.text.len(),
            }
    }
}

/// Jobs on their way to the writer.
#[derive(Debug)]
pub(super) struct JobQueue {
    overflow: Overflow,
    state: Mutex<QueueState>,
    /// Notified when the writer is to look before its time.
    is_urgent: Condvar,
    /// Notified when the writer has taken jobs.
    has_room: Condvar,
}

#[derive(Debug, Default)]
struct QueueState {
    jobs: VecDeque<WriterJob>,
    bytes: usize,
    is_closed: bool,
    /// The writer has ended and takes nothing any more.
    is_abandoned: bool,
}

/// The jobs that the writer has taken.
pub(super) struct TakenJobs {
    pub jobs: VecDeque<WriterJob>,
    /// No further jobs will come.
    pub is_last: bool,
}

impl JobQueue {
    pub fn new(overflow: Overflow) -> Self {
        Self {
            overflow,
            state: Mutex::default(),
            is_urgent: Condvar::new(),
            has_room: Condvar::new(),
        }
    }

    /// Adds a message. Returns `false` if there is no room for it, and it is lost.
    pub fn push(&self, job: WriterJob) -> bool {
        let size = job.size();
        let mut state = self.lock();
        while state.bytes + size > CAPACITY && !state.is_abandoned {
            match self.overflow {
                Overflow::Count => return false,
                Overflow::Wait if state.jobs.is_empty() => break,
                Overflow::Wait => {
                    self.is_urgent.notify_one();
                    let waited = self.has_room.wait(state);
                    state = waited.unwrap_or_else(PoisonError::into_inner);
                }
            }
        }
        self.add(job, size, state)
    }

    /// Adds a job without which later messages would be meaningless. There are few of them.
    pub fn push_always(&self, job: WriterJob) {
        let size = job.size();
        let state = self.lock();
        self.add(job, size, state);
    }

    fn add(&self, job: WriterJob, size: usize, mut state: MutexGuard<'_, QueueState>) -> bool {
        if state.is_abandoned {
            return false;
        }
        state.jobs.push_back(job);
        let was_urgent = state.bytes >= URGENT;
        state.bytes += size;
        if state.bytes >= URGENT && !was_urgent {
            self.is_urgent.notify_one();
        }
        true
    }

    /// Ends the queue: the writer takes what is in it, and ends.
    pub fn close(&self) {
        self.lock().is_closed = true;
        self.is_urgent.notify_one();
    }

    /// Refuses all further jobs: the writer has ended.
    pub fn abandon(&self) {
        let mut state = self.lock();
        state.is_abandoned = true;
        state.jobs.clear();
        self.has_room.notify_all();
    }

    /// Takes all jobs, at the latest after this time. The writer looks in intervals, because waking it for each message would cost
    /// the other thread more than the message itself.
    pub fn take(&self, after: Duration) -> TakenJobs {
        let state = self.lock();
        let is_idle = |state: &mut QueueState| state.bytes < URGENT && !state.is_closed;
        let waited = self.is_urgent.wait_timeout_while(state, after, is_idle);
        let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let jobs = std::mem::take(&mut state.jobs);
        state.bytes = 0;
        self.has_room.notify_all();
        TakenJobs {
            jobs,
            is_last: state.is_closed,
        }
    }

    fn lock(&self) -> MutexGuard<'_, QueueState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn message(size: usize) -> WriterJob {
        WriterJob::Message {
            channel: 0,
            at_ns: 0,
            sequence: 0,
            data: vec![0; size],
        }
    }

    #[test]
    fn a_full_queue_refuses_messages_in_real_time_and_takes_descriptions() {
        let queue = JobQueue::new(Overflow::Count);
        let third = CAPACITY / 3;
        let taken = (0..4)
            .map(|_| queue.push(message(third)))
            .collect::<Vec<_>>();
        assert_eq!(taken, [true, true, false, false]);
        queue.push_always(message(third));
        assert_eq!(queue.take(Duration::ZERO).jobs.len(), 3);
        assert!(queue.push(message(third)), "there is room again");
    }

    #[test]
    fn a_full_queue_waits_for_the_writer_in_simulated_time() {
        let queue = Arc::new(JobQueue::new(Overflow::Wait));
        let pushed = Arc::clone(&queue);
        let pusher =
            std::thread::spawn(move || (0..20).all(|_| pushed.push(message(CAPACITY / 3))));
        let mut count = 0;
        while count < 20 {
            count += queue.take(Duration::from_secs(10)).jobs.len();
        }
        assert!(pusher.join().expect("no panic"));
        // a message that is larger than the queue passes alone
        assert!(queue.push(message(CAPACITY)));
    }

    #[test]
    fn a_pusher_does_not_wait_for_a_writer_that_has_ended() {
        let queue = Arc::new(JobQueue::new(Overflow::Wait));
        let pushed = Arc::clone(&queue);
        let pusher = std::thread::spawn(move || {
            (0..20)
                .filter(|_| pushed.push(message(CAPACITY / 3)))
                .count()
        });
        std::thread::sleep(Duration::from_millis(20));
        queue.abandon();
        assert!(pusher.join().expect("no panic") < 20);
        assert!(!queue.push(message(1)));
    }
}
