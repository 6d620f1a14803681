//! Tokens: the keywords and signs of the language.

use std::fmt;

/// A token of the language.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Token<'input> {
    Keyword(Keyword),
    Sign(Sign),
    /// A lower-case word: a function, an agent or a property.
    Name(&'input str),
    /// An upper-case word: a domain or an enumeration literal.
    Constant(&'input str),
    /// A rule name: `r_x`.
    Rule(&'input str),
    /// A variable: `$x`.
    Variable(&'input str),
    /// Any word after `asm`, `module` and `init`.
    Word(&'input str),
    /// The path after `import`, without quotes.
    Path(&'input str),
    /// An integer: digits.
    Integer(&'input str),
    /// A natural: digits and `n`.
    Natural(&'input str),
    /// A real: digits, a dot, digits.
    Real(&'input str),
    /// A complex number: `1+i2`, `i2`, `i`. Includes a sign unless an operand precedes it.
    Complex(&'input str),
    /// A character `'c'`, without quotes.
    Char(&'input str),
    /// A string `"text"`, without quotes.
    Text(&'input str),
    /// A marker before the first token that selects the start symbol of the grammar; never read
    /// from a text.
    Start(TextKind),
}

/// The start symbol for a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TextKind {
    File,
    Rule,
    Term,
}

/// Generates an enum whose variants have fixed spellings, optionally with a synonym.
macro_rules! spelled {
    ($(#[$meta:meta])* $name:ident { $($variant:ident $spelling:literal $(| $synonym:literal)?,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub(crate) enum $name { $($variant,)* }

        impl $name {
            /// Returns the variant with this spelling.
            pub(crate) fn spelled(text: &str) -> Option<Self> {
                match text {
                    $($spelling $(| $synonym)? => Some(Self::$variant),)*
                    _ => None,
                }
            }

            /// Returns the spelling, without synonyms.
            pub(crate) const fn spelling(self) -> &'static str {
                match self { $(Self::$variant => $spelling,)* }
            }
        }
    };
}

spelled! {
    /// The keywords. `and`, `or`, … are also accepted as names by the grammar.
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
        // reserved in AsmetaL without a use
        Try "try", Catch "catch", Endcase "endcase", Fairness "FAIRNESS" | "fairness",
    }
}

spelled! {
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
    /// Returns `true` if the token ends an operand, so that `+`, `-` and `<` after it are
    /// operators.
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
    /// Writes the token as in source texts; required by the parser's error recovery.
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
