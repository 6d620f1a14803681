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

/// Formats a number for messages: very large and very small ones with an exponent.
pub(crate) fn shown(number: f64) -> String {
    let size = number.abs();
    if size == 0.0 || (1e-5..1e16).contains(&size) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let space = if self.unit.is_empty() { "" } else { " " };
        let unit = format!("{space}{}", self.unit);
        match (self.min.map(shown), self.max.map(shown)) {
            (Some(min), Some(max)) => write!(f, "{min} ..= {max}{unit}"),
            (Some(min), None) => write!(f, "{min} ..{unit}"),
            (None, Some(max)) => write!(f, "..= {max}{unit}"),
            (None, None) => f.write_str("any range"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_and_small_numbers_have_an_exponent() {
        for (number, text) in [
            (0.0, "0"),
            (0.5, "0.5"),
            (-1e15, "-1000000000000000"),
            (1e308, "1e308"),
            (-2.5e20, "-2.5e20"),
            (1e-9, "1e-9"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(shown(number), text);
        }
    }
}
