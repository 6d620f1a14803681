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
    /// The services in the order of their alternatives; several of one alternative receive one-way calls only.
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

impl RequiredReference {
    /// Adds a service behind its alternatives that come first.
    pub(crate) fn add(&mut self, wiring: Wiring) {
        let position = wiring.wire.alternative;
        let before = |it: &Wiring| it.wire.alternative <= position;
        let index = self.wirings.partition_point(before);
        self.wirings.insert(index, wiring);
    }
}

/// The wiring whose service replies: the first of an alternative.
pub(super) fn wiring_of(
    references: &[RequiredReference],
    slot: OperationSlot,
    alternative: u32,
) -> Option<&Wiring> {
    let mut wirings = references.get(slot.port)?.wirings.iter();
    wirings.find(|it| it.wire.alternative == alternative)
}

pub(super) fn wire_of(
    references: &[RequiredReference],
    slot: OperationSlot,
    alternative: u32,
) -> Wire {
    let wiring = wiring_of(references, slot, alternative);
    wiring.map_or_else(Wire::default, |wiring| wiring.wire)
}

/// The alternative to which a call goes first.
pub(super) fn first_alternative(references: &[RequiredReference], slot: OperationSlot) -> u32 {
    let first = references.get(slot.port).and_then(|it| it.wirings.first());
    first.map_or(0, |wiring| wiring.wire.alternative)
}

/// The alternative to which a call goes if this one is unavailable.
pub(super) fn next_alternative(
    references: &[RequiredReference],
    slot: OperationSlot,
    alternative: u32,
) -> Option<u32> {
    let wirings = references.get(slot.port)?.wirings.iter();
    let mut positions = wirings.map(|it| it.wire.alternative);
    positions.find(|position| *position > alternative)
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
