//! Vacuity: what does not matter can be anything.

use crate::random::{ATOMS, Random, Structure};
use asmotion_temporal::{AtomOccurrence, Bits, Ctl, GraphBuilder, Ltl, Vacuity};
use asmotion_temporal::{check_ctl, check_ltl, check_ltl_with_vacuity, vacuity_ctl, vacuity_ltl};

/// 0 → 1 → 0; atoms hold at 0, at 1, nowhere, everywhere.
fn pair() -> Structure {
    let mut builder = GraphBuilder::new();
    builder.edge(1, 0);
    builder.end_node();
    builder.edge(0, 0);
    builder.end_node();
    Structure {
        graph: builder.finish(vec![0]).expect("a lawful graph"),
        atoms: [&[0][..], &[1], &[], &[0, 1]]
            .map(|ones| Bits::from_ones(2, ones.iter().copied()))
            .to_vec(),
        fairness: Vec::new(),
    }
}

#[test]
fn an_antecedent_that_is_never_true_is_unmet() {
    let pair = pair();
    let response = |cause| Ltl::implies(Ltl::Atom(cause), Ltl::finally(Ltl::Atom(1)));
    let formula = Ltl::globally(Ltl::And(vec![response(0), response(2)]));
    let found = vacuity_ltl(&pair.graph, &pair.atoms, &formula, &[]).expect("a result");
    let irrelevant = |atom, occurrence| AtomOccurrence { atom, occurrence };
    // node 1 follows anyway: the cause does not matter; and nothing matters after a cause that never comes
    let expected = Vacuity {
        irrelevant: vec![irrelevant(0, 0), irrelevant(2, 2), irrelevant(1, 3)],
        unmet: vec![1],
    };
    assert_eq!(found, expected);

    let response = Ctl::implies(Ctl::Atom(2), Ctl::af(Ctl::Atom(1)));
    let formula = Ctl::ag(response);
    let found = vacuity_ctl(&pair.graph, &pair.atoms, &formula, &[]).expect("a result");
    let expected = Vacuity {
        irrelevant: vec![irrelevant(2, 0), irrelevant(1, 1)],
        unmet: vec![0],
    };
    assert_eq!(found, expected);

    let violated = Ctl::ag(Ctl::implies(Ctl::Atom(3), Ctl::Atom(2)));
    let found = vacuity_ctl(&pair.graph, &pair.atoms, &violated, &[]);
    assert_eq!(found, Ok(Vacuity::default()));
}

#[test]
fn operands_of_an_equivalence_matter_if_one_constant_shows_it() {
    let pair = pair();
    let changes = Ltl::globally(Ltl::iff(Ltl::Atom(0), Ltl::next(Ltl::Atom(1))));
    let found = vacuity_ltl(&pair.graph, &pair.atoms, &changes, &[]);
    assert_eq!(found, Ok(Vacuity::default()));
    let guarded = Ltl::globally(Ltl::implies(
        Ltl::Atom(2),
        Ltl::iff(Ltl::Atom(0), Ltl::Atom(1)),
    ));
    let found = vacuity_ltl(&pair.graph, &pair.atoms, &guarded, &[]).expect("a result");
    // only the guard matters
    let atoms: Vec<usize> = found.irrelevant.iter().map(|it| it.occurrence).collect();
    assert_eq!(atoms, [1, 2]);
}

/// An atom that does not matter is replaced by other sets of nodes: the formula still holds.
#[test]
fn an_irrelevant_atom_can_be_any_set() {
    let (mut tried, mut irrelevant) = (0, 0);
    for seed in 0..1500 {
        let mut random = Random::new(seed);
        let Structure {
            graph,
            mut atoms,
            fairness,
        } = random.structure(5);
        // one formula without `iff`, whose atoms all differ
        let (ltl, ctl) = (distinct_ltl(&mut random), distinct_ctl(&mut random));
        atoms.resize(ATOMS + 1, Bits::full(graph.node_count()));
        let of_ltl = vacuity_ltl(&graph, &atoms, &ltl, &fairness).expect("a result");
        let of_ctl = vacuity_ctl(&graph, &atoms, &ctl, &fairness).expect("a result");
        let both = check_ltl_with_vacuity(&graph, &atoms, &ltl, &fairness).expect("a result");
        let verdict = check_ltl(&graph, &atoms, &ltl, &fairness).expect("a verdict");
        assert_eq!(both, (verdict, of_ltl.clone()), "seed {seed}");
        tried += 1;
        for (found, is_ltl) in [(of_ltl, true), (of_ctl, false)] {
            for it in found.irrelevant {
                irrelevant += 1;
                let mut others = atoms.clone();
                others[it.atom] = random.bits(graph.node_count(), 2);
                let verdict = if is_ltl {
                    check_ltl(&graph, &others, &ltl, &fairness)
                } else {
                    check_ctl(&graph, &others, &ctl, &fairness)
                };
                assert!(verdict.expect("a verdict").holds(), "seed {seed}");
            }
        }
    }
    assert!(tried > 1000 && irrelevant > 500, "{tried} {irrelevant}");
}

fn distinct_ltl(random: &mut Random) -> Ltl {
    let [one, two, three] = [0, 1, 2].map(Ltl::Atom);
    let unary = [Ltl::finally, Ltl::globally, Ltl::next, Ltl::once];
    let mut some = |of| unary[random.below(unary.len())](of);
    let response = Ltl::implies(some(one), some(two));
    Ltl::globally(Ltl::Or(vec![some(three), response]))
}

fn distinct_ctl(random: &mut Random) -> Ctl {
    let [one, two, three] = [0, 1, 2].map(Ctl::Atom);
    let unary = [Ctl::ef, Ctl::af, Ctl::eg, Ctl::ag, Ctl::negation];
    let mut some = |of| unary[random.below(unary.len())](of);
    let response = Ctl::implies(some(one), some(two));
    Ctl::ag(Ctl::Or(vec![some(three), response]))
}
