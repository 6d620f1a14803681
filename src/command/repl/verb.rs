//! The commands of the session.

use crate::prompt::{self, Verb, verb};

/// All commands.
pub const VERBS: &[Verb] = &[
    verb("step", "s", "[N]", "does a step, or N"),
    verb(
        "run",
        "r",
        "[N]",
        "does steps until a break, a fault, or N of them (1000)",
    ),
    verb(
        "set",
        "",
        "LOCATION := TERM",
        "gives a location a value; a monitored one keeps it",
    ),
    verb(
        "unset",
        "",
        "LOCATION",
        "no longer holds a monitored location",
    ),
    verb(
        "eval",
        "e",
        "TERM",
        "the value of a term; a term alone will do where it is no verb",
    ),
    verb(
        "fire",
        "f",
        "RULE",
        "fires a rule now, as in `fire r_reset[]` or `fire x := 1`; it counts as no step",
    ),
    verb(
        "watch",
        "w",
        "[TERM]",
        "shows a term after each step; all of them without one",
    ),
    verb("unwatch", "", "NUMBER", "stops showing it"),
    verb(
        "break",
        "b",
        "[LOCATION | RULE | if TERM]",
        "stops `run` when it is written, runs, becomes true",
    ),
    verb("unbreak", "", "NUMBER", "no longer stops there"),
    verb(
        "who",
        "",
        "LOCATION",
        "who wrote a location last, when, and what was there before",
    ),
    verb(
        "state",
        "",
        "[NAME]",
        "what the locations hold, or those of one function",
    ),
    verb(
        "inputs",
        "",
        "",
        "the monitored functions, and what is held",
    ),
    verb(
        "undo",
        "u",
        "[N]",
        "goes back one event, or N: steps, rules fired, locations set",
    ),
    verb("history", "h", "", "what happened"),
    verb(
        "save",
        "",
        "FILE.avalla",
        "writes what happened as a scenario that checks every update",
    ),
    verb("help", "?", "", "this list"),
    verb("quit", "q", "", "ends; so does Ctrl-D"),
];

/// Splits a line into its command and the rest.
pub fn split(line: &str) -> Option<(&'static str, &str)> {
    let (verb, rest) = prompt::split(VERBS, line)?;
    // `step = 3` is a term about a function with the name of a command
    let is_operand = rest.starts_with(['=', '!', '<', '>', '+', '*']);
    (!is_operand).then_some((verb, rest))
}
