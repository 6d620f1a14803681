//! What texts have in common.

/// The value that all of the texts have; `None` if they differ or if there are none.
pub(crate) fn common<'t>(mut texts: impl Iterator<Item = &'t String>) -> Option<&'t str> {
    let first = texts.next()?;
    texts.all(|text| text == first).then_some(first)
}
