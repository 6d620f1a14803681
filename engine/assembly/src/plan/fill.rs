//! What was written, or its default.

use crate::At;
use crate::model::Amount;
use crate::scope::{Notes, Scope};

/// A word, or its default.
pub(super) fn given<T: Copy + Default>(word: &Option<At<T>>) -> T {
    word.as_ref().map(|word| word.value).unwrap_or_default()
}

/// A number that was checked not to be negative.
pub(super) fn number(number: &Option<At<i64>>) -> Option<u64> {
    number
        .as_ref()
        .and_then(|number| u64::try_from(number.value).ok())
}

/// A number that may come from a property.
pub(super) fn amount(
    scope: &Scope<'_>,
    name: &str,
    amount: &Option<At<Amount>>,
    least: i64,
    notes: &mut Notes,
) -> Option<u64> {
    let range = least..=crate::read::DAY_MS;
    let number = scope.amount(name, amount.as_ref()?, range, notes)?;
    u64::try_from(number).ok()
}
