//! Names of machines before the functions of a term, as in `courier.mode = ASKING`.

/// Returns the machines that a term names, in order of their indices.
pub(crate) fn qualifiers(text: &str, names: &[String]) -> Vec<usize> {
    let is_named = |name: &String| places_of(text, name).next().is_some();
    let named = names.iter().enumerate().filter(|(_, name)| is_named(name));
    named.map(|(index, _)| index).collect()
}

/// Removes the name of a machine before its functions.
pub(crate) fn unqualified(text: &str, name: &str) -> String {
    let mut rest = String::new();
    let mut end = 0;
    for place in places_of(text, name) {
        rest.push_str(text.get(end..place).unwrap_or_default());
        end = place + name.len() + 1;
    }
    rest.push_str(text.get(end..).unwrap_or_default());
    rest
}

/// Returns the places of `NAME.` before a function.
pub(crate) fn places_of<'t>(text: &'t str, name: &'t str) -> impl Iterator<Item = usize> + 't {
    let is_word = |sign: char| sign.is_alphanumeric() || sign == '_' || sign == '$';
    let places = text.match_indices(name).map(|(place, _)| place);
    places.filter(move |place| {
        let before = text.get(..*place).and_then(|it| it.chars().next_back());
        let after = text.get(place + name.len()..).unwrap_or_default();
        let mut after = after.chars();
        !before.is_some_and(|it| is_word(it) || it == '.')
            && after.next() == Some('.')
            && after.next().is_some_and(|sign| sign.is_alphabetic())
    })
}
