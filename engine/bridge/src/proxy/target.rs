//! The presence of the target: whether it runs, and whether what it stands for can be reached.

use asmotion_component::{Cycle, PeerStatus, ServiceFault, State};

use super::operation::refusal;

/// The target of a proxy.
pub(super) struct ProxyTarget {
    /// Names in the system: one component, or those inside a nested composite.
    names: Vec<String>,
}

/// Whether the target is there.
pub(super) enum TargetAbsence {
    /// It handles messages, as far as is known.
    None,
    /// It has been silent for longer than the composite allows. `is_known` if it runs nevertheless; the state of a target in
    /// another process is not known.
    Silent { fault: ServiceFault, is_known: bool },
    /// It does not run, or cannot be reached.
    Component(ServiceFault),
}

impl ProxyTarget {
    pub(super) fn new(names: &[String]) -> Self {
        Self {
            names: names.to_vec(),
        }
    }

    /// Returns whether the target is there. `is_stale` if it is silent.
    pub(super) fn absence(&self, is_stale: bool, cycle: &Cycle<'_>) -> TargetAbsence {
        let peers = self.names.iter().map(|name| (name, cycle.peer(name)));
        let peers: Vec<_> = peers.collect();
        let mut refusals = peers
            .iter()
            .filter_map(|(name, peer)| absent(name, (*peer)?));
        match refusals.next() {
            Some(fault) => TargetAbsence::Component(fault),
            None if is_stale => TargetAbsence::Silent {
                fault: refusal("STALE", "the target is silent"),
                is_known: !peers.is_empty() && peers.iter().all(|(_, peer)| peer.is_some()),
            },
            None => TargetAbsence::None,
        }
    }
}

impl TargetAbsence {
    /// Why the target handles no messages; `None` if it is only silent.
    pub(super) fn of_component(&self) -> Option<&ServiceFault> {
        match self {
            Self::Component(fault) => Some(fault),
            Self::Silent { .. } | Self::None => None,
        }
    }

    /// The reply to commands, if they are refused. One that runs takes them, although it is silent.
    pub(super) fn to_commands(&self) -> Option<&ServiceFault> {
        match self {
            Self::Component(fault)
            | Self::Silent {
                fault,
                is_known: false,
            } => Some(fault),
            Self::Silent { is_known: true, .. } | Self::None => None,
        }
    }

    /// The reply to readings, if there is no current value.
    pub(super) fn to_readings(&self) -> Option<&ServiceFault> {
        match self {
            Self::Component(fault) | Self::Silent { fault, .. } => Some(fault),
            Self::None => None,
        }
    }
}

/// Why a component with this status handles no messages.
fn absent(name: &str, peer: PeerStatus) -> Option<ServiceFault> {
    let stopped = |how| Some(refusal("STOPPED", &format!("`{name}` {how}")));
    match peer.state {
        State::Init | State::PreOperational => stopped("is not configured"),
        State::FatalError | State::Exception => stopped("has failed"),
        State::Stopped => stopped("is stopped"),
        State::Running | State::RunTimeError if peer.is_reachable => None,
        State::Running | State::RunTimeError => Some(refusal(
            "UNAVAILABLE",
            &format!("what `{name}` stands for cannot be reached"),
        )),
    }
}
