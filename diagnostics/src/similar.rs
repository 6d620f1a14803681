//! Did you mean: the known name that a misspelt one resembles.

/// A longer name is not compared with others: it was not mistyped.
const MAX_LENGTH: usize = 100;

/// How alike two names are, from 0 to 1, where one is offered for the other.
const LIKE: f64 = 0.6;

/// The known name that is most like `name`, if one is like it at all; the first in order of the
/// alphabet where several are.
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
