//! The status of another component of the system.

use crate::life_cycle::State;

/// The status of another component of the system, as [`Cycle::peer`](crate::Cycle::peer) returns it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PeerStatus {
    /// State in its life cycle.
    pub state: State,
    /// `false` if it stands for something outside of the system that is not there, such as a robot that is silent.
    pub is_reachable: bool,
}
