//! Words that are nearly other words.

/// A longer word is no slip of the finger.
const MAX_LENGTH: usize = 100;

/// The candidate that differs from `written` by a slip of the finger, in whatever case, or that
/// `written` begins.
pub(crate) fn nearest<'a>(
    written: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    if written.len() > MAX_LENGTH {
        return None;
    }
    let written = written.to_lowercase();
    let slips = |word: &str| {
        let word = word.to_lowercase();
        let begun = written.len() >= 3 && word.starts_with(&written);
        if begun {
            1
        } else {
            strsim::damerau_levenshtein(&written, &word)
        }
    };
    let (slips, word) = candidates
        .into_iter()
        .map(|word| (slips(word), word))
        .min()?;
    let forgiven = match word.len() {
        0..3 => 0,
        3..5 => 1,
        _ => 2,
    };
    (slips <= forgiven).then_some(word)
}
