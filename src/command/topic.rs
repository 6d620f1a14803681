//! `asmotion topic`: what goes over a broker's topics.

mod echo;
mod hz;
mod list;
mod publish;

use crate::broker::Broker;
use crate::exit::Exit;
use crate::terminal::Terminal;
use clap::{Args, Subcommand};

/// Shows what goes over a broker's topics, and publishes.
#[derive(Args)]
pub struct Topic {
    #[command(flatten)]
    broker: Broker,

    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// The topics, their types, who writes and reads them, and how often
    List(list::List),
    /// The messages of a topic, as they come
    Echo(echo::Echo),
    /// How often a topic's messages come
    Hz(hz::Hz),
    /// Publishes a message
    Pub(publish::Pub),
}

impl Topic {
    /// Does it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        let remote = match self.broker.remote() {
            Ok(remote) => remote,
            Err(problem) => {
                terminal.error(problem);
                return Exit::Usage;
            }
        };
        let end = match self.what {
            What::List(list) => list.run(&remote, terminal),
            What::Echo(echo) => echo.run(&remote, terminal),
            What::Hz(hz) => hz.run(&remote, terminal),
            What::Pub(publish) => publish.run(&remote, terminal),
        };
        match end {
            Ok(exit) => exit,
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }
}
