//! Compares the operations that a reference calls with those of the services that it is wired to.

use std::sync::Arc;

use asmotion_component::Declaration;
use asmotion_component::declaration::OperationDeclaration;
use asmotion_composite::finding::Findings;
use asmotion_composite::model;

use super::Flattener;
use crate::codes::c155::{OperationDifference, OperationMismatch};
use crate::component::{Component, Service};
use crate::plan::{End, Implementation};

/// The operations at an end of a wire.
struct WireEnd {
    interface: String,
    operations: Vec<OperationDeclaration>,
    /// The component declares them itself; else they are those known for the interface.
    are_declared: bool,
}

impl Flattener<'_, '_> {
    /// Reports operations that a reference calls and a service lacks, or declares with other types.
    pub(super) fn compare_operations(
        &mut self,
        wire: &model::Wire,
        reference: &End,
        (written, service): (&model::End, &End),
    ) {
        let ends = self.caller(reference).zip(self.provider(service));
        let Some((caller, provider)) = ends else {
            return;
        };
        // reported by the check of wires
        if caller.interface != provider.interface {
            return;
        }
        if !caller.are_declared && !provider.are_declared {
            return;
        }
        for called in &caller.operations {
            let mut served = provider.operations.iter();
            let served = served.find(|it| it.name == called.name);
            let difference = match served {
                // the operations of a service that does not declare them are not known completely
                None if !provider.are_declared => continue,
                None => None,
                Some(served) => match difference(called, served) {
                    None => continue,
                    some => some,
                },
            };
            self.notes.found(OperationMismatch {
                reference: wire.reference.to_string(),
                service: written.to_string(),
                interface: caller.interface.clone(),
                operation: called.name.clone(),
                difference,
                at: written.span(),
                reference_at: wire.reference.span(),
            });
        }
    }

    fn caller(&self, end: &End) -> Option<WireEnd> {
        let component = self.plan.component(&end.component)?;
        let declared = self.declaration(component).and_then(|it| {
            let mut references = it.references.iter();
            let reference = references.find(|it| it.name == end.name)?;
            Some(reference.operations.clone())
        });
        let mut wire_end = self.wire_end(&component.references, &end.name, declared)?;
        if !wire_end.are_declared {
            let is_called = |operation: &OperationDeclaration| {
                let mut calls = component.binding.iter().flat_map(|it| it.calls());
                calls.any(|call| {
                    call.operation.service == end.name && call.operation.operation == operation.name
                })
            };
            wire_end.operations.retain(is_called);
        }
        Some(wire_end)
    }

    fn provider(&self, end: &End) -> Option<WireEnd> {
        let component = self.plan.component(&end.component)?;
        let declared = self.declaration(component).and_then(|it| {
            let mut services = it.services.iter();
            let service = services.find(|it| it.name == end.name)?;
            Some(service.operations.clone())
        });
        self.wire_end(&component.services, &end.name, declared)
    }

    fn wire_end(
        &self,
        listed: &[Service],
        name: &str,
        declared: Option<Vec<OperationDeclaration>>,
    ) -> Option<WireEnd> {
        let interface = &listed.iter().find(|it| it.name == name)?.interface;
        let known = || self.parts.context.catalogue.operations(interface);
        Some(WireEnd {
            interface: interface.clone(),
            are_declared: declared.is_some(),
            operations: declared.or_else(known)?,
        })
    }

    /// Returns the declaration of a component of the executable or of a program; `None` if it is not known.
    fn declaration(&self, component: &Component) -> Option<Arc<Declaration>> {
        if let Implementation::Rust(name) = &component.implementation {
            return self.parts.context.catalogue.declaration(name);
        }
        let program = component.program.as_ref()?;
        Some(Arc::new(program.declaration.clone()))
    }
}

/// Returns the first difference between the types of an operation at both ends.
fn difference(
    called: &OperationDeclaration,
    served: &OperationDeclaration,
) -> Option<OperationDifference> {
    let compared = [
        ("request", served.request.compare(&called.request)),
        ("response", served.response.compare(&called.response)),
    ];
    let mut differences = compared
        .into_iter()
        .filter_map(|(part, result)| Some((part, result.err()?)));
    let (part, types) = differences.next()?;
    Some(OperationDifference { part, types })
}
