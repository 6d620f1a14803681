//! Monitors against the semantics on infinite paths, and against the checker.

use crate::random::{Random, Structure};
use crate::words::{for_each_lasso, holds};
use asmotion_temporal::{
    Bits, Ctl, Lasso, Ltl, Monitor, MonitorVerdict, NotMonitorable, ResponseMonitor, check_ctl,
};

/// Longest lasso of the enumeration.
const LENGTH: usize = 4;
/// Positions of a lasso that a monitor sees. A formula of the tests, of depth 4, is violated within this many if at all.
const POSITIONS: usize = 60;

/// The nodes of a lasso, with its cycle repeated.
fn nodes(lasso: &Lasso) -> Vec<u32> {
    let mut nodes = vec![lasso.start];
    nodes.extend(lasso.stem.iter().map(|step| step.node));
    while nodes.len() < POSITIONS && !lasso.cycle.is_empty() {
        nodes.extend(lasso.cycle.iter().map(|step| step.node));
    }
    nodes
}

/// Returns the position at which a monitor reports a violation.
fn violated_at(monitor: &Monitor, atoms: &[Bits], lasso: &Lasso) -> Option<usize> {
    let mut state = monitor.begin();
    for (position, node) in nodes(lasso).into_iter().enumerate() {
        let letter = |atom: usize| Some(atoms[atom].contains(node as usize));
        let judged = monitor.judge(&state, &letter);
        assert_eq!(judged, monitor.pass(&mut state, &letter));
        assert!(monitor.fits(&state));
        match judged {
            MonitorVerdict::Violated => return Some(position),
            MonitorVerdict::Satisfied => return None,
            MonitorVerdict::Open => {}
        }
    }
    None
}

fn for_lassos(structure: &Structure, see: &mut dyn FnMut(&Lasso)) {
    for start in structure.graph.initial() {
        for_each_lasso(structure, *start, &mut Vec::new(), LENGTH, see);
    }
}

#[test]
fn a_reported_violation_is_one_and_safety_is_watched_completely() {
    let (mut reported, mut complete, mut refused) = (0, 0, 0);
    for seed in 0..3000 {
        let mut random = Random::new(seed);
        let structure = random.structure(4);
        let formula = random.ltl(1 + seed as usize % 4);
        let Ok(monitor) = Monitor::of_ltl(&formula) else {
            refused += 1;
            continue;
        };
        let is_safety = monitor.unwatched().next().is_none();
        for_lassos(&structure, &mut |lasso| {
            let violated = violated_at(&monitor, &structure.atoms, lasso).is_some();
            let holds = holds(&formula, lasso, &structure.atoms);
            let context = || format!("seed {seed}: {formula:?} {lasso:?}");
            assert!(!(violated && holds), "{}", context());
            assert!(violated || holds || !is_safety, "{}", context());
            reported += usize::from(violated);
            complete += usize::from(is_safety);
        });
    }
    assert!(reported > 10_000 && complete > 10_000 && refused > 100);
}

#[test]
fn a_property_of_all_paths_that_holds_is_violated_on_none() {
    let (mut held, mut reported) = (0, 0);
    for seed in 0..4000 {
        let mut random = Random::new(seed);
        let mut structure = random.structure(4);
        structure.fairness.clear();
        let formula = random.ctl(1 + seed as usize % 4);
        let Ok(monitor) = Monitor::of_ctl(&formula) else {
            continue;
        };
        let checked = check_ctl(&structure.graph, &structure.atoms, &formula, &[]);
        let violation = checked.expect("a formula").violation;
        for_lassos(&structure, &mut |lasso| {
            let violated = violated_at(&monitor, &structure.atoms, lasso).is_some();
            assert!(
                violation.is_some() || !violated,
                "seed {seed}: {formula:?} {lasso:?}"
            );
            held += usize::from(violation.is_none());
            reported += usize::from(violated);
        });
    }
    assert!(held > 10_000 && reported > 10_000, "{held} {reported}");
}

#[test]
fn an_unknown_atom_is_judged_as_if_it_had_the_better_value() {
    let mut early = 0;
    for seed in 0..2000 {
        let mut random = Random::new(seed);
        let formula = random.ltl(1 + seed as usize % 4);
        let Ok(monitor) = Monitor::of_ltl(&formula) else {
            continue;
        };
        let mut state = monitor.begin();
        for _ in 0..20 {
            let values: Vec<bool> = (0..8).map(|_| random.one_in(2)).collect();
            let unknown = random.below(8);
            let partial = |atom: usize| (atom != unknown).then(|| values[atom]);
            let other = |atom: usize| Some(values[atom] != (atom == unknown));
            let is_early = monitor.judge(&state, &partial) == MonitorVerdict::Violated;
            if is_early {
                assert_eq!(monitor.judge(&state, &other), MonitorVerdict::Violated);
            }
            let known = |atom: usize| Some(values[atom]);
            let judged = monitor.pass(&mut state, &known);
            assert!(!is_early || judged == MonitorVerdict::Violated);
            early += usize::from(is_early);
            if judged != MonitorVerdict::Open {
                break;
            }
        }
    }
    assert!(early > 100, "{early}");
}

fn atom(index: usize) -> Ltl {
    Ltl::Atom(index)
}

#[test]
fn a_repeated_property_begins_anew_and_any_other_stays_violated() {
    let run = |formula: &Ltl, word: &[bool]| {
        let monitor = Monitor::of_ltl(formula).expect("safety");
        let mut state = monitor.begin();
        let positions = word.iter().map(|value| {
            let verdict = monitor.pass(&mut state, &|_| Some(*value));
            verdict == MonitorVerdict::Violated
        });
        positions.collect::<Vec<bool>>()
    };
    let word = [true, false, true, true, false, false];
    let globally = run(&Ltl::globally(atom(0)), &word);
    assert_eq!(globally, [false, true, false, false, true, true]);
    // p is false at the second position: whatever follows does not help
    let next = run(&Ltl::next(atom(0)), &word);
    assert_eq!(next, [false, true, true, true, true, true]);
}

#[test]
fn what_cannot_be_watched_has_a_reason() {
    let refused = |formula: &Ltl| Monitor::of_ltl(formula).err();
    let liveness = Ltl::globally(Ltl::implies(atom(0), Ltl::finally(atom(1))));
    assert_eq!(refused(&liveness), Some(NotMonitorable::Liveness));
    let tautology = Ltl::globally(Ltl::True);
    assert_eq!(refused(&tautology), Some(NotMonitorable::Trivial));
    let past = Ltl::globally(Ltl::once(Ltl::globally(atom(0))));
    assert_eq!(refused(&past), Some(NotMonitorable::PastOfFuture));
    let reset = Monitor::of_ctl(&Ctl::ag(Ctl::ef(Ctl::Atom(0)))).err();
    assert_eq!(reset, Some(NotMonitorable::Existence));
    // an implication of something that is only possible says nothing about one run
    let answered = Ctl::implies(Ctl::Atom(0), Ctl::ef(Ctl::Atom(1)));
    let answered = Monitor::of_ctl(&Ctl::ag(answered)).err();
    assert_eq!(answered, Some(NotMonitorable::Existence));
    let many = Ltl::And((0..13).map(|index| Ltl::globally(atom(index))).collect());
    assert_eq!(refused(&many), Some(NotMonitorable::TooLarge));
    let until = Ltl::globally(Ltl::implies(atom(0), Ltl::until(atom(1), atom(2))));
    let until = Monitor::of_ltl(&until).expect("has a safety part");
    assert_eq!(
        until.unwatched().collect::<Vec<_>>(),
        [NotMonitorable::Liveness]
    );
}

/// Evaluates `G(p → F≤within q)` by its definition, as far as the word shows it.
fn late_by_definition(word: &[(i64, bool, bool)], within: i64) -> bool {
    word.iter().enumerate().any(|(start, (since, cause, _))| {
        let in_time = |it: &&(i64, bool, bool)| it.0 <= since + within;
        let seen = word[start..].iter().take_while(in_time);
        let is_seen_to_the_end = word.last().is_some_and(|last| last.0 >= since + within);
        *cause && is_seen_to_the_end && !seen.clone().any(|it| it.2)
    })
}

#[test]
fn a_late_response_is_one_by_definition() {
    let formula = Ltl::globally(Ltl::implies(atom(0), Ltl::finally(atom(1))));
    let monitor = ResponseMonitor::of_ltl(&formula).expect("a response");
    let (mut late, mut in_time) = (0, 0);
    for seed in 0..5000 {
        let mut random = Random::new(seed);
        let mut word = Vec::new();
        let mut now = 0;
        for _ in 0..12 {
            // times increase strictly: a response at the very end of the time counts
            now += 1 + random.below(3) as i64;
            word.push((now, random.one_in(4), random.one_in(4)));
        }
        let within = 3 + random.below(6) as i64;
        let mut state = monitor.begin();
        let mut is_late = false;
        for (now, cause, goal) in &word {
            let letter = |atom: usize| Some(if atom == 0 { *cause } else { *goal });
            is_late |= monitor.note(&mut state, *now, within, &letter);
            monitor.pass(&mut state, &letter);
            assert!(monitor.fits(&state));
        }
        let by_definition = late_by_definition(&word, within);
        assert_eq!(is_late, by_definition, "seed {seed}: {word:?} {within}");
        late += usize::from(is_late);
        in_time += usize::from(!is_late);
    }
    assert!(late > 500 && in_time > 500, "{late} {in_time}");
}
