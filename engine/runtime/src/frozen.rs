//! Frozen systems: the complete state of a simulation between two steps, as data.
//!
//! A frozen system contains the states of its components and everything in transit between them: unread samples,
//! requests and replies, outstanding calls, the clock, scheduled work and counters. It can be thawed into a system
//! started from the same composite, which continues exactly as the frozen one would have. State is never omitted
//! silently: freezing a system with connections to the outside (an adapter, a thread that reads or writes ports, a
//! caller) is an error.

mod sample;

use asmotion_bus::TraceContext;
use asmotion_component::{CallError, CannotFreeze, ThawError};
use asmotion_datum::{Datum, DatumError, cbor};
use serde::{Deserialize, Serialize};

pub(crate) use sample::{FrozenSample, SampleNames};

/// Layout version of frozen systems; must be incremented with each change.
const VERSION: u32 = 3;

/// The state of a simulation between two steps, as bytes. Simulations with equal states run identically from there on.
///
/// Includes the values of secret properties.
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
    /// Returns the state as CBOR. Equal states have equal bytes.
    pub fn as_bytes(&self) -> &[u8] {
        &self.0
    }

    /// Creates a frozen system from bytes, which are checked by [`Simulation::thaw`](crate::Simulation::thaw).
    pub fn from_bytes(bytes: impl Into<Box<[u8]>>) -> Self {
        Self(bytes.into())
    }

    /// Returns the whole state by name, for display and for comparing two states.
    ///
    /// # Errors
    ///
    /// An error if the bytes are malformed.
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
            Some(version) => return Err(SystemThawError::VersionMismatch(version, VERSION)),
            None => {}
        }
        let versioned: VersionedState<S> = frozen.to().map_err(SystemThawError::Malformed)?;
        Ok(versioned.state)
    }
}

/// Displays the number of bytes; see [`FrozenSystem::to_datum`] for the content.
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

/// The error type of freezing a system.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SystemFreezeError {
    /// A component cannot be frozen.
    #[error("`{component}`: {source}")]
    Component {
        /// Name of the component in the system.
        component: String,
        /// Reason reported by the component.
        source: CannotFreeze,
    },
    /// The system depends on something outside that cannot be frozen; contains its description.
    #[error("{0}, which is outside the system and cannot be frozen with it")]
    External(String),
    /// An unread sample, request or reply cannot be represented as a datum.
    #[error("{location}: {source}")]
    NoData {
        /// Location, such as `Follower.path`.
        location: String,
        /// Reason for the failure.
        source: DatumError,
    },
}

/// The error type of thawing a system, which is then unchanged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SystemThawError {
    /// The bytes are malformed.
    #[error("not a frozen system: {0}")]
    Malformed(DatumError),
    /// The bytes were written by another version: the version of the bytes and the current one.
    #[error("the frozen system has layout {0}, and this build has layout {1}")]
    VersionMismatch(i64, u32),
    /// The state belongs to another composite; contains a description of the difference.
    #[error("the frozen state belongs to another system: {0}")]
    SystemMismatch(String),
    /// A component rejects its state.
    #[error("`{component}`: {source}")]
    Component {
        /// Name of the component in the system.
        component: String,
        /// Reason reported by the component.
        source: ThawError,
    },
    /// The system to be thawed cannot be frozen itself, so a failure could not be rolled back.
    #[error(transparent)]
    CannotFreeze(SystemFreezeError),
}

/// Returns the error for a value that cannot be represented as a datum.
pub(crate) fn no_data(place: &str) -> impl Fn(DatumError) -> SystemFreezeError + use<> {
    let place = place.to_owned();
    move |source| SystemFreezeError::NoData {
        location: place.clone(),
        source,
    }
}

/// Formats a trace as the text of its header.
pub(crate) fn trace_text(trace: Option<TraceContext>) -> Option<String> {
    trace.map(|trace| trace.to_string())
}

/// Parses the header text of a trace.
pub(crate) fn trace_of(text: &Option<String>) -> Result<Option<TraceContext>, SystemThawError> {
    let read = text.as_ref().map(|text| text.parse());
    read.transpose()
        .map_err(|_| system_mismatch("a trace is not a W3C trace context"))
}

/// Returns the error for a state that belongs to another system.
pub(crate) fn system_mismatch(difference: impl Into<String>) -> SystemThawError {
    SystemThawError::SystemMismatch(difference.into())
}

/// Outcome of a call: a response or an error.
pub(crate) type FrozenResult = Result<FrozenSample, CallError>;
