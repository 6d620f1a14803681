//! Inputs that lead from a given state into a set, so that a machine finds a step without trying all of them.

use crate::bdd::Bdd;
use crate::encoding::{Code, InputCode};
use crate::error::SymbolicError;
use crate::model::{NodeSet, SymbolicModel};
use crate::query::SymbolicFault;
use asmotion_lang::Value;
use asmotion_lang::ir::{FunctionId, Slot};

/// The value of an input location.
#[derive(Clone, Debug)]
pub struct SymbolicInput {
    /// The monitored function.
    pub function: FunctionId,
    /// Arguments of the function.
    pub arguments: Vec<Value>,
    /// Value that the environment gives the location.
    pub value: Value,
}

impl SymbolicModel<'_> {
    /// Returns the set of a state's nodes; `value` is the state.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn nodes_of_state(&self, value: &dyn Fn(Slot) -> Value) -> Result<NodeSet, SymbolicError> {
        let mut all = self.store.always();
        // from the last variables on, so that each is added before those that are known
        for (slot, code) in self.slots.iter().rev() {
            all = match code.is(&value(*slot)) {
                Some(is) => self.store.and(is, &all)?,
                None => self.store.never(),
            };
        }
        Ok(NodeSet(all))
    }

    /// Returns the first of the nodes in a set as a set of its own, with the inputs that its conditions read. `None` if the set is empty.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn first_node(
        &self,
        of: &NodeSet,
    ) -> Result<Option<(NodeSet, Vec<SymbolicInput>)>, SymbolicError> {
        let found = self.first_inputs(&of.0, |input| input.known.as_ref())?;
        Ok(found.map(|(set, inputs)| (NodeSet(set), inputs)))
    }

    /// Returns the first inputs of a step from a node to a node of another set. `None` if no step leads there.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn step_inputs(
        &self,
        from: &NodeSet,
        to: &NodeSet,
    ) -> Result<Option<Vec<SymbolicInput>>, SymbolicError> {
        let states = self.states_of(&to.0)?;
        for moves in &self.moves {
            let cases = moves.between(&self.store, &from.0, &states)?;
            if let Some((_, inputs)) = self.first_inputs(&cases, |input| input.free.as_ref())? {
                return Ok(Some(inputs));
            }
        }
        Ok(None)
    }

    /// Returns the first inputs with which a step from a node has a fault. `None` if it has none.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn failing_inputs(
        &self,
        from: &NodeSet,
        fault: &SymbolicFault,
    ) -> Result<Option<Vec<SymbolicInput>>, SymbolicError> {
        let cases = self.store.and(&from.0, &fault.cases)?;
        let found = self.first_inputs(&cases, |input| input.free.as_ref())?;
        Ok(found.map(|(_, inputs)| inputs))
    }

    /// Returns the part of a set with the first possible value of each input, and these values.
    fn first_inputs(
        &self,
        set: &Bdd,
        code: fn(&InputCode) -> Option<&Code>,
    ) -> Result<Option<(Bdd, Vec<SymbolicInput>)>, SymbolicError> {
        if set.is_never() {
            return Ok(None);
        }
        let mut set = set.clone();
        let mut found = Vec::new();
        for ((function, arguments), input) in self.inputs.named() {
            let Some(code) = code(input) else { continue };
            for (index, guard) in code.values.iter().enumerate() {
                let part = self.store.and(&set, guard)?;
                if part.is_never() {
                    continue;
                }
                set = part;
                // the code after the last value stands for an input that is not read
                found.extend(input.values.get(index).map(|value| SymbolicInput {
                    function: *function,
                    arguments: arguments.clone(),
                    value: value.clone(),
                }));
                break;
            }
        }
        Ok(Some((set, found)))
    }
}
