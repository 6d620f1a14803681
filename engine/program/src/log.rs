//! The lines that a program prints.

use std::collections::VecDeque;
use std::io::{PipeReader, Read};

/// Greatest number of lines that wait for the component's next cycle; further ones are counted.
const WAITING: usize = 200;

/// Number of last lines that are shown when a program fails.
const LAST: usize = 5;

/// Longest line in bytes; a longer one is cut.
const LONGEST: usize = 500;

/// Number of bytes that are read at once.
const CHUNK: usize = 16 << 10;

/// Collects the standard output and standard error of a program.
///
/// Both are one pipe, so that lines keep their order. All that a program has written before a reply is in the pipe when the
/// reply arrives: reading both together makes lines as deterministic as the program.
pub(crate) struct ProgramLog {
    /// Does not block.
    pipe: PipeReader,
    unfinished: Vec<u8>,
    waiting: VecDeque<String>,
    /// Number of lines left out since the last call of `take`.
    left_out: u64,
    last: VecDeque<String>,
    has_ended: bool,
}

impl ProgramLog {
    pub(crate) fn new(pipe: PipeReader) -> Self {
        Self {
            pipe,
            unfinished: Vec::new(),
            waiting: VecDeque::new(),
            left_out: 0,
            last: VecDeque::new(),
            has_ended: false,
        }
    }

    /// The pipe, to wait for; `None` once no process can write to it any more.
    pub(crate) fn pipe(&self) -> Option<&PipeReader> {
        (!self.has_ended).then_some(&self.pipe)
    }

    /// Reads what is in the pipe, at most `chunks` chunks. Returns whether there may be more.
    pub(crate) fn read(&mut self, chunks: usize) -> bool {
        let mut bytes = [0; CHUNK];
        for _ in 0..chunks {
            match self.pipe.read(&mut bytes) {
                Ok(0) => {
                    self.has_ended = true;
                    self.finish_line();
                    return false;
                }
                Ok(count) => self.add(&bytes[..count]),
                // empty, or interrupted by a signal
                Err(_) => return false,
            }
        }
        true
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if *byte == b'\n' {
                self.finish_line();
            } else if self.unfinished.len() <= LONGEST {
                self.unfinished.push(*byte);
            }
        }
    }

    fn finish_line(&mut self) {
        let bytes = std::mem::take(&mut self.unfinished);
        let is_cut = bytes.len() > LONGEST;
        let line = String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST)]);
        let line: String = line.chars().filter(|it| !it.is_control()).collect();
        if line.trim().is_empty() {
            return;
        }
        let line = if is_cut { format!("{line}…") } else { line };
        if self.last.len() == LAST {
            self.last.pop_front();
        }
        self.last.push_back(line.clone());
        if self.waiting.len() < WAITING {
            self.waiting.push_back(line);
        } else {
            self.left_out += 1;
        }
    }

    /// Removes and returns up to `limit` lines, and the number of lines left out if there are any.
    pub(crate) fn take(&mut self, limit: usize) -> (Vec<String>, u64) {
        let count = self.waiting.len().min(limit);
        let lines = self.waiting.drain(..count).collect();
        // the rest is older than what the program prints next
        self.left_out += self.waiting.drain(..).len() as u64;
        (lines, std::mem::take(&mut self.left_out))
    }

    /// The last lines.
    pub(crate) fn last_lines(&self) -> Vec<String> {
        self.last.iter().cloned().collect()
    }
}
