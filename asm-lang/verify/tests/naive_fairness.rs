//! Comparison of branching time under fairness of agents, justice and compassion with a naive exploration, in every storage, with reductions
//! and threads.

use crate::naive::{Digits, Random};
use crate::naive_logic::{Condition, Fair, Formula, Graph};
use crate::storage::{ENOUGH, Limited};
use crate::{independent, open, verified};
use asmotion_lang::simulate::location;
use asmotion_lang::{Chooser, Machine, NoInputs, Value};
use asmotion_verify::{FairName, Options, Storage};
use std::cell::RefCell;
use std::collections::BTreeMap;

const ATOMS: &[&str] = &[
    "common = 0",
    "common < 2",
    "place(ONE) = 2",
    "place(TWO) = 1",
    "x(THREE) = 1",
    "(exists $a in Agents with place($a) = 3)",
];

/// Largest number of states that is compared.
const MAX_STATES: usize = 160;

struct Choices<'a>(&'a RefCell<Digits>);

impl Chooser for Choices<'_> {
    fn choose(&mut self, count: usize) -> usize {
        self.0.borrow_mut().draw(count)
    }
}

/// The values of `place` and `x` for each agent, and of `common`.
fn locations(machine: &Machine) -> Vec<i64> {
    let state = machine.state();
    let named: BTreeMap<String, i64> = state
        .slots()
        .filter_map(|slot| {
            let Value::Int(number) = state.get(slot) else {
                return None;
            };
            Some((location(machine, slot), *number))
        })
        .collect();
    let names = [
        "place(ONE)",
        "place(TWO)",
        "place(THREE)",
        "x(ONE)",
        "x(TWO)",
        "x(THREE)",
        "common",
    ];
    names.iter().map(|name| named[*name]).collect()
}

fn is_true(state: &[i64], atom: &str) -> bool {
    match atom {
        "common = 0" => state[6] == 0,
        "common < 2" => state[6] < 2,
        "place(ONE) = 2" => state[0] == 2,
        "place(TWO) = 1" => state[1] == 1,
        "x(THREE) = 1" => state[5] == 1,
        _ => state[..3].contains(&3),
    }
}

/// The states, with edges that are labelled with the agent that they move. `None` if there are too many.
fn explored(text: &str) -> Option<(Vec<Vec<i64>>, Graph)> {
    // a machine takes a violated invariant for a fault
    let lines = text.lines().filter(|line| !line.contains("invariant"));
    let text = lines.collect::<Vec<_>>().join("\n");
    let machine = open(&text).machine().unwrap();
    let mut states = vec![locations(&machine)];
    let mut known = BTreeMap::from([(locations(&machine), 0)]);
    let mut machines = vec![machine];
    let mut graph = Graph {
        initial: vec![0],
        ..Graph::default()
    };
    while graph.edges.len() < machines.len() {
        let at = graph.edges.len();
        let digits = RefCell::new(Digits::default());
        let mut edges = Vec::new();
        for agent in 0..3 {
            let mut next = machines[at].clone();
            if next.step(&mut NoInputs, &mut Choices(&digits), 0).is_ok() {
                let state = locations(&next);
                let count = machines.len();
                let target = *known.entry(state.clone()).or_insert(count);
                if target == count {
                    states.push(state);
                    machines.push(next);
                }
                edges.push((target, if target == at { 0 } else { 1 << agent }));
            }
            assert_eq!(digits.borrow_mut().increment(), agent < 2, "{text}");
        }
        graph.edges.push(edges);
        if machines.len() > MAX_STATES {
            return None;
        }
    }
    graph.close(0);
    Some((states, graph))
}

/// Fairness that is due to the agents.
fn of_agents(graph: &Graph, is_strong: bool) -> Vec<Fair> {
    let agents = (0..3).map(|agent| {
        let is_enabled = |edges: &Vec<(usize, u32)>| edges.iter().any(|it| it.1 >> agent & 1 == 1);
        let enabled = graph.edges.iter().map(is_enabled);
        let moves = |label: u32, mask: u32| label & mask != 0;
        if is_strong {
            Fair::IfOften(enabled.collect(), moves, 1 << agent)
        } else {
            Fair::Often(enabled.map(|it| !it).collect(), moves, 1 << agent)
        }
    });
    agents.collect()
}

/// Ways to explore, which make no difference.
fn ways(random: &mut Random, plain: &Options) -> [Options; 3] {
    [0, 1, 2].map(|way| {
        let mut flag = || random.below(2) == 0;
        let (symmetry, cone, independent) = (flag(), flag(), flag());
        Options {
            symmetry,
            cone,
            independent: independent && !symmetry,
            without_grounding: flag(),
            storage: match way {
                0 => Storage::Exact,
                1 => Storage::Compact,
                _ => Limited::of(ENOUGH),
            },
            threads: 1 + random.below(3) as usize,
            ..plain.clone()
        }
    })
}

#[test]
fn formulas_under_fairness_have_the_values_of_a_naive_exploration() {
    let seed = std::env::var("ASMOTION_NAIVE_SEED").ok();
    let seed = seed.and_then(|it| it.parse().ok());
    let mut random = Random(seed.unwrap_or(0xfa1e_0a5e_55ed_0003));
    let (mut held, mut violated, mut compared) = (0, 0, 0);
    for round in 0..200 {
        let text = independent::specification(&mut random);
        let Some((states, mut graph)) = explored(&text) else {
            continue;
        };
        compared += 1;
        let mut condition = || Condition::random(&mut random, ATOMS, 1);
        let (often, cause, effect) = (condition(), condition(), condition());
        let of = |condition: &Condition| {
            let truths = states.iter();
            let truths = truths.map(|state| condition.is_true(&|atom| is_true(state, atom)));
            truths.collect::<Vec<bool>>()
        };
        let (mut lines, mut fairness) = (String::new(), Vec::new());
        match round % 5 {
            0 => {
                lines = format!("  JUSTICE {often}\n");
                graph.fairness = vec![Fair::Often(of(&often), |_, _| false, 0)];
            }
            1 => {
                // a state in which the effect is true makes the edges that leave it true
                lines = format!("  COMPASSION({cause}, {effect})\n");
                let effects = of(&effect);
                for (edges, is_it) in graph.edges.iter_mut().zip(effects) {
                    edges
                        .iter_mut()
                        .for_each(|it| it.1 |= u32::from(is_it) << 5);
                }
                let is_effect = |label: u32, mask: u32| label & mask != 0;
                graph.fairness = vec![Fair::IfOften(of(&cause), is_effect, 1 << 5)];
            }
            2 | 3 => {
                let is_strong = round % 5 == 3;
                fairness = vec![FairName {
                    name: "Agents".to_owned(),
                    is_strong,
                }];
                graph.fairness = of_agents(&graph, is_strong);
            }
            _ => {}
        }
        let text = text
            .replace(
                "import StandardLibrary\n",
                "import StandardLibrary\nimport CTLLibrary\n",
            )
            .replace("  main rule", &format!("{lines}  main rule"));
        let formulas: Vec<Formula> = (0..5)
            .map(|at| Formula::temporal(&mut random, ATOMS, at % 3))
            .collect();
        let properties: Vec<String> = formulas.iter().map(ToString::to_string).collect();
        let plain = Options {
            only: properties.clone(),
            properties,
            fairness,
            ..Options::default()
        };
        let all = ways(&mut random, &plain);
        let found: Vec<_> = all.iter().map(|way| verified(&text, way)).collect();
        for formula in &formulas {
            let expected = graph.satisfies(formula, &|node, condition| {
                condition.is_true(&|atom| is_true(&states[node], atom))
            });
            let property = formula.to_string();
            for (found, way) in found.iter().zip(&all) {
                let checked = found.properties.iter().find(|it| it.text == property);
                let holds = checked.unwrap().verdict.holds();
                assert_eq!(holds, expected, "{property}\n{way:?}\n{text}");
            }
            held += u32::from(expected);
            violated += u32::from(!expected);
        }
    }
    assert!(
        held > 100 && violated > 100 && compared > 80,
        "{held} {violated} {compared}"
    );
}
