//! LTL: every short lasso agrees with the verdict, and counterexamples violate the formula.

use crate::naive;
use crate::random::{Random, Structure};
use crate::words::{assert_is_path, entry, for_each_lasso, holds, is_fair};
use asmotion_temporal::{Bits, FairPaths, Fairness, GraphBuilder, Lasso, Ltl, Recurrent};
use asmotion_temporal::{TemporalError, check_ltl};

/// Longest path of the enumeration.
const LENGTH: usize = 6;

/// Returns the size of the smallest violating lasso, by stem and then by cycle.
fn shortest_violation(structure: &Structure, formula: &Ltl) -> Option<(usize, usize)> {
    let mut best = None;
    for start in structure.graph.initial() {
        for_each_lasso(structure, *start, &mut Vec::new(), LENGTH, &mut |lasso| {
            let size = (lasso.stem.len(), lasso.cycle.len());
            if best.is_none_or(|best| size < best) && !holds(formula, lasso, &structure.atoms) {
                best = Some(size);
            }
        });
    }
    best
}

/// Asserts that every short fair continuation of a finite path violates the formula, and that there is a fair continuation.
fn assert_decides(structure: &Structure, formula: &Ltl, lasso: &Lasso) {
    let fair = naive::fair_nodes(structure);
    assert!(fair.contains(entry(lasso) as usize));
    let mut steps = lasso.stem.clone();
    for_each_lasso(structure, lasso.start, &mut steps, LENGTH, &mut |it| {
        assert!(!holds(formula, it, &structure.atoms), "{lasso:?} {it:?}");
    });
}

#[test]
fn verdicts_agree_with_every_short_lasso() {
    let (mut violated, mut held, mut finite, mut longer) = (0, 0, 0, 0);
    for seed in 0..6000 {
        let mut random = Random::new(seed);
        let structure = random.structure(4);
        let formula = random.ltl(1 + seed as usize % 4);
        let context = || format!("seed {seed}: {formula:?} {structure:?}");
        let verdict = check_ltl(
            &structure.graph,
            &structure.atoms,
            &formula,
            &structure.fairness,
        );
        let verdict = verdict.unwrap_or_else(|error| panic!("{error}: {}", context()));
        assert_eq!(verdict.fair, naive::fair_paths(&structure), "{}", context());
        let shortest = shortest_violation(&structure, &formula);
        let Some(lasso) = verdict.violation else {
            assert_eq!(shortest, None, "{}", context());
            held += 1;
            continue;
        };
        violated += 1;
        assert_is_path(&structure.graph, &lasso);
        if lasso.cycle.is_empty() {
            finite += 1;
            assert_decides(&structure, &formula, &lasso);
            continue;
        }
        assert!(is_fair(&lasso.cycle, &structure.fairness), "{}", context());
        assert!(!holds(&formula, &lasso, &structure.atoms), "{}", context());
        let size = (lasso.stem.len(), lasso.cycle.len());
        longer += usize::from(shortest.is_some_and(|shortest| shortest < size));
    }
    assert!(
        violated > 1000 && held > 1000 && finite > 300,
        "{violated} {held} {finite}"
    );
    // the automaton can take longer than the path to begin its cycle
    assert!(longer < 50, "{longer}");
}

/// 0 → 1 → 2 → 1, and 2 → 2; atom `n` holds at node `n`.
fn line() -> Structure {
    let mut builder = GraphBuilder::new();
    builder.edge(1, 0);
    builder.end_node();
    builder.edge(2, 1);
    builder.end_node();
    builder.edge(1, 2);
    builder.edge(2, 3);
    builder.end_node();
    Structure {
        graph: builder.finish(vec![0]).expect("a lawful graph"),
        atoms: (0..3).map(|at| Bits::from_ones(3, [at])).collect(),
        fairness: Vec::new(),
    }
}

#[test]
fn a_constraint_on_edges_is_satisfied_by_the_edge_alone() {
    let line = line();
    let recurs = Ltl::globally(Ltl::finally(Ltl::Atom(1)));
    let check = |fairness: &[Fairness]| {
        check_ltl(&line.graph, &line.atoms, &recurs, fairness).expect("a verdict")
    };
    let lasso = check(&[]).violation.expect("node 2 can stay");
    assert_eq!((lasso.stem.len(), lasso.cycle.len()), (2, 1));
    let moves = Recurrent::edges(Bits::from_ones(4, [2]));
    assert!(check(&[Fairness::Justice(moves.clone())]).holds());
    // both ends of the edge 2 → 2 are visited for ever, but not along this edge
    let stays = Recurrent::edges(Bits::from_ones(4, [3]));
    assert!(!check(&[Fairness::Justice(stays.clone())]).holds());
    let strong = Fairness::Compassion(Recurrent::nodes(Bits::from_ones(3, [2])), moves.clone());
    assert!(check(&[strong]).holds());
    let impossible = Fairness::Compassion(stays, Recurrent::default());
    assert!(check(&[impossible]).holds());
    let nothing = check(&[Fairness::Justice(Recurrent::default())]);
    assert_eq!((nothing.holds(), nothing.fair), (true, FairPaths::FromNone));
}

#[test]
fn a_violated_safety_property_has_a_finite_path() {
    let line = line();
    let never = Ltl::globally(Ltl::negation(Ltl::Atom(2)));
    let verdict = check_ltl(&line.graph, &line.atoms, &never, &[]).expect("a verdict");
    let lasso = verdict.violation.expect("a violation");
    assert_eq!((lasso.stem.len(), lasso.cycle.len()), (2, 0));
    let earlier = Ltl::globally(Ltl::implies(Ltl::Atom(2), Ltl::once(Ltl::Atom(1))));
    assert!(check_ltl(&line.graph, &line.atoms, &earlier, &[]).is_ok_and(|it| it.holds()));
}

#[test]
fn large_conjunctions_stay_small() {
    let line = line();
    let response =
        |at: usize| Ltl::implies(Ltl::Atom(at % 3), Ltl::finally(Ltl::Atom((at + 1) % 3)));
    let all = Ltl::And((0..200).map(|at| Ltl::globally(response(at))).collect());
    let verdict = check_ltl(&line.graph, &line.atoms, &all, &[]).expect("a verdict");
    assert!(!verdict.holds());
    let mut iff = Ltl::Atom(0);
    for at in 0..100 {
        iff = Ltl::iff(iff, Ltl::Atom(at % 3));
    }
    assert!(check_ltl(&line.graph, &line.atoms, &iff, &[]).is_ok());
}

#[test]
fn sizes_and_atoms_are_checked() {
    let line = line();
    let check = |atoms: &[Bits], formula: &Ltl, fairness: &[Fairness]| {
        check_ltl(&line.graph, atoms, formula, fairness).expect_err("an error")
    };
    assert_eq!(
        check(&line.atoms, &Ltl::Atom(3), &[]),
        TemporalError::UnknownAtom { atom: 3, count: 3 }
    );
    let size = |what, expected, found| TemporalError::SetSize {
        what,
        expected,
        found,
    };
    assert_eq!(check(&[Bits::new(4)], &Ltl::True, &[]), size("nodes", 3, 4));
    let edges = Fairness::Justice(Recurrent::edges(Bits::new(3)));
    assert_eq!(check(&[], &Ltl::True, &[edges]), size("edges", 4, 3));
}
