//! Control-state diagrams: the control states of a specification, and the transitions between them that its rules contain.
//!
//! A control state ASM (Börger & Stärk, section 2.2.6) has a function whose value names the phase it is in. The diagram is read
//! from the text of the rules: guards that compare the control state with a literal restrict the states in which an update can
//! be made, and every other guard is kept as text. It is an over-approximation: guards that exclude each other are not compared.

use crate::specification::Specification;
use asmotion_diagnostics::Span;
use asmotion_hir::{
    DomainKind, FunctionId, FunctionKind, Meaning, Model, RuleKind, RuleTerm, Term, TermKind,
    UpdateTarget, VarId,
};
use asmotion_value::{Atom, RuleId, Value};
use std::collections::BTreeMap;

/// Nesting of rule calls beyond which no transition is read, which ends recursion.
const MAX_CALLS: usize = 24;

/// The control states of a specification and the transitions between them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ControlDiagram {
    /// The location with the control state, for example `mode`.
    pub location: String,
    /// All control states, in order of declaration.
    pub states: Vec<String>,
    /// The control state in the initial state; `None` if it is not a literal.
    pub initial: Option<String>,
    /// The transitions, in order of their rules in the text; equal ones are listed once.
    pub transitions: Vec<ControlTransition>,
}

/// An update of the control state by a literal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ControlTransition {
    /// The control states in which it can be made, in order of declaration.
    pub from: Vec<String>,
    /// The next control state.
    pub to: String,
    /// Other conditions under which it is made, outermost first, as in the text.
    pub guards: Vec<String>,
    /// Line of the update, or of the call whose argument is the next control state, from 1.
    pub line: usize,
}

impl Specification {
    /// The control-state diagrams: one for each controlled function without arguments whose values are the literals of an
    /// enumeration, and to which a rule assigns a literal.
    pub fn control_diagrams(&self) -> Vec<ControlDiagram> {
        let functions = self.model.own_functions();
        let diagrams = functions.filter_map(|(id, _)| ControlReader::new(self, id)?.read());
        diagrams.collect()
    }
}

/// Reads the transitions of one function.
struct ControlReader<'s> {
    specification: &'s Specification,
    control: FunctionId,
    first: Atom,
    states: Vec<String>,
    transitions: Vec<ControlTransition>,
}

/// The way to a rule: what is known when it is executed.
#[derive(Clone)]
struct Place {
    /// For each control state, in order of declaration, `true` if the rule can be executed in it.
    possible: Vec<bool>,
    guards: Vec<String>,
    /// The variables of the enclosing rule that stand for terms: values and texts.
    arguments: BTreeMap<VarId, Argument>,
    calls: Vec<RuleId>,
}

/// The argument of a macro.
#[derive(Clone)]
struct Argument {
    atom: Option<Atom>,
    text: String,
    span: Span,
}

impl<'s> ControlReader<'s> {
    fn new(specification: &'s Specification, control: FunctionId) -> Option<Self> {
        let model = &specification.model;
        let function = model.function(control);
        let is_updated = matches!(
            function.kind,
            FunctionKind::Controlled | FunctionKind::Shared
        );
        let domain = model.types.get(function.codomain).as_domain()?;
        let DomainKind::Enum { first, count } = model.domain(domain).kind else {
            return None;
        };
        let name = |index| {
            model
                .atoms
                .get(index as usize)
                .map(|it| it.name.to_string())
        };
        let states = (first.0..first.0 + count)
            .map(name)
            .collect::<Option<_>>()?;
        (is_updated && function.parameters.is_empty()).then_some(Self {
            specification,
            control,
            first,
            states,
            transitions: Vec::new(),
        })
    }

    fn model(&self) -> &'s Model {
        &self.specification.model
    }

    fn read(mut self) -> Option<ControlDiagram> {
        let model = self.model();
        let programs = model.programs.iter().map(|it| it.rule);
        let roots: Vec<RuleId> = model.main.into_iter().chain(programs).collect();
        for root in roots {
            let place = Place {
                possible: vec![true; self.states.len()],
                guards: Vec::new(),
                arguments: BTreeMap::new(),
                calls: vec![root],
            };
            if let Some(body) = &model.rule(root).body {
                self.rule(&body.root, &place);
            }
        }
        if self.transitions.is_empty() {
            return None;
        }
        let function = model.function(self.control);
        let initial = function.initial.as_ref();
        let initial = initial.and_then(|body| self.atom(&body.root, &BTreeMap::new()));
        self.transitions.sort_by_key(|it| it.line);
        self.transitions.dedup();
        Some(ControlDiagram {
            location: function.name.to_string(),
            initial: initial.and_then(|atom| self.states.get(self.index(atom)?).cloned()),
            states: self.states,
            transitions: self.transitions,
        })
    }

    fn rule(&mut self, rule: &RuleTerm, place: &Place) {
        if !place.possible.contains(&true) {
            return;
        }
        match &*rule.kind {
            RuleKind::Update(UpdateTarget::Location(function, _), value) => {
                if *function == self.control {
                    self.transition(value, rule.span, place);
                }
            }
            RuleKind::Call(called, arguments) => self.call(*called, arguments, place),
            RuleKind::Par(rules) | RuleKind::Seq(rules) => {
                rules.iter().for_each(|rule| self.rule(rule, place));
            }
            RuleKind::If(guard, then, other) => {
                self.rule(then, &self.under(place, guard, true));
                if let Some(other) = other {
                    self.rule(other, &self.under(place, guard, false));
                }
            }
            RuleKind::Switch(subject, cases, other) => self.switch(subject, cases, other, place),
            RuleKind::Choose(_, guard, body, none) => {
                let inner = guard.as_ref().map(|guard| self.under(place, guard, true));
                self.rule(body, inner.as_ref().unwrap_or(place));
                if let Some(none) = none {
                    self.rule(none, place);
                }
            }
            RuleKind::Forall(_, guard, body) => {
                let inner = guard.as_ref().map(|guard| self.under(place, guard, true));
                self.rule(body, inner.as_ref().unwrap_or(place));
            }
            RuleKind::Let(_, body)
            | RuleKind::Extend(_, _, body)
            | RuleKind::While(_, body)
            | RuleKind::WhileRec(_, body)
            | RuleKind::Iterate(body) => self.rule(body, place),
            RuleKind::Local(local) => self.rule(&local.body, place),
            RuleKind::Skip
            | RuleKind::Update(UpdateTarget::Variable(_), _)
            | RuleKind::Assign(..)
            | RuleKind::Run(..)
            | RuleKind::Invalid => {}
        }
    }

    fn transition(&mut self, value: &Term, span: Span, place: &Place) {
        let Some(to) = self
            .atom(value, &place.arguments)
            .and_then(|it| self.index(it))
        else {
            return;
        };
        // an argument names the place better than the macro that all calls share
        let argument = variable(value).and_then(|it| place.arguments.get(&it));
        let span = argument.map_or(span, |it| it.span);
        let (line, _) = self.specification.sources.position(span.file, span.start);
        let from = self.states.iter().zip(&place.possible);
        self.transitions.push(ControlTransition {
            from: from
                .filter(|(_, is)| **is)
                .map(|(state, _)| state.clone())
                .collect(),
            to: self.states[to].clone(),
            guards: place.guards.clone(),
            line,
        });
    }

    fn call(&mut self, called: RuleId, arguments: &[Term], place: &Place) {
        let rule = self.model().rule(called);
        let is_recursive = place.calls.contains(&called) || place.calls.len() > MAX_CALLS;
        let Some(body) = rule
            .body
            .as_ref()
            .filter(|_| !is_recursive && !rule.library)
        else {
            return;
        };
        let variables = (0..).map(VarId);
        let passed = variables.zip(arguments).map(|(variable, argument)| {
            let outer = self::variable(argument).and_then(|it| place.arguments.get(&it).cloned());
            let own = || Argument {
                atom: self.atom(argument, &place.arguments),
                text: self.text(argument, place),
                span: argument.span,
            };
            (variable, outer.unwrap_or_else(own))
        });
        let mut inner = Place {
            arguments: passed.collect(),
            ..place.clone()
        };
        inner.calls.push(called);
        self.rule(&body.root, &inner);
    }

    fn switch(
        &mut self,
        subject: &Term,
        cases: &[(Term, RuleTerm)],
        other: &Option<RuleTerm>,
        place: &Place,
    ) {
        let is_control = self.is_control(subject);
        let mut rest = place.clone();
        for (case, rule) in cases {
            let mut inner = place.clone();
            let state = self
                .atom(case, &place.arguments)
                .and_then(|it| self.index(it));
            match state.filter(|_| is_control) {
                Some(state) => {
                    inner
                        .possible
                        .iter_mut()
                        .enumerate()
                        .for_each(|(index, is)| *is &= index == state);
                    rest.possible[state] = false;
                }
                None => {
                    let guard =
                        format!("{} = {}", self.text(subject, place), self.text(case, place));
                    inner.guards.push(guard);
                }
            }
            self.rule(rule, &inner);
        }
        if let Some(other) = other {
            if !is_control {
                rest.guards
                    .push(format!("{} is another", self.text(subject, place)));
            }
            self.rule(other, &rest);
        }
    }

    /// The place behind a guard, or behind its negation.
    fn under(&self, place: &Place, guard: &Term, holds: bool) -> Place {
        let mut inner = place.clone();
        match self.states_of(guard, place) {
            Some(states) => {
                let states = states.into_iter().map(|state| state == holds);
                inner
                    .possible
                    .iter_mut()
                    .zip(states)
                    .for_each(|(is, can)| *is &= can);
            }
            // the conjuncts about the control state restrict it, the others are kept as text
            None => match self.application(guard) {
                Some(("and", [left, right])) if holds => {
                    return self.under(&self.under(place, left, true), right, true);
                }
                Some(("or", [left, right])) if !holds => {
                    return self.under(&self.under(place, left, false), right, false);
                }
                Some(("not", [inner])) => return self.under(place, inner, !holds),
                _ => {
                    let text = self.text(guard, place);
                    inner.guards.push(match (holds, text.contains(' ')) {
                        (true, _) => text,
                        (false, false) => format!("not {text}"),
                        (false, true) => format!("not ({text})"),
                    });
                }
            },
        }
        inner
    }

    /// The control states in which a condition holds; `None` if it depends on anything else.
    fn states_of(&self, condition: &Term, place: &Place) -> Option<Vec<bool>> {
        match self.application(condition)? {
            (name @ ("eq" | "neq"), [left, right]) => {
                let literal = if self.is_control(left) {
                    right
                } else if self.is_control(right) {
                    left
                } else {
                    return None;
                };
                let state = self.index(self.atom(literal, &place.arguments)?)?;
                let states = 0..self.states.len();
                Some(
                    states
                        .map(|index| (index == state) == (name == "eq"))
                        .collect(),
                )
            }
            ("not", [inner]) => {
                let states = self.states_of(inner, place)?;
                Some(states.into_iter().map(|is| !is).collect())
            }
            (name @ ("and" | "or"), [left, right]) => {
                let (left, right) = (self.states_of(left, place)?, self.states_of(right, place)?);
                let both = left.into_iter().zip(right);
                let joined = both.map(|(one, other)| {
                    if name == "and" {
                        one && other
                    } else {
                        one || other
                    }
                });
                Some(joined.collect())
            }
            _ => None,
        }
    }

    /// A function of the standard library with its arguments, if the term applies one.
    fn application<'t>(&self, term: &'t Term) -> Option<(&'s str, &'t [Term])> {
        let (function, arguments) = if let TermKind::Apply(function, arguments) = &*term.kind {
            (function, arguments)
        } else if let TermKind::Spread(function, tuple) = &*term.kind
            && let TermKind::Tuple(arguments) = &*tuple.kind
        {
            (function, arguments)
        } else {
            return None;
        };
        let function = self.model().function(*function);
        function.library.then_some((&*function.name, arguments))
    }

    fn is_control(&self, term: &Term) -> bool {
        term.kind.function() == Some(self.control)
    }

    /// The literal that a term stands for.
    fn atom(&self, term: &Term, arguments: &BTreeMap<VarId, Argument>) -> Option<Atom> {
        if let TermKind::Value(Value::Atom(atom)) = &*term.kind {
            return Some(*atom);
        }
        if let Some(variable) = variable(term) {
            return arguments.get(&variable)?.atom;
        }
        let function = self.model().function(term.kind.function()?);
        if let Meaning::Constant(atom) = function.meaning {
            Some(atom)
        } else {
            None
        }
    }

    fn index(&self, atom: Atom) -> Option<usize> {
        let index = atom.0.checked_sub(self.first.0)? as usize;
        (index < self.states.len()).then_some(index)
    }

    /// The text of a term on one line, with the arguments of the macro that contains it.
    fn text(&self, term: &Term, place: &Place) -> String {
        let argument = variable(term).and_then(|it| place.arguments.get(&it));
        if let Some(argument) = argument {
            return argument.text.clone();
        }
        let text = self.specification.sources.snippet(term.span);
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    }
}

/// The variable, if the term is one.
fn variable(term: &Term) -> Option<VarId> {
    if let TermKind::Variable(variable) = *term.kind {
        Some(variable)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use crate::{MemoryFiles, open};

    fn diagram(rules: &str) -> Vec<String> {
        let mut files = MemoryFiles::new();
        let text = format!(
            "asm light\nimport StandardLibrary\nsignature:\n enum domain Mode = {{RED | GREEN | DARK}}\n \
             monitored fault: Boolean\n monitored pressed: Boolean\n controlled mode: Mode\n controlled n: Integer\n\
             definitions:\n{rules}\ndefault init s0:\n function mode = RED\n function n = 0\n"
        );
        files.add("light.asm", text.as_str());
        let specification = open("light.asm", &files).unwrap();
        let [diagram] = specification.control_diagrams().try_into().unwrap();
        assert_eq!(diagram.location, "mode");
        assert_eq!(diagram.initial.as_deref(), Some("RED"));
        let transitions = diagram.transitions.iter();
        transitions
            .map(|it| {
                format!(
                    "{} -> {} if {} at {}",
                    it.from.join("|"),
                    it.to,
                    it.guards.join(" & "),
                    it.line
                )
            })
            .collect()
    }

    #[test]
    fn guards_on_the_control_state_restrict_a_transition_and_others_label_it() {
        let found = diagram(
            " main rule r_Main =\n  if fault then\n   mode := DARK\n  else switch mode\n   case RED:\n    if pressed then mode := GREEN endif\n   \
             case GREEN:\n    mode := RED\n  endswitch endif",
        );
        assert_eq!(
            found,
            [
                "RED|GREEN|DARK -> DARK if fault at 12",
                "RED -> GREEN if not fault & pressed at 15",
                "GREEN -> RED if not fault at 17",
            ]
        );
    }

    #[test]
    fn a_macro_passes_the_next_state_on() {
        let found = diagram(
            " macro rule r_enter($next in Mode) =\n  if mode != $next then mode := $next endif\n main rule r_Main =\n  par\n   \
             if (mode = RED or mode = GREEN) and n > 2 then\n    r_enter[DARK]\n   endif\n   n := n + 1\n  endpar",
        );
        assert_eq!(found, ["RED|GREEN -> DARK if n > 2 at 15"]);
    }
}
