//! Bindings of variables while a body is lowered.

use super::facts;
use crate::id::Local;
use asmotion_hir::{TermKind, VarId};
use asmotion_value::RuleId;
use std::collections::BTreeSet;
use std::rc::Rc;

/// The replacement of a variable in lowered code.
#[derive(Clone, Debug)]
pub(super) enum VariableBinding {
    /// A local of the frame.
    Local(Local),
    /// A term passed by name.
    Term(Rc<Closed>),
    /// A location, because rules assign the variable.
    State {
        /// The local that holds the number of the run of the binding rule.
        run: Local,
        /// The variable's number within the rule.
        index: u32,
    },
}

/// A term passed by name, with the bindings of its free variables.
#[derive(Debug)]
pub(super) struct Closed {
    pub term: asmotion_hir::Term,
    pub bindings: Vec<Option<VariableBinding>>,
    /// Canonical text; closed terms with equal keys are equal.
    pub key: String,
}

/// The variables of a body and the size of its frame, during lowering.
#[derive(Debug)]
pub(super) struct LoweringFrame {
    bindings: Vec<Option<VariableBinding>>,
    /// Number of locals allocated so far.
    pub locals: u32,
    /// The rule that is being lowered; `None` for other bodies.
    pub rule: Option<RuleId>,
}

impl LoweringFrame {
    /// Creates an empty frame for the body of a rule.
    pub fn of_rule(rule: RuleId) -> Self {
        Self {
            bindings: Vec::new(),
            locals: 0,
            rule: Some(rule),
        }
    }

    /// Creates a frame whose first variables are the arguments.
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

    /// Allocates a local that belongs to no variable.
    pub fn fresh(&mut self) -> Local {
        self.locals += 1;
        self.locals - 1
    }

    /// Allocates a local for a variable.
    pub fn bind(&mut self, variable: VarId) -> Local {
        let local = self.fresh();
        self.set(variable, VariableBinding::Local(local));
        local
    }

    /// Sets the replacement of a variable.
    pub fn set(&mut self, variable: VarId, binding: VariableBinding) {
        let index = variable.0 as usize;
        if self.bindings.len() <= index {
            self.bindings.resize(index + 1, None);
        }
        self.bindings[index] = Some(binding);
    }

    /// Returns the replacements of all variables, indexed by variable.
    pub fn bindings(&self) -> &[Option<VariableBinding>] {
        &self.bindings
    }

    /// Runs `work` with the bindings of a by-name term in place of those of this frame.
    pub fn within<T>(&mut self, closed: &Closed, work: impl FnOnce(&mut Self) -> T) -> T {
        let outer = std::mem::replace(&mut self.bindings, closed.bindings.clone());
        let result = work(self);
        self.bindings = outer;
        result
    }
}

/// Closes a term over the locals of its free variables. Those become additional arguments of the
/// macro, numbered from `base`.
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
