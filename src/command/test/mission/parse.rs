//! The notation of conditions: `Coordinator.mode = FOLLOWING and speed(World.truth) < 0.1`.
//!
//! ```text
//! condition  = conjunction { "or" conjunction }
//! conjunction = negation { "and" negation }
//! negation   = "not" negation | "(" condition ")" | comparison
//! comparison = operand [ ("=" | "!=" | "<" | "<=" | ">" | ">=") literal ]
//! operand    = name | name "(" arguments ")" | "speed" "(" name ")" | "state" "(" name ")"
//!            | "violations" "(" name ")" | "distance" "(" place "," place ")"
//! place      = name | "[" number "," number "]"
//! ```

use asmotion_composite::At;
use asmotion_diagnostics::Span;

use super::condition::{ConditionResult, ObservedValue, Relation, RunCondition};
use super::operand::WrittenPlace;
use super::resolve::PlanNames;
use crate::codes::v032::InvalidRunCondition;

/// Depth of parentheses and negations beyond which a condition is refused.
const DEEPEST: usize = 64;

/// Reads a condition.
///
/// # Errors
/// The condition is malformed, or names something that the plan does not have.
pub(super) fn condition(
    text: &At<String>,
    names: &mut PlanNames<'_>,
) -> Result<RunCondition, Box<InvalidRunCondition>> {
    let mut parser = ConditionParser {
        text: &text.value,
        span: text.span,
        at: 0,
        depth: 0,
        names,
    };
    let condition = parser.disjunction()?;
    parser.skip_blanks();
    if parser.at < text.value.len() {
        return Err(parser.unexpected("`and`, `or` or the end of the condition"));
    }
    Ok(condition)
}

struct ConditionParser<'c, 'p> {
    text: &'c str,
    /// Location of the text in the mission.
    span: Span,
    /// Position in the text.
    at: usize,
    depth: usize,
    names: &'c mut PlanNames<'p>,
}

impl ConditionParser<'_, '_> {
    fn disjunction(&mut self) -> ConditionResult<RunCondition> {
        let mut condition = self.conjunction()?;
        while self.word("or") {
            let right = self.conjunction()?;
            condition = RunCondition::Or(Box::new(condition), Box::new(right));
        }
        Ok(condition)
    }

    fn conjunction(&mut self) -> ConditionResult<RunCondition> {
        let mut condition = self.negation()?;
        while self.word("and") {
            let right = self.negation()?;
            condition = RunCondition::And(Box::new(condition), Box::new(right));
        }
        Ok(condition)
    }

    fn negation(&mut self) -> ConditionResult<RunCondition> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.invalid("the condition is nested too deep", self.here()));
        }
        let condition = if self.word("not") {
            RunCondition::Not(Box::new(self.negation()?))
        } else if self.sign("(") {
            let inner = self.disjunction()?;
            self.expect(")")?;
            inner
        } else {
            self.comparison()?
        };
        self.depth -= 1;
        Ok(condition)
    }

    fn comparison(&mut self) -> ConditionResult<RunCondition> {
        let from = self.start();
        let operand = self.operand()?;
        let written = self.part(from, self.at);
        let Some(relation) = self.relation() else {
            // a Boolean alone
            let with = ObservedValue::Truth(true);
            self.names
                .check(operand, Relation::Equal, &with, &written)?;
            let relation = Relation::Equal;
            return Ok(RunCondition::Compare {
                operand,
                relation,
                with,
            });
        };
        let literal = self.literal()?;
        let with = literal.value;
        let compared = At::new(written.value, literal.span);
        self.names.check(operand, relation, &with, &compared)?;
        Ok(RunCondition::Compare {
            operand,
            relation,
            with,
        })
    }

    fn operand(&mut self) -> ConditionResult<usize> {
        let name = self.name("a location, a port or a topic")?;
        match name.value.as_str() {
            "speed" if self.sign("(") => {
                let of = self.name("a port or a topic")?;
                self.expect(")")?;
                self.names.speed(&of)
            }
            "state" if self.sign("(") => {
                let of = self.name("a component")?;
                self.expect(")")?;
                self.names.state(&of)
            }
            "violations" if self.sign("(") => {
                let of = self.name("a component")?;
                self.expect(")")?;
                self.names.violations(&of)
            }
            "distance" if self.sign("(") => {
                let from = self.place()?;
                self.expect(",")?;
                let to = self.place()?;
                self.expect(")")?;
                self.names.distance(from, to)
            }
            _ if self.text[self.at..].starts_with('(') => {
                let Some(length) = self.text[self.at..].find(')') else {
                    return Err(self.unexpected("`)`"));
                };
                let arguments = self.part(self.at, self.at + length + 1);
                self.at += length + 1;
                let location = format!("{}{}", name.value, arguments.value);
                let span = name.span.to(arguments.span);
                self.names.name(&At::new(location, span))
            }
            _ => self.names.name(&name),
        }
    }

    fn place(&mut self) -> ConditionResult<WrittenPlace> {
        if !self.sign("[") {
            let name = self.name("a port, a topic or `[x, y]`")?;
            return Ok(WrittenPlace::Moving(name));
        }
        let x = self.number()?;
        self.expect(",")?;
        let y = self.number()?;
        self.expect("]")?;
        Ok(WrittenPlace::Fixed([x, y]))
    }

    fn number(&mut self) -> ConditionResult<f64> {
        let literal = self.literal()?;
        match literal.value {
            ObservedValue::Number(number) => Ok(number),
            ObservedValue::Truth(_) | ObservedValue::Text(_) => {
                Err(self.invalid("expected a number", literal.span))
            }
        }
    }

    fn relation(&mut self) -> Option<Relation> {
        let signs = [
            ("!=", Relation::NotEqual),
            ("<=", Relation::LessOrEqual),
            (">=", Relation::GreaterOrEqual),
            ("=", Relation::Equal),
            ("<", Relation::Less),
            (">", Relation::Greater),
        ];
        let found = signs.iter().find(|(sign, _)| self.sign(sign));
        found.map(|(_, relation)| *relation)
    }

    /// Reads a number, `true`, `false`, a text in quotes or a word.
    fn literal(&mut self) -> ConditionResult<At<ObservedValue>> {
        let from = self.start();
        let rest = &self.text[from..];
        if let Some(quote) = rest.chars().next().filter(|it| matches!(it, '"' | '\'')) {
            let Some(length) = rest[1..].find(quote) else {
                return Err(self.invalid("the quote is not closed", self.here()));
            };
            self.at = from + length + 2;
            let text = rest[1..=length].to_owned();
            let span = self.part(from, self.at).span;
            return Ok(At::new(ObservedValue::Text(text), span));
        }
        let part_of_it = |letter: char| letter.is_alphanumeric() || "_-+.".contains(letter);
        let length = rest.find(|letter| !part_of_it(letter));
        let length = length.unwrap_or(rest.len());
        if length == 0 {
            return Err(self.unexpected("a value"));
        }
        self.at = from + length;
        let word = self.part(from, self.at);
        Ok(At::new(ObservedValue::of_text(&word), word.span))
    }

    /// Reads a name such as `Driver/Arm.state.position.0` or `topic:a/b.data`.
    fn name(&mut self, expected: &str) -> ConditionResult<At<String>> {
        let from = self.start();
        let rest = &self.text[from..];
        let part_of_it = |letter: char| letter.is_alphanumeric() || "_-./:".contains(letter);
        let length = rest.find(|letter| !part_of_it(letter));
        let length = length.unwrap_or(rest.len());
        if length == 0 {
            return Err(self.unexpected(expected));
        }
        self.at = from + length;
        Ok(self.part(from, self.at))
    }

    /// Skips a keyword, if it is next.
    fn word(&mut self, word: &str) -> bool {
        let from = self.start();
        let Some(rest) = self.text[from..].strip_prefix(word) else {
            return false;
        };
        let goes_on =
            rest.starts_with(|next: char| next.is_alphanumeric() || "_-./:".contains(next));
        if !goes_on {
            self.at = from + word.len();
        }
        !goes_on
    }

    /// Skips a sign, if it is next.
    fn sign(&mut self, sign: &str) -> bool {
        let from = self.start();
        let found = self.text[from..].starts_with(sign);
        if found {
            self.at = from + sign.len();
        }
        found
    }

    fn expect(&mut self, sign: &str) -> ConditionResult<()> {
        if self.sign(sign) {
            return Ok(());
        }
        Err(self.unexpected(&format!("`{sign}`")))
    }

    fn skip_blanks(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    /// Position of the next sign.
    fn start(&mut self) -> usize {
        self.skip_blanks();
        self.at
    }

    /// A part of the text with its location.
    fn part(&self, from: usize, to: usize) -> At<String> {
        let start = self.span.start as usize;
        let text = self.text.get(from..to).unwrap_or_default().to_owned();
        At::new(text, Span::new(self.span.file, start + from, start + to))
    }

    /// Location of the next sign.
    fn here(&self) -> Span {
        self.part(self.at, self.at + 1).span
    }

    fn unexpected(&mut self, expected: &str) -> Box<InvalidRunCondition> {
        self.skip_blanks();
        let found = match self.text[self.at..].chars().next() {
            Some(letter) => format!("`{letter}`"),
            None => "the end of the condition".to_owned(),
        };
        self.invalid(&format!("expected {expected}, found {found}"), self.here())
    }

    fn invalid(&self, reason: &str, at: Span) -> Box<InvalidRunCondition> {
        Box::new(InvalidRunCondition {
            reason: reason.to_owned(),
            at,
            help: None,
        })
    }
}
