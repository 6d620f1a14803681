//! Properties: typed settings with a default, a range and a unit; constant during a cycle.

use std::any::Any;
use std::fmt::Debug;
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use asmotion_datum::{Datum, DatumError, Described};
use serde::Serialize;

use crate::declaration::PropertyDeclaration;
use crate::suggestion::suggestion;

/// A type that a property may have: numbers, Booleans, text, lists, arrays, messages.
pub trait PropertyValue: Described + Serialize + Clone + Debug + Send + Sync + 'static {}

impl<T: Described + Serialize + Clone + Debug + Send + Sync + 'static> PropertyValue for T {}

/// A value that a property does not accept.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("property `{property}` of `{component}` {problem}")]
pub struct PropertyError {
    /// Name of the component.
    pub component: String,
    /// Name of the property.
    pub property: String,
    /// The violated requirement.
    pub problem: Box<PropertyProblem>,
}

/// The violated requirement of a property.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PropertyProblem {
    /// The component declares no such property.
    #[error("does not exist{}", suggestion(nearest.as_deref()))]
    Unknown {
        /// A similar name that exists, as a suggestion.
        nearest: Option<String>,
    },
    /// The value has another type.
    #[error("must be {expected}: {source}")]
    Mismatch {
        /// Name of the property's type.
        expected: String,
        /// The first difference and its place in the value.
        source: DatumError,
    },
    /// The value is outside the range.
    #[error("must be between {min} and {max}{}{unit}, not {value}", space(unit))]
    OutOfRange {
        /// The rejected value.
        value: Datum,
        /// The least allowed value.
        min: Datum,
        /// The greatest allowed value.
        max: Datum,
        /// Unit of the three values; empty without one.
        unit: String,
    },
    /// The value is none of the choices.
    #[error("must be one of {}, not {value}", list(choices))]
    NotAChoice {
        /// The rejected value.
        value: Datum,
        /// The allowed values.
        choices: Vec<Datum>,
    },
}

fn space(unit: &str) -> &str {
    if unit.is_empty() { "" } else { " " }
}

fn list(choices: &[Datum]) -> String {
    let words: Vec<_> = choices.iter().map(ToString::to_string).collect();
    words.join(", ")
}

/// Checks values against the declaration.
pub(crate) struct Check<T> {
    pub range: Option<(Contains<T>, RangeInclusive<T>)>,
    /// `true` if values are compared with the declared schema, because the Rust type accepts any datum.
    pub by_schema: bool,
}

impl<T> Default for Check<T> {
    fn default() -> Self {
        Self {
            range: None,
            by_schema: false,
        }
    }
}

/// Tests whether a range contains a value. Stored as a function because only the `range` method requires `PartialOrd`.
pub(crate) type Contains<T> = fn(&T, &RangeInclusive<T>) -> bool;

/// A property at run time.
pub(crate) struct Slot<T> {
    pub declaration: PropertyDeclaration,
    pub value: T,
    /// The staged value, which `apply` puts into effect.
    pub staged: Option<T>,
    pub check: Check<T>,
    /// Number of changes of all properties of the component.
    pub revision: Arc<AtomicU64>,
}

/// A property at run time, without its static type. Used by its component's thread only.
pub trait AnyProperty: Any + Send {
    /// Returns the declaration: name, type, default, range and unit.
    fn declaration(&self) -> &PropertyDeclaration;

    /// The current value.
    ///
    /// # Errors
    /// An error of the value's own `Serialize` implementation.
    fn get(&self) -> Result<Datum, DatumError>;

    /// Sets the allowed values; none for no limit.
    fn set_choices(&mut self, choices: &[Datum]);

    /// Checks that a value is allowed.
    ///
    /// # Errors
    /// The violated requirement: type, range or choices.
    fn check(&self, value: &Datum) -> Result<(), PropertyProblem>;

    /// Stages an allowed value; [`AnyProperty::apply`] puts it into effect.
    fn stage(&mut self, value: &Datum);

    /// Returns the staged value; `None` if there is none.
    ///
    /// # Errors
    ///
    /// An error if the value cannot be represented as a datum.
    fn staged(&self) -> Result<Option<Datum>, DatumError>;

    /// Puts the staged value into effect. Returns whether there was one.
    fn apply(&mut self) -> bool;
}

impl<T: PropertyValue> AnyProperty for Slot<T> {
    fn declaration(&self) -> &PropertyDeclaration {
        &self.declaration
    }

    fn get(&self) -> Result<Datum, DatumError> {
        Datum::of(&self.value)
    }

    fn set_choices(&mut self, choices: &[Datum]) {
        self.declaration.choices = choices.to_vec();
    }

    fn check(&self, value: &Datum) -> Result<(), PropertyProblem> {
        let declaration = &self.declaration;
        let mismatch = |source| PropertyProblem::Mismatch {
            expected: declaration.schema.to_string(),
            source,
        };
        let typed = T::read(value).map_err(mismatch)?;
        if self.check.by_schema {
            declaration.schema.accepts(value).map_err(mismatch)?;
        }
        if let (Some((contains, range)), Some((least, greatest))) =
            (&self.check.range, &declaration.range)
            && !contains(&typed, range)
        {
            return Err(PropertyProblem::OutOfRange {
                value: value.clone(),
                min: least.clone(),
                max: greatest.clone(),
                unit: declaration.unit.clone(),
            });
        }
        if !declaration.choices.is_empty() && !declaration.choices.contains(value) {
            return Err(PropertyProblem::NotAChoice {
                value: value.clone(),
                choices: declaration.choices.clone(),
            });
        }
        Ok(())
    }

    fn stage(&mut self, value: &Datum) {
        self.staged = T::read(value).ok();
    }

    fn staged(&self) -> Result<Option<Datum>, DatumError> {
        self.staged.as_ref().map(Datum::of).transpose()
    }

    fn apply(&mut self) -> bool {
        let Some(next) = self.staged.take() else {
            return false;
        };
        self.value = next;
        self.revision.fetch_add(1, Ordering::Relaxed);
        true
    }
}
