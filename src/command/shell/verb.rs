//! The commands of the shell.

use crate::prompt::{Verb, verb};

/// All commands. An omitted component is the entered one.
pub const VERBS: &[Verb] = &[
    verb("ls", "l", "", "the components; in one, what it has"),
    verb(
        "cd",
        "",
        "[COMPONENT | ..]",
        "enters a component, or leaves it",
    ),
    verb("peers", "", "[COMPONENT]", "who it is joined to, and how"),
    verb(
        "call",
        "",
        "[SERVICE.]OPERATION [JSON]",
        "calls an operation; `operation(JSON)` alone will do",
    ),
    verb(
        "get",
        "",
        "[PROPERTY]",
        "the value of a property, or of all",
    ),
    verb(
        "set",
        "",
        "PROPERTY = VALUE",
        "sets a property from the next cycle on",
    ),
    verb("read", "r", "PORT", "what left an output last"),
    verb("write", "w", "PORT JSON", "gives a message to an input"),
    verb(
        "watch",
        "",
        "PORT [N]",
        "the next N messages that leave an output (10)",
    ),
    verb("configure", "", "[COMPONENT]", "a step of its life cycle"),
    verb("start", "", "[COMPONENT]", ""),
    verb("stop", "", "[COMPONENT]", ""),
    verb("cleanup", "", "[COMPONENT]", ""),
    verb("recover", "", "[COMPONENT]", ""),
    verb("reset", "", "[COMPONENT]", ""),
    verb("help", "?", "", "this list"),
    verb("quit", "q", "", "ends; so does Ctrl-D"),
];
