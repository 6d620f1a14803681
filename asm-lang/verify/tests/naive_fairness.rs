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

pub const ATOMS: &[&str] = &[
    "common = 0",
    "common < 2",
    "place(ONE) = 2",
    "place(TWO) = 1",
    "x(THREE) = 1",
    "(exists $a in Agents with place($a) = 3)",
];

/// Largest number of states that is compared.
const MAX_STATES: usize = 160;

/// The locations of a state, in order.
pub const LOCATIONS: [&str; 7] = [
    "place(ONE)",
    "place(TWO)",
    "place(THREE)",
    "x(ONE)",
    "x(TWO)",
    "x(THREE)",
    "common",
];

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
    LOCATIONS.iter().map(|name| named[*name]).collect()
}

pub fn is_true(state: &[i64], atom: &str) -> bool {
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
pub fn explored(text: &str, max_states: usize) -> Option<(Vec<Vec<i64>>, Graph)> {
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
        if machines.len() > max_states {
            return None;
        }
    }
    graph.close(0);
    Some((states, graph))
}

/// The fairness of a specification.
pub enum Due {
    Nothing,
    Justice(Condition),
    Compassion(Condition, Condition),
    /// Weak or strong, of each agent.
    Agents {
        is_strong: bool,
    },
}

/// Label of the edges that leave a state in which the effect of compassion is true.
const EFFECT: u32 = 1 << 5;

impl Due {
    pub fn random(random: &mut Random, kind: usize) -> Self {
        let mut condition = || Condition::random(random, ATOMS, 1);
        let (often, cause, effect) = (condition(), condition(), condition());
        match kind {
            0 => Self::Justice(often),
            1 => Self::Compassion(cause, effect),
            2 | 3 => Self::Agents {
                is_strong: kind == 3,
            },
            _ => Self::Nothing,
        }
    }

    /// The lines of a specification.
    pub fn lines(&self) -> String {
        match self {
            Self::Justice(often) => format!("  JUSTICE {often}\n"),
            Self::Compassion(cause, effect) => format!("  COMPASSION({cause}, {effect})\n"),
            Self::Nothing | Self::Agents { .. } => String::new(),
        }
    }

    pub fn names(&self) -> Vec<FairName> {
        match self {
            Self::Agents { is_strong } => vec![FairName {
                name: "Agents".to_owned(),
                is_strong: *is_strong,
            }],
            Self::Nothing | Self::Justice(_) | Self::Compassion(..) => Vec::new(),
        }
    }

    /// The fairness of a part of a graph, whose edges it labels. Agents are enabled as in the whole graph.
    pub fn apply(
        &self,
        (states, graph): (&[Vec<i64>], &mut Graph),
        (all, whole): (&[Vec<i64>], &[u32]),
    ) {
        let of = |condition: &Condition| {
            let truths = states.iter();
            let truths = truths.map(|state| condition.is_true(&|atom| is_true(state, atom)));
            truths.collect::<Vec<bool>>()
        };
        let is_labelled = |label: u32, mask: u32| label & mask != 0;
        match self {
            Self::Nothing => {}
            Self::Justice(often) => {
                graph.fairness = vec![Fair::Often(of(often), |_, _| false, 0)];
            }
            Self::Compassion(cause, effect) => {
                for (edges, is_it) in graph.edges.iter_mut().zip(of(effect)) {
                    edges
                        .iter_mut()
                        .for_each(|it| it.1 |= if is_it { EFFECT } else { 0 });
                }
                graph.fairness = vec![Fair::IfOften(of(cause), is_labelled, EFFECT)];
            }
            Self::Agents { is_strong } => {
                let agents = (0..3).map(|agent| {
                    let is_enabled = |state: &Vec<i64>| {
                        let at = all.iter().position(|it| it == state).unwrap();
                        whole[at] >> agent & 1 == 1
                    };
                    let enabled = states.iter().map(is_enabled);
                    if *is_strong {
                        Fair::IfOften(enabled.collect(), is_labelled, 1 << agent)
                    } else {
                        Fair::Often(enabled.map(|it| !it).collect(), is_labelled, 1 << agent)
                    }
                });
                graph.fairness = agents.collect();
            }
        }
    }
}

/// The agents that the edges of each node move.
pub fn enabled(graph: &Graph) -> Vec<u32> {
    let nodes = graph.edges.iter();
    nodes
        .map(|edges| edges.iter().fold(0, |all, it| all | it.1))
        .collect()
}

/// Ways to explore, which make no difference.
pub fn ways(random: &mut Random, plain: &Options) -> [Options; 3] {
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
    for round in 0..200_usize {
        let text = independent::specification(&mut random);
        let Some((states, mut graph)) = explored(&text, MAX_STATES) else {
            continue;
        };
        compared += 1;
        let due = Due::random(&mut random, round % 5);
        let moved = enabled(&graph);
        due.apply((&states, &mut graph), (&states, &moved));
        let (lines, fairness) = (due.lines(), due.names());
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
