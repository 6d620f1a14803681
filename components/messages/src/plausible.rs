//! Checks of values that cannot be meant: not finite where a quantity is, or far beyond everything that a robot can measure.
//!
//! The limits do not depend on the robot. They keep sums, products and squares of accepted values finite.

use asmotion_datum::{DatumError, DatumProblem};

/// Limit of a coordinate, m; coordinates of geodesy (ECEF, UTM) are within it.
pub(crate) const LARGEST_POSITION: f64 = 1e7;
/// Limit of a speed, m/s or rad/s.
pub(crate) const LARGEST_SPEED: f64 = 1e5;
/// Limit of an angle that is never wrapped, rad.
pub(crate) const LARGEST_ANGLE: f64 = 1e9;
/// Limit of any other measurement, in its unit.
pub(crate) const LARGEST_MEASUREMENT: f64 = 1e9;
/// Limit of a duration, s: a century.
pub(crate) const LARGEST_DURATION: f64 = 3.2e9;

/// The error about a field.
pub(crate) fn implausible(field: &str, problem: &'static str) -> DatumError {
    DatumError::new(DatumProblem::Implausible(problem)).within(field)
}

/// Accepts a number whose size is at most `largest`; not NaN.
pub(crate) fn bounded(field: &str, value: f64, largest: f64) -> Result<(), DatumError> {
    if value.abs() <= largest {
        Ok(())
    } else {
        Err(implausible(field, "not finite, or too large"))
    }
}

/// Accepts a number from zero to `largest`.
pub(crate) fn positive(field: &str, value: f64, largest: f64) -> Result<(), DatumError> {
    if value < 0.0 {
        return Err(implausible(field, "negative"));
    }
    bounded(field, value, largest)
}

/// Accepts a list of numbers whose size is at most `largest`. The error does not name the element, so that all elements have one
/// cause.
pub(crate) fn all_bounded(field: &str, values: &[f64], largest: f64) -> Result<(), DatumError> {
    let mut values = values.iter();
    values.try_for_each(|value| bounded(field, *value, largest))
}
