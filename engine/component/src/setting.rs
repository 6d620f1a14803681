//! Properties in the making.

use std::ops::RangeInclusive;
use std::sync::Arc;

use asmotion_datum::Datum;

use crate::conversion::PropertyConversion;
use crate::declaration::PropertyDeclaration;
use crate::handle;
use crate::interface::Interface;
use crate::property::{Check, Contains, PropertyValue, Slot};

/// The declaration of a property in progress:
/// `interface.setting("speed_mps", 0.6, "cruise speed").range(0.0..=5.0).unit("m/s").declare()`.
#[must_use = "a setting is declared by `declare`"]
pub struct Setting<'a, T: PropertyValue> {
    pub(crate) interface: &'a mut Interface,
    pub(crate) declaration: PropertyDeclaration,
    pub(crate) value: T,
    check: Check<T>,
}

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
            conversion: PropertyConversion::to::<T>(),
        };
        Self {
            interface,
            declaration,
            value: default,
            check: Check::default(),
        }
    }

    /// Sets the range of allowed values, both ends inclusive.
    pub fn range(mut self, range: RangeInclusive<T>) -> Self
    where
        T: PartialOrd,
    {
        let least = self
            .interface
            .datum_of(&self.declaration.name, range.start());
        let greatest = self.interface.datum_of(&self.declaration.name, range.end());
        self.declaration.range = Some((least, greatest));
        self.check.range = Some((|value, range| range.contains(value), range));
        self
    }

    /// Sets the unit, for example `m/s`.
    pub fn unit(mut self, unit: &str) -> Self {
        unit.clone_into(&mut self.declaration.unit);
        self
    }

    /// Restricts the value to these choices.
    pub fn choices(mut self, choices: impl IntoIterator<Item = impl Into<T>>) -> Self {
        let name = self.declaration.name.clone();
        self.declaration.choices = choices
            .into_iter()
            .map(|choice| self.interface.datum_of(&name, &choice.into()))
            .collect();
        self
    }

    /// Declares the property and returns its handle.
    pub fn declare(self) -> handle::Property<T> {
        let slot = Slot {
            declaration: self.declaration,
            value: self.value,
            staged: None,
            check: self.check,
            revision: Arc::clone(self.interface.revision()),
        };
        self.interface.add_property(slot)
    }
}

impl Interface {
    /// Declares a property without limits.
    pub fn property<T: PropertyValue>(
        &mut self,
        name: &str,
        default: T,
        doc: &str,
    ) -> handle::Property<T> {
        self.setting(name, default, doc).declare()
    }

    /// Begins the declaration of a property with a range, a unit or choices:
    /// `interface.setting(…).range(0.0..=5.0).unit("m").declare()`.
    pub fn setting<T: PropertyValue>(
        &mut self,
        name: &str,
        default: T,
        doc: &str,
    ) -> Setting<'_, T> {
        Setting::new(self, name, default, doc)
    }

    /// Declares a property whose type is known only at run time, by its schema.
    pub fn property_of(&mut self, declaration: PropertyDeclaration) -> handle::Property<Datum> {
        let range = declaration.range.clone();
        let contains: Contains<Datum> = |value, range| match (value, range.start(), range.end()) {
            (Datum::Int(value), Datum::Int(least), Datum::Int(greatest)) => {
                (least..=greatest).contains(&value)
            }
            (value, least, greatest) => match (least.as_float(), greatest.as_float()) {
                (Some(least), Some(greatest)) => value
                    .as_float()
                    .is_some_and(|value| (least..=greatest).contains(&value)),
                _ => true,
            },
        };
        let slot = Slot {
            value: declaration.default.clone(),
            staged: None,
            check: Check {
                range: range.map(|(least, greatest)| (contains, least..=greatest)),
                by_schema: true,
            },
            revision: Arc::clone(self.revision()),
            declaration,
        };
        self.add_property(slot)
    }
}
