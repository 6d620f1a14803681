//! The inputs of a step: the values of all bound locations, fixed before the step begins.

use asmotion_component::prefetch;
use asmotion_lang::Environment;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate;
use asmotion_lang::value::Value;
use std::collections::BTreeSet;

/// The inputs of one step.
#[derive(Debug, Default)]
pub(crate) struct InputFrame {
    /// The bound locations, ascending, with their positions in `values`. In one list: most specifications have a few, and every
    /// step looks them up.
    positions: Vec<(FunctionId, Vec<Value>, usize)>,
    /// `None` until the inputs are fixed for the first time.
    values: Vec<Option<Value>>,
    /// The function of each location.
    functions: Vec<FunctionId>,
    /// Functions of which a location has another value than at the last call of `take_changed`.
    changed: BTreeSet<FunctionId>,
}

impl InputFrame {
    /// Adds a location and returns its position; `None` if it is bound already.
    pub fn bind(&mut self, function: FunctionId, arguments: Vec<Value>) -> Option<usize> {
        let position = self.values.len();
        let Err(place) = self.find(function, &arguments) else {
            return None;
        };
        self.positions
            .insert(place, (function, arguments, position));
        self.values.push(None);
        self.functions.push(function);
        Some(position)
    }

    /// Position of a bound location.
    pub fn position(&self, function: FunctionId, arguments: &[Value]) -> Option<usize> {
        let place = self.find(function, arguments).ok()?;
        self.positions.get(place).map(|(.., position)| *position)
    }

    /// Place of a location in `positions`, or that at which it can be inserted.
    fn find(&self, function: FunctionId, arguments: &[Value]) -> Result<usize, usize> {
        self.positions
            .binary_search_by(|(known, of, _)| (*known, of.as_slice()).cmp(&(function, arguments)))
    }

    /// Prefetches the lists.
    pub fn prefetch(&self) {
        prefetch(&*self.positions);
        prefetch(&*self.values);
        prefetch(&*self.functions);
    }

    /// The values of all bound locations, by position; `None` until the inputs are fixed for the first time.
    pub fn values(&self) -> &[Option<Value>] {
        &self.values
    }

    /// Names of the bound locations, by position.
    pub fn names(&self, machine: &Machine) -> Vec<String> {
        let mut names = vec![String::new(); self.values.len()];
        for (function, arguments, position) in &self.positions {
            if let Some(name) = names.get_mut(*position) {
                *name = simulate::applied(machine, *function, arguments);
            }
        }
        names
    }

    pub fn clear(&mut self) {
        self.values.fill(None);
        self.changed.extend(&self.functions);
    }

    /// Returns the functions of which a location has another value than at the last call.
    pub fn take_changed(&mut self) -> BTreeSet<FunctionId> {
        std::mem::take(&mut self.changed)
    }

    /// Sets the value of the location at this position.
    pub fn set(&mut self, position: usize, value: Value) {
        let Some(known) = self.values.get_mut(position) else {
            return;
        };
        if known.as_ref() != Some(&value) {
            self.changed.extend(self.functions.get(position));
            *known = Some(value);
        }
    }
}

impl Environment for InputFrame {
    /// A location without binding is undef.
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        let position = self.position(function, arguments);
        Ok(position.and_then(|position| self.values.get(position)?.clone()))
    }

    fn source(&self, _function: FunctionId, _arguments: &[Value]) -> String {
        "what the composite binds to it".to_owned()
    }
}
