//! Creates coordinators for components implemented by specifications.

use std::collections::BTreeMap;

use asmotion_component::{Component, Interface};
use asmotion_coordinator::{Coordinator, Interfaces};
use asmotion_datum::Schema;
use asmotion_diagnostics::Loader;

use super::Make;

/// Loads the specification and creates the component that executes it.
pub(super) fn make(
    component: &asmotion_plan::Component,
    file: &str,
    types: &BTreeMap<String, Schema>,
    loader: &dyn Loader,
    seed: u64,
) -> Result<Make, String> {
    let specification = asmotion_lang::open(file, loader).map_err(|failure| failure.to_string())?;
    let binding = component.binding.clone().unwrap_or_default();
    let interfaces = interfaces(component, types);
    Ok(Box::new(move |interface: &mut Interface| {
        let made = Coordinator::new(specification, &binding, &interfaces, seed, interface);
        let made = made.map_err(|error| error.to_string())?;
        Ok(Box::new(made) as Box<dyn Component>)
    }))
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
