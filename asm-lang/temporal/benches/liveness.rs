//! Liveness under weak fairness of five agents on 350 000 nodes with 1.2 million edges, of the size of Peterson's algorithm with
//! five processes.

#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a bench fails by panicking"
)]

use asmotion_temporal::{Bits, Ctl, Fairness, Graph, GraphBuilder, Ltl, Recurrent};
use asmotion_temporal::{check_ctl, check_ltl};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

const NODES: u32 = 350_000;
const AGENTS: u32 = 5;

/// Agents take turns to move on a long ring; a move of one agent sometimes goes back a little.
fn graph() -> (Graph, Vec<Fairness>) {
    let mut builder = GraphBuilder::new();
    let mut dice = 1_u32;
    let mut roll = |bound: u32| {
        dice = dice.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (dice >> 8) % bound
    };
    let mut enabled = vec![Vec::new(); AGENTS as usize];
    for node in 0..NODES {
        let mut moves = 0;
        for agent in 0..AGENTS {
            // agent 0 can always move, and all others often
            if agent != 0 && roll(100) >= 61 {
                continue;
            }
            let target = if agent == 0 {
                node + 1
            } else {
                node.saturating_sub(roll(40)) + roll(40)
            };
            builder.edge(target % NODES, agent);
            enabled[agent as usize].push(node as usize);
            moves += 1;
        }
        assert!(moves > 0);
        builder.end_node();
    }
    let graph = builder.finish(vec![0]).expect("a lawful graph");
    let fairness = (0..AGENTS).map(|agent| {
        let nodes = enabled[agent as usize].iter().copied();
        let disabled = Bits::from_ones(graph.node_count(), nodes).complemented();
        let moves = graph.edges_with(|label| label == agent);
        Fairness::Justice(Recurrent::nodes_or_edges(disabled, moves))
    });
    let fairness = fairness.collect();
    (graph, fairness)
}

fn liveness(criterion: &mut Criterion) {
    let (graph, fairness) = graph();
    // every agent at one node of a small part of the ring: true, and nowhere: violated
    let somewhere = Bits::from_fn(graph.node_count(), |node| node % 7 < 5);
    let atoms = [somewhere, Bits::new(graph.node_count())];
    let mut group = criterion.benchmark_group(format!("{} edges", graph.edge_count()));
    group.sample_size(10);
    for (name, atom) in [("often", 0), ("violated", 1)] {
        let recurs = Ltl::globally(Ltl::finally(Ltl::Atom(atom)));
        let always = Ctl::ag(Ctl::af(Ctl::Atom(atom)));
        group.bench_function(format!("G F {name}"), |bench| {
            bench.iter(|| black_box(check_ltl(&graph, &atoms, &recurs, &fairness)));
        });
        group.bench_function(format!("AG AF {name}"), |bench| {
            bench.iter(|| black_box(check_ctl(&graph, &atoms, &always, &fairness)));
        });
    }
    group.finish();
}

criterion_group!(benches, liveness);
criterion_main!(benches);
