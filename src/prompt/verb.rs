//! Verbs: what a line at a prompt may begin with.

use crate::terminal::{NAME, Terminal};

/// A verb, as `help` shows it.
pub struct Verb {
    /// The word.
    pub name: &'static str,
    /// A shorter one; often none.
    pub short: &'static str,
    /// What follows it.
    pub usage: &'static str,
    /// What it does.
    pub help: &'static str,
}

/// A verb: word, shorter word, what follows, what it does.
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

/// The verb a line begins with, and what follows it.
pub fn split<'l>(verbs: &[Verb], line: &'l str) -> Option<(&'static str, &'l str)> {
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let is_it = |verb: &&Verb| verb.name == word || (!verb.short.is_empty() && verb.short == word);
    let verb = verbs.iter().find(is_it)?;
    Some((verb.name, rest.trim()))
}

/// Shows all verbs.
pub fn help(verbs: &[Verb], terminal: &mut Terminal) {
    for verb in verbs {
        let short = match verb.short {
            "" => String::new(),
            short => format!(" ({short})"),
        };
        let left = format!("{}{short} {}", verb.name, verb.usage);
        terminal.result(format_args!("  {NAME}{left:<38}{NAME:#} {}", verb.help));
    }
}
