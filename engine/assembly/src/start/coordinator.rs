//! Creates coordinators for components implemented by specifications.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_component::{Component, Interface};
use asmotion_composite::model::PlannedWatch;
use asmotion_coordinator::{Coordinator, GivenProperty, Interfaces, Watch};
use asmotion_datum::Schema;
use asmotion_diagnostics::{FileId, Loader};
use asmotion_plan::Plan;

use super::workshop::{CoordinatorOptions, Make};

/// Loads the specification and creates the component that executes it.
pub(super) fn make(
    component: &asmotion_plan::Component,
    file: &str,
    types: &BTreeMap<String, Schema>,
    loader: &dyn Loader,
    options: CoordinatorOptions,
) -> Result<Make, String> {
    let specification = asmotion_lang::open(file, loader).map_err(|failure| failure.to_string())?;
    let binding = component.binding.clone().unwrap_or_default();
    let interfaces = interfaces(component, types);
    let watch = component.special.watch.as_ref();
    let watch = watch.map(watched).unwrap_or_default();
    Ok(Box::new(move |interface: &mut Interface| {
        let seed = options.seed;
        let made = Coordinator::watching(
            specification,
            &binding,
            &watch,
            &interfaces,
            seed,
            interface,
        );
        let mut made = made.map_err(|error| error.to_string())?;
        if options.records_cycles {
            made.record_cycles();
        }
        Ok(Box::new(made) as Box<dyn Component>)
    }))
}

/// Returns the options of one coordinator, with a seed of its own.
pub(super) fn options(
    options: CoordinatorOptions,
    component: &asmotion_plan::Component,
    plan: &Plan,
) -> CoordinatorOptions {
    let mut components = plan.components.iter();
    let position = components.position(|it| it.name == component.name);
    CoordinatorOptions {
        seed: options.seed.wrapping_add(position.unwrap_or(0) as u64),
        ..options
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

fn interfaces(
    component: &asmotion_plan::Component,
    types: &BTreeMap<String, Schema>,
) -> Interfaces {
    let schema = |kind: &String| {
        let known = types.get(kind).cloned();
        known.unwrap_or_else(|| Schema::opaque(kind.clone()))
    };
    let ports = |ports: &[asmotion_plan::Port]| {
        ports
            .iter()
            .map(|port| (port.name.clone(), schema(&port.kind)))
            .collect()
    };
    let services = |services: &[asmotion_plan::Service]| {
        services
            .iter()
            .map(|it| (it.name.clone(), it.interface.clone()))
            .collect()
    };
    Interfaces {
        inputs: ports(&component.inputs),
        outputs: ports(&component.outputs),
        references: services(&component.references),
        services: services(&component.services),
    }
}
