//! The operator's script: timed commands, one per line.

use std::str::FromStr;

use asmotion_datum::{Datum, DatumError, Described, Schema};
use serde::{Deserialize, Serialize};

/// One line of a script: `1.0 goal 26.4 4.2 0`, `8 estop on`, `9.5 estop off`, `12 cancel`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScheduledCommand {
    /// Time in s after the operator's first cycle.
    pub at: f64,
    /// The action at that time.
    pub command: OperatorCommand,
}

/// A line of a script as a property: text that describes a timed command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ScriptLine {
    text: String,
    /// The command that the text means, and when it is due.
    pub scheduled: ScheduledCommand,
}

impl TryFrom<String> for ScriptLine {
    type Error = ScriptError;

    fn try_from(text: String) -> Result<Self, ScriptError> {
        let scheduled = text.parse()?;
        Ok(Self { text, scheduled })
    }
}

impl From<ScriptLine> for String {
    fn from(line: ScriptLine) -> Self {
        line.text
    }
}

impl Described for ScriptLine {
    fn describe() -> Schema {
        String::describe()
    }

    fn initial() -> Self {
        Self {
            text: "0 cancel".to_owned(),
            scheduled: ScheduledCommand {
                at: 0.0,
                command: OperatorCommand::Cancel,
            },
        }
    }

    fn write(&self) -> Result<Datum, DatumError> {
        self.text.write()
    }

    fn read(datum: &Datum) -> Result<Self, DatumError> {
        datum.to()
    }
}

/// An action of the operator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OperatorCommand {
    /// Sends a goal: x and y in m, yaw in rad, map frame.
    Goal {
        /// x coordinate, m.
        x: f64,
        /// y coordinate, m.
        y: f64,
        /// Heading, rad (default: 0).
        yaw: f64,
    },
    /// Cancels the mission.
    Cancel,
    /// Presses (`true`) or releases (`false`) the e-stop button.
    Estop(bool),
}

/// A line that is not a valid command.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{line}`: {problem}; as in `1.0 goal 26.4 4.2`, `8 estop on`, `12 cancel`")]
pub struct ScriptError {
    /// The line as written.
    pub line: String,
    /// The violated rule.
    pub problem: &'static str,
}

impl FromStr for ScheduledCommand {
    type Err = ScriptError;

    fn from_str(line: &str) -> Result<Self, ScriptError> {
        let wrong = |problem| ScriptError {
            line: line.to_owned(),
            problem,
        };
        let words: Vec<&str> = line.split_whitespace().collect();
        let Some((at, command)) = words.split_first() else {
            return Err(wrong("the line is empty"));
        };
        let number = |word: &str| {
            let number: Option<f64> = word.parse().ok();
            number
                .filter(|number| number.is_finite())
                .ok_or_else(|| wrong("expected a number"))
        };
        let at = number(at)?;
        if at < 0.0 {
            return Err(wrong("the time is before the start"));
        }
        let command = match command {
            ["goal", x, y] => OperatorCommand::Goal {
                x: number(x)?,
                y: number(y)?,
                yaw: 0.0,
            },
            ["goal", x, y, yaw] => OperatorCommand::Goal {
                x: number(x)?,
                y: number(y)?,
                yaw: number(yaw)?,
            },
            ["cancel"] => OperatorCommand::Cancel,
            ["estop", "on"] => OperatorCommand::Estop(true),
            ["estop", "off"] => OperatorCommand::Estop(false),
            _ => return Err(wrong("unknown command")),
        };
        Ok(Self { at, command })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_reads_what_an_operator_does() {
        let command = |line: &str| {
            line.parse::<ScheduledCommand>()
                .map(|scheduled| scheduled.command)
        };
        assert_eq!(
            command("1.0 goal 26.4 4.2"),
            Ok(OperatorCommand::Goal {
                x: 26.4,
                y: 4.2,
                yaw: 0.0
            })
        );
        assert_eq!(
            command("1 goal -2 0 1.57"),
            Ok(OperatorCommand::Goal {
                x: -2.0,
                y: 0.0,
                yaw: 1.57
            })
        );
        assert_eq!(command("8 estop on"), Ok(OperatorCommand::Estop(true)));
        assert_eq!(command("12 cancel"), Ok(OperatorCommand::Cancel));
    }

    #[test]
    fn it_refuses_what_nobody_can_do() {
        for line in [
            "",
            "goal 1 2",
            "1 goal 1",
            "1 goal x y",
            "-1 cancel",
            "1 fly",
            "NaN cancel",
        ] {
            assert!(line.parse::<ScheduledCommand>().is_err(), "{line}");
        }
    }
}
