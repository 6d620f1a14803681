//! Creates coordinators for components implemented by specifications.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_component::{Component, Interface};
use asmotion_coordinator::{Coordinator, Interfaces, PreparedSpecification};
use asmotion_datum::Schema;
use asmotion_plan::Plan;

use super::workshop::{CoordinatorOptions, Make};

/// Creates the component that runs a specification.
pub(super) fn make(
    component: &asmotion_plan::Component,
    prepared: Arc<PreparedSpecification>,
    types: &BTreeMap<String, Schema>,
    options: CoordinatorOptions,
) -> Make {
    let interfaces = interfaces(component, types);
    Box::new(move |interface: &mut Interface| {
        let made = Coordinator::of(prepared, &interfaces, options.seed, interface);
        let mut made = made.map_err(|error| error.to_string())?;
        if options.records_cycles {
            made.record_cycles();
        }
        Ok(Box::new(made) as Box<dyn Component>)
    })
}

/// Returns the options of one coordinator, with a seed of its own.
pub(super) fn options(
    options: CoordinatorOptions,
    component: &asmotion_plan::Component,
    plan: &Plan,
) -> CoordinatorOptions {
    let position = plan.components.position(&component.name);
    CoordinatorOptions {
        seed: options.seed.wrapping_add(position.unwrap_or(0) as u64),
        ..options
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
