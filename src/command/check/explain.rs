//! `asmotion check --explain`: the meaning of a code.

use crate::codes::all;
use crate::exit::Exit;
use crate::terminal::{NAME, TerminalOutput};
use asmotion_diagnostics::did_you_mean;

/// Prints the page of a code, or a list of all codes.
pub fn explain(name: Option<&str>, terminal: &mut TerminalOutput) -> Exit {
    let Some(name) = name else {
        for code in all() {
            terminal.result(format_args!("{NAME}{code}{NAME:#}  {}", code.title));
        }
        return Exit::Ok;
    };
    if let Some(code) = all().find(|code| code.name.eq_ignore_ascii_case(name)) {
        terminal.result(code.page().trim_end());
        return Exit::Ok;
    }
    terminal.error(format_args!("unknown code `{name}`"));
    match nearest(name) {
        Some(similar) => terminal.progress(did_you_mean(similar)),
        None => terminal.progress("`asmotion check --explain` lists all codes"),
    }
    Exit::Usage
}

/// Returns the first code that differs from `name` in one letter or in its number of zeros.
fn nearest(name: &str) -> Option<&'static str> {
    let family = name.chars().next()?.to_ascii_uppercase();
    let number: Option<u32> = name.get(1..).and_then(|digits| digits.parse().ok());
    let same_number = |code: &&str| {
        code.starts_with(family) && code.get(1..).and_then(|it| it.parse().ok()) == number
    };
    let slips = |code: &str| {
        let letters = code.chars().zip(name.chars());
        letters
            .filter(|(one, other)| !one.eq_ignore_ascii_case(other))
            .count()
    };
    let mut names = all().map(|code| code.name);
    if number.is_some()
        && let Some(code) = names.find(same_number)
    {
        return Some(code);
    }
    let mut names = all().map(|code| code.name);
    names.find(|code| code.len() == name.len() && slips(code) == 1)
}
