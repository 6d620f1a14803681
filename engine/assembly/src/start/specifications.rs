//! The specifications of the components of a system.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_composite::model::PlannedWatch;
use asmotion_coordinator::{GivenProperty, PreparedSpecification, Watch};
use asmotion_diagnostics::{FileId, Loader};

/// The specifications that have been loaded and prepared, so that components with the same file, bindings and watched
/// properties share one.
pub(super) struct PreparedSpecifications<'a> {
    loader: &'a dyn Loader,
    /// By file.
    prepared: BTreeMap<String, Vec<Arc<PreparedSpecification>>>,
}

impl<'a> PreparedSpecifications<'a> {
    pub fn new(loader: &'a dyn Loader) -> Self {
        Self {
            loader,
            prepared: BTreeMap::new(),
        }
    }

    /// Returns the specification of a component.
    ///
    /// # Errors
    /// The file cannot be opened, or the bindings or the watched properties do not fit it, as text.
    pub fn prepared(
        &mut self,
        component: &asmotion_plan::Component,
        file: &str,
    ) -> Result<Arc<PreparedSpecification>, String> {
        let binding = component.binding.clone().unwrap_or_default();
        let watch = component.special.watch.as_ref();
        let watch = watch.map(watched).unwrap_or_default();
        let known = self.prepared.entry(file.to_owned()).or_default();
        if let Some(found) = known.iter().find(|it| it.has(&binding, &watch)) {
            return Ok(found.clone());
        }
        let opened = asmotion_lang::open(file, self.loader);
        let specification = opened.map_err(|failure| failure.to_string())?;
        let made = PreparedSpecification::new(specification, binding, &watch);
        let made = Arc::new(made.map_err(|error| error.to_string())?);
        known.push(made.clone());
        Ok(made)
    }
}

/// Returns the texts of a specification and its imports, in the order in which they are loaded; empty if it cannot be
/// opened.
pub(crate) fn texts(file: &str, loader: &dyn Loader) -> Vec<Arc<str>> {
    let Ok(specification) = asmotion_lang::open(file, loader) else {
        return Vec::new();
    };
    let sources = &specification.sources;
    let files = (0..).map(FileId);
    let files = files.take_while(|file| !sources.path(*file).is_empty());
    files.map(|file| sources.shared_text(file)).collect()
}

fn watched(keys: &PlannedWatch) -> Watch {
    let properties = keys.properties.iter().map(|it| GivenProperty {
        text: it.property.clone(),
        within_ns: it
            .within_ms
            .and_then(|ms| i64::try_from(ms).ok()?.checked_mul(1_000_000)),
    });
    Watch {
        is_off: !keys.temporal,
        safe_rule: keys.safe_rule.clone(),
        properties: properties.collect(),
    }
}
