//! Conditions on messages: `jointStatus.new`, `jointStatus.error_flags != 0`.

use std::str::FromStr;

use asmotion_datum::{Datum, Schema, Shape};

/// Something that holds of a message that came through a port, or does not.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// The port.
    pub port: String,
    /// The part of its messages: `error_flags`. Of a run of elements, one is enough.
    pub path: String,
    test: Test,
}

#[derive(Clone, Debug, PartialEq)]
enum Test {
    /// Every message will do.
    New,
    /// The part compares so with a constant.
    Compare(Relation, Datum),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Equal,
    Unequal,
    Less,
    AtMost,
    Greater,
    AtLeast,
}

/// Longer signs first, so that `<=` is not read as `<`.
const RELATIONS: [(&str, Relation); 6] = [
    ("==", Relation::Equal),
    ("!=", Relation::Unequal),
    ("<=", Relation::AtMost),
    (">=", Relation::AtLeast),
    ("<", Relation::Less),
    (">", Relation::Greater),
];

/// Why a text is no condition.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConditionError {
    /// It does not begin with a port and a part of its messages.
    #[error("`{0}` does not begin with `port.field`")]
    NoField(String),
    /// What follows the field is no comparison.
    #[error("`{0}` is no comparison with a number, a truth value or a text in quotes")]
    NoComparison(String),
}

impl FromStr for Condition {
    type Err = ConditionError;

    /// `port.new`, `port.flag` or `port.field != 0`.
    fn from_str(text: &str) -> Result<Self, ConditionError> {
        let belongs = |letter: char| letter.is_alphanumeric() || letter == '.' || letter == '_';
        let text = text.trim();
        let end = text.find(|letter| !belongs(letter)).unwrap_or(text.len());
        let (place, rest) = text.split_at(end);
        let no_field = || ConditionError::NoField(text.to_owned());
        let (port, path) = place.split_once('.').ok_or_else(no_field)?;
        if port.is_empty() || path.split('.').any(str::is_empty) {
            return Err(no_field());
        }
        let test = match (rest.trim(), path) {
            ("", "new") => Test::New,
            ("", _) => Test::Compare(Relation::Equal, Datum::Bool(true)),
            (rest, _) => {
                comparison(rest).ok_or_else(|| ConditionError::NoComparison(rest.to_owned()))?
            }
        };
        let path = if test == Test::New { "" } else { path };
        let (port, path) = (port.to_owned(), path.to_owned());
        Ok(Self { port, path, test })
    }
}

fn comparison(text: &str) -> Option<Test> {
    let (sign, relation) = RELATIONS.iter().find(|(sign, _)| text.starts_with(sign))?;
    let constant = text[sign.len()..].trim();
    let quoted = |text: &str| Some(text.strip_prefix('"')?.strip_suffix('"')?.to_owned());
    let constant = match constant {
        "true" => Datum::Bool(true),
        "false" => Datum::Bool(false),
        text => match (text.parse::<f64>(), quoted(text)) {
            (Ok(number), _) if number.is_finite() => Datum::Float(number),
            (_, Some(text)) => Datum::Text(text),
            _ => return None,
        },
    };
    let ordered = !matches!(relation, Relation::Equal | Relation::Unequal);
    let lawful = !ordered || matches!(constant, Datum::Float(_));
    lawful.then_some(Test::Compare(*relation, constant))
}

impl Condition {
    /// Whether it can be asked of a part of this shape.
    pub fn suits(&self, part: &Schema) -> bool {
        let Test::Compare(_, constant) = &self.test else {
            return true;
        };
        match &part.shape {
            Shape::Any => true,
            Shape::Bool => matches!(constant, Datum::Bool(_)),
            Shape::Text => matches!(constant, Datum::Text(_)),
            Shape::List(element) | Shape::Array(element, _) => self.suits(element),
            Shape::Option(_) | Shape::Record(_) => false,
            Shape::I8
            | Shape::I16
            | Shape::I32
            | Shape::I64
            | Shape::U8
            | Shape::U16
            | Shape::U32
            | Shape::U64
            | Shape::F32
            | Shape::F64 => matches!(constant, Datum::Float(_)),
        }
    }

    /// Whether it holds of a message.
    pub fn holds(&self, message: &Datum) -> bool {
        match &self.test {
            Test::New => true,
            Test::Compare(relation, constant) => (message.get(&self.path))
                .is_some_and(|part| any(&part, &|value| compare(*relation, value, constant))),
        }
    }
}

/// Whether a value, or an element of it, passes.
fn any(value: &Datum, passes: &dyn Fn(&Datum) -> bool) -> bool {
    match value {
        Datum::List(_) | Datum::Numbers(_) | Datum::Bytes(_) => (0..value.count().unwrap_or(0))
            .any(|index| {
                value
                    .element(index)
                    .is_some_and(|element| any(&element, passes))
            }),
        Datum::Null
        | Datum::Bool(_)
        | Datum::Int(_)
        | Datum::Float(_)
        | Datum::Text(_)
        | Datum::Record(_) => passes(value),
    }
}

fn compare(relation: Relation, value: &Datum, constant: &Datum) -> bool {
    let (Some(left), Some(right)) = (value.as_float(), constant.as_float()) else {
        return match relation {
            Relation::Equal => value == constant,
            Relation::Unequal => value != constant,
            Relation::Less | Relation::AtMost | Relation::Greater | Relation::AtLeast => false,
        };
    };
    match relation {
        Relation::Equal => left == right,
        Relation::Unequal => left != right,
        Relation::Less => left < right,
        Relation::AtMost => left <= right,
        Relation::Greater => left > right,
        Relation::AtLeast => left >= right,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn holds(condition: &str, message: &Datum) -> bool {
        condition.parse::<Condition>().unwrap().holds(message)
    }

    #[test]
    fn it_holds_if_one_element_does() {
        let flags = |flags: &[i64]| {
            let flags = flags.iter().copied().map(Datum::Int).collect();
            Datum::record([("flags", Datum::List(flags))])
        };
        assert!(!holds("status.flags != 0", &flags(&[0, 0])));
        assert!(holds("status.flags != 0", &flags(&[0, 4])));
        assert!(holds("status.flags >= 4", &flags(&[0, 4])));
        assert!(!holds("status.flags > 4", &flags(&[0, 4])));
        assert!(!holds("status.other != 0", &flags(&[1])));
        assert!(holds("status.new", &flags(&[])));
    }

    #[test]
    fn it_compares_truth_and_text() {
        let message = Datum::record([("lost", Datum::Bool(true)), ("word", Datum::text("OPEN"))]);
        assert!(holds("status.lost", &message));
        assert!(!holds("status.lost == false", &message));
        assert!(holds("status.word == \"OPEN\"", &message));
        assert!(!holds("status.word != \"OPEN\"", &message));
    }

    #[test]
    fn it_refuses_what_is_no_condition() {
        for text in [
            "",
            "status",
            "status.",
            ".flags",
            "status.flags !=",
            "status.flags = 0",
            "status.flags < true",
            "status.flags != NaN",
            "status.flags != 0 or more",
        ] {
            assert!(text.parse::<Condition>().is_err(), "{text}");
        }
    }
}
