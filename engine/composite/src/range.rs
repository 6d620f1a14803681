//! Numeric ranges.

/// A numeric range, inclusive; `None` for an unlimited end.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Range {
    pub min: Option<f64>,
    pub max: Option<f64>,
    /// Unit displayed after the limits; empty if none.
    pub unit: String,
}

impl Range {
    pub(crate) fn contains(&self, number: f64) -> bool {
        self.min.is_none_or(|min| number >= min) && self.max.is_none_or(|max| number <= max)
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let space = if self.unit.is_empty() { "" } else { " " };
        let unit = format!("{space}{}", self.unit);
        match (self.min, self.max) {
            (Some(min), Some(max)) => write!(f, "{min} ..= {max}{unit}"),
            (Some(min), None) => write!(f, "{min} ..{unit}"),
            (None, Some(max)) => write!(f, "..= {max}{unit}"),
            (None, None) => f.write_str("any range"),
        }
    }
}
