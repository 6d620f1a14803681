//! Checks the bindings between the functions of an ASM component and its ports and services.

mod action;
mod argument;
mod coverage;
mod function;
mod idle;
mod input;
mod start;
mod unused;

use std::sync::Arc;

use crate::codes::c101::OtherMainRule;
use crate::codes::c147::StateWithoutExit;
use asmotion_diagnostics::{Diagnostic, Report};

use super::annotation;
use super::scene::{CheckedComponent, CheckedComposite};
use crate::finding::Findings;
use crate::model::Implementation;
use crate::signature::Signature;

pub use function::chosen_field;
pub(super) use function::{literal, location};

pub(crate) fn check(scene: &CheckedComposite<'_>, report: &mut Report) {
    // the last component without findings; instances of one element follow each other
    let mut checked: Option<&CheckedComponent<'_>> = None;
    for part in &scene.parts {
        if checked.is_some_and(|it| is_bound_alike(it, part)) {
            continue;
        }
        let before = report.diagnostics.len();
        component(scene, part, report);
        if before == report.diagnostics.len() {
            checked = Some(part);
        }
    }
}

/// Returns whether the bindings of two components have the same findings, because all parts of the components that the check looks at
/// are equal. Bindings that are equal but not shared are not compared.
fn is_bound_alike(one: &CheckedComponent<'_>, other: &CheckedComponent<'_>) -> bool {
    let (one, face) = (one.component, &one.face);
    let (other, other_face) = (other.component, &other.face);
    Arc::ptr_eq(&one.bind, &other.bind)
        && one.implementation == other.implementation
        // otherwise whether it cycles by time depends on its connections
        && CheckedComposite::has_pace(one)
        && CheckedComposite::has_pace(other)
        && one.subscribe == other.subscribe
        && one.publish == other.publish
        && one.services == other.services
        && one.references == other.references
        && face.differs_in_topics_only(other_face)
}

/// Checks the bindings of a component; none if it is no ASM.
fn component(scene: &CheckedComposite<'_>, part: &CheckedComponent<'_>, report: &mut Report) {
    let Some(Implementation::Asm { file, main }) = &part.component.implementation else {
        return;
    };
    let signature = scene.family.specification(scene.member, file);
    let bound = Bound {
        scene,
        part,
        signature,
    };
    if let (Some(signature), Some(main)) = (signature, main) {
        let found = signature.main_rule();
        if found.as_ref().is_none_or(|(name, _)| *name != main.value) {
            report.found(OtherMainRule {
                name: main.value.clone(),
                at: main.span,
                found,
            });
        }
    }
    let mut found = Report::new();
    // without the specification, the elements of a domain are unknown: its errors are reported instead
    let is_pattern = |location: &str| signature.is_none() && location.contains('$');
    let monitored = part.bind.monitored.iter();
    for monitored in monitored.filter(|it| !is_pattern(&it.location)) {
        function::monitored(&bound, monitored, &mut found);
        idle::check(monitored, &mut found);
    }
    let outs = part.bind.out.iter();
    for out in outs.filter(|it| !is_pattern(&it.location)) {
        function::out(&bound, out, &mut found);
    }
    extend_once(report, found);
    if let Some(signature) = signature {
        coverage::check(&bound, signature, file.span, report);
        input::check(&part.bind, signature, report);
        start::check(&part.bind, signature, report);
        unused::check(part, signature, report);
        annotation::check(part, signature, file.span, report);
        for stuck in signature.states_without_exit() {
            report.found(StateWithoutExit {
                function: stuck.function.clone(),
                state: stuck.state.clone(),
                at: file.span,
                entered: stuck.entered,
            });
        }
    }
}

/// An ASM component and its signature; `None` if the specification could not be read.
pub(crate) struct Bound<'b> {
    pub scene: &'b CheckedComposite<'b>,
    pub part: &'b CheckedComponent<'b>,
    pub signature: Option<&'b dyn Signature>,
}

/// Adds the findings. The bindings that stand for the elements of a domain have one place; of their findings with one
/// code, the first is added with the number of the others, and without a fix, which would replace the variable.
fn extend_once(report: &mut Report, found: Report) {
    let mut added: Vec<(Diagnostic, usize)> = Vec::new();
    for finding in found.diagnostics {
        let place = |it: &Diagnostic| it.primary.as_ref().map(|label| label.span);
        let is_same = |(first, _): &&mut (Diagnostic, usize)| {
            first.code == finding.code && place(first) == place(&finding)
        };
        match added.iter_mut().find(is_same) {
            Some((first, _)) if *first == finding => {}
            Some((first, others)) => {
                first.fix = None;
                *others += 1;
            }
            None => added.push((finding, 0)),
        }
    }
    for (finding, others) in added {
        report.push(match others {
            0 => finding,
            1 => finding.note("the same holds for another location"),
            _ => finding.note(format!("the same holds for {others} other locations")),
        });
    }
}
