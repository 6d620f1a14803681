//! Graphs: numbering, completion and errors.

use crate::random::Random;
use asmotion_temporal::{Graph, GraphBuilder, TemporalError};

#[test]
fn edges_are_numbered_by_source() {
    let mut builder = GraphBuilder::new();
    builder.edge(1, 10);
    builder.edge(0, 11);
    builder.end_node();
    builder.end_node();
    let graph = builder.finish(vec![1, 0, 1]).expect("a lawful graph");
    assert_eq!((graph.node_count(), graph.edge_count()), (2, 3));
    assert_eq!(graph.initial(), [0, 1]);
    assert_eq!(graph.stuttering(), 1);
    assert_eq!((graph.edges(0), graph.edges(1)), (0..2, 2..3));
    assert_eq!(graph.successors(0), [1, 0]);
    assert_eq!(graph.predecessors(1), [0, 1]);
    assert_eq!(graph.label(1), Some(11));
    assert_eq!(graph.label(2), Some(Graph::STUTTER));
    let marked = graph.edges_with(|label| label != 10);
    assert_eq!(marked.ones().collect::<Vec<_>>(), [1, 2]);
    // beyond the last node and edge
    assert_eq!((graph.edges(2), graph.edges(u32::MAX)), (0..0, 0..0));
    assert_eq!((graph.source(3), graph.target(3)), (None, None));
}

#[test]
fn predecessors_mirror_successors() {
    for seed in 0..200 {
        let graph = Random::new(seed).graph(12);
        let nodes = 0..graph.node_count() as u32;
        let mut forwards = Vec::new();
        let mut backwards = Vec::new();
        for node in nodes {
            forwards.extend(graph.successors(node).iter().map(|to| (node, *to)));
            backwards.extend(graph.predecessors(node).iter().map(|from| (*from, node)));
            for edge in graph.edges(node) {
                assert_eq!(graph.source(edge as u32), Some(node));
            }
        }
        forwards.sort_unstable();
        backwards.sort_unstable();
        assert_eq!(forwards, backwards);
    }
}

#[test]
fn graphs_that_are_not_well_formed_are_errors() {
    let one = || {
        let mut builder = GraphBuilder::new();
        builder.end_node();
        builder
    };
    let unknown = |node, count| Err(TemporalError::UnknownNode { node, count });
    let finish = |builder: GraphBuilder, initial| builder.finish(initial).map(|_| ());
    assert_eq!(finish(one(), vec![0]), Ok(()));
    assert_eq!(finish(one(), vec![]), Err(TemporalError::NoInitialNode));
    assert_eq!(finish(one(), vec![1]), unknown(1, 1));
    let mut builder = one();
    builder.edge(5, 0);
    builder.end_node();
    assert_eq!(finish(builder, vec![0]), unknown(5, 2));
    let mut builder = one();
    builder.edge(0, 0);
    let unfinished = finish(builder, vec![0]);
    assert_eq!(unfinished, Err(TemporalError::UnfinishedNode));
    let mut builder = GraphBuilder::new();
    builder.edge(0, Graph::STUTTER);
    builder.end_node();
    let reserved = finish(builder, vec![0]);
    assert_eq!(reserved, Err(TemporalError::ReservedLabel));
}
