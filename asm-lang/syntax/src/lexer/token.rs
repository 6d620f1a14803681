//! The words and signs of the language.

use std::fmt;

/// The smallest thing the parser sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Token<'input> {
    /// A reserved word.
    Keyword(Keyword),
    /// A sign.
    Sign(Sign),
    /// A word that begins lower-case: a function, an agent, a property.
    Name(&'input str),
    /// A word that begins upper-case: a domain or an enumeration literal.
    Constant(&'input str),
    /// `r_x`.
    Rule(&'input str),
    /// `$x`.
    Variable(&'input str),
    /// Any word after `asm`, `module` and `init`.
    Word(&'input str),
    /// What stands after `import`, without quotes.
    Path(&'input str),
    /// Digits.
    Integer(&'input str),
    /// Digits and `n`.
    Natural(&'input str),
    /// Digits, a point, digits.
    Real(&'input str),
    /// `1+i2`, `i2`, `i`; with its sign where no operand stands before it.
    Complex(&'input str),
    /// `'c'`, without quotes.
    Char(&'input str),
    /// `"text"`, without quotes.
    Text(&'input str),
    /// Stands before the tokens of a text and says what the text is; no text has it.
    Start(TextKind),
}

/// What a text is as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TextKind {
    /// A specification.
    File,
    /// One rule.
    Rule,
    /// One term.
    Term,
}

/// A fixed spelling for every variant; a later spelling of the same variant is its synonym.
macro_rules! spelled {
    ($(#[$meta:meta])* $name:ident { $($variant:ident $spelling:literal $(| $synonym:literal)?,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub(crate) enum $name { $($variant,)* }

        impl $name {
            /// The variant that is spelled so.
            pub(crate) fn spelled(text: &str) -> Option<Self> {
                match text {
                    $($spelling $(| $synonym)? => Some(Self::$variant),)*
                    _ => None,
                }
            }

            /// How it is written.
            pub(crate) const fn spelling(self) -> &'static str {
                match self { $(Self::$variant => $spelling,)* }
            }
        }
    };
}

spelled! {
    /// The reserved words. `and`, `or`, … are reserved here and let in as names by the grammar.
    Keyword {
        // a file and its sections
        Asm "asm", Module "module", Asyncr "asyncr", Import "import", Export "export",
        Signature "signature", Definitions "definitions",
        Default "default", Init "init", Agent "agent",
        // domains
        Domain "domain", Anydomain "anydomain", Basic "basic", Abstract "abstract", Enum "enum",
        Subsetof "subsetof", Dynamic "dynamic",
        ProdType "Prod", SeqType "Seq", PowersetType "Powerset", BagType "Bag", MapType "Map",
        RuleType "Rule",
        // functions
        Function "function", Static "static", Derived "derived", Monitored "monitored",
        Controlled "controlled", Shared "shared", Out "out", Local "local",
        // rules
        Rule "rule", Macro "macro", Turbo "turbo", Main "main", Skip "skip",
        Par "par", Endpar "endpar", Seq "seq", Endseq "endseq",
        If "if", Then "then", Else "else", Endif "endif",
        Switch "switch", Case "case", Otherwise "otherwise", Endswitch "endswitch",
        Choose "choose", Forall "forall", In "in", With "with", Do "do", Ifnone "ifnone",
        Let "let", Endlet "endlet", Extend "extend", While "while", Whilerec "whilerec",
        Iterate "iterate", Enditerate "enditerate",
        // properties
        Invariant "invariant", Over "over", Invar "INVAR" | "invar",
        Justice "JUSTICE" | "justice", Compassion "COMPASSION" | "compassion",
        Ctlspec "CTLSPEC" | "ctlspec", Ltlspec "LTLSPEC" | "ltlspec",
        // terms
        True "true", False "false", Undef "undef", Exists "exists", Exist "exist", Unique "unique",
        And "and", Or "or", Xor "xor", Not "not", Implies "implies", Iff "iff", Mod "mod",
        // reserved by AsmetaL and never used by it
        Try "try", Catch "catch", Endcase "endcase", Fairness "FAIRNESS" | "fairness",
    }
}

spelled! {
    /// The signs.
    Sign {
        Open "(", Close ")", OpenBrace "{", CloseBrace "}", OpenBracket "[", CloseBracket "]",
        OpenRule "<<", CloseRule ">>",
        Comma ",", Colon ":", Dot ".", Dots "..", Bar "|", Arrow "->",
        Assign ":=", Return "<-",
        Plus "+", Minus "-", Star "*", Slash "/", Caret "^",
        Eq "=", Neq "!=", Lt "<", Le "<=", Gt ">", Ge ">=",
    }
}

impl Token<'_> {
    /// Whether an operand ends here, so that `+`, `-` and `<` after it are operators.
    pub(crate) fn ends_operand(self) -> bool {
        match self {
            Self::Keyword(word) => matches!(
                word,
                Keyword::True
                    | Keyword::False
                    | Keyword::Undef
                    | Keyword::Endif
                    | Keyword::Endswitch
                    | Keyword::Endlet
            ),
            Self::Sign(sign) => matches!(
                sign,
                Sign::Close | Sign::CloseBrace | Sign::CloseBracket | Sign::CloseRule
            ),
            Self::Name(_)
            | Self::Constant(_)
            | Self::Rule(_)
            | Self::Variable(_)
            | Self::Word(_)
            | Self::Path(_)
            | Self::Integer(_)
            | Self::Natural(_)
            | Self::Real(_)
            | Self::Complex(_)
            | Self::Char(_)
            | Self::Text(_) => true,
            Self::Start(_) => false,
        }
    }
}

impl fmt::Display for Token<'_> {
    /// As the source has it; the parser's error recovery asks for it.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Keyword(word) => out.write_str(word.spelling()),
            Self::Sign(sign) => out.write_str(sign.spelling()),
            Self::Char(text) => write!(out, "'{text}'"),
            Self::Text(text) => write!(out, "\"{text}\""),
            Self::Start(_) => Ok(()),
            Self::Name(text)
            | Self::Constant(text)
            | Self::Rule(text)
            | Self::Variable(text)
            | Self::Word(text)
            | Self::Path(text)
            | Self::Integer(text)
            | Self::Natural(text)
            | Self::Real(text)
            | Self::Complex(text) => out.write_str(text),
        }
    }
}
