//! The order in which the initial state is computed: domains and initial values, each after those
//! it depends on.

use super::facts::{definition, visit};
use super::{domain, function_id};
use crate::program::{DomainElements, Initial, Program};
use asmotion_hir::{Body, DomainId, FunctionId, Model, Term, TermKind};
use std::collections::BTreeSet;

/// A topological order, and the domains that have none.
#[derive(Debug, Default)]
pub(super) struct InitialOrder {
    /// Functions with initial values, and domains that must be computed, in order of dependency.
    pub steps: Vec<Initial>,
    /// Domains whose definitions depend on themselves.
    pub circular: Vec<DomainId>,
}

/// Determines the order. Functions whose initial values depend on each other stand in order of
/// declaration; their values are computed one by one on first access.
pub(super) fn initial(model: &Model, program: &Program) -> InitialOrder {
    let mut search = OrderSearch {
        model,
        program,
        seen: BTreeSet::new(),
        open: Vec::new(),
        order: InitialOrder::default(),
    };
    for index in 0..model.domains.len() as u32 {
        search.add(OrderNode::Domain(DomainId(index)));
    }
    for (index, function) in model.functions.iter().enumerate() {
        if function.initial.is_some() || definition(function).is_some() {
            search.add(OrderNode::Function(FunctionId(index as u32)));
        }
    }
    search.order
}

/// Returns `true` if initial values of a function depend on other values of the same function.
pub(super) fn is_recursive(model: &Model, function: FunctionId) -> bool {
    let mut seen = BTreeSet::new();
    let mut open = vec![function];
    while let Some(next) = open.pop() {
        for body in bodies(model, OrderNode::Function(next)) {
            for needed in needs(model, &body.root) {
                if needed == OrderNode::Function(function) {
                    return true;
                }
                if let (OrderNode::Function(needed), true) = (needed, seen.insert(needed)) {
                    open.push(needed);
                }
            }
        }
    }
    false
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum OrderNode {
    Domain(DomainId),
    Function(FunctionId),
}

struct OrderSearch<'a> {
    model: &'a Model,
    program: &'a Program,
    seen: BTreeSet<OrderNode>,
    /// The path of the depth-first search.
    open: Vec<OrderNode>,
    order: InitialOrder,
}

impl OrderSearch<'_> {
    fn add(&mut self, node: OrderNode) {
        if let Some(start) = self.open.iter().position(|open| *open == node) {
            let circle = self.open[start..].iter().filter_map(|open| match open {
                OrderNode::Domain(domain) => Some(*domain),
                OrderNode::Function(_) => None,
            });
            let first = circle.min();
            self.order.circular.extend(first);
        }
        if !self.seen.insert(node) {
            return;
        }
        self.open.push(node);
        let model = self.model;
        for body in bodies(model, node) {
            for needed in needs(model, &body.root) {
                stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.add(needed));
            }
        }
        self.open.pop();
        match node {
            OrderNode::Domain(id) => {
                let elements = &self.program.domains[id.0 as usize].elements;
                if matches!(elements, DomainElements::Computed(_)) {
                    self.order.steps.push(Initial::Domain(domain::id(id)));
                }
            }
            OrderNode::Function(id) => {
                if model.function(id).initial.is_some() {
                    self.order.steps.push(Initial::Function(function_id(id)));
                }
            }
        }
    }
}

fn bodies(model: &Model, node: OrderNode) -> Vec<&Body<Term>> {
    match node {
        OrderNode::Domain(domain) => model.domain(domain).definition.iter().collect(),
        OrderNode::Function(function) => {
            let declared = model.function(function);
            definition(declared)
                .into_iter()
                .chain(&declared.initial)
                .collect()
        }
    }
}

/// Returns the functions and domains that a term refers to.
fn needs(model: &Model, term: &Term) -> BTreeSet<OrderNode> {
    let mut needed = BTreeSet::new();
    visit(term, &mut |term| {
        needed.extend(term.kind.function().map(OrderNode::Function));
        if let TermKind::Extent(ty) = &*term.kind {
            let parts = model.types.reachable_types(*ty, &model.domains);
            let domains = parts.filter_map(|part| model.types.get(part).as_domain());
            needed.extend(domains.map(OrderNode::Domain));
        }
    });
    needed
}
