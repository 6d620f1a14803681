//! Ctrl-C during a verification.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by the handler, read by the exploration.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Installs the handler: the first Ctrl-C ends the exploration, the second one the process.
pub fn install() {
    // without the handler, Ctrl-C ends the process at once; a process installs it once
    let _ = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        let _ = writeln!(anstream::stderr(), "\n    Stopping (Ctrl-C again to abort)");
    });
}

/// Returns `true` after the first Ctrl-C.
pub fn has_occurred() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}
