//! The commands of the session.

use crate::prompt::{self, Verb, verb};

/// All commands.
pub const VERBS: &[Verb] = &[
    verb("step", "s", "[N]", "executes a step, or N steps"),
    verb(
        "run",
        "r",
        "[N]",
        "executes steps until a break, a fault, or N steps (1000)",
    ),
    verb(
        "set",
        "",
        "LOCATION := TERM",
        "sets a location; a monitored one keeps the value",
    ),
    verb(
        "unset",
        "",
        "LOCATION",
        "stops keeping the value of a monitored location",
    ),
    verb(
        "eval",
        "e",
        "TERM",
        "evaluates a term; a term that is not a verb needs no `eval`",
    ),
    verb(
        "fire",
        "f",
        "RULE",
        "fires a rule now, as in `fire r_reset[]` or `fire x := 1`; does not count as a step",
    ),
    verb(
        "watch",
        "w",
        "[TERM]",
        "shows a term after each step; without a term, lists them all",
    ),
    verb("unwatch", "", "NUMBER", "stops showing a term"),
    verb(
        "break",
        "b",
        "[LOCATION | RULE | if TERM]",
        "stops `run` when the location is written, the rule runs, or the term becomes true",
    ),
    verb("unbreak", "", "NUMBER", "removes a break"),
    verb(
        "who",
        "",
        "LOCATION",
        "shows the last update of a location: rule, step and previous value",
    ),
    verb(
        "state",
        "",
        "[NAME]",
        "shows the values of all locations, or of one function",
    ),
    verb(
        "inputs",
        "",
        "",
        "lists the monitored functions and the values that are kept",
    ),
    verb(
        "undo",
        "u",
        "[N]",
        "undoes one event, or N: steps, rules fired, locations set",
    ),
    verb("history", "h", "", "lists the events so far"),
    verb(
        "save",
        "",
        "FILE.avalla",
        "saves the events as a scenario that checks every update",
    ),
    verb("help", "?", "", "shows this list"),
    verb("quit", "q", "", "quits, as `exit` and Ctrl-D do"),
    verb("exit", "", "", ""),
];

/// Splits a line into its command and the rest.
pub fn split(line: &str) -> Option<(&'static str, &str)> {
    let (verb, rest) = prompt::split(VERBS, line)?;
    // `step = 3` is a term about a function with the name of a command
    let is_operand = rest.starts_with(['=', '!', '<', '>', '+', '*']);
    (!is_operand).then_some((verb, rest))
}
