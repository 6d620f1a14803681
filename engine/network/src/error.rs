//! Why a system cannot be joined to a bus as asked.

use asmotion_bus::BusError;
use asmotion_runtime::BuildError;

/// Why something cannot be joined to a bus.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// The system has no such end, or it is joined already.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The bus refuses it.
    #[error(transparent)]
    Bus(#[from] BusError),
}
