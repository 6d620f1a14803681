//! Lines of the supervised processes in the output of `asmotion up`, with the name of their process.

use std::io::{BufRead, BufReader, Read};
use std::process::Child;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::terminal::{NAME, print_progress, print_result};

/// Interval at which the ends of outputs are polled.
const LOOK: Duration = Duration::from_millis(10);

/// The threads that read the outputs of one process. They always read, so that no process waits for the reader of this one.
#[derive(Default)]
pub(super) struct Relay {
    threads: Vec<JoinHandle<()>>,
}

impl Relay {
    /// Prints each line of the outputs of a process, after its name and `|`.
    pub(super) fn start(name: &str, width: usize, child: &mut Child) -> Self {
        let prefix = format!("{NAME}{name:width$}{NAME:#} | ");
        let (out, err) = (child.stdout.take(), child.stderr.take());
        let out = out.and_then(|it| relay(it, prefix.clone(), print_result));
        let err = err.and_then(|it| relay(it, prefix, print_progress));
        Self {
            threads: out.into_iter().chain(err).collect(),
        }
    }

    /// Waits until the outputs have ended, at most until this instant: a program that the process leaves behind keeps them open.
    pub(super) fn finish(&self, until: Instant) {
        while Instant::now() < until && !self.threads.iter().all(JoinHandle::is_finished) {
            thread::sleep(LOOK);
        }
    }
}

/// Starts a thread that prints the lines of an output. Without a thread, the output is closed, and its process goes on.
fn relay(
    output: impl Read + Send + 'static,
    prefix: String,
    print: fn(String),
) -> Option<JoinHandle<()>> {
    let read = move || {
        // other programs write to the output, too, in any encoding
        for line in BufReader::new(output).split(b'\n').map_while(Result::ok) {
            let line = String::from_utf8_lossy(&line);
            print(format!("{prefix}{}", line.trim_end()));
        }
    };
    thread::Builder::new().spawn(read).ok()
}
