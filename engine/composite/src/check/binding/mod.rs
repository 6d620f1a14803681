//! Checks the bindings between the functions of an ASM component and its ports and services.

mod action;
mod argument;
mod function;

use crate::codes::c097::UnboundMonitored;
use crate::codes::c098::UnboundOut;
use crate::codes::c101::OtherMainRule;
use asmotion_diagnostics::Report;

use super::annotation;
use super::scene::{CheckedComponent, CheckedComposite};
use crate::finding::Findings;
use crate::model::Implementation;
use crate::signature::{FunctionKind, Signature};

pub use function::chosen_field;

pub(crate) fn check(scene: &CheckedComposite<'_>, report: &mut Report) {
    for part in &scene.parts {
        let Some(Implementation::Asm { file, main }) = &part.component.implementation else {
            continue;
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
        for monitored in &part.component.bind.monitored {
            function::monitored(&bound, monitored, report);
        }
        for out in &part.component.bind.out {
            function::out(&bound, out, report);
        }
        if let Some(signature) = signature {
            unbound(&bound, signature, file.span, report);
            annotation::check(part, signature, file.span, report);
        }
    }
}

/// An ASM component and its signature; `None` if the specification could not be read.
pub(crate) struct Bound<'b> {
    pub scene: &'b CheckedComposite<'b>,
    pub part: &'b CheckedComponent<'b>,
    pub signature: Option<&'b dyn Signature>,
}

/// Reports monitored and out functions of the specification that have no binding.
fn unbound(
    bound: &Bound<'_>,
    signature: &dyn Signature,
    file: asmotion_diagnostics::Span,
    report: &mut Report,
) {
    let bind = &bound.part.component.bind;
    let events = action::events(bind);
    for function in signature.functions() {
        let name = function.name.as_str();
        match function.kind {
            FunctionKind::Monitored => {
                let bound = bind.monitored.iter().any(|it| it.function.value == name);
                if !bound && !events.contains(&name) {
                    report.found(UnboundMonitored { function, at: file });
                }
            }
            FunctionKind::Out => {
                if !bind.out.iter().any(|it| it.function.value == name) {
                    report.found(UnboundOut { function, at: file });
                }
            }
            FunctionKind::Shared
            | FunctionKind::Controlled
            | FunctionKind::Static
            | FunctionKind::Derived
            | FunctionKind::Local => {}
        }
    }
}
