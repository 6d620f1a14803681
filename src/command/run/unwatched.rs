//! Replacement for `--top` in a build without the feature `tui`.

use std::sync::atomic::AtomicBool;

use crate::feature::{LeftOut, Tui};
use crate::mission::Mission;

/// The monitor of a run: this build has none.
pub enum Spectator {}

/// Returns `None`.
///
/// # Errors
/// Fails if the monitor is requested; the message names the feature.
pub fn spectator(is_requested: bool, _: &Mission) -> Result<Option<Spectator>, String> {
    if is_requested {
        Err(format!("`--top`: {}", LeftOut::new::<Tui>()))
    } else {
        Ok(None)
    }
}

impl Spectator {
    /// Never called: there is no monitor.
    pub fn run_beside<T, E>(
        &self,
        _: &AtomicBool,
        _: impl FnOnce() -> Result<T, E>,
        _: impl FnOnce(&T) -> String,
    ) -> Result<T, E> {
        match *self {}
    }
}
