//! `asmotion top`: live view of a running system.

use crate::broker::BrokerArguments;
use crate::build::Build;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use crate::top;
use clap::Args;
use std::io::IsTerminal;
use std::sync::atomic::AtomicBool;

/// Shows a running system on the terminal: components, topics, the last messages.
///
/// Keys: `q` quits, Tab switches tables, arrows select a row, `s` sorts by name, rate or trouble, `/` filters by name, `p`
/// pauses. Entries without recent messages are marked with their age.
#[derive(Args)]
pub struct Top {
    #[command(flatten)]
    broker: BrokerArguments,
}

impl Top {
    /// Shows the system until `q` is pressed.
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        if !std::io::stdout().is_terminal() {
            terminal.error("`asmotion top` needs a terminal; programs can use `asmotion component list` and `asmotion topic list`");
            return Exit::Usage;
        }
        let result = self.broker.settings(build).and_then(|settings| {
            let (location, remote) = settings.watch();
            top::show(&remote?, &location, &AtomicBool::new(false), &|| None)
                .map_err(|error| error.to_string())
        });
        match result {
            Ok(()) => Exit::Ok,
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }
}
