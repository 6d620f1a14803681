//! Applies fixes to a text.

use crate::diagnostic::Diagnostic;
use crate::fix::{Applicability, Edit, Fix};
use crate::span::{FileId, Span};

/// Result of [`apply`]: the edited text and the findings it resolves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fixed<'a> {
    /// The text after all applied edits.
    pub text: String,
    /// The findings whose fix was applied, in order of their position.
    pub applied: Vec<&'a Diagnostic>,
}

/// Applies the sure fixes of one file. Of two that overlap, only the one that starts first is
/// applied; the caller checks the new text again and applies the other in the next round.
pub fn apply<'a>(text: &str, file: FileId, findings: &'a [Diagnostic]) -> Fixed<'a> {
    let mut offers: Vec<(&Diagnostic, Vec<&Edit>)> = findings
        .iter()
        .filter_map(|finding| Some((finding, valid_edits(finding.fix.as_ref()?, text, file)?)))
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

/// Returns the edits of a sure fix in order, or `None` if one lies outside this text or two
/// overlap.
fn valid_edits<'a>(fix: &'a Fix, text: &str, file: FileId) -> Option<Vec<&'a Edit>> {
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

/// Returns `true` if two ranges overlap. Adjacent ranges do not, unless both start at the same
/// byte: two insertions there have no defined order.
fn touch(one: Span, other: Span) -> bool {
    one.start == other.start || (one.start < other.end && other.start < one.end)
}

/// Applies edits that are sorted and do not overlap.
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
    use crate::severity::Severity;

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
