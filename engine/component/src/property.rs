//! Properties: typed settings with a default, a range and a unit; constant during a cycle.

use std::any::Any;
use std::fmt::Debug;
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use asmotion_datum::{Datum, DatumError, Described};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::declaration::PropertyDeclaration;
use crate::handle;
use crate::interface::Interface;
use crate::suggestion::suggestion;

/// What a property may hold: numbers, truth values, text, runs of them, messages.
pub trait PropertyValue:
    Described + Serialize + DeserializeOwned + Clone + Debug + Send + Sync + 'static
{
}

impl<T: Described + Serialize + DeserializeOwned + Clone + Debug + Send + Sync + 'static>
    PropertyValue for T
{
}

/// Why a property cannot have a value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("property `{property}` of `{component}` {problem}")]
pub struct PropertyError {
    /// The component.
    pub component: String,
    /// The property.
    pub property: String,
    /// What is wrong.
    pub problem: Box<PropertyProblem>,
}

/// What is wrong with a property or its value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PropertyProblem {
    /// The component has no such property.
    #[error("does not exist{}", suggestion(nearest.as_deref()))]
    Unknown {
        /// A name like it.
        nearest: Option<String>,
    },
    /// The value is of another type.
    #[error("is {expected}: {source}")]
    Mismatch {
        /// The property's type.
        expected: String,
        /// What does not fit, and where.
        source: DatumError,
    },
    /// The value is outside of the range.
    #[error("cannot be {value}: it is {least} to {greatest}{}{unit}", space(unit))]
    OutOfRange {
        /// The value.
        value: Datum,
        /// The least lawful value.
        least: Datum,
        /// The greatest lawful value.
        greatest: Datum,
        /// The unit of all three.
        unit: String,
    },
    /// The value is none of the choices.
    #[error("cannot be {value}: it is one of {}", list(choices))]
    NoChoice {
        /// The value.
        value: Datum,
        /// The lawful ones.
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

/// A property in the making: `interface.setting("speed_mps", 0.6, "cruise speed").range(0.0..=5.0).unit("m/s").declare()`.
#[must_use = "a setting is declared by `declare`"]
pub struct Setting<'a, T: PropertyValue> {
    pub(crate) interface: &'a mut Interface,
    pub(crate) declaration: PropertyDeclaration,
    pub(crate) value: T,
    check: Check<T>,
}

/// Which values are lawful.
struct Check<T> {
    range: Option<(Contains<T>, RangeInclusive<T>)>,
}

/// How a range of a type that has an order is asked; known only where the range is given.
type Contains<T> = fn(&T, &RangeInclusive<T>) -> bool;

impl<'a, T: PropertyValue> Setting<'a, T> {
    pub(crate) fn new(interface: &'a mut Interface, name: &str, default: T, doc: &str) -> Self {
        let declaration = PropertyDeclaration {
            name: name.to_owned(),
            doc: doc.to_owned(),
            schema: T::describe(),
            unit: String::new(),
            default: interface.datum_of(name, &default),
            range: None,
            choices: Vec::new(),
        };
        Self {
            interface,
            declaration,
            value: default,
            check: Check { range: None },
        }
    }

    /// With these bounds, both lawful.
    pub fn range(mut self, range: RangeInclusive<T>) -> Self
    where
        T: PartialOrd,
    {
        let least = (self.interface).datum_of(&self.declaration.name, range.start());
        let greatest = (self.interface).datum_of(&self.declaration.name, range.end());
        self.declaration.range = Some((least, greatest));
        self.check.range = Some((|value, range| range.contains(value), range));
        self
    }

    /// With this unit: `m/s`.
    pub fn unit(mut self, unit: &str) -> Self {
        unit.clone_into(&mut self.declaration.unit);
        self
    }

    /// With no values but these.
    pub fn choices(mut self, choices: impl IntoIterator<Item = impl Into<T>>) -> Self {
        let name = self.declaration.name.clone();
        self.declaration.choices = choices
            .into_iter()
            .map(|choice| self.interface.datum_of(&name, &choice.into()))
            .collect();
        self
    }

    /// Declares the property.
    pub fn declare(self) -> handle::Property<T> {
        let slot = Slot {
            declaration: self.declaration,
            value: self.value,
            next: None,
            check: self.check,
            revision: Arc::clone(self.interface.revision()),
        };
        self.interface.add_property(slot)
    }
}

/// A property at run time.
pub(crate) struct Slot<T> {
    declaration: PropertyDeclaration,
    pub value: T,
    /// The value after the present cycle.
    next: Option<T>,
    check: Check<T>,
    /// Incremented with each change, for all properties of the component.
    revision: Arc<AtomicU64>,
}

/// A property at run time, whose type the caller does not know. One thread at a time has it: its component's.
pub trait AnyProperty: Any + Send {
    /// What the component declared.
    fn declaration(&self) -> &PropertyDeclaration;

    /// The present value.
    ///
    /// # Errors
    /// The value has no form as data, which its own `Serialize` has refused.
    fn get(&self) -> Result<Datum, DatumError>;

    /// Checks that a value is lawful.
    ///
    /// # Errors
    /// The value is of another type, out of range or none of the choices.
    fn check(&self, value: &Datum) -> Result<(), PropertyProblem>;

    /// Gets a lawful value ready; [`AnyProperty::apply`] puts it in place.
    fn prepare(&mut self, value: &Datum);

    /// The prepared value, if there is one.
    ///
    /// # Errors
    /// The value has no form as data.
    fn prepared(&self) -> Result<Option<Datum>, DatumError>;

    /// Puts the prepared value in place. Says whether there was one.
    fn apply(&mut self) -> bool;
}

impl<T: PropertyValue> AnyProperty for Slot<T> {
    fn declaration(&self) -> &PropertyDeclaration {
        &self.declaration
    }

    fn get(&self) -> Result<Datum, DatumError> {
        Datum::of(&self.value)
    }

    fn check(&self, value: &Datum) -> Result<(), PropertyProblem> {
        let declaration = &self.declaration;
        let typed: T = value.to().map_err(|source| PropertyProblem::Mismatch {
            expected: declaration.schema.to_string(),
            source,
        })?;
        if let (Some((contains, range)), Some((least, greatest))) =
            (&self.check.range, &declaration.range)
            && !contains(&typed, range)
        {
            return Err(PropertyProblem::OutOfRange {
                value: value.clone(),
                least: least.clone(),
                greatest: greatest.clone(),
                unit: declaration.unit.clone(),
            });
        }
        if !declaration.choices.is_empty() && !declaration.choices.contains(value) {
            return Err(PropertyProblem::NoChoice {
                value: value.clone(),
                choices: declaration.choices.clone(),
            });
        }
        Ok(())
    }

    fn prepare(&mut self, value: &Datum) {
        self.next = value.to().ok();
    }

    fn prepared(&self) -> Result<Option<Datum>, DatumError> {
        self.next.as_ref().map(Datum::of).transpose()
    }

    fn apply(&mut self) -> bool {
        let Some(next) = self.next.take() else {
            return false;
        };
        self.value = next;
        self.revision.fetch_add(1, Ordering::Relaxed);
        true
    }
}
