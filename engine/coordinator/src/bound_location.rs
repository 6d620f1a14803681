//! Bound locations, resolved to ids and values.

use crate::bind_error::BindError;
use crate::location::{LocationArgument, LocationName};
use asmotion_lang::Specification;
use asmotion_lang::ir::{FunctionId, Program, ValueShape};
use asmotion_lang::value::Value;

/// The locations that one binding covers: a single one, or one for each combination of the elements that its key
/// selects.
pub(crate) struct BoundLocations {
    pub function: FunctionId,
    pub codomain: ValueShape,
    arguments: Vec<BoundArgument>,
    pub key: Vec<KeyField>,
}

enum BoundArgument {
    Element(Value),
    /// The element selected by the key at this position.
    Key(usize),
}

/// A field of messages that selects an element.
pub(crate) struct KeyField {
    /// Path of the field.
    pub path: String,
    pub shape: ValueShape,
    /// The elements that it can select, in ascending order.
    pub elements: Vec<Value>,
}

impl BoundLocations {
    /// Resolves a location. `key` maps variables to paths of fields.
    ///
    /// # Errors
    /// The specification has no such function or element, or a variable has neither a field nor a finite domain.
    pub fn resolve(
        name: &LocationName,
        key: &[(String, String)],
        specification: &Specification,
    ) -> Result<Self, BindError> {
        let program = &specification.program;
        let unknown = || BindError::UnknownFunction {
            function: name.function.clone(),
            arity: name.arguments.len(),
        };
        let function = specification.function(&name.function, name.arguments.len());
        let function = function.ok_or_else(unknown)?;
        let declared = program.functions.get(function.0 as usize);
        let declared = declared.ok_or_else(unknown)?;
        let mut fields = Vec::new();
        let mut arguments = Vec::new();
        for (argument, shape) in name.arguments.iter().zip(&declared.parameters) {
            arguments.push(match argument {
                LocationArgument::Element(text) => {
                    let known = element(text, shape, program);
                    BoundArgument::Element(known.ok_or_else(|| BindError::UnknownElement {
                        location: name.to_string(),
                        element: text.clone(),
                    })?)
                }
                LocationArgument::Variable(variable) => {
                    let found = key.iter().position(|(known, _)| known == variable);
                    let path = found.and_then(|at| key.get(at)).map(|(_, path)| path);
                    let elements = program.named_elements(shape);
                    let (Some(path), Some(elements)) = (path, elements) else {
                        return Err(BindError::FreeVariable {
                            location: name.to_string(),
                            variable: variable.clone(),
                        });
                    };
                    fields.push(KeyField {
                        path: path.clone(),
                        shape: shape.clone(),
                        elements: elements.into_iter().map(|(_, element)| element).collect(),
                    });
                    BoundArgument::Key(fields.len() - 1)
                }
            });
        }
        Ok(Self {
            function,
            codomain: declared.codomain.clone(),
            arguments,
            key: fields,
        })
    }

    /// The arguments of each location, with the elements that its key selects, in the order of
    /// [`position`](Self::position).
    pub fn all(&self) -> Vec<BoundLocation> {
        let mut selected: Vec<Vec<Value>> = vec![Vec::new()];
        for field in &self.key {
            let longer = |elements: &Vec<Value>| {
                let elements = elements.clone();
                let extended = field.elements.iter();
                extended.map(move |element| {
                    [elements.as_slice(), std::slice::from_ref(element)].concat()
                })
            };
            selected = selected.iter().flat_map(longer).collect();
        }
        let located = selected.into_iter().map(|elements| BoundLocation {
            arguments: self.arguments_for(&elements),
            elements,
        });
        located.collect()
    }

    /// Position, among all locations, of the one whose key has these elements; `None` if one is not of its domain.
    pub fn position(&self, elements: &[Value]) -> Option<usize> {
        let mut position = 0;
        for (field, element) in self.key.iter().zip(elements) {
            position *= field.elements.len();
            position += field.elements.binary_search(element).ok()?;
        }
        Some(position)
    }

    fn arguments_for(&self, elements: &[Value]) -> Vec<Value> {
        let arguments = self.arguments.iter().map(|argument| match argument {
            BoundArgument::Element(value) => value.clone(),
            BoundArgument::Key(at) => elements.get(*at).cloned().unwrap_or(Value::Undef),
        });
        arguments.collect()
    }
}

/// One of the locations that a binding covers.
pub(crate) struct BoundLocation {
    pub arguments: Vec<Value>,
    /// The elements of its key, in the order of the key's fields.
    pub elements: Vec<Value>,
}

/// The element of a domain that a text names.
fn element(text: &str, shape: &ValueShape, program: &Program) -> Option<Value> {
    if let Some(known) = program.named_elements(shape) {
        let found = known.into_iter().find(|(name, _)| name == text);
        return found.map(|(_, element)| element);
    }
    let number = text.parse().ok()?;
    let is_in = match shape {
        ValueShape::Int | ValueShape::Domain(_) => true,
        ValueShape::Natural => number >= 0,
        ValueShape::Bool
        | ValueShape::Real
        | ValueShape::Char
        | ValueShape::Text
        | ValueShape::Complex
        | ValueShape::Rule
        | ValueShape::Tuple(_)
        | ValueShape::Seq(_)
        | ValueShape::Set(_)
        | ValueShape::Bag(_)
        | ValueShape::Map(..)
        | ValueShape::Any => false,
    };
    is_in.then_some(Value::Int(number))
}
