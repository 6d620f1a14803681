//! Real numbers with a total order.

use std::cmp::Ordering;
use std::hash::{Hash, Hasher};

/// A 64-bit float with total equality and order: those of IEEE 754 `totalOrder`, with a single NaN.
/// `NaN = NaN` and `-0.0 < 0.0` hold.
#[derive(Clone, Copy, Debug, Default)]
pub struct Real(f64);

impl Real {
    /// Creates a number; every NaN becomes the same one.
    pub fn new(number: f64) -> Self {
        Self(if number.is_nan() { f64::NAN } else { number })
    }

    /// Returns the number as a float.
    pub fn get(self) -> f64 {
        self.0
    }
}

impl PartialEq for Real {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_bits() == other.0.to_bits()
    }
}

impl Eq for Real {}

impl PartialOrd for Real {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Real {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl Hash for Real {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.to_bits().hash(state);
    }
}
