//! `asmotion top`: a running system on the terminal, as it changes.

use crate::broker::Broker;
use crate::exit::Exit;
use crate::terminal::Terminal;
use crate::top;
use clap::Args;
use std::io::IsTerminal;
use std::sync::atomic::AtomicBool;

/// Shows a running system: components, topics, the last messages.
///
/// Keys: `q` ends it, Tab goes to the other table, the arrows to another row, `s` sorts by name, rate or trouble,
/// `/` filters by a piece of a name, `p` stops time. What has not been heard of for long is marked with its age.
#[derive(Args)]
pub struct Top {
    #[command(flatten)]
    broker: Broker,
}

impl Top {
    /// Shows it, until a key ends it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        if !std::io::stdout().is_terminal() {
            terminal.error("`asmotion top` draws on a terminal; for a program there are `asmotion component list` and `asmotion topic list`");
            return Exit::Usage;
        }
        let shown = (self.broker.settings()).and_then(|settings| {
            let place = settings.place();
            let remote = self.broker.remote()?;
            top::show(&remote, &place, &AtomicBool::new(false)).map_err(|error| error.to_string())
        });
        match shown {
            Ok(()) => Exit::Ok,
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }
}
