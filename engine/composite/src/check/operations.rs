//! Compares the operations that a composite lists with those of the component's services.

use crate::codes::c026::UndeclaredMember;
use crate::codes::c027::DeclarationDiffers;
use asmotion_component::declaration::OperationDeclaration;
use asmotion_datum::{Schema, Shape};
use asmotion_diagnostics::Report;

use super::endpoints::Endpoints;
use super::scene::CheckedComposite;
use crate::at::At;
use crate::finding::Findings;
use crate::model::{Component, Listed};

/// Reports each listed operation that no service of the component has, or that has another signature.
pub(super) fn operations(
    scene: &CheckedComposite<'_>,
    component: &Component,
    implementation: &At<String>,
    face: &Endpoints,
    report: &mut Report,
) {
    let services = face.services.iter();
    let declared = services.map(|service| scene.catalogue.operations(&service.interface.text));
    // an interface that this build does not know is reported elsewhere, and has unknown operations
    let Some(declared) = declared.collect::<Option<Vec<_>>>() else {
        return;
    };
    let declared = declared.concat();
    for Listed { name, kind } in &component.operations {
        let mut same = declared
            .iter()
            .filter(|it| it.name == name.value)
            .peekable();
        let Some(first) = same.peek().copied() else {
            report.found(UndeclaredMember {
                implementation: implementation.value.clone(),
                what: "operation",
                name: name.value.clone(),
                at: name.span,
                made_of: implementation.span,
                known: declared.iter().map(|it| it.name.clone()).collect(),
            });
            continue;
        };
        let written = Signature::read(&kind.value);
        if !same.any(|it| {
            written
                .as_ref()
                .is_some_and(|written| written.is_of(it, scene))
        }) {
            report.found(DeclarationDiffers {
                implementation: implementation.value.clone(),
                what: "operation",
                name: name.value.clone(),
                declared: signature(first),
                written: kind.value.clone(),
                at: kind.span,
                made_of: implementation.span,
            });
        }
    }
}

/// A signature as written: `fn(f64) -> bool`.
struct Signature<'t> {
    parameters: Vec<&'t str>,
    result: Option<&'t str>,
}

impl<'t> Signature<'t> {
    fn read(text: &'t str) -> Option<Self> {
        let rest = text.trim().strip_prefix("fn")?.trim_start();
        let (parameters, rest) = rest.strip_prefix('(')?.split_once(')')?;
        let parameters = match parameters.trim() {
            "" => Vec::new(),
            listed => listed.split(',').map(str::trim).collect(),
        };
        let result = match rest.trim() {
            "" => None,
            arrow => Some(arrow.strip_prefix("->")?.trim()),
        };
        Some(Self { parameters, result })
    }

    /// Returns whether an operation has this signature: its parameters are the request or the fields of the request, and its
    /// result is the response or the only field of the response.
    fn is_of(&self, operation: &OperationDeclaration, scene: &CheckedComposite<'_>) -> bool {
        let result = Vec::from_iter(self.result);
        are(&self.parameters, &operation.request, scene) && are(&result, &operation.response, scene)
    }
}

/// Returns whether written types are a message type or the types of its fields.
fn are(written: &[&str], schema: &Schema, scene: &CheckedComposite<'_>) -> bool {
    if let [whole] = written
        && scene.types.means(whole, schema)
    {
        return true;
    }
    let parts = parts(schema);
    parts.len() == written.len()
        && written
            .iter()
            .zip(parts)
            .all(|(written, part)| scene.types.means(written, part))
}

/// Returns the types of the fields of a record; the type itself if it is no record.
fn parts(schema: &Schema) -> Vec<&Schema> {
    if let Shape::Record(fields) = &schema.shape {
        fields.iter().map(|field| &field.schema).collect()
    } else {
        vec![schema]
    }
}

/// Writes the signature of an operation.
fn signature(operation: &OperationDeclaration) -> String {
    let parameters: Vec<String> = parts(&operation.request)
        .iter()
        .map(ToString::to_string)
        .collect();
    let parameters = parameters.join(", ");
    match *parts(&operation.response) {
        [] => format!("fn({parameters})"),
        [only] => format!("fn({parameters}) -> {only}"),
        _ => format!("fn({parameters}) -> {}", operation.response),
    }
}
