//! Misspelt keywords.

/// Words longer than this number of bytes are not compared: they are unlikely to be typing errors.
const MAX_LENGTH: usize = 100;

/// Returns the candidate that differs from `written` by a typing error, regardless of case, or that
/// is a prefix of it.
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
        let is_prefix = written.len() >= 3 && word.starts_with(&written);
        if is_prefix {
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
