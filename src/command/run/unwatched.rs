//! What stands for `--top` in a build without the monitor.

use std::sync::atomic::AtomicBool;

use crate::feature::{LeftOut, Tui};
use crate::mission::Mission;

/// Somebody who looks on: in this build nobody.
pub enum Spectator {}

/// Nobody, or the way to get the monitor.
///
/// # Errors
/// One is wanted.
pub fn spectator(wanted: bool, _: &Mission) -> Result<Option<Spectator>, String> {
    match wanted {
        true => Err(format!("`--top`: {}", LeftOut::new::<Tui>())),
        false => Ok(None),
    }
}

impl Spectator {
    /// Never called: nobody looks on.
    pub fn beside<T, E>(&self, _: &AtomicBool, _: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        match *self {}
    }
}
