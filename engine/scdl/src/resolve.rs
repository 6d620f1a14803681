//! What SCDL leaves to the implementation, or to the runtime: services and references that are not
//! listed, targets without a service, interfaces, callbacks, autowire.

use crate::codes::x006::UnknownScdlName;
use crate::codes::x009::AmbiguousAutowire;
use std::collections::BTreeMap;

use asmotion_assembly::{At, Catalogue};
use asmotion_diagnostics::{Finding, Report, similar};

use crate::model::{
    Component, Composite, Contract, Implementation, Interface, Multiplicity, Target, Wire,
};
use crate::name;

/// Finds out what a composite leaves open. `nested` are those that were resolved before.
pub(crate) fn resolve(
    composite: &mut Composite,
    nested: &BTreeMap<String, Composite>,
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

/// A service or reference that is named nowhere but where it is used.
pub(crate) fn contract(name: At<String>, interface: Option<Interface>) -> Contract {
    Contract {
        name,
        interface,
        bindings: Vec::new(),
        promote: Vec::new(),
        targets: Vec::new(),
        multiplicity: Multiplicity::default(),
        autowire: None,
        notes: Vec::new(),
    }
}

/// What the implementation says of itself: a component of the build, or a composite.
fn declared(
    component: &mut Component,
    nested: &BTreeMap<String, Composite>,
    catalogue: &dyn Catalogue,
) {
    let at = component.name.span;
    let named = |name: &str, interface: &str| {
        let interface = Interface {
            name: At::new(interface.to_owned(), at),
            callback: None,
        };
        contract(At::new(name.to_owned(), at), Some(interface))
    };
    let (services, references) = match &component.implementation {
        Some(Implementation::Java(class)) => {
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
        Some(Implementation::Composite(name)) => match nested.get(&name.value) {
            Some(nested) => (nested.services.clone(), nested.references.clone()),
            None => return,
        },
        Some(Implementation::Asm(_) | Implementation::Python(_)) | None => return,
    };
    complete(&mut component.services, services);
    complete(&mut component.references, references);
}

/// Adds what is declared to what is listed. Says whether that was news.
pub(crate) fn complete(listed: &mut Vec<Contract>, declared: Vec<Contract>) -> bool {
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
                listed.push(Contract {
                    promote: Vec::new(),
                    bindings: Vec::new(),
                    ..declared
                });
            }
        }
    }
    news
}

/// The wires that stand at references.
fn targets(composite: &mut Composite) -> Vec<Wire> {
    let mut wires = Vec::new();
    for component in &mut composite.components {
        for reference in &mut component.references {
            for target in std::mem::take(&mut reference.targets) {
                let source = Target {
                    component: component.name.clone(),
                    name: Some(reference.name.clone()),
                };
                wires.push(Wire { source, target });
            }
        }
    }
    wires
}

/// Wires the references that find their service by themselves: the one with their interface.
fn autowire(composite: &mut Composite, report: &mut Report) {
    let mut wires = Vec::new();
    for component in &composite.components {
        for reference in &component.references {
            let wanted = reference.autowire.or(component.autowire);
            let is_end = |end: &Target| {
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
            if !wanted.unwrap_or(composite.autowire) || wired || promoted {
                continue;
            }
            let source = Target {
                component: component.name.clone(),
                name: Some(reference.name.clone()),
            };
            match answering(composite, component, reference).as_slice() {
                [target] => wires.push(Wire {
                    source,
                    target: target.clone(),
                }),
                [] if reference.multiplicity.optional => {}
                several => {
                    let finding = AmbiguousAutowire {
                        reference: source.to_string(),
                        services: several.iter().map(Target::to_string).collect(),
                        at: reference.name.span,
                    };
                    report.push(finding.diagnostic());
                }
            }
        }
    }
    composite.wires.append(&mut wires);
}

/// The services of others that have the interface of a reference.
fn answering(composite: &Composite, of: &Component, reference: &Contract) -> Vec<Target> {
    let wanted = reference.interface.as_ref().map(|it| &it.name.value);
    let others = composite.components.iter();
    let others = others.filter(|other| other.name.value != of.name.value);
    let services = others.flat_map(|other| other.services.iter().map(move |it| (other, it)));
    let same = services.filter(|(_, service)| {
        let interface = service.interface.as_ref().map(|it| &it.name.value);
        wanted.is_some() && interface == wanted
    });
    same.map(|(other, service)| Target {
        component: other.name.clone(),
        name: Some(service.name.clone()),
    })
    .collect()
}

/// Which of the two lists of a component is meant.
#[derive(Clone, Copy)]
pub(crate) enum Side {
    Service,
    Reference,
}

impl Side {
    pub(crate) fn of(self, component: &Component) -> &Vec<Contract> {
        match self {
            Self::Service => &component.services,
            Self::Reference => &component.references,
        }
    }

    pub(crate) fn promoted(self, composite: &mut Composite) -> &mut Vec<Contract> {
        match self {
            Self::Service => &mut composite.services,
            Self::Reference => &mut composite.references,
        }
    }

    fn of_mut(self, component: &mut Component) -> &mut Vec<Contract> {
        match self {
            Self::Service => &mut component.services,
            Self::Reference => &mut component.references,
        }
    }
}

/// Says which service and reference a wire means; `false` where a component is not there.
fn wire(composite: &mut Composite, wire: &mut Wire, report: &mut Report) -> bool {
    let source = end(composite, &mut wire.source, Side::Reference, None, report);
    let like = wire.source.name.clone();
    let like = like.as_ref().and_then(|name| {
        let found = find(composite, &wire.source.component, Side::Reference, name);
        found.map(|reference| (name.clone(), reference.interface.clone()))
    });
    source && end(composite, &mut wire.target, Side::Service, like, report)
}

fn find<'c>(
    composite: &'c Composite,
    component: &str,
    side: Side,
    name: &str,
) -> Option<&'c Contract> {
    let component = composite
        .components
        .iter()
        .find(|it| it.name.value == component)?;
    side.of(component).iter().find(|it| it.name.value == name)
}

/// Names the end where only its component is named, and lists it with its component. `like` is the
/// reference that is to be answered.
fn end(
    composite: &mut Composite,
    end: &mut Target,
    side: Side,
    like: Option<(At<String>, Option<Interface>)>,
    report: &mut Report,
) -> bool {
    let mut components = composite.components.iter_mut();
    let Some(component) = components.find(|it| it.name.value == end.component.value) else {
        let known = composite.components.iter();
        let known: Vec<&String> = known.map(|component| &component.name.value).collect();
        let near = similar(&end.component, &known).copied();
        let mut known = composite.components.iter();
        let finding = UnknownScdlName {
            what: "component",
            name: end.component.value.clone(),
            nearest: near
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
            let (name, interface) = meant(listed, like, &end.component);
            end.name = Some(name.clone());
            (name, interface)
        }
    };
    if !listed.iter().any(|it| it.name.value == name.value) {
        listed.push(contract(name, interface));
    }
    true
}

/// Which of the listed ones is meant where none is named: the only one, the one with the interface, or
/// the one that Java would name after the interface.
fn meant(
    listed: &[Contract],
    like: Option<(At<String>, Option<Interface>)>,
    component: &At<String>,
) -> (At<String>, Option<Interface>) {
    if let [only] = listed {
        return (only.name.clone(), None);
    }
    let Some((name, interface)) = like else {
        return (component.clone(), None);
    };
    let wanted = interface.as_ref().map(|it| &it.name.value);
    let same = listed
        .iter()
        .find(|it| wanted.is_some() && it.interface.as_ref().map(|it| &it.name.value) == wanted);
    match (same, wanted) {
        (Some(same), _) => (same.name.clone(), None),
        (None, Some(wanted)) => {
            let name = At::new(name::simple(wanted).to_owned(), component.span);
            (name, interface)
        }
        (None, None) => (At::new(name.value, component.span), None),
    }
}

/// Says which services and references are promoted; a promotion of nothing goes.
fn promote(composite: &mut Composite, report: &mut Report) {
    for side in [Side::Service, Side::Reference] {
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

/// Whatever is joined has one interface: who says it tells the others, until nobody hears anything new.
pub(crate) fn interfaces(composite: &mut Composite) {
    loop {
        let mut news = false;
        for wire in composite.wires.clone() {
            let ends = [
                (&wire.source, Side::Reference),
                (&wire.target, Side::Service),
            ];
            news |= agree(composite, &ends);
        }
        for side in [Side::Service, Side::Reference] {
            for promotion in side.promoted(composite).clone() {
                for target in &promotion.promote {
                    tell(
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

pub(crate) fn interface(composite: &Composite, (end, side): (&Target, Side)) -> Option<Interface> {
    let name = end.name.as_ref()?;
    find(composite, &end.component, side, name)?
        .interface
        .clone()
}

/// Tells each end what the other one knows.
fn agree(composite: &mut Composite, ends: &[(&Target, Side); 2]) -> bool {
    let mut news = false;
    let [one, other] = *ends;
    for (from, to) in [(one, other), (other, one)] {
        let known = interface(composite, from);
        tell(composite, to, known.as_ref(), &mut news);
    }
    news
}

fn tell(
    composite: &mut Composite,
    (end, side): (&Target, Side),
    known: Option<&Interface>,
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
