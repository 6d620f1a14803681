//! Compares the annotations in a specification (`@Provided`, `@Required`; SCA-ASM) with the services and references of
//! its component.

use crate::codes::c102::UnlistedAnnotation;
use crate::codes::c103::OtherInterface;
use crate::codes::c104::Unannotated;
use asmotion_diagnostics::{Report, Span};

use super::scene::CheckedComponent;
use crate::at::At;
use crate::finding::Findings;
use crate::model::binding::{Action, Effect};
use crate::nearest::nearest;
use crate::signature::{Annotated, Signature};

/// Checks a component implemented by a specification. Specifications without annotations are skipped.
pub(crate) fn check(
    part: &CheckedComponent<'_>,
    signature: &dyn Signature,
    file: Span,
    report: &mut Report,
) {
    let annotations = signature.annotations();
    let references = part.component.references.iter();
    let references: Vec<AnnotatedName<'_>> =
        references.map(|it| (&it.name, &it.interface)).collect();
    let services = part.component.services.iter();
    let services: Vec<AnnotatedName<'_>> = services.map(|it| (&it.name, &it.kind)).collect();
    for annotated in &annotations.references {
        let mut listed = references.iter();
        let same = listed.find(|(name, _)| name.value == annotated.name);
        reference(annotated, same, file, report);
    }
    for annotated in &annotations.provided {
        if !services
            .iter()
            .any(|(_, interface)| last(interface) == annotated.interface)
        {
            report.found(UnlistedAnnotation {
                what: "service",
                name: annotated.interface.to_lowercase(),
                interface: annotated.interface.clone(),
                at: file,
                declared: annotated.declared,
            });
        }
    }
    let called = called(part);
    let is_known = |(name, _): &&AnnotatedName<'_>| {
        let mut annotated = annotations.references.iter();
        annotated.any(|it| it.name == name.value) || called.contains(&name.value.as_str())
    };
    if !annotations.references.is_empty() {
        let unknown = references.iter().filter(|it| !is_known(it));
        unannotated("reference", unknown, &annotations.references, report);
    }
    let is_provided = |(_, interface): &&AnnotatedName<'_>| {
        let mut provided = annotations.provided.iter();
        provided.any(|it| it.interface == last(interface))
    };
    if !annotations.provided.is_empty() {
        let unknown = services.iter().filter(|it| !is_provided(it));
        unannotated("service", unknown, &annotations.provided, report);
    }
}

/// Name and interface of an annotated service or reference.
type AnnotatedName<'c> = (&'c At<String>, &'c At<String>);

/// Returns the last segment of an interface name: `Dispatch` for `courier/Dispatch`.
fn last(interface: &str) -> &str {
    interface.rsplit('/').next().unwrap_or(interface)
}

fn reference(
    annotated: &Annotated,
    listed: Option<&AnnotatedName<'_>>,
    file: Span,
    report: &mut Report,
) {
    let (name, declared) = (annotated.name.clone(), annotated.declared);
    let Some((_, interface)) = listed else {
        return report.found(UnlistedAnnotation {
            what: "reference",
            name,
            interface: annotated.interface.clone(),
            at: file,
            declared,
        });
    };
    // `Agent` matches every interface
    if annotated.interface != "Agent" && annotated.interface != last(interface) {
        report.found(OtherInterface {
            what: "reference",
            name,
            annotated: annotated.interface.clone(),
            listed: interface.value.clone(),
            at: interface.span,
            declared,
        });
    }
}

fn unannotated<'c>(
    what: &'static str,
    unknown: impl Iterator<Item = &'c AnnotatedName<'c>>,
    annotated: &[Annotated],
    report: &mut Report,
) {
    for (name, _) in unknown {
        let known = annotated
            .iter()
            .map(|it| (it.name.as_str(), Some(it.declared)));
        report.found(Unannotated {
            what,
            name: name.value.clone(),
            at: name.span,
            nearest: nearest(name, known),
        });
    }
}

/// Returns the references called by the bindings of the composite; they need no annotation.
fn called<'p>(part: &'p CheckedComponent<'_>) -> Vec<&'p str> {
    let effects = part.bind.out.iter().map(|it| &it.effect);
    let actions = effects.flat_map(|effect| match effect {
        Effect::Literals(literals) => literals.as_slice(),
        Effect::Publish(_) => &[],
    });
    let actions = actions.flat_map(|(_, actions)| actions);
    let called = actions.filter_map(|action| match action {
        Action::Call(call) => Some(call.operation.component.value.as_str()),
        Action::Publish { .. } | Action::Cancel(_) => None,
    });
    called.collect()
}
