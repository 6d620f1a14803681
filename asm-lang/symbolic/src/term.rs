//! Symbolic evaluation of terms.

use crate::bdd::Bdd;
use crate::error::SymbolicError;
use crate::evaluator::{Evaluator, MAX_COMBINATIONS};
use crate::fault::FaultClass;
use crate::guarded::Guarded;
use crate::model::MAX_VALUES;
use asmotion_lang::Value;
use asmotion_lang::ir::{
    Arithmetic, BodyId, Collection, FunctionId, Origin, Term, TermNode, ValueShape,
};
use asmotion_lang::stdlib::{Builtin, BuiltinContext, BuiltinFault, integer};
use asmotion_lang::value::RuleId;

/// Combinations of values with their conditions.
pub(crate) type Combinations = Vec<(Vec<Value>, Bdd)>;

impl Evaluator<'_> {
    /// Evaluates a term where `path` is true.
    pub fn term(&mut self, term: &Term, path: &Bdd) -> Result<Guarded, SymbolicError> {
        if path.is_never() {
            return Ok(Guarded::default());
        }
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.term_here(term, path))
    }

    fn term_here(&mut self, term: &Term, path: &Bdd) -> Result<Guarded, SymbolicError> {
        let origin = term.origin;
        match &*term.node {
            TermNode::Constant(value) => Ok(Guarded::of(value.clone(), path)),
            TermNode::Unbound => {
                self.fail(FaultClass::Other, origin, path)?;
                Ok(Guarded::default())
            }
            TermNode::Local(local) => match self.local(*local) {
                Some(value) => value.under(self.store, path),
                None => Ok(Guarded::of(Value::Undef, path)),
            },
            TermNode::Agent => self.agent.under(self.store, path),
            TermNode::Slot(function, slot) => {
                if self.is_input(*function) {
                    let location = self.machine.state().location(self.program, *slot);
                    let arguments = location.map(|(_, arguments)| arguments).unwrap_or_default();
                    return self.input(*function, &arguments, origin, path);
                }
                if *slot < self.program.eager {
                    return self.stored(*slot, path);
                }
                let location = self.machine.state().location(self.program, *slot);
                let arguments = location.map(|(_, arguments)| arguments).unwrap_or_default();
                self.location(*function, &arguments, origin, path)
            }
            TermNode::Location(function, arguments) => {
                let combinations = self.combinations(arguments, origin, path)?;
                self.each_combination(&combinations, |it, arguments, path| {
                    it.location(*function, arguments, origin, path)
                })
            }
            TermNode::Call(body, arguments) => {
                let arguments = self.terms(arguments, path)?;
                let path = self.alive(path)?;
                self.call_body(*body, arguments, origin, &path)
            }
            TermNode::Cached(cache, term) => self.cached(*cache, term, path),
            TermNode::Builtin(builtin, arguments) => {
                let combinations = self.combinations(arguments, origin, path)?;
                self.each_combination(&combinations, |it, arguments, path| {
                    match it.builtin(builtin, arguments) {
                        Ok(value) => Ok(Guarded::of(value, path)),
                        Err(_) => {
                            it.fail(FaultClass::Library, origin, path)?;
                            Ok(Guarded::default())
                        }
                    }
                })
            }
            TermNode::Logic(..)
            | TermNode::Not(_)
            | TermNode::Equal(..)
            | TermNode::Compare(..)
            | TermNode::Quantified(..) => self.truth(term, path)?.value(self.store),
            TermNode::Arithmetic(operation, left, right) => {
                self.arithmetic(*operation, left, right, origin, path)
            }
            TermNode::Tuple(items) => {
                let combinations = self.combinations(items, origin, path)?;
                self.each_combination(&combinations, |_, items, path| {
                    Ok(Guarded::of(Value::tuple(items.iter().cloned()), path))
                })
            }
            TermNode::Component(tuple, index) => {
                let index = *index as usize;
                self.mapped(tuple, path, |_, value| {
                    if let Value::Tuple(items) = value {
                        items.get(index).cloned().unwrap_or_default()
                    } else {
                        Value::Undef
                    }
                })
            }
            TermNode::If(guard, then, otherwise) => {
                let truth = self.guard(guard, path)?;
                let mut value = self.term(then, &truth.yes)?;
                value.join(self.store, &self.term(otherwise, &truth.no)?)?;
                Ok(value)
            }
            TermNode::Switch(subject, cases, otherwise) => {
                let subject = self.term(subject, path)?;
                let mut rest = subject.defined(self.store)?;
                let mut value = Guarded::default();
                for (case, result) in cases {
                    let (here, others) = self.case(case, &subject, &rest)?;
                    value.join(self.store, &self.term(result, &here)?)?;
                    rest = others;
                }
                value.join(self.store, &self.term(otherwise, &rest)?)?;
                Ok(value)
            }
            TermNode::Let(bindings, body) => {
                let mut path = path.clone();
                for (local, term) in bindings {
                    let value = self.term(term, &path)?;
                    path = self.alive(&path)?;
                    self.set_local(*local, value);
                }
                self.term(body, &path)
            }
            TermNode::Listed(collection, items) => {
                let combinations = self.combinations(items, origin, path)?;
                self.each_combination(&combinations, |_, items, path| {
                    Ok(Guarded::of(collected(*collection, items.to_vec()), path))
                })
            }
            TermNode::Interval(collection, from, to, step) => {
                let mut bounds = vec![from.clone(), to.clone()];
                bounds.extend(step.clone());
                let combinations = self.combinations(&bounds, origin, path)?;
                self.each_combination(&combinations, |_, bounds, path| {
                    let items = interval(bounds)
                        .ok_or_else(|| SymbolicError::unsupported(origin, "this interval"))?;
                    let value = items.map_or(Value::Undef, |items| collected(*collection, items));
                    Ok(Guarded::of(value, path))
                })
            }
            TermNode::Collect(collection, binders, guard, item) => {
                self.comprehension(*collection, (binders, guard.as_ref()), item, origin, path)
            }
            TermNode::Map(pairs) => {
                let terms = pairs
                    .iter()
                    .flat_map(|(key, value)| [key.clone(), value.clone()]);
                let terms: Vec<Term> = terms.collect();
                let combinations = self.combinations(&terms, origin, path)?;
                self.each_combination(&combinations, |_, items, path| {
                    let pairs = items.chunks_exact(2).filter_map(|pair| {
                        let [key, value] = pair else { return None };
                        Some((key.clone(), value.clone()))
                    });
                    Ok(Guarded::of(Value::map(pairs), path))
                })
            }
            TermNode::CollectMap(..) => {
                Err(SymbolicError::unsupported(origin, "a map by comprehension"))
            }
            TermNode::Extent(shape) => {
                let elements = self.elements(shape, origin)?;
                Ok(Guarded::of(Value::set(elements), path))
            }
            TermNode::Watched(term) => self.term(term, path),
            TermNode::Pre(term) => {
                let view = std::mem::take(&mut self.view);
                let value = self.term(term, path);
                self.view = view;
                value
            }
            TermNode::Program(agent) => self.mapped(agent, path, |it, agent| {
                it.program_of(agent).map_or(Value::Undef, Value::Rule)
            }),
            TermNode::Name(element) => self.mapped(element, path, |it, element| {
                if element.is_undef() {
                    Value::Undef
                } else {
                    Value::text(element.show(&it.machine.naming()).to_string())
                }
            }),
            TermNode::Named(domain, text) => {
                let domain = *domain;
                self.mapped(text, path, |it, text| {
                    let Value::Text(text) = text else {
                        return Value::Undef;
                    };
                    let naming = it.machine.naming();
                    let mut elements = it.machine.state().extent(domain).iter();
                    let found = elements.find(|it| it.show(&naming).to_string() == **text);
                    found.cloned().unwrap_or_default()
                })
            }
        }
    }

    /// Evaluates terms one after the other.
    pub fn terms(&mut self, terms: &[Term], path: &Bdd) -> Result<Vec<Guarded>, SymbolicError> {
        let mut values = Vec::with_capacity(terms.len());
        let mut path = path.clone();
        for term in terms {
            values.push(self.term(term, &path)?);
            path = self.alive(&path)?;
        }
        Ok(values)
    }

    /// Evaluates terms, and returns all combinations of their values.
    pub fn combinations(
        &mut self,
        terms: &[Term],
        origin: Origin,
        path: &Bdd,
    ) -> Result<Combinations, SymbolicError> {
        let values = self.terms(terms, path)?;
        let path = self.alive(path)?;
        let mut all: Combinations = vec![(Vec::new(), path)];
        for values in &values {
            let mut longer = Vec::new();
            for (start, guard) in &all {
                for (value, condition) in values.iter() {
                    let guard = self.store.and(guard, condition)?;
                    if !guard.is_never() {
                        let mut items = start.clone();
                        items.push(value.clone());
                        longer.push((items, guard));
                    }
                }
                if longer.len() > MAX_COMBINATIONS {
                    return Err(many(origin));
                }
            }
            all = longer;
        }
        Ok(all)
    }

    fn each_combination(
        &mut self,
        combinations: &Combinations,
        evaluate: impl Fn(&mut Self, &[Value], &Bdd) -> Result<Guarded, SymbolicError>,
    ) -> Result<Guarded, SymbolicError> {
        let mut all = Guarded::default();
        for (values, guard) in combinations {
            let value = evaluate(self, values, guard)?;
            all.join(self.store, &value)?;
        }
        Ok(all)
    }

    fn mapped(
        &mut self,
        term: &Term,
        path: &Bdd,
        map: impl Fn(&Self, &Value) -> Value,
    ) -> Result<Guarded, SymbolicError> {
        let value = self.term(term, path)?;
        let mut mapped = Guarded::default();
        for (value, guard) in value.iter() {
            mapped.add(self.store, map(self, value), guard)?;
        }
        Ok(mapped)
    }

    /// Splits a path by whether a case has the value of the subject.
    pub fn case(
        &mut self,
        case: &Term,
        subject: &Guarded,
        path: &Bdd,
    ) -> Result<(Bdd, Bdd), SymbolicError> {
        let value = self.term(case, path)?;
        let path = self.alive(path)?;
        let mut here = self.store.never();
        for (value, guard) in value.iter() {
            if let Some(same) = subject.get(value) {
                here = self.store.or(&here, &self.store.and(guard, same)?)?;
            }
        }
        let here = self.store.and(&here, &path)?;
        let others = self.store.without(&path, &here)?;
        Ok((here, others))
    }

    /// Returns the value of a location.
    fn location(
        &mut self,
        function: FunctionId,
        arguments: &[Value],
        origin: Origin,
        path: &Bdd,
    ) -> Result<Guarded, SymbolicError> {
        if self.is_input(function) {
            return self.input(function, arguments, origin, path);
        }
        if let Some(slot) = self.slot(function, arguments) {
            return self.stored(slot, path);
        }
        // no rule updates locations without a slot: they keep their initial values
        let declared = self.program.functions.get(function.0 as usize);
        let Some(initial) = declared.and_then(|it| it.initial) else {
            return Ok(Guarded::of(Value::Undef, path));
        };
        let arguments = arguments.iter().map(|it| Guarded::of(it.clone(), path));
        let was_initial = std::mem::replace(&mut self.is_initial, true);
        let value = self.call_body(initial, arguments.collect(), origin, path);
        self.is_initial = was_initial;
        value
    }

    /// Evaluates a body with these arguments.
    pub fn call_body(
        &mut self,
        body: BodyId,
        arguments: Vec<Guarded>,
        origin: Origin,
        path: &Bdd,
    ) -> Result<Guarded, SymbolicError> {
        if path.is_never() {
            return Ok(Guarded::default());
        }
        let program = self.program;
        let Some(body) = program.bodies.get(body.0 as usize) else {
            return Ok(Guarded::of(Value::Undef, path));
        };
        self.enter(arguments, body.locals, origin)?;
        let value = self.term(&body.code, path);
        self.leave();
        value
    }

    fn cached(&mut self, cache: u32, term: &Term, path: &Bdd) -> Result<Guarded, SymbolicError> {
        if let Some(value) = self.cached.get(&cache) {
            return Ok(Guarded::of(value.clone(), path));
        }
        let value = self.term(term, path)?;
        if let Some((only, guard)) = value.iter().next()
            && value.len() == 1
            && guard == path
        {
            self.cached.insert(cache, only.clone());
        }
        Ok(value)
    }

    fn builtin(&self, builtin: &Builtin, arguments: &[Value]) -> Result<Value, BuiltinFault> {
        if builtin.strict && arguments.iter().any(Value::is_undef) {
            return Ok(Value::Undef);
        }
        let mut printed = Vec::new();
        let names = self.machine.naming();
        let mut context = BuiltinContext {
            names: &names,
            now_ns: 0,
            printed: &mut printed,
        };
        (builtin.body)(arguments, &mut context)
    }

    fn arithmetic(
        &mut self,
        operation: Arithmetic,
        left: &Term,
        right: &Term,
        origin: Origin,
        path: &Bdd,
    ) -> Result<Guarded, SymbolicError> {
        let compute = match operation {
            Arithmetic::Plus => integer::plus,
            Arithmetic::Minus => integer::minus,
            Arithmetic::Mult => integer::mult,
            Arithmetic::Mod => integer::modulo,
        };
        let left = self.term(left, path)?;
        let mut value = Guarded::default();
        let mut rest = self.store.never();
        for (operand, guard) in left.iter() {
            if matches!(operand, Value::Int(_)) {
                rest = self.store.or(&rest, guard)?;
            } else {
                // the other operand is not evaluated
                value.add(self.store, Value::Undef, guard)?;
            }
        }
        let right = self.term(right, &rest)?;
        if left.len() * right.len() > MAX_COMBINATIONS {
            return Err(many(origin));
        }
        for (first, guard) in left.iter() {
            let Value::Int(first) = first else { continue };
            for (second, condition) in right.iter() {
                let guard = self.store.and(guard, condition)?;
                if guard.is_never() {
                    continue;
                }
                let result = if let Value::Int(second) = second {
                    compute(*first, *second).map(Value::Int)
                } else {
                    Ok(Value::Undef)
                };
                match result {
                    Ok(result) => value.add(self.store, result, &guard)?,
                    Err(_) => self.fail(FaultClass::Library, origin, &guard)?,
                }
            }
        }
        Ok(value)
    }

    /// Returns the elements of a shape.
    pub fn elements(
        &self,
        shape: &ValueShape,
        origin: Origin,
    ) -> Result<Vec<Value>, SymbolicError> {
        let elements = self.machine.elements(shape, MAX_VALUES);
        elements.ok_or_else(|| {
            SymbolicError::unsupported(origin, "a domain without finitely many elements")
        })
    }

    /// Returns the program of an agent.
    pub fn program_of(&self, agent: &Value) -> Option<RuleId> {
        let Value::Atom(atom) = agent else {
            return None;
        };
        let domain = self.program.atom_domains.get(atom.0 as usize)?;
        let mut programs = self.program.programs.iter();
        let found = programs.find(|(of, _)| of == domain);
        found.map(|(_, rule)| *rule)
    }
}

/// The error for too many combinations of values.
pub(crate) fn many(origin: Origin) -> SymbolicError {
    SymbolicError::unsupported(origin, "a term with this many combinations of values")
}

/// Builds a collection of its elements.
pub(crate) fn collected(collection: Collection, items: Vec<Value>) -> Value {
    match collection {
        Collection::Set => Value::set(items),
        Collection::Seq => Value::seq(items),
        Collection::Bag => Value::bag(items),
    }
}

/// Lists an interval of integers, from its first element, last element and step. `Some(None)` if a bound is undef.
fn interval(bounds: &[Value]) -> Option<Option<Vec<Value>>> {
    if bounds.iter().any(Value::is_undef) {
        return Some(None);
    }
    let mut numbers = Vec::new();
    for bound in bounds {
        let Value::Int(number) = bound else {
            return None;
        };
        numbers.push(*number);
    }
    let (from, to, step) = match numbers.as_slice() {
        [from, to] => (*from, *to, 1),
        [from, to, step] => (*from, *to, *step),
        _ => return None,
    };
    let mut items = Vec::new();
    let mut at = from;
    while step > 0 && at <= to {
        if items.len() >= MAX_COMBINATIONS {
            return None;
        }
        items.push(Value::Int(at));
        let Some(next) = at.checked_add(step) else {
            break;
        };
        at = next;
    }
    Some(Some(items))
}
