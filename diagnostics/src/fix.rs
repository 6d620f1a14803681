//! Ways out that a machine can take.

use crate::diagnostic::Diagnostic;
use crate::span::{FileId, Span};

/// Whether a machine may take the way out without asking.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Applicability {
    /// It keeps the meaning, or no other meaning is lawful.
    Sure,
    /// A person decides: it may not be what was meant.
    Maybe,
}

/// Characters and what to put in their place; an empty `text` deletes, an empty `span` inserts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// The characters to replace.
    pub span: Span,
    /// What to put there.
    pub text: String,
}

/// Edits that mend a finding, all of them together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// What to say about it, as in "did you mean `speed`?".
    pub title: String,
    /// The edits, apart from each other, in one file.
    pub edits: Vec<Edit>,
    /// Whether a machine may do it without asking.
    pub applicability: Applicability,
}

impl Fix {
    /// Replaces one place; a machine may do so without asking.
    pub fn sure(title: impl Into<String>, span: Span, text: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            edits: vec![Edit {
                span,
                text: text.into(),
            }],
            applicability: Applicability::Sure,
        }
    }

    /// Replaces one place, if a person agrees.
    pub fn maybe(title: impl Into<String>, span: Span, text: impl Into<String>) -> Self {
        Self {
            applicability: Applicability::Maybe,
            ..Self::sure(title, span, text)
        }
    }

    /// Replaces another place as well.
    #[must_use]
    pub fn and(mut self, span: Span, text: impl Into<String>) -> Self {
        self.edits.push(Edit {
            span,
            text: text.into(),
        });
        self
    }
}

/// A text after a round of fixes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fixed<'a> {
    /// The new text.
    pub text: String,
    /// The findings whose fix is in it, by place.
    pub applied: Vec<&'a Diagnostic>,
}

/// Applies the sure fixes of one file. Where two meet, the one that stands first is taken; the other
/// has its turn when the new text is read again.
pub fn apply<'a>(text: &str, file: FileId, findings: &'a [Diagnostic]) -> Fixed<'a> {
    let mut offers: Vec<(&Diagnostic, Vec<&Edit>)> = findings
        .iter()
        .filter_map(|finding| Some((finding, lawful(finding.fix.as_ref()?, text, file)?)))
        .collect();
    offers.sort_by_key(|(_, edits)| edits.first().map(|edit| edit.span));
    let mut taken: Vec<&Edit> = Vec::new();
    let mut applied = Vec::new();
    for (finding, edits) in offers {
        let meets = |edit: &&Edit| taken.iter().any(|other| touch(edit.span, other.span));
        if !edits.iter().any(meets) {
            taken.extend(edits);
            applied.push(finding);
        }
    }
    taken.sort_by_key(|edit| edit.span);
    Fixed {
        text: rewritten(text, &taken),
        applied,
    }
}

/// The edits of a sure fix in order, if every one of them lies in this text and none meets another.
fn lawful<'a>(fix: &'a Fix, text: &str, file: FileId) -> Option<Vec<&'a Edit>> {
    let inside = |edit: &Edit| edit.span.file == file && text.get(edit.span.range()).is_some();
    if fix.applicability == Applicability::Maybe || !fix.edits.iter().all(inside) {
        return None;
    }
    let mut edits: Vec<&Edit> = fix.edits.iter().collect();
    edits.sort_by_key(|edit| edit.span);
    let apart = edits
        .windows(2)
        .all(|pair| matches!(pair, [first, second] if !touch(first.span, second.span)));
    (apart && !edits.is_empty()).then_some(edits)
}

/// Whether two places overlap. Two that only adjoin do not, unless both begin at the same byte: who
/// comes first would be a guess.
fn touch(one: Span, other: Span) -> bool {
    one.start == other.start || (one.start < other.end && other.start < one.end)
}

/// The text with edits that are in order and apart.
fn rewritten(text: &str, edits: &[&Edit]) -> String {
    let mut new = String::with_capacity(text.len());
    let mut kept = 0;
    for edit in edits {
        new.push_str(text.get(kept..edit.span.start as usize).unwrap_or(""));
        new.push_str(&edit.text);
        kept = edit.span.end as usize;
    }
    new.push_str(text.get(kept..).unwrap_or(""));
    new
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::Code;
    use crate::diagnostic::Severity;

    const FILE: FileId = FileId(0);

    const CODE: &Code = &Code {
        name: "W000",
        severity: Severity::Warning,
        title: "Something to fix",
        text: "",
    };

    fn at(start: usize, end: usize) -> Span {
        Span::new(FILE, start, end)
    }

    fn finding(fix: Fix) -> Diagnostic {
        Diagnostic::new(CODE, "a finding").with_fix(fix)
    }

    #[test]
    fn it_applies_what_is_sure_and_leaves_what_is_not() {
        let findings = [
            finding(Fix::sure("", at(4, 7), "two")),
            finding(Fix::maybe("", at(0, 3), "ONE")),
        ];
        let fixed = apply("one 2.. three", FILE, &findings);
        assert_eq!(fixed.text, "one two three");
        assert_eq!(fixed.applied, [&findings[0]]);
    }

    #[test]
    fn it_leaves_what_overlaps_to_the_next_round() {
        let findings = [
            finding(Fix::sure("", at(2, 6), "inner")),
            finding(Fix::sure("", at(0, 4), "outer")),
            finding(Fix::sure("", at(4, 6), "beside")),
        ];
        let fixed = apply("abcdefgh", FILE, &findings);
        assert_eq!(fixed.text, "outerbesidegh");
        assert_eq!(fixed.applied.len(), 2);
    }

    #[test]
    fn it_takes_all_edits_of_a_fix_or_none() {
        let wrap = Fix::sure("", at(0, 2), "").and(at(6, 8), "");
        let findings = [finding(wrap.clone()), finding(Fix::sure("", at(7, 8), "x"))];
        assert_eq!(apply("( abc )!", FILE, &findings[1..]).text, "( abc )x");
        assert_eq!(apply("( abc )!", FILE, &findings).text, "abc ");
    }

    #[test]
    fn it_takes_one_of_two_insertions_at_one_place() {
        let insert = |text: &str| finding(Fix::sure("", at(1, 1), text));
        let findings = [insert("x"), insert("y")];
        assert_eq!(apply("ab", FILE, &findings).text, "axb");
    }

    #[test]
    fn it_refuses_what_lies_outside_the_text_or_inside_a_letter() {
        let findings = [
            finding(Fix::sure("", at(1, 9), "")),
            finding(Fix::sure("", at(1, 2), "")),
            finding(Fix::sure("", Span::new(FileId(1), 0, 1), "")),
        ];
        let fixed = apply("ä", FILE, &findings);
        assert_eq!((fixed.text.as_str(), fixed.applied.len()), ("ä", 0));
    }
}
