//! The statuses of a system's components by name, which other components read in their cycles.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError, RwLock};

use asmotion_component::PeerStatus;

use crate::descriptor::ComponentStatus;

/// The statuses of all components of a system, shared by the executor and all components.
///
/// The executor writes when it adds or removes a component; a cycle holds the lock for a look-up only.
#[derive(Clone, Default)]
pub(crate) struct PeerTable(Arc<RwLock<BTreeMap<usize, PeerEntry>>>);

struct PeerEntry {
    name: Arc<str>,
    status: Arc<ComponentStatus>,
}

impl PeerTable {
    /// Adds the component at this position.
    pub(crate) fn insert(&self, component: usize, name: Arc<str>, status: Arc<ComponentStatus>) {
        let mut peers = self.0.write().unwrap_or_else(PoisonError::into_inner);
        peers.insert(component, PeerEntry { name, status });
    }

    /// Forgets the component at this position.
    pub(crate) fn remove(&self, component: usize) {
        let mut peers = self.0.write().unwrap_or_else(PoisonError::into_inner);
        peers.remove(&component);
    }

    /// The status of the component with this name. Of one that is being replaced, the newest.
    pub(crate) fn find(&self, component: &str) -> Option<PeerStatus> {
        let peers = self.0.read().unwrap_or_else(PoisonError::into_inner);
        let mut newest_first = peers.values().rev();
        let entry = newest_first.find(|entry| *entry.name == *component)?;
        Some(entry.status.as_peer())
    }
}
