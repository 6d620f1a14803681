//! The commands of the shell.

use crate::prompt::{Verb, verb};

/// All commands. An omitted component is the entered one.
pub const VERBS: &[Verb] = &[
    verb("ls", "l", "", "lists the components, or the content of one"),
    verb(
        "cd",
        "",
        "[COMPONENT | ..]",
        "enters a component, or leaves it",
    ),
    verb(
        "peers",
        "",
        "[COMPONENT]",
        "shows the connections of a component",
    ),
    verb(
        "call",
        "",
        "[SERVICE.]OPERATION [JSON]",
        "calls an operation; `operation(JSON)` alone does the same",
    ),
    verb("get", "", "[PROPERTY]", "shows one property, or all"),
    verb(
        "set",
        "",
        "PROPERTY = VALUE",
        "sets a property from the next cycle on",
    ),
    verb("read", "r", "PORT", "shows the last message of an output"),
    verb("write", "w", "PORT JSON", "sends a message to an input"),
    verb(
        "watch",
        "",
        "PORT [N]",
        "shows the next N messages of an output (10)",
    ),
    verb(
        "configure",
        "",
        "[COMPONENT]",
        "requests a step of the life cycle",
    ),
    verb("start", "", "[COMPONENT]", ""),
    verb("stop", "", "[COMPONENT]", ""),
    verb("cleanup", "", "[COMPONENT]", ""),
    verb("recover", "", "[COMPONENT]", ""),
    verb("reset", "", "[COMPONENT]", ""),
    verb("help", "?", "", "shows this list"),
    verb("quit", "q", "", "quits, as `exit` and Ctrl-D do"),
    verb("exit", "", "", ""),
];
