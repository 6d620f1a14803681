//! Checks values of properties before there is a component.

use std::fmt;

use asmotion_datum::{Datum, DatumError, Described};

/// Checks values by converting them to a property's type, which can accept fewer values than its schema: a line of a script is a
/// text of a certain form. The default accepts all values: in another process, a type is known by its schema alone.
#[derive(Clone, Copy, Default)]
pub struct PropertyConversion(Option<ConversionCheck>);

/// Converts a value and drops the result.
type ConversionCheck = fn(&Datum) -> Result<(), DatumError>;

impl PropertyConversion {
    /// The conversion to a type.
    pub fn to<T: Described>() -> Self {
        Self(Some(|value| T::read(value).map(drop)))
    }

    /// Converts a value.
    ///
    /// # Errors
    /// The reason that the type does not accept the value.
    pub fn check(&self, value: &Datum) -> Result<(), DatumError> {
        self.0.map_or(Ok(()), |convert| convert(value))
    }
}

impl fmt::Debug for PropertyConversion {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("PropertyConversion")
    }
}

impl PartialEq for PropertyConversion {
    /// Declarations are compared by their schemas.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
