//! `asmotion topic`: messages of topics on a broker.

mod echo;
mod hz;
mod list;
mod publish;

use crate::broker::Broker;
use crate::exit::Exit;
use crate::terminal::Terminal;
use clap::{Args, Subcommand};

/// Lists, shows and publishes messages of topics on a broker.
#[derive(Args)]
pub struct Topic {
    #[command(flatten)]
    broker: Broker,

    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Lists topics with type, publishers, subscribers and rate
    List(list::List),
    /// Prints the messages of a topic
    Echo(echo::Echo),
    /// Measures the rate of a topic
    Hz(hz::Hz),
    /// Publishes a message
    Pub(publish::Pub),
}

impl Topic {
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
