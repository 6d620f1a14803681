//! CTL by its definition: fixpoints on sets, and fair paths by enumeration of subgraphs.

use crate::random::Structure;
use asmotion_temporal::{Bits, Ctl, FairPaths, Fairness, Recurrent};

fn edges(structure: &Structure) -> Vec<(usize, usize)> {
    let graph = &structure.graph;
    let edges = 0..graph.edge_count() as u32;
    let ends = edges.map(|edge| Some((graph.source(edge)? as usize, graph.target(edge)? as usize)));
    ends.flatten().collect()
}

/// Returns the nodes of fair cycles within a set: the ends of sets of edges that form a strongly connected subgraph in which everything
/// recurs that has to.
fn on_fair_cycles(structure: &Structure, within: &Bits) -> Bits {
    let edges = edges(structure);
    let mut found = Bits::new(within.size());
    for chosen in 1_u32..1 << edges.len() {
        let is_chosen = |edge: usize| chosen >> edge & 1 != 0;
        let ends = || {
            let all = edges.iter().enumerate();
            all.filter(|(edge, _)| is_chosen(*edge))
                .map(|(_, ends)| *ends)
        };
        let nodes = Bits::from_ones(within.size(), ends().map(|(source, _)| source));
        if !nodes.is_subset(within) || nodes.is_subset(&found) {
            continue;
        }
        let recurs = |it: &Recurrent| {
            nodes.ones().any(|node| it.contains_node(node as u32))
                || (0..edges.len()).any(|edge| is_chosen(edge) && it.contains_edge(edge))
        };
        let is_fair = structure.fairness.iter().all(|it| match it {
            Fairness::Justice(often) => recurs(often),
            Fairness::Compassion(cause, effect) => recurs(effect) || !recurs(cause),
        });
        // strongly connected: every node reaches every other
        let is_connected = nodes.ones().all(|from| {
            let mut reached = Bits::new(within.size());
            loop {
                let before = reached.count();
                for (source, target) in ends() {
                    if source == from || reached.contains(source) {
                        reached.insert(target);
                    }
                }
                if reached.count() == before {
                    break;
                }
            }
            reached == nodes
        });
        if is_fair && is_connected {
            found.union_with(&nodes);
        }
    }
    found
}

fn before(structure: &Structure, set: &Bits) -> Bits {
    Bits::from_fn(set.size(), |node| {
        let mut successors = structure.graph.successors(node as u32).iter();
        successors.any(|it| set.contains(*it as usize))
    })
}

fn until(structure: &Structure, through: &Bits, goal: &Bits) -> Bits {
    let mut found = goal.clone();
    loop {
        let mut more = before(structure, &found);
        more.intersect_with(through);
        more.union_with(&found);
        if more == found {
            return found;
        }
        found = more;
    }
}

fn globally(structure: &Structure, set: &Bits) -> Bits {
    until(structure, set, &on_fair_cycles(structure, set))
}

pub(crate) fn fair_nodes(structure: &Structure) -> Bits {
    globally(structure, &Bits::full(structure.graph.node_count()))
}

pub(crate) fn fair_paths(structure: &Structure) -> FairPaths {
    let fair = fair_nodes(structure);
    let initial = structure.graph.initial();
    let count = initial
        .iter()
        .filter(|it| fair.contains(**it as usize))
        .count();
    if count == 0 {
        FairPaths::FromNone
    } else if count < initial.len() {
        FairPaths::FromSome
    } else {
        FairPaths::FromAll
    }
}

/// Returns the nodes that satisfy a formula.
pub(crate) fn satisfying(structure: &Structure, formula: &Ctl) -> Bits {
    let size = structure.graph.node_count();
    let of = |formula: &Ctl| satisfying(structure, formula);
    let not = |formula: &Ctl| of(formula).complemented();
    let and = |mut left: Bits, right: &Bits| {
        left.intersect_with(right);
        left
    };
    let or = |mut left: Bits, right: &Bits| {
        left.union_with(right);
        left
    };
    let fair = fair_nodes(structure);
    let next =
        |steps: u32, set: Bits| (0..steps).fold(set, |set, _| before(structure, &and(set, &fair)));
    let exists_until =
        |left: &Bits, right: &Bits| until(structure, left, &and(right.clone(), &fair));
    // violates the right formula until both are violated
    let broken = |left: &Ctl, right: &Ctl| exists_until(&not(right), &and(not(left), &not(right)));
    match formula {
        Ctl::True => Bits::full(size),
        Ctl::False => Bits::new(size),
        Ctl::Atom(atom) => structure.atoms[*atom].clone(),
        Ctl::Not(operand) => not(operand),
        Ctl::And(parts) => parts
            .iter()
            .fold(Bits::full(size), |set, part| and(set, &of(part))),
        Ctl::Or(parts) => parts
            .iter()
            .fold(Bits::new(size), |set, part| or(set, &of(part))),
        Ctl::Implies(left, right) => or(not(left), &of(right)),
        Ctl::Iff(left, right) => or(and(of(left), &of(right)), &and(not(left), &not(right))),
        Ctl::Ex(steps, operand) => next(*steps, of(operand)),
        Ctl::Ax(steps, operand) => next(*steps, not(operand)).complemented(),
        Ctl::Ef(operand) => exists_until(&Bits::full(size), &of(operand)),
        Ctl::Af(operand) => globally(structure, &not(operand)).complemented(),
        Ctl::Eg(operand) => globally(structure, &of(operand)),
        Ctl::Ag(operand) => exists_until(&Bits::full(size), &not(operand)).complemented(),
        Ctl::Eu(left, right) => exists_until(&of(left), &of(right)),
        Ctl::Au(left, right) => {
            or(broken(left, right), &globally(structure, &not(right))).complemented()
        }
        Ctl::Ew(left, right) => or(
            exists_until(&of(left), &of(right)),
            &globally(structure, &of(left)),
        ),
        Ctl::Aw(left, right) => broken(left, right).complemented(),
    }
}
