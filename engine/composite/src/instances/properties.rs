//! Properties of the composite in `for`, as in `"$r in 1..${properties.robots}"`.

use std::collections::{BTreeMap, BTreeSet};

use super::range::written;
use crate::tree::{Branch, Node, Table};

/// Beginning of a property in a string.
const OPEN: &str = "${properties.";

/// The values of properties when a composite is read.
pub(crate) struct RangeProperties {
    /// The texts by name; `None` if the value is known later only.
    values: BTreeMap<String, Option<String>>,
}

impl RangeProperties {
    /// The properties of the tree of a composite: their defaults, and those that are set from outside in their place.
    pub(crate) fn new(tree: &Table, settings: &[(String, String)]) -> Self {
        let mut values = BTreeMap::new();
        if let Some(declared) = tree.get("properties")
            && let Branch::Table(declared) = &declared.node.value
        {
            for property in &declared.entries {
                values.insert(property.key.value.clone(), default(&property.node));
            }
        }
        for (name, text) in settings {
            // an unknown one is reported where settings are checked
            values
                .entry(name.clone())
                .and_modify(|value| *value = Some(text.clone()));
        }
        Self { values }
    }

    /// Substitutes the properties in a range, and adds their names to `used`.
    ///
    /// # Errors
    /// The reason that one has no value.
    pub(super) fn substitute(
        &self,
        range: &mut Node,
        used: &mut BTreeSet<String>,
    ) -> Result<(), String> {
        let Branch::Text(text) = &mut range.value else {
            return Ok(());
        };
        while let Some((before, rest)) = text.split_once(OPEN) {
            let Some((name, after)) = rest.split_once('}') else {
                return Ok(());
            };
            used.insert(name.to_owned());
            let value = match self.values.get(name) {
                None => return Err(format!("the composite has no property `{name}`")),
                Some(None) => {
                    return Err(format!(
                        "the property `{name}` has no value yet: it needs a default that is written here"
                    ));
                }
                Some(Some(value)) => value,
            };
            *text = format!("{before}{value}{after}");
        }
        Ok(())
    }
}

/// The default of a declared property; `None` without one, or if it depends on the environment.
fn default(declared: &Node) -> Option<String> {
    let Branch::Table(keys) = &declared.value else {
        return None;
    };
    let text = written(&keys.get("default")?.node.value)?;
    (!text.contains("${")).then_some(text)
}
