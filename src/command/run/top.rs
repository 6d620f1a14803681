//! `--top`: runs a composite and shows the monitor beside it, in one process.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use asmotion_remote::Remote;

use crate::mission::{Mission, MissionBrokers, MissionClock};
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
            let location = match mission.clock {
                MissionClock::Wall => "this process".to_owned(),
                MissionClock::Virtual(_) => "this process, virtual clock".to_owned(),
            };
            return Ok(Some(Spectator { remote, location }));
        }
        MissionBrokers::One(settings) => Some(settings),
        // with several brokers, the monitor shows the systems on the first one
        MissionBrokers::Each(brokers) => brokers.values().next(),
    };
    let Some(settings) = settings else {
        return Ok(None);
    };
    let (place, remote) = settings.watch();
    let remote = remote?;
    Ok(Some(Spectator {
        remote,
        location: place,
    }))
}

impl Spectator {
    /// Performs `run` and shows the monitor until a key ends both. After the end of the run, its `headline` and the last
    /// state remain visible until a key is pressed. If the run fails to start, the monitor is not shown.
    pub fn run_beside<T: Send, E: Send>(
        &self,
        stop: &AtomicBool,
        run: impl FnOnce() -> Result<T, E> + Send,
        headline: impl FnOnce(&T) -> String + Send,
    ) -> Result<T, E> {
        let result = OnceLock::new();
        std::thread::scope(|scope| {
            let running = scope.spawn(|| {
                let end = run().inspect_err(|_| stop.store(true, Ordering::Relaxed))?;
                // set once, here
                let _ = result.set(headline(&end));
                Ok(end)
            });
            let result = || result.get().cloned();
            // the run continues if the screen cannot be drawn
            if top::show(&self.remote, &self.location, stop, &result).is_ok() {
                stop.store(true, Ordering::Relaxed);
            }
            match running.join() {
                Ok(end) => end,
                Err(panic) => std::panic::resume_unwind(panic),
            }
        })
    }
}
