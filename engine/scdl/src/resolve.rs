//! What SCDL leaves to the implementation, or to the runtime: services and references that are not
//! listed, targets without a service, interfaces, callbacks, autowire.

use std::collections::BTreeMap;

use assembly::{At, Catalogue};
use source::{Report, similar};

use crate::finding::ScdlError;
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

/// Tells nested composites the interfaces that those around them know.
pub(crate) fn across(composites: &mut BTreeMap<String, Composite>) {
    loop {
        let mut facts = Vec::new();
        for component in composites.values().flat_map(|it| &it.components) {
            let Some(Implementation::Composite(nested)) = &component.implementation else {
                continue;
            };
            for side in [Side::Service, Side::Reference] {
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
        if !news {
            return;
        }
    }
}

/// Assumes what nobody says. `nested` are those that were settled before.
pub(crate) fn settle(
    composite: &mut Composite,
    nested: &BTreeMap<String, Composite>,
    report: &mut Report,
) {
    for component in &mut composite.components {
        if let Some(Implementation::Composite(name)) = &component.implementation
            && let Some(nested) = nested.get(&name.value)
        {
            complete(&mut component.services, nested.services.clone());
            complete(&mut component.references, nested.references.clone());
        }
    }
    interfaces(composite);
    assume(composite, report);
    callbacks(composite);
}

/// A service or reference that is named nowhere but where it is used.
fn contract(name: At<String>, interface: Option<Interface>) -> Contract {
    Contract {
        name,
        interface,
        binding: None,
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

/// Adds what is declared to what is listed.
fn complete(listed: &mut Vec<Contract>, declared: Vec<Contract>) {
    for declared in declared {
        match listed
            .iter_mut()
            .find(|it| it.name.value == declared.name.value)
        {
            Some(listed) => listed.interface = listed.interface.take().or(declared.interface),
            None => listed.push(Contract {
                promote: Vec::new(),
                binding: None,
                ..declared
            }),
        }
    }
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
                    let finding = ScdlError::Autowire {
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
enum Side {
    Service,
    Reference,
}

impl Side {
    fn of(self, component: &Component) -> &Vec<Contract> {
        match self {
            Self::Service => &component.services,
            Self::Reference => &component.references,
        }
    }

    fn promoted(self, composite: &mut Composite) -> &mut Vec<Contract> {
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
        let finding = ScdlError::Unknown {
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
fn interfaces(composite: &mut Composite) {
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

fn interface(composite: &Composite, (end, side): (&Target, Side)) -> Option<Interface> {
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

/// Gives the rest an interface of a name that nobody has said, and says so; then all agree again.
fn assume(composite: &mut Composite, report: &mut Report) {
    let of = composite.name.value.clone();
    for index in 0..composite.components.len() {
        for side in [Side::Service, Side::Reference] {
            let Some(component) = composite.components.get_mut(index) else {
                continue;
            };
            // a nested composite says it in its own file
            if matches!(component.implementation, Some(Implementation::Composite(_))) {
                continue;
            }
            let owner = component.name.value.clone();
            let mut listed = side.of_mut(component).iter_mut();
            let Some(contract) = listed.find(|it| it.interface.is_none()) else {
                continue;
            };
            let assumed = format!("{of}/{}", contract.name.value);
            let at = contract.name.span;
            let finding = ScdlError::Assumed {
                what: "the interface",
                of: format!("{owner}.{}", contract.name.value),
                assumed: assumed.clone(),
                at,
            };
            report.push(finding.diagnostic());
            contract.interface = Some(Interface {
                name: At::new(assumed, at),
                callback: None,
            });
            interfaces(composite);
            return assume(composite, report);
        }
    }
}

/// A callback is a reference of the provider and a service of the caller, wired the other way round.
fn callbacks(composite: &mut Composite) {
    let calls_back = |interface: Option<&Interface>| interface.and_then(|it| it.callback.clone());
    for component in &mut composite.components {
        if matches!(component.implementation, Some(Implementation::Composite(_))) {
            continue;
        }
        let called = |of: &[Contract]| {
            let called = of.iter().filter_map(|it| {
                let callback = calls_back(it.interface.as_ref())?;
                let interface = Interface {
                    name: callback,
                    callback: None,
                };
                let name = it.name.clone().map(|name| name::callback(&name));
                let mut contract = contract(name, Some(interface));
                contract.multiplicity.optional = true;
                Some(contract)
            });
            called.collect::<Vec<_>>()
        };
        let (back, forth) = (called(&component.services), called(&component.references));
        complete(&mut component.references, back);
        complete(&mut component.services, forth);
    }
    let back = composite.wires.iter().filter_map(|wire| {
        let back = |target: &Target| Target {
            component: target.component.clone(),
            name: target
                .name
                .clone()
                .map(|name| name.map(|name| name::callback(&name))),
        };
        calls_back(interface(composite, (&wire.source, Side::Reference)).as_ref())?;
        Some(Wire {
            source: back(&wire.target),
            target: back(&wire.source),
        })
    });
    let back: Vec<Wire> = back.collect();
    composite.wires.extend(back);
}
