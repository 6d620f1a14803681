//! Verdicts of NuSMV on the same structures.

#![expect(
    clippy::disallowed_methods,
    reason = "the test writes models for another program"
)]

use crate::random::{ATOMS, Random, Structure};
use asmotion_temporal::{Bits, Ctl, Fairness, Ltl, Recurrent, check_ctl, check_ltl};
use std::fmt::Write;
use std::path::Path;

/// Number of formulas of each logic for a structure.
const FORMULAS: usize = 12;

#[test]
fn verdicts_are_those_of_nusmv() {
    let Some(nusmv) = asmotion_skip::nusmv() else {
        return;
    };
    let (mut held, mut violated) = (0, 0);
    for seed in 0..40 {
        let mut random = Random::new(1000 + seed);
        let structure = random.structure(6);
        let Structure {
            graph,
            atoms,
            fairness,
        } = &structure;
        let has_compassion = fairness
            .iter()
            .any(|it| matches!(it, Fairness::Compassion(_, _)));
        let mut model = model(&structure);
        let mut expected = Vec::new();
        // NuSMV ignores compassion for CTL
        for at in 0..if has_compassion { 0 } else { FORMULAS } {
            let formula = random.ctl(1 + at % 4);
            let verdict = check_ctl(graph, atoms, &formula, fairness);
            expected.push((verdict.expect("a verdict").holds(), ctl(&formula)));
            let _ = writeln!(model, "CTLSPEC {}", ctl(&formula));
        }
        for at in 0..FORMULAS {
            let formula = random.ltl(1 + at % 4);
            let verdict = check_ltl(graph, atoms, &formula, fairness);
            expected.push((verdict.expect("a verdict").holds(), ltl(&formula)));
            let _ = writeln!(model, "LTLSPEC {}", ltl(&formula));
        }
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("structure-{seed}.smv"));
        std::fs::write(&path, &model).expect("a model");
        let verdicts = verdicts(&nusmv, &path);
        assert_eq!(verdicts.len(), expected.len(), "{}", path.display());
        for (verdict, (holds, formula)) in verdicts.into_iter().zip(expected) {
            assert_eq!(holds, verdict, "{formula} in {}", path.display());
            if holds {
                held += 1;
            } else {
                violated += 1;
            }
        }
    }
    assert!(held > 200 && violated > 200, "{held} {violated}");
}

/// Runs NuSMV, and returns its verdicts in the order of the specifications.
fn verdicts(nusmv: &asmotion_skip::Nusmv, model: &Path) -> Vec<bool> {
    let output = nusmv.command().args(["-dcx"]).arg(model).output();
    let output = output.expect("NuSMV");
    let text = String::from_utf8_lossy(&output.stdout);
    let lines = text.lines().filter(|it| it.starts_with("-- specification"));
    lines
        .map(|line| {
            let (_, verdict) = line.rsplit_once("is ").expect("a verdict");
            assert!(["true", "false"].contains(&verdict), "{line}");
            verdict == "true"
        })
        .collect()
}

/// The structure as a model. The last edge taken is a variable, because constraints can be about edges.
fn model(structure: &Structure) -> String {
    let graph = &structure.graph;
    let mut model = String::from("MODULE main\nVAR\n");
    let edges = graph.edge_count();
    let _ = writeln!(model, "  node : 0..{};", graph.node_count().max(2) - 1);
    let _ = writeln!(model, "  last : 0..{edges};");
    let initial = graph.initial().iter().map(|it| *it as usize);
    let _ = writeln!(model, "INIT last = {edges} & {}", among("node", initial));
    let steps = (0..edges as u32).map(|edge| {
        let ends = (graph.source(edge), graph.target(edge));
        let (Some(source), Some(target)) = ends else {
            unreachable!("edges have ends")
        };
        format!("(node = {source} & next(node) = {target} & next(last) = {edge})")
    });
    let _ = writeln!(model, "TRANS {}", steps.collect::<Vec<_>>().join(" | "));
    for (at, atom) in structure.atoms.iter().enumerate().take(ATOMS) {
        let _ = writeln!(model, "DEFINE p{at} := {};", among("node", atom.ones()));
    }
    for constraint in &structure.fairness {
        let _ = match constraint {
            Fairness::Justice(often) => writeln!(model, "JUSTICE {}", recurrent(often)),
            Fairness::Compassion(cause, effect) => {
                let (cause, effect) = (recurrent(cause), recurrent(effect));
                writeln!(model, "COMPASSION({cause}, {effect})")
            }
        };
    }
    model
}

fn among(variable: &str, values: impl Iterator<Item = usize>) -> String {
    let values = values.map(|value| format!("{variable} = {value}"));
    let any: Vec<String> = values.chain(["FALSE".to_owned()]).collect();
    format!("({})", any.join(" | "))
}

fn recurrent(often: &Recurrent) -> String {
    let any = |variable: &str, bits: &Option<Bits>| {
        let ones = bits.iter().flat_map(Bits::ones);
        among(variable, ones)
    };
    let (nodes, edges) = (any("node", &often.nodes), any("last", &often.edges));
    format!("({nodes} | {edges})")
}

fn joined(parts: impl Iterator<Item = String>, sign: &str, unit: &str) -> String {
    let parts: Vec<String> = parts.chain([unit.to_owned()]).collect();
    format!("({})", parts.join(sign))
}

fn ctl(formula: &Ctl) -> String {
    match formula {
        Ctl::True => "TRUE".to_owned(),
        Ctl::False => "FALSE".to_owned(),
        Ctl::Atom(atom) => format!("p{atom}"),
        Ctl::Not(of) => format!("!({})", ctl(of)),
        Ctl::And(parts) => joined(parts.iter().map(ctl), " & ", "TRUE"),
        Ctl::Or(parts) => joined(parts.iter().map(ctl), " | ", "FALSE"),
        Ctl::Implies(left, right) => format!("({} -> {})", ctl(left), ctl(right)),
        Ctl::Iff(left, right) => format!("({} <-> {})", ctl(left), ctl(right)),
        Ctl::Ex(steps, of) => repeated("EX", *steps, &ctl(of)),
        Ctl::Ax(steps, of) => repeated("AX", *steps, &ctl(of)),
        Ctl::Ef(of) => format!("EF ({})", ctl(of)),
        Ctl::Af(of) => format!("AF ({})", ctl(of)),
        Ctl::Eg(of) => format!("EG ({})", ctl(of)),
        Ctl::Ag(of) => format!("AG ({})", ctl(of)),
        Ctl::Eu(left, right) => format!("E [{} U {}]", ctl(left), ctl(right)),
        Ctl::Au(left, right) => format!("A [{} U {}]", ctl(left), ctl(right)),
        // NuSMV has no weak until
        Ctl::Ew(left, right) => {
            let (left, right) = (ctl(left), ctl(right));
            format!("(E [{left} U {right}] | EG ({left}))")
        }
        Ctl::Aw(left, right) => {
            let (left, right) = (ctl(left), ctl(right));
            format!("!E [!({right}) U (!({left}) & !({right}))]")
        }
    }
}

fn repeated(operator: &str, steps: u32, of: &str) -> String {
    (0..steps).fold(of.to_owned(), |of, _| format!("{operator} ({of})"))
}

fn ltl(formula: &Ltl) -> String {
    let unary = |operator: &str, of: &Ltl| format!("{operator} ({})", ltl(of));
    let binary = |left: &Ltl, operator: &str, right: &Ltl| {
        format!("(({}) {operator} ({}))", ltl(left), ltl(right))
    };
    match formula {
        Ltl::True => "TRUE".to_owned(),
        Ltl::False => "FALSE".to_owned(),
        Ltl::Atom(atom) => format!("p{atom}"),
        Ltl::Not(of) => format!("!({})", ltl(of)),
        Ltl::And(parts) => joined(parts.iter().map(ltl), " & ", "TRUE"),
        Ltl::Or(parts) => joined(parts.iter().map(ltl), " | ", "FALSE"),
        Ltl::Implies(left, right) => binary(left, "->", right),
        Ltl::Iff(left, right) => binary(left, "<->", right),
        Ltl::Next(of) => unary("X", of),
        Ltl::Finally(of) => unary("F", of),
        Ltl::Globally(of) => unary("G", of),
        Ltl::Yesterday(of) => unary("Y", of),
        Ltl::WeakYesterday(of) => unary("Z", of),
        Ltl::Once(of) => unary("O", of),
        Ltl::Historically(of) => unary("H", of),
        Ltl::Until(left, right) => binary(left, "U", right),
        Ltl::Release(left, right) => binary(left, "V", right),
        // NuSMV has no weak until
        Ltl::WeakUntil(left, right) => {
            format!("({} | G ({}))", binary(left, "U", right), ltl(left))
        }
        Ltl::Since(left, right) => binary(left, "S", right),
        Ltl::Triggered(left, right) => binary(left, "T", right),
    }
}
