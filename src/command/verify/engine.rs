//! The engine of a verification.

use crate::feature::LeftOut;
use asmotion_verify::Engine;
use clap::ValueEnum;

/// The way in which states are explored.
#[derive(Clone, Copy, ValueEnum)]
pub enum EngineOption {
    /// One by one: any specification, and the shortest run for each violation
    Explicit,
    /// Sets of them, as decision diagrams: more states, if all locations have finitely many values
    Symbolic,
}

impl EngineOption {
    /// Returns the engine.
    ///
    /// # Errors
    /// This build does not have it.
    #[cfg(feature = "symbolic")]
    pub fn engine(self) -> Result<Engine, LeftOut> {
        Ok(match self {
            Self::Explicit => Engine::Explicit,
            Self::Symbolic => Engine::Symbolic,
        })
    }

    /// Returns the engine.
    ///
    /// # Errors
    /// This build does not have it.
    #[cfg(not(feature = "symbolic"))]
    pub fn engine(self) -> Result<Engine, LeftOut> {
        match self {
            Self::Explicit => Ok(Engine::Explicit),
            Self::Symbolic => Err(LeftOut::new::<crate::feature::Symbolic>()),
        }
    }
}
