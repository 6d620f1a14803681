//! Access to the words and parts of a scenario's text.

use super::command::COMMANDS;
use crate::ast::{NameText, Term};
use crate::codes::v004::IncompleteCommand;
use crate::codes::v005::UnendedCommand;
use crate::fragment::parse_term_in;
use crate::lexer::{Lexer, word_length};
use asmotion_diagnostics::{FileId, Finding, Report, Span};
use std::ops::Range;
use std::sync::Arc;

/// Reads a scenario from beginning to end.
pub(super) struct ScenarioReader<'input, 'run> {
    pub file: FileId,
    pub text: &'input str,
    pub lexer: Lexer<'input, 'run>,
    pub report: Report,
}

impl<'input> ScenarioReader<'input, '_> {
    // ── parts of commands ──

    /// Returns the range up to the `;`, and skips the `;`. If it is missing, the command ends
    /// before the line on which the next one begins.
    pub(super) fn command_range(&mut self, command: Span) -> Range<usize> {
        self.part_behind(self.lexer.position(), command)
    }

    /// Returns the same range for a command whose last word ends at `before`.
    pub(super) fn part_behind(&mut self, before: usize, command: Span) -> Range<usize> {
        self.lexer.blanks_and_comments();
        let start = self.lexer.position();
        let mut end = start;
        loop {
            self.lexer.blanks_and_comments();
            let rest = self.lexer.rest();
            if rest.starts_with(';') {
                self.lexer.pass();
                return start..end;
            }
            if rest.is_empty() || (end > start && self.begins_command()) {
                let last = if end > start { end } else { before };
                self.error(UnendedCommand {
                    command,
                    next: self.here(),
                    end: self.span(last..last),
                });
                return start..end;
            }
            self.lexer.pass();
            end = self.lexer.position();
        }
    }

    /// Skips to the next `;`, or to the line on which the next command begins.
    pub(super) fn skip_command(&mut self) {
        loop {
            self.lexer.blanks_and_comments();
            if self.begins_command() || !self.lexer.pass() {
                return;
            }
            if self.text[..self.lexer.position()].ends_with(';') {
                return;
            }
        }
    }

    /// Returns `true` if a command begins here: its keyword is the first word of a line and not
    /// part of a location.
    pub(super) fn begins_command(&self) -> bool {
        let before = self.text[..self.lexer.position()].trim_end_matches([' ', '\t']);
        let rest = self.lexer.rest();
        let word = rest.get(..word_length(rest)).unwrap_or("");
        let after = rest.get(word.len()..).unwrap_or("").trim_start();
        (before.is_empty() || before.ends_with(['\n', '\r']))
            && COMMANDS.contains(&word)
            && (after.starts_with("//") || !after.starts_with(|c| "(:=<>+-*/.,".contains(c)))
    }

    pub(super) fn term(&mut self, part: Range<usize>) -> Option<Term> {
        let parsed = parse_term_in(self.file, self.text, part);
        self.collect_errors(parsed)
    }

    pub(super) fn collect_errors<T>(&mut self, parsed: Result<T, Report>) -> Option<T> {
        match parsed {
            Ok(part) => Some(part),
            Err(report) => {
                self.report.extend(report);
                None
            }
        }
    }

    // ── words ──

    /// Reads the next word.
    pub(super) fn word(&mut self) -> &'input str {
        let rest = self.lexer.rest();
        let word = rest.get(..word_length(rest)).unwrap_or("");
        self.lexer.start_at(self.lexer.position() + word.len());
        word
    }

    /// Reads the next word if it is `expected`.
    pub(super) fn accept_word(&mut self, word: &str) -> Option<Span> {
        self.lexer.blanks_and_comments();
        let rest = self.lexer.rest();
        let start = self.lexer.position();
        (rest.get(..word_length(rest)) == Some(word)).then(|| {
            self.word();
            self.span(start..start + word.len())
        })
    }

    pub(super) fn accept_sign(&mut self, sign: &str) -> bool {
        self.lexer.blanks_and_comments();
        let is_here = self.lexer.rest().starts_with(sign);
        if is_here {
            self.lexer.start_at(self.lexer.position() + sign.len());
        }
        is_here
    }

    pub(super) fn name(&mut self) -> Option<NameText> {
        self.lexer.blanks_and_comments();
        let start = self.lexer.position();
        let text = self.word();
        (!text.is_empty()).then(|| NameText {
            text: Arc::from(text),
            span: self.span(start..start + text.len()),
        })
    }

    /// Reads the name of a scenario, block or invariant: like the reference, any printable
    /// characters up to a blank, `:`, `;` or a comment.
    pub(super) fn label(&mut self) -> Option<NameText> {
        self.lexer.blanks_and_comments();
        let rest = self.lexer.rest();
        let start = self.lexer.position();
        let text = rest.get(..label_length(rest)).unwrap_or("");
        self.lexer.start_at(start + text.len());
        (!text.is_empty()).then(|| NameText {
            text: Arc::from(text),
            span: self.span(start..start + text.len()),
        })
    }

    pub(super) fn variable(&mut self) -> Option<NameText> {
        self.lexer.blanks_and_comments();
        let start = self.lexer.position();
        if !self.accept_sign("$") {
            return None;
        }
        let name = self.name()?;
        Some(NameText {
            text: Arc::from(format!("${}", name.text)),
            span: self.span(start..start).to(name.span),
        })
    }

    pub(super) fn expected_label(
        &mut self,
        command: &'static str,
        expected: &'static str,
        form: &'static str,
        at: Span,
    ) -> Option<NameText> {
        let name = self.label();
        if name.is_none() {
            self.incomplete(command, expected, form, at);
        }
        name
    }

    pub(super) fn incomplete(
        &mut self,
        command: &'static str,
        expected: &'static str,
        form: &'static str,
        at: Span,
    ) {
        self.error(IncompleteCommand {
            command,
            expected,
            form,
            at,
        });
        self.skip_command();
    }

    // ── spans ──

    pub(super) fn span(&self, range: Range<usize>) -> Span {
        Span::new(self.file, range.start, range.end.min(self.text.len()))
    }

    /// Returns the span of the next word or character.
    pub(super) fn here(&self) -> Span {
        let start = self.lexer.position();
        let rest = self.lexer.rest();
        let length = match word_length(rest) {
            0 => rest.chars().next().map_or(0, char::len_utf8),
            length => length,
        };
        self.span(start..start + length)
    }

    pub(super) fn error(&mut self, error: impl Finding) {
        self.report.push(error.diagnostic());
    }
}

/// Returns the length of the name of a scenario, block or invariant at the beginning of a text.
fn label_length(text: &str) -> usize {
    let ends = |c: char| c.is_whitespace() || c.is_control() || c == ':' || c == ';';
    let length = text.find(ends).unwrap_or(text.len());
    let comment = ["//", "/*"].iter().filter_map(|opening| text.find(opening));
    comment.fold(length, usize::min)
}
