//! Resolves the property values of a component.

use super::PartSource;
use crate::plan::PropertyValues;
use asmotion_composite::property::lawful;
use asmotion_composite::scope::{OutsideSettings, SubstitutionNotes};

/// Returns the values set in the file, in file order, followed by those set from outside.
pub(super) fn properties(
    source: &PartSource<'_>,
    mut set: OutsideSettings,
    notes: &mut SubstitutionNotes,
) -> PropertyValues {
    let declaration = source
        .member
        .declaration(source.component, source.catalogue);
    let order = source
        .component
        .properties
        .iter()
        .map(|setting| setting.name.value.clone());
    let names: Vec<String> = order.collect();
    let later: Vec<String> = set
        .keys()
        .filter(|name| !names.contains(name))
        .cloned()
        .collect();
    let mut settings = PropertyValues::default();
    for name in names.into_iter().chain(later) {
        let Some((Some(value), at)) = set.remove(&name) else {
            continue;
        };
        let declared = declaration.as_ref().and_then(|declaration| {
            declaration
                .properties
                .iter()
                .find(|property| property.name == name)
        });
        let value = match declared {
            Some(declared) => lawful(declared, value, at, notes),
            None => Some(value),
        };
        settings.0.extend(value.map(|value| (name, value)));
    }
    settings
}
