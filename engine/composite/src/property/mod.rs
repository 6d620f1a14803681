//! The properties of a composite: declared, set from outside or left at their defaults, and checked.

mod admissible;
mod kind;

use std::path::Path;

use asmotion_diagnostics::{Sources, Span};

pub use self::admissible::lawful;
use self::kind::{accept, from_text};
use crate::codes::c013::UnknownSetting;
use crate::codes::c017::MissingSetting;
use crate::environment::VariableSource;
use crate::finding::Findings;
use crate::model::{Composite, Property, PropertyType, Scalar};
use crate::nearest::nearest_name;
use crate::scope::{OutsideSettings, PropertyScope, SubstitutionNotes};
use crate::tree::{Branch, Node};
use crate::value::SettingValue;

/// The properties of the outermost composite that are set from outside all files: by name and text.
pub fn outside_settings(
    composite: &Composite,
    settings: &[(String, String)],
    notes: &mut SubstitutionNotes,
) -> OutsideSettings {
    let mut set = OutsideSettings::new();
    let properties = &composite.properties;
    for (name, text) in settings {
        let Some(property) = properties.iter().find(|it| it.name.value == *name) else {
            let known = properties.iter().map(|it| it.name.value.as_str());
            notes.found(UnknownSetting {
                name: name.clone(),
                at: None,
                nearest: nearest_name(name, known),
            });
            continue;
        };
        let value = from_text(text, property.kind.value);
        let value = value.unwrap_or_else(|| SettingValue::Text(text.clone()));
        set.insert(name.clone(), (Some(value), None));
    }
    set
}

/// The properties of a composite, with the values that were `set` from outside.
pub fn scope<'s>(
    properties: &[Property],
    mut set: OutsideSettings,
    environment: &'s dyn VariableSource,
    sources: &'s Sources,
    notes: &mut SubstitutionNotes,
) -> PropertyScope<'s> {
    let mut scope = PropertyScope::new(environment, sources);
    for property in properties {
        let name = &property.name;
        let found = match (set.remove(&name.value), &property.default) {
            (Some(set), _) => Some(set),
            (None, Some(node)) => Some((default(&scope, property, node, notes), Some(node.span))),
            (None, None) => {
                let (name, at) = (name.value.clone(), name.span);
                notes.found(MissingSetting { name, at });
                None
            }
        };
        let value = found.and_then(|(value, at)| {
            let value = accept(property, value?, at, notes)?;
            Some(beside(property.kind.value, value, at, sources))
        });
        scope.declare(&name.value, value, name.span);
    }
    scope
}

/// Evaluates a default. Values from the environment are strings, and are parsed as the property's type.
fn default(
    scope: &PropertyScope<'_>,
    property: &Property,
    node: &Node,
    notes: &mut SubstitutionNotes,
) -> Option<SettingValue> {
    let value = scope.node(node, notes)?;
    match (&value, &node.value) {
        (SettingValue::Text(filled), Branch::Text(written)) if filled != written => {
            from_text(filled, property.kind.value).or(Some(value))
        }
        _ => Some(value),
    }
}

/// Resolves a path relative to the folder of the file that contains it, independent of the working directory. Substituted
/// paths are already resolved: a property of this type has passed through this function, and a variable comes from
/// outside all files.
fn beside(
    kind: PropertyType,
    value: SettingValue,
    at: Option<Span>,
    sources: &Sources,
) -> SettingValue {
    let Some(at) =
        at.filter(|at| kind.scalar == Scalar::Path && !sources.snippet(*at).contains("${"))
    else {
        return value;
    };
    match value {
        SettingValue::Text(path) if path.is_empty() => SettingValue::Text(path),
        SettingValue::Text(path) => {
            let folder = Path::new(sources.path(at.file))
                .parent()
                .unwrap_or(Path::new(""));
            SettingValue::Text(folder.join(path).display().to_string())
        }
        SettingValue::List(paths) => {
            let paths = paths
                .into_iter()
                .map(|path| beside(kind, path, Some(at), sources));
            SettingValue::List(paths.collect())
        }
        other @ (SettingValue::Integer(_)
        | SettingValue::Real(_)
        | SettingValue::Boolean(_)
        | SettingValue::Secret(_)
        | SettingValue::Record(_)) => other,
    }
}
