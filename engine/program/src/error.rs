//! The ways in which a program can fail as a component.

use std::process::ExitStatus;
use std::time::Duration;

/// The reason that a program is not started, or that its component fails. The text begins with a code, except for faults
/// that the program reports itself without one.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProgramError {
    /// The operating system does not start the command.
    #[error("PROGRAM_NOT_STARTED: `{command}` cannot be started: {reason}")]
    NotStarted {
        /// The first word of the command.
        command: String,
        /// The reason given by the operating system.
        reason: String,
    },
    /// The program runs, but has not connected in time.
    #[error(
        "PROGRAM_SILENT: the program did not connect to the socket in `ASMOTION_SOCKET` within {limit:?}{}",
        Lines(last_lines)
    )]
    NotConnected {
        /// The time limit.
        limit: Duration,
        /// The last lines of its output.
        last_lines: Vec<String>,
    },
    /// The program has not answered a request in time, and was killed.
    #[error(
        "PROGRAM_SILENT: the program did not answer `{request}` within {limit:?}{}",
        Lines(last_lines)
    )]
    Silent {
        /// Type of the request.
        request: &'static str,
        /// The time limit.
        limit: Duration,
        /// The last lines of its output.
        last_lines: Vec<String>,
    },
    /// The program has ended, or has closed the connection.
    #[error("PROGRAM_ENDED: the program {}{}", ending(status.as_ref()), Lines(last_lines))]
    Ended {
        /// Its exit status; `None` if it closed the connection and was killed.
        status: Option<ExitStatus>,
        /// The last lines of its output.
        last_lines: Vec<String>,
    },
    /// The program violates the protocol.
    #[error("PROTOCOL: {0}")]
    Protocol(String),
    /// The program has answered with a fault.
    #[error("{}{text}", Prefix(code))]
    Fault {
        /// A word in capitals; empty without one.
        code: String,
        /// Explanation for a human reader.
        text: String,
    },
}

impl ProgramError {
    /// The last lines that the program printed, if that helps.
    pub fn last_lines(&self) -> &[String] {
        match self {
            Self::NotConnected { last_lines, .. }
            | Self::Silent { last_lines, .. }
            | Self::Ended { last_lines, .. } => last_lines,
            Self::NotStarted { .. } | Self::Protocol(_) | Self::Fault { .. } => &[],
        }
    }

    /// The same error without the last lines.
    #[must_use]
    pub fn without_lines(mut self) -> Self {
        match &mut self {
            Self::NotConnected { last_lines, .. }
            | Self::Silent { last_lines, .. }
            | Self::Ended { last_lines, .. } => last_lines.clear(),
            Self::NotStarted { .. } | Self::Protocol(_) | Self::Fault { .. } => {}
        }
        self
    }

    /// The same error with another time limit, if it has one.
    pub(crate) fn with_limit(mut self, of_all: Duration) -> Self {
        if let Self::Silent { limit, .. } = &mut self {
            *limit = of_all;
        }
        self
    }

    /// A violation of the protocol.
    pub(crate) fn protocol(text: impl Into<String>) -> Self {
        Self::Protocol(text.into())
    }
}

fn ending(status: Option<&ExitStatus>) -> String {
    status.map_or_else(
        || "closed the connection".to_owned(),
        |status| format!("has ended ({status})"),
    )
}

/// Displays the last lines of a program's output, if there are any.
struct Lines<'a>(&'a [String]);

impl std::fmt::Display for Lines<'_> {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, line) in self.0.iter().enumerate() {
            let separator = if index == 0 {
                "; its last output: "
            } else {
                " | "
            };
            write!(to, "{separator}{}", line.trim())?;
        }
        Ok(())
    }
}

/// Displays a code before a text, if there is one.
struct Prefix<'a>(&'a str);

impl std::fmt::Display for Prefix<'_> {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.is_empty() {
            return Ok(());
        }
        write!(to, "{}: ", self.0)
    }
}
