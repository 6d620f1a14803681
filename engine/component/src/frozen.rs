//! Frozen states: the state of a component between two cycles as data.
//!
//! A model checker stores many states, compares them and continues from each; a recording starts with one and is
//! replayed from there. Both need the state of a component as plain bytes. `#[derive(Freeze)]` on the component's
//! struct generates the conversion: each field becomes an entry of a CBOR record, unless it is marked
//! - `#[freeze(skip)]`: part of the environment, such as a port or a file source; left unchanged by thawing, or
//! - `#[freeze(reset)]`: irrelevant for later cycles, such as a cache or working memory; set to its [`Default`].
//!
//! Fields are serialised with serde, [`PropertySet`]s by their last values. Since frozen bytes may come from an
//! untrusted source, a type with invariants should validate them with `#[serde(try_from = "…")]`. The serialisation
//! must be deterministic: use a `BTreeMap`, not a `HashMap`.

use std::fmt;

pub use asmotion_datum::{Datum, DatumError, FieldName};
use asmotion_datum::{DatumProblem, Word, cbor};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::derived::{Properties, PropertySet};

/// The state of a component between two cycles.
///
/// Two states are equal if and only if their bytes are. This includes floating-point numbers: NaN equals itself, and
/// zero differs from negative zero. A state belongs to a component type, not to an instance, and can be thawed into any
/// component of that type. It contains the values of the component's properties, including secrets.
///
/// States are serialised with serde, for example as CBOR:
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
    /// Fields encoded as a CBOR record.
    #[serde(with = "serde_bytes")]
    fields: Box<[u8]>,
}

impl FrozenState {
    /// Creates a state from a custom record, for components that do not use `#[derive(Freeze)]`.
    ///
    /// # Errors
    ///
    /// An error if the value cannot be represented as a datum.
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

    /// Returns the component type, such as `nav::TrajectoryFollower`.
    pub fn component(&self) -> &str {
        &self.component
    }

    /// Returns the version of the layout used by the component type.
    pub fn version(&self) -> u32 {
        self.version
    }

    /// Returns the encoded fields. Equal states have equal bytes.
    pub fn as_bytes(&self) -> &[u8] {
        &self.fields
    }

    /// Returns the fields by name, for display and for comparison field by field.
    ///
    /// # Errors
    ///
    /// An error if the bytes are malformed.
    pub fn to_datum(&self) -> Result<Datum, ThawError> {
        cbor::decode(&self.fields).map_err(|error| self.error(ThawProblem::Malformed(error)))
    }

    /// Decodes the state after checking the component type and the layout version.
    ///
    /// # Errors
    ///
    /// An error if the type or version differs, or if the bytes are malformed.
    pub fn read<T: DeserializeOwned>(&self, component: &str, version: u32) -> Result<T, ThawError> {
        let problem = if self.component != component {
            ThawProblem::ComponentMismatch(self.component.clone())
        } else if self.version != version {
            ThawProblem::VersionMismatch {
                frozen: self.version,
                current: version,
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

    fn error(&self, problem: ThawProblem) -> ThawError {
        ThawError {
            component: self.component.clone(),
            problem,
        }
    }
}

/// Displays the type, the version and the number of bytes; see [`FrozenState::to_datum`] for the content.
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

/// The error type of freezing a component.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("`{component}` cannot be frozen: {reason}")]
pub struct CannotFreeze {
    /// Type of the component.
    pub component: String,
    /// Reason for the failure.
    pub reason: FreezeProblem,
}

/// The reason that a component cannot be frozen.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FreezeProblem {
    /// The component does not implement [`Component::freeze`](crate::Component::freeze).
    #[error(
        "it does not implement `Component::freeze` and `thaw`: derive `Freeze`, and add `asmotion_component::freeze_by_fields!()` to its `impl Component`"
    )]
    NotImplemented,
    /// Background work is in progress; the component can be frozen once it is done. Contains a description of the work.
    #[error("{0} in the background")]
    Busy(String),
    /// The component refuses, for this reason.
    #[error("{0}")]
    Refused(String),
    /// A field cannot be represented as a datum.
    #[error(transparent)]
    NoData(DatumError),
}

/// The error type of thawing a component, which is then unchanged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("`{component}` rejects the frozen state: {problem}")]
pub struct ThawError {
    /// Type of the component.
    pub component: String,
    /// Reason for the failure.
    pub problem: ThawProblem,
}

/// The reason that a frozen state is rejected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ThawProblem {
    /// The component does not implement [`Component::thaw`](crate::Component::thaw).
    #[error("it does not implement `Component::thaw`")]
    NotImplemented,
    /// The state has another component type, contained here.
    #[error("it is the state of a `{0}`")]
    ComponentMismatch(String),
    /// The state was frozen by another version of the component.
    #[error("it has layout {frozen}, and this build has layout {current}")]
    VersionMismatch {
        /// Version of the state.
        frozen: u32,
        /// Version of the component.
        current: u32,
    },
    /// The bytes are malformed.
    #[error(transparent)]
    Malformed(DatumError),
    /// The state is well-formed but belongs to another component; contains a description of the difference.
    #[error("{0}")]
    Foreign(String),
}

/// A component whose struct declares which of its fields are state; see the [derive](derive@crate::Freeze).
pub trait Freeze {
    /// Type of the component, as named in composites.
    const COMPONENT: &'static str;
    /// Version of the layout; must be incremented whenever the meaning of a field changes.
    const VERSION: u32;

    /// Returns the state fields by name, in declaration order.
    ///
    /// # Errors
    ///
    /// An error if background work is in progress or if a field cannot be represented as a datum.
    fn fields(&self) -> Result<Vec<(FieldName, Datum)>, FreezeProblem>;

    /// Sets all fields; on error none is changed.
    ///
    /// # Errors
    ///
    /// An error if a field is missing, unknown or malformed.
    fn set_fields(&mut self, fields: &[(FieldName, Datum)]) -> Result<(), DatumError>;
}

/// Freezes a component by its fields.
///
/// # Errors
///
/// An error if background work is in progress or if a field cannot be represented as a datum.
pub fn freeze_fields<C: Freeze>(component: &C) -> Result<FrozenState, CannotFreeze> {
    let fields = component.fields().map_err(|reason| CannotFreeze {
        component: C::COMPONENT.to_owned(),
        reason,
    })?;
    FrozenState::of(C::COMPONENT, C::VERSION, &Datum::Record(fields))
}

/// Restores the fields of a component from a frozen state; on error none is changed.
///
/// # Errors
///
/// An error if the type or version differs, or if the bytes are malformed.
pub fn thaw_fields<C: Freeze>(component: &mut C, state: &FrozenState) -> Result<(), ThawError> {
    let record: Datum = state.read(C::COMPONENT, C::VERSION)?;
    let set = entries(&record).and_then(|fields| component.set_fields(fields));
    set.map_err(|error| state.error(ThawProblem::Malformed(error)))
}

/// Implements the two methods of a [`Component`](crate::Component) that derives [`Freeze`]; used in its
/// `impl Component`.
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

/// A type of state fields: every type that serde can serialise and deserialise, and [`PropertySet`].
pub trait StateField {
    /// Decoded value. Decoding is separate from assignment, so that no field is changed if any is malformed.
    type Read;

    /// Returns the value as a datum.
    ///
    /// # Errors
    ///
    /// An error if it cannot be represented as a datum.
    fn to_datum(&self) -> Result<Datum, DatumError>;

    /// Decodes a value.
    ///
    /// # Errors
    ///
    /// An error if the datum has another type.
    fn read(datum: &Datum) -> Result<Self::Read, DatumError>;

    /// Assigns a decoded value.
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

/// Freezes the values of the last refresh. After thawing, the next refresh reads the properties again.
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

/// Returns a short fingerprint of the texts a frozen state depends on, such as specifications, bindings and
/// declarations. It is a 64-bit FNV-1a hash, which protects against mistakes but not against an adversary.
pub fn fingerprint<'t>(texts: impl IntoIterator<Item = &'t str>) -> String {
    // the separator is a byte that does not occur in UTF-8, so that `ab`, `c` differs from `a`, `bc`
    let bytes = texts
        .into_iter()
        .flat_map(|text| text.bytes().chain([0xff]));
    let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{hash:016x}")
}

/// Returns the entries of a record. Used by the derive macros.
///
/// # Errors
///
/// An error if the datum is not a record.
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

/// Returns a field as an entry of a record. Used by the derive macros.
///
/// # Errors
///
/// An error if the value cannot be represented as a datum.
pub fn entry(
    name: &'static str,
    value: &impl StateField,
) -> Result<(FieldName, Datum), FreezeProblem> {
    let datum = value.to_datum();
    let datum = datum.map_err(|error| FreezeProblem::NoData(error.within(name)))?;
    Ok((name.into(), datum))
}

/// Decodes a field of a record. Used by the derive macros.
///
/// # Errors
///
/// An error if the field is missing or has another type.
pub fn field<F: StateField>(
    fields: &[(FieldName, Datum)],
    name: &str,
) -> Result<F::Read, DatumError> {
    F::read(only_value(fields, name)?).map_err(|error| error.within(name))
}

/// Decodes a field that is itself a struct of properties. Used by the derive macros.
///
/// # Errors
///
/// An error if the field is missing or has another type.
pub fn nested<P: Properties>(fields: &[(FieldName, Datum)], name: &str) -> Result<P, DatumError> {
    P::of_datum(only_value(fields, name)?).map_err(|error| error.within(name))
}

/// Decodes a field that is a word. Used by the derive macros.
///
/// # Errors
///
/// An error if the field is missing or its word is unknown.
pub fn word<W: Word>(fields: &[(FieldName, Datum)], name: &str) -> Result<W, DatumError> {
    let word = only_value(fields, name)?.as_text().and_then(W::of_word);
    word.ok_or_else(|| mismatch("expected a word of the type".to_owned()).within(name))
}

fn only_value<'a>(fields: &'a [(FieldName, Datum)], name: &str) -> Result<&'a Datum, DatumError> {
    let mut matching = fields.iter().filter(|(known, _)| known == name);
    match (matching.next(), matching.next()) {
        (Some((_, datum)), None) => Ok(datum),
        (Some(_), Some(_)) | (None, _) => {
            Err(mismatch(format!("expected the field `{name}` once")))
        }
    }
}

/// Rejects unknown fields. Used by the derive macros.
///
/// # Errors
///
/// An error naming the first unknown field.
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
