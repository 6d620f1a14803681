//! What the variables of a body stand for while it is lowered.

use super::facts;
use crate::program::Local;
use asmotion_hir::{TermKind, VarId};
use asmotion_value::RuleId;
use std::collections::BTreeSet;
use std::rc::Rc;

/// What a variable stands for.
#[derive(Clone, Debug)]
pub(super) enum VariableBinding {
    /// A local of the frame.
    Local(Local),
    /// A term passed by name.
    Term(Rc<Closed>),
    /// A location of its own: rules assign it.
    State {
        /// Holds the number of the run of the rule that binds it.
        run: Local,
        /// The number of the variable.
        index: u32,
    },
}

/// A term passed by name, with what its variables stand for.
#[derive(Debug)]
pub(super) struct Closed {
    pub term: asmotion_hir::Term,
    pub bindings: Vec<Option<VariableBinding>>,
    /// Equal keys, equal terms.
    pub key: String,
}

/// The variables of a body while it is lowered.
#[derive(Debug)]
pub(super) struct LoweringFrame {
    bindings: Vec<Option<VariableBinding>>,
    /// How many locals are in use.
    pub locals: u32,
    /// The rule whose variables these are.
    pub rule: Option<RuleId>,
}

impl LoweringFrame {
    /// A frame without variables, for the body of a rule.
    pub fn of_rule(rule: RuleId) -> Self {
        Self {
            bindings: Vec::new(),
            locals: 0,
            rule: Some(rule),
        }
    }

    /// A frame whose first variables are its arguments.
    pub fn of(arguments: usize, variables: usize) -> Self {
        let bindings = (0..variables)
            .map(|index| (index < arguments).then_some(VariableBinding::Local(index as Local)))
            .collect();
        Self {
            bindings,
            locals: arguments as u32,
            rule: None,
        }
    }

    pub fn binding(&self, variable: VarId) -> Option<VariableBinding> {
        self.bindings.get(variable.0 as usize).cloned().flatten()
    }

    /// A local without a variable.
    pub fn fresh(&mut self) -> Local {
        self.locals += 1;
        self.locals - 1
    }

    /// Gives a variable a local.
    pub fn bind(&mut self, variable: VarId) -> Local {
        let local = self.fresh();
        self.set(variable, VariableBinding::Local(local));
        local
    }

    /// Says what a variable stands for.
    pub fn set(&mut self, variable: VarId, binding: VariableBinding) {
        let index = variable.0 as usize;
        if self.bindings.len() <= index {
            self.bindings.resize(index + 1, None);
        }
        self.bindings[index] = Some(binding);
    }

    /// What all variables stand for.
    pub fn bindings(&self) -> &[Option<VariableBinding>] {
        &self.bindings
    }

    /// Works with the variables of a term passed by name, in this frame.
    pub fn within<T>(&mut self, closed: &Closed, work: impl FnOnce(&mut Self) -> T) -> T {
        let outer = std::mem::replace(&mut self.bindings, closed.bindings.clone());
        let result = work(self);
        self.bindings = outer;
        result
    }
}

/// Closes a term over the locals its variables stand for: they become further arguments of the
/// macro, numbered from `base` on.
pub(super) fn close(
    term: &asmotion_hir::Term,
    bindings: &[Option<VariableBinding>],
    extras: &mut Vec<Local>,
    base: u32,
) -> Closed {
    let mut variables = BTreeSet::new();
    facts::visit(term, &mut |term| {
        if let TermKind::Variable(variable) = &*term.kind {
            variables.insert(variable.0 as usize);
        }
    });
    let mut closed: Vec<Option<VariableBinding>> = vec![None; bindings.len()];
    let mut key = format!("{:?}", term.span);
    for index in variables {
        let Some(Some(binding)) = bindings.get(index) else {
            continue;
        };
        let rebound = match binding {
            VariableBinding::Local(local) => {
                extras.push(*local);
                let local = base + extras.len() as u32 - 1;
                key.push_str(&format!(" {index}={local}"));
                VariableBinding::Local(local)
            }
            VariableBinding::State {
                run,
                index: variable,
            } => {
                extras.push(*run);
                let run = base + extras.len() as u32 - 1;
                key.push_str(&format!(" {index}={run}.{variable}"));
                VariableBinding::State {
                    run,
                    index: *variable,
                }
            }
            VariableBinding::Term(inner) => {
                let inner = close(&inner.term, &inner.bindings, extras, base);
                key.push_str(&format!(" {index}=({})", inner.key));
                VariableBinding::Term(Rc::new(inner))
            }
        };
        closed[index] = Some(rebound);
    }
    Closed {
        term: term.clone(),
        bindings: closed,
        key,
    }
}
