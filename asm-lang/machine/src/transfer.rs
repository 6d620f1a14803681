//! Transfer of a state to a machine of another program, for a specification that replaces a running one.
//!
//! Functions, domains, elements and rules correspond if they have the same names and signatures. A location keeps its
//! value if its function and its arguments have a counterpart; all others have the initial values of the new program.

use crate::choose::FirstChoice;
use crate::environment::{Environment, NoInputs};
use crate::fault::StepFault;
use crate::machine::Machine;
use crate::run::CodomainCheck;
use asmotion_ir::{DomainId, Function, FunctionId, FunctionKind, Origin, Program, ValueShape};
use asmotion_value::{Atom, RuleId, Value};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The functions and elements of a program that have a counterpart in another program.
#[derive(Clone, Debug)]
pub struct Correspondence {
    domains: Vec<Option<DomainId>>,
    functions: Vec<Option<FunctionId>>,
    /// Declared atoms, then those created from the reserve.
    atoms: Vec<Option<Atom>>,
    rules: Vec<Option<RuleId>>,
}

/// The reason that a machine cannot continue in the state of another one.
#[derive(Clone, Debug, PartialEq)]
pub enum TransferError {
    /// A location, given in terms of the other machine, has a value without a counterpart.
    Value {
        /// The function of the location.
        function: FunctionId,
        /// The arguments of the location.
        arguments: Vec<Value>,
        /// The value.
        value: Value,
    },
    /// A message on its way contains an element without a counterpart.
    Message,
    /// A value is outside the codomain of its function, or an initial value cannot be computed.
    Fault(Box<StepFault>),
}

/// A location of the new program, and the value that it keeps.
type KeptLocation = (FunctionId, Vec<Value>, Value);

impl Machine {
    /// Creates the elements that a machine of another program has created by `extend`, and returns the counterparts of
    /// its functions and elements.
    pub fn adopt_elements(&mut self, other: &Machine) -> Correspondence {
        let mut correspondence = Correspondence::between(&other.program, &self.program);
        self.adopt_reserve(other, &mut correspondence);
        correspondence
    }

    /// Continues in the state of a machine of another program, whose elements this machine has
    /// [adopted](Self::adopt_elements): with its locations, messages and number of steps. A machine that has made no step
    /// passes nothing on. The environment supplies the inputs that initial values depend on. Invariants are not checked;
    /// see [`Machine::check_invariants`].
    ///
    /// # Errors
    /// A value or a message has no counterpart, or does not fit; this machine is unchanged.
    pub fn continue_from(
        &mut self,
        other: &Machine,
        correspondence: &Correspondence,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<(), TransferError> {
        if other.steps == 0 {
            return Ok(());
        }
        let mut next = self.clone();
        if !next.is_complete {
            next.rounds += 1;
            let complete = next.initialise_with_inputs(environment, now_ns);
            complete.map_err(TransferError::Fault)?;
        }
        let kept = other.kept_locations(correspondence)?;
        next.set_locations(kept).map_err(TransferError::Fault)?;
        let translate = |value: &Value| correspondence.value(value);
        let messages = other.messages.translated(&next.messages, &translate);
        next.messages = messages.ok_or(TransferError::Message)?;
        next.steps = other.steps;
        next.forget_last_step();
        next.changed_outside();
        *self = next;
        Ok(())
    }

    /// Creates the elements that the other machine has created.
    fn adopt_reserve(&mut self, other: &Machine, correspondence: &mut Correspondence) {
        let declared = self.program.atom_domains.len();
        for (domain, number) in &other.state.store.reserve {
            let domain = correspondence.domain(*domain);
            let domain = domain.filter(|it| self.program.domains[it.0 as usize].grows);
            let atom = domain.map(|domain| {
                let created = (domain, *number);
                let reserve = &mut self.state.store.reserve;
                if let Some(known) = reserve.iter().position(|known| *known == created) {
                    return Atom((declared + known) as u32);
                }
                reserve.push(created);
                let atom = Atom((declared + reserve.len() - 1) as u32);
                for &domain in &self.code.supers[domain.0 as usize] {
                    let extent = &mut self.state.store.extents[domain.0 as usize];
                    Arc::make_mut(extent).push(Value::Atom(atom));
                }
                atom
            });
            correspondence.atoms.push(atom);
        }
    }

    /// The locations whose functions and arguments have counterparts, in terms of the other program.
    fn kept_locations(
        &self,
        correspondence: &Correspondence,
    ) -> Result<Vec<KeptLocation>, TransferError> {
        let mut kept = Vec::new();
        for slot in self.state.slots() {
            let Some((function, arguments)) = self.state.location(&self.program, slot) else {
                continue;
            };
            let own = &self.program.functions[function.0 as usize];
            let (true, Some(counterpart)) = (is_written(own), correspondence.function(function))
            else {
                continue;
            };
            let mapped = arguments.iter().map(|it| correspondence.value(it));
            let Some(mapped) = mapped.collect::<Option<Vec<_>>>() else {
                continue;
            };
            let value = self.state.get(slot);
            match correspondence.value(value) {
                Some(value) => kept.push((counterpart, mapped, value)),
                None => {
                    return Err(TransferError::Value {
                        function,
                        arguments,
                        value: value.clone(),
                    });
                }
            }
        }
        Ok(kept)
    }

    /// Sets the values of locations. Locations with an argument outside its domain are left out.
    fn set_locations(&mut self, all: Vec<KeptLocation>) -> Result<(), Box<StepFault>> {
        self.scratch.updates.begin(self.state.slot_count());
        let step = self.steps;
        self.run(&mut NoInputs, &mut FirstChoice, step, 0, |run| {
            for (function, arguments, value) in all {
                run.stack.clear();
                run.stack.extend(arguments);
                if run.misplaced(function, 0).is_some() {
                    continue;
                }
                let slot = run.slot(function, 0);
                let codomain = CodomainCheck::of(run.program, function);
                // the context records a misfit as a fault
                if run
                    .accepts(slot, &value, codomain, Origin::default())
                    .is_err()
                {
                    return;
                }
                run.state.store.slots[slot as usize] = value;
            }
            run.stack.clear();
        })?;
        self.state.commit();
        Ok(())
    }
}

impl Correspondence {
    /// Finds the counterparts of a program's domains, declared elements, functions and rules.
    fn between(from: &Program, to: &Program) -> Self {
        let domains = counterparts(&from.symbols.domains, &to.symbols.domains);
        let mut correspondence = Self {
            domains: domains
                .into_iter()
                .map(|it| it.map(|it| DomainId(it as u32)))
                .collect(),
            functions: Vec::new(),
            atoms: Vec::new(),
            rules: rules(from, to),
        };
        correspondence.atoms = correspondence.declared_atoms(from, to);
        correspondence.functions = correspondence.functions(from, to);
        correspondence
    }

    /// Returns the counterpart of a function; `None` if there is none with its name and signature.
    pub fn function(&self, function: FunctionId) -> Option<FunctionId> {
        self.functions.get(function.0 as usize).copied()?
    }

    /// Returns the value that has the counterparts of its elements and rules.
    pub fn value(&self, value: &Value) -> Option<Value> {
        let all = |values: &[Value]| {
            let values = values.iter().map(|it| self.value(it));
            values.collect::<Option<Vec<Value>>>()
        };
        match value {
            Value::Undef
            | Value::Bool(_)
            | Value::Int(_)
            | Value::Real(_)
            | Value::Char(_)
            | Value::Text(_)
            | Value::Complex(_) => Some(value.clone()),
            Value::Atom(atom) => Some(Value::Atom(*self.atoms.get(atom.0 as usize)?.as_ref()?)),
            Value::Rule(rule) => Some(Value::Rule(*self.rules.get(rule.0 as usize)?.as_ref()?)),
            Value::Tuple(items) => Some(Value::tuple(all(items)?)),
            Value::Seq(items) => Some(Value::seq(all(items)?)),
            Value::Set(items) => {
                let items = items.iter().map(|it| self.value(it));
                Some(Value::set(items.collect::<Option<Vec<_>>>()?))
            }
            Value::Bag(items) => {
                let items = items.iter();
                let items = items.map(|(it, count)| Some((self.value(it)?, *count)));
                Some(Value::Bag(Arc::new(items.collect::<Option<_>>()?)))
            }
            Value::Map(pairs) => {
                let pairs = pairs.iter();
                let pairs = pairs.map(|(key, value)| Some((self.value(key)?, self.value(value)?)));
                Some(Value::map(pairs.collect::<Option<Vec<_>>>()?))
            }
        }
    }

    fn domain(&self, domain: DomainId) -> Option<DomainId> {
        self.domains.get(domain.0 as usize).copied()?
    }

    fn declared_atoms(&self, from: &Program, to: &Program) -> Vec<Option<Atom>> {
        let declared = |program: &Program| {
            let names = program.symbols.atoms.iter().cloned();
            let atoms = program.atom_domains.iter().copied().zip(names);
            atoms.collect::<Vec<_>>()
        };
        let known = declared(to).into_iter().enumerate();
        let known: BTreeMap<_, _> = known.map(|(index, atom)| (atom, index)).collect();
        let counterpart = |(domain, name)| {
            let index = known.get(&(self.domain(domain)?, name))?;
            Some(Atom(*index as u32))
        };
        declared(from).into_iter().map(counterpart).collect()
    }

    fn functions(&self, from: &Program, to: &Program) -> Vec<Option<FunctionId>> {
        let mut known: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (index, name) in to.symbols.functions.iter().enumerate() {
            known.entry(name).or_default().push(index);
        }
        let all = from.functions.iter().zip(&from.symbols.functions);
        let counterpart = |(function, name): (&Function, &Arc<str>)| {
            let mut candidates = known.get(&**name)?.iter();
            let found = candidates.find(|index| {
                let candidate = to.functions.get(**index);
                candidate.is_some_and(|candidate| self.has_signature(function, candidate))
            });
            Some(FunctionId(*found? as u32))
        };
        all.map(counterpart).collect()
    }

    /// Returns whether a function of the new program has the kind and the signature of one of the old program.
    fn has_signature(&self, old: &Function, new: &Function) -> bool {
        let parameters = old.parameters.iter().map(|it| self.shape(it));
        is_written(old) == is_written(new)
            && (old.kind == FunctionKind::Monitored) == (new.kind == FunctionKind::Monitored)
            && parameters.eq(new.parameters.iter().cloned().map(Some))
            && self.shape(&old.codomain).as_ref() == Some(&new.codomain)
    }

    /// The shape with the counterparts of its domains.
    fn shape(&self, shape: &ValueShape) -> Option<ValueShape> {
        let boxed = |shape: &ValueShape| self.shape(shape).map(Into::into);
        match shape {
            ValueShape::Domain(domain) => self.domain(*domain).map(ValueShape::Domain),
            ValueShape::Tuple(items) => {
                let items = items.iter().map(|it| self.shape(it));
                items.collect::<Option<_>>().map(ValueShape::Tuple)
            }
            ValueShape::Seq(item) => boxed(item).map(ValueShape::Seq),
            ValueShape::Set(item) => boxed(item).map(ValueShape::Set),
            ValueShape::Bag(item) => boxed(item).map(ValueShape::Bag),
            ValueShape::Map(key, value) => Some(ValueShape::Map(boxed(key)?, boxed(value)?)),
            ValueShape::Bool
            | ValueShape::Int
            | ValueShape::Natural
            | ValueShape::Real
            | ValueShape::Char
            | ValueShape::Text
            | ValueShape::Complex
            | ValueShape::Rule
            | ValueShape::Any => Some(shape.clone()),
        }
    }
}

/// Returns whether rules update the function's locations, which are then part of the state.
fn is_written(function: &Function) -> bool {
    match function.kind {
        FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Shared => true,
        FunctionKind::Monitored | FunctionKind::Local | FunctionKind::Fixed => false,
    }
}

/// The position of each name in the other list; the first one if it occurs several times.
fn counterparts<N: Ord>(from: &[N], to: &[N]) -> Vec<Option<usize>> {
    let mut known = BTreeMap::new();
    for (index, name) in to.iter().enumerate() {
        known.entry(name).or_insert(index);
    }
    from.iter().map(|name| known.get(name).copied()).collect()
}

/// The counterpart of each rule. A rule that the other program never uses as a value is none: it could not be executed as one.
fn rules(from: &Program, to: &Program) -> Vec<Option<RuleId>> {
    let named = |program: &Program| {
        let domains = program.symbols.rule_domains.iter().cloned();
        let rules = program.symbols.rules.iter().cloned().zip(domains);
        rules.collect::<Vec<_>>()
    };
    let found = counterparts(&named(from), &named(to)).into_iter();
    let is_value = |rule: &usize| to.rules.get(*rule).is_some_and(|it| it.routine.is_some());
    let found = found.map(|it| it.filter(is_value));
    found.map(|it| it.map(|it| RuleId(it as u32))).collect()
}
