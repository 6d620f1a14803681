//! What the parser would rather have seen, in families instead of forty tokens.

use crate::lexer::Keyword;
use crate::spelling::nearest;
use std::fmt;

/// The tokens that could stand here, by the names the grammar gives them.
#[derive(Clone, Debug, Default)]
pub(super) struct Expected<'a> {
    tokens: Vec<&'a str>,
}

/// What a term can begin with, numbers among it.
const TERM: &[&str] = &[
    "name", "variable", "constant", "integer", "natural", "real", "complex", "char", "text",
    "true", "false", "undef", "if", "switch", "let", "and", "or", "xor", "implies", "iff", "mod",
    "not", "+", "-", "(", "[", "{", "<", "<<", "Prod", "Seq", "Powerset", "Bag", "Map", "Rule",
    "forall", "exists", "exist",
];

/// What a domain can begin with.
const TYPE: &[&str] = &["constant", "Prod", "Seq", "Powerset", "Bag", "Map", "Rule"];

/// What can follow an operand in a longer term.
const OPERATOR: &[&str] = &[
    "implies", "iff", "or", "xor", "and", "=", "!=", "<", "<=", ">", ">=", "+", "-", "*", "/",
    "mod", "^",
];

/// The names of all kinds; operators name functions.
const NAME: &[&str] = &[
    "name",
    "constant",
    "rule name",
    "variable",
    "and",
    "or",
    "xor",
    "implies",
    "iff",
    "mod",
    "not",
];

impl<'a> Expected<'a> {
    /// What a rule can begin with, `skip` and `par` among it.
    pub(super) const RULE: &'static [&'static str] = &[
        "name",
        "variable",
        "rule name",
        "skip",
        "par",
        "seq",
        "if",
        "switch",
        "choose",
        "forall",
        "let",
        "extend",
        "while",
        "whilerec",
        "iterate",
        "local",
        "dynamic",
    ];

    /// From the parser's list, where every token is quoted.
    pub(super) fn new(tokens: &'a [String]) -> Self {
        Self {
            tokens: tokens.iter().map(|token| token.trim_matches('"')).collect(),
        }
    }

    /// Whether this token could stand here.
    pub(super) fn has(&self, token: &str) -> bool {
        self.tokens.contains(&token)
    }

    /// Whether a rule could begin here.
    pub(super) fn rule(&self) -> bool {
        self.has("skip")
    }

    /// Whether a term could begin here.
    pub(super) fn term(&self) -> bool {
        self.has("integer")
    }

    /// Whether a declaration could begin here.
    pub(super) fn item(&self) -> bool {
        self.has("anydomain")
    }

    /// Whether a term could go on here.
    pub(super) fn operator(&self) -> bool {
        self.has("implies") && !self.has("name")
    }

    fn domain(&self) -> bool {
        self.has("Powerset") && !self.term() && !self.item()
    }

    /// What is to be named here and what such a name begins with, where one kind of name is
    /// expected and nothing else.
    pub(super) fn name(&self) -> Option<(&'static str, &'static str)> {
        if self.term() || self.item() || self.rule() {
            return None;
        }
        match (
            self.has("name"),
            self.has("constant"),
            self.has("rule name"),
            self.has("variable"),
        ) {
            (_, false, true, false) => Some(("a rule", "`r_`")),
            (true, false, false, false) => Some(("a function", "a small letter")),
            (false, true, false, false) => Some(("a domain", "a capital letter")),
            (false, false, false, true) => Some(("a variable", "`$`")),
            _ => None,
        }
    }

    /// The word expected here that differs from `written` by a slip of the finger.
    pub(super) fn nearest(&self, written: &str) -> Option<&'a str> {
        let words = self
            .tokens
            .iter()
            .filter(|token| Keyword::spelled(token).is_some());
        nearest(written, words.copied())
    }
}

impl fmt::Display for Expected<'_> {
    /// "`then`", "a rule or `endpar`", "a term".
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Whatever else may stand here, these are what was meant.
        if self.has(":=") {
            return out.write_str("`:=`");
        }
        if self.item() {
            if self.has(",") {
                return out.write_str("`,` or a declaration");
            }
            let operator = if self.operator() {
                "an operator or "
            } else {
                ""
            };
            return write!(out, "{operator}a declaration");
        }
        let name = self.name().map(|(what, _)| format!("the name of {what}"));
        let any_name = self.has("name") && self.has("constant");
        let families: [(bool, &str, &[&str]); 5] = [
            (self.term(), "a term", TERM),
            (self.rule(), "a rule", Self::RULE),
            (self.domain(), "a domain", TYPE),
            (
                name.is_some() && !self.domain(),
                name.as_deref().unwrap_or_default(),
                NAME,
            ),
            (any_name && !self.term(), "a name", NAME),
        ];
        let mut left = self.tokens.clone();
        let mut found = Vec::new();
        for (_, family, members) in families.into_iter().filter(|(applies, _, _)| *applies) {
            left.retain(|token| !members.contains(token));
            found.push(family.to_owned());
        }
        left.retain(|token| !OPERATOR.contains(token));
        if left.is_empty() && found.is_empty() {
            found.push("an operator".to_owned());
        }
        let words = left.iter().map(|token| match *token {
            "variable" => "a variable".to_owned(),
            "constant" => "the name of a domain".to_owned(),
            "rule name" => "the name of a rule".to_owned(),
            "name" => "a name".to_owned(),
            "word" => "a name".to_owned(),
            "path" => "the path of a file".to_owned(),
            word => format!("`{word}`"),
        });
        let mut all: Vec<String> = words.chain(found).collect();
        all.dedup();
        match all.split_last() {
            Some((last, [])) => out.write_str(last),
            Some((last, others)) => write!(out, "{} or {last}", others.join(", ")),
            None => out.write_str("something else"),
        }
    }
}
