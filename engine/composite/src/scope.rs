//! Substitution of properties and variables in strings; the only access to the environment.

use crate::codes::c013::UnknownSetting;
use crate::codes::c014::UnsetVariable;
use crate::codes::c015::InvalidSetting;
use crate::codes::c016::SettingOutOfRange;
use std::collections::BTreeMap;

use asmotion_diagnostics::{Code, Finding, Report, Sources, Span};

use crate::environment::{VariableSource, is_secret};
use crate::finding::Findings;
use crate::nearest::nearest;
use crate::template::{self, Piece, Template};
use crate::tree::{Branch, Node};
use crate::value::{REDACTED, SettingValue};
use crate::wording::is_outside;

/// Codes that may concern values set outside the files.
const OF_VALUES: &[&Code] = &[
    UnknownSetting::CODE,
    InvalidSetting::CODE,
    SettingOutOfRange::CODE,
];

/// Diagnostics collected during substitution.
#[derive(Default)]
pub struct SubstitutionNotes {
    /// Diagnostics in order of detection.
    pub report: Report,
    /// Unset environment variables.
    pub missing: Vec<String>,
    /// Whether an error concerns a value set outside the files.
    pub outside: bool,
}

impl SubstitutionNotes {
    fn missing(&mut self, name: &str) {
        if !self.missing.iter().any(|known| known == name) {
            self.missing.push(name.to_owned());
        }
    }
}

impl Findings for SubstitutionNotes {
    fn found(&mut self, finding: impl Finding) {
        let finding = finding.diagnostic();
        self.outside |= is_outside(&finding) && finding.is_any(OF_VALUES);
        self.report.push(finding);
    }
}

/// Externally set values by property name, with their source location if in a file; the value is `None` if it could not
/// be resolved.
pub type OutsideSettings = BTreeMap<String, (Option<SettingValue>, Option<Span>)>;

/// Property values of a composite instance.
pub struct PropertyScope<'s> {
    /// Value and location of each property; `None` for an unresolved value, which has been reported.
    values: BTreeMap<String, (Option<SettingValue>, Span)>,
    environment: &'s dyn VariableSource,
    sources: &'s Sources,
}

/// A string after substitution.
#[derive(Clone, Debug)]
pub(crate) struct Filled {
    pub text: String,
    /// Text with secrets masked, for display.
    pub shown: String,
}

impl Filled {
    fn secret(&self) -> bool {
        self.text != self.shown
    }
}

impl<'s> PropertyScope<'s> {
    /// A scope without properties.
    pub fn new(environment: &'s dyn VariableSource, sources: &'s Sources) -> Self {
        let values = BTreeMap::new();
        Self {
            values,
            environment,
            sources,
        }
    }

    /// Adds a property that is declared at `declared`; its value is `None` if it is unknown, which has been reported.
    pub(crate) fn declare(&mut self, name: &str, value: Option<SettingValue>, declared: Span) {
        self.values.insert(name.to_owned(), (value, declared));
    }

    /// The value of a property, if it is known.
    pub fn value(&self, name: &str) -> Option<&SettingValue> {
        self.values.get(name)?.0.as_ref()
    }

    /// Applies the substitutions in a value; `None` if one is unresolved.
    pub fn node(&self, node: &Node, notes: &mut SubstitutionNotes) -> Option<SettingValue> {
        Some(match &node.value {
            Branch::Text(text) => return self.text(text, node.span, notes),
            Branch::Integer(number) => SettingValue::Integer(*number),
            Branch::Float(number) => SettingValue::Real(*number),
            Branch::Boolean(truth) => SettingValue::Boolean(*truth),
            Branch::Date(date) => SettingValue::Text(date.clone()),
            Branch::List(items) => {
                let values: Vec<_> = items.iter().map(|item| self.node(item, notes)).collect();
                SettingValue::List(values.into_iter().collect::<Option<_>>()?)
            }
            Branch::Table(table) => {
                let fields = table.entries.iter().map(|entry| {
                    let value = self.node(&entry.node, notes)?;
                    Some((entry.key.value.clone(), value))
                });
                let fields: Vec<_> = fields.collect();
                SettingValue::Record(fields.into_iter().collect::<Option<_>>()?)
            }
        })
    }

    /// Applies the substitutions in a string. A string consisting of a single property has the type of the property.
    fn text(&self, text: &str, span: Span, notes: &mut SubstitutionNotes) -> Option<SettingValue> {
        let exact = self.sources.snippet(span) == text;
        let template = template::parse(text, span, exact).ok()?;
        if let [Piece::Property { name, span }] = template.pieces.as_slice() {
            return self.property(name, *span, notes).cloned();
        }
        let filled = self.fill(&template, notes)?;
        Some(if filled.secret() {
            SettingValue::Secret(filled.text)
        } else {
            SettingValue::Text(filled.text)
        })
    }

    pub(crate) fn property(
        &self,
        name: &str,
        at: Span,
        notes: &mut SubstitutionNotes,
    ) -> Option<&SettingValue> {
        match self.values.get(name) {
            Some((value, _)) => value.as_ref(),
            None => {
                let known = self
                    .values
                    .iter()
                    .map(|(name, (_, at))| (name.as_str(), Some(*at)));
                let nearest = nearest(name, known);
                notes.found(UnknownSetting {
                    name: name.to_owned(),
                    at: Some(at),
                    nearest,
                });
                None
            }
        }
    }

    /// Applies the substitutions in a template; `None` if one is unresolved.
    pub(crate) fn fill(
        &self,
        template: &Template,
        notes: &mut SubstitutionNotes,
    ) -> Option<Filled> {
        let mut text = String::new();
        let mut shown = String::new();
        let mut complete = true;
        for piece in &template.pieces {
            let filled = match piece {
                Piece::Text(plain) => Some((plain.clone(), false)),
                Piece::Property { name, span } => self.property(name, *span, notes).map(plain),
                Piece::Variable {
                    name,
                    default,
                    span,
                } => self.variable(name, default.as_deref(), *span, notes),
            };
            match filled {
                Some((piece, secret)) => {
                    shown.push_str(if secret { REDACTED } else { &piece });
                    text.push_str(&piece);
                }
                None => complete = false,
            }
        }
        complete.then_some(Filled { text, shown })
    }

    /// Returns the value of an environment variable and whether it is a secret. If its name ends in `_FILE`, the value
    /// is the content of the named file.
    fn variable(
        &self,
        name: &str,
        default: Option<&str>,
        at: Span,
        notes: &mut SubstitutionNotes,
    ) -> Option<(String, bool)> {
        let value = self
            .environment
            .variable(name)
            .filter(|value| !value.is_empty());
        let Some(value) = value.or(default.map(str::to_owned)) else {
            notes.missing(name);
            notes.found(UnsetVariable::NotSet {
                name: name.to_owned(),
                at,
            });
            return None;
        };
        if !name.ends_with("_FILE") {
            return Some((value, is_secret(name)));
        }
        match self.environment.secret(&value) {
            Ok(text) => Some((text.trim_end_matches(['\r', '\n']).to_owned(), true)),
            Err(reason) => {
                notes.missing(name);
                let (name, path) = (name.to_owned(), value);
                notes.found(UnsetVariable::NoSecret {
                    name,
                    path,
                    reason,
                    at,
                });
                None
            }
        }
    }
}

/// Formats a value as text; the flag tells whether it is a secret.
fn plain(value: &SettingValue) -> (String, bool) {
    match value {
        SettingValue::Text(text) => (text.clone(), false),
        SettingValue::Secret(text) => (text.clone(), true),
        SettingValue::Boolean(_)
        | SettingValue::Integer(_)
        | SettingValue::Real(_)
        | SettingValue::List(_)
        | SettingValue::Record(_) => (value.to_string(), false),
    }
}
