//! The text of an environment, section by section.

use std::collections::{BTreeMap, BTreeSet};

/// The arguments of a location, and its initial value.
type InitialValue = (Vec<String>, String);

/// The parts of an environment that are written as text.
#[derive(Debug, Default)]
pub(crate) struct Glue {
    signature: Vec<String>,
    rules: Vec<String>,
    initial: Vec<String>,
    /// Initial values of functions with arguments: domain, and the values of locations.
    located: BTreeMap<String, (String, Vec<InitialValue>)>,
    fairness: Vec<String>,
    definitions: Vec<String>,
    /// Functions of which the environment needs to know that they were updated; `true` if only changes count.
    pub given: BTreeMap<String, bool>,
    /// Inputs of the verified specification that the environment sets.
    pub controlled: BTreeSet<String>,
    /// Inputs of the verified specification with a fixed value.
    pub fixed: BTreeSet<String>,
}

impl Glue {
    pub fn heading(&mut self, text: &str) {
        self.signature.push(format!("// ---- {text}"));
    }

    pub fn declare(&mut self, comment: &str, declaration: String) {
        if !comment.is_empty() {
            self.signature.push(format!("// {comment}"));
        }
        self.signature.push(declaration);
    }

    pub fn define(&mut self, definition: String) {
        self.definitions.push(definition);
    }

    pub fn start(&mut self, location: &str, value: &str) {
        self.initial.push(format!("function {location} = {value}"));
    }

    /// Sets the initial value of a location of a function with this domain.
    pub fn start_at(&mut self, function: &str, domain: &str, location: &str, value: &str) {
        let arguments = location.strip_prefix(function).unwrap_or_default();
        let inside = arguments
            .strip_prefix('(')
            .and_then(|it| it.strip_suffix(')'));
        let Some(inside) = inside else {
            return self.start(location, value);
        };
        let arguments = inside.split(", ").map(str::to_owned).collect();
        let known = self.located.entry(function.to_owned());
        let (_, values) = known.or_insert_with(|| (domain.to_owned(), Vec::new()));
        values.push((arguments, value.to_owned()));
    }

    /// The initial values of functions with arguments; undef at other locations.
    fn located(&self) -> String {
        let functions = self.located.iter().map(|(function, (domain, values))| {
            let mut value = "undef".to_owned();
            for (arguments, there) in values.iter().rev() {
                let equal = arguments.iter().enumerate();
                let equal: Vec<String> = equal.map(|(at, it)| format!("$a{at} = {it}")).collect();
                let condition = equal.join(" and ");
                value = format!("if {condition} then {there} else {value} endif");
            }
            format!("function {function}{} = {value}", parameters(domain))
        });
        functions.collect::<Vec<_>>().join("\n")
    }

    pub fn rule(&mut self, comment: &str, name: &str, body: &str) {
        self.rules
            .push(format!("// {comment}\nrule {name} =\n{body}\n"));
    }

    pub fn justice(&mut self, comment: &str, term: &str) {
        self.fairness
            .push(format!("// {comment}\nJUSTICE {term}\n"));
    }

    /// A line for each function of the specifications that the environment observes (`given`), sets (`controlled`) or fixes (`static`).
    pub fn functions(&self) -> String {
        let given = self.given.iter();
        let given = given.map(|(function, changes)| format!("given {function} {changes}"));
        let controlled = self.controlled.iter().map(|it| format!("controlled {it}"));
        let fixed = self.fixed.iter().map(|it| format!("static {it}"));
        given
            .chain(controlled)
            .chain(fixed)
            .collect::<Vec<_>>()
            .join("\n")
    }

    /// Returns the text of the environment as a specification.
    pub fn text(&self, comment: &str) -> String {
        let comment: Vec<String> = comment.lines().map(|line| format!("// {line}")).collect();
        format!(
            "asm environment\n{}\nimport StandardLibrary\n\nsignature:\n{}\n\ndefinitions:\n{}\n{}\n{}\nmain rule r_Main = r_environment[]\n\n\
             default init s0:\n{}\n{}\n",
            comment.join("\n"),
            self.signature.join("\n"),
            self.definitions.join("\n"),
            self.rules.join("\n"),
            self.fairness.join("\n"),
            self.initial.join("\n"),
            self.located(),
        )
    }
}

/// Rules in sequence; `skip` if there are none.
pub(crate) fn sequence(rules: &[String]) -> String {
    match rules {
        [] => "skip".to_owned(),
        [only] => only.clone(),
        several => format!("seq\n{}\nendseq", several.join("\n")),
    }
}

/// Parameters for a definition of a function with this domain.
pub(crate) fn parameters(domain: &str) -> String {
    let inside = domain
        .strip_prefix("Prod(")
        .and_then(|it| it.strip_suffix(')'));
    let parts: Vec<&str> = inside.map_or_else(|| vec![domain], |it| it.split(", ").collect());
    let parts = parts
        .iter()
        .enumerate()
        .map(|(at, part)| format!("$a{at} in {part}"));
    format!("({})", parts.collect::<Vec<_>>().join(", "))
}
