//! Duration literals in attributes, such as `"200ms"`.

use syn::{Error, LitStr, Result};

/// Units of duration literals, with their length in nanoseconds.
const UNITS: [(&str, u64); 5] = [
    ("ns", 1),
    ("us", 1_000),
    ("ms", 1_000_000),
    ("s", 1_000_000_000),
    ("min", 60_000_000_000),
];

/// Parses a duration literal and returns its nanoseconds.
pub fn nanos(text: &LitStr) -> Result<u64> {
    let written = text.value();
    let digits = written.find(|c: char| !c.is_ascii_digit());
    let (number, unit) = written.split_at(digits.unwrap_or(written.len()));
    let number: Option<u64> = number.parse().ok();
    let unit = UNITS.iter().find(|(name, _)| *name == unit.trim());
    let nanos = number
        .zip(unit)
        .and_then(|(number, (_, unit))| number.checked_mul(*unit));
    nanos.ok_or_else(|| {
        let message =
            "a duration is a whole number and `ns`, `us`, `ms`, `s` or `min`, as in \"200ms\"";
        Error::new(text.span(), message)
    })
}

/// Returns how many of a unit make a second, for the units that composites use for durations.
pub fn per_second(unit: &str) -> Option<f64> {
    match unit {
        "s" => Some(1.0),
        "ms" => Some(1e3),
        "us" => Some(1e6),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proc_macro2::Span;

    fn read(text: &str) -> Option<u64> {
        nanos(&LitStr::new(text, Span::call_site())).ok()
    }

    #[test]
    fn it_reads_whole_numbers_of_a_unit() {
        assert_eq!(read("200ms"), Some(200_000_000));
        assert_eq!(read("1 min"), Some(60_000_000_000));
        assert_eq!(read("0s"), Some(0));
    }

    #[test]
    fn it_refuses_what_is_no_duration() {
        for text in [
            "",
            "s",
            "200",
            "1.5s",
            "-1s",
            "3 fortnights",
            "99999999999min",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }
}
