//! The first step of a specification before any message has arrived, for the check of a composite.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_diagnostics::Span;
use asmotion_lang::hir::Model;
use asmotion_lang::ir::{FunctionId, Program, ValueShape};
use asmotion_lang::value::{Atom, Value};
use asmotion_lang::{Environment, FaultKind, FirstChoice, Machine, StepFault};

use crate::signature::StartValue;

/// Bound functions that are undef, by name, and what needs their values.
pub(crate) type Undefined = Vec<(String, Span)>;

/// A specification in executable form.
pub(crate) struct Executable {
    pub program: Arc<Program>,
    /// The place of each origin, by its number.
    pub origins: Vec<Span>,
}

impl Executable {
    /// Makes the first step with these values of bound functions. If it fails because a guard or an invariant is undef, returns
    /// the functions that are undef and without which it would take another course.
    pub(crate) fn undefined_at_start(
        &self,
        model: &Model,
        values: &BTreeMap<String, StartValue>,
    ) -> Undefined {
        let mut inputs = BTreeMap::new();
        let mut undefined = Vec::new();
        for (id, function) in model.own_functions() {
            let Some(given) = values.get(&*function.name) else {
                continue;
            };
            let id = FunctionId(id.0);
            if *given == StartValue::Undef {
                undefined.push((id, function.name.to_string()));
            }
            inputs.insert(id, value(given, model));
        }
        if undefined.is_empty() {
            return Vec::new();
        }
        let Some(fault) = self.first_fault(&inputs) else {
            return Vec::new();
        };
        let is_undef = |value: &Value| *value == Value::Undef;
        let is_guard = matches!(fault.kind, FaultKind::UndefinedGuard);
        let is_invariant =
            matches!(&fault.kind, FaultKind::Invariant { value, .. } if is_undef(value));
        let Some(needed) = self.origins.get(fault.origin.0 as usize) else {
            return Vec::new();
        };
        if !(is_guard || is_invariant) {
            return Vec::new();
        }
        // does the step take another course with values of these functions?
        let matters = |given: &[&(FunctionId, String)]| {
            let mut inputs = inputs.clone();
            for (id, _) in given {
                inputs.extend(self.any_value(*id).map(|value| (*id, value)));
            }
            let other = self.first_fault(&inputs);
            other.is_none_or(|other| other.origin != fault.origin)
        };
        let mut needs: Vec<_> = undefined.iter().filter(|it| matters(&[it])).collect();
        if needs.is_empty() {
            needs = undefined.iter().collect();
            if !matters(&needs) {
                return Vec::new();
            }
        }
        let named = needs.into_iter().map(|(_, name)| (name.clone(), *needed));
        named.collect()
    }

    fn first_fault(&self, inputs: &BTreeMap<FunctionId, Value>) -> Option<Box<StepFault>> {
        let mut machine = Machine::new(Arc::clone(&self.program)).ok()?;
        let mut environment = StartInputs(inputs);
        machine.step(&mut environment, &mut FirstChoice, 0).err()
    }

    /// A value of a function's codomain; `None` unless it is simple.
    fn any_value(&self, function: FunctionId) -> Option<Value> {
        let declared = self.program.functions.get(function.0 as usize)?;
        if declared.codomain == ValueShape::Bool {
            return Some(Value::Bool(false));
        }
        let elements = self.program.named_elements(&declared.codomain)?;
        elements.into_iter().next().map(|(_, value)| value)
    }
}

fn value(given: &StartValue, model: &Model) -> Value {
    match given {
        StartValue::Undef => Value::Undef,
        StartValue::Bool(value) => Value::Bool(*value),
        StartValue::Int(value) => Value::Int(*value),
        StartValue::Text(text) => {
            let mut atoms = (0..).map(Atom).zip(&model.atoms);
            let found = atoms.find(|(_, atom)| *atom.name == **text);
            found.map_or_else(|| Value::text(text), |(atom, _)| Value::Atom(atom))
        }
    }
}

/// The values of bound functions, for all arguments.
struct StartInputs<'i>(&'i BTreeMap<FunctionId, Value>);

impl Environment for StartInputs<'_> {
    fn read(&mut self, function: FunctionId, _: &[Value]) -> Result<Option<Value>, String> {
        Ok(self.0.get(&function).cloned())
    }
}
