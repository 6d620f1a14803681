//! Times of bounded responses: comments `//@Within 2 s` before a property.

use asmotion_diagnostics::{FileId, Span};
use asmotion_lang::Specification;
use std::collections::BTreeMap;

/// A comment `//@Within`.
pub(super) struct WithinComment {
    pub at: Span,
    /// The text after the word.
    pub text: String,
    /// The time in nanoseconds; `None` if it is none.
    pub time_ns: Option<i64>,
}

/// Returns the comments of the files with these properties.
pub(super) fn annotations(
    specification: &Specification,
    files: impl Iterator<Item = FileId>,
) -> Vec<WithinComment> {
    let files: BTreeMap<u32, FileId> = files.map(|file| (file.0, file)).collect();
    let mut found = Vec::new();
    for file in files.into_values() {
        let parsed = asmotion_lang::syntax::parse(file, specification.sources.text(file));
        let annotations = parsed.file.annotations.iter();
        let within = annotations.filter(|it| &*it.name.text == "Within");
        found.extend(within.map(|it| WithinComment {
            at: it.name.span,
            text: it.rest.clone(),
            time_ns: time_ns(&it.rest),
        }));
    }
    found
}

/// Reads a time, as in `2 s`, `200 ms` or `1.5 min`. What follows a further `//` is a comment.
fn time_ns(text: &str) -> Option<i64> {
    let text = text.split("//").next()?.trim();
    let unit = text.find(|sign: char| sign.is_alphabetic())?;
    let (number, unit) = text.split_at_checked(unit)?;
    let factor = match unit.trim() {
        "ms" => 1e6,
        "s" => 1e9,
        "min" => 60e9,
        _ => return None,
    };
    let time: f64 = number.trim().parse().ok()?;
    let time = time * factor;
    // at most a year, so that times of a run do not overflow
    (1.0..=3.2e16).contains(&time).then_some(time as i64)
}

#[cfg(test)]
mod tests {
    use super::time_ns;

    #[test]
    fn a_time_has_a_positive_number_and_a_unit() {
        assert_eq!(time_ns("2 s"), Some(2_000_000_000));
        assert_eq!(time_ns("200ms // of the watchdog"), Some(200_000_000));
        assert_eq!(time_ns("1.5 min"), Some(90_000_000_000));
        for text in [
            "", "2", "s", "0 s", "-1 s", "soon", "2 h", "1e30 s", "NaN s",
        ] {
            assert_eq!(time_ns(text), None, "{text}");
        }
    }
}
