//! The properties of a component, as it takes them.

use super::Source;
use crate::lawful::lawful;
use crate::model;
use crate::plan::Settings;
use crate::scope::{Notes, Set};

/// The properties that are set, in the order of the file, then those set from outside.
pub(super) fn properties(source: &Source<'_>, mut set: Set, notes: &mut Notes) -> Settings {
    let declaration = match &source.component.implementation {
        Some(model::Implementation::Rust(name)) => source.catalogue.declaration(name),
        _ => None,
    };
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
    let mut settings = Settings::default();
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
