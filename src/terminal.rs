//! Output of the program: results on standard output, progress and diagnostics on standard error.

use std::fmt::Display;
use std::io::Write;
use std::sync::OnceLock;

use anstream::ColorChoice;
use asmotion_lang::{Report, Severity, Sources, Style};
pub use asmotion_story::style::{BAD, FAINT, GOOD, NAME, NOTE};
use clap::ValueEnum;

use crate::output_queue::OutputQueue;

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

/// The queues of both standard streams, once a command has asked for them with [`never_wait`].
static QUEUES: OnceLock<OutputQueues> = OnceLock::new();

struct OutputQueues {
    out: OutputQueue,
    err: OutputQueue,
}

/// Lets no output of this process wait for its reader from now on: lines that nobody reads are dropped and counted. For
/// commands that have duties in real time.
pub fn never_wait() {
    if QUEUES.get().is_some() {
        return;
    }
    let out = OutputQueue::start("stdout", anstream::stdout(), missing_results);
    let err = OutputQueue::start("stderr", anstream::stderr(), missing_progress);
    // without threads, output waits
    if let (Ok(out), Ok(err)) = (out, err) {
        let _ = QUEUES.set(OutputQueues { out, err });
    }
}

/// The line in place of lines of standard output that were dropped.
fn missing_results(count: u64) -> String {
    serde_json::json!({ "type": "lost_output", "v": 1, "count": count }).to_string()
}

/// The line in place of lines of standard error that were dropped.
fn missing_progress(count: u64) -> String {
    let lines = if count == 1 { "line" } else { "lines" };
    format!("{NOTE}…{NOTE:#} {count} {lines} not shown, because nobody read the output")
}

/// Prints a line of the result while a command works. A line that cannot be written is lost.
pub fn print_result(line: impl Display) {
    match QUEUES.get() {
        Some(queues) => queues.out.push(line.to_string()),
        None => {
            let _ = writeln!(anstream::stdout(), "{line}");
        }
    }
}

/// Prints a line of progress while a command works. A line that cannot be written is lost.
pub fn print_progress(line: impl Display) {
    match QUEUES.get() {
        Some(queues) => queues.err.push(line.to_string()),
        None => {
            let _ = writeln!(anstream::stderr(), "{line}");
        }
    }
}

/// Prints a warning while a command works. A line that cannot be written is lost.
pub fn print_warning(what: &str) {
    print_progress(format_args!("{NOTE}warning{NOTE:#}: {what}"));
}

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
        if let Some(queues) = QUEUES.get() {
            // in the order of the lines, where both streams go to the same place
            queues.err.settle();
            queues.out.push_important(line.to_string());
        } else if let Err(error) = writeln!(self.out, "{line}")
            && error.kind() != std::io::ErrorKind::BrokenPipe
        {
            self.lost.get_or_insert(error);
        }
    }

    /// Takes the error of writing results, if there was one. Waits until all output is written, as long as it is read.
    pub fn lost(&mut self) -> Option<std::io::Error> {
        if let Some(queues) = QUEUES.get() {
            // progress that cannot be written can be reported nowhere
            let _ = queues.err.finish();
            return queues.out.finish().err();
        }
        if let Err(error) = self.out.flush()
            && error.kind() != std::io::ErrorKind::BrokenPipe
        {
            self.lost.get_or_insert(error);
        }
        self.lost.take()
    }

    /// Prints a line of progress.
    pub fn progress(&mut self, line: impl Display) {
        match QUEUES.get() {
            Some(queues) => {
                queues.out.settle();
                queues.err.push_important(line.to_string());
            }
            None => {
                let _ = writeln!(self.err, "{line}");
            }
        }
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
