//! LTL: every short lasso agrees with the verdict, and counterexamples violate the formula.

use crate::naive;
use crate::random::{Random, Structure};
use crate::words::{assert_is_path, entry, for_each_lasso, holds, is_fair};
use asmotion_temporal::{Bits, Ctl, FairPaths, Fairness, GraphBuilder, Lasso, Ltl, Recurrent};
use asmotion_temporal::{TemporalError, check_ctl, check_ctl_while, check_ltl, check_ltl_while};
use std::cell::Cell;

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

/// Beyond 32 constraints, cycles satisfy one after the other.
#[test]
fn many_constraints_are_satisfied_by_one_cycle() {
    const NODES: u32 = 100;
    let mut builder = GraphBuilder::new();
    for node in 0..NODES {
        builder.edge((node + 1) % NODES, 0);
        builder.edge((node + NODES - 1) % NODES, 0);
        builder.end_node();
    }
    let graph = builder.finish(vec![0]).expect("a lawful graph");
    let at = |node| Recurrent::nodes(Bits::from_ones(NODES as usize, [node]));
    let mut fairness: Vec<Fairness> = (0..35).map(|it| Fairness::Justice(at(2 * it))).collect();
    fairness.push(Fairness::Compassion(at(1), at(90)));
    fairness.push(Fairness::Compassion(at(99), at(98)));
    let goal = Bits::from_ones(NODES as usize, [95]);
    let formula = Ltl::globally(Ltl::finally(Ltl::Atom(0)));
    let verdict = check_ltl(&graph, std::slice::from_ref(&goal), &formula, &fairness);
    let lasso = verdict.expect("a verdict").violation.expect("a violation");
    assert_is_path(&graph, &lasso);
    assert!(is_fair(&lasso.cycle, &fairness));
    assert!(
        lasso
            .cycle
            .iter()
            .all(|it| !goal.contains(it.node as usize))
    );
}

/// Nothing recurses over nodes: the stack of a thread is too small for that.
#[test]
fn long_paths_need_no_stack() {
    const NODES: u32 = 1_000_000;
    let check = || {
        let mut builder = GraphBuilder::new();
        for node in 0..NODES {
            builder.edge((node + 1) % NODES, 0);
            builder.edge(node.saturating_sub(1), 1);
            builder.end_node();
        }
        let graph = builder.finish(vec![0]).expect("a lawful graph");
        let last = [Bits::from_ones(NODES as usize, [NODES as usize - 1])];
        let moves = Bits::from_fn(graph.edge_count(), |edge| edge % 2 == 0);
        let back = moves.clone().complemented();
        let fairness = [
            Fairness::Justice(Recurrent::edges(moves)),
            Fairness::Compassion(Recurrent::edges(back), Recurrent::nodes(last[0].clone())),
        ];
        let atom = || Ltl::Atom(0);
        let recurs = Ltl::globally(Ltl::finally(atom()));
        let ctl = Ctl::ag(Ctl::af(Ctl::Atom(0)));
        for fairness in [&fairness[..1], &fairness] {
            let is_strong = fairness.len() == 2;
            let verdict = check_ltl(&graph, &last, &recurs, fairness).expect("a verdict");
            assert_eq!(verdict.holds(), is_strong);
            let verdict = check_ctl(&graph, &last, &ctl, fairness).expect("a verdict");
            assert_eq!(verdict.holds(), is_strong);
        }
        let never = Ltl::globally(Ltl::negation(atom()));
        let verdict = check_ltl(&graph, &last, &never, &[]).expect("a verdict");
        let lasso = verdict.violation.expect("a violation");
        assert_eq!(lasso.stem.len(), NODES as usize - 1);
    };
    let thread = std::thread::Builder::new().stack_size(256 << 10);
    let thread = thread.spawn(check).expect("a thread");
    thread.join().expect("no panic");
}

/// No lasso has a shorter stem, or a shorter cycle after a stem of the same length, than the counterexamples of properties of the usual
/// forms.
#[test]
fn counterexamples_of_usual_properties_are_shortest() {
    let atom = Ltl::Atom;
    let usual = [
        Ltl::globally(Ltl::finally(atom(0))),
        Ltl::finally(Ltl::globally(atom(0))),
        Ltl::finally(atom(0)),
        Ltl::until(atom(0), atom(1)),
        Ltl::implies(
            Ltl::globally(Ltl::finally(atom(0))),
            Ltl::globally(Ltl::finally(atom(1))),
        ),
        Ltl::globally(Ltl::implies(atom(0), Ltl::finally(atom(1)))),
    ];
    let mut longer = vec![(0, 0); usual.len()];
    for seed in 0..1500 {
        let structure = Random::new(seed).structure(4);
        for (formula, (longer, all)) in usual.iter().zip(&mut longer) {
            let Structure {
                graph,
                atoms,
                fairness,
            } = &structure;
            let verdict = check_ltl(graph, atoms, formula, fairness).expect("a verdict");
            let Some(lasso) = verdict.violation.filter(|it| !it.cycle.is_empty()) else {
                continue;
            };
            let size = (lasso.stem.len(), lasso.cycle.len());
            let shortest = shortest_violation(&structure, formula);
            *all += 1;
            *longer += usize::from(shortest.is_some_and(|shortest| shortest < size));
        }
    }
    assert!(longer.iter().all(|(_, all)| *all > 100), "{longer:?}");
    let longer: Vec<usize> = longer.into_iter().map(|(longer, _)| longer).collect();
    assert_eq!(longer[..5], [0; 5]);
    // a response: the path can pass the cause once more than it has to
    assert!(longer[5] < 10, "{longer:?}");
}

/// Strong fairness as an assumption of the formula, instead of a constraint.
#[test]
fn assumptions_agree_with_constraints() {
    for seed in 0..200 {
        let mut structure = Random::new(seed).structure(6);
        let nodes = |at: usize| Recurrent::nodes(structure.atoms[at].clone());
        structure.fairness = vec![
            Fairness::Compassion(nodes(0), nodes(1)),
            Fairness::Compassion(nodes(1), nodes(2)),
        ];
        let recurs = |at| Ltl::globally(Ltl::finally(Ltl::Atom(at)));
        let strong = |cause, effect| Ltl::implies(recurs(cause), recurs(effect));
        let assumption = Ltl::And(vec![strong(0, 1), strong(1, 2)]);
        let property = Ltl::implies(recurs(0), Ltl::globally(Ltl::once(Ltl::Atom(2))));
        let assumed = Ltl::implies(assumption, property.clone());
        let Structure {
            graph,
            atoms,
            fairness,
        } = &structure;
        let constrained = check_ltl(graph, atoms, &property, fairness).expect("a verdict");
        let assumed = check_ltl(graph, atoms, &assumed, &[]).expect("a verdict");
        assert_eq!(constrained.holds(), assumed.holds(), "seed {seed}");
    }
}

#[test]
fn checks_can_be_interrupted() {
    let graph = Random::new(1).graph(6);
    let atoms = [Bits::new(graph.node_count())];
    let recurs = Ltl::globally(Ltl::finally(Ltl::Atom(0)));
    let always = Ctl::ag(Ctl::af(Ctl::Atom(0)));
    let largest = Cell::new(0);
    let ends_at = |limit: usize| {
        let largest = &largest;
        move |bytes: usize| {
            largest.set(bytes.max(largest.get()));
            bytes <= limit
        }
    };
    let interrupted = |verdict| verdict == Err(TemporalError::Interrupted);
    let ltl = |limit| check_ltl_while(&graph, &atoms, &recurs, &[], &ends_at(limit));
    assert!(ltl(usize::MAX).is_ok_and(|it| !it.holds()));
    assert!(largest.get() > 0 && interrupted(ltl(largest.get() - 1)));
    let ctl = |limit| check_ctl_while(&graph, &atoms, &always, &[], &ends_at(limit));
    largest.set(0);
    assert!(ctl(usize::MAX).is_ok_and(|it| !it.holds()));
    assert!(largest.get() > 0 && interrupted(ctl(largest.get() - 1)));
}
