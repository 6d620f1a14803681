//! Lowering: translates a model to a program.

mod call;
mod constant;
mod domain;
mod facts;
mod frame;
mod layout;
mod lint;
mod message;
mod needs;
mod order;
mod reach;
mod rule;
mod term;
mod uses;
mod watched;

use crate::code::{Body, Rule, RuleNode, Term};
use crate::codes::a035::CircularDomain;
use crate::id::{BodyId, FunctionId, Origin, RoutineId};
use crate::program::{DomainElements, Initial, Invariant, Program, RuleValue, Symbols};
pub use facts::{visit as visit_terms, walk as visit_rules};
pub use layout::MAX_CREATED;

pub use message::{MessageRole, MessageUse, message_uses};
pub use uses::{UnreachedLiteral, applied_functions, read_functions, unreached_literals};
pub use watched::is_watched;

use asmotion_diagnostics::{Finding, Report, Span};
use asmotion_hir::{Meaning, Model};
use asmotion_value::RuleId;
use facts::Facts;
use frame::LoweringFrame;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Default limit of eager slots for a function: most locations of a larger one are usually never
/// accessed.
const MAX_DENSE: u32 = 1 << 16;

/// Default limit of lazy slots for a function. That many take 100 MB.
const MAX_LAZY: u32 = 1 << 21;

/// A program with the source spans of its parts.
#[derive(Debug)]
pub struct Lowered {
    /// The program, ready for a machine.
    pub program: Program,
    /// The span of each [`Origin`], indexed by its number.
    pub origins: Vec<Span>,
    /// Warnings found during lowering.
    pub warnings: Report,
}

/// Lowers a model with the default limits for slots.
///
/// # Errors
/// A macro cannot be specialised, a domain depends on itself, or a message does not fit its
/// receiver.
pub fn lower(model: &Model) -> Result<Lowered, Report> {
    lower_with(model, MAX_DENSE, MAX_LAZY)
}

/// Lowers a model. Functions with more than `dense` locations have lazy slots, or interned locations if they have more than
/// `lazy`. The limits affect performance only, not the run. Functions without arguments always have a slot.
///
/// # Errors
/// As [`lower`].
pub fn lower_with(model: &Model, dense: u32, lazy: u32) -> Result<Lowered, Report> {
    let mut lowering = Lowering::new(model, dense, lazy);
    lowering.layout();
    lowering.definitions();
    lowering.initial_state();
    lowering.invariants();
    let main = model.main.map(|rule| lowering.routine_by_value(rule));
    lowering.rule_values();
    lowering.program.main = main;
    message::check(model, &mut lowering.report);
    lowering.lazy_layout();
    lowering.added();
    if lowering.report.has_errors() {
        return Err(lowering.report.finish());
    }
    Ok(Lowered {
        program: lowering.program,
        origins: lowering.origins,
        warnings: lint::warnings(model, &lowering.facts),
    })
}

/// State of the translation of one model.
struct Lowering<'a> {
    model: &'a Model,
    facts: Facts,
    program: Program,
    origins: Vec<Span>,
    origin_ids: BTreeMap<Span, Origin>,
    report: Report,
    /// The body of each function with a definition.
    definitions: BTreeMap<asmotion_hir::FunctionId, BodyId>,
    /// The cache of each static function without arguments.
    caches: BTreeMap<asmotion_hir::FunctionId, u32>,
    /// The routine of each rule, for each combination of arguments passed by name.
    routines: BTreeMap<call::Special, RoutineId>,
    /// Depth of nested macro specialisations.
    depth: usize,
    /// Nesting depth of the term that is being lowered.
    nesting: usize,
    /// Number of by-name terms substituted so far.
    expansions: usize,
    /// `true` once unbounded growth of such terms was reported.
    has_grown: bool,
    /// Functions with more locations than this have no eager slots.
    dense: u64,
    /// Functions with more locations than this have no lazy slots.
    lazy: u64,
}

impl<'a> Lowering<'a> {
    fn new(model: &'a Model, dense: u32, lazy: u32) -> Self {
        let names = |names: &mut dyn Iterator<Item = &Arc<str>>| names.cloned().collect();
        let symbols = Symbols {
            atoms: names(&mut model.atoms.iter().map(|atom| &atom.name)),
            functions: names(&mut model.functions.iter().map(|function| &function.name)),
            domains: names(&mut model.domains.iter().map(|domain| &domain.name)),
            rules: names(&mut model.rules.iter().map(|rule| &rule.name)),
            rule_domains: model
                .rules
                .iter()
                .map(|rule| rule_domains(model, rule))
                .collect(),
        };
        let atoms = model.atoms.iter();
        let program = Program {
            symbols,
            atom_domains: atoms.map(|atom| domain::id(atom.domain)).collect(),
            domains: Vec::new(),
            functions: Vec::new(),
            eager: 0,
            slots: 0,
            dense: Vec::new(),
            initial_order: Vec::new(),
            initial_inputs: Vec::new(),
            bodies: Vec::new(),
            routines: Vec::new(),
            rules: Vec::new(),
            programs: Vec::new(),
            main: None,
            invariants: Vec::new(),
            added_terms: Vec::new(),
            added_rules: Vec::new(),
            compatible: model.compatible,
            counted: Vec::new(),
            caches: 0,
            result: 0,
            variables: function_id(model.reserved.variables),
            messages: message::messages(model),
        };
        Self {
            model,
            facts: Facts::of(model),
            program,
            // origin 0: parts added from outside have no place
            origins: vec![Span::default()],
            origin_ids: BTreeMap::new(),
            report: Report::new(),
            definitions: BTreeMap::new(),
            caches: BTreeMap::new(),
            routines: BTreeMap::new(),
            depth: 0,
            nesting: 0,
            expansions: 0,
            has_grown: false,
            dense: u64::from(dense.max(1)),
            lazy: u64::from(lazy),
        }
    }

    fn origin(&mut self, span: Span) -> Origin {
        let next = Origin(self.origins.len() as u32);
        let origins = &mut self.origins;
        *self.origin_ids.entry(span).or_insert_with(|| {
            origins.push(span);
            next
        })
    }

    fn definitions(&mut self) {
        // Allocate the ids first, because definitions may be recursive.
        for (index, function) in self.model.functions.iter().enumerate() {
            if let Meaning::Defined(body) = &function.meaning {
                let id = self.reserve_body(body.root.span, body);
                self.definitions
                    .insert(asmotion_hir::FunctionId(index as u32), id);
                let function_id = asmotion_hir::FunctionId(index as u32);
                if function.parameters.is_empty() && self.facts.is_static(function_id) {
                    self.caches.insert(function_id, self.program.caches);
                    self.program.caches += 1;
                }
            }
        }
        let defined: Vec<(asmotion_hir::FunctionId, BodyId)> = self
            .definitions
            .iter()
            .map(|(&function, &body)| (function, body))
            .collect();
        for (function, id) in defined {
            if let Meaning::Defined(body) = &self.model.function(function).meaning {
                self.fill_body(id, body);
            }
        }
        for (index, domain) in self.model.domains.iter().enumerate() {
            if let (DomainElements::Computed(id), Some(body)) = (
                self.program.domains[index].elements.clone(),
                &domain.definition,
            ) {
                self.fill_body(id, body);
            }
        }
    }

    fn initial_state(&mut self) {
        for (index, function) in self.model.functions.iter().enumerate() {
            if let Some(body) = &function.initial {
                let id = self.body(function.span, body);
                self.program.functions[index].initial = Some(id);
            }
        }
        let order = order::initial(self.model, &self.program);
        for circular in &order.circular {
            let domain = self.model.domain(*circular);
            let at = domain
                .definition
                .as_ref()
                .map_or(domain.span, |definition| definition.root.span);
            let finding = CircularDomain {
                domain: domain.name.clone(),
                at,
                declared: domain.span,
            };
            self.report.push(finding.diagnostic());
        }
        // the reference computes no initial state: a location gets its value on first access
        let lazy = |initial: &Initial| matches!(initial, Initial::Function(_));
        (self.program.initial_inputs, self.program.initial_order) = order
            .steps
            .into_iter()
            .filter(|initial| !(self.model.compatible && lazy(initial)))
            .partition(|&initial| self.begins_with_input(initial));
    }

    fn begins_with_input(&self, initial: Initial) -> bool {
        match initial {
            Initial::Function(function) => self
                .facts
                .begins_with_input(asmotion_hir::FunctionId(function.0)),
            Initial::Domain(domain) => self
                .model
                .domain(asmotion_hir::DomainId(domain.0))
                .definition
                .as_ref()
                .is_some_and(|definition| self.facts.reads_input(&definition.root)),
        }
    }

    fn invariants(&mut self) {
        for invariant in &self.model.invariants {
            let body = self.body(invariant.span, &invariant.condition);
            let assumes = self.facts.reads_monitored(&invariant.condition.root);
            let root = &invariant.condition.root;
            // where initial values are computed on first access, the invariant is what reads them
            let begins = self.model.compatible && self.facts.may_begin_with_input(root);
            let waits = !assumes && (begins || self.facts.reads_input(root));
            let origin = self.origin(invariant.condition.root.span);
            let name = invariant.name.clone();
            self.program.invariants.push(Invariant {
                name,
                body,
                assumes,
                waits,
                is_constraint: false,
                origin,
            });
        }
        self.watched_constraints();
    }

    /// Constraints that read inputs are assumptions about them, like such invariants.
    fn watched_constraints(&mut self) {
        let model = self.model;
        let watched = model.properties.iter().filter(|it| is_watched(model, it));
        for constraint in watched {
            let [condition] = constraint.formulas.as_slice() else {
                continue;
            };
            let body = self.body(constraint.span, condition);
            let origin = self.origin(condition.root.span);
            self.program.invariants.push(Invariant {
                name: constraint
                    .name
                    .clone()
                    .unwrap_or_else(|| constraint.text.clone()),
                body,
                assumes: true,
                waits: false,
                is_constraint: true,
                origin,
            });
        }
    }

    fn rule_values(&mut self) {
        for index in 0..self.model.rules.len() {
            let id = RuleId(index as u32);
            let rule = self.model.rule(id);
            let assigns = self.facts.assigns_parameter(id, rule.parameters.len());
            let is_value = self.facts.rule_values.contains(&id) && !assigns;
            let routine = (is_value && rule.body.is_some()).then(|| self.routine_by_value(id));
            let returns = self.leaves_result(id);
            self.program.rules.push(RuleValue {
                routine,
                returns,
                arguments: Vec::new(),
            });
        }
        for program in &self.model.programs {
            let span = self.model.rule(program.rule).span;
            let arguments: Vec<BodyId> = program
                .arguments
                .iter()
                .map(|argument| self.body(span, argument))
                .collect();
            let rule = if arguments.is_empty() {
                program.rule
            } else {
                let routine = self.routine_by_value(program.rule);
                self.program.rules.push(RuleValue {
                    routine: Some(routine),
                    returns: self.leaves_result(program.rule),
                    arguments,
                });
                let rule = self.model.rule(program.rule);
                let symbols = &mut self.program.symbols;
                symbols.rules.push(rule.name.clone());
                symbols.rule_domains.push(rule_domains(self.model, rule));
                RuleId(self.program.rules.len() as u32 - 1)
            };
            self.program
                .programs
                .push((domain::id(program.domain), rule));
        }
    }

    /// Lowers the added terms and rules. They contribute code but no locations.
    fn added(&mut self) {
        for body in &self.model.added.terms {
            let id = self.body(body.root.span, body);
            self.program.added_terms.push(id);
        }
        let model = self.model;
        for (body, rule) in model.added.rules.iter().zip(facts::added_rules(model)) {
            let id = self.added_routine(rule, body);
            self.program.added_rules.push(id);
        }
    }

    fn reserve_body(
        &mut self,
        span: Span,
        body: &asmotion_hir::Body<asmotion_hir::Term>,
    ) -> BodyId {
        let origin = self.origin(span);
        let code = Term::undef(origin);
        let arguments = body.variables.iter().take(body.parameters);
        let open = self.is_open(body.root.ty)
            || arguments
                .into_iter()
                .any(|argument| self.is_open(argument.ty));
        self.program.bodies.push(Body {
            arguments: body.parameters as u32,
            locals: body.variables.len() as u32,
            code,
            origin,
            open,
        });
        BodyId(self.program.bodies.len() as u32 - 1)
    }

    fn fill_body(&mut self, id: BodyId, body: &asmotion_hir::Body<asmotion_hir::Term>) {
        let mut frame = LoweringFrame::of(body.parameters, body.variables.len());
        let code = self.term(&body.root, &mut frame);
        let slot = &mut self.program.bodies[id.0 as usize];
        slot.code = code;
        slot.locals = frame.locals;
    }

    fn body(&mut self, span: Span, body: &asmotion_hir::Body<asmotion_hir::Term>) -> BodyId {
        let id = self.reserve_body(span, body);
        self.fill_body(id, body);
        id
    }

    fn reserve_routine(&mut self, rule: &asmotion_hir::Rule) -> RoutineId {
        let open = rule.parameters.iter().any(|&ty| self.is_open(ty));
        self.reserve_routine_at(rule.span, open)
    }

    fn reserve_routine_at(&mut self, span: Span, open: bool) -> RoutineId {
        let origin = self.origin(span);
        let code = Rule {
            node: Box::new(RuleNode::Skip),
            origin,
        };
        self.program.routines.push(Body {
            arguments: 0,
            locals: 0,
            code,
            origin,
            open,
        });
        RoutineId(self.program.routines.len() as u32 - 1)
    }
}

/// Returns the domains of a rule's parameters as text.
fn rule_domains(model: &Model, rule: &asmotion_hir::Rule) -> Arc<str> {
    let domains = rule.parameters.iter().map(|&ty| model.show_type(ty));
    domains.collect::<Vec<_>>().join(",").into()
}

/// Converts the id of a function, whose number is the same in the model and in the program.
fn function_id(id: asmotion_hir::FunctionId) -> FunctionId {
    FunctionId(id.0)
}
