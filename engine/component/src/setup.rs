//! Setup: what a component sees while it is configured.

use std::any::Any;
use std::cell::Cell;

use crate::Fault;
use crate::body::Body;
use crate::handle::Property;
use crate::property::{self, PropertyValue};

/// What a component sees while it is configured: its properties.
pub struct Setup<'a> {
    body: &'a Body,
    name: &'a str,
    /// A handle was not this component's.
    foreign: Cell<bool>,
}

impl<'a> Setup<'a> {
    pub(crate) fn new(body: &'a Body, name: &'a str) -> Self {
        Self {
            body,
            name,
            foreign: Cell::new(false),
        }
    }

    /// The component's name in the system.
    pub fn name(&self) -> &str {
        self.name
    }

    /// The value of a property.
    pub fn property<T: PropertyValue>(&self, property: Property<T>) -> T {
        self.body.value(property).unwrap_or_else(|| {
            self.foreign.set(true);
            T::initial()
        })
    }

    /// Fails if a handle was not this component's.
    pub(crate) fn finish(self) -> Result<(), Fault> {
        if !self.foreign.get() {
            return Ok(());
        }
        let kind = "property".into();
        Err(Fault::ForeignHandle { kind })
    }
}

impl Body {
    /// The value of a property, if the handle is this component's.
    pub(crate) fn value<T: PropertyValue>(&self, property: Property<T>) -> Option<T> {
        let slot = self.properties.get(property.position(self.owner))?;
        let slot: &property::Slot<T> = (&**slot as &dyn Any).downcast_ref()?;
        Some(slot.value.clone())
    }
}
