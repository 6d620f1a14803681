//! The initial state: computed from the program, completed with the inputs of the first step.

use crate::choose::FirstChoice;
use crate::environment::{Environment, NoInputs};
use crate::fault::StepFault;
use crate::machine::Machine;
use crate::misfit::{DomainMisfit, is_listed};
use crate::run::StepContext;
use asmotion_ir::{DomainElements, DomainId, FunctionId, Initial, Origin, Program, Slot, Storage};
use asmotion_value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// An initial value outside the codomain of its function.
#[derive(Clone, Debug, PartialEq)]
pub struct InitialMisfit {
    /// Arguments of the location.
    pub arguments: Vec<Value>,
    /// The offending part of the value.
    pub misfit: DomainMisfit,
    /// Place of the initial value's definition.
    pub origin: Origin,
}

impl Machine {
    pub(crate) fn initialise(&mut self) -> Result<(), Box<StepFault>> {
        self.scratch.updates.begin(self.state.slot_count());
        self.state.initial.slots = self.state.store.slots.clone();
        let program = self.program.clone();
        for &initial in &program.initial_order {
            self.initialise_one(&program, initial, &mut NoInputs, 0)?;
        }
        self.begin_initial(0);
        self.is_complete = !program.needs_inputs();
        if !self.is_complete {
            return Ok(());
        }
        let checked = self.check_initial(&mut NoInputs, 0);
        if program.compatible {
            // in the reference, reading a location makes it part of the state
            self.state.commit();
        }
        checked
    }

    /// Completes the initial state with the inputs of the first step.
    pub(crate) fn initialise_with_inputs(
        &mut self,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        let program = self.program.clone();
        for &initial in &program.initial_inputs {
            self.initialise_one(&program, initial, environment, now_ns)?;
        }
        self.begin_initial(now_ns);
        self.is_complete = true;
        Ok(())
    }

    /// Marks the current state as the initial one: locations accessed later are initialised from
    /// it.
    fn begin_initial(&mut self, now_ns: i64) {
        self.state.initial.slots = self.state.store.slots.clone();
        self.state.initial.extents = self.state.store.extents.clone();
        self.state.initial.now_ns = now_ns;
        self.state.commit();
    }

    pub(crate) fn check_initial(
        &mut self,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        self.run(environment, &mut FirstChoice, 0, now_ns, |run| {
            let _ = run.check_invariants(false);
        })
    }

    fn initialise_one(
        &mut self,
        program: &Program,
        initial: Initial,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        match initial {
            Initial::Domain(domain) => self.initialise_domain(program, domain, environment, now_ns),
            Initial::Function(function) => {
                self.initialise_function(program, function, environment, now_ns)
            }
        }
    }

    fn initialise_domain(
        &mut self,
        program: &Program,
        domain: DomainId,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        let DomainElements::Computed(body) = program.domains[domain.0 as usize].elements else {
            return Ok(());
        };
        let elements = self.build(environment, now_ns, |run| run.call_body(body, 0))?;
        let elements: Vec<Value> = match elements {
            Value::Set(elements) => elements.iter().cloned().collect(),
            Value::Seq(elements) => {
                let mut elements = elements.to_vec();
                elements.sort();
                elements.dedup();
                elements
            }
            Value::Undef
            | Value::Bool(_)
            | Value::Int(_)
            | Value::Real(_)
            | Value::Char(_)
            | Value::Atom(_)
            | Value::Rule(_)
            | Value::Text(_)
            | Value::Complex(_)
            | Value::Tuple(_)
            | Value::Bag(_)
            | Value::Map(_) => Vec::new(),
        };
        self.state.store.extents[domain.0 as usize] = Arc::new(elements);
        Ok(())
    }

    fn initialise_function(
        &mut self,
        program: &Program,
        function: FunctionId,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        let declared = &program.functions[function.0 as usize];
        let (
            Some(body),
            Storage::Dense {
                base,
                count,
                lazy: false,
                ..
            },
        ) = (declared.initial, &declared.storage)
        else {
            return Ok(());
        };
        for slot in *base..base + count {
            let arguments = self
                .state
                .location(program, slot)
                .map(|(_, arguments)| arguments);
            let value = self.build(environment, now_ns, |run| {
                run.locals.extend(arguments.into_iter().flatten());
                run.call_body(body, 0)
            })?;
            self.state.store.slots[slot as usize] = value;
        }
        Ok(())
    }

    /// Runs `work` in the context of the initial state.
    fn build<T>(
        &mut self,
        environment: &mut dyn Environment,
        now_ns: i64,
        work: impl FnOnce(&mut StepContext<'_>) -> T,
    ) -> Result<T, Box<StepFault>> {
        self.run(environment, &mut FirstChoice, 0, now_ns, |run| {
            run.building = true;
            work(run)
        })
    }

    /// Returns the initial values outside the codomain of their functions, at most one for each
    /// function. They are not faults: the reference does not check them, and existing specifications
    /// rely on that.
    pub fn initial_misfits(&self) -> Vec<InitialMisfit> {
        let mut found: BTreeMap<FunctionId, InitialMisfit> = BTreeMap::new();
        for slot in 0..self.state.slot_count() as Slot {
            let function = self.state.function(&self.program, slot);
            if let Some(function) = function.filter(|function| !found.contains_key(function)) {
                let misfit = self.initial_misfit(slot, function);
                found.extend(misfit.map(|misfit| (function, misfit)));
            }
        }
        found.into_values().collect()
    }

    fn initial_misfit(&self, slot: Slot, function: FunctionId) -> Option<InitialMisfit> {
        let (program, state) = (&*self.program, &self.state);
        let body = program.functions[function.0 as usize].initial?;
        // before the first step, domains that depend on inputs are not known; values that do are undef
        let is_open =
            |domain| !self.is_complete && program.initial_inputs.contains(&Initial::Domain(domain));
        let is_element = |domain: DomainId, value: &Value| {
            is_open(domain) || is_listed(program, &state.initial.extents, domain, value)
        };
        let value = state.get_initial(slot);
        let misfit = DomainMisfit::of_value(program, function, value, &is_element)?;
        let (_, arguments) = state.location(program, slot)?;
        Some(InitialMisfit {
            arguments,
            misfit,
            origin: program.bodies[body.0 as usize].code.origin,
        })
    }
}
