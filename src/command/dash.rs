//! `asmotion dash`: shows a recording in a web browser.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use asmotion_monitor::{Dashboard, MonitorSource, RecordedRun};
use clap::Args;

use super::run::dashboard::{loopback_address, open_browser};
use crate::build::Build;
use crate::exit::Exit;
use crate::mission::dashboard_settings;
use crate::terminal::{TerminalOutput, print_progress};

/// Interval at which the end is polled.
const LOOK: Duration = Duration::from_millis(50);

/// Shows a recording in a web browser: the whole run, at any time.
///
/// The dashboard is that of `asmotion run --dashboard`, with a line for the time of the run. Ctrl-C ends it.
#[derive(Args)]
pub struct Dash {
    /// Recording of `asmotion run --record FILE.mcap` or of `[deploy] record`; files that continue it are found beside it
    file: PathBuf,

    /// Address of a loopback interface to listen at [default: 127.0.0.1:7070, or another port if it is in use]
    #[arg(long, value_name = "ADDRESS")]
    listen: Option<String>,

    /// Opens the dashboard in a browser
    #[arg(long)]
    open: bool,
}

impl Dash {
    /// Serves the dashboard until Ctrl-C.
    pub fn run(self, _: &Build, terminal: &mut TerminalOutput) -> Exit {
        match self.serve(terminal) {
            Ok(()) => Exit::Ok,
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }

    fn serve(&self, terminal: &mut TerminalOutput) -> Result<(), String> {
        let listen = self.listen.as_deref();
        let listen = listen
            .map(|it| loopback_address("--listen", it))
            .transpose()?;
        let name = self.file.display();
        let run = RecordedRun::read(&self.file).map_err(|error| format!("`{name}` {error}"))?;
        if let Some(problem) = run.problem() {
            terminal.warn(format_args!("`{name}` is INCOMPLETE: {problem}"));
        }
        let source = MonitorSource::recorded(run);
        let opened = Dashboard::open(dashboard_settings(listen), source);
        let dashboard = opened.map_err(|error| error.to_string())?;
        let url = format!("http://{}/", dashboard.address());
        print_progress(format_args!("   Dashboard {url}"));
        if self.open && !open_browser(&url) {
            print_progress("     Browser cannot be opened here: open the address above");
        }
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        // without the handler, Ctrl-C ends the process at once, and open tabs look as if the connection was lost
        let _ = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed));
        while !stop.load(Ordering::Relaxed) {
            std::thread::sleep(LOOK);
        }
        Ok(())
    }
}
