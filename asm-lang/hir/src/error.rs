//! What can be wrong with a tree that was read, and how to say it.

use asmotion_diagnostics::{Diagnostic, LoadError, Span};
use std::sync::Arc;

type Name = Arc<str>;

/// A finding of the analysis.
#[derive(Debug, thiserror::Error)]
pub(crate) enum HirError {
    #[error("unknown function `{name}`")]
    UnknownFunction {
        name: Name,
        at: Span,
        similar: Option<(Name, Span)>,
    },
    #[error("`{name}` is known only with `import {library}`")]
    NotImported {
        name: Name,
        library: &'static str,
        at: Span,
    },
    #[error("unknown variable `{name}`")]
    UnknownVariable {
        name: Name,
        at: Span,
        similar: Option<Name>,
    },
    #[error("`{name}` is not bound here")]
    OutOfScope { name: Name, at: Span, bound: Span },
    #[error("unknown rule `{name}`")]
    UnknownRule {
        name: Name,
        at: Span,
        similar: Option<(Name, Span)>,
    },
    #[error("unknown domain `{name}`")]
    UnknownDomain {
        name: Name,
        at: Span,
        similar: Option<Name>,
    },
    #[error("`{name}` is neither an enumeration literal nor a domain")]
    UnknownConstant {
        name: Name,
        at: Span,
        similar: Option<Name>,
    },
    #[error("no `{name}` takes {actual}")]
    NoOverload {
        name: Name,
        at: Span,
        actual: String,
        candidates: Vec<(String, Span)>,
        hint: Option<String>,
        /// A number that is written for another domain.
        number: Option<Respelt>,
    },
    #[error("{what} expects {wanted}, this is {actual}")]
    Mismatch {
        what: String,
        wanted: String,
        actual: String,
        at: Span,
        /// Where the wanted type comes from, and how to say so.
        because: Option<(Span, &'static str)>,
        /// How a number that stands here is written in the wanted domain.
        number: Option<String>,
    },
    #[error("`{name}` takes {wanted} argument{}, not {actual}", if *wanted == 1 { "" } else { "s" })]
    Arity {
        name: Name,
        wanted: usize,
        actual: usize,
        at: Span,
        declared: Span,
    },
    #[error("`{name}` is declared twice")]
    Duplicate { name: Name, at: Span, first: Span },
    #[error("cannot find `{path}`")]
    ImportNotFound { path: String, at: Span },
    #[error("`{path}` imports itself")]
    ImportCycle {
        path: String,
        at: Span,
        chain: Vec<(String, Option<Span>)>,
    },
    #[error("imports nest deeper than {limit} files")]
    ImportsTooDeep { at: Span, limit: usize },
    #[error("{error}")]
    Unreadable { error: LoadError, at: Option<Span> },
    #[error("`{module}` exports no `{name}`")]
    NotExported { module: Name, name: Name, at: Span },
    #[error("`{function}` is {kind}, so no rule may update it")]
    WritesFixed {
        function: Name,
        kind: &'static str,
        at: Span,
        declared: Span,
    },
    #[error("`{function}` is monitored, so no rule may update it")]
    WritesMonitored {
        function: Name,
        at: Span,
        declared: Span,
    },
    #[error("`{name}` is assigned: it becomes a location of the rule that binds it")]
    WritesVariable { name: Name, at: Span, bound: Span },
    #[error("`{name}` ranges over {actual}, which is not a collection")]
    NotACollection {
        name: Name,
        actual: String,
        at: Span,
    },
    #[error("{what} are of different domains: {first} and {second}")]
    Disagree {
        what: &'static str,
        first: String,
        second: String,
        first_at: Span,
        second_at: Span,
    },
    #[error("`{name}` is defined here, but not declared in the signature")]
    DefinesUndeclared {
        name: Name,
        at: Span,
        similar: Option<(Name, Span)>,
    },
    #[error("`{name}` is {kind}; {why}")]
    DefinesWrongKind {
        name: Name,
        kind: &'static str,
        why: &'static str,
        help: &'static str,
        at: Span,
        /// Where, if not in a library.
        declared: Option<Span>,
    },
    #[error("`{name}` has no main rule")]
    NoMain { name: Name, at: Span },
    #[error("the main rule takes no arguments")]
    MainParameters { at: Span },
    #[error("`{name}` is defined as itself: it is an element of its domain")]
    DefinesItself { name: Name, at: Span },
    #[error("`{function}` is set by the machine, so no rule may update it")]
    WritesReserved { function: Name, at: Span },
    #[error("a Natural is wanted, this is an Integer")]
    IntegerForNatural { number: String, at: Span },
    #[error("`{name}` is local, but no rule declares it")]
    LocalInSignature { name: Name, at: Span },
    #[error("`{domain}` is extended, but not declared dynamic")]
    ExtendsStatic {
        domain: Name,
        at: Span,
        declared: Span,
    },
    #[error("`{name}` is declared for {wanted}, this is any {actual}")]
    TooWide {
        name: Name,
        wanted: String,
        actual: String,
        at: Span,
        declared: Span,
    },
    #[error("the specification is `asyncr`, but nothing chooses who runs")]
    NothingChosen { at: Span },
    #[error("`{name}` does not say what it returns")]
    ResultUndeclared {
        name: Name,
        at: Span,
        declared: Span,
    },
    #[error("`{function}` is monitored: what the environment says next counts, not this result")]
    ReturnsToMonitored {
        function: Name,
        at: Span,
        declared: Span,
    },
    #[error("`{name}` returns nothing")]
    NoResult {
        name: Name,
        at: Span,
        declared: Span,
    },
    #[error("`{name}` is a {is} rule")]
    CallForm {
        name: Name,
        is: &'static str,
        want: &'static str,
        at: Span,
        declared: Span,
    },
    #[error("`{domain}` cannot be extended: it is {kind}")]
    CannotExtend {
        domain: Name,
        kind: &'static str,
        at: Span,
        declared: Span,
    },
    #[error("none of the initial states is {wanted}")]
    NoSuchInit {
        wanted: String,
        at: Span,
        help: String,
    },
    #[error("this is not a rule: its value is {actual}")]
    NotARule { actual: String, at: Span },
    #[error("`not` binds tighter than `{operator}`: this reads `(not …) {operator} …`")]
    NotBinds {
        operator: &'static str,
        at: Span,
        operand: Span,
    },
    #[error("the file is called `{stem}`, the specification `{name}`")]
    FileName { name: Name, stem: String, at: Span },
    #[error("`{module}` exports nothing, so this import brings no name")]
    ImportsNothing { module: Name, at: Span },
    #[error("`{domain}` is a subset of itself")]
    DomainCycle { domain: Name, at: Span },
    #[error("`{domain}` has no elements: it is not defined")]
    EmptyDomain { domain: Name, at: Span },
}

/// A number as it is written in the domain that is wanted.
#[derive(Debug)]
pub(crate) struct Respelt {
    pub at: Span,
    pub domain: &'static str,
    pub text: String,
}

impl HirError {
    /// The finding for people.
    pub(crate) fn diagnostic(&self) -> Diagnostic {
        let error = |code| Diagnostic::error(code, self);
        let warning = |code| Diagnostic::warning(code, self);
        match self {
            Self::UnknownFunction { at, similar, .. } => {
                let finding = error("A001").label(*at, "not declared in this file or its imports");
                let help = "declare it in the signature, or import the module that declares it";
                with_similar(finding, *at, similar, help)
            }
            Self::NotImported { library, at, .. } => error("A036")
                .label(*at, format!("declared by `{library}`, which this file does not import"))
                .help(format!("write `import {library}` behind the name of the specification")),
            Self::UnknownVariable { at, similar, .. } => {
                let finding = error("A002").label(*at, "not bound here");
                match similar {
                    Some(name) => {
                        finding.guess(format!("did you mean `{name}`?"), *at, name.to_string())
                    }
                    None => finding.help(
                        "bind it with `let`, `forall`, `choose`, or make it a parameter of the rule",
                    ),
                }
            }
            Self::OutOfScope { at, bound, .. } => warning("W021")
                .label(*at, "a run that comes here fails")
                .label(*bound, "bound here, for the rule or term that follows it and no further")
                .help("move what needs it into that rule, or bind it again with `let`, `forall` or `choose`"),
            Self::UnknownRule { at, similar, .. } => {
                let finding = error("A003").label(*at, "no rule has this name");
                with_similar(
                    finding,
                    *at,
                    similar,
                    "rules are declared under `definitions:`",
                )
            }
            Self::UnknownDomain { at, similar, .. } => {
                let finding = error("A004").label(*at, "no domain has this name");
                match similar {
                    Some(name) => {
                        finding.guess(format!("did you mean `{name}`?"), *at, name.to_string())
                    }
                    None => finding
                        .help("declare it in the signature, or import the module that declares it"),
                }
            }
            Self::UnknownConstant { at, similar, .. } => {
                let finding = error("A005").label(*at, "unknown name");
                match similar {
                    Some(name) => finding.guess(format!("did you mean `{name}`?"), *at, name.to_string()),
                    None => finding.help("names that begin with a capital are literals of an `enum domain`, or domains"),
                }
            }
            Self::NoOverload {
                at,
                candidates,
                hint,
                number,
                ..
            } => {
                let mut finding = error("A006").label(*at, "applied here");
                for (signature, declared) in candidates.iter().take(4) {
                    finding = finding.label(*declared, signature.clone());
                }
                match (number, hint) {
                    (Some(Respelt { at, domain, text }), _) => finding.fix(
                        format!("a number of {domain} is written so"),
                        *at,
                        text.clone(),
                    ),
                    (None, Some(hint)) => finding.help(hint.clone()),
                    (None, None) => finding
                        .help("give arguments of the declared domains, or declare an overload"),
                }
            }
            Self::Mismatch {
                at,
                actual,
                wanted,
                because,
                number,
                ..
            } => {
                let finding = error("A007").label(*at, format!("this is {actual}"));
                let finding = match because {
                    Some((because, how)) => finding.label(*because, format!("{how} {wanted}")),
                    None => finding,
                };
                match (number, conversion(wanted, actual)) {
                    (Some(number), _) => finding.fix(
                        format!("a number of {wanted} is written so"),
                        *at,
                        number.clone(),
                    ),
                    (None, Some(help)) => finding.help(help),
                    (None, None) => {
                        finding.help(format!("write a term whose value is in {wanted}"))
                    }
                }
            }
            Self::Arity {
                at,
                declared,
                actual,
                ..
            } => error("A008")
                .label(*at, format!("{actual} given"))
                .label(*declared, "declared here")
                .help("give one argument for each parameter"),
            Self::Duplicate { at, first, .. } => error("A009")
                .label(*at, "declared again here")
                .label(*first, "first declared here")
                .help("rename one of them; functions may share a name if their domains differ"),
            Self::ImportNotFound { path, at } => error("A010")
                .label(*at, "no such file")
                .note(
                    "a path is taken from the folder of the importing file; `.asm` may be left out",
                )
                .help(format!(
                    "check the spelling, or create `{path}.asm`",
                    path = path.trim_end_matches(".asm")
                )),
            Self::ImportCycle { at, chain, .. } if chain.len() < 2 => error("A011")
                .label(*at, "this is the file itself")
                .help("drop this import: a file knows its own names"),
            Self::ImportCycle { at, chain, .. } => {
                let mut finding = error("A011").label(*at, "this import closes the circle");
                for (path, import) in chain {
                    if let Some(import) = import.filter(|import| import != at) {
                        finding = finding.label(import, format!("`{path}` imports this"));
                    }
                }
                finding.help("move what both files need into a third module and import that")
            }
            Self::ImportsTooDeep { at, .. } => error("A012")
                .label(*at, "one import too many")
                .help("import the module you need directly"),
            Self::Unreadable { at, .. } => {
                let finding = error("A013");
                let finding = match at {
                    Some(at) => finding.label(*at, "imported here"),
                    None => finding,
                };
                finding.help("check the path")
            }
            Self::NotExported { at, .. } => error("A015")
                .label(*at, "asked for here")
                .help("add it to the `export` clause of the module, or drop it here"),
            Self::WritesFixed {
                at, declared, kind, ..
            } => error("A016")
                .label(*at, "updated here")
                .label(*declared, format!("declared {kind} here"))
                .help("declare it `controlled` to let rules write it"),
            Self::WritesMonitored { at, declared, .. } => error("A014")
                .label(*at, "updated here")
                .label(*declared, "declared monitored here")
                .help("declare it `shared` if rules write it, too; what the environment is to hear goes to an `out` function"),
            Self::WritesVariable { at, bound, .. } => warning("W020")
                .label(*at, "assigned here, for the rules that follow in a `seq`")
                .label(*bound, "bound here to its first value, and forgotten after the rule")
                .help("update a controlled function if the value is to last"),
            Self::NotACollection { at, .. } => error("A018")
                .label(*at, "not a set, sequence or bag")
                .help("range over a domain, a set or a sequence"),
            Self::Disagree {
                first_at,
                second_at,
                first,
                second,
                ..
            } => error("A019")
                .label(*second_at, format!("this is {second}"))
                .label(*first_at, format!("this is {first}"))
                .help(match (first.as_str(), second.as_str()) {
                    ("Integer", "Real") | ("Real", "Integer") => {
                        "write the whole numbers with a point, as in `1.0`, or convert with `itor(…)`"
                    }
                    _ => "let all of them be of one domain",
                }),
            Self::DefinesUndeclared { at, similar, .. } => {
                let finding = error("A020").label(*at, "defined here");
                with_similar(finding, *at, similar, "declare it in the signature first")
            }
            Self::DefinesWrongKind {
                at, declared, help, ..
            } => {
                let finding = error("A021").label(*at, "defined here").help(*help);
                match declared {
                    Some(declared) => finding.label(*declared, "declared here"),
                    None => finding,
                }
            }
            Self::NoMain { at, .. } => warning("W005")
                .label(*at, "this `asm` cannot run")
                .help("add `main rule r_Main = …`, or make it a `module`"),
            Self::MainParameters { at } => error("A023")
                .label(*at, "declared with parameters")
                .help("bind what it needs with `let`, `choose` or `forall` inside the rule"),
            Self::NoResult { at, declared, .. } => error("A024")
                .label(*at, "its result is wanted here")
                .label(*declared, "a macro, which has none")
                .help("declare `turbo rule r_x(…) in D = …` and update `result` in it"),
            Self::DefinesItself { at, .. } => warning("W024")
                .label(*at, "this says nothing")
                .help("drop the definition"),
            Self::WritesReserved { at, function } => error("A034")
                .label(*at, "updated here")
                .help(format!("`{function}` is the agent whose program runs: run it with `program(agent)`")),
            Self::IntegerForNatural { at, number } => warning("W025")
                .label(*at, "taken for the Natural of this size")
                .fix("a Natural is written so", *at, number.clone()),
            Self::LocalInSignature { at, .. } => warning("W026")
                .label(*at, "taken for a controlled function")
                .help("declare it `controlled`, or in front of the body of a turbo rule, as in `local f: Integer [f := 0]`"),
            Self::ExtendsStatic { at, declared, .. } => warning("W027")
                .label(*at, "extended here")
                .label(*declared, "declared here")
                .help("write `dynamic` in front of the declaration: the reference tools insist on it"),
            Self::TooWide { at, declared, wanted, .. } => warning("W028")
                .label(*at, format!("may be no element of {wanted}"))
                .label(*declared, "declared here")
                .help("range over the smaller domain, or declare the function for the larger one"),
            Self::NothingChosen { at } => warning("W029")
                .label(*at, "all that this runs, runs in every step")
                .note("there is no scheduler but the main rule")
                .help("choose the agents that run, as in `choose $a in Agent do program($a)`"),
            Self::ResultUndeclared { at, declared, .. } => warning("W022")
                .label(*at, "its result is wanted here")
                .label(*declared, "declared without `in Domain`")
                .help("declare `turbo rule r_x(…) in D = …`, so that the result is checked"),
            Self::ReturnsToMonitored { at, declared, .. } => warning("W023")
                .label(*at, "written here")
                .label(*declared, "declared monitored here")
                .help("declare it `controlled`, or `shared` if both may write it"),
            Self::CallForm {
                at,
                declared,
                want,
                is,
                ..
            } => error("A025")
                .label(*at, format!("called as a {}", other_form(is)))
                .label(*declared, "declared here")
                .help(*want),
            Self::CannotExtend {
                at, declared, kind, ..
            } => error("A026")
                .label(*at, "extended here")
                .label(*declared, format!("{kind}, declared here"))
                .help("only abstract domains, and subsets of them, take new elements"),
            Self::NoSuchInit { at, help, .. } => error("A027")
                .label(*at, "an initial state")
                .help(help),
            Self::NotARule { at, .. } => error("A028")
                .label(*at, "stands where a rule is wanted")
                .help("an update is written `location := term`, a macro call `r_name[…]`"),
            Self::NotBinds {
                at,
                operand,
                operator,
            } => warning("W001")
                .label(*at, format!("applies to the left of `{operator}` alone"))
                .label(*operand, "not to all of this")
                .help(format!(
                    "write `not (… {operator} …)` to negate the comparison"
                )),
            Self::FileName { name, at, stem } => {
                let found = warning("W002").label(*at, "this name").help(format!(
                    "or call the file `{name}.asm`: the reference tools insist on it"
                ));
                match is_word(stem) {
                    true => found.fix("name it after the file", *at, stem.clone()),
                    false => found,
                }
            }
            Self::ImportsNothing { at, .. } => warning("W003")
                .label(*at, "imported here")
                .help("add `export *` to the module"),
            Self::DomainCycle { at, .. } => error("A033")
                .label(*at, "its `subsetof` leads back here")
                .help("let one of the domains be a subset of a basic or an abstract domain"),
            Self::EmptyDomain { at, domain } => warning("W004")
                .label(*at, "declared here, defined nowhere")
                .help(format!(
                    "add `domain {domain} = {{…}}` under `definitions:`"
                )),
        }
    }
}

/// Whether the file's name can be a name of the language.
fn is_word(stem: &str) -> bool {
    let mut letters = stem.chars();
    let first = letters.next();
    first.is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
        && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

/// Offers the similar name, or help where there is none.
fn with_similar(
    finding: Diagnostic,
    at: Span,
    similar: &Option<(Name, Span)>,
    help: &str,
) -> Diagnostic {
    match similar {
        Some((name, declared)) => finding
            .label(*declared, "a similar name is declared here")
            .guess(format!("did you mean `{name}`?"), at, name.to_string()),
        None => finding.help(help),
    }
}

/// The standard function that leads from one type to the other.
fn conversion(wanted: &str, actual: &str) -> Option<String> {
    let function = match (actual, wanted) {
        ("Integer", "Real") => "itor",
        ("Integer", "Natural") => "iton",
        ("Natural", "Real") => "ntor",
        ("Natural", "Integer") => "ntoi",
        ("Real", "Integer") => "rtoi",
        ("Real", "Natural") => "rton",
        (_, "String") => "toString",
        _ => return None,
    };
    Some(format!("convert it: `{function}(…)`"))
}

/// What a rule was taken for that is called in the other form.
fn other_form(is: &str) -> &'static str {
    match is {
        "turbo" => "macro rule",
        _ => "turbo rule",
    }
}
