//! Formats values in a few characters, for the story and the monitor's tables.

use asmotion_datum::Datum;

/// Length of the longest list that is shown in full; longer lists are maps and scans.
pub const MOST: usize = 32;

/// Size from which a number has an exponent.
const LARGE: f64 = 1e15;

/// Formats a value briefly: numbers with four decimals, large ones with an exponent.
pub fn brief(value: &Datum) -> String {
    match value {
        Datum::Float(number) if number.is_finite() && number.abs() >= LARGE => {
            format!("{number:e}")
        }
        Datum::Float(number) if number.is_finite() => {
            let shown = format!("{number:.4}");
            let shown = shown.trim_end_matches('0').trim_end_matches('.');
            match shown {
                "-0" => "0".to_owned(),
                shown => shown.to_owned(),
            }
        }
        Datum::List(_) | Datum::Numbers(_) | Datum::Bytes(_) => {
            let count = value.count().unwrap_or(0);
            let shown = (0..count.min(MOST)).filter_map(|index| value.element(index));
            let shown: Vec<_> = shown.map(|it| brief(&it)).collect();
            let more = if count > MOST {
                format!(", … {count} in all")
            } else {
                String::new()
            };
            format!("[{}{more}]", shown.join(", "))
        }
        Datum::Record(fields) => {
            let fields = fields.iter();
            let shown: Vec<_> = fields
                .map(|(name, it)| format!("{name}: {}", brief(it)))
                .collect();
            format!("{{{}}}", shown.join(", "))
        }
        Datum::Text(text) => text.clone(),
        Datum::Null | Datum::Bool(_) | Datum::Int(_) | Datum::Float(_) => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_number_has_an_exponent() {
        for (number, text) in [(1e308, "1e308"), (-2.5e15, "-2.5e15"), (1e9, "1000000000")] {
            assert_eq!(brief(&Datum::Float(number)), text);
        }
    }

    #[test]
    fn a_long_list_is_cut() {
        let list = Datum::List(vec![Datum::Int(1); 40]);
        assert!(brief(&list).ends_with("1, … 40 in all]"));
    }
}
