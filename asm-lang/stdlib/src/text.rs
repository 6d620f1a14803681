//! Strings: sequences of Unicode scalar values, indexed from 0. If an argument is `undef`, so is the
//! result, except that `contains` is false for an `undef` text.

use crate::argument::{binary, ternary, unary};
use crate::builtin::{Builtin, strict, total};
use crate::complex::Complex;
use crate::fault::{BuiltinFault, LIMIT};
use crate::integer;
use asmotion_value::Value;

/// Returns the number of characters.
pub fn size(text: &str) -> i64 {
    integer::of(text.chars().count())
}

/// Returns the concatenation of two strings.
///
/// # Errors
/// [`BuiltinFault::TooLarge`] for more than [`LIMIT`] bytes.
pub fn concat(left: &str, right: &str) -> Result<String, BuiltinFault> {
    let size = left.len().saturating_add(right.len());
    if size > LIMIT {
        return Err(BuiltinFault::TooLarge {
            function: "concat",
            size,
        });
    }
    Ok([left, right].concat())
}

/// Converts to upper case according to Unicode: `ß` becomes `SS`.
pub fn to_upper(text: &str) -> String {
    text.to_uppercase()
}

/// Converts to lower case according to Unicode.
pub fn to_lower(text: &str) -> String {
    text.to_lowercase()
}

/// Returns the characters at positions `from` to `to - 1`.
///
/// # Errors
/// [`BuiltinFault::Part`] unless `0 <= from <= to <= size`.
pub fn sub_string(text: &str, from: i64, to: i64) -> Result<String, BuiltinFault> {
    let length = text.chars().count();
    let part = || BuiltinFault::Part {
        function: "subString",
        from,
        to,
        length,
    };
    let start = usize::try_from(from).map_err(|_| part())?;
    let end = usize::try_from(to).map_err(|_| part())?;
    if start > end || end > length {
        return Err(part());
    }
    Ok(text.chars().skip(start).take(end - start).collect())
}

/// Returns `true` if `text` contains `part`.
pub fn contains(text: &str, part: &str) -> bool {
    text.contains(part)
}

/// Splits `text` at the separator, which is a plain string, not a pattern. Empty parts at the end
/// are left out. An empty separator splits between any two characters.
pub fn split(text: &str, separator: &str) -> Vec<Value> {
    if text.is_empty() {
        return vec![Value::text("")];
    }
    if separator.is_empty() {
        return text.chars().map(Value::text).collect();
    }
    let mut parts: Vec<&str> = text.split(separator).collect();
    while parts.last().is_some_and(|part| part.is_empty()) {
        parts.pop();
    }
    parts.into_iter().map(Value::text).collect()
}

/// Parses an integer; surrounding blanks are ignored.
///
/// # Errors
/// [`BuiltinFault::Unreadable`] if the text is not a 64-bit integer.
pub fn to_integer(text: &str) -> Result<i64, BuiltinFault> {
    text.trim()
        .parse()
        .map_err(|_| unreadable("toInteger", text, "an integer of 64 bits"))
}

/// Parses a natural, with or without the suffix `n` of a literal.
///
/// # Errors
/// [`BuiltinFault::Unreadable`] if the text is not a 64-bit integer, [`BuiltinFault::Negative`]
/// for a negative one.
pub fn to_natural(text: &str) -> Result<i64, BuiltinFault> {
    let digits = text.trim();
    let digits = digits.strip_suffix('n').unwrap_or(digits);
    let number = digits
        .parse()
        .map_err(|_| unreadable("toNatural", text, "a natural of 64 bits"))?;
    if number < 0 {
        return Err(BuiltinFault::Negative {
            function: "toNatural",
            number,
        });
    }
    Ok(number)
}

/// Parses a real; exponents, `Infinity` and `NaN` are accepted.
///
/// # Errors
/// [`BuiltinFault::Unreadable`] if the text is not a number.
pub fn to_real(text: &str) -> Result<f64, BuiltinFault> {
    text.trim()
        .parse()
        .map_err(|_| unreadable("toReal", text, "a real"))
}

/// Parses a complex number in the notation of literals: `1.5`, `i2.0`, `1.5-i2.0`. `i` stands for
/// `i1`.
///
/// # Errors
/// [`BuiltinFault::Unreadable`] if the text is not a complex number.
pub fn to_complex(text: &str) -> Result<Complex, BuiltinFault> {
    parse_complex(text.trim()).ok_or_else(|| unreadable("toComplex", text, "a complex number"))
}

/// Returns the first character.
///
/// # Errors
/// [`BuiltinFault::Empty`] for an empty text.
pub fn to_char(text: &str) -> Result<char, BuiltinFault> {
    text.chars()
        .next()
        .ok_or(BuiltinFault::Empty { function: "toChar" })
}

/// Parses `re`, `±i im` or both. The imaginary part starts at the only `i` that follows a sign or
/// starts the text.
fn parse_complex(text: &str) -> Option<Complex> {
    let Some((before, imaginary)) = split_imaginary(text) else {
        return Some(Complex::new(text.parse().ok()?, 0.0));
    };
    let (real, sign) = match before.strip_suffix('-') {
        Some(real) => (real, -1.0),
        None => (before.strip_suffix('+').unwrap_or(before), 1.0),
    };
    let re = if real.is_empty() {
        0.0
    } else {
        real.parse().ok()?
    };
    let size: f64 = if imaginary.is_empty() {
        1.0
    } else {
        imaginary.parse().ok()?
    };
    Some(Complex::new(re, sign * size))
}

/// Splits at the `i` of the imaginary unit, as opposed to that of `inf`.
fn split_imaginary(text: &str) -> Option<(&str, &str)> {
    let at_each = text.match_indices('i');
    at_each
        .map(|(at, unit)| (&text[..at], &text[at + unit.len()..]))
        .find(|(before, after)| {
            (before.is_empty() || before.ends_with(['+', '-'])) && !after.starts_with("nf")
        })
}

fn unreadable(function: &'static str, text: &str, expected: &'static str) -> BuiltinFault {
    BuiltinFault::Unreadable {
        function,
        text: text.into(),
        expected,
    }
}

pub(crate) const TABLE: &[Builtin] = &[
    strict("size", "String", |arguments, _| unary(arguments, size)),
    strict("plus", "Prod(String,String)", |arguments, _| {
        binary(arguments, concat)
    }),
    strict("concat", "Prod(String,String)", |arguments, _| {
        binary(arguments, concat)
    }),
    strict("toUpper", "String", |arguments, _| {
        unary(arguments, to_upper)
    }),
    strict("toLower", "String", |arguments, _| {
        unary(arguments, to_lower)
    }),
    strict(
        "subString",
        "Prod(String,Integer,Integer)",
        |arguments, _| ternary(arguments, sub_string),
    ),
    total("contains", "Prod(String,String)", |arguments, _| {
        binary(
            arguments,
            |text: Option<&str>, part: Option<&str>| match text {
                None => Some(false),
                Some(text) => part.map(|part| contains(text, part)),
            },
        )
    }),
    strict("split", "Prod(String,String)", |arguments, _| {
        binary(arguments, split)
    }),
    strict("toInteger", "String", |arguments, _| {
        unary(arguments, to_integer)
    }),
    strict("toNatural", "String", |arguments, _| {
        unary(arguments, to_natural)
    }),
    strict("toReal", "String", |arguments, _| unary(arguments, to_real)),
    strict("toComplex", "String", |arguments, _| {
        unary(arguments, to_complex)
    }),
    strict("toChar", "String", |arguments, _| unary(arguments, to_char)),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::*;
    use asmotion_value::ValueNames;
    use proptest::prelude::*;

    #[test]
    fn parts() {
        check("size", "String", &[text("äbc")], "3");
        check("size", "String", &[text("")], "0");
        check(
            "plus",
            "Prod(String,String)",
            &[text("a"), text("b")],
            r#""ab""#,
        );
        check(
            "concat",
            "Prod(String,String)",
            &[text("a"), text("")],
            r#""a""#,
        );
        check(
            "concat",
            "Prod(String,String)",
            &[text("a"), UNDEF],
            "undef",
        );
        check("toUpper", "String", &[text("straße")], r#""STRASSE""#);
        check("toLower", "String", &[text("ÄB")], r#""äb""#);
        check(
            "contains",
            "Prod(String,String)",
            &[text("abc"), text("bc")],
            "true",
        );
        check(
            "contains",
            "Prod(String,String)",
            &[text("abc"), text("")],
            "true",
        );
        check(
            "contains",
            "Prod(String,String)",
            &[text("abc"), text("ac")],
            "false",
        );
        for (arguments, expected) in [
            ([UNDEF, text("a")], "false"),
            ([UNDEF, UNDEF], "false"),
            ([text("a"), UNDEF], "undef"),
        ] {
            check("contains", "Prod(String,String)", &arguments, expected);
        }
        let part = |from, to, expected| {
            let arguments = [text("äbcd"), int(from), int(to)];
            check(
                "subString",
                "Prod(String,Integer,Integer)",
                &arguments,
                expected,
            );
        };
        part(0, 2, r#""äb""#);
        part(4, 4, r#""""#);
        part(2, 5, "range 2 to 5 of `subString` is outside a length of 4");
        part(
            -1,
            2,
            "range -1 to 2 of `subString` is outside a length of 4",
        );
        part(3, 2, "range 3 to 2 of `subString` is outside a length of 4");
    }

    #[test]
    fn splitting_takes_the_separator_literally() {
        let parts = |whole, separator, expected| {
            check(
                "split",
                "Prod(String,String)",
                &[text(whole), text(separator)],
                expected,
            );
        };
        parts("a,b,c", ",", r#"["a", "b", "c"]"#);
        parts("a.b", ".", r#"["a", "b"]"#);
        parts("abc", ",", r#"["abc"]"#);
        parts(",a,,b,,", ",", r#"["", "a", "", "b"]"#);
        parts(",", ",", "[]");
        parts("", ",", r#"[""]"#);
        parts("äb", "", r#"["ä", "b"]"#);
    }

    #[test]
    fn numbers_are_read() {
        let read = |name, written, expected| check(name, "String", &[text(written)], expected);
        read("toInteger", "12", "12");
        read("toInteger", " -12 ", "-12");
        read(
            "toInteger",
            "x",
            r#"`toInteger` cannot parse "x" as an integer of 64 bits"#,
        );
        read(
            "toInteger",
            "9223372036854775808",
            r#"`toInteger` cannot parse "9223372036854775808" as an integer of 64 bits"#,
        );
        read("toNatural", "12", "12");
        read("toNatural", "12n", "12");
        read(
            "toNatural",
            "-1",
            "expected a Natural for `toNatural`, found -1",
        );
        read(
            "toNatural",
            "",
            r#"`toNatural` cannot parse "" as a natural of 64 bits"#,
        );
        read("toReal", "1.5", "1.5");
        read("toReal", "1e3", "1000.0");
        read("toReal", "Infinity", "inf");
        read("toReal", "one", r#"`toReal` cannot parse "one" as a real"#);
        read("toComplex", "1.5", "1.5+i0.0");
        read("toComplex", "1.5-i2.0", "1.5-i2.0");
        read("toComplex", "-i", "0.0-i1.0");
        read("toComplex", "i2", "0.0+i2.0");
        read("toComplex", "-inf+iinf", "-inf+iinf");
        read(
            "toComplex",
            "2i",
            r#"`toComplex` cannot parse "2i" as a complex number"#,
        );
        read(
            "toComplex",
            "i2i3",
            r#"`toComplex` cannot parse "i2i3" as a complex number"#,
        );
        read("toChar", "äb", "'ä'");
        read("toChar", "", "`toChar` of an empty argument");
    }

    #[test]
    fn a_text_cannot_fill_the_memory() {
        let half = Value::text("x".repeat(LIMIT / 2 + 1));
        check(
            "concat",
            "Prod(String,String)",
            &[half.clone(), half],
            "`concat` would create 16777218 elements, more than 16777216",
        );
    }

    struct Nameless;
    impl ValueNames for Nameless {
        fn atom(
            &self,
            _: asmotion_value::Atom,
            _: &mut std::fmt::Formatter<'_>,
        ) -> std::fmt::Result {
            Ok(())
        }
        fn rule(
            &self,
            _: asmotion_value::RuleId,
            _: &mut std::fmt::Formatter<'_>,
        ) -> std::fmt::Result {
            Ok(())
        }
    }

    proptest! {
        #[test]
        fn numbers_survive_their_text(integer: i64, re: f64, im: f64) {
            let shown = |value: Value| crate::to_string::to_string(&value, &Nameless);
            prop_assert_eq!(to_integer(&shown(Value::Int(integer))), Ok(integer));
            prop_assert_eq!(to_real(&shown(Value::real(re))).map(Value::real), Ok(Value::real(re)));
            let complex = Complex::new(re, im).value();
            prop_assert_eq!(to_complex(&shown(complex.clone())).map(Complex::value), Ok(complex));
        }

        #[test]
        fn what_was_split_joins_again(parts in prop::collection::vec("[a-zä]+", 1..6)) {
            let texts: Vec<Value> = parts.iter().map(Value::text).collect();
            prop_assert_eq!(split(&parts.join("--"), "--"), texts);
        }
    }
}
