//! "Did you mean": finds the known name that a misspelt one resembles.

/// Names longer than this number of bytes are not compared: they are unlikely to be typing errors.
const MAX_LENGTH: usize = 100;

/// Least similarity, from 0 to 1, for a name to be suggested.
const LIKE: f64 = 0.6;

/// Returns the question "did you mean `name`?", as a help.
pub fn did_you_mean(name: &str) -> String {
    format!("did you mean `{name}`?")
}

/// Returns the end of a message about an unknown name: "; did you mean `name`?", or nothing for `None`.
pub fn or_did_you_mean(name: Option<&str>) -> String {
    name.map_or_else(String::new, |name| format!("; {}", did_you_mean(name)))
}

/// Returns the known name most similar to `name`, or `None` if none is similar enough. Of several
/// equally similar names, the alphabetically first is returned.
pub fn similar<'a, N: AsRef<str>>(
    name: &str,
    known: impl IntoIterator<Item = &'a N>,
) -> Option<&'a N> {
    if name.len() > MAX_LENGTH {
        return None;
    }
    let likeness = |candidate: &str| strsim::normalized_damerau_levenshtein(name, candidate);
    known
        .into_iter()
        .map(|candidate| (likeness(candidate.as_ref()), candidate))
        .filter(|(likeness, candidate)| {
            *likeness >= LIKE || candidate.as_ref().eq_ignore_ascii_case(name)
        })
        .max_by(|(a, x), (b, y)| a.total_cmp(b).then_with(|| y.as_ref().cmp(x.as_ref())))
        .map(|(_, candidate)| candidate)
}
