//! Conditions on messages: `jointStatus.new`, `jointStatus.error_flags != 0`.

use std::str::FromStr;

use asmotion_datum::{Datum, Schema, Shape};

/// A condition on the messages of a port.
#[derive(Clone, Debug, PartialEq)]
pub struct MessageCondition {
    /// Name of the port.
    pub port: String,
    /// Path of the tested part, for example `error_flags`; empty for `new`. If the part is a list, one element that
    /// satisfies the test suffices.
    pub path: String,
    test: ConditionTest,
}

#[derive(Clone, Debug, PartialEq)]
enum ConditionTest {
    /// True of every message.
    New,
    /// Compares the part with a constant.
    Compare(ConditionRelation, Datum),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ConditionRelation {
    Equal,
    Unequal,
    Less,
    AtMost,
    Greater,
    AtLeast,
}

/// Longer operators first, so that `<=` is not read as `<`.
const RELATIONS: [(&str, ConditionRelation); 6] = [
    ("==", ConditionRelation::Equal),
    ("!=", ConditionRelation::Unequal),
    ("<=", ConditionRelation::AtMost),
    (">=", ConditionRelation::AtLeast),
    ("<", ConditionRelation::Less),
    (">", ConditionRelation::Greater),
];

/// The reason that a text is not a condition.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConditionError {
    /// The text does not begin with a port and a part of its messages.
    #[error("`{0}` does not start with `port.field`")]
    InvalidField(String),
    /// The text after the field is not a comparison.
    #[error("`{0}` is not a comparison with a number, a Boolean or a quoted string")]
    InvalidComparison(String),
}

impl FromStr for MessageCondition {
    type Err = ConditionError;

    /// Parses `port.new`, `port.flag` or `port.field != 0`.
    fn from_str(text: &str) -> Result<Self, ConditionError> {
        let belongs = |letter: char| letter.is_alphanumeric() || letter == '.' || letter == '_';
        let text = text.trim();
        let end = text.find(|letter| !belongs(letter)).unwrap_or(text.len());
        let (place, rest) = text.split_at(end);
        let no_field = || ConditionError::InvalidField(text.to_owned());
        let (port, path) = place.split_once('.').ok_or_else(no_field)?;
        if port.is_empty() || path.split('.').any(str::is_empty) {
            return Err(no_field());
        }
        let test = match (rest.trim(), path) {
            ("", "new") => ConditionTest::New,
            ("", _) => ConditionTest::Compare(ConditionRelation::Equal, Datum::Bool(true)),
            (rest, _) => comparison(rest)
                .ok_or_else(|| ConditionError::InvalidComparison(rest.to_owned()))?,
        };
        let path = if test == ConditionTest::New { "" } else { path };
        let (port, path) = (port.to_owned(), path.to_owned());
        Ok(Self { port, path, test })
    }
}

fn comparison(text: &str) -> Option<ConditionTest> {
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
    let ordered = !matches!(
        relation,
        ConditionRelation::Equal | ConditionRelation::Unequal
    );
    let is_comparable = !ordered || matches!(constant, Datum::Float(_));
    is_comparable.then_some(ConditionTest::Compare(*relation, constant))
}

impl MessageCondition {
    /// Returns whether the condition can be applied to a part of this schema.
    pub fn applies_to(&self, part: &Schema) -> bool {
        let ConditionTest::Compare(_, constant) = &self.test else {
            return true;
        };
        let shape = &part.shape;
        if let Shape::List(element) | Shape::Array(element, _) = shape {
            return self.applies_to(element);
        }
        let (is_bool, is_text) = (*shape == Shape::Bool, *shape == Shape::Text);
        *shape == Shape::Any
            || (is_bool && matches!(constant, Datum::Bool(_)))
            || (is_text && matches!(constant, Datum::Text(_)))
            || (shape.is_number() && matches!(constant, Datum::Float(_)))
    }

    /// Returns whether the condition holds for a message.
    pub fn is_met_by(&self, message: &Datum) -> bool {
        match &self.test {
            ConditionTest::New => true,
            ConditionTest::Compare(relation, constant) => message
                .get(&self.path)
                .is_some_and(|part| any(&part, &|value| compare(*relation, value, constant))),
        }
    }
}

/// Returns whether a value or one of its elements satisfies the test.
fn any(value: &Datum, predicate: &dyn Fn(&Datum) -> bool) -> bool {
    match value {
        Datum::List(_) | Datum::Numbers(_) | Datum::Bytes(_) => (0..value.count().unwrap_or(0))
            .any(|index| {
                value
                    .element(index)
                    .is_some_and(|element| any(&element, predicate))
            }),
        Datum::Null
        | Datum::Bool(_)
        | Datum::Int(_)
        | Datum::Float(_)
        | Datum::Text(_)
        | Datum::Record(_) => predicate(value),
    }
}

fn compare(relation: ConditionRelation, value: &Datum, constant: &Datum) -> bool {
    let (Some(left), Some(right)) = (value.as_float(), constant.as_float()) else {
        return match relation {
            ConditionRelation::Equal => value == constant,
            ConditionRelation::Unequal => value != constant,
            ConditionRelation::Less
            | ConditionRelation::AtMost
            | ConditionRelation::Greater
            | ConditionRelation::AtLeast => false,
        };
    };
    match relation {
        ConditionRelation::Equal => left == right,
        ConditionRelation::Unequal => left != right,
        ConditionRelation::Less => left < right,
        ConditionRelation::AtMost => left <= right,
        ConditionRelation::Greater => left > right,
        ConditionRelation::AtLeast => left >= right,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holds(condition: &str, message: &Datum) -> bool {
        condition
            .parse::<MessageCondition>()
            .unwrap()
            .is_met_by(message)
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
    fn each_relation_holds_on_its_side_of_the_constant() {
        for (condition, expected) in [
            ("p.n < 2", [true, false, false]),
            ("p.n <= 2", [true, true, false]),
            ("p.n == 2", [false, true, false]),
            ("p.n != 2", [true, false, true]),
            ("p.n >= 2", [false, true, true]),
            ("p.n > 2", [false, false, true]),
        ] {
            let message = |n| Datum::record([("n", Datum::Float(n))]);
            let held = [1.0, 2.0, 3.0].map(|n| holds(condition, &message(n)));
            assert_eq!(held, expected, "{condition} of 1, 2, 3");
        }
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
            assert!(text.parse::<MessageCondition>().is_err(), "{text}");
        }
    }
}
