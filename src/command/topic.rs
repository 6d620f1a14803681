//! `asmotion topic`: messages of topics on a broker.

mod echo;
mod hz;
mod list;
mod publish;

use crate::broker::BrokerArguments;
use crate::build::Build;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_diagnostics::{or_did_you_mean, similar};
use asmotion_remote::Remote;
use clap::{Args, Subcommand};
use std::time::Duration;

/// Age from which a message is shown with its age: it waited, for example because nobody read the output.
pub(super) const OLD: Duration = Duration::from_secs(1);

/// Lists, shows and publishes messages of topics on a broker.
#[derive(Args)]
pub struct Topic {
    #[command(flatten)]
    broker: BrokerArguments,

    #[command(subcommand)]
    what: TopicCommand,
}

#[derive(Subcommand)]
enum TopicCommand {
    /// Lists topics with type, publishers, subscribers and rate
    List(list::TopicList),
    /// Prints the messages of a topic
    Echo(echo::Echo),
    /// Measures the rate of a topic
    Hz(hz::Hz),
    /// Publishes a message
    Pub(publish::Pub),
}

impl Topic {
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let remote = match self.broker.remote(build) {
            Ok(remote) => remote,
            Err(problem) => {
                terminal.error(problem);
                return Exit::Usage;
            }
        };
        let end = match self.what {
            TopicCommand::List(list) => list.run(&remote, terminal),
            TopicCommand::Echo(echo) => echo.run(&remote, build, terminal),
            TopicCommand::Hz(hz) => hz.run(&remote, terminal),
            TopicCommand::Pub(publish) => publish.run(&remote, terminal),
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

/// The warning that no running process has a topic, with the most similar one; `None` if one has it, or if the name is a
/// pattern.
fn unknown_topic(topic: &str, remote: &Remote) -> Option<String> {
    if topic.split('.').any(|word| word == "*" || word == "#") {
        return None;
    }
    let mut known = Vec::new();
    for presence in remote.processes() {
        let topics = presence.presence.topics.iter();
        known.extend(topics.map(|topic| presence.key(&topic.name)));
    }
    if known.iter().any(|known| known == topic) {
        return None;
    }
    // names on the broker begin with the robot
    let of_a_robot = format!(".{topic}");
    let whole = known.iter().find(|known| known.ends_with(&of_a_robot));
    let suggestion = whole.or_else(|| similar(topic, &known));
    let suggestion = or_did_you_mean(suggestion.map(String::as_str));
    Some(format!(
        "no running process has a topic `{topic}`{suggestion}"
    ))
}
