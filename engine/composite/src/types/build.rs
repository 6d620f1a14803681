//! Builds schemas from type definitions.

use crate::codes::c110::UnknownType;
use crate::codes::c111::RecursiveType;
use crate::codes::c112::ConflictingTypes;
use crate::codes::c113::TypeDiffersFromBuild;
use crate::codes::c116::{MAX_DEPTH, MAX_FIELDS, TypesTooLarge};
use std::collections::BTreeMap;

use asmotion_datum::{OutlineKey, Schema, Shape};
use asmotion_diagnostics::{Report, Span};

use super::{Definition, PRIMITIVES, TypeText, many, primitive};
use crate::at::At;
use crate::catalogue::Catalogue;
use crate::finding::Findings;
use crate::nearest::nearest_name;

/// Builder of schemas from type definitions.
pub(super) struct Builder<'d, 'c, 'r> {
    pub definitions: &'d BTreeMap<&'d str, Vec<&'d Definition>>,
    pub catalogue: &'c dyn Catalogue,
    pub report: &'r mut Report,
    /// Definitions being built, outermost first; used to detect recursion.
    pub open: Vec<&'d str>,
    /// Number of fields built so far, counting every use of a type; bounds exponential growth.
    pub fields: usize,
}

impl<'d> Builder<'d, '_, '_> {
    pub(super) fn record(&mut self, definition: &'d Definition) -> Schema {
        let before = self.fields;
        self.fields += definition.fields.len();
        if self.fields > MAX_FIELDS || self.open.len() > MAX_DEPTH {
            if before <= MAX_FIELDS {
                self.report.found(TypesTooLarge {
                    at: definition.name.span,
                });
                self.fields = MAX_FIELDS + 1;
            }
            return Schema::opaque(definition.name.value.clone());
        }
        self.open.push(&definition.name);
        let fields = definition.fields.iter().map(|field| {
            let value = match &field.text {
                Some(text) => self.value(text),
                None => Schema::plain(Shape::Any),
            };
            OutlineKey::new(field.name.value.clone(), "", value)
        });
        let fields = fields.collect();
        self.open.pop();
        Schema {
            name: definition.name.value.clone().into(),
            shape: Shape::Record(fields),
        }
    }

    fn value(&mut self, text: &TypeText) -> Schema {
        let base = match (
            primitive(&text.base),
            self.definitions.get_key_value(text.base.as_str()),
        ) {
            (Some(schema), _) => schema,
            (None, Some((name, all))) => self.described(name, all, text.base.span),
            (None, None) => match self.catalogue.schema(&text.base) {
                Some(schema) => schema,
                None => self.unknown(text),
            },
        };
        many(base, text.many)
    }

    fn described(&mut self, name: &'d str, all: &[&'d Definition], at: Span) -> Schema {
        if self.open.contains(&name) {
            self.report.found(RecursiveType {
                name: name.to_owned(),
                at,
            });
            return Schema::opaque(name.to_owned());
        }
        match all.first() {
            Some(definition) => self.record(definition),
            None => Schema::opaque(name.to_owned()),
        }
    }

    fn unknown(&mut self, text: &TypeText) -> Schema {
        let messages = self.catalogue.messages();
        let primitives = PRIMITIVES.iter().map(|(name, _)| *name);
        let known = self.definitions.keys().copied().chain(primitives);
        let known = known.chain(messages.iter().map(String::as_str));
        let nearest = nearest_name(&text.base, known);
        let At {
            value: name,
            span: at,
        } = text.base.clone();
        self.report.found(UnknownType {
            name: name.clone(),
            at,
            nearest,
        });
        Schema::opaque(name)
    }

    /// Checks that several definitions of a type agree with each other and with the catalogue.
    pub(super) fn agree(&mut self, all: &[(&Definition, Schema)]) {
        let Some(((first, schema), others)) = all.split_first() else {
            return;
        };
        let name = &first.name.value;
        for (other, second) in others {
            if let Err(difference) = schema.compare(second) {
                self.report.found(ConflictingTypes {
                    name: name.clone(),
                    at: other.name.span,
                    first: first.name.span,
                    difference: difference.to_string(),
                });
            }
        }
        if let Some(built) = self.catalogue.schema(name)
            && let Err(difference) = schema.compare(&built)
        {
            let (at, difference) = (first.name.span, difference.to_string());
            self.report.found(TypeDiffersFromBuild {
                name: name.clone(),
                at,
                difference,
            });
        }
    }
}
