//! Which integers a program gives functions over domains without end, as far as it shows: `cell(r + 1,
//! c)` where `r` and `c` range over an interval.
//!
//! What is found only says where slots are laid out. Other arguments are met all the same.

use crate::code::{Binder, Node, Place, Range, Rule, RuleNode, Term};
use crate::interval::Interval;
use crate::program::{
    AxisRange, BodyId, Elements, FunctionId, FunctionKind, Program, RoutineId, Shape, Storage,
};
use asmotion_value::Value;
use std::collections::BTreeMap;

/// Beyond these bounds nothing is laid out.
const MOST: i64 = 1 << 20;

/// So often the arguments of a routine are found to range wider before they count as unknown.
const PATIENCE: u8 = 4;

/// For each function over integers without end the integers each argument is known to range over;
/// `None` for an argument of another type.
pub(super) fn arguments(program: &Program) -> Vec<(FunctionId, Vec<Option<Interval>>)> {
    let mut reach = Reach {
        program,
        routines: vec![None; program.routines.len()],
        bodies: vec![None; program.bodies.len()],
        used: BTreeMap::new(),
        todo: Vec::new(),
    };
    reach.begin();
    while let Some(part) = reach.todo.pop() {
        reach.part(part);
    }
    reach.used.into_iter().collect()
}

impl Interval {
    /// The axis of arguments within these bounds.
    pub(super) fn axis(self) -> Option<AxisRange> {
        let count = u32::try_from(self.high.checked_sub(self.low)?.checked_add(1)?).ok()?;
        Some(AxisRange::Ints {
            low: self.low,
            count,
        })
    }
}

/// The arguments of a routine or body, and how often they were widened.
type Given = Option<(Vec<Interval>, u8)>;

#[derive(Clone, Copy)]
enum Part {
    Routine(RoutineId),
    Body(BodyId),
}

struct Reach<'p> {
    program: &'p Program,
    routines: Vec<Given>,
    bodies: Vec<Given>,
    used: BTreeMap<FunctionId, Vec<Option<Interval>>>,
    todo: Vec<Part>,
}

impl Reach<'_> {
    /// Whatever runs of its own accord: the main rule, rules that are values, invariants.
    fn begin(&mut self) {
        let values = self.program.rules.iter().filter_map(|rule| rule.routine);
        for routine in self.program.main.into_iter().chain(values) {
            let count = self.program.routines[routine.0 as usize].arguments;
            self.call(Part::Routine(routine), vec![Interval::ANY; count as usize]);
        }
        for invariant in &self.program.invariants {
            self.call(Part::Body(invariant.body), Vec::new());
        }
    }

    /// Notes what a part is called with; it is gone through again if that is more than before.
    fn call(&mut self, part: Part, arguments: Vec<Interval>) {
        let given = match part {
            Part::Routine(routine) => &mut self.routines[routine.0 as usize],
            Part::Body(body) => &mut self.bodies[body.0 as usize],
        };
        let Some((known, widened)) = given else {
            *given = Some((arguments, 0));
            return self.todo.push(part);
        };
        let wider: Vec<Interval> = known
            .iter()
            .zip(&arguments)
            .map(|(known, argument)| known.or(*argument))
            .collect();
        if wider == *known {
            return;
        }
        *widened += 1;
        *known = match *widened > PATIENCE {
            true => vec![Interval::ANY; wider.len()],
            false => wider,
        };
        self.todo.push(part);
    }

    fn part(&mut self, part: Part) {
        let program = self.program;
        let (given, locals) = match part {
            Part::Routine(routine) => {
                let index = routine.0 as usize;
                (&self.routines[index], program.routines[index].locals)
            }
            Part::Body(body) => {
                let index = body.0 as usize;
                (&self.bodies[index], program.bodies[index].locals)
            }
        };
        let mut known = given
            .as_ref()
            .map(|(arguments, _)| arguments.clone())
            .unwrap_or_default();
        known.resize(locals as usize, Interval::ANY);
        match part {
            Part::Routine(routine) => {
                self.rule(&program.routines[routine.0 as usize].code, &mut known);
            }
            Part::Body(body) => {
                self.term(&program.bodies[body.0 as usize].code, &mut known);
            }
        }
    }

    fn rule(&mut self, rule: &Rule, known: &mut Vec<Interval>) {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.rule_here(rule, known));
    }

    fn rule_here(&mut self, rule: &Rule, known: &mut Vec<Interval>) {
        match &*rule.node {
            RuleNode::Skip => {}
            RuleNode::Update(place, value) => {
                self.place(place, known);
                self.term(value, known);
            }
            RuleNode::Assign(place, routine, arguments) => {
                if let Some(place) = place {
                    self.place(place, known);
                }
                let arguments = self.terms(arguments, known);
                self.call(Part::Routine(*routine), arguments);
            }
            RuleNode::Call(routine, arguments) => {
                let arguments = self.terms(arguments, known);
                self.call(Part::Routine(*routine), arguments);
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

    fn place(&mut self, place: &Place, known: &mut Vec<Interval>) {
        match place {
            Place::Slot(..) | Place::Local(_) => {}
            Place::Location(function, arguments) => {
                let arguments = self.terms(arguments, known);
                self.uses(*function, &arguments);
            }
        }
    }

    fn terms(&mut self, terms: &[Term], known: &mut Vec<Interval>) -> Vec<Interval> {
        terms.iter().map(|term| self.term(term, known)).collect()
    }

    fn binders(&mut self, binders: &[Binder], guard: Option<&Term>, known: &mut Vec<Interval>) {
        for binder in binders {
            known[binder.local as usize] = match &binder.range {
                Range::Ints(low, high) => Interval {
                    low: *low,
                    high: *high,
                },
                Range::Elements(term) => {
                    self.term(term, known);
                    Interval::ANY
                }
                Range::Atoms(..) | Range::Bools | Range::Domain(_) => Interval::ANY,
            };
        }
        if let Some(guard) = guard {
            self.term(guard, known);
        }
    }

    fn term(&mut self, term: &Term, known: &mut Vec<Interval>) -> Interval {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.term_here(term, known))
    }

    /// Goes through a term; gives what integers it may be.
    fn term_here(&mut self, term: &Term, known: &mut Vec<Interval>) -> Interval {
        match &*term.node {
            Node::Constant(Value::Int(number)) => return Interval::of(*number),
            Node::Constant(_) | Node::Agent | Node::Slot(..) | Node::Extent(_) | Node::Unbound => {}
            Node::Local(local) => return known[*local as usize],
            Node::Location(function, arguments) => {
                let arguments = self.terms(arguments, known);
                self.uses(*function, &arguments);
            }
            Node::Call(body, arguments) => {
                let arguments = self.terms(arguments, known);
                self.call(Part::Body(*body), arguments);
            }
            Node::Arithmetic(operation, left, right) => {
                let (left, right) = (self.term(left, known), self.term(right, known));
                return Interval::computed(*operation, left, right).0;
            }
            Node::If(guard, then, otherwise) => {
                self.term(guard, known);
                let then = self.term(then, known);
                return then.or(self.term(otherwise, known));
            }
            Node::Let(bindings, body) => {
                for (local, term) in bindings {
                    known[*local as usize] = self.term(term, known);
                }
                return self.term(body, known);
            }
            Node::Quantified(_, binders, guard) => self.binders(binders, guard.as_ref(), known),
            Node::Collect(_, binders, guard, item) => {
                self.binders(binders, guard.as_ref(), known);
                self.term(item, known);
            }
            Node::CollectMap(binders, guard, key, value) => {
                self.binders(binders, guard.as_ref(), known);
                self.term(key, known);
                self.term(value, known);
            }
            Node::Cached(_, term)
            | Node::Watched(term)
            | Node::Pre(term)
            | Node::Not(term)
            | Node::Component(term, _)
            | Node::Name(term)
            | Node::Named(_, term)
            | Node::Program(term) => {
                self.term(term, known);
            }
            Node::Builtin(_, terms) | Node::Tuple(terms) | Node::Listed(_, terms) => {
                self.terms(terms, known);
            }
            Node::Logic(_, left, right)
            | Node::Equal(left, right)
            | Node::Compare(_, left, right) => {
                self.term(left, known);
                self.term(right, known);
            }
            Node::Switch(subject, cases, otherwise) => {
                self.term(subject, known);
                for (case, value) in cases {
                    self.term(case, known);
                    self.term(value, known);
                }
                self.term(otherwise, known);
            }
            Node::Interval(_, from, to, step) => {
                for term in [from, to].into_iter().chain(step) {
                    self.term(term, known);
                }
            }
            Node::Map(pairs) => {
                for (key, value) in pairs {
                    self.term(key, known);
                    self.term(value, known);
                }
            }
        }
        Interval::ANY
    }

    /// Notes a location of a function over integers without end.
    fn uses(&mut self, function: FunctionId, arguments: &[Interval]) {
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

    /// Whether the values of a shape are integers without known bounds.
    fn is_endless(&self, shape: &Shape) -> bool {
        match shape {
            Shape::Int | Shape::Natural => true,
            Shape::Domain(domain) => match self.program.domains[domain.0 as usize] {
                crate::program::Domain {
                    elements: Elements::Computed(_) | Elements::Undefined,
                    base,
                    grows,
                } => base.is_none() && !grows,
                _ => false,
            },
            Shape::Bool
            | Shape::Real
            | Shape::Char
            | Shape::Text
            | Shape::Complex
            | Shape::Rule
            | Shape::Tuple(_)
            | Shape::Seq(_)
            | Shape::Set(_)
            | Shape::Bag(_)
            | Shape::Map(..)
            | Shape::Any => false,
        }
    }
}
