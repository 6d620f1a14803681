//! `--watch`: verifies again after each change of a file.

use super::watched_results::WatchedResults;
use super::{Verify, interrupt};
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use std::time::Duration;

/// Time between two looks at the files.
const INTERVAL: Duration = Duration::from_millis(200);

/// Number of looks at files that are being written or missing, each after half of the interval.
const LOOKS: usize = 20;

impl Verify {
    /// Verifies again and again until Ctrl-C; returns the exit code of the last verification.
    pub(super) fn watch(
        &self,
        paths: &str,
        terminal: &mut TerminalOutput,
        mut verify: impl FnMut(&mut WatchedResults, &mut TerminalOutput) -> Exit,
    ) -> Exit {
        let mut results = WatchedResults::of_repeated();
        loop {
            self.files.forget();
            let exit = verify(&mut results, terminal);
            terminal.status("Watching", format_args!("{paths} (Ctrl-C ends)"));
            if self.wait_for_change() {
                return exit;
            }
        }
    }

    /// Waits until a file has changed; returns `true` after Ctrl-C.
    fn wait_for_change(&self) -> bool {
        loop {
            if interrupt::has_occurred() {
                return true;
            }
            if self.files.have_changed() {
                self.wait_until_written();
                // a file may be back as it was
                if self.files.have_changed() {
                    return interrupt::has_occurred();
                }
            }
            std::thread::sleep(INTERVAL);
        }
    }

    /// Waits until an editor has written its files: until all of them are there and no longer change, but not for long.
    fn wait_until_written(&self) {
        let mut before = self.files.look();
        for _ in 0..LOOKS {
            std::thread::sleep(INTERVAL / 2);
            let now = self.files.look();
            if interrupt::has_occurred() || now == before && !self.files.are_missing(&now) {
                return;
            }
            before = now;
        }
    }
}
