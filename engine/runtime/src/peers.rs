//! The statuses of a system's components by name, which other components read in their cycles.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, PoisonError, RwLock};

use asmotion_component::PeerStatus;

use crate::descriptor::ComponentStatus;

/// The statuses of all components of a system, shared by the executor and all components.
///
/// The executor writes when it adds or removes a component; a cycle holds the lock for a look-up only.
#[derive(Clone, Default)]
pub(crate) struct PeerTable(Arc<RwLock<PeerEntries>>);

#[derive(Default)]
struct PeerEntries {
    /// By position.
    entries: BTreeMap<usize, PeerEntry>,
    /// Positions by name: two while a component is being replaced.
    positions: BTreeMap<Arc<str>, BTreeSet<usize>>,
}

struct PeerEntry {
    name: Arc<str>,
    status: Arc<ComponentStatus>,
}

impl PeerTable {
    /// Adds the component at this position.
    pub(crate) fn insert(&self, component: usize, name: Arc<str>, status: Arc<ComponentStatus>) {
        self.remove(component);
        let mut peers = self.0.write().unwrap_or_else(PoisonError::into_inner);
        let positions = peers.positions.entry(Arc::clone(&name)).or_default();
        positions.insert(component);
        peers.entries.insert(component, PeerEntry { name, status });
    }

    /// Forgets the component at this position.
    pub(crate) fn remove(&self, component: usize) {
        let mut peers = self.0.write().unwrap_or_else(PoisonError::into_inner);
        let Some(PeerEntry { name, .. }) = peers.entries.remove(&component) else {
            return;
        };
        if let Some(positions) = peers.positions.get_mut(&name) {
            positions.remove(&component);
            if positions.is_empty() {
                peers.positions.remove(&name);
            }
        }
    }

    /// The status of the component with this name. Of one that is being replaced, the newest.
    pub(crate) fn find(&self, component: &str) -> Option<PeerStatus> {
        let peers = self.0.read().unwrap_or_else(PoisonError::into_inner);
        let newest = peers.positions.get(component)?.last()?;
        Some(peers.entries.get(newest)?.status.as_peer())
    }

    /// The position of the component with this name. Of one that is being replaced, the oldest.
    pub(crate) fn position(&self, component: &str) -> Option<usize> {
        let peers = self.0.read().unwrap_or_else(PoisonError::into_inner);
        peers.positions.get(component)?.first().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_component::State;

    #[test]
    fn components_are_found_by_name_also_while_one_replaces_another() {
        let peers = PeerTable::default();
        let insert = |position, name: &str, state| {
            peers.insert(position, name.into(), Arc::new(ComponentStatus::new(state)));
        };
        let found = |name: &str| (peers.position(name), peers.find(name).map(|it| it.state));
        insert(0, "Planner", State::Running);
        insert(1, "Follower", State::Stopped);
        assert_eq!(found("Follower"), (Some(1), Some(State::Stopped)));
        insert(2, "Planner", State::Init);
        assert_eq!(found("Planner"), (Some(0), Some(State::Init)));
        peers.remove(0);
        assert_eq!(found("Planner"), (Some(2), Some(State::Init)));
        // another component at a known position
        insert(2, "Driver", State::Running);
        assert_eq!(found("Planner"), (None, None));
        assert_eq!(found("Driver"), (Some(2), Some(State::Running)));
        peers.remove(7);
        peers.remove(2);
        assert_eq!(found("Driver"), (None, None));
    }
}
