//! Facts about the values of locations, for each function: whether undef is among them, and their bounds.
//!
//! The facts hold in a given state, and every step preserves them: they are the least fixpoint, over all rules, of the values
//! in that state and the values of all updates, with bounds that still grow after some rounds widened to those of the
//! codomain, and narrowed again to those of the updates. A machine checks them again whenever its state was changed other than by a step. Memory safety does not
//! depend on them.

use asmotion_ir::{
    Arithmetic, AssignTarget, Binder, BinderRange, DomainElements, FunctionId, FunctionKind,
    Initial, IntegerInterval, Program, Rule, RuleNode, Slot, Storage, Term, TermNode, ValueKind,
};
use asmotion_value::Value;

/// Number of rounds before bounds are widened.
const ROUNDS: usize = 8;

/// Number of rounds that narrow widened bounds.
const NARROWING_ROUNDS: usize = 2;

/// Limit for the nesting of definitions that are evaluated.
const MAX_DEPTH: usize = 8;

/// The possible values of a term or of a function's locations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ValueFact {
    /// The kind of all values but undef; `None` if there are no others.
    kind: Option<ValueKind>,
    /// Bounds of integers, and of the numbers of atoms.
    pub interval: IntegerInterval,
    /// `true` if undef is possible.
    pub may_be_undef: bool,
}

impl ValueFact {
    /// Any value.
    pub const ANYTHING: Self = Self {
        kind: Some(ValueKind::Other),
        interval: IntegerInterval::ANY,
        may_be_undef: true,
    };

    /// Undef only.
    const UNDEF: Self = Self {
        kind: None,
        interval: IntegerInterval::ANY,
        may_be_undef: true,
    };

    fn of(value: &Value) -> Self {
        let (kind, number) = if let Value::Int(number) = value {
            (ValueKind::Int, *number)
        } else if let Value::Bool(truth) = value {
            (ValueKind::Bool, i64::from(*truth))
        } else if let Value::Atom(atom) = value {
            (ValueKind::Atom, i64::from(atom.0))
        } else if value.is_undef() {
            return Self::UNDEF;
        } else {
            return Self::ANYTHING;
        };
        Self::within(kind, IntegerInterval::of(number))
    }

    fn within(kind: ValueKind, interval: IntegerInterval) -> Self {
        Self {
            kind: Some(kind),
            interval,
            may_be_undef: false,
        }
    }

    fn truth(may_be_undef: bool) -> Self {
        Self {
            may_be_undef,
            ..Self::within(ValueKind::Bool, IntegerInterval { low: 0, high: 1 })
        }
    }

    fn or(self, other: Self) -> Self {
        let may_be_undef = self.may_be_undef || other.may_be_undef;
        match (self.kind, other.kind) {
            (None, _) => Self {
                may_be_undef,
                ..other
            },
            (_, None) => Self {
                may_be_undef,
                ..self
            },
            (Some(one), Some(another)) if one == another => Self {
                kind: Some(one),
                interval: self.interval.or(other.interval),
                may_be_undef,
            },
            (Some(_), Some(_)) => Self::ANYTHING,
        }
    }

    /// Returns `true` if each value is of this kind and not undef.
    pub fn is_always(self, kind: ValueKind) -> bool {
        self.kind == Some(kind) && !self.may_be_undef
    }

    /// Returns `true` if all values are scalars.
    pub fn is_scalar(self) -> bool {
        match self.kind {
            None | Some(ValueKind::Bool | ValueKind::Int | ValueKind::Real | ValueKind::Atom) => {
                true
            }
            Some(ValueKind::Other) => false,
        }
    }

    /// Returns the bounds of the values that are integers.
    pub fn integers(self) -> IntegerInterval {
        if self.kind == Some(ValueKind::Int) {
            self.interval
        } else {
            IntegerInterval::ANY
        }
    }

    fn permits(self, value: &Value) -> bool {
        self.or(Self::of(value)) == self
    }
}

/// The facts about the functions of a program, indexed by function.
pub(crate) struct ValueFacts {
    facts: Vec<ValueFact>,
    /// The slots that must be checked, with their functions.
    checked: Vec<(FunctionId, std::ops::Range<Slot>)>,
}

impl ValueFacts {
    /// Finds facts that hold in a state with these slots, and in all states that steps lead to from there.
    pub fn of(program: &Program, slots: &[Value]) -> Self {
        let mut facts = vec![ValueFact::UNDEF; program.functions.len()];
        let mut checked = Vec::new();
        for (index, function) in program.functions.iter().enumerate() {
            let id = FunctionId(index as u32);
            let waits = program.initial_inputs.contains(&Initial::Function(id));
            let is_changed_outside = match function.kind {
                FunctionKind::Monitored | FunctionKind::Shared | FunctionKind::Local => true,
                FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Fixed => false,
            };
            let Storage::Dense { base, count, .. } = function.storage else {
                facts[index] = ValueFact::ANYTHING;
                continue;
            };
            if waits || is_changed_outside {
                facts[index] = ValueFact::ANYTHING;
                continue;
            }
            let range = base..base + count;
            let values = slots.get(base as usize..range.end as usize);
            let values = values.unwrap_or_default().iter().map(ValueFact::of);
            facts[index] = values.fold(
                if function.storage.is_lazy() {
                    ValueFact::UNDEF
                } else {
                    ValueFact {
                        may_be_undef: false,
                        ..ValueFact::UNDEF
                    }
                },
                ValueFact::or,
            );
            checked.push((id, range));
        }
        let mut found = Self { facts, checked };
        let mut initially = Evaluation {
            program,
            facts: &found.facts,
            found: found.facts.clone(),
        };
        initially.lazy();
        let initial = initially.found;
        let preserved = preserved(program, initial.clone());
        found.facts = narrowed(program, &initial, preserved);
        found
    }

    /// Returns the fact about a function.
    pub fn get(&self, function: FunctionId) -> ValueFact {
        let fact = self.facts.get(function.0 as usize).copied();
        fact.unwrap_or(ValueFact::ANYTHING)
    }

    /// Returns `true` if the facts hold in a state with these slots.
    pub fn hold(&self, slots: &[Value]) -> bool {
        self.checked.iter().all(|(function, range)| {
            let fact = self.get(*function);
            let slots = slots.get(range.start as usize..range.end as usize);
            slots.is_some_and(|slots| slots.iter().all(|value| fact.permits(value)))
        })
    }
}

/// Returns these facts with the values of all updates in states for which other facts hold.
fn updated(program: &Program, in_state: &[ValueFact], facts: Vec<ValueFact>) -> Vec<ValueFact> {
    let mut next = Evaluation {
        program,
        facts: in_state,
        found: facts,
    };
    next.all();
    next.found
}

/// Returns facts that follow from the initial ones and that every step preserves.
fn preserved(program: &Program, initial: Vec<ValueFact>) -> Vec<ValueFact> {
    let mut facts = initial;
    for round in 0.. {
        let next = updated(program, &facts, facts.clone());
        if next == facts {
            break;
        }
        facts = if round < ROUNDS {
            next
        } else {
            widened(program, &facts, &next)
        };
    }
    facts
}

/// Narrows facts that every step preserves to the initial ones with the values of all updates. `x := (x + 1) mod 9` is bounded
/// although `x + 1` is not.
fn narrowed(program: &Program, initial: &[ValueFact], preserved: Vec<ValueFact>) -> Vec<ValueFact> {
    let mut facts = preserved;
    for _ in 0..NARROWING_ROUNDS {
        let next = updated(program, &facts, initial.to_vec());
        let is_preserved = || updated(program, &next, next.clone()) == next;
        if next == facts || !is_preserved() {
            break;
        }
        facts = next;
    }
    facts
}

/// Widens the bounds that have changed, to those of the codomain if it has any, or else to infinity: each changes at most twice.
fn widened(program: &Program, before: &[ValueFact], after: &[ValueFact]) -> Vec<ValueFact> {
    let facts = before.iter().zip(after).zip(&program.functions);
    let widen =
        |((before, after), function): ((&ValueFact, &ValueFact), &asmotion_ir::Function)| {
            let domain = function
                .within
                .map(|it| &program.domains[it.0 as usize].elements);
            let bounds = match domain {
                Some(&DomainElements::Ints { low, high }) if low <= high => {
                    IntegerInterval { low, high }
                }
                Some(_) | None => IntegerInterval::ANY,
            };
            let mut wide = *after;
            if after.interval.low < before.interval.low {
                let is_within = after.interval.low >= bounds.low;
                wide.interval.low = if is_within { bounds.low } else { i64::MIN };
            }
            if after.interval.high > before.interval.high {
                let is_within = after.interval.high <= bounds.high;
                wide.interval.high = if is_within { bounds.high } else { i64::MAX };
            }
            wide
        };
    facts.map(widen).collect()
}

/// One round: the values of all updates, given the facts of the round before.
struct Evaluation<'a> {
    program: &'a Program,
    facts: &'a [ValueFact],
    found: Vec<ValueFact>,
}

/// The values of the locals of a frame.
type Locals = Vec<ValueFact>;

impl Evaluation<'_> {
    fn all(&mut self) {
        for routine in &self.program.routines {
            let mut locals = vec![ValueFact::ANYTHING; routine.locals as usize];
            self.rule(&routine.code, &mut locals);
        }
        self.lazy();
    }

    /// Adds the initial values that lazy locations get in a step.
    fn lazy(&mut self) {
        for (index, function) in self.program.functions.iter().enumerate() {
            if function.storage.is_lazy()
                && let Some(body) = function.initial
            {
                let body = &self.program.bodies[body.0 as usize];
                let mut locals = vec![ValueFact::ANYTHING; body.locals as usize];
                let value = self.term(&body.code, &mut locals, 0);
                self.add(FunctionId(index as u32), value);
            }
        }
    }

    fn add(&mut self, function: FunctionId, value: ValueFact) {
        let fact = &mut self.found[function.0 as usize];
        *fact = fact.or(value);
    }

    fn rule(&mut self, rule: &Rule, locals: &mut Locals) {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.rule_here(rule, locals));
    }

    fn rule_here(&mut self, rule: &Rule, locals: &mut Locals) {
        match &*rule.node {
            RuleNode::Update(place, value) => {
                let value = self.term(value, locals, 0);
                self.update(place, value);
            }
            RuleNode::Assign(place, _, _) => {
                if let Some(place) = place {
                    self.update(place, ValueFact::ANYTHING);
                }
            }
            RuleNode::Par(rules) | RuleNode::Seq(rules) => {
                rules.iter().for_each(|rule| self.rule(rule, locals));
            }
            RuleNode::If(_, then, otherwise) => {
                self.rule(then, locals);
                self.rule(otherwise, locals);
            }
            RuleNode::Switch(_, cases, otherwise) => {
                cases.iter().for_each(|(_, rule)| self.rule(rule, locals));
                self.rule(otherwise, locals);
            }
            RuleNode::Choose(binders, _, body, ifnone) => {
                self.bind(binders, locals);
                self.rule(body, locals);
                self.rule(ifnone, locals);
            }
            RuleNode::Forall(binders, _, body) => {
                self.bind(binders, locals);
                self.rule(body, locals);
            }
            RuleNode::Let(bindings, body) => {
                for (local, term) in bindings {
                    let value = self.term(term, locals, 0);
                    set(locals, *local, value);
                }
                self.rule(body, locals);
            }
            RuleNode::Extend(_, new, body) => {
                for local in new {
                    set(locals, *local, ValueFact::ANYTHING);
                }
                self.rule(body, locals);
            }
            RuleNode::Draw(numbers, body) => {
                for (local, _, _) in numbers {
                    set(locals, *local, ValueFact::ANYTHING);
                }
                self.rule(body, locals);
            }
            RuleNode::Local { run, initial, body } => {
                set(locals, *run, ValueFact::ANYTHING);
                initial.iter().for_each(|rule| self.rule(rule, locals));
                self.rule(body, locals);
            }
            RuleNode::Counted(_, body) | RuleNode::Watched(body) | RuleNode::While { body, .. } => {
                self.rule(body, locals)
            }
            RuleNode::Skip
            | RuleNode::Call(..)
            | RuleNode::Run(..)
            | RuleNode::RunAgent(..)
            | RuleNode::Act(..) => {}
        }
    }

    fn update(&mut self, place: &AssignTarget, value: ValueFact) {
        match place {
            AssignTarget::Slot(function, _) | AssignTarget::Location(function, _) => {
                self.add(*function, self.accepted(*function, value));
            }
            // the program is compatible, and has no direct rule
            AssignTarget::Local(_) => {}
        }
    }

    /// Returns the values that an update of a function accepts.
    fn accepted(&self, function: FunctionId, value: ValueFact) -> ValueFact {
        let domain = self.program.functions[function.0 as usize].within;
        let domain = domain.map(|it| &self.program.domains[it.0 as usize].elements);
        if let Some(&DomainElements::Ints { low, high }) = domain
            && value.kind == Some(ValueKind::Int)
        {
            let low = value.interval.low.max(low);
            let high = value.interval.high.min(high);
            return if low <= high {
                let interval = IntegerInterval { low, high };
                ValueFact { interval, ..value }
            } else {
                // the step fails
                ValueFact {
                    may_be_undef: value.may_be_undef,
                    ..ValueFact::UNDEF
                }
            };
        }
        value
    }

    fn bind(&self, binders: &[Binder], locals: &mut Locals) {
        for binder in binders {
            let value = match binder.range {
                BinderRange::Ints(low, high) if low <= high => {
                    ValueFact::within(ValueKind::Int, IntegerInterval { low, high })
                }
                BinderRange::Bools => ValueFact::truth(false),
                BinderRange::Atoms(first, count) if count > 0 => {
                    let low = i64::from(first);
                    let high = low + i64::from(count) - 1;
                    ValueFact::within(ValueKind::Atom, IntegerInterval { low, high })
                }
                BinderRange::Ints(..)
                | BinderRange::Atoms(..)
                | BinderRange::Domain(_)
                | BinderRange::Elements(_) => ValueFact::ANYTHING,
            };
            set(locals, binder.local, value);
        }
    }

    fn term(&self, term: &Term, locals: &mut Locals, depth: usize) -> ValueFact {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
            self.term_here(term, locals, depth)
        })
    }

    fn term_here(&self, term: &Term, locals: &mut Locals, depth: usize) -> ValueFact {
        match &*term.node {
            TermNode::Constant(value) => ValueFact::of(value),
            TermNode::Local(local) => {
                let local = locals.get(*local as usize).copied();
                local.unwrap_or(ValueFact::ANYTHING)
            }
            TermNode::Slot(function, _) => self.facts[function.0 as usize],
            TermNode::Location(function, arguments) => {
                let fact = self.facts[function.0 as usize];
                let arguments: Vec<ValueFact> = arguments
                    .iter()
                    .map(|argument| self.term(argument, locals, depth))
                    .collect();
                if self.is_dense(*function, &arguments) {
                    fact
                } else {
                    // locations off the axes have values of their own
                    ValueFact::ANYTHING
                }
            }
            TermNode::Call(body, arguments) if depth < MAX_DEPTH => {
                let body = &self.program.bodies[body.0 as usize];
                let arguments = arguments
                    .iter()
                    .map(|argument| self.term(argument, locals, depth));
                let mut inner: Locals = arguments.collect();
                inner.resize(body.locals as usize, ValueFact::ANYTHING);
                self.term(&body.code, &mut inner, depth + 1)
            }
            TermNode::Cached(_, term) => self.term(term, locals, depth),
            TermNode::Logic(_, left, right) | TermNode::Compare(_, left, right) => {
                let left = self.term(left, locals, depth);
                let right = self.term(right, locals, depth);
                ValueFact::truth(left.may_be_undef || right.may_be_undef)
            }
            TermNode::Not(operand) => {
                ValueFact::truth(self.term(operand, locals, depth).may_be_undef)
            }
            TermNode::Equal(..) => ValueFact::truth(false),
            TermNode::Quantified(..) => ValueFact::truth(true),
            TermNode::Arithmetic(operation, left, right) => {
                let left = self.term(left, locals, depth);
                let right = self.term(right, locals, depth);
                arithmetic(*operation, left, right)
            }
            TermNode::If(_, then, otherwise) => {
                let then = self.term(then, locals, depth);
                then.or(self.term(otherwise, locals, depth))
            }
            TermNode::Switch(_, cases, otherwise) => {
                let otherwise = self.term(otherwise, locals, depth);
                cases.iter().fold(otherwise, |all, (_, value)| {
                    all.or(self.term(value, locals, depth))
                })
            }
            TermNode::Let(bindings, body) => {
                for (local, term) in bindings {
                    let value = self.term(term, locals, depth);
                    set(locals, *local, value);
                }
                self.term(body, locals, depth)
            }
            TermNode::Call(..)
            | TermNode::Agent
            | TermNode::Builtin(..)
            | TermNode::Tuple(_)
            | TermNode::Component(..)
            | TermNode::Listed(..)
            | TermNode::Interval(..)
            | TermNode::Collect(..)
            | TermNode::Map(_)
            | TermNode::CollectMap(..)
            | TermNode::Extent(_)
            | TermNode::Unbound
            | TermNode::Program(_)
            | TermNode::Pre(_)
            | TermNode::Watched(_)
            | TermNode::Name(_)
            | TermNode::Named(..) => ValueFact::ANYTHING,
        }
    }

    /// Returns `true` if all arguments lie on the axes of a function.
    fn is_dense(&self, function: FunctionId, arguments: &[ValueFact]) -> bool {
        let Storage::Dense { axes, .. } = &self.program.functions[function.0 as usize].storage
        else {
            return false;
        };
        axes.len() == arguments.len()
            && axes.iter().zip(arguments).all(|(axis, argument)| {
                let (kind, low) = match axis.over {
                    asmotion_ir::AxisRange::Bool => (ValueKind::Bool, 0),
                    asmotion_ir::AxisRange::Ints { low, .. } => (ValueKind::Int, low),
                    asmotion_ir::AxisRange::Atoms { first, .. } => (ValueKind::Atom, first.into()),
                };
                let high = low.saturating_add(i64::from(axis.over.count()) - 1);
                argument.is_always(kind) && argument.interval.within(low, high)
            })
    }
}

fn arithmetic(operation: Arithmetic, left: ValueFact, right: ValueFact) -> ValueFact {
    let (interval, _) = IntegerInterval::computed(operation, left.integers(), right.integers());
    ValueFact {
        may_be_undef: left.may_be_undef || right.may_be_undef,
        ..ValueFact::within(ValueKind::Int, interval)
    }
}

fn set(locals: &mut Locals, local: asmotion_ir::Local, value: ValueFact) {
    if let Some(place) = locals.get_mut(local as usize) {
        *place = value;
    }
}
