//! `--top`: a run, and beside it the monitor, in one process.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use asmotion_remote::Remote;

use crate::broker;
use crate::mission::{Brokers, Mission};
use crate::top;

/// Somebody who looks on.
pub struct Spectator {
    remote: Remote,
    place: String,
}

/// Who looks on while a mission runs, if somebody wants to.
///
/// # Errors
/// There is no terminal, or the broker does not let us.
pub fn spectator(wanted: bool, mission: &Mission) -> Result<Option<Spectator>, String> {
    if !wanted {
        return Ok(None);
    }
    if !std::io::stdout().is_terminal() {
        return Err("`--top` draws on a terminal: a program may take `--json` instead".to_owned());
    }
    let settings = match &mission.brokers {
        Brokers::Nothing => return Ok(None),
        Brokers::Inside(bus) => {
            let remote = Remote::over(Arc::new(bus.clone()), None);
            let remote = remote.map_err(|error| error.to_string())?;
            let place = "this process".to_owned();
            return Ok(Some(Spectator { remote, place }));
        }
        Brokers::One(settings) => Some(&**settings),
        // one of several: the systems of the others have monitors of their own
        Brokers::Each(brokers) => brokers.values().next(),
    };
    let Some(settings) = settings else {
        return Ok(None);
    };
    let place = settings.place();
    let mut settings = settings.clone();
    settings.robot = None;
    let remote = broker::remote(settings)?;
    Ok(Some(Spectator { remote, place }))
}

impl Spectator {
    /// Runs something, and shows it until a key ends both. When it has run to its end, what was last seen stays until then;
    /// when it has not even begun, there is nothing to see.
    pub fn beside<T: Send, E: Send>(
        &self,
        stop: &AtomicBool,
        run: impl FnOnce() -> Result<T, E> + Send,
    ) -> Result<T, E> {
        std::thread::scope(|scope| {
            let running =
                scope.spawn(|| run().inspect_err(|_| stop.store(true, Ordering::Relaxed)));
            // a screen that cannot be drawn on is no reason not to run
            if top::show(&self.remote, &self.place, stop).is_ok() {
                stop.store(true, Ordering::Relaxed);
            }
            match running.join() {
                Ok(end) => end,
                Err(panic) => std::panic::resume_unwind(panic),
            }
        })
    }
}
