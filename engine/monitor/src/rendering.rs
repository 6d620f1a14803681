//! JSON for the page: compact where messages are large.
//!
//! A long list of integers, such as an occupancy grid, is written as `{"rle":[value,count,…]}`; a single-precision number has
//! the digits of its own precision. Numbers that JSON lacks are the strings `"NaN"`, `"Infinity"` and `"-Infinity"`.

use std::fmt::{Display, Write};

use asmotion_datum::{Datum, Numbers};

/// Number of elements from which a list of integers is written by runs.
const LONG: usize = 1024;

/// Writes a datum as JSON.
pub(crate) fn json(datum: &Datum) -> String {
    let mut text = String::new();
    write(datum, &mut text);
    text
}

/// Writes a text as JSON.
pub(crate) fn quoted(text: &str) -> String {
    let mut quoted = String::new();
    quote(text, &mut quoted);
    quoted
}

fn quote(text: &str, to: &mut String) {
    let is_escaped = |byte: u8| byte < b' ' || byte == b'"' || byte == b'\\';
    if text.bytes().any(is_escaped) {
        to.push_str(&serde_json::Value::from(text).to_string());
    } else {
        to.push('"');
        to.push_str(text);
        to.push('"');
    }
}

fn write(datum: &Datum, to: &mut String) {
    match datum {
        Datum::Null => to.push_str("null"),
        Datum::Bool(value) => show(value, to),
        Datum::Int(value) => show(value, to),
        Datum::Float(value) => number(*value, to),
        Datum::Text(text) => quote(text, to),
        Datum::Bytes(bytes) => integers(bytes, to),
        Datum::Numbers(numbers) => packed(numbers, to),
        Datum::List(elements) => list(elements, write, to),
        Datum::Record(entries) => {
            to.push('{');
            for (index, (name, value)) in entries.iter().enumerate() {
                if index > 0 {
                    to.push(',');
                }
                quote(name, to);
                to.push(':');
                write(value, to);
            }
            to.push('}');
        }
    }
}

fn packed(numbers: &Numbers, to: &mut String) {
    match numbers {
        Numbers::I8(all) => integers(all, to),
        Numbers::I16(all) => integers(all, to),
        Numbers::U16(all) => integers(all, to),
        Numbers::I32(all) => integers(all, to),
        Numbers::U32(all) => integers(all, to),
        Numbers::I64(all) => integers(all, to),
        Numbers::F32(all) => list(all, |value, to| number(*value, to), to),
        Numbers::F64(all) => list(all, |value, to| number(*value, to), to),
    }
}

fn integers<T: Display + PartialEq>(all: &[T], to: &mut String) {
    if all.len() < LONG {
        return list(all, |value, to| show(value, to), to);
    }
    to.push_str("{\"rle\":");
    let runs: Vec<&[T]> = all.chunk_by(|one, other| one == other).collect();
    let run = |run: &&[T], to: &mut String| {
        // writing to a string does not fail
        let _ = write!(to, "{},{}", run[0], run.len());
    };
    list(&runs, run, to);
    to.push('}');
}

fn list<T>(all: &[T], mut element: impl FnMut(&T, &mut String), to: &mut String) {
    to.push('[');
    for (index, one) in all.iter().enumerate() {
        if index > 0 {
            to.push(',');
        }
        element(one, to);
    }
    to.push(']');
}

fn number(value: impl zmij::Float, to: &mut String) {
    let mut buffer = zmij::Buffer::new();
    match buffer.format(value) {
        "inf" => to.push_str("\"Infinity\""),
        "-inf" => to.push_str("\"-Infinity\""),
        "NaN" => to.push_str("\"NaN\""),
        number => to.push_str(number.strip_suffix(".0").unwrap_or(number)),
    }
}

fn show(value: &impl Display, to: &mut String) {
    // writing to a string does not fail
    let _ = write!(to, "{value}");
}

#[cfg(test)]
mod tests {
    use super::json;
    use asmotion_datum::{Datum, Numbers};

    #[test]
    fn a_grid_is_written_by_runs_and_a_scan_with_its_own_precision() {
        let mut cells = vec![0_i8; 2000];
        cells[1999] = 100;
        let grid = Datum::Numbers(Numbers::I8(cells.into()));
        assert_eq!(json(&grid), r#"{"rle":[0,1999,100,1]}"#);
        let scan = Datum::Numbers(Numbers::F32([0.1, f32::INFINITY, f32::NAN].into()));
        assert_eq!(json(&scan), r#"[0.1,"Infinity","NaN"]"#);
        let short = Datum::Numbers(Numbers::I8([1, 1, -1].into()));
        assert_eq!(json(&short), "[1,1,-1]");
    }

    #[test]
    fn texts_are_escaped() {
        let datum = Datum::record([(
            "</script>\"",
            Datum::List(vec![Datum::text("a\n"), Datum::Null]),
        )]);
        assert_eq!(json(&datum), r#"{"</script>\"":["a\n",null]}"#);
    }
}
