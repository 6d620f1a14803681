//! Frozen systems: everything that a simulation depends on between two steps, as data.
//!
//! A frozen system contains the states of its components and, around them, what is on its way: samples in connections,
//! requests and replies, calls under way, the clock, what is due next, counters. It thaws into a system that has been
//! started from the same composite, which goes on as the frozen one would have. Nothing is left out in silence: a system
//! that touches the world outside (an adapter, a thread that reads or writes ports, a caller) cannot be frozen, and says
//! why.

mod sample;

use asmotion_bus::TraceContext;
use asmotion_component::{CallError, CannotFreeze, ThawError};
use asmotion_datum::{Datum, DatumError, cbor};
use serde::{Deserialize, Serialize};

pub(crate) use sample::{FrozenSample, SampleNames};

/// The layout of frozen systems; to be incremented with each change.
const VERSION: u32 = 1;

/// A simulation between two steps, as bytes. Equal bytes: equal runs from here on.
///
/// Secrets among the values of properties are in it.
///
/// ```
/// use asmotion_component::{Activity, Component, Cycle, Fault, Freeze, Span, freeze_by_fields};
/// use asmotion_runtime::{FrozenSystem, Run, System};
///
/// /// Counts its cycles.
/// #[derive(Freeze)]
/// #[freeze(component = "test::Counter", version = 1)]
/// struct Counter {
///     count: u64,
/// }
///
/// impl Component for Counter {
///     freeze_by_fields!();
///
///     fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
///         self.count += 1;
///         Ok(())
///     }
/// }
///
/// let start = || {
///     let mut system = System::new();
///     let counter = |_: &mut _| Box::new(Counter { count: 0 }) as Box<dyn Component>;
///     system.add("Counter", Activity::periodic(10.ms()), counter)?;
///     Ok::<_, asmotion_runtime::BuildError>(system.simulate())
/// };
/// let mut run = start()?;
/// run.run_for(1.s());
/// let frozen: FrozenSystem = run.freeze()?;
///
/// let mut other = start()?;
/// other.thaw(&frozen)?;
/// other.run_for(1.s());
/// assert_eq!(other.cycles("Counter"), 201);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct FrozenSystem(#[serde(with = "serde_bytes")] Box<[u8]>);

impl FrozenSystem {
    /// The bytes, CBOR. Equal states have equal bytes.
    pub fn as_bytes(&self) -> &[u8] {
        &self.0
    }

    /// Takes bytes for a frozen system. Whether they are one is checked by [`Simulation::thaw`](crate::Simulation::thaw).
    pub fn from_bytes(bytes: impl Into<Box<[u8]>>) -> Self {
        Self(bytes.into())
    }

    /// Everything by name, for people and for comparing two states.
    ///
    /// # Errors
    /// The bytes are no frozen system.
    pub fn to_datum(&self) -> Result<Datum, SystemThawError> {
        cbor::decode(&self.0).map_err(SystemThawError::Malformed)
    }

    pub(crate) fn of(state: impl Serialize) -> Result<Self, SystemFreezeError> {
        let versioned = VersionedState {
            version: VERSION,
            state,
        };
        let bytes = cbor::encode(&versioned).map_err(no_data("the system"))?;
        Ok(Self(bytes.into_boxed_slice()))
    }

    pub(crate) fn read<S: serde::de::DeserializeOwned>(&self) -> Result<S, SystemThawError> {
        let frozen = self.to_datum()?;
        match frozen.get("version").and_then(|version| version.as_int()) {
            Some(version) if version == i64::from(VERSION) => {}
            Some(version) => return Err(SystemThawError::OtherVersion(version, VERSION)),
            None => {}
        }
        let versioned: VersionedState<S> = frozen.to().map_err(SystemThawError::Malformed)?;
        Ok(versioned.state)
    }
}

/// The number of bytes; the bytes themselves are for [`FrozenSystem::to_datum`].
impl std::fmt::Debug for FrozenSystem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "FrozenSystem({} bytes)", self.0.len())
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct VersionedState<S> {
    version: u32,
    state: S,
}

/// Why a system cannot be frozen now, or at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SystemFreezeError {
    /// A component does not freeze.
    #[error("`{component}`: {source}")]
    Component {
        /// Its name in the system.
        component: String,
        /// Its reason.
        source: CannotFreeze,
    },
    /// Something belongs to the world outside of the system, which does not freeze with it.
    #[error("{0}: that is outside of the system, and does not freeze with it")]
    Outside(String),
    /// Something on its way has no form as data.
    #[error("{place}: {source}")]
    NoData {
        /// Where it is: `Follower.path`.
        place: String,
        /// Why not.
        source: DatumError,
    },
}

/// Why a system does not take a frozen state. The system is as it was before.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SystemThawError {
    /// The bytes are no frozen system.
    #[error("this is no frozen system: {0}")]
    Malformed(DatumError),
    /// The bytes were written by another version.
    #[error("the frozen system has layout {0}, and this build has layout {1}")]
    OtherVersion(i64, u32),
    /// The system was made of another composite: what differs.
    #[error("the frozen system is another one: {0}")]
    OtherSystem(String),
    /// A component does not take its state.
    #[error("`{component}`: {source}")]
    Component {
        /// Its name in the system.
        component: String,
        /// Its reason.
        source: ThawError,
    },
    /// The system that is to take the state could not be frozen itself, so a failure could not be undone.
    #[error(transparent)]
    Unfreezable(SystemFreezeError),
}

/// The error of a value without a form as data.
pub(crate) fn no_data(place: &str) -> impl Fn(DatumError) -> SystemFreezeError + use<> {
    let place = place.to_owned();
    move |source| SystemFreezeError::NoData {
        place: place.clone(),
        source,
    }
}

/// A trace as the text of its header.
pub(crate) fn trace_text(trace: Option<TraceContext>) -> Option<String> {
    trace.map(|trace| trace.to_string())
}

/// Reads the text of a trace.
pub(crate) fn trace_of(text: &Option<String>) -> Result<Option<TraceContext>, SystemThawError> {
    let read = text.as_ref().map(|text| text.parse());
    read.transpose()
        .map_err(|_| other("a trace has no W3C text"))
}

/// The error of a state that does not fit this system.
pub(crate) fn other(what: impl Into<String>) -> SystemThawError {
    SystemThawError::OtherSystem(what.into())
}

/// The end of a call: a response, or why there is none.
pub(crate) type FrozenResult = Result<FrozenSample, CallError>;
