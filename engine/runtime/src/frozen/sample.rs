//! Samples of statically unknown type.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_component::Declaration;
use asmotion_datum::{Datum, DatumError, Sample, Schema};
use serde::{Deserialize, Serialize};

use super::{SystemThawError, system_mismatch};

/// A sample as data, with the name of its type, which appears in traces.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FrozenSample {
    /// Name of the message type; empty for a datum.
    type_name: String,
    value: Datum,
}

/// A thawed sample: a datum that keeps the name of its original type.
#[derive(Debug, Clone)]
struct NamedDatum {
    name: &'static str,
    value: Datum,
}

/// Names of the message types declared by the components of a system.
pub(crate) struct SampleNames(BTreeMap<String, &'static str>);

impl SampleNames {
    /// Collects the type names from declarations.
    pub(crate) fn of<'d>(declarations: impl IntoIterator<Item = &'d Declaration>) -> Self {
        let mut names = BTreeMap::from([(String::new(), "")]);
        for declaration in declarations {
            let ports = declaration.inputs.iter().chain(&declaration.outputs);
            let services = declaration.services.iter().map(|of| &of.operations);
            let references = declaration.references.iter().map(|of| &of.operations);
            let operations = services.chain(references).flatten();
            let schemas = operations.flat_map(|of| [&of.request, &of.response]);
            for schema in ports.map(|port| &port.schema).chain(schemas) {
                if let Schema {
                    name: Cow::Borrowed(name),
                    ..
                } = schema
                {
                    names.insert((*name).to_owned(), *name);
                }
            }
        }
        Self(names)
    }
}

impl FrozenSample {
    pub(crate) fn of(sample: &dyn Sample) -> Result<Self, DatumError> {
        Ok(Self {
            type_name: sample.type_name().to_owned(),
            value: sample.to_datum()?,
        })
    }

    pub(crate) fn thaw(&self, names: &SampleNames) -> Result<Arc<dyn Sample>, SystemThawError> {
        let name = names.0.get(&self.type_name);
        let name = *name.ok_or_else(|| {
            system_mismatch(format!("it has no messages of type `{}`", self.type_name))
        })?;
        let value = self.value.clone();
        Ok(match name {
            "" => Arc::new(value),
            name => Arc::new(NamedDatum { name, value }),
        })
    }
}

impl Sample for NamedDatum {
    fn type_name(&self) -> &'static str {
        self.name
    }

    fn to_datum(&self) -> Result<Datum, DatumError> {
        Ok(self.value.clone())
    }

    fn to_shared(&self) -> Arc<dyn Sample> {
        Arc::new(self.clone())
    }

    fn pointee(&self) -> Option<Arc<dyn Sample>> {
        None
    }
}
