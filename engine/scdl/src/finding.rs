//! What can be found while SCDL is read or written.

use asmotion_assembly::At;
use asmotion_diagnostics::{Diagnostic, Span};
use asmotion_lang::codes::Code;

macro_rules! codes {
    ($($name:ident)*) => {
        &[$(Code {
            name: stringify!($name),
            page: include_str!(concat!("../codes/", stringify!($name), ".md")),
        },)*]
    };
}

/// The codes of SCDL, in order: the file as XML, what it says, what cannot be said here or there.
pub const CODES: &[Code] =
    codes! { X001 X002 X003 X004 X005 X006 X007 X008 X009 X010 X011 X012 X013 X014 };

/// A finding in SCDL, or in a composite that is to become SCDL.
#[derive(Clone, Debug, thiserror::Error)]
pub(crate) enum ScdlError {
    #[error("this is not XML: {reason}")]
    Syntax { reason: String, at: Span },
    #[error("`<{name}>` is no composite of the Service Component Architecture")]
    NotScdl { name: String, at: Span },
    #[error("`<{element}>` has no `{attribute}`")]
    Missing {
        element: String,
        attribute: &'static str,
        at: Span,
    },
    #[error("`{what}` has no counterpart in a composite file")]
    NoCounterpart { what: String, at: Span },
    #[error("the password of `{of}` stands in the file")]
    Password {
        of: String,
        variable: String,
        at: Span,
    },
    #[error("there is no {what} `{name}`")]
    Unknown {
        what: &'static str,
        name: String,
        nearest: Option<At<String>>,
        at: Span,
    },
    #[error("`{name}` cannot be `{value}`")]
    WrongValue {
        name: String,
        value: String,
        wanted: &'static str,
        at: Span,
    },
    #[error("nothing says {what} of `{of}`")]
    Assumed {
        what: &'static str,
        of: String,
        assumed: String,
        at: Span,
    },
    #[error("`{reference}` finds {} by itself", found(.services))]
    Autowire {
        reference: String,
        services: Vec<String>,
        at: Span,
    },
    #[error("SCDL cannot say {what} of `{of}`")]
    Unsayable { what: String, of: String, at: Span },
    #[error("`{name}` is no name in a composite file")]
    Renamed {
        name: String,
        renamed: String,
        at: Span,
    },
    #[error("`{of}` promotes several things")]
    Several {
        of: String,
        promoted: String,
        name: String,
        at: Span,
    },
    #[error("nothing says whether `{of}` publishes or subscribes `{topic}`")]
    Undirected { of: String, topic: String, at: Span },
    #[error("`{of}` is called at another address here")]
    Moved { of: String, here: String, at: Span },
}

fn found(services: &[String]) -> String {
    match services {
        [] => "no service".to_owned(),
        several => format!("{} services", several.len()),
    }
}

impl ScdlError {
    pub(crate) fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::Syntax { at, .. } => Diagnostic::error("X001", self)
                .label(*at, "here")
                .help("mend the file with the tool that wrote it"),
            Self::NotScdl { at, .. } => Diagnostic::error("X002", self)
                .label(*at, "the outermost element")
                .help("SCDL begins with `<composite xmlns=\"http://docs.oasis-open.org/ns/opencsa/sca/200912\" name=\"…\">`"),
            Self::Missing { attribute, at, .. } => Diagnostic::error("X003", self)
                .label(*at, "of this element")
                .help(format!("add `{attribute}=\"…\"`")),
            Self::NoCounterpart { at, .. } => Diagnostic::warning("X004", self)
                .label(*at, "kept as a comment")
                .help("say it by hand where the comment stands, or leave it out"),
            Self::Password { variable, at, .. } => Diagnostic::warning("X005", self)
                .label(*at, "whoever has the file has it")
                .help(format!("set `{variable}`, which the composite file names in its place")),
            Self::Unknown { nearest, at, .. } => {
                let error = Diagnostic::error("X006", self).label(*at, "not to be found");
                match nearest {
                    Some(near) => error
                        .label(near.span, "this one is there")
                        .help(format!("did you mean `{}`?", near.value)),
                    None => error.help("add it, or leave this out"),
                }
            }
            Self::WrongValue { wanted, at, .. } => Diagnostic::error("X007", self)
                .label(*at, format!("not {wanted}"))
                .help(format!("write {wanted}")),
            Self::Assumed { assumed, at, .. } => Diagnostic::warning("X008", self)
                .label(*at, format!("`{assumed}` is assumed"))
                .help("put the right one in the composite file"),
            Self::Autowire { services, at, .. } => {
                let error = Diagnostic::error("X009", self).label(*at, "wired by itself");
                match services.is_empty() {
                    true => error.help("no service has its interface; name one with `target`"),
                    false => error.help(format!(
                        "it could be {}; name one with `target`",
                        services.join(" or ")
                    )),
                }
            }
            Self::Unsayable { at, .. } => Diagnostic::warning("X010", self)
                .label(*at, "left out")
                .help("keep the composite file: it is the one that runs"),
            Self::Renamed { renamed, at, .. } => Diagnostic::warning("X011", self)
                .label(*at, format!("becomes `{renamed}`"))
                .help("a name has letters, digits, `_` and `-`, and begins with a letter"),
            Self::Several {
                promoted, name, at, ..
            } => Diagnostic::warning("X013", self)
                .label(*at, format!("`{promoted}` becomes `{name}`"))
                .help("one promotion promotes one thing here; wire each by its own name"),
            Self::Moved { here, at, .. } => Diagnostic::warning("X014", self)
                .label(*at, format!("`{here}` from now on"))
                .help("tell those who call it: the operation's name follows, and the argument is JSON"),
            Self::Undirected { topic, at, .. } => Diagnostic::warning("X012", self)
                .label(*at, "renames it")
                .help(format!("list `{topic}` under `publish` or `subscribe` of the composite file, with its type")),
        }
    }
}
