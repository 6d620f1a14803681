//! Output of the program: results on standard output, progress and diagnostics on standard error.

use anstream::ColorChoice;
use anstyle::{AnsiColor, Style as Ansi};
use asmotion_lang::{Report, Severity, Sources, Style};
use clap::ValueEnum;
use std::fmt::Display;
use std::io::Write;

/// Use of colour in the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Colour {
    /// If the output is a terminal
    #[default]
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

/// Colours by meaning. Colour is never the only carrier of information.
pub const GOOD: Ansi = AnsiColor::Green.on_default().bold();
/// See [`GOOD`].
pub const BAD: Ansi = AnsiColor::Red.on_default().bold();
/// See [`GOOD`].
pub const NOTE: Ansi = AnsiColor::Yellow.on_default();
/// See [`GOOD`].
pub const NAME: Ansi = AnsiColor::Cyan.on_default();
/// See [`GOOD`].
pub const FAINT: Ansi = Ansi::new().dimmed();

/// Both standard streams.
pub struct TerminalOutput {
    out: anstream::AutoStream<std::io::Stdout>,
    err: anstream::AutoStream<std::io::Stderr>,
    /// First error of writing a result, other than a closed pipe.
    lost: Option<std::io::Error>,
}

impl TerminalOutput {
    /// Opens the standard streams with this choice of colour.
    pub fn new(colour: Colour) -> Self {
        let choice = match colour {
            Colour::Auto => ColorChoice::Auto,
            Colour::Always => ColorChoice::Always,
            Colour::Never => ColorChoice::Never,
        };
        choice.write_global();
        Self {
            out: anstream::stdout(),
            err: anstream::stderr(),
            lost: None,
        }
    }

    /// Prints a line of a result.
    pub fn result(&mut self, line: impl Display) {
        if let Err(error) = writeln!(self.out, "{line}")
            && error.kind() != std::io::ErrorKind::BrokenPipe
        {
            self.lost.get_or_insert(error);
        }
    }

    /// Takes the error of writing results, if there was one.
    pub fn lost(&mut self) -> Option<std::io::Error> {
        if let Err(error) = self.out.flush()
            && error.kind() != std::io::ErrorKind::BrokenPipe
        {
            self.lost.get_or_insert(error);
        }
        self.lost.take()
    }

    /// Prints a line of progress.
    pub fn progress(&mut self, line: impl Display) {
        let _ = writeln!(self.err, "{line}");
    }

    /// Prints a line that begins with an activity, for example `   Checking 3 files`.
    pub fn status(&mut self, verb: &str, what: impl Display) {
        self.progress(format_args!("{GOOD}{verb:>12}{GOOD:#} {what}"));
    }

    /// Prints an error that stops the command.
    pub fn error(&mut self, what: impl Display) {
        self.progress(format_args!("{BAD}error{BAD:#}: {what}"));
    }

    /// Prints a warning.
    pub fn warn(&mut self, what: impl Display) {
        self.progress(format_args!("{NOTE}warning{NOTE:#}: {what}"));
    }

    /// Prints all findings of a report.
    pub fn report(&mut self, report: &Report, sources: &Sources) {
        for finding in &report.diagnostics {
            self.progress(format_args!(
                "{}\n",
                asmotion_lang::render(finding, sources, Style::Coloured)
            ));
        }
    }
}

/// Number of errors and warnings, for example "1 error, 2 warnings"; `None` without any.
pub fn count(report: &Report) -> Option<String> {
    let number = |severity, word: &str| match report.count(severity) {
        0 => None,
        1 => Some(format!("1 {word}")),
        several => Some(format!("{several} {word}s")),
    };
    let parts: Vec<String> = [
        number(Severity::Error, "error"),
        number(Severity::Warning, "warning"),
    ]
    .into_iter()
    .flatten()
    .collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}
