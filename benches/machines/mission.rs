//! Inputs of an endless mission, generated at almost no cost.

use asmotion_lang::value::{Atom, Value};
use asmotion_lang::{Environment, Machine, ir};
use std::sync::Arc;

/// A sequence of events, with occasional goals, cancellations and emergency stops.
pub struct Mission {
    program: Arc<ir::Program>,
    reads: u32,
}

impl Mission {
    /// Creates the inputs for this machine.
    pub fn of(machine: &Machine) -> Self {
        Self {
            program: machine.program().clone(),
            reads: 0,
        }
    }
}

impl Environment for Mission {
    fn read(
        &mut self,
        function: ir::FunctionId,
        _arguments: &[Value],
    ) -> Result<Option<Value>, String> {
        self.reads = self.reads.wrapping_add(1);
        Ok(Some(
            match self.program.functions[function.0 as usize].codomain {
                ir::ValueShape::Bool => Value::Bool(self.reads.is_multiple_of(37)),
                ir::ValueShape::Domain(domain) => {
                    match self.program.domains[domain.0 as usize].elements {
                        ir::DomainElements::Atoms { first, count } => {
                            Value::Atom(Atom(first.0 + self.reads / 4 * 3 % count))
                        }
                        ir::DomainElements::Ints { .. }
                        | ir::DomainElements::Computed(_)
                        | ir::DomainElements::Undefined
                        | ir::DomainElements::Open => Value::Undef,
                    }
                }
                ir::ValueShape::Int
                | ir::ValueShape::Natural
                | ir::ValueShape::Real
                | ir::ValueShape::Char
                | ir::ValueShape::Text
                | ir::ValueShape::Complex
                | ir::ValueShape::Rule
                | ir::ValueShape::Tuple(_)
                | ir::ValueShape::Seq(_)
                | ir::ValueShape::Set(_)
                | ir::ValueShape::Bag(_)
                | ir::ValueShape::Map(..)
                | ir::ValueShape::Any => Value::Undef,
            },
        ))
    }
}
