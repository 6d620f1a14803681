//! Property values and substitutions. Only this module accesses the environment.

mod kind;

use crate::codes::c013::UnknownSetting;
use crate::codes::c014::UnsetVariable;
use crate::codes::c015::InvalidSetting;
use crate::codes::c016::SettingOutOfRange;
use crate::codes::c017::MissingSetting;
use std::collections::BTreeMap;
use std::path::Path;

use asmotion_diagnostics::{Code, Finding, Report, Sources, Span};

use self::kind::accept;
use self::kind::from_text;
pub(crate) use self::kind::within;
use crate::environment::{VariableSource, is_secret};
use crate::finding::Findings;
use crate::model::{Amount, Composite, Piece, Property, PropertyType, Scalar, Template};
use crate::nearest::{nearest, nearest_name};
use crate::range::Range;
use crate::read::template;
use crate::table::Key;
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

/// Parses the property values of the outermost composite that are set outside the files; reports unknown names.
pub fn outside_settings(
    composite: &Composite,
    settings: &[(String, String)],
    notes: &mut SubstitutionNotes,
) -> OutsideSettings {
    let mut set = OutsideSettings::new();
    let properties = &composite.properties;
    for (name, text) in settings {
        let Some(property) = properties.iter().find(|it| it.name.value == *name) else {
            let known = properties.iter().map(|it| it.name.value.as_str());
            notes.found(UnknownSetting {
                name: name.clone(),
                at: None,
                nearest: nearest_name(name, known),
            });
            continue;
        };
        let value = from_text(text, property.kind.value);
        let value = value.unwrap_or_else(|| SettingValue::Text(text.clone()));
        set.insert(name.clone(), (Some(value), None));
    }
    set
}

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
    /// Resolves the properties of a composite, with the values `set` from outside taking precedence.
    pub fn new(
        properties: &[Property],
        mut set: OutsideSettings,
        environment: &'s dyn VariableSource,
        sources: &'s Sources,
        notes: &mut SubstitutionNotes,
    ) -> Self {
        let mut scope = Self {
            values: BTreeMap::new(),
            environment,
            sources,
        };
        for property in properties {
            let value = match (set.remove(&property.name.value), &property.default) {
                (Some((value, at)), _) => {
                    let value = value.and_then(|value| accept(property, value, at, notes));
                    value.map(|value| beside(property.kind.value, value, at, sources))
                }
                (None, Some(default)) => {
                    let value = scope.default(property, default, notes);
                    let at = Some(default.span);
                    let value = value.and_then(|value| accept(property, value, at, notes));
                    value.map(|value| beside(property.kind.value, value, at, sources))
                }
                (None, None) => {
                    let (name, at) = (property.name.value.clone(), property.name.span);
                    notes.found(MissingSetting { name, at });
                    None
                }
            };
            scope
                .values
                .insert(property.name.value.clone(), (value, property.name.span));
        }
        scope
    }

    /// Returns the value of a property; `None` if it is unresolved.
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

    /// Resolves a default value. Environment variables are strings and are converted to the type of the property.
    fn default(
        &self,
        property: &Property,
        node: &Node,
        notes: &mut SubstitutionNotes,
    ) -> Option<SettingValue> {
        let value = self.node(node, notes)?;
        match (&value, &node.value) {
            (SettingValue::Text(filled), Branch::Text(written)) if filled != written => {
                from_text(filled, property.kind.value).or(Some(value))
            }
            _ => Some(value),
        }
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

    fn property(
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

    /// Resolves an integer that may refer to a property.
    pub(crate) fn amount(
        &self,
        key: &Key,
        amount: &Amount,
        at: Span,
        notes: &mut SubstitutionNotes,
    ) -> Option<u64> {
        let name = key.name;
        let template = match amount {
            Amount::Number(number) => return Some(*number),
            Amount::Template(template) => template,
        };
        let value = match template.pieces.as_slice() {
            [Piece::Property { name, span }] => self.property(name, *span, notes)?.clone(),
            _ => SettingValue::Text(self.fill(template, notes)?.text),
        };
        let number = match &value {
            SettingValue::Integer(number) => Some(*number),
            SettingValue::Real(number) if number.fract() == 0.0 => Some(*number as i64),
            SettingValue::Text(text) => text.trim().parse().ok(),
            SettingValue::Real(_)
            | SettingValue::Boolean(_)
            | SettingValue::Secret(_)
            | SettingValue::List(_)
            | SettingValue::Record(_) => None,
        };
        let Some(number) = number else {
            notes.found(InvalidSetting::WrongType {
                name: name.to_owned(),
                wanted: "an integer".to_owned(),
                found: value.describe(),
                at: Some(at),
                declared: None,
            });
            return None;
        };
        if !(key.least..=key.greatest).contains(&(number as f64)) {
            let (min, max) = (Some(key.least), Some(key.greatest));
            notes.found(SettingOutOfRange {
                name: name.to_owned(),
                value: number.to_string(),
                range: Range {
                    min,
                    max,
                    unit: String::new(),
                },
                at: Some(at),
                declared: None,
            });
            return None;
        }
        u64::try_from(number).ok()
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

/// Makes a relative path relative to the directory of the file that contains it. Substituted values are unchanged:
/// properties of this type have been resolved before, and variables are set outside the files.
fn beside(
    kind: PropertyType,
    value: SettingValue,
    at: Option<Span>,
    sources: &Sources,
) -> SettingValue {
    let Some(at) =
        at.filter(|at| kind.scalar == Scalar::Path && !sources.snippet(*at).contains("${"))
    else {
        return value;
    };
    match value {
        SettingValue::Text(path) if path.is_empty() => SettingValue::Text(path),
        SettingValue::Text(path) => {
            let folder = Path::new(sources.path(at.file))
                .parent()
                .unwrap_or(Path::new(""));
            SettingValue::Text(folder.join(path).display().to_string())
        }
        SettingValue::List(paths) => {
            let paths = paths
                .into_iter()
                .map(|path| beside(kind, path, Some(at), sources));
            SettingValue::List(paths.collect())
        }
        other @ (SettingValue::Boolean(_)
        | SettingValue::Integer(_)
        | SettingValue::Real(_)
        | SettingValue::Secret(_)
        | SettingValue::Record(_)) => other,
    }
}
