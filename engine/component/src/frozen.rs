//! Frozen state: what a component remembers between two cycles, as data.
//!
//! A model checker keeps many states, compares them and goes on from each; a recording begins with one and replays from
//! there. Both need the state of a component as plain bytes. `#[derive(Freeze)]` on the component's struct makes them:
//! each field becomes an entry of a record, encoded as CBOR, unless it is marked
//! - `#[freeze(skip)]`: belongs to the place and not to the state (ports, the source of files), and stays as it is, or
//! - `#[freeze(reset)]`: holds nothing that a later cycle depends on (a cache, scratch memory), and becomes its
//!   [`Default`].
//!
//! Fields are frozen by serde, [`PropertySet`]s by their last values. A type whose numbers must fit together should read
//! itself with `#[serde(try_from = "…")]`, since frozen bytes may come from a stranger. Fields must be serialised in the
//! same order each time: a `BTreeMap`, not a `HashMap`.

use std::fmt;

pub use asmotion_datum::{Datum, DatumError, FieldName};
use asmotion_datum::{DatumProblem, Word, cbor};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::derived::{Properties, PropertySet};

/// The state of a component between two cycles.
///
/// Two states are equal if and only if their bytes are, floating-point numbers included: NaN equals itself, and zero is
/// not minus zero. A state is of a type of component, not of one instance: it thaws into any other component of that
/// type. It contains the values of the component's properties, secrets among them.
///
/// It is written with serde, for instance as CBOR:
///
/// ```
/// use asmotion_component::{Freeze, FrozenState, freeze_fields};
/// use asmotion_datum::cbor;
///
/// /// Counts.
/// #[derive(Freeze)]
/// #[freeze(component = "test::Counter", version = 1)]
/// struct Counter {
///     count: u64,
/// }
///
/// let frozen = freeze_fields(&Counter { count: 3 })?;
/// let bytes = cbor::encode(&frozen)?;
/// assert_eq!(cbor::decode::<FrozenState>(&bytes)?, frozen);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrozenState {
    component: String,
    version: u32,
    /// The fields, as CBOR.
    #[serde(with = "serde_bytes")]
    fields: Box<[u8]>,
}

impl FrozenState {
    /// A state that a component encodes by itself, instead of by `#[derive(Freeze)]`: any record.
    ///
    /// # Errors
    /// The value has no form as data.
    pub fn of(
        component: &str,
        version: u32,
        fields: &impl Serialize,
    ) -> Result<Self, CannotFreeze> {
        let fields = cbor::encode(fields).map_err(|error| CannotFreeze {
            component: component.to_owned(),
            reason: FreezeProblem::NoData(error),
        })?;
        Ok(Self {
            component: component.to_owned(),
            version,
            fields: fields.into_boxed_slice(),
        })
    }

    /// The type of the component: `nav::TrajectoryFollower`.
    pub fn component(&self) -> &str {
        &self.component
    }

    /// The version of the layout in which that type froze itself.
    pub fn version(&self) -> u32 {
        self.version
    }

    /// The encoded fields. Equal states have equal bytes.
    pub fn as_bytes(&self) -> &[u8] {
        &self.fields
    }

    /// The fields by name, for people and for comparing two states field by field.
    ///
    /// # Errors
    /// The bytes are none that a component wrote.
    pub fn to_datum(&self) -> Result<Datum, ThawError> {
        cbor::decode(&self.fields).map_err(|error| self.refused(ThawProblem::Malformed(error)))
    }

    /// Checks that this is a state of a type of component in its present layout, and reads it.
    ///
    /// # Errors
    /// It is a state of another type or version, or the bytes are not what the type writes.
    pub fn read<T: DeserializeOwned>(&self, component: &str, version: u32) -> Result<T, ThawError> {
        let problem = if self.component != component {
            ThawProblem::OtherComponent(self.component.clone())
        } else if self.version != version {
            ThawProblem::OtherVersion {
                frozen: self.version,
                present: version,
            }
        } else {
            match cbor::decode(&self.fields) {
                Ok(fields) => return Ok(fields),
                Err(error) => ThawProblem::Malformed(error),
            }
        };
        Err(ThawError {
            component: component.to_owned(),
            problem,
        })
    }

    fn refused(&self, problem: ThawProblem) -> ThawError {
        ThawError {
            component: self.component.clone(),
            problem,
        }
    }
}

/// The type, the version and the number of bytes; the bytes themselves are for [`FrozenState::to_datum`].
impl fmt::Debug for FrozenState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            component,
            version,
            fields,
        } = self;
        write!(f, "{component} v{version}, {} bytes", fields.len())
    }
}

/// Why a component cannot be frozen now, or at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("`{component}` cannot be frozen: {reason}")]
pub struct CannotFreeze {
    /// The type of the component.
    pub component: String,
    /// What stands in the way.
    pub reason: FreezeProblem,
}

/// What stands in the way of freezing a component.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FreezeProblem {
    /// The component leaves out [`Component::freeze`](crate::Component::freeze).
    #[error(
        "it does not implement `Component::freeze` and `thaw`: derive `Freeze`, and add `asmotion_component::freeze_by_fields!()` to its `impl Component`"
    )]
    NotImplemented,
    /// Work is under way outside of the component; it can be frozen when that is done.
    #[error("{0}, which is under way")]
    Busy(String),
    /// A field has no form as data.
    #[error(transparent)]
    NoData(DatumError),
}

/// Why a component does not take a frozen state. The component is as it was before.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("`{component}` does not take the frozen state: {problem}")]
pub struct ThawError {
    /// The type of the component.
    pub component: String,
    /// What does not fit.
    pub problem: ThawProblem,
}

/// What of a frozen state does not fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ThawProblem {
    /// The component leaves out [`Component::thaw`](crate::Component::thaw).
    #[error("it does not implement `Component::thaw`")]
    NotImplemented,
    /// The state is of another type of component.
    #[error("it is a state of `{0}`")]
    OtherComponent(String),
    /// The state has been frozen by another version of the component.
    #[error("it has layout {frozen}, and this build has layout {present}")]
    OtherVersion {
        /// The version of the state.
        frozen: u32,
        /// The version of the component.
        present: u32,
    },
    /// The bytes are not what this type of component writes.
    #[error(transparent)]
    Malformed(DatumError),
    /// The state is readable, but does not belong to this component: what differs.
    #[error("{0}")]
    Foreign(String),
}

/// A component whose struct says what of it is state: see the [derive](derive@crate::Freeze).
pub trait Freeze {
    /// The type of the component, as composites name it.
    const COMPONENT: &'static str;
    /// Number of the present layout; to be incremented whenever the meaning of a field changes.
    const VERSION: u32;

    /// The fields that are state, by name, in order.
    ///
    /// # Errors
    /// Work is under way, or a field has no form as data.
    fn fields(&self) -> Result<Vec<(FieldName, Datum)>, FreezeProblem>;

    /// Sets all fields, or none.
    ///
    /// # Errors
    /// A field is missing, unknown, or not what the type writes.
    fn set_fields(&mut self, fields: &[(FieldName, Datum)]) -> Result<(), DatumError>;
}

/// Freezes a component by its fields.
///
/// # Errors
/// Work is under way, or a field has no form as data.
pub fn freeze_fields<C: Freeze>(component: &C) -> Result<FrozenState, CannotFreeze> {
    let fields = component.fields().map_err(|reason| CannotFreeze {
        component: C::COMPONENT.to_owned(),
        reason,
    })?;
    FrozenState::of(C::COMPONENT, C::VERSION, &Datum::Record(fields))
}

/// Sets the fields of a component to a frozen state, all or none.
///
/// # Errors
/// The state is of another type or version, or the bytes are not what the type writes.
pub fn thaw_fields<C: Freeze>(component: &mut C, state: &FrozenState) -> Result<(), ThawError> {
    let record: Datum = state.read(C::COMPONENT, C::VERSION)?;
    let set = entries(&record).and_then(|fields| component.set_fields(fields));
    set.map_err(|error| state.refused(ThawProblem::Malformed(error)))
}

/// The two methods of a [`Component`](crate::Component) that derives [`Freeze`]; stands in its `impl Component`.
#[macro_export]
macro_rules! freeze_by_fields {
    () => {
        fn freeze(&self) -> ::core::result::Result<$crate::FrozenState, $crate::CannotFreeze> {
            $crate::freeze_fields(self)
        }

        fn thaw(
            &mut self,
            state: &$crate::FrozenState,
        ) -> ::core::result::Result<(), $crate::ThawError> {
            $crate::thaw_fields(self, state)
        }
    };
}

/// A field that is state. Everything that serde reads and writes is, and so is a [`PropertySet`].
pub trait StateField {
    /// A value that has been read, on its way into the field.
    type Read;

    /// The value as data.
    ///
    /// # Errors
    /// It has no form as data.
    fn to_datum(&self) -> Result<Datum, DatumError>;

    /// Reads a value.
    ///
    /// # Errors
    /// The data does not fit.
    fn read(datum: &Datum) -> Result<Self::Read, DatumError>;

    /// Puts a value that has been read into the field.
    fn set(&mut self, read: Self::Read);
}

impl<T: Serialize + DeserializeOwned> StateField for T {
    type Read = T;

    fn to_datum(&self) -> Result<Datum, DatumError> {
        Datum::of(self)
    }

    fn read(datum: &Datum) -> Result<T, DatumError> {
        datum.to()
    }

    fn set(&mut self, read: T) {
        *self = read;
    }
}

/// The values of the last refresh. After thawing, the next refresh reads the properties again.
impl<P: Properties> StateField for PropertySet<P> {
    type Read = P;

    fn to_datum(&self) -> Result<Datum, DatumError> {
        P::to_datum(self)
    }

    fn read(datum: &Datum) -> Result<P, DatumError> {
        P::of_datum(datum)
    }

    fn set(&mut self, read: P) {
        self.set_values(read);
    }
}

/// A short text that tells apart what a frozen state can belong to: specifications, bindings, declarations. (FNV-1a of
/// 64 bits: against mistakes, not against an adversary.)
pub fn fingerprint<'t>(texts: impl IntoIterator<Item = &'t str>) -> String {
    // a byte that no text contains keeps neighbours apart
    let bytes = texts
        .into_iter()
        .flat_map(|text| text.bytes().chain([0xff]));
    let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{hash:016x}")
}

/// The entries of a record. For the derive macros.
///
/// # Errors
/// It is no record.
pub fn entries(datum: &Datum) -> Result<&[(FieldName, Datum)], DatumError> {
    match datum {
        Datum::Record(entries) => Ok(entries),
        Datum::Null
        | Datum::Bool(_)
        | Datum::Int(_)
        | Datum::Float(_)
        | Datum::Text(_)
        | Datum::Bytes(_)
        | Datum::Numbers(_)
        | Datum::List(_) => Err(mismatch(format!(
            "expected a record, found {}",
            datum.kind()
        ))),
    }
}

/// One field as an entry of a record. For the derive macros.
///
/// # Errors
/// The value has no form as data.
pub fn entry(
    name: &'static str,
    value: &impl StateField,
) -> Result<(FieldName, Datum), FreezeProblem> {
    let datum = value.to_datum();
    let datum = datum.map_err(|error| FreezeProblem::NoData(error.within(name)))?;
    Ok((name.into(), datum))
}

/// One field of a record, read. For the derive macros.
///
/// # Errors
/// There is no such field, or its data does not fit.
pub fn field<F: StateField>(
    fields: &[(FieldName, Datum)],
    name: &str,
) -> Result<F::Read, DatumError> {
    F::read(one(fields, name)?).map_err(|error| error.within(name))
}

/// One field of a record that is itself a struct of properties. For the derive macros.
///
/// # Errors
/// There is no such field, or its data does not fit.
pub fn nested<P: Properties>(fields: &[(FieldName, Datum)], name: &str) -> Result<P, DatumError> {
    P::of_datum(one(fields, name)?).map_err(|error| error.within(name))
}

/// One field of a record that is a word. For the derive macros.
///
/// # Errors
/// There is no such field, or no such word.
pub fn word<W: Word>(fields: &[(FieldName, Datum)], name: &str) -> Result<W, DatumError> {
    let word = one(fields, name)?.as_text().and_then(W::of_word);
    word.ok_or_else(|| mismatch("expected a word of the type".to_owned()).within(name))
}

fn one<'a>(fields: &'a [(FieldName, Datum)], name: &str) -> Result<&'a Datum, DatumError> {
    let mut found = fields.iter().filter(|(known, _)| known == name);
    match (found.next(), found.next()) {
        (Some((_, datum)), None) => Ok(datum),
        (Some(_), Some(_)) | (None, _) => {
            Err(mismatch(format!("expected the field `{name}` once")))
        }
    }
}

/// Refuses fields that are not known. For the derive macros.
///
/// # Errors
/// The first of them.
pub fn refuse_unknown(fields: &[(FieldName, Datum)], known: &[&str]) -> Result<(), DatumError> {
    let unknown = |(name, _): &&(FieldName, Datum)| !known.contains(&&**name);
    match fields.iter().find(unknown) {
        Some((name, _)) => Err(mismatch(format!("unknown field `{name}`"))),
        None => Ok(()),
    }
}

fn mismatch(what: String) -> DatumError {
    DatumError::new(DatumProblem::Mismatch(what))
}
