//! Completes what SCDL leaves to the implementation or the runtime: services and references that are not listed,
//! targets without a service, interfaces, callbacks, and autowire.

use crate::codes::x006::UnknownScdlName;
use crate::codes::x009::AmbiguousAutowire;
use std::collections::BTreeMap;

use asmotion_composite::{At, Catalogue};
use asmotion_diagnostics::{Finding, Report, similar};

use crate::model::{
    ScdlComponent, ScdlComposite, ScdlContract, ScdlImplementation, ScdlInterface,
    ScdlMultiplicity, ScdlTarget, ScdlWire,
};
use crate::name;

/// Completes a composite. `nested` contains the composites resolved before.
pub(crate) fn resolve(
    composite: &mut ScdlComposite,
    nested: &BTreeMap<String, ScdlComposite>,
    catalogue: &dyn Catalogue,
    report: &mut Report,
) {
    for component in &mut composite.components {
        declared(component, nested, catalogue);
    }
    let mut targets = targets(composite);
    composite.wires.append(&mut targets);
    autowire(composite, report);
    let mut wires = std::mem::take(&mut composite.wires);
    wires.retain_mut(|wire| self::wire(composite, wire, report));
    composite.wires = wires;
    promote(composite, report);
    interfaces(composite);
}

/// A service or reference that is declared nowhere but in its use.
pub(crate) fn contract(name: At<String>, interface: Option<ScdlInterface>) -> ScdlContract {
    ScdlContract {
        name,
        interface,
        bindings: Vec::new(),
        promote: Vec::new(),
        targets: Vec::new(),
        multiplicity: ScdlMultiplicity::default(),
        autowire: None,
        notes: Vec::new(),
    }
}

/// Adds the services and references that the implementation declares: a built-in component or a composite.
fn declared(
    component: &mut ScdlComponent,
    nested: &BTreeMap<String, ScdlComposite>,
    catalogue: &dyn Catalogue,
) {
    let at = component.name.span;
    let named = |name: &str, interface: &str| {
        let interface = ScdlInterface {
            name: At::new(interface.to_owned(), at),
            callback: None,
        };
        contract(At::new(name.to_owned(), at), Some(interface))
    };
    let (services, references) = match &component.implementation {
        Some(ScdlImplementation::Java(class)) => {
            let Some(declaration) = catalogue.declaration(&name::component(class)) else {
                return;
            };
            let services = declaration.services.iter();
            let references = declaration.references.iter().map(|it| {
                let mut reference = named(&it.name, &it.interface);
                reference.multiplicity.optional = it.optional;
                reference
            });
            let services = services.map(|it| named(&it.name, &it.interface));
            (services.collect(), references.collect())
        }
        Some(ScdlImplementation::Composite(name)) => match nested.get(&name.value) {
            Some(nested) => (nested.services.clone(), nested.references.clone()),
            None => return,
        },
        Some(ScdlImplementation::Asm(_) | ScdlImplementation::Python(_)) | None => return,
    };
    complete(&mut component.services, services);
    complete(&mut component.references, references);
}

/// Adds declared contracts to the listed ones, and interfaces to those that lack one. Returns whether anything changed.
pub(crate) fn complete(listed: &mut Vec<ScdlContract>, declared: Vec<ScdlContract>) -> bool {
    let mut news = false;
    for declared in declared {
        match listed
            .iter_mut()
            .find(|it| it.name.value == declared.name.value)
        {
            Some(listed) => {
                news |= listed.interface.is_none() && declared.interface.is_some();
                listed.interface = listed.interface.take().or(declared.interface);
            }
            None => {
                news = true;
                listed.push(ScdlContract {
                    promote: Vec::new(),
                    bindings: Vec::new(),
                    ..declared
                });
            }
        }
    }
    news
}

/// Converts the targets of references to wires.
fn targets(composite: &mut ScdlComposite) -> Vec<ScdlWire> {
    let mut wires = Vec::new();
    for component in &mut composite.components {
        for reference in &mut component.references {
            for target in std::mem::take(&mut reference.targets) {
                let source = ScdlTarget {
                    component: component.name.clone(),
                    name: Some(reference.name.clone()),
                };
                wires.push(ScdlWire { source, target });
            }
        }
    }
    wires
}

/// Wires each reference with `autowire` to the only service with its interface.
fn autowire(composite: &mut ScdlComposite, report: &mut Report) {
    let mut wires = Vec::new();
    for component in &composite.components {
        for reference in &component.references {
            let is_autowired = reference.autowire.or(component.autowire);
            let is_end = |end: &ScdlTarget| {
                let name = end.name.as_ref().map(|name| &name.value);
                end.component.value == component.name.value
                    && name.is_none_or(|name| *name == reference.name.value)
            };
            let wired = composite.wires.iter().any(|wire| is_end(&wire.source));
            let promoted = composite
                .references
                .iter()
                .flat_map(|it| &it.promote)
                .any(is_end);
            let bound = reference.url().is_some();
            if !is_autowired.unwrap_or(composite.autowire) || wired || promoted || bound {
                continue;
            }
            let source = ScdlTarget {
                component: component.name.clone(),
                name: Some(reference.name.clone()),
            };
            match answering(composite, component, reference).as_slice() {
                [target] => wires.push(ScdlWire {
                    source,
                    target: target.clone(),
                }),
                [] if reference.multiplicity.optional => {}
                several => {
                    let finding = AmbiguousAutowire {
                        reference: source.to_string(),
                        services: several.iter().map(ScdlTarget::to_string).collect(),
                        at: reference.name.span,
                    };
                    report.push(finding.diagnostic());
                }
            }
        }
    }
    composite.wires.append(&mut wires);
}

/// The services of other components that have the interface of a reference.
fn answering(
    composite: &ScdlComposite,
    of: &ScdlComponent,
    reference: &ScdlContract,
) -> Vec<ScdlTarget> {
    let required = reference.interface.as_ref().map(|it| &it.name.value);
    let others = composite.components.iter();
    let others = others.filter(|other| other.name.value != of.name.value);
    let services = others.flat_map(|other| other.services.iter().map(move |it| (other, it)));
    let same = services.filter(|(_, service)| {
        let interface = service.interface.as_ref().map(|it| &it.name.value);
        required.is_some() && interface == required
    });
    same.map(|(other, service)| ScdlTarget {
        component: other.name.clone(),
        name: Some(service.name.clone()),
    })
    .collect()
}

/// Selects the services or the references of a component.
#[derive(Clone, Copy)]
pub(crate) enum ContractSide {
    Service,
    Reference,
}

impl ContractSide {
    pub(crate) fn of(self, component: &ScdlComponent) -> &Vec<ScdlContract> {
        match self {
            Self::Service => &component.services,
            Self::Reference => &component.references,
        }
    }

    pub(crate) fn promoted(self, composite: &mut ScdlComposite) -> &mut Vec<ScdlContract> {
        match self {
            Self::Service => &mut composite.services,
            Self::Reference => &mut composite.references,
        }
    }

    fn of_mut(self, component: &mut ScdlComponent) -> &mut Vec<ScdlContract> {
        match self {
            Self::Service => &mut component.services,
            Self::Reference => &mut component.references,
        }
    }
}

/// Completes both ends of a wire. Returns `false` if a component does not exist.
fn wire(composite: &mut ScdlComposite, wire: &mut ScdlWire, report: &mut Report) -> bool {
    let source = end(
        composite,
        &mut wire.source,
        ContractSide::Reference,
        None,
        report,
    );
    let like = wire.source.name.clone();
    let like = like.as_ref().and_then(|name| {
        let found = find(
            composite,
            &wire.source.component,
            ContractSide::Reference,
            name,
        );
        found.map(|reference| (name.clone(), reference.interface.clone()))
    });
    source
        && end(
            composite,
            &mut wire.target,
            ContractSide::Service,
            like,
            report,
        )
}

fn find<'c>(
    composite: &'c ScdlComposite,
    component: &str,
    side: ContractSide,
    name: &str,
) -> Option<&'c ScdlContract> {
    let component = composite
        .components
        .iter()
        .find(|it| it.name.value == component)?;
    side.of(component).iter().find(|it| it.name.value == name)
}

/// Completes an end that names only its component, and lists the service or reference there. `like` describes the
/// reference to be wired.
fn end(
    composite: &mut ScdlComposite,
    end: &mut ScdlTarget,
    side: ContractSide,
    like: Option<(At<String>, Option<ScdlInterface>)>,
    report: &mut Report,
) -> bool {
    let mut components = composite.components.iter_mut();
    let Some(component) = components.find(|it| it.name.value == end.component.value) else {
        let known = composite.components.iter();
        let known: Vec<&String> = known.map(|component| &component.name.value).collect();
        let similar_name = similar(&end.component, &known).copied();
        let mut known = composite.components.iter();
        let finding = UnknownScdlName {
            what: "component",
            name: end.component.value.clone(),
            nearest: similar_name
                .and_then(|near| known.find(|it| it.name.value == *near))
                .map(|it| it.name.clone()),
            at: end.component.span,
        };
        report.push(finding.diagnostic());
        return false;
    };
    let listed = side.of_mut(component);
    let (name, interface) = match (&end.name, like) {
        (Some(name), like) => (name.clone(), like.and_then(|(_, interface)| interface)),
        (None, like) => {
            let (name, interface) = candidate(listed, like, &end.component);
            end.name = Some(name.clone());
            (name, interface)
        }
    };
    if !listed.iter().any(|it| it.name.value == name.value) {
        listed.push(contract(name, interface));
    }
    true
}

/// Selects the contract for an end that names none: the only one, the one with the interface, or the one that Java
/// would name after the interface.
fn candidate(
    listed: &[ScdlContract],
    like: Option<(At<String>, Option<ScdlInterface>)>,
    component: &At<String>,
) -> (At<String>, Option<ScdlInterface>) {
    if let [only] = listed {
        return (only.name.clone(), None);
    }
    let Some((name, interface)) = like else {
        return (component.clone(), None);
    };
    let required = interface.as_ref().map(|it| &it.name.value);
    let same = listed.iter().find(|it| {
        required.is_some() && it.interface.as_ref().map(|it| &it.name.value) == required
    });
    match (same, required) {
        (Some(same), _) => (same.name.clone(), None),
        (None, Some(required)) => {
            let name = At::new(name::simple(required).to_owned(), component.span);
            (name, interface)
        }
        (None, None) => (At::new(name.value, component.span), None),
    }
}

/// Completes the ends of promotions; removes promotions of unknown components.
fn promote(composite: &mut ScdlComposite, report: &mut Report) {
    for side in [ContractSide::Service, ContractSide::Reference] {
        let mut promotions = std::mem::take(side.promoted(composite));
        for promotion in &mut promotions {
            let like = (promotion.name.clone(), promotion.interface.clone());
            promotion
                .promote
                .retain_mut(|target| end(composite, target, side, Some(like.clone()), report));
        }
        *side.promoted(composite) = promotions;
    }
}

/// Propagates interfaces along wires and promotions until nothing changes: connected contracts have the same interface.
pub(crate) fn interfaces(composite: &mut ScdlComposite) {
    loop {
        let mut news = false;
        for wire in composite.wires.clone() {
            let ends = [
                (&wire.source, ContractSide::Reference),
                (&wire.target, ContractSide::Service),
            ];
            news |= agree(composite, &ends);
        }
        for side in [ContractSide::Service, ContractSide::Reference] {
            for promotion in side.promoted(composite).clone() {
                for target in &promotion.promote {
                    set_interface(
                        composite,
                        (target, side),
                        promotion.interface.as_ref(),
                        &mut news,
                    );
                }
                let known = promotion
                    .promote
                    .iter()
                    .find_map(|target| interface(composite, (target, side)));
                let mut same = side.promoted(composite).iter_mut();
                let same = same.find(|it| it.name.value == promotion.name.value);
                if let Some(same) = same.filter(|it| it.interface.is_none() && known.is_some()) {
                    same.interface = known;
                    news = true;
                }
            }
        }
        if !news {
            return;
        }
    }
}

pub(crate) fn interface(
    composite: &ScdlComposite,
    (end, side): (&ScdlTarget, ContractSide),
) -> Option<ScdlInterface> {
    let name = end.name.as_ref()?;
    find(composite, &end.component, side, name)?
        .interface
        .clone()
}

/// Propagates the interface of each end to the other. Returns whether anything changed.
fn agree(composite: &mut ScdlComposite, ends: &[(&ScdlTarget, ContractSide); 2]) -> bool {
    let mut news = false;
    let [one, other] = *ends;
    for (from, to) in [(one, other), (other, one)] {
        let known = interface(composite, from);
        set_interface(composite, to, known.as_ref(), &mut news);
    }
    news
}

fn set_interface(
    composite: &mut ScdlComposite,
    (end, side): (&ScdlTarget, ContractSide),
    known: Option<&ScdlInterface>,
    news: &mut bool,
) {
    let Some(known) = known else {
        return;
    };
    let mut components = composite.components.iter_mut();
    let component = components.find(|it| it.name.value == end.component.value);
    let contract = component.and_then(|component| {
        let mut listed = side.of_mut(component).iter_mut();
        listed.find(|it| Some(&it.name.value) == end.name.as_ref().map(|name| &name.value))
    });
    if let Some(contract) = contract.filter(|it| it.interface.is_none()) {
        contract.interface = Some(known.clone());
        *news = true;
    }
}
