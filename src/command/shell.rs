//! `asmotion shell`: a prompt in a running system, modelled on Orocos' TaskBrowser.

mod browser;
mod peers;
mod verb;

use crate::broker::BrokerArguments;
use crate::build::Build;
use crate::exit::Exit;
use crate::prompt::{Prompt, PromptLine};
use crate::terminal::TerminalOutput;
use browser::Browser;
use clap::Args;
use verb::VERBS;

/// Opens a prompt in a running system: inspects components, calls, reads, writes, watches.
///
/// `ls` lists the components, `cd RoverDriver` enters one, `help` lists all commands. Tab completes names; the history is
/// kept.
#[derive(Args)]
pub struct Shell {
    #[command(flatten)]
    broker: BrokerArguments,
}

impl Shell {
    /// Reads and executes commands until the end of input.
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let prompt = Prompt::new(VERBS, "_./-", "shell_history")
            .map_err(|error| format!("cannot read the input: {error}"));
        let ready = prompt.and_then(|prompt| Ok((prompt, self.broker.remote(build)?)));
        let (mut prompt, remote) = match ready {
            Ok(ready) => ready,
            Err(problem) => {
                terminal.error(problem);
                return Exit::Usage;
            }
        };
        let mut browser = Browser::new(remote);
        browser.print_banner(terminal);
        loop {
            prompt.set_names(browser.names());
            match prompt.read(&browser.prompt()) {
                PromptLine::Text(line) => {
                    if !browser.execute(&line, terminal) {
                        break;
                    }
                }
                PromptLine::Nothing => {}
                PromptLine::End => break,
            }
        }
        prompt.save_history();
        Exit::Ok
    }
}
