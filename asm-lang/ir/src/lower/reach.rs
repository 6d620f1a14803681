//! Reachability of arguments: the integers that a program passes to functions over infinite
//! domains, as far as interval analysis shows. Example: `cell(r + 1, c)`, where `r` and `c` range
//! over an interval.
//!
//! The result only decides which locations get slots. All other arguments remain possible.

use crate::code::{AssignTarget, Binder, BinderRange, Rule, RuleNode, Term, TermNode};
use crate::id::{BodyId, FunctionId, RoutineId};
use crate::interval::IntegerInterval;
use crate::program::{AxisRange, DomainElements, FunctionKind, Program, Storage};
use crate::value_shape::ValueShape;
use asmotion_value::Value;
use std::collections::BTreeMap;

/// Arguments of greater magnitude get no slots.
const MOST: i64 = 1 << 20;

/// Widening: the number of times that the intervals of a routine's arguments may grow before they
/// are taken as unknown.
const PATIENCE: u8 = 4;

/// Returns, for each function over unbounded integers, the interval of each argument, or `None` for
/// an argument of another type.
pub(super) fn arguments(program: &Program) -> Vec<(FunctionId, Vec<Option<IntegerInterval>>)> {
    let mut reach = ReachAnalysis {
        program,
        routines: vec![None; program.routines.len()],
        bodies: vec![None; program.bodies.len()],
        used: BTreeMap::new(),
        todo: Vec::new(),
    };
    reach.begin();
    while let Some(part) = reach.todo.pop() {
        reach.visit_item(part);
    }
    reach.used.into_iter().collect()
}

impl IntegerInterval {
    /// Returns the axis for arguments in this interval, if it is small enough.
    pub(super) fn axis(self) -> Option<AxisRange> {
        let count = u32::try_from(self.high.checked_sub(self.low)?.checked_add(1)?).ok()?;
        Some(AxisRange::Ints {
            low: self.low,
            count,
        })
    }
}

/// Intervals of the arguments of a routine or body, and the number of times they grew; `None`
/// before the first call.
type Given = Option<(Vec<IntegerInterval>, u8)>;

#[derive(Clone, Copy)]
enum ReachItem {
    Routine(RoutineId),
    Body(BodyId),
}

struct ReachAnalysis<'p> {
    program: &'p Program,
    routines: Vec<Given>,
    bodies: Vec<Given>,
    used: BTreeMap<FunctionId, Vec<Option<IntegerInterval>>>,
    todo: Vec<ReachItem>,
}

impl ReachAnalysis<'_> {
    /// Starts with the code that is run without a call: the main rule, rule values and invariants.
    fn begin(&mut self) {
        let values = self.program.rules.iter().filter_map(|rule| rule.routine);
        for routine in self.program.main.into_iter().chain(values) {
            let count = self.program.routines[routine.0 as usize].arguments;
            self.call(
                ReachItem::Routine(routine),
                vec![IntegerInterval::ANY; count as usize],
            );
        }
        for invariant in &self.program.invariants {
            self.call(ReachItem::Body(invariant.body), Vec::new());
        }
    }

    /// Joins the arguments of a call with those known, and queues the callee if they grew.
    fn call(&mut self, part: ReachItem, arguments: Vec<IntegerInterval>) {
        let given = match part {
            ReachItem::Routine(routine) => &mut self.routines[routine.0 as usize],
            ReachItem::Body(body) => &mut self.bodies[body.0 as usize],
        };
        let Some((known, widened)) = given else {
            *given = Some((arguments, 0));
            return self.todo.push(part);
        };
        let wider: Vec<IntegerInterval> = known
            .iter()
            .zip(&arguments)
            .map(|(known, argument)| known.or(*argument))
            .collect();
        if wider == *known {
            return;
        }
        *widened += 1;
        *known = if *widened > PATIENCE {
            vec![IntegerInterval::ANY; wider.len()]
        } else {
            wider
        };
        self.todo.push(part);
    }

    fn visit_item(&mut self, part: ReachItem) {
        let program = self.program;
        let (given, locals) = match part {
            ReachItem::Routine(routine) => {
                let index = routine.0 as usize;
                (&self.routines[index], program.routines[index].locals)
            }
            ReachItem::Body(body) => {
                let index = body.0 as usize;
                (&self.bodies[index], program.bodies[index].locals)
            }
        };
        let mut known = given
            .as_ref()
            .map(|(arguments, _)| arguments.clone())
            .unwrap_or_default();
        known.resize(locals as usize, IntegerInterval::ANY);
        match part {
            ReachItem::Routine(routine) => {
                self.rule(&program.routines[routine.0 as usize].code, &mut known);
            }
            ReachItem::Body(body) => {
                self.term(&program.bodies[body.0 as usize].code, &mut known);
            }
        }
    }

    fn rule(&mut self, rule: &Rule, known: &mut Vec<IntegerInterval>) {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.rule_here(rule, known));
    }

    fn rule_here(&mut self, rule: &Rule, known: &mut Vec<IntegerInterval>) {
        match &*rule.node {
            RuleNode::Skip => {}
            RuleNode::Update(place, value) => {
                self.visit_target(place, known);
                self.term(value, known);
            }
            RuleNode::Assign(place, routine, arguments) => {
                if let Some(place) = place {
                    self.visit_target(place, known);
                }
                let arguments = self.terms(arguments, known);
                self.call(ReachItem::Routine(*routine), arguments);
            }
            RuleNode::Call(routine, arguments) => {
                let arguments = self.terms(arguments, known);
                self.call(ReachItem::Routine(*routine), arguments);
            }
            RuleNode::Run(term, arguments) | RuleNode::RunAgent(term, arguments) => {
                self.term(term, known);
                self.terms(arguments, known);
            }
            RuleNode::Act(_, arguments) => {
                self.terms(arguments, known);
            }
            RuleNode::Par(rules) | RuleNode::Seq(rules) => {
                rules.iter().for_each(|rule| self.rule(rule, known));
            }
            RuleNode::If(guard, then, otherwise) => {
                self.term(guard, known);
                self.rule(then, known);
                self.rule(otherwise, known);
            }
            RuleNode::Switch(subject, cases, otherwise) => {
                self.term(subject, known);
                for (case, rule) in cases {
                    self.term(case, known);
                    self.rule(rule, known);
                }
                self.rule(otherwise, known);
            }
            RuleNode::Choose(binders, guard, body, ifnone) => {
                self.binders(binders, guard.as_ref(), known);
                self.rule(body, known);
                self.rule(ifnone, known);
            }
            RuleNode::Forall(binders, guard, body) => {
                self.binders(binders, guard.as_ref(), known);
                self.rule(body, known);
            }
            RuleNode::Let(bindings, body) => {
                for (local, term) in bindings {
                    known[*local as usize] = self.term(term, known);
                }
                self.rule(body, known);
            }
            RuleNode::Extend(_, _, body) | RuleNode::Counted(_, body) | RuleNode::Watched(body) => {
                self.rule(body, known)
            }
            RuleNode::While { guard, body, .. } => {
                if let Some(guard) = guard {
                    self.term(guard, known);
                }
                self.rule(body, known);
            }
            RuleNode::Local { initial, body, .. } => {
                initial.iter().for_each(|rule| self.rule(rule, known));
                self.rule(body, known);
            }
            RuleNode::Draw(_, body) => self.rule(body, known),
        }
    }

    fn visit_target(&mut self, place: &AssignTarget, known: &mut Vec<IntegerInterval>) {
        match place {
            AssignTarget::Slot(..) | AssignTarget::Local(_) => {}
            AssignTarget::Location(function, arguments) => {
                let arguments = self.terms(arguments, known);
                self.uses(*function, &arguments);
            }
        }
    }

    fn terms(&mut self, terms: &[Term], known: &mut Vec<IntegerInterval>) -> Vec<IntegerInterval> {
        terms.iter().map(|term| self.term(term, known)).collect()
    }

    fn binders(
        &mut self,
        binders: &[Binder],
        guard: Option<&Term>,
        known: &mut Vec<IntegerInterval>,
    ) {
        for binder in binders {
            known[binder.local as usize] = match &binder.range {
                BinderRange::Ints(low, high) => IntegerInterval {
                    low: *low,
                    high: *high,
                },
                BinderRange::Elements(term) => {
                    self.term(term, known);
                    IntegerInterval::ANY
                }
                BinderRange::Atoms(..) | BinderRange::Bools | BinderRange::Domain(_) => {
                    IntegerInterval::ANY
                }
            };
        }
        if let Some(guard) = guard {
            self.term(guard, known);
        }
    }

    fn term(&mut self, term: &Term, known: &mut Vec<IntegerInterval>) -> IntegerInterval {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.term_here(term, known))
    }

    /// Analyses a term and returns the interval of its value.
    fn term_here(&mut self, term: &Term, known: &mut Vec<IntegerInterval>) -> IntegerInterval {
        match &*term.node {
            TermNode::Constant(Value::Int(number)) => return IntegerInterval::of(*number),
            TermNode::Constant(_)
            | TermNode::Agent
            | TermNode::Slot(..)
            | TermNode::Extent(_)
            | TermNode::Unbound => {}
            TermNode::Local(local) => return known[*local as usize],
            TermNode::Location(function, arguments) => {
                let arguments = self.terms(arguments, known);
                self.uses(*function, &arguments);
            }
            TermNode::Call(body, arguments) => {
                let arguments = self.terms(arguments, known);
                self.call(ReachItem::Body(*body), arguments);
            }
            TermNode::Arithmetic(operation, left, right) => {
                let (left, right) = (self.term(left, known), self.term(right, known));
                return IntegerInterval::computed(*operation, left, right).0;
            }
            TermNode::If(guard, then, otherwise) => {
                self.term(guard, known);
                let then = self.term(then, known);
                return then.or(self.term(otherwise, known));
            }
            TermNode::Let(bindings, body) => {
                for (local, term) in bindings {
                    known[*local as usize] = self.term(term, known);
                }
                return self.term(body, known);
            }
            TermNode::Quantified(_, binders, guard) => self.binders(binders, guard.as_ref(), known),
            TermNode::Collect(_, binders, guard, item) => {
                self.binders(binders, guard.as_ref(), known);
                self.term(item, known);
            }
            TermNode::CollectMap(binders, guard, key, value) => {
                self.binders(binders, guard.as_ref(), known);
                self.term(key, known);
                self.term(value, known);
            }
            TermNode::Cached(_, term)
            | TermNode::Watched(term)
            | TermNode::Pre(term)
            | TermNode::Not(term)
            | TermNode::Component(term, _)
            | TermNode::Name(term)
            | TermNode::Named(_, term)
            | TermNode::Program(term) => {
                self.term(term, known);
            }
            TermNode::Builtin(_, terms) | TermNode::Tuple(terms) | TermNode::Listed(_, terms) => {
                self.terms(terms, known);
            }
            TermNode::Logic(_, left, right)
            | TermNode::Equal(left, right)
            | TermNode::Compare(_, left, right) => {
                self.term(left, known);
                self.term(right, known);
            }
            TermNode::Switch(subject, cases, otherwise) => {
                self.term(subject, known);
                for (case, value) in cases {
                    self.term(case, known);
                    self.term(value, known);
                }
                self.term(otherwise, known);
            }
            TermNode::Interval(_, from, to, step) => {
                for term in [from, to].into_iter().chain(step) {
                    self.term(term, known);
                }
            }
            TermNode::Map(pairs) => {
                for (key, value) in pairs {
                    self.term(key, known);
                    self.term(value, known);
                }
            }
        }
        IntegerInterval::ANY
    }

    /// Records an access to a location of a function over unbounded integers.
    fn uses(&mut self, function: FunctionId, arguments: &[IntegerInterval]) {
        let declared = &self.program.functions[function.0 as usize];
        let is_written = match declared.kind {
            FunctionKind::Controlled | FunctionKind::Out => true,
            FunctionKind::Monitored
            | FunctionKind::Shared
            | FunctionKind::Local
            | FunctionKind::Fixed => false,
        };
        if declared.storage != Storage::Interned || !is_written {
            return;
        }
        let is_endless: Vec<bool> = declared
            .parameters
            .iter()
            .map(|shape| self.is_endless(shape))
            .collect();
        let mut pairs = is_endless.iter().zip(arguments);
        if !pairs.all(|(is_endless, argument)| !is_endless || argument.within(-MOST, MOST)) {
            return;
        }
        let used = is_endless
            .iter()
            .zip(arguments)
            .map(|(is_endless, argument)| is_endless.then_some(*argument))
            .collect();
        let known = self.used.entry(function).or_insert(used);
        for (known, argument) in known.iter_mut().zip(arguments) {
            *known = known.map(|known| known.or(*argument));
        }
    }

    /// Returns `true` if a shape consists of integers without known bounds.
    fn is_endless(&self, shape: &ValueShape) -> bool {
        match shape {
            ValueShape::Int | ValueShape::Natural => true,
            ValueShape::Domain(domain) => match self.program.domains[domain.0 as usize] {
                crate::program::Domain {
                    elements: DomainElements::Computed(_) | DomainElements::Undefined,
                    base,
                    grows,
                    ..
                } => base.is_none() && !grows,
                _ => false,
            },
            ValueShape::Bool
            | ValueShape::Real
            | ValueShape::Char
            | ValueShape::Text
            | ValueShape::Complex
            | ValueShape::Rule
            | ValueShape::Tuple(_)
            | ValueShape::Seq(_)
            | ValueShape::Set(_)
            | ValueShape::Bag(_)
            | ValueShape::Map(..)
            | ValueShape::Any => false,
        }
    }
}
