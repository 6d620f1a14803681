//! Records of commands from outside a system, for its log and its recording.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Something that was asked of a running system from outside, or what became of it. A command has one record when it is asked and
/// another one with its outcome, or only the latter if it is refused at once.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct CommandRecord {
    /// Number of the command, the same in both records; each source counts its own.
    pub number: u64,
    /// Origin: the address of a browser, or the name of a tool or process on a bus.
    pub client: String,
    /// Number of the tab of a dashboard; 0 for tools and processes.
    #[serde(skip_serializing_if = "is_zero")]
    pub tab: u64,
    /// How a tab of a dashboard proved that it knows the token.
    #[serde(skip_serializing_if = "TabLogin::is_none")]
    pub login: TabLogin,
    /// The command in words, for example `set Follower.max_speed = 0.4`.
    pub text: String,
    /// Outcome so far.
    pub outcome: CommandOutcome,
    /// The reason that it was refused or failed; empty otherwise.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// Number of refused commands before this one that have no records, because there were too many in a short time.
    #[serde(skip_serializing_if = "is_zero")]
    pub left_out: u64,
}

/// How a tab of a dashboard proved that it knows the token.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TabLogin {
    /// It did not.
    #[default]
    None,
    /// With the cookie of an earlier login of this browser.
    Cookie,
    /// With the token itself.
    Token,
}

/// Outcome of a command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CommandOutcome {
    /// It is asked; the outcome follows.
    #[default]
    Asked,
    /// It was carried out.
    Done,
    /// It was refused, and has had no effect.
    Refused,
    /// No answer came in time: whether it was carried out is not known.
    Unknown,
}

impl CommandRecord {
    /// The record of the same command with its outcome.
    #[must_use]
    pub fn ended(&self, outcome: CommandOutcome, reason: String) -> Self {
        Self {
            outcome,
            reason,
            left_out: 0,
            ..self.clone()
        }
    }

    /// The command and its outcome in words, without its origin.
    pub fn words(&self) -> String {
        let Self { text, reason, .. } = self;
        let words = match self.outcome {
            CommandOutcome::Asked => text.clone(),
            CommandOutcome::Done => format!("done: {text}"),
            CommandOutcome::Refused => format!("refused: {text}: {reason}"),
            CommandOutcome::Unknown => format!("no answer: {text}: {reason}"),
        };
        match self.left_out {
            0 => words,
            count => format!("{words} ({count} refused before it)"),
        }
    }

    /// The origin in words, for example `127.0.0.1:50312 tab 2`.
    pub fn origin(&self) -> String {
        match self.tab {
            0 => self.client.clone(),
            tab => format!("{} tab {tab}", self.client),
        }
    }
}

impl TabLogin {
    /// Returns whether the tab has not proved that it knows the token.
    pub fn is_none(&self) -> bool {
        *self == Self::None
    }
}

impl fmt::Display for TabLogin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "no login",
            Self::Cookie => "cookie",
            Self::Token => "token",
        })
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes fields by reference"
)]
fn is_zero(count: &u64) -> bool {
    *count == 0
}
