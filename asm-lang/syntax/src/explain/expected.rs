//! The tokens that the parser accepts, grouped for messages.

use crate::lexer::Keyword;
use crate::spelling::nearest;
use std::fmt;

/// The accepted tokens, by their names in the grammar.
#[derive(Clone, Debug, Default)]
pub(super) struct Expected<'a> {
    tokens: Vec<&'a str>,
}

/// Tokens that can begin a term.
const TERM: &[&str] = &[
    "name", "variable", "constant", "integer", "natural", "real", "complex", "char", "text",
    "true", "false", "undef", "if", "switch", "let", "and", "or", "xor", "implies", "iff", "mod",
    "not", "+", "-", "(", "[", "{", "<", "<<", "Prod", "Seq", "Powerset", "Bag", "Map", "Rule",
    "forall", "exists", "exist",
];

/// Tokens that can begin a domain.
const TYPE: &[&str] = &["constant", "Prod", "Seq", "Powerset", "Bag", "Map", "Rule"];

/// Tokens that can continue a term after an operand.
const OPERATOR: &[&str] = &[
    "implies", "iff", "or", "xor", "and", "=", "!=", "<", "<=", ">", ">=", "+", "-", "*", "/",
    "mod", "^",
];

/// Tokens that can be names; operators are names of functions.
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
    /// Tokens that can begin a rule.
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

    /// Creates the set from the parser's list, in which tokens are quoted.
    pub(super) fn new(tokens: &'a [String]) -> Self {
        Self {
            tokens: tokens.iter().map(|token| token.trim_matches('"')).collect(),
        }
    }

    /// Returns `true` if this token is accepted.
    pub(super) fn has(&self, token: &str) -> bool {
        self.tokens.contains(&token)
    }

    /// Returns `true` if a rule is accepted.
    pub(super) fn rule(&self) -> bool {
        self.has("skip")
    }

    /// Returns `true` if a term is accepted.
    pub(super) fn term(&self) -> bool {
        self.has("integer")
    }

    /// Returns `true` if a declaration is accepted.
    pub(super) fn item(&self) -> bool {
        self.has("anydomain")
    }

    /// Returns `true` if an operator is accepted after an operand.
    pub(super) fn operator(&self) -> bool {
        self.has("implies") && !self.has("name")
    }

    fn domain(&self) -> bool {
        self.has("Powerset") && !self.term() && !self.item()
    }

    /// Returns what is to be named and how such a name begins, if exactly one kind of name is
    /// accepted and nothing else.
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
            (true, false, false, false) => Some(("a function", "a lower-case letter")),
            (false, true, false, false) => Some(("a domain", "an upper-case letter")),
            (false, false, false, true) => Some(("a variable", "`$`")),
            _ => None,
        }
    }

    /// Returns the accepted keyword that `written` is probably a misspelling of.
    pub(super) fn nearest(&self, written: &str) -> Option<&'a str> {
        let words = self
            .tokens
            .iter()
            .filter(|token| Keyword::spelled(token).is_some());
        nearest(written, words.copied())
    }
}

impl fmt::Display for Expected<'_> {
    /// Describes the tokens: "`then`", "a rule or `endpar`", "a term".
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        // the most specific expectations come first, even if other tokens are accepted as well
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
