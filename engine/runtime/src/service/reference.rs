//! A reference at run time: the services it is wired to, and how.

use std::sync::Arc;

use asmotion_component::declaration::ReferenceDeclaration;
use asmotion_component::{CallError, OperationSlot, Wire};

use super::message::ServiceRequest;
use super::provider::RequestQueue;
use crate::effects::ComponentEffects;

/// A reference at run time.
pub(crate) struct RequiredReference {
    pub declaration: ReferenceDeclaration,
    /// One service, or several that receive one-way calls only.
    pub wirings: Vec<Wiring>,
}

/// The wire between a reference and one service.
pub(crate) struct Wiring {
    pub queue: Arc<RequestQueue>,
    /// Full name of the service, for example `TrajectoryPlanner.planning`.
    pub to: String,
    /// Position of the provider in the system; `None` for a remote provider.
    pub provider: Option<usize>,
    /// Position of each of the reference's operations in the service.
    pub operations: Vec<usize>,
    pub wire: Wire,
}

impl Wiring {
    /// Queues a request at the provider and triggers it.
    pub(super) fn send(
        &self,
        request: ServiceRequest,
        effects: &mut ComponentEffects<'_>,
    ) -> Result<(), CallError> {
        if self.queue.send(request, effects.effects)? {
            self.trigger(effects);
        }
        Ok(())
    }

    /// Signals a new message to the provider. A remote provider's queue has a notifier instead.
    pub(super) fn trigger(&self, effects: &mut ComponentEffects<'_>) {
        if let Some(provider) = self.provider {
            effects.effects.trigger(provider);
        }
    }
}

/// The wiring whose service replies: the first.
pub(super) fn wiring_of(references: &[RequiredReference], slot: OperationSlot) -> Option<&Wiring> {
    references.get(slot.port)?.wirings.first()
}

pub(super) fn wire_of(references: &[RequiredReference], slot: OperationSlot) -> Wire {
    wiring_of(references, slot).map_or_else(Wire::default, |wiring| wiring.wire)
}

pub(super) fn path_names(references: &[RequiredReference], slot: OperationSlot) -> (&str, &str) {
    let Some(reference) = references.get(slot.port) else {
        return ("", "");
    };
    let operation = reference.declaration.operations.get(slot.operation);
    (
        &reference.declaration.name,
        operation.map_or("", |operation| &operation.name),
    )
}
