//! A reference at run time: which services it is joined to, and how.

use std::sync::Arc;

use super::{Ask, CallError, Inbox, Wire};
use crate::declaration::ReferenceDeclaration;
use crate::outside::Leaving;

/// A reference at run time.
pub(crate) struct Reference {
    pub declaration: ReferenceDeclaration,
    /// One; several where nobody answers, and all are told.
    pub wirings: Vec<Wiring>,
}

/// What a reference is joined to.
pub(crate) struct Wiring {
    pub inbox: Arc<Inbox>,
    /// The service: `TrajectoryPlanner.planning`.
    pub to: String,
    /// The provider's place in the system, if it is there.
    pub provider: Option<usize>,
    /// The service's position of each of the reference's operations.
    pub operations: Vec<usize>,
    pub wire: Wire,
}

impl Wiring {
    /// Leaves a question with the provider.
    pub(super) fn ask(&self, ask: Ask, leaving: &mut Leaving<'_>) -> Result<(), CallError> {
        if self.inbox.ask(ask, leaving.outside)? {
            self.trigger(leaving);
        }
        Ok(())
    }

    /// Something is in the provider's inbox. One beyond the bus hears the inbox' bell.
    pub(super) fn trigger(&self, leaving: &mut Leaving<'_>) {
        if let Some(provider) = self.provider {
            leaving.outside.trigger(provider);
        }
    }
}

/// Which operation of which reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Slot {
    pub port: usize,
    pub operation: usize,
}

/// The wiring whose service answers.
pub(super) fn wiring(references: &[Reference], slot: Slot) -> Option<&Wiring> {
    references.get(slot.port)?.wirings.first()
}

pub(super) fn wire_of(references: &[Reference], slot: Slot) -> Wire {
    wiring(references, slot).map_or_else(Wire::default, |wiring| wiring.wire)
}

pub(super) fn names(references: &[Reference], slot: Slot) -> (&str, &str) {
    let Some(reference) = references.get(slot.port) else {
        return ("", "");
    };
    let operation = reference.declaration.operations.get(slot.operation);
    (
        &reference.declaration.name,
        operation.map_or("", |operation| &operation.name),
    )
}
