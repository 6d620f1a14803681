//! `asmotion fmt`: formats specifications and scenarios.

use crate::diff;
use crate::exit::Exit;
use crate::files::{self, DiskLoader, STANDARD_INPUT};
use crate::paths::{FileKind, PathError, named_files};
use crate::terminal::TerminalOutput;
use asmotion_diagnostics::LoadError;
use asmotion_lang::{Loader, Report, Sources, syntax};
use clap::Args;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Formats specifications and scenarios; see docs/formatting.md.
#[derive(Args)]
pub struct Fmt {
    /// Specifications, scenarios, and folders that contain them; `-` formats standard input
    #[arg(required = true)]
    paths: Vec<PathBuf>,

    /// Lists files that are not formatted, changes nothing, and fails if there are any
    #[arg(long)]
    check: bool,

    /// Prints the changes as a diff and changes nothing
    #[arg(long)]
    diff: bool,
}

/// Numbers of files by result.
#[derive(Default)]
struct FmtSummary {
    changed: usize,
    unchanged: usize,
    /// Files with errors, left unchanged.
    unparsable: usize,
    /// Files that could not be read or written.
    failed: usize,
}

impl Fmt {
    pub fn run(self, terminal: &mut TerminalOutput) -> Exit {
        let mut tally = FmtSummary::default();
        for path in &self.paths {
            match files_at(path) {
                Ok(files) => files
                    .iter()
                    .for_each(|file| self.format_file(file, &mut tally, terminal)),
                Err(error) => {
                    terminal.error(error);
                    tally.failed += 1;
                }
            }
        }
        if self.paths != [PathBuf::from("-")] {
            self.conclude(&tally, terminal);
        }
        if tally.failed > 0 {
            Exit::Usage
        } else if tally.unparsable > 0 || (self.check && tally.changed > 0) {
            Exit::Findings
        } else {
            Exit::Ok
        }
    }

    fn format_file(&self, path: &str, summary: &mut FmtSummary, terminal: &mut TerminalOutput) {
        let kind = FileKind::of(Path::new(path));
        let is_toml = matches!(kind, Some(FileKind::Composite | FileKind::Mission));
        if is_toml || path.ends_with(".toml") {
            terminal.error(format_args!(
                "cannot format `{path}`: `fmt` formats specifications (`.asm`) and scenarios (`.avalla`)"
            ));
            summary.failed += 1;
            return;
        }
        let before = match read(path) {
            Ok(text) => text,
            Err(error) => {
                terminal.error(error);
                summary.failed += 1;
                return;
            }
        };
        let after = match formatted(path, &before) {
            Ok(text) => text,
            Err((report, sources)) => {
                terminal.report(&report, &sources);
                summary.unparsable += 1;
                return;
            }
        };
        let changes = *before != *after;
        if path == STANDARD_INPUT && !self.check && !self.diff {
            terminal.result(after.trim_end_matches('\n'));
        } else if changes && let Err(error) = self.change(path, &before, &after, terminal) {
            terminal.error(format_args!("cannot rewrite `{path}`: {error}"));
            summary.failed += 1;
            return;
        }
        if changes {
            summary.changed += 1;
        } else {
            summary.unchanged += 1;
        }
    }

    /// Writes the formatted text, or prints the difference.
    fn change(
        &self,
        path: &str,
        before: &str,
        after: &str,
        terminal: &mut TerminalOutput,
    ) -> std::io::Result<()> {
        if self.diff {
            terminal.result(diff::unified(path, before, after).trim_end());
        } else if self.check {
            terminal.result(path);
        } else {
            files::rewrite(path, before, after)?;
            terminal.status("Formatted", path);
        }
        Ok(())
    }

    fn conclude(&self, summary: &FmtSummary, terminal: &mut TerminalOutput) {
        let change = if self.check || self.diff {
            "to format"
        } else {
            "formatted"
        };
        let mut parts = vec![
            format!("{} {change}", count(summary.changed)),
            format!("{} left as they are", summary.unchanged),
        ];
        if summary.failed > 0 {
            parts.push(format!("{} not readable or not writable", summary.failed));
        }
        if summary.unparsable > 0 {
            parts.push(format!("{} with errors left unchanged", summary.unparsable));
        }
        let line = parts.join(", ");
        if summary.unparsable + summary.failed > 0 || (self.check && summary.changed > 0) {
            terminal.error(line);
        } else {
            terminal.status("Finished", line);
        }
    }
}

fn count(files: usize) -> String {
    match files {
        1 => "1 file".to_owned(),
        files => format!("{files} files"),
    }
}

/// The file itself, or the specifications and scenarios in a folder.
fn files_at(path: &Path) -> Result<Vec<String>, PathError> {
    let kinds = [FileKind::Specification, FileKind::Scenario];
    let files = named_files(&[path.to_owned()], &kinds)?;
    Ok(files.iter().map(|file| file.text()).collect())
}

fn read(path: &str) -> Result<Arc<str>, LoadError> {
    let failed = |error: std::io::Error| LoadError {
        path: path.to_owned(),
        reason: files::reason(&error),
    };
    let text = DiskLoader.read(path)?;
    if !text.contains(char::REPLACEMENT_CHARACTER) {
        return Ok(text);
    }
    let bytes = if path == STANDARD_INPUT {
        files::standard_input()?.to_owned()
    } else {
        std::fs::read(path).map_err(failed)?
    };
    // a check reads such a text as far as possible, but it cannot be written again without losses
    utf8(path, bytes).map(Arc::from)
}

/// Returns a text, or the place of its first byte that is not UTF-8.
fn utf8(path: &str, bytes: Vec<u8>) -> Result<String, LoadError> {
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let bytes = error.as_bytes();
        let before = String::from_utf8_lossy(bytes.get(..valid).unwrap_or_default());
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        let byte = bytes.get(valid).copied().unwrap_or_default();
        let reason = format!(
            "line {line}, column {column}: the byte 0x{byte:02X} is not UTF-8; if the text is Latin-1, `iconv -f ISO-8859-1 -t UTF-8` converts it"
        );
        let path = path.to_owned();
        LoadError { path, reason }
    })
}

fn formatted(path: &str, text: &Arc<str>) -> Result<String, (Report, Sources)> {
    let mut sources = Sources::new();
    let file = sources.add(path, text.clone());
    let is_scenario = FileKind::of(Path::new(path)) == Some(FileKind::Scenario);
    let formatted = if is_scenario {
        syntax::format_scenario(file, text)
    } else {
        syntax::format(file, text)
    };
    formatted.map_err(|report| (report, sources))
}
