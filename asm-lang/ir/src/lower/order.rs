//! In which order the initial state is made: domains and initial values, each after what it needs.

use super::facts::{definition, visit};
use super::{domain, function_id};
use crate::program::{Elements, Initial, Program};
use asmotion_hir::{Body, DomainId, FunctionId, Model, Term, TermKind, Type};
use std::collections::BTreeSet;

/// The order, and the domains for which there is none.
#[derive(Debug, Default)]
pub(super) struct Order {
    /// Functions with initial values, and domains that must be computed.
    pub steps: Vec<Initial>,
    /// Domains whose definitions lead back to them.
    pub circular: Vec<DomainId>,
}

/// Functions whose initial values depend on each other stand in order of declaration: their values
/// are computed one by one when they are wanted.
pub(super) fn initial(model: &Model, program: &Program) -> Order {
    let mut search = Search {
        model,
        program,
        seen: BTreeSet::new(),
        open: Vec::new(),
        order: Order::default(),
    };
    for index in 0..model.domains.len() as u32 {
        search.add(Node::Domain(DomainId(index)));
    }
    for index in 0..model.functions.len() as u32 {
        search.add(Node::Function(FunctionId(index)));
    }
    search.order
}

/// Whether the initial value of a function depends on other values of the same function.
pub(super) fn is_recursive(model: &Model, function: FunctionId) -> bool {
    let mut seen = BTreeSet::new();
    let mut open = vec![function];
    while let Some(next) = open.pop() {
        for body in bodies(model, Node::Function(next)) {
            for needed in needs(model, &body.root) {
                if needed == Node::Function(function) {
                    return true;
                }
                if let (Node::Function(needed), true) = (needed, seen.insert(needed)) {
                    open.push(needed);
                }
            }
        }
    }
    false
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Node {
    Domain(DomainId),
    Function(FunctionId),
}

struct Search<'a> {
    model: &'a Model,
    program: &'a Program,
    seen: BTreeSet<Node>,
    /// The way here.
    open: Vec<Node>,
    order: Order,
}

impl Search<'_> {
    fn add(&mut self, node: Node) {
        if let Some(start) = self.open.iter().position(|open| *open == node) {
            let circle = self.open[start..].iter().filter_map(|open| match open {
                Node::Domain(domain) => Some(*domain),
                Node::Function(_) => None,
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
            Node::Domain(id) => {
                let elements = &self.program.domains[id.0 as usize].elements;
                if matches!(elements, Elements::Computed(_)) {
                    self.order.steps.push(Initial::Domain(domain::id(id)));
                }
            }
            Node::Function(id) => {
                if model.function(id).initial.is_some() {
                    self.order.steps.push(Initial::Function(function_id(id)));
                }
            }
        }
    }
}

fn bodies(model: &Model, node: Node) -> Vec<&Body<Term>> {
    match node {
        Node::Domain(domain) => model.domain(domain).definition.iter().collect(),
        Node::Function(function) => {
            let declared = model.function(function);
            definition(declared)
                .into_iter()
                .chain(&declared.initial)
                .collect()
        }
    }
}

/// The functions and domains that a term mentions.
fn needs(model: &Model, term: &Term) -> BTreeSet<Node> {
    let mut needed = BTreeSet::new();
    visit(term, &mut |term| match &*term.kind {
        TermKind::Apply(function, _) | TermKind::Spread(function, _) => {
            needed.insert(Node::Function(*function));
        }
        TermKind::Extent(ty) => {
            for part in model.types.reach(*ty, &model.domains) {
                if let Type::Domain(domain) = model.types.get(part) {
                    needed.insert(Node::Domain(*domain));
                }
            }
        }
        _ => {}
    });
    needed
}
