//! Verbs: the commands of a prompt.

use crate::terminal::{NAME, TerminalOutput};

/// A command and its help text.
pub struct Verb {
    /// Name of the command.
    pub name: &'static str,
    /// Abbreviation; often empty.
    pub short: &'static str,
    /// Arguments.
    pub usage: &'static str,
    /// Description.
    pub help: &'static str,
}

/// Creates a verb from name, abbreviation, arguments and description.
pub const fn verb(
    name: &'static str,
    short: &'static str,
    usage: &'static str,
    help: &'static str,
) -> Verb {
    Verb {
        name,
        short,
        usage,
        help,
    }
}

/// Splits a line into its verb and the rest.
pub fn split<'l>(verbs: &[Verb], line: &'l str) -> Option<(&'static str, &'l str)> {
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let is_it = |verb: &&Verb| verb.name == word || (!verb.short.is_empty() && verb.short == word);
    let verb = verbs.iter().find(is_it)?;
    Some((verb.name, rest.trim()))
}

/// Prints all verbs with their descriptions.
pub fn help(verbs: &[Verb], terminal: &mut TerminalOutput) {
    for verb in verbs {
        let short = match verb.short {
            "" => String::new(),
            short => format!(" ({short})"),
        };
        let left = format!("{}{short} {}", verb.name, verb.usage);
        terminal.result(format_args!("  {NAME}{left:<38}{NAME:#} {}", verb.help));
    }
}
