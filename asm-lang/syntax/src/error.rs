//! What can be wrong with a text: the facts, then the words.

use crate::lexer::Keyword;
use asmotion_diagnostics::{Applicability, Diagnostic, Edit, Fix, Span};
use thiserror::Error;

/// A word or a sign of the text and where it stands.
pub(crate) type Place = (String, Span);

/// Everything the lexer and the parser have to say. The codes are stable: a new fact takes a new
/// number at the end of its group.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(crate) enum SyntaxError {
    // ── tokens ──
    #[error("`{characters}` is not part of the language")]
    UnknownCharacters { characters: String, at: Span },

    #[error("`{word}` has letters a name cannot have")]
    ForeignLetters { word: String, at: Span },

    #[error("this comment has no end")]
    OpenComment { open: Span },

    #[error("the closing `{quote}` is missing")]
    OpenQuote { quote: char, open: Span },

    #[error("a character stands between the quotes, neither none nor several")]
    CharLength { text: String, at: Span },

    #[error("`{digits}` does not fit into 64 bits")]
    TooLarge { digits: String, at: Span },

    #[error("numbers have no exponent")]
    Exponent { number: String, at: Span },

    #[error("digits are missing after the point")]
    BarePoint { number: String, at: Span },

    #[error("`{found}` is written `{meant}`")]
    Foreign {
        found: String,
        meant: &'static str,
        text: String,
        at: Span,
    },

    #[error("`;` separates nothing")]
    Semicolon { at: Span },

    #[error("`{word}` names an element of a run, which a specification cannot do")]
    ElementName { word: String, at: Span },

    // ── files ──
    #[error("the file is empty: it begins with `asm` and a name")]
    Empty { at: Span },

    #[error("the file does not begin with `asm` or `module` and a name")]
    NoHeading { at: Span },

    #[error("the file is named a second time")]
    SecondHeading { at: Span, first: Span },

    #[error("`export` stands twice")]
    SecondExport { at: Span, first: Span },

    #[error("there are two main rules")]
    SecondMain { at: Span, first: Span },

    #[error("`agent` stands outside an initial state")]
    AgentOutsideInit { at: Span },

    // ── structure ──
    #[error("the file ends before {missing}")]
    CutOff {
        missing: String,
        at: Span,
        open: Vec<Place>,
    },

    #[error("`{missing}` is missing: this `{}` is still open", open.0)]
    Unclosed {
        missing: String,
        at: Span,
        open: Place,
        misaligned: Option<(Place, Place)>,
    },

    #[error("`else if` needs one `endif` for each `if`")]
    ElseIf { at: Span, outer: Span, inner: Span },

    #[error("`{}` closes nothing", found.0)]
    ClosesNothing { found: Place },

    #[error("several rules stand where one belongs")]
    SeveralRules {
        first: Span,
        second: Span,
        all: Option<(Span, String)>,
    },

    #[error("a rule is missing before `{}`", found.0)]
    NoRule { found: Place, after: Option<Place> },

    #[error("rules stand without brackets")]
    BracketedRule { at: Span },

    #[error("`{}` is called without brackets", call.0)]
    CallWithoutBrackets { call: Place },

    #[error("`{word}` stands in brackets of its own")]
    BareQuantifier { word: &'static str, at: Span },

    #[error("nested too deep")]
    TooDeep { at: Span },

    #[error("`,` does not separate rules")]
    CommaBetweenRules { at: Span },

    #[error("the arguments of a function stand in round brackets")]
    SquareArguments { at: Span },

    // ── words ──
    #[error("`=` compares; an update is written `:=`")]
    EqualsForUpdate { at: Span },

    #[error("`:=` updates; a comparison is written `=`")]
    UpdateForEquals { at: Span },

    #[error("expected `{word}` after {after}")]
    MissingWord {
        word: &'static str,
        after: String,
        at: Span,
        opener: Option<Place>,
    },

    #[error("unknown word `{}`", found.0)]
    UnknownWord { found: Place, meant: String },

    #[error("`{}` is a reserved word and cannot name {what}", found.0)]
    ReservedName { found: Place, what: &'static str },

    #[error("`{}` is a complex number and cannot name {what}", found.0)]
    ComplexName { found: Place, what: &'static str },

    #[error("the name of {what} begins with {beginning}")]
    Misnamed {
        what: &'static str,
        beginning: &'static str,
        found: Place,
        better: Option<String>,
    },

    #[error("`{}` is reserved and means nothing", found.0)]
    Unused { found: Place },

    #[error("expected {what}, found `{}`", found.0)]
    Expected {
        what: String,
        found: Place,
        after: Option<Place>,
        open: Option<Place>,
    },

    #[error("a product of domains is written `Prod(A, B)`")]
    ProductSign { at: Span },

    #[error("`in` is no operator")]
    InfixMembership { at: Span },

    #[error("`<-` takes the result of a rule, `r_x(…)`")]
    ReturnOfNoRule { at: Span },

    #[error("too many errors: the rest of the file was not read")]
    TooMany { at: Span },

    // ── warnings ──
    #[error("`exist` is now written `exists`")]
    OldExists { at: Span },

    #[error("`..` is now written `:`")]
    OldInterval {
        at: Span,
        /// With the blanks that it needs.
        new: &'static str,
    },

    #[error("`{block}` with {count}")]
    FewRules {
        block: &'static str,
        count: &'static str,
        at: Span,
        /// How the text reads without the block; empty where that is hard to say.
        without: Vec<Edit>,
    },

    #[error("{what} after {before}")]
    OutOfOrder {
        what: &'static str,
        before: &'static str,
        at: Span,
        earlier: Span,
        /// How it is put into its place; empty where that is hard to say.
        moved: Vec<Edit>,
    },

    #[error("`{rule}` is called before it is declared")]
    CalledEarly {
        rule: String,
        at: Span,
        declared: Span,
        /// How it is declared first.
        moved: Vec<Edit>,
    },

    #[error("`{section}:` is missing before {what}")]
    NoSection {
        section: &'static str,
        what: &'static str,
        at: Span,
        /// How the heading is written there.
        written: Edit,
    },

    #[error("`{name}` does not begin with `{prefix}`")]
    PropertyPrefix {
        prefix: &'static str,
        name: String,
        at: Span,
    },
}

impl SyntaxError {
    /// The code of what a file needs to be told only once.
    pub(crate) fn once(&self) -> Option<&'static str> {
        match self {
            Self::Semicolon { .. } => Some("L010"),
            Self::TooDeep { .. } => Some("L039"),
            _ => None,
        }
    }

    /// The words for people, and the fix for tools.
    pub(crate) fn diagnostic(&self) -> Diagnostic {
        let error = |code| Diagnostic::error(code, self);
        let warning = |code| Diagnostic::warning(code, self);
        match self {
            Self::UnknownCharacters { at, .. } => error("L001").label(*at, "not understood"),
            Self::ForeignLetters { at, .. } => error("L002")
                .label(*at, "not a name")
                .help("names are written with the letters a to z, digits and `_`"),
            Self::OpenComment { open } => error("L003")
                .label(*open, "begins here and reaches to the end of the file")
                .help("close it with `*/`"),
            Self::OpenQuote { quote, open } => error("L004")
                .label(*open, "reaches to the end of the line")
                .help(format!(
                    "close it with `{quote}`; a text cannot go on in the next line"
                )),
            Self::CharLength { text, at } => {
                let found = error("L005").label(*at, "not one character");
                if text.is_empty() {
                    found
                } else {
                    found.guess("a text stands in double quotes", *at, format!("\"{text}\""))
                }
            }
            Self::TooLarge { at, .. } => error("L006")
                .label(*at, "too large")
                .note(format!("the largest number is {}", i64::MAX)),
            Self::Exponent { number, at } => exponent(error("L007"), number, *at),
            Self::BarePoint { number, at } => error("L008").label(*at, "not a number").fix(
                "write at least one digit",
                *at,
                format!("{number}0"),
            ),
            Self::Foreign {
                found,
                meant,
                text,
                at,
            } => {
                let foreign = error("L009").label(*at, "as other languages write it");
                let foreign = match found.as_str() {
                    "=>" => foreign.help("to compare, write `>=`"),
                    _ => foreign,
                };
                foreign.fix(format!("write `{meant}`"), *at, text.clone())
            }
            Self::Semicolon { at } => error("L010")
                .label(*at, "not part of the language")
                .help("`par … endpar` and `seq … endseq` hold several rules")
                .fix("leave it out, here and elsewhere", *at, ""),
            Self::ElementName { at, .. } => error("L011")
                .label(*at, "not part of a specification")
                .help("take an element by `choose` or `forall`, or declare it `static`"),

            Self::Empty { at } => warning("L020")
                .label(*at, "nothing to run")
                .help("the smallest file is `asm name signature: definitions:`"),
            Self::NoHeading { at } => error("L021")
                .label(*at, "begins here")
                .help("write `asm name` first, with the name of the file"),
            Self::SecondHeading { at, first } => error("L022")
                .label(*at, "named again")
                .label(*first, "named here")
                .help("a file holds one `asm` or one `module`; put the other into its own file"),
            Self::SecondExport { at, first } => error("L023")
                .label(*at, "the second one")
                .label(*first, "the first one")
                .help("name everything in one `export`, with commas between"),
            Self::SecondMain { at, first } => error("L024")
                .label(*at, "the second one")
                .label(*first, "the first one")
                .help("remove `main` from one of them"),
            Self::AgentOutsideInit { at } => error("L025")
                .label(*at, "belongs to no initial state")
                .help("put it after `default init name:`"),

            Self::CutOff { missing, at, open } => {
                let found = error("L030").label(*at, format!("expected {missing}, found the end"));
                open.iter().fold(found, |found, (word, span)| {
                    found.label(*span, format!("this `{word}` is still open"))
                })
            }
            Self::Unclosed {
                missing,
                at,
                open,
                misaligned,
            } => {
                let unclosed = error("L031")
                    .label(*at, format!("expected `{missing}` before this"))
                    .label(open.1, "opened here");
                match misaligned {
                    Some((inner, end)) => unclosed
                        .label(
                            inner.1,
                            format!("perhaps it is this `{}` that was not closed", inner.0),
                        )
                        .label(
                            end.1,
                            format!("for the `{}` that closes it is indented otherwise", end.0),
                        ),
                    None => unclosed,
                }
            }
            Self::ElseIf { at, outer, inner } => error("L032")
                .label(*at, "expected another `endif` before this")
                .label(*outer, "this `if` is still open")
                .label(*inner, "this one is an `if` of its own")
                .help("end both: `if … else if … endif endif`"),
            Self::ClosesNothing { found } => {
                error("L033").label(found.1, "nothing is open that this could close")
            }
            Self::SeveralRules { first, second, all } => {
                let found = error("L034").label(*second, "the second rule");
                let found = match all {
                    Some(_) => found.label(*first, "the first rule"),
                    None => found.label(*first, "declares one rule"),
                };
                let found = found.help("put them into `par … endpar` or `seq … endseq`");
                match all {
                    Some((span, text)) => {
                        found.guess("do them in parallel", *span, format!("par {text} endpar"))
                    }
                    None => found,
                }
            }
            Self::NoRule { found, after } => {
                let missing = error("L035").label(found.1, "expected a rule before this");
                let missing = match after {
                    Some((word, span)) => missing.label(*span, format!("`{word}` wants a rule")),
                    None => missing,
                };
                missing.help("`skip` is the rule that does nothing")
            }
            Self::BracketedRule { at } => error("L036")
                .label(*at, "not the beginning of a rule")
                .help("leave the brackets out, or write `par … endpar`"),
            Self::CallWithoutBrackets { call: (rule, at) } => error("L037")
                .label(*at, "expected `[` after this")
                .help("a turbo rule is called with round brackets")
                .fix("call it", *at, format!("{rule}[]")),
            Self::BareQuantifier { word, at } => error("L038")
                .label(*at, "not the beginning of a term")
                .help(format!("write `({word} $x in D with …)`")),
            Self::TooDeep { at } => error("L039")
                .label(*at, format!("more than {} levels", crate::MAX_DEPTH))
                .help("name a part of it by a function or a rule of its own"),
            Self::CommaBetweenRules { at } => {
                error("L040")
                    .label(*at, "not expected here")
                    .fix("leave it out", *at, "")
            }
            Self::SquareArguments { at } => error("L041")
                .label(*at, "square brackets call a rule")
                .help("write `f(x) := …`"),

            Self::EqualsForUpdate { at } => {
                error("L050")
                    .label(*at, "compares")
                    .fix("write an update", *at, ":=")
            }
            Self::UpdateForEquals { at } => {
                error("L051")
                    .label(*at, "updates")
                    .fix("write a comparison", *at, "=")
            }
            Self::MissingWord {
                word, at, opener, ..
            } => {
                let missing = error("L052").label(*at, format!("expected `{word}` before this"));
                match opener {
                    Some((word, span)) => missing.label(*span, format!("this `{word}`")),
                    None => missing,
                }
            }
            Self::UnknownWord { found, meant } => error("L053")
                .label(found.1, "not understood here")
                .guess(format!("did you mean `{meant}`?"), found.1, meant.clone()),
            Self::ReservedName { found, .. } => error("L054")
                .label(found.1, "reserved")
                .help("take another name"),
            Self::ComplexName { found, .. } => error("L055")
                .label(found.1, "a number")
                .note("`i` is the imaginary unit: `i`, `i2` and `1+i2` are numbers")
                .help("take another name"),
            Self::Misnamed { found, better, .. } => {
                let misnamed = error("L056").label(found.1, "not such a name");
                match better {
                    Some(better) => {
                        misnamed.guess(format!("call it `{better}`"), found.1, better.clone())
                    }
                    None => misnamed,
                }
            }
            Self::Unused { found } => unused(error("L057"), found),
            Self::Expected {
                what,
                found,
                after,
                open,
            } => {
                let mut expected = error("L058").label(found.1, "not expected here");
                if let Some((_, span)) = after {
                    expected = expected.label(*span, format!("expected {what} after this"));
                }
                if let Some((word, span)) = open {
                    expected = expected.label(*span, format!("this `{word}` is still open"));
                }
                if after.is_none() && Keyword::spelled(&found.0).is_some() {
                    expected = expected.note(format!("`{}` is a reserved word", found.0));
                }
                expected
            }
            Self::ProductSign { at } => error("L059")
                .label(*at, "multiplies numbers")
                .help("write `Prod(A, B) -> C` for a function of two arguments"),
            Self::InfixMembership { at } => error("L060")
                .label(*at, "only binds variables")
                .help("whether a set has an element says `contains(set, element)`"),
            Self::ReturnOfNoRule { at } => error("L061")
                .label(*at, "expected the name of a rule after this")
                .help("the value of a function is written by `:=`"),
            Self::TooMany { at } => error("L062").label(*at, "reading stopped here"),

            Self::OldExists { at } => warning("L070")
                .label(*at, "the spelling before AsmetaS 26.06")
                .fix("write it the new way", *at, "exists"),
            Self::OldInterval { at, new } => warning("L071")
                .label(*at, "an old spelling, AsmetaS refuses it")
                .fix("write it the new way", *at, *new),
            Self::FewRules {
                at, count, without, ..
            } => {
                let few = warning("L072").label(*at, "AsmetaS wants at least two rules here");
                let help = match *count {
                    "no rule" => "`skip` is the rule that does nothing",
                    _ => "a rule alone needs no block",
                };
                match without.as_slice() {
                    [] => few.help(help),
                    edits => few.with_fix(all_sure(help, edits)),
                }
            }
            Self::OutOfOrder {
                at, earlier, moved, ..
            } => {
                let found = warning("L073")
                    .label(*at, "AsmetaS wants this first")
                    .label(*earlier, "and this after it");
                match moved.as_slice() {
                    [] => found.help("put it before the other"),
                    edits => found.with_fix(all_sure("put it before the other", edits)),
                }
            }
            Self::NoSection { at, written, .. } => warning("L074")
                .label(*at, "AsmetaS wants the heading before this")
                .with_fix(all_sure("write the heading", std::slice::from_ref(written))),
            Self::PropertyPrefix { prefix, name, at } => warning("L075")
                .label(*at, "AsmetaS refuses this name")
                .fix("rename it", *at, format!("{prefix}{name}")),
            Self::CalledEarly {
                at,
                declared,
                moved,
                ..
            } => warning("L076")
                .label(*at, "AsmetaS does not know it yet")
                .label(*declared, "declared here")
                .with_fix(all_sure("declare it first", moved)),
        }
    }
}

/// Edits that keep the meaning.
fn all_sure(title: &str, edits: &[Edit]) -> Fix {
    Fix {
        title: title.to_owned(),
        edits: edits.to_vec(),
        applicability: Applicability::Sure,
    }
}

fn exponent(found: Diagnostic, number: &str, at: Span) -> Diagnostic {
    let found = found.label(at, "not a number of the language");
    let plain = number
        .parse::<f64>()
        .map(|value| format!("{value:?}"))
        .unwrap_or_default();
    if plain.is_empty() || plain.contains(['e', 'i', 'N']) {
        found.help("write all the digits")
    } else {
        found.fix("write all the digits", at, plain)
    }
}

fn unused(diagnostic: Diagnostic, found: &Place) -> Diagnostic {
    let diagnostic = diagnostic.label(found.1, "AsmetaL reserves this word and never uses it");
    match found.0.as_str() {
        "endcase" => {
            diagnostic.help("a case ends where the next one begins, the last at `endswitch`")
        }
        "FAIRNESS" | "fairness" => diagnostic.help("write `JUSTICE` or `COMPASSION`"),
        _ => diagnostic,
    }
}
