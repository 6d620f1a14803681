//! Dependencies of a term: inputs, or locations that rules update.

use asmotion_lang::hir::{FunctionId, FunctionKind, Meaning, Model, Term};
use std::collections::BTreeSet;

/// Inputs, by the machines that read them.
pub(crate) type InputFunctions = BTreeSet<(usize, FunctionId)>;

/// The kinds of functions that a term depends on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Reads {
    /// Monitored functions.
    pub inputs: bool,
    /// The monitored and shared functions that no other machine updates.
    pub input_functions: BTreeSet<FunctionId>,
    /// Functions that rules update.
    pub state: bool,
}

impl Reads {
    /// Examines a term. `provided` are monitored functions that another machine updates.
    pub fn of(model: &Model, term: &Term, provided: &BTreeSet<FunctionId>) -> Self {
        let mut reads = Self::default();
        reads.add(model, term, provided, &mut BTreeSet::new());
        reads
    }

    fn add(
        &mut self,
        model: &Model,
        term: &Term,
        provided: &BTreeSet<FunctionId>,
        seen: &mut BTreeSet<FunctionId>,
    ) {
        let mut applied = Vec::new();
        asmotion_lang::ir::visit_terms(term, &mut |part| applied.extend(part.kind.function()));
        for id in applied {
            let Some(function) = model.functions.get(id.0 as usize) else {
                continue;
            };
            match function.kind {
                FunctionKind::Monitored if provided.contains(&id) => self.state = true,
                FunctionKind::Monitored => {
                    self.inputs = true;
                    self.input_functions.insert(id);
                }
                FunctionKind::Shared => {
                    (self.inputs, self.state) = (true, true);
                    self.input_functions.insert(id);
                }
                FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Local => {
                    self.state = true;
                }
                FunctionKind::Static | FunctionKind::Derived => {}
            }
            if let Meaning::Defined(body) = &function.meaning
                && seen.insert(id)
            {
                self.add(model, &body.root, provided, seen);
            }
        }
    }
}
