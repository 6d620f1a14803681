//! Ways out for properties from outside that cannot be read: operators in other notations, misspelt names of properties and machines;
//! and the libraries of operators that a specification does not import.

use crate::system::VerifiedMachine;
use asmotion_diagnostics::{Sources, did_you_mean, similar};
use asmotion_lang::hir::temporal_notation;
use asmotion_lang::{Diagnostic, Report, Specification};

/// Returns the library that declares an operator which the report says is unknown.
pub(crate) fn missing_library(report: &Report, sources: &Sources) -> Option<&'static str> {
    let findings = report.diagnostics.iter();
    let unknown = findings.filter(|it| it.code.name == "A001");
    let places = unknown.filter_map(|it| it.primary.as_ref().map(|label| label.span));
    let mut names = places.map(|place| sources.snippet(place));
    names.find_map(library_of)
}

/// Returns the library for temporal logic that declares an operator or a pattern: a function with parameters.
fn library_of(operator: &str) -> Option<&'static str> {
    let libraries = ["CTLLibrary", "LTLLibrary"].into_iter();
    let mut libraries = libraries.filter_map(asmotion_lang::stdlib::library);
    let declares = |line: &str| {
        let declared = line.trim_start().strip_prefix("static ");
        let declared = declared.and_then(|line| line.split_once(':'));
        declared.is_some_and(|(name, ty)| name == operator && ty.contains("->"))
    };
    let library = libraries.find(|library| library.text.lines().any(declares));
    library.map(|library| library.name)
}

/// Names that a property from outside can refer to.
pub(crate) struct KnownNames<'a> {
    /// Names of the machines.
    pub machines: &'a [String],
    /// Names of the properties in the specifications.
    pub properties: &'a [String],
}

impl KnownNames<'_> {
    /// Adds ways out to a report about the text of a property, which was resolved in one of the machines.
    pub fn hinted(
        &self,
        mut report: Report,
        text: &str,
        at: usize,
        machines: &[VerifiedMachine],
    ) -> Report {
        let (Some(first), Some(machine)) = (report.diagnostics.first_mut(), machines.get(at))
        else {
            return report;
        };
        let place = first.primary.as_ref().map(|label| label.span);
        let unknown = place.filter(|_| first.code.name == "A001");
        let unknown = unknown.map(|place| machine.specification.sources.snippet(place));
        let hint = unknown
            .and_then(|name| self.of_unknown(name, text, machines))
            .or_else(|| self.machine(text))
            .or_else(|| notation(text));
        if let Some(hint) = hint {
            replace_general_help(first, unknown.is_some(), hint);
        }
        report
    }

    /// Returns the way out for an unknown function.
    fn of_unknown(&self, name: &str, text: &str, machines: &[VerifiedMachine]) -> Option<String> {
        if text.trim() == name
            && let Some(known) = similar(name, self.properties)
        {
            return Some(did_you_mean(known));
        }
        let declares = |specification: &Specification| {
            let mut functions = specification.model.own_functions();
            functions.any(|(_, function)| &*function.name == name)
        };
        let other = machines.iter().find(|it| declares(&it.specification))?;
        Some(format!(
            "name the machine of each function: `{}.{name}`",
            other.name
        ))
    }

    /// Returns the way out for an unknown machine before a function.
    fn machine(&self, text: &str) -> Option<String> {
        if self.machines.len() < 2 {
            return None;
        }
        let is_sign = |sign: char| !(sign.is_alphanumeric() || "_.".contains(sign));
        let qualified = text.split(is_sign).filter_map(|word| word.split_once('.'));
        let mut qualifiers = qualified.map(|(machine, _)| machine);
        let unknown = qualifiers.find(|name| {
            let is_name = name.starts_with(char::is_alphabetic);
            is_name && self.machines.iter().all(|known| known != name)
        })?;
        Some(match similar(unknown, self.machines) {
            Some(known) => did_you_mean(known),
            None => format!("the machines are {}", self.machines.join(", ")),
        })
    }
}

/// Returns what is to be written for the first operator in another notation.
fn notation(text: &str) -> Option<String> {
    let is_sign = |sign: char| !(sign.is_alphanumeric() || sign == '_');
    let words = text.split(is_sign);
    let signs = ["[]", "<>"].into_iter().filter(|sign| text.contains(sign));
    signs.chain(words).find_map(|word| {
        let (operator, meaning) = temporal_notation(word, None)?;
        Some(format!("{meaning}: write `{operator}`"))
    })
}

/// Adds a help in place of the general one about an unknown name.
fn replace_general_help(diagnostic: &mut Diagnostic, is_unknown: bool, hint: String) {
    if is_unknown {
        diagnostic.helps.clear();
        diagnostic.fix = None;
    }
    diagnostic.helps.push(hint);
}

#[cfg(test)]
mod tests {
    use super::library_of;

    #[test]
    fn operators_and_patterns_are_in_the_libraries_that_declare_them() {
        let found = ["ag", "absenceG", "pb", "g", "t", "ctl", "plus"].map(library_of);
        let (ctl, ltl) = (Some("CTLLibrary"), Some("LTLLibrary"));
        assert_eq!(found, [ctl, ctl, ctl, ltl, ltl, None, None]);
    }
}
