//! Blanks, comments and annotations between tokens.

use super::{Lexer, word};
use crate::ast::{Annotation, NameText};
use crate::codes::l003::OpenComment;

impl Lexer<'_, '_> {
    pub(crate) fn blanks_and_comments(&mut self) {
        loop {
            let rest = self.rest();
            let length = match rest {
                _ if rest.starts_with("//") => self.line_comment(),
                _ if rest.starts_with("/*") => self.block_comment(),
                _ => rest.len() - rest.trim_start().len(),
            };
            if length == 0 {
                return;
            }
            self.position += length;
        }
    }

    /// Skips `// …` and `//@Name …`, up to the end of the line or of the text.
    fn line_comment(&mut self) -> usize {
        let rest = self.rest();
        let line = rest.split(['\n', '\r']).next().unwrap_or(rest);
        if let Some(note) = line.strip_prefix("//@") {
            self.annotation(note, self.position + "//@".len());
        }
        line.len()
    }

    fn annotation(&mut self, note: &str, start: usize) {
        let (name, rest) = note
            .split_at_checked(word::length(note))
            .unwrap_or((note, ""));
        if !name.is_empty() {
            let span = self.findings.span(start, start + name.len());
            let name = NameText {
                text: name.into(),
                span,
            };
            self.annotations.push(Annotation {
                name,
                rest: rest.trim().to_owned(),
            });
        }
    }

    /// Skips `/* … */`; such comments do not nest.
    fn block_comment(&self) -> usize {
        let rest = self.rest();
        let opener = "/*".len();
        match rest.get(opener..).and_then(|inside| inside.find("*/")) {
            Some(inside) => opener + inside + "*/".len(),
            None => {
                self.findings.report(OpenComment {
                    open: self.next_bytes(opener),
                });
                rest.len()
            }
        }
    }
}
