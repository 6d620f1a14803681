//! Calls: a macro is specialised for the arguments that must be passed by name; all other arguments
//! are passed by value.

use super::frame::{Closed, LoweringFrame, VariableBinding, close};
use super::{Lowering, facts};
use crate::code::{RuleNode, Term, TermNode, ValueKind};
use crate::codes::a031::MacroGrows;
use crate::codes::a032::NotALocation;
use crate::id::{Local, Origin, RoutineId};
use asmotion_diagnostics::{Finding, Span};
use asmotion_hir::{TermKind, VarId};
use asmotion_value::RuleId;
use std::rc::Rc;

/// Limit for the nesting of macro specialisations.
const MAX_DEPTH: usize = 64;

/// Limit for the nesting of terms after by-name substitution; the parser's limit is lower.
const MAX_NESTING: usize = 1200;

/// Limit for the number of by-name substitutions in a program.
const MAX_EXPANSIONS: usize = 1 << 20;

/// A rule with, for each parameter, the key of the term substituted for it, or `None` if passed by
/// value.
pub(super) type Special = (RuleId, Vec<Option<String>>);

impl Lowering<'_> {
    /// Returns the routine of a rule with all arguments by value: main rule, turbo rule, or rule
    /// value.
    pub(super) fn routine_by_value(&mut self, rule: RuleId) -> RoutineId {
        let parameters = self.model.rule(rule).parameters.len();
        self.routine(rule, vec![None; parameters], 0)
    }

    /// Returns the routine of a rule for these by-name arguments. Their free variables are passed
    /// as `extras` additional arguments, after those passed by value.
    fn routine(
        &mut self,
        rule: RuleId,
        by_name: Vec<Option<Rc<Closed>>>,
        extras: u32,
    ) -> RoutineId {
        let keys = by_name
            .iter()
            .map(|closed| closed.as_ref().map(|closed| closed.key.clone()))
            .collect();
        let special = (rule, keys);
        if let Some(&known) = self.routines.get(&special) {
            return known;
        }
        let declared = self.model.rule(rule);
        let id = self.reserve_routine(declared);
        self.routines.insert(special, id);
        let Some(body) = &declared.body else {
            return id;
        };
        if self.depth >= MAX_DEPTH {
            let finding = MacroGrows::Argument {
                rule: declared.name.clone(),
                declared: declared.span,
            };
            self.grows(finding);
            return id;
        }
        let mut frame = LoweringFrame::of_rule(rule);
        let mut values = Vec::new();
        for (index, closed) in by_name.into_iter().enumerate() {
            let parameter = VarId(index as u32);
            match closed {
                None => {
                    frame.bind(parameter);
                    values.push(parameter);
                }
                Some(closed) => frame.set(parameter, VariableBinding::Term(closed)),
            }
        }
        frame.locals += extras;
        let arguments = frame.locals;
        self.depth += 1;
        let code = self.with_state(&values, &body.root, &mut frame);
        self.depth -= 1;
        let routine = &mut self.program.routines[id.0 as usize];
        routine.arguments = arguments;
        routine.locals = frame.locals;
        routine.code = code;
        id
    }

    /// Lowers an added rule to a routine.
    pub(super) fn added_routine(
        &mut self,
        id: RuleId,
        body: &asmotion_hir::Body<asmotion_hir::RuleTerm>,
    ) -> RoutineId {
        let routine = self.reserve_routine_at(body.root.span, false);
        let mut frame = LoweringFrame::of_rule(id);
        let code = self.rule(&body.root, &mut frame);
        let added = &mut self.program.routines[routine.0 as usize];
        added.locals = frame.locals;
        added.code = code;
        routine
    }

    /// Substitutes a by-name argument for its parameter.
    pub(super) fn by_name(
        &mut self,
        closed: &Closed,
        frame: &mut LoweringFrame,
        origin: Origin,
    ) -> Term {
        self.expansions += 1;
        if self.nesting <= MAX_NESTING && self.expansions <= MAX_EXPANSIONS {
            frame.within(closed, |frame| self.term(&closed.term, frame))
        } else {
            let finding = MacroGrows::Term {
                at: closed.term.span,
            };
            self.grows(finding);
            Term::undef(origin)
        }
    }

    /// Reports unbounded growth of macros; only once.
    fn grows(&mut self, finding: MacroGrows) {
        if !self.has_grown {
            self.report.push(finding.diagnostic());
        }
        self.has_grown = true;
    }

    /// Lowers a call, and decides for each argument how it is passed.
    pub(super) fn call(
        &mut self,
        rule: RuleId,
        arguments: &[asmotion_hir::Term],
        frame: &mut LoweringFrame,
        span: Span,
    ) -> RuleNode {
        let mut values = Vec::new();
        let mut by_name = Vec::new();
        let mut extras: Vec<Local> = Vec::new();
        let turbo = self.model.rule(rule).turbo;
        let named: Vec<Option<(asmotion_hir::Term, Vec<Option<VariableBinding>>)>> = arguments
            .iter()
            .enumerate()
            .map(|(index, argument)| {
                let (term, bindings) = match self.variable_term(argument, frame) {
                    Some(closed) => (closed.term.clone(), closed.bindings.clone()),
                    None => (argument.clone(), frame.bindings().to_vec()),
                };
                (!turbo && self.is_by_name(rule, index, &term, &bindings))
                    .then_some((term, bindings))
            })
            .collect();
        let value_count = named.iter().filter(|named| named.is_none()).count() as u32;
        for (index, (argument, named)) in arguments.iter().zip(named).enumerate() {
            match named {
                None => {
                    values.push(self.term(argument, frame));
                    by_name.push(None);
                }
                Some((term, bindings)) => {
                    if self.facts.assigns(rule, VarId(index as u32))
                        && !is_location(self.model, &term, &bindings)
                    {
                        self.not_a_location(rule, index, argument.span);
                    }
                    by_name.push(Some(Rc::new(close(
                        &term,
                        &bindings,
                        &mut extras,
                        value_count,
                    ))));
                }
            }
        }
        let origin = self.origin(span);
        let extra_count = extras.len() as u32;
        values.extend(extras.into_iter().map(|local| Term {
            node: Box::new(TermNode::Local(local)),
            kind: ValueKind::Other,
            origin,
        }));
        RuleNode::Call(self.routine(rule, by_name, extra_count), values)
    }

    /// Returns the by-name argument that a variable stands for, if the term is such a variable.
    fn variable_term(
        &self,
        term: &asmotion_hir::Term,
        frame: &LoweringFrame,
    ) -> Option<Rc<Closed>> {
        let TermKind::Variable(variable) = &*term.kind else {
            return None;
        };
        match frame.binding(*variable) {
            Some(VariableBinding::Term(closed)) => Some(closed),
            Some(VariableBinding::Local(_) | VariableBinding::State { .. }) | None => None,
        }
    }

    /// Decides if an argument must be passed by name. By name and by value differ in three cases:
    /// the macro writes the parameter, the macro reads it again after an intermediate state, or the
    /// macro may skip an argument whose evaluation fails or asks the environment. The last case is
    /// ignored for recursive macros, whose specialisation would not terminate.
    fn is_by_name(
        &self,
        rule: RuleId,
        parameter: usize,
        argument: &asmotion_hir::Term,
        bindings: &[Option<VariableBinding>],
    ) -> bool {
        let parameter = VarId(parameter as u32);
        let holds_name = || {
            let mut found = false;
            facts::visit(argument, &mut |term| {
                if let TermKind::Variable(variable) = &*term.kind {
                    found |= matches!(
                        bindings.get(variable.0 as usize),
                        Some(Some(
                            VariableBinding::Term(_) | VariableBinding::State { .. }
                        ))
                    );
                }
            });
            found
        };
        self.facts.assigns(rule, parameter)
            || (self.facts.is_sequential(rule) && (self.facts.is_dynamic(argument) || holds_name()))
            || (!self.facts.is_recursive(rule)
                && !self.facts.needs(rule, parameter)
                && (holds_name() || !self.facts.is_silent(self.model, argument)))
    }

    fn not_a_location(&mut self, rule: RuleId, parameter: usize, span: Span) {
        let declared = self.model.rule(rule);
        let parameter = declared.body.as_ref().map_or_else(String::new, |body| {
            body.variables[parameter].name.to_string()
        });
        let finding = NotALocation {
            rule: declared.name.clone(),
            parameter,
            at: span,
            declared: declared.span,
        };
        self.report.push(finding.diagnostic());
    }
}

/// Returns `true` if a term is a location that rules may update.
fn is_location(
    model: &asmotion_hir::Model,
    term: &asmotion_hir::Term,
    bindings: &[Option<VariableBinding>],
) -> bool {
    if let TermKind::Variable(variable) = &*term.kind {
        return matches!(
            bindings.get(variable.0 as usize),
            Some(Some(VariableBinding::State { .. }))
        );
    }
    term.kind.function().is_some_and(|function| {
        matches!(
            model.function(function).kind,
            asmotion_hir::FunctionKind::Controlled
                | asmotion_hir::FunctionKind::Out
                | asmotion_hir::FunctionKind::Shared
                | asmotion_hir::FunctionKind::Local
        )
    })
}
