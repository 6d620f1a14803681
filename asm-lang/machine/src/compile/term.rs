//! Terms compiled: to values, and where the kind is known to truth values and integers directly.

use super::range::Ranges;
use super::rule::program_of;
use super::{Compiler, IntCode, TermCode, TruthCode};
use crate::extent::MAX_ELEMENTS;
use crate::fault::FaultKind;
use crate::run::Truth;
use ir::{
    Arithmetic, BodyId, Collection, Comparison, FunctionId, FunctionKind, Kind, Logic, Node, Origin,
    Quantifier, Slot, Term,
};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;
use value::{Real, Value};

impl Compiler<'_> {
    pub(super) fn terms(&self, terms: &[Term]) -> Vec<TermCode> {
        terms.iter().map(|term| self.term(term)).collect()
    }

    /// A term as code that gives a value.
    pub(super) fn term(&self, term: &Term) -> TermCode {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.term_here(term))
    }

    fn term_here(&self, term: &Term) -> TermCode {
        let origin = term.origin;
        match &*term.node {
            Node::Constant(value) => {
                let value = value.clone();
                Box::new(move |_| value.clone())
            }
            Node::Local(local) => {
                let local = *local;
                Box::new(move |run| run.local(local).clone())
            }
            Node::Agent => Box::new(|run| run.agent.clone()),
            Node::Slot(function, slot) => self.slot(*function, *slot, origin),
            Node::Location(function, arguments) => self.location(*function, arguments, origin),
            Node::Call(body, arguments) => self.call_body(*body, arguments),
            Node::Cached(cache, term) => {
                let (cache, term) = (*cache as usize, self.term(term));
                Box::new(move |run| {
                    if let Some(value) = &run.state.caches[cache] {
                        return value.clone();
                    }
                    let value = term(run);
                    if run.fault.is_none() {
                        run.state.caches[cache] = Some(value.clone());
                    }
                    value
                })
            }
            Node::Builtin(builtin, arguments) => self.builtin(builtin, arguments, origin),
            Node::Logic(..) | Node::Not(_) | Node::Equal(..) | Node::Compare(..) | Node::Quantified(..) => {
                let truth = self.truth(term);
                Box::new(move |run| truth(run).value())
            }
            Node::Arithmetic(..) => {
                let integer = self.integer(term);
                Box::new(move |run| integer(run).map_or(Value::Undef, Value::Int))
            }
            Node::Tuple(items) => {
                let items = self.terms(items);
                Box::new(move |run| Value::tuple(items.iter().map(|item| item(run))))
            }
            Node::Component(tuple, index) => {
                let (tuple, index) = (self.term(tuple), *index as usize);
                Box::new(move |run| match tuple(run) {
                    Value::Tuple(items) => items.get(index).cloned().unwrap_or_default(),
                    _ => Value::Undef,
                })
            }
            Node::If(guard, then, otherwise) => {
                let guard_origin = guard.origin;
                let guard = self.truth(guard);
                let then = self.term(then);
                let otherwise = self.term(otherwise);
                Box::new(move |run| match guard(run) {
                    Truth::True => then(run),
                    Truth::False => otherwise(run),
                    Truth::Undef => run.fail(FaultKind::UndefinedGuard, guard_origin),
                })
            }
            Node::Switch(subject, cases, otherwise) => {
                let subject = self.term(subject);
                let cases: Vec<_> =
                    cases.iter().map(|(case, value)| (self.term(case), self.term(value))).collect();
                let otherwise = self.term(otherwise);
                Box::new(move |run| {
                    let subject = subject(run);
                    for (case, value) in &cases {
                        if case(run) == subject {
                            return value(run);
                        }
                    }
                    otherwise(run)
                })
            }
            Node::Let(bindings, body) => {
                let bindings: Vec<_> =
                    bindings.iter().map(|(local, term)| (*local, self.term(term))).collect();
                let body = self.term(body);
                Box::new(move |run| {
                    for (local, term) in &bindings {
                        let value = term(run);
                        run.set_local(*local, value);
                    }
                    body(run)
                })
            }
            Node::Listed(collection, items) => {
                let (collection, items) = (*collection, self.terms(items));
                Box::new(move |run| collect(collection, items.iter().map(|item| item(run)).collect()))
            }
            Node::Interval(collection, from, to, step) => {
                self.interval(*collection, from, to, step.as_ref(), origin)
            }
            Node::Collect(collection, binders, guard, item) => {
                let ranges = self.ranges(binders, guard.as_ref(), true);
                self.comprehension(*collection, ranges, item, origin)
            }
            Node::Map(pairs) => {
                let pairs: Vec<_> =
                    pairs.iter().map(|(key, value)| (self.term(key), self.term(value))).collect();
                Box::new(move |run| Value::map(pairs.iter().map(|(key, value)| (key(run), value(run)))))
            }
            Node::CollectMap(binders, guard, key, value) => {
                let ranges = self.ranges(binders, guard.as_ref(), true);
                let (key, value) = (self.term(key), self.term(value));
                Box::new(move |run| {
                    let mut pairs = BTreeMap::new();
                    ranges.each(run, &mut |run| {
                        let key = key(run);
                        pairs.insert(key, value(run));
                        ControlFlow::Continue(())
                    });
                    Value::Map(Arc::new(pairs))
                })
            }
            Node::Extent(shape) => {
                let shape = shape.clone();
                Box::new(move |run| match run.extent(&shape) {
                    Ok(elements) => Value::set(elements),
                    Err(kind) => run.fail(kind, origin),
                })
            }
            Node::Program(agent) => {
                let agent = self.term(agent);
                Box::new(move |run| {
                    let agent = agent(run);
                    program_of(run, &agent).map_or(Value::Undef, Value::Rule)
                })
            }
        }
    }

    fn is_input(&self, function: FunctionId) -> bool {
        matches!(
            self.program.functions[function.0 as usize].kind,
            FunctionKind::Monitored | FunctionKind::Shared
        )
    }

    fn slot(&self, function: FunctionId, slot: Slot, origin: Origin) -> TermCode {
        if !self.is_input(function) {
            return Box::new(move |run| run.state.slots[slot as usize].clone());
        }
        Box::new(move |run| {
            if run.state.asked[slot as usize] == run.round {
                return run.state.slots[slot as usize].clone();
            }
            let from = run.stack.len();
            if let Some((_, arguments)) = run.state.location(run.program, slot) {
                run.stack.extend(arguments);
            }
            let value = run.input(slot, function, from, origin);
            run.stack.truncate(from);
            value
        })
    }

    fn location(&self, function: FunctionId, arguments: &[Term], origin: Origin) -> TermCode {
        let arguments = self.terms(arguments);
        let is_input = self.is_input(function);
        Box::new(move |run| {
            let from = run.stack.len();
            for argument in &arguments {
                let argument = argument(run);
                run.stack.push(argument);
            }
            let slot = run.slot(function, from);
            let value = match is_input {
                true => run.input(slot, function, from, origin),
                false => run.state.slots[slot as usize].clone(),
            };
            run.stack.truncate(from);
            value
        })
    }

    fn call_body(&self, body: BodyId, arguments: &[Term]) -> TermCode {
        let arguments = self.terms(arguments);
        Box::new(move |run| {
            let from = run.locals.len();
            for argument in &arguments {
                let argument = argument(run);
                run.locals.push(argument);
            }
            run.call_body(body, from)
        })
    }

    fn builtin(&self, builtin: &'static stdlib::Builtin, arguments: &[Term], origin: Origin) -> TermCode {
        let arguments = self.terms(arguments);
        Box::new(move |run| {
            let from = run.stack.len();
            for argument in &arguments {
                let argument = argument(run);
                run.stack.push(argument);
            }
            let result = match builtin.strict && run.stack[from..].iter().any(Value::is_undef) {
                true => Ok(Value::Undef),
                false => {
                    // `naming` borrows the run only in part
                    let names = crate::state::Naming { program: run.program, reserve: &run.state.reserve };
                    let mut context = stdlib::Context {
                        names: &names,
                        now_ns: run.now_ns,
                        printed: &mut run.record.printed,
                    };
                    (builtin.body)(&run.stack[from..], &mut context)
                }
            };
            run.stack.truncate(from);
            match result {
                Ok(value) => value,
                Err(fault) => run.fail(FaultKind::Library(fault), origin),
            }
        })
    }

    fn interval(
        &self,
        collection: Collection,
        from: &Term,
        to: &Term,
        step: Option<&Term>,
        origin: Origin,
    ) -> TermCode {
        let (from, to) = (self.term(from), self.term(to));
        let step = step.map(|step| self.term(step));
        Box::new(move |run| {
            let (from, to) = (from(run), to(run));
            let step = step.as_ref().map(|step| step(run));
            match listed(&from, &to, step.as_ref()) {
                Ok(Some(items)) => collect(collection, items),
                Ok(None) => Value::Undef,
                Err(count) => run.fail(FaultKind::TooLarge(count), origin),
            }
        })
    }

    fn comprehension(&self, collection: Collection, ranges: Ranges, item: &Term, origin: Origin) -> TermCode {
        let item = self.term(item);
        Box::new(move |run| {
            let mut items = Vec::new();
            ranges.each(run, &mut |run| {
                items.push(item(run));
                if items.len() as u64 > MAX_ELEMENTS {
                    run.fail(FaultKind::TooLarge(items.len() as u64), origin);
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(())
            });
            collect(collection, items)
        })
    }

    /// A term as code that gives a truth value.
    pub(super) fn truth(&self, term: &Term) -> TruthCode {
        match &*term.node {
            Node::Logic(logic, left, right) => self.logic(*logic, left, right),
            Node::Not(operand) => {
                let operand = self.truth(operand);
                Box::new(move |run| match operand(run) {
                    Truth::True => Truth::False,
                    Truth::False => Truth::True,
                    Truth::Undef => Truth::Undef,
                })
            }
            Node::Equal(left, right) => self.equal(left, right),
            Node::Compare(comparison, left, right) => self.compare(*comparison, left, right),
            Node::Quantified(quantifier, binders, guard) => {
                self.quantified(*quantifier, self.ranges(binders, guard.as_ref(), false))
            }
            Node::Slot(function, slot) if !self.is_input(*function) => {
                let slot = *slot as usize;
                Box::new(move |run| Truth::from_value(&run.state.slots[slot]))
            }
            _ => {
                let code = self.term(term);
                Box::new(move |run| Truth::from_value(&code(run)))
            }
        }
    }

    /// Strong Kleene connectives; the right operand is not evaluated where the left decides.
    fn logic(&self, logic: Logic, left: &Term, right: &Term) -> TruthCode {
        use Truth::{False, True, Undef};
        let (left, right) = (self.truth(left), self.truth(right));
        match logic {
            Logic::And => Box::new(move |run| match left(run) {
                False => False,
                True => right(run),
                Undef => if right(run) == False { False } else { Undef },
            }),
            Logic::Or => Box::new(move |run| match left(run) {
                True => True,
                False => right(run),
                Undef => if right(run) == True { True } else { Undef },
            }),
            Logic::Implies => Box::new(move |run| match left(run) {
                False => True,
                True => right(run),
                Undef => if right(run) == True { True } else { Undef },
            }),
            Logic::Xor => Box::new(move |run| match (left(run), right(run)) {
                (Undef, _) | (_, Undef) => Undef,
                (left, right) => Truth::of(left != right),
            }),
            Logic::Iff => Box::new(move |run| match (left(run), right(run)) {
                (Undef, _) | (_, Undef) => Undef,
                (left, right) => Truth::of(left == right),
            }),
        }
    }

    /// `=` on anything. A location against a constant is the commonest guard of all.
    fn equal(&self, left: &Term, right: &Term) -> TruthCode {
        match (&*left.node, &*right.node) {
            (Node::Slot(function, slot), Node::Constant(value))
            | (Node::Constant(value), Node::Slot(function, slot))
                if !self.is_input(*function) =>
            {
                let (slot, value) = (*slot as usize, value.clone());
                Box::new(move |run| Truth::of(run.state.slots[slot] == value))
            }
            (_, Node::Constant(value)) => {
                let (left, value) = (self.term(left), value.clone());
                Box::new(move |run| Truth::of(left(run) == value))
            }
            _ if left.kind == Kind::Int && right.kind == Kind::Int => {
                let (left, right) = (self.integer(left), self.integer(right));
                Box::new(move |run| Truth::of(left(run) == right(run)))
            }
            _ => {
                let (left, right) = (self.term(left), self.term(right));
                Box::new(move |run| {
                    let left = left(run);
                    Truth::of(left == right(run))
                })
            }
        }
    }

    fn compare(&self, comparison: Comparison, left: &Term, right: &Term) -> TruthCode {
        let (left, right) = (self.integer(left), self.integer(right));
        macro_rules! compared {
            ($operator:tt) => {
                Box::new(move |run| match (left(run), right(run)) {
                    (Some(left), Some(right)) => Truth::of(left $operator right),
                    _ => Truth::Undef,
                })
            };
        }
        match comparison {
            Comparison::Lt => compared!(<),
            Comparison::Le => compared!(<=),
            Comparison::Gt => compared!(>),
            Comparison::Ge => compared!(>=),
        }
    }

    /// Strong Kleene quantifiers: an undef guard leaves the answer open unless another one decides.
    fn quantified(&self, quantifier: Quantifier, ranges: Ranges) -> TruthCode {
        let decided_by = match quantifier {
            Quantifier::Forall => Truth::False,
            Quantifier::Exists | Quantifier::ExistsUnique => Truth::True,
        };
        let enough = if quantifier == Quantifier::ExistsUnique { 2 } else { 1 };
        Box::new(move |run| {
            let mut found = 0;
            let mut open = false;
            ranges.each_guard(run, &mut |_, truth| {
                open |= truth == Truth::Undef;
                found += usize::from(truth == decided_by);
                if found >= enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            match (quantifier, found) {
                (Quantifier::Forall, 0) | (Quantifier::Exists | Quantifier::ExistsUnique, 0) | (Quantifier::ExistsUnique, 1)
                    if open =>
                {
                    Truth::Undef
                }
                (Quantifier::Forall, found) => Truth::of(found == 0),
                (Quantifier::Exists, found) => Truth::of(found > 0),
                (Quantifier::ExistsUnique, found) => Truth::of(found == 1),
            }
        })
    }

    /// A term as code that gives an integer.
    fn integer(&self, term: &Term) -> IntCode {
        match &*term.node {
            Node::Constant(Value::Int(number)) => {
                let number = *number;
                Box::new(move |_| Some(number))
            }
            Node::Local(local) => {
                let local = *local;
                Box::new(move |run| as_integer(run.local(local)))
            }
            Node::Slot(function, slot) if !self.is_input(*function) => {
                let slot = *slot as usize;
                Box::new(move |run| as_integer(&run.state.slots[slot]))
            }
            Node::Arithmetic(arithmetic, left, right) => {
                self.arithmetic(*arithmetic, left, right, term.origin)
            }
            _ => {
                let code = self.term(term);
                Box::new(move |run| as_integer(&code(run)))
            }
        }
    }

    fn arithmetic(&self, arithmetic: Arithmetic, left: &Term, right: &Term, origin: Origin) -> IntCode {
        let (left, right) = (self.integer(left), self.integer(right));
        let operation = match arithmetic {
            Arithmetic::Plus => stdlib::integer::plus,
            Arithmetic::Minus => stdlib::integer::minus,
            Arithmetic::Mult => stdlib::integer::mult,
            Arithmetic::Mod => stdlib::integer::modulo,
        };
        Box::new(move |run| {
            let (left, right) = (left(run)?, right(run)?);
            match operation(left, right) {
                Ok(number) => Some(number),
                Err(fault) => {
                    run.fail(FaultKind::Library(fault), origin);
                    None
                }
            }
        })
    }
}

fn as_integer(value: &Value) -> Option<i64> {
    match value {
        Value::Int(number) => Some(*number),
        _ => None,
    }
}

fn collect(collection: Collection, items: Vec<Value>) -> Value {
    match collection {
        Collection::Set => Value::set(items),
        Collection::Seq => Value::Seq(Arc::new(items)),
        Collection::Bag => Value::bag(items),
    }
}

/// The elements of `from : to, step`, the bound included when it is reached; `None` if a bound is
/// undef, the count if there are too many.
fn listed(from: &Value, to: &Value, step: Option<&Value>) -> Result<Option<Vec<Value>>, u64> {
    match (from, to, step) {
        (Value::Int(from), Value::Int(to), None | Some(Value::Int(_))) => {
            let step = match step {
                Some(Value::Int(step)) => *step,
                _ => 1,
            };
            if step <= 0 || from > to {
                return Ok(Some(Vec::new()));
            }
            let count = to.abs_diff(*from) / step.unsigned_abs() + 1;
            if count > MAX_ELEMENTS {
                return Err(count);
            }
            Ok(Some((0..count as i64).map(|index| Value::Int(from + index * step)).collect()))
        }
        (Value::Real(from), Value::Real(to), None | Some(Value::Real(_))) => {
            let step = match step {
                Some(Value::Real(step)) => step.get(),
                _ => 1.0,
            };
            let count = ((to.get() - from.get()) / step + 1e-9).floor() + 1.0;
            if !(step > 0.0 && count >= 1.0) {
                return Ok(Some(Vec::new()));
            }
            if count > MAX_ELEMENTS as f64 {
                return Err(count as u64);
            }
            let number = |index: u64| Real::new(decimal(from.get() + index as f64 * step));
            Ok(Some((0..count as u64).map(|index| Value::Real(number(index))).collect()))
        }
        _ => Ok(None),
    }
}

/// The number with 12 decimals: `0.1 + 2 · 0.1` is `0.3`, as it is written.
fn decimal(number: f64) -> f64 {
    let scaled = (number * 1e12).round() / 1e12;
    if scaled.is_finite() { scaled } else { number }
}
