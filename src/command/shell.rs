//! `asmotion shell`: a running system at a prompt, as Orocos' TaskBrowser shows one.

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

/// Talks with a running system: looks around in its components, calls, reads, writes, watches.
///
/// `ls` shows the components, `cd RoverDriver` enters one, `help` tells the rest. Tab completes; lines are remembered.
#[derive(Args)]
pub struct Shell {
    #[command(flatten)]
    broker: Broker,
}

impl Shell {
    /// Talks until the input ends.
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
