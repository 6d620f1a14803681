//! `asmotion shell`: a prompt in a running system, modelled on Orocos' TaskBrowser.

mod browser;
mod peers;
mod verb;

use crate::broker::Broker;
use crate::exit::Exit;
use crate::prompt::{Line, Prompt};
use crate::terminal::Terminal;
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
    broker: Broker,
}

impl Shell {
    /// Reads and executes commands until the end of input.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        let prompt = Prompt::new(VERBS, "_./-", "shell_history")
            .map_err(|error| format!("cannot read the input: {error}"));
        let ready = prompt.and_then(|prompt| Ok((prompt, self.broker.remote()?)));
        let (mut prompt, remote) = match ready {
            Ok(ready) => ready,
            Err(problem) => {
                terminal.error(problem);
                return Exit::Usage;
            }
        };
        let mut browser = Browser::new(remote);
        browser.greet(terminal);
        loop {
            prompt.know(browser.names());
            match prompt.read(&browser.prompt()) {
                Line::Text(line) => {
                    if !browser.answer(&line, terminal) {
                        break;
                    }
                }
                Line::Nothing => {}
                Line::End => break,
            }
        }
        prompt.keep();
        Exit::Ok
    }
}
