//! Suggestions for a name that does not exist.

/// The known name with the smallest edit distance; `None` if even that exceeds a third of the length.
pub fn suggestion_among<'a>(
    name: &str,
    candidates: impl Iterator<Item = &'a str>,
) -> Option<String> {
    candidates
        .map(|known| (strsim::damerau_levenshtein(name, known), known))
        .filter(|(distance, known)| *distance <= known.len().max(name.len()) / 3)
        .min()
        .map(|(_, known)| known.to_owned())
}

/// The end of a message about an unknown name: `; did you mean `plan`?`, or an empty string.
pub fn suggestion(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}
