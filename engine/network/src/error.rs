//! Errors in connecting a system to a bus.

use asmotion_bus::BusError;
use asmotion_runtime::BuildError;

/// An error in connecting a system to a bus.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// The system has no such end, or it is connected already.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The bus refuses the publisher, subscription or service.
    #[error(transparent)]
    Bus(#[from] BusError),
}
