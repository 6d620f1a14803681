//! Completes the resolved composites: propagates interfaces across composites, assumes the missing ones, and adds
//! callbacks.

use crate::codes::x004::NoCounterpart;
use crate::codes::x008::AssumedValue;
use std::collections::BTreeMap;

use asmotion_composite::At;
use asmotion_diagnostics::{Finding, Report};

use crate::model::{
    ScdlComposite, ScdlContract, ScdlImplementation, ScdlInterface, ScdlTarget, ScdlWire,
};
use crate::name;
use crate::resolve::{ContractSide, complete, contract, interface, interfaces};

/// Completes all resolved composites. `order` contains nested composites before those that nest them.
pub(crate) fn complete_all(
    composites: &mut BTreeMap<String, ScdlComposite>,
    order: &[String],
    report: &mut Report,
) {
    propagate_interfaces(composites);
    for name in order {
        while composites
            .get_mut(name)
            .is_some_and(|composite| assume(composite, report))
        {
            propagate_interfaces(composites);
        }
    }
    for composite in composites.values_mut() {
        callbacks(composite, report);
    }
}

/// Propagates interfaces between composites and those that nest them, until nothing changes.
fn propagate_interfaces(composites: &mut BTreeMap<String, ScdlComposite>) {
    while upwards(composites) || downwards(composites) {}
}

/// Propagates the interfaces of nested composites to the promotions that use them. Returns whether anything changed.
fn upwards(composites: &mut BTreeMap<String, ScdlComposite>) -> bool {
    let promoted =
        |composite: &ScdlComposite| (composite.services.clone(), composite.references.clone());
    let promoted: BTreeMap<String, _> = composites
        .iter()
        .map(|(name, composite)| (name.clone(), promoted(composite)))
        .collect();
    let mut news = false;
    for composite in composites.values_mut() {
        let mut here = false;
        for component in &mut composite.components {
            if let Some(ScdlImplementation::Composite(name)) = &component.implementation
                && let Some((services, references)) = promoted.get(&name.value)
            {
                here |= complete(&mut component.services, services.clone());
                here |= complete(&mut component.references, references.clone());
            }
        }
        if here {
            interfaces(composite);
        }
        news |= here;
    }
    news
}

/// Propagates the interfaces in composites to those that they nest. Returns whether anything changed.
fn downwards(composites: &mut BTreeMap<String, ScdlComposite>) -> bool {
    let mut facts = Vec::new();
    for component in composites.values().flat_map(|it| &it.components) {
        let Some(ScdlImplementation::Composite(nested)) = &component.implementation else {
            continue;
        };
        for side in [ContractSide::Service, ContractSide::Reference] {
            for contract in side.of(component) {
                let interface = contract.interface.clone();
                let fact =
                    interface.map(|it| (nested.value.clone(), side, contract.name.clone(), it));
                facts.extend(fact);
            }
        }
    }
    let mut news = false;
    for (nested, side, name, interface) in facts {
        let Some(nested) = composites.get_mut(&nested) else {
            continue;
        };
        let mut promotions = side.promoted(nested).iter_mut();
        let promotion = promotions.find(|it| it.name.value == name.value);
        if let Some(promotion) = promotion.filter(|it| it.interface.is_none()) {
            promotion.interface = Some(interface);
            interfaces(nested);
            news = true;
        }
    }
    news
}

/// Assumes an interface for one contract that has none, named after the contract, and reports it. Returns whether there
/// was one.
fn assume(composite: &mut ScdlComposite, report: &mut Report) -> bool {
    let of = composite.name.value.clone();
    for component in &mut composite.components {
        // a nested composite declares its interfaces in its own file
        if matches!(
            component.implementation,
            Some(ScdlImplementation::Composite(_))
        ) {
            continue;
        }
        let owner = component.name.value.clone();
        let mut listed = component
            .services
            .iter_mut()
            .chain(&mut component.references);
        let Some(contract) = listed.find(|it| it.interface.is_none()) else {
            continue;
        };
        let assumed = format!("{of}/{}", contract.name.value);
        let at = contract.name.span;
        let finding = AssumedValue {
            what: "the interface",
            of: format!("{owner}.{}", contract.name.value),
            assumed: assumed.clone(),
            at,
        };
        report.push(finding.diagnostic());
        contract.interface = Some(ScdlInterface {
            name: At::new(assumed, at),
            callback: None,
        });
        interfaces(composite);
        return true;
    }
    false
}

/// Adds callbacks: a callback is a reference of the provider and a service of the caller, wired in the opposite
/// direction. The callback of a promoted service or reference is promoted too.
fn callbacks(composite: &mut ScdlComposite, report: &mut Report) {
    for component in &mut composite.components {
        let called = |of: &[ScdlContract]| of.iter().filter_map(callback).collect::<Vec<_>>();
        let (back, forth) = (called(&component.services), called(&component.references));
        complete(&mut component.references, back);
        complete(&mut component.services, forth);
    }
    let wires = composite.wires.iter().filter_map(|wire| {
        interface(composite, (&wire.source, ContractSide::Reference))?.callback?;
        Some(ScdlWire {
            source: back(&wire.target),
            target: back(&wire.source),
        })
    });
    let wires: Vec<ScdlWire> = wires.collect();
    composite.wires.extend(wires);
    let of_services = promoted_callbacks(composite, ContractSide::Service, report);
    let of_references = promoted_callbacks(composite, ContractSide::Reference, report);
    composite.references.extend(of_services);
    composite.services.extend(of_references);
}

/// The promotions of the callbacks of promoted services or references. A reference is either wired or promoted, so a
/// callback that is wired inside the composite cannot be promoted.
fn promoted_callbacks(
    composite: &mut ScdlComposite,
    side: ContractSide,
    report: &mut Report,
) -> Vec<ScdlContract> {
    let wired: Vec<String> = composite
        .wires
        .iter()
        .map(|it| it.source.to_string())
        .collect();
    let mut promoted = Vec::new();
    for promotion in side.promoted(composite) {
        let Some(callback) = callback(promotion) else {
            continue;
        };
        let ends: Vec<ScdlTarget> = promotion.promote.iter().map(back).collect();
        if ends.iter().any(|end| wired.contains(&end.to_string())) {
            let what = format!("the callback of {}", promotion.name.value);
            promotion.notes.push(what.clone());
            let at = promotion.name.span;
            report.push(NoCounterpart { what, at }.diagnostic());
        } else {
            promoted.push(ScdlContract {
                promote: ends,
                ..callback
            });
        }
    }
    promoted
}

/// The contract of a callback, if the interface has one.
fn callback(of: &ScdlContract) -> Option<ScdlContract> {
    let interface = ScdlInterface {
        name: of.interface.as_ref()?.callback.clone()?,
        callback: None,
    };
    let name = of.name.clone().map(|name| name::callback(&name));
    let mut callback = contract(name, Some(interface));
    callback.multiplicity.optional = true;
    Some(callback)
}

/// The callback of an end of a wire.
fn back(end: &ScdlTarget) -> ScdlTarget {
    ScdlTarget {
        component: end.component.clone(),
        name: end
            .name
            .clone()
            .map(|name| name.map(|name| name::callback(&name))),
    }
}
