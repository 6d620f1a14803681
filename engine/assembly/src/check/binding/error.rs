//! What can be wrong between a composite and the `.asm` file it binds.

use asmotion_diagnostics::{Diagnostic, Span};

use crate::finding::Finding;
use crate::nearest::{Nearest, Suggest, nearest_name};
use crate::read::error::enumerate;
use crate::signature::FunctionInfo;

#[derive(Debug, thiserror::Error)]
pub(crate) enum BindingError {
    #[error("the specification has no function `{name}`")]
    UnknownFunction {
        name: String,
        at: Span,
        nearest: Option<Nearest>,
    },
    #[error("`{}` is {}, so {reason}", function.name, function.kind.word())]
    WrongKind {
        function: FunctionInfo,
        reason: &'static str,
        help: &'static str,
        at: Span,
    },
    #[error("`{}` has arguments, so one message cannot be its value", function.name)]
    HasArguments { function: FunctionInfo, at: Span },
    #[error("`{literal}` is no literal of `{domain}`")]
    UnknownLiteral {
        literal: String,
        domain: String,
        literals: Vec<String>,
        at: Span,
        declared: Span,
    },
    #[error("`{}` takes {}, not {found}", function.name, function.codomain.name())]
    WrongValue {
        function: FunctionInfo,
        found: String,
        at: Span,
    },
    #[error("`{}` is {}, and {found} does not fit it", function.name, function.codomain.name())]
    WrongField {
        function: FunctionInfo,
        found: String,
        at: Span,
        typed: Option<Span>,
    },
    #[error("which field of `{message}` belongs to `{function}`?")]
    WhichField {
        function: String,
        message: String,
        fields: Vec<String>,
        at: Span,
    },
    #[error("nothing gives `{}` a value, so it stays undef", function.name)]
    UnboundMonitored { function: FunctionInfo, at: Span },
    #[error("nobody hears of what the specification writes to `{}`", function.name)]
    UnboundOut { function: FunctionInfo, at: Span },
    #[error("`@{name}` is neither an input nor kept from a reply")]
    UnknownKept {
        name: String,
        at: Span,
        known: Vec<String>,
    },
    #[error("`{what}` takes `{wanted}`, but {given} is {found}")]
    WrongArgument {
        what: String,
        wanted: String,
        given: String,
        found: String,
        at: Span,
    },
    #[error("the main rule of the specification is not `{name}`")]
    MainRule {
        name: String,
        at: Span,
        found: Option<(String, Span)>,
    },
}

impl Finding for BindingError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::UnknownFunction { at, nearest, .. } => Diagnostic::error("C090", self)
                .label(*at, "bound here")
                .suggest(*at, nearest),
            Self::WrongKind {
                function, help, at, ..
            } => Diagnostic::error("C091", self)
                .label(*at, "bound here")
                .label(
                    function.declared,
                    format!("declared {} here", function.kind.word()),
                )
                .help(*help),
            Self::HasArguments { function, at } => Diagnostic::error("C092", self)
                .label(*at, "bound here")
                .label(function.declared, format!("from `{}`", function.domain))
                .help("bind a function without arguments"),
            Self::UnknownLiteral {
                literal,
                literals,
                at,
                declared,
                ..
            } => {
                let known: Vec<&str> = literals.iter().map(String::as_str).collect();
                let nearest = nearest_name(literal, known.iter().copied());
                Diagnostic::error("C093", self)
                    .label(*at, "no such literal")
                    .label(*declared, "the domain has others")
                    .help(format!("it can be {}", enumerate(&known)))
                    .suggest(*at, &nearest)
            }
            Self::WrongValue { function, at, .. } => Diagnostic::error("C094", self)
                .label(*at, format!("not of `{}`", function.codomain.name()))
                .label(function.declared, "declared here")
                .help(format!("write a value of `{}`", function.codomain.name())),
            Self::WrongField {
                function,
                at,
                typed,
                ..
            } => {
                let diagnostic = Diagnostic::error("C095", self)
                    .label(*at, "bound here")
                    .label(function.declared, "declared here")
                    .help("bind a field whose type the function takes; `map` reads a text as a literal, `edge = true` is for Booleans");
                match typed {
                    Some(typed) => diagnostic.label(*typed, "the message is described here"),
                    None => diagnostic,
                }
            }
            Self::WhichField { fields, at, .. } => {
                let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
                Diagnostic::error("C096", self)
                    .label(*at, "several could")
                    .help(format!("say `field = \"…\"`: {}", enumerate(&fields)))
            }
            Self::UnboundMonitored { function, at } => Diagnostic::warning("C097", self)
                .label(*at, format!("no binding for `{}`", function.name))
                .label(function.declared, "declared `monitored` here")
                .help(format!(
                    "add `{} = {{ topic = \"…\" }}` to `bind.monitored`",
                    function.name
                )),
            Self::UnboundOut { function, at } => Diagnostic::warning("C098", self)
                .label(*at, format!("no binding for `{}`", function.name))
                .label(function.declared, "declared `out` here")
                .help(format!(
                    "add `{} = {{ topic = \"…\" }}` to `bind.out`",
                    function.name
                )),
            Self::UnknownKept { name, at, known } => {
                let nearest = nearest_name(name, known.iter().map(String::as_str));
                Diagnostic::error("C099", self)
                    .label(*at, "not known")
                    .help("a call keeps its reply with `keep = \"name\"`; `@@` is an at sign")
                    .suggest(*at, &nearest)
            }
            Self::WrongArgument { at, .. } => Diagnostic::error("C100", self)
                .label(*at, "of another type")
                .help("`@name.field` takes a part of a message"),
            Self::MainRule { at, found, .. } => {
                let diagnostic = Diagnostic::error("C101", self).label(*at, "named here");
                match found {
                    Some((name, declared)) => diagnostic.label(*declared, "the main rule").guess(
                        format!("did you mean `{name}`?"),
                        *at,
                        name,
                    ),
                    None => diagnostic.note("it has no main rule, so it is a module"),
                }
            }
        }
    }
}
