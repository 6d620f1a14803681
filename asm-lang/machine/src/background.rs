//! A bounded number of threads that compile native code while closures execute steps.
//!
//! A process may have many machines, for instance one for each verification. A thread for each compilation would take the cores from the
//! steps that it is meant to accelerate.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Threads that compile at the same time, at most. A second one lets a small specification overtake a large one.
const MAX_WORKERS: usize = 2;

type Job = Box<dyn FnOnce() + Send>;

struct Queue {
    jobs: VecDeque<Job>,
    workers: usize,
}

static QUEUE: Mutex<Queue> = Mutex::new(Queue {
    jobs: VecDeque::new(),
    workers: 0,
});

/// Runs the job in a thread, in the order of the calls, as soon as fewer than [`MAX_WORKERS`] jobs are running.
///
/// A job is dropped if it is the only one and no thread can be started: closures continue.
pub(crate) fn run(job: Job) {
    let mut queue = queue();
    queue.jobs.push_back(job);
    if queue.workers == MAX_WORKERS {
        return;
    }
    queue.workers += 1;
    drop(queue);
    let name = "native-compiler".to_owned();
    if std::thread::Builder::new().name(name).spawn(work).is_err() {
        no_thread();
    }
}

/// Runs jobs until none is left. A panic ends its job alone.
fn work() {
    while let Some(job) = next() {
        drop(catch_unwind(AssertUnwindSafe(job)));
    }
}

/// Takes the next job. Without one, the worker is counted out in the same critical section, so that no job is left without a worker.
fn next() -> Option<Job> {
    let mut queue = queue();
    let job = queue.jobs.pop_front();
    if job.is_none() {
        queue.workers -= 1;
    }
    job
}

fn no_thread() {
    let mut queue = queue();
    queue.workers -= 1;
    if queue.workers == 0 {
        queue.jobs.clear();
    }
}

/// No code panics while the queue is locked.
fn queue() -> MutexGuard<'static, Queue> {
    QUEUE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::{MAX_WORKERS, run};
    use std::panic::resume_unwind;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc::channel;
    use std::time::Duration;

    static RUNNING: AtomicUsize = AtomicUsize::new(0);
    static MOST: AtomicUsize = AtomicUsize::new(0);

    #[test]
    fn all_jobs_run_and_few_at_a_time_although_some_panic() {
        let (done, ended) = channel();
        for index in 0..50 {
            let done = done.clone();
            run(Box::new(move || {
                let running = RUNNING.fetch_add(1, Ordering::SeqCst) + 1;
                MOST.fetch_max(running, Ordering::SeqCst);
                std::thread::sleep(Duration::from_millis(1));
                RUNNING.fetch_sub(1, Ordering::SeqCst);
                done.send(index).unwrap();
                if index % 7 == 0 {
                    resume_unwind(Box::new("a compiler that panics"));
                }
            }));
        }
        drop(done);
        let mut indices: Vec<i32> = ended.iter().collect();
        indices.sort_unstable();
        assert_eq!(indices, (0..50).collect::<Vec<_>>());
        assert!(MOST.load(Ordering::SeqCst) <= MAX_WORKERS);
    }
}
