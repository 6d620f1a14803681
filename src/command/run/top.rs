//! `--top`: runs a composite and shows the monitor beside it, in one process.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use asmotion_remote::Remote;

use crate::broker;
use crate::mission::{Mission, MissionBrokers};
use crate::top;

/// The monitor of a run.
pub struct Spectator {
    remote: Remote,
    location: String,
}

/// Creates the monitor of a mission if `is_requested` is set.
///
/// # Errors
/// Fails if standard output is not a terminal, or if the broker refuses the connection.
pub fn spectator(is_requested: bool, mission: &Mission) -> Result<Option<Spectator>, String> {
    if !is_requested {
        return Ok(None);
    }
    if !std::io::stdout().is_terminal() {
        return Err("`--top` needs a terminal; programs can use `--json`".to_owned());
    }
    let settings = match &mission.brokers {
        MissionBrokers::Nothing => return Ok(None),
        MissionBrokers::Inside(bus) => {
            let remote = Remote::over_bus(Arc::new(bus.clone()), None);
            let remote = remote.map_err(|error| error.to_string())?;
            let location = "this process".to_owned();
            return Ok(Some(Spectator { remote, location }));
        }
        MissionBrokers::One(settings) => Some(&**settings),
        // with several brokers, the monitor shows the systems on the first one
        MissionBrokers::Each(brokers) => brokers.values().next(),
    };
    let Some(settings) = settings else {
        return Ok(None);
    };
    let (place, remote) = broker::watch(settings);
    let remote = remote?;
    Ok(Some(Spectator {
        remote,
        location: place,
    }))
}

impl Spectator {
    /// Runs `work` and shows the monitor until a key ends both. After the end of the run, the last state remains
    /// visible until a key is pressed. If the run fails to start, the monitor is not shown.
    pub fn run_beside<T: Send, E: Send>(
        &self,
        stop: &AtomicBool,
        run: impl FnOnce() -> Result<T, E> + Send,
    ) -> Result<T, E> {
        std::thread::scope(|scope| {
            let running =
                scope.spawn(|| run().inspect_err(|_| stop.store(true, Ordering::Relaxed)));
            // the run continues if the screen cannot be drawn
            if top::show(&self.remote, &self.location, stop).is_ok() {
                stop.store(true, Ordering::Relaxed);
            }
            match running.join() {
                Ok(end) => end,
                Err(panic) => std::panic::resume_unwind(panic),
            }
        })
    }
}
