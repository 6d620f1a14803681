//! CTL: verdicts agree with naive fixpoints, and paths show why.

use crate::naive;
use crate::random::{Random, Structure};
use crate::words::{assert_is_path, entry, is_fair};
use asmotion_temporal::{Bits, Ctl, GraphBuilder, Lasso, TemporalError, check_ctl, witness_ctl};

#[test]
fn verdicts_agree_with_naive_fixpoints() {
    let (mut violated, mut held) = (0, 0);
    for seed in 0..4000 {
        let mut random = Random::new(seed);
        let structure = random.structure(5);
        if structure.graph.edge_count() > 9 {
            continue;
        }
        let formula = random.ctl(1 + seed as usize % 4);
        let context = || format!("seed {seed}: {formula:?} {structure:?}");
        let Structure {
            graph,
            atoms,
            fairness,
        } = &structure;
        let verdict = check_ctl(graph, atoms, &formula, fairness).expect("a verdict");
        let set = naive::satisfying(&structure, &formula);
        let fair = naive::fair_nodes(&structure);
        let initial = graph.initial().iter().map(|node| *node as usize);
        let mut relevant = initial.filter(|node| fair.contains(*node));
        let holds = relevant.clone().all(|node| set.contains(node));
        assert_eq!(verdict.holds(), holds, "{}", context());
        assert_eq!(verdict.fair, naive::fair_paths(&structure), "{}", context());
        let witness = witness_ctl(graph, atoms, &formula, fairness).expect("a witness");
        let exists = relevant.any(|node| set.contains(node));
        assert_eq!(witness.is_some(), exists, "{}", context());
        for lasso in [&verdict.violation, &witness].into_iter().flatten() {
            assert_is_path(graph, lasso);
            assert!(fair.contains(entry(lasso) as usize), "{}", context());
            if !lasso.cycle.is_empty() {
                assert!(is_fair(&lasso.cycle, fairness), "{}", context());
            }
        }
        if holds {
            held += 1;
        } else {
            violated += 1;
        }
    }
    assert!(violated > 1000 && held > 1000, "{violated} {held}");
}

/// Returns the nodes before, and at, the end of the stem, and those of the cycle.
fn nodes(lasso: &Lasso) -> (Vec<usize>, usize, Vec<usize>) {
    let mut stem = vec![lasso.start as usize];
    stem.extend(lasso.stem.iter().map(|step| step.node as usize));
    let end = stem.pop().unwrap_or_default();
    let cycle = lasso.cycle.iter().map(|step| step.node as usize);
    (stem, end, cycle.collect())
}

/// Paths of formulas with one path quantifier are replayed.
#[test]
fn paths_show_what_they_have_to() {
    let mut shown = [0; 6];
    for seed in 0..3000 {
        let mut random = Random::new(seed);
        let structure = random.structure(5);
        let Structure {
            graph,
            atoms,
            fairness,
        } = &structure;
        let (p, q) = (&atoms[0], &atoms[1]);
        let violation = |formula: Ctl| {
            let verdict = check_ctl(graph, atoms, &formula, fairness);
            let lasso = verdict.expect("a verdict").violation;
            lasso.map(|lasso| (nodes(&lasso), lasso))
        };
        let atom = Ctl::Atom;
        if let Some(((stem, end, cycle), _)) = violation(Ctl::ag(atom(0))) {
            assert!(stem.iter().all(|node| p.contains(*node)) && !p.contains(end));
            assert!(cycle.is_empty());
            shown[0] += 1;
        }
        if let Some(((stem, _, cycle), lasso)) = violation(Ctl::af(atom(0))) {
            assert!(stem.iter().chain(&cycle).all(|node| !p.contains(*node)));
            assert!(!cycle.is_empty() && is_fair(&lasso.cycle, fairness));
            shown[1] += 1;
        }
        if let Some(((stem, end, _), _)) = violation(Ctl::ax(3, atom(0))) {
            assert!(stem.len() == 3 && !p.contains(end));
            shown[2] += 1;
        }
        if let Some(((stem, end, cycle), _)) = violation(Ctl::au(atom(0), atom(1))) {
            assert!(stem.iter().chain(&cycle).all(|node| !q.contains(*node)));
            assert!(!q.contains(end) && (!cycle.is_empty() || !p.contains(end)));
            shown[3] += 1;
        }
        let nested = Ctl::ag(Ctl::implies(atom(0), Ctl::af(atom(1))));
        if let Some(((stem, end, cycle), _)) = violation(nested) {
            assert!(!cycle.is_empty() && cycle.iter().all(|node| !q.contains(*node)));
            let all: Vec<usize> = stem.iter().chain([&end]).chain(&cycle).copied().collect();
            assert!(all.iter().any(|node| p.contains(*node)));
            shown[4] += 1;
        }
        let until = Ctl::eu(atom(0), atom(1));
        if let Some(lasso) = witness_ctl(graph, atoms, &until, fairness).expect("a witness") {
            let (stem, end, cycle) = nodes(&lasso);
            assert!(stem.iter().all(|node| p.contains(*node)) && q.contains(end));
            assert!(cycle.is_empty());
            shown[5] += 1;
        }
    }
    assert!(shown.iter().all(|count| *count > 300), "{shown:?}");
}

#[test]
fn many_steps_are_exact() {
    let mut builder = GraphBuilder::new();
    for node in 0..50 {
        builder.edge((node + 1) % 50, 0);
        builder.end_node();
    }
    let graph = builder.finish(vec![0]).expect("a lawful graph");
    let atoms = [Bits::from_ones(50, [37])];
    let after = |steps| Ctl::ex(steps, Ctl::Atom(0));
    let witness = |steps| witness_ctl(&graph, &atoms, &after(steps), &[]);
    for rounds in [0, 1, 7, 20] {
        let steps = 37 + 50 * rounds;
        let lasso = witness(steps).expect("a witness").expect("a path");
        assert_eq!(lasso.stem.len(), steps as usize);
        assert_is_path(&graph, &lasso);
        assert_eq!(entry(&lasso), 37);
        assert_eq!(witness(steps + 1), Ok(None));
    }
    assert!(matches!(
        witness(u32::MAX),
        Err(TemporalError::TooManySteps { .. })
    ));
    let mut iff = Ctl::Atom(0);
    for _ in 0..100 {
        iff = Ctl::iff(iff, Ctl::ef(Ctl::Atom(0)));
    }
    assert!(check_ctl(&graph, &atoms, &iff, &[]).is_ok());
}
