//! Linear time with past, by the definitions: a path is compared with guesses of the truth of each temporal operand at each of its nodes,
//! which have to fit at each edge, and whose promises have to be kept. Runs that show a violation are judged in the same way.

use crate::naive::Random;
use crate::naive_fairness::{self, Due, enabled, explored, is_true, ways};
use crate::naive_inputs::{self, Explored};
use crate::naive_logic::{Condition, Fair, Graph, Nodes};
use crate::{independent, open, verified, verified_system};
use asmotion_verify::{Engine, EnvironmentModel, Options, Run, Storage, SystemSpecification};
use std::collections::BTreeMap;
use std::fmt;

/// Operators about the rest of a path, and about its beginning.
const UNARY: &[&str] = &["x", "f", "g", "y", "z", "o", "h"];
const BINARY: &[&str] = &["u", "v", "s", "t"];

/// A formula of linear time. An operand is the index of an earlier part.
#[derive(Debug)]
enum Part {
    Is(Condition),
    Not(usize),
    And(usize, usize),
    Or(usize, usize),
    Unary(&'static str, usize),
    Binary(&'static str, usize, usize),
}

/// A formula: the last part.
#[derive(Debug, Default)]
struct Linear(Vec<Part>);

impl Linear {
    fn random(random: &mut Random, atoms: &[&'static str], depth: u32) -> Self {
        let mut formula = Self::default();
        formula.add(random, atoms, depth, true);
        formula
    }

    /// Adds a formula; returns its index.
    fn add(
        &mut self,
        random: &mut Random,
        atoms: &[&'static str],
        depth: u32,
        is_temporal: bool,
    ) -> usize {
        let part = if depth == 0 {
            Part::Is(Condition::random(random, atoms, 1))
        } else {
            let kind = random.below(10) + if is_temporal { 3 } else { 0 };
            let operand = self.add(random, atoms, depth - 1, false);
            match kind {
                0 => Part::Not(operand),
                1 => Part::And(operand, self.add(random, atoms, depth - 1, false)),
                2 => Part::Or(operand, self.add(random, atoms, depth - 1, false)),
                3..=8 => Part::Unary(UNARY[random.below(7) as usize], operand),
                _ => {
                    let right = self.add(random, atoms, depth - 1, false);
                    Part::Binary(BINARY[random.below(4) as usize], operand, right)
                }
            }
        };
        self.0.push(part);
        self.0.len() - 1
    }

    fn temporal(&self) -> Vec<usize> {
        let parts = self.0.iter().enumerate();
        let temporal = parts.filter(|(_, it)| matches!(it, Part::Unary(..) | Part::Binary(..)));
        temporal.map(|(index, _)| index).collect()
    }

    fn show(&self, index: usize, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = |before: &str, operands: &[(usize, &str)]| {
            write!(f, "{before}")?;
            for (operand, after) in operands {
                self.show(*operand, f)?;
                write!(f, "{after}")?;
            }
            Ok(())
        };
        match &self.0[index] {
            Part::Is(condition) => write!(f, "({condition})"),
            Part::Not(operand) => shown("not (", &[(*operand, ")")]),
            Part::And(left, right) => shown("(", &[(*left, " and "), (*right, ")")]),
            Part::Or(left, right) => shown("(", &[(*left, " or "), (*right, ")")]),
            Part::Unary(name, operand) => shown(&format!("{name}("), &[(*operand, ")")]),
            Part::Binary(name, left, right) => {
                shown(&format!("{name}("), &[(*left, ", "), (*right, ")")])
            }
        }
    }

    /// The value of each part at a node, of which those of the temporal ones are given.
    fn values(
        &self,
        guess: &BTreeMap<usize, bool>,
        atom: &dyn Fn(&Condition) -> bool,
    ) -> Vec<bool> {
        let mut values: Vec<bool> = Vec::new();
        for (index, part) in self.0.iter().enumerate() {
            values.push(match part {
                Part::Is(condition) => atom(condition),
                Part::Not(operand) => !values[*operand],
                Part::And(left, right) => values[*left] && values[*right],
                Part::Or(left, right) => values[*left] || values[*right],
                Part::Unary(..) | Part::Binary(..) => guess[&index],
            });
        }
        values
    }

    /// Returns `true` if the values can be those of the first node of a path.
    fn starts(&self, now: &[bool]) -> bool {
        self.0.iter().enumerate().all(|(index, part)| match part {
            Part::Unary("y", _) => !now[index],
            Part::Unary("z", _) => now[index],
            Part::Unary("o" | "h", operand) => now[index] == now[*operand],
            Part::Binary("s" | "t", _, right) => now[index] == now[*right],
            Part::Is(_)
            | Part::Not(_)
            | Part::And(..)
            | Part::Or(..)
            | Part::Unary(..)
            | Part::Binary(..) => true,
        })
    }

    /// Returns `true` if the values of two nodes can follow each other.
    fn fits(&self, now: &[bool], next: &[bool]) -> bool {
        self.0.iter().enumerate().all(|(index, part)| match part {
            Part::Unary(name, it) => match *name {
                "x" => now[index] == next[*it],
                "f" => now[index] == (now[*it] || next[index]),
                "g" => now[index] == (now[*it] && next[index]),
                "y" | "z" => next[index] == now[*it],
                "o" => next[index] == (next[*it] || now[index]),
                _ => next[index] == (next[*it] && now[index]),
            },
            Part::Binary(name, left, right) => match *name {
                "u" => now[index] == (now[*right] || (now[*left] && next[index])),
                "v" => now[index] == (now[*right] && (now[*left] || next[index])),
                "s" => next[index] == (next[*right] || (next[*left] && now[index])),
                _ => next[index] == (next[*right] && (next[*left] || now[index])),
            },
            Part::Is(_) | Part::Not(_) | Part::And(..) | Part::Or(..) => true,
        })
    }

    /// Returns `true` if a node keeps the promise of a part, which has to happen infinitely often.
    fn keeps(&self, index: usize, now: &[bool]) -> bool {
        match &self.0[index] {
            Part::Unary("f", goal) | Part::Binary("u", _, goal) => !now[index] || now[*goal],
            Part::Unary("g", goal) | Part::Binary("v", _, goal) => now[index] || !now[*goal],
            Part::Is(_)
            | Part::Not(_)
            | Part::And(..)
            | Part::Or(..)
            | Part::Unary(..)
            | Part::Binary(..) => true,
        }
    }

    /// Returns `true` if the formula is true on all fair paths from the initial nodes.
    fn is_satisfied(&self, graph: &Graph, truths: &dyn Fn(usize, &Condition) -> bool) -> bool {
        let temporal = self.temporal();
        let guess = |bits: u32| {
            let parts = temporal.iter().enumerate();
            let parts = parts.map(|(at, part)| (*part, bits >> at & 1 == 1));
            parts.collect::<BTreeMap<usize, bool>>()
        };
        let guesses: Vec<_> = (0..1 << temporal.len()).map(guess).collect();
        let values = |node: usize| -> Vec<Vec<bool>> {
            let values = guesses.iter();
            let values = values.map(|it| self.values(it, &|condition| truths(node, condition)));
            values.collect()
        };
        let values: Vec<Vec<Vec<bool>>> = (0..graph.edges.len()).map(values).collect();
        // the nodes that can be reached, with their guesses
        let (mut known, mut nodes) = (BTreeMap::new(), Vec::new());
        let mut product = Graph::default();
        for node in &graph.initial {
            for (guess, now) in values[*node].iter().enumerate() {
                if self.starts(now) && now.last() == Some(&false) {
                    known.entry((*node, guess)).or_insert_with(|| {
                        nodes.push((*node, guess));
                        nodes.len() - 1
                    });
                }
            }
        }
        product.initial = (0..nodes.len()).collect();
        while product.edges.len() < nodes.len() {
            let (node, guess) = nodes[product.edges.len()];
            let now = &values[node][guess];
            let mut edges = Vec::new();
            for (target, label) in &graph.edges[node] {
                for (guess, next) in values[*target].iter().enumerate() {
                    if self.fits(now, next) {
                        let target = *known.entry((*target, guess)).or_insert_with(|| {
                            nodes.push((*target, guess));
                            nodes.len() - 1
                        });
                        edges.push((target, *label));
                    }
                }
            }
            product.edges.push(edges);
        }
        let lifted = |of: &Nodes| nodes.iter().map(|(node, _)| of[*node]).collect::<Nodes>();
        for fair in &graph.fairness {
            product.fairness.push(match fair {
                Fair::Often(nodes, test, mask) => Fair::Often(lifted(nodes), *test, *mask),
                Fair::IfOften(nodes, test, mask) => Fair::IfOften(lifted(nodes), *test, *mask),
            });
        }
        for part in temporal {
            let kept = nodes.iter();
            let kept = kept.map(|(node, guess)| self.keeps(part, &values[*node][*guess]));
            product
                .fairness
                .push(Fair::Often(kept.collect(), |_, _| false, 0));
        }
        let fair = product.fair_within(&vec![true; nodes.len()]);
        !product.initial.iter().any(|it| fair[*it])
    }
}

impl fmt::Display for Linear {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.show(self.0.len() - 1, f)
    }
}

/// The atoms of agents; `x` is an operator here.
const OF_AGENTS: &[&str] = &[
    "common = 0",
    "common < 2",
    "place(ONE) = 2",
    "place(TWO) = 1",
    "number(THREE) = 1",
    "(exists $a in Agents with place($a) = 3)",
];

/// Calls the function `x` of the agents `number`.
pub fn renamed(text: &str) -> String {
    let text = text
        .replace("x(", "number(")
        .replace("over x", "over number");
    text.replace("controlled x", "controlled number")
}

fn original(atom: &str) -> String {
    atom.replace("number(", "x(")
}

/// Largest number of temporal operators that is compared.
const MAX_OPERATORS: usize = 5;

/// Formulas with few temporal operators.
fn formulas(random: &mut Random, atoms: &[&'static str], count: usize) -> Vec<Linear> {
    let mut all = Vec::new();
    while all.len() < count {
        let formula = Linear::random(random, atoms, 1 + all.len() as u32 % 3);
        if formula.temporal().len() <= MAX_OPERATORS {
            all.push(formula);
        }
    }
    all
}

/// The states of a run of agents that ends in a cycle, with the agents that its steps move.
fn path_of(run: &Run) -> Option<(Vec<Vec<i64>>, Graph)> {
    let cycle = run.cycle?;
    let names = naive_fairness::LOCATIONS.map(renamed);
    let mut known: BTreeMap<&str, &str> = run
        .initial
        .iter()
        .map(|(name, value)| (name.as_str(), value.as_str()))
        .collect();
    let state = |known: &BTreeMap<&str, &str>| {
        let values = names
            .iter()
            .map(|name| known[name.as_str()].parse::<i64>().unwrap());
        values.collect::<Vec<i64>>()
    };
    let mut states = vec![state(&known)];
    let mut edges = Vec::new();
    for (at, step) in run.steps.iter().enumerate() {
        for update in &step.updates {
            known.insert(&update.location, &update.after);
        }
        states.push(state(&known));
        let agent = step.choices.iter().flat_map(|it| &it.values);
        let agent = agent.map(|(_, value)| value.as_str()).next();
        let agent = ["ONE", "TWO", "THREE"]
            .iter()
            .position(|it| Some(*it) == agent);
        let label = match agent {
            Some(agent) if states[at] != states[at + 1] => 1 << agent,
            _ => 0,
        };
        edges.push(vec![(at + 1, label)]);
    }
    let last = states.len() - 1;
    if cycle < run.steps.len() {
        assert_eq!(
            states[last], states[cycle],
            "the run does not return: {run:?}"
        );
        states.pop();
        edges[last - 1][0].0 = cycle;
    } else {
        edges.push(vec![(last, 0)]);
    }
    let initial = vec![0];
    Some((
        states,
        Graph {
            initial,
            edges,
            ..Graph::default()
        },
    ))
}

fn seed(default: u64) -> u64 {
    let seed = std::env::var("ASMOTION_NAIVE_SEED").ok();
    seed.and_then(|it| it.parse().ok()).unwrap_or(default)
}

#[test]
fn linear_formulas_under_fairness_have_the_values_of_a_naive_exploration() {
    let mut random = Random(seed(0x11fa_0a5e_55ed_0005));
    let (mut held, mut violated, mut compared, mut runs) = (0, 0, 0, 0);
    for round in 0..200_usize {
        let text = independent::specification(&mut random);
        let Some((states, mut graph)) = explored(&text, 60) else {
            continue;
        };
        compared += 1;
        let due = Due::random(&mut random, round % 5);
        let moved = enabled(&graph);
        due.apply((&states, &mut graph), (&states, &moved));
        let text = renamed(&text)
            .replace(
                "import StandardLibrary\n",
                "import StandardLibrary\nimport LTLLibrary\n",
            )
            .replace(
                "  main rule",
                &format!("{}  main rule", renamed(&due.lines())),
            );
        let formulas = formulas(&mut random, OF_AGENTS, 5);
        let properties: Vec<String> = formulas.iter().map(ToString::to_string).collect();
        let plain = Options {
            only: properties.clone(),
            properties,
            fairness: due.names(),
            ..Options::default()
        };
        let mut all = ways(&mut random, &plain).to_vec();
        if plain.fairness.is_empty() {
            all.push(Options {
                engine: Engine::Symbolic,
                ..plain.clone()
            });
        }
        let found: Vec<_> = all.iter().map(|way| verified(&text, way)).collect();
        for formula in &formulas {
            let atom = |states: &[Vec<i64>], node: usize, condition: &Condition| {
                condition.is_true(&|atom| is_true(&states[node], &original(atom)))
            };
            let expected = formula.is_satisfied(&graph, &|node, it| atom(&states, node, it));
            let property = formula.to_string();
            for (found, way) in found.iter().zip(&all) {
                let checked = found.properties.iter().find(|it| it.text == property);
                let verdict = &checked.unwrap().verdict;
                let shown = format!("{property}\n{way:?}\n{text}");
                assert_eq!(verdict.holds(), expected, "{shown}");
                assert_eq!(verdict.is_violated(), !expected, "{shown}");
                // the run is a fair path on which the formula is false
                if let Some((on_path, mut path)) =
                    verdict.run().filter(|_| !expected).and_then(path_of)
                {
                    due.apply((&on_path, &mut path), (&states, &moved));
                    let is_satisfied =
                        formula.is_satisfied(&path, &|node, it| atom(&on_path, node, it));
                    assert!(!is_satisfied, "{:?}\n{shown}", verdict.run());
                    runs += 1;
                }
            }
            held += u32::from(expected);
            violated += u32::from(!expected);
        }
    }
    assert!(
        held > 100 && violated > 100 && compared > 60 && runs > 200,
        "{held} {violated} {compared} {runs}"
    );
}

#[test]
fn linear_formulas_with_inputs_have_the_values_of_a_naive_exploration() {
    let mut random = Random(seed(0x11e9_0a5e_55ed_0006));
    let (mut held, mut violated) = (0, 0);
    for round in 0..160_usize {
        let justice =
            (round % 4 == 0).then(|| Condition::random(&mut random, naive_inputs::ATOMS, 1));
        let line = justice.as_ref().map(|it| format!("  JUSTICE {it}\n"));
        let line = line.unwrap_or_default();
        let text = random.specification();
        let text = text
            .replace("colour := undef", "colour := RED")
            .replace(":= undef", ":= 0")
            .replace(
                "import StandardLibrary\n",
                "import StandardLibrary\nimport LTLLibrary\n",
            )
            .replace("  main rule", &format!("{line}  main rule"));
        let limit = [usize::MAX, 0, 1, usize::MAX][(round % 4) ^ (round / 4 % 4)];
        let formulas = formulas(&mut random, naive_inputs::ATOMS, 5);
        let properties: Vec<String> = formulas.iter().map(ToString::to_string).collect();
        let options = Options {
            properties,
            ..Options::default()
        };
        let system = || {
            let environment = if limit == usize::MAX {
                EnvironmentModel::Free
            } else {
                EnvironmentModel::Hold {
                    changes: limit as u32,
                }
            };
            SystemSpecification::of(open(&text)).with_environment(environment)
        };
        let mut all = vec![
            verified_system(system(), &options),
            verified_system(
                system(),
                &Options {
                    storage: Storage::Compact,
                    threads: 2,
                    ..options.clone()
                },
            ),
        ];
        if limit == usize::MAX {
            all.push(verified(
                &text,
                &Options {
                    engine: Engine::Symbolic,
                    ..options.clone()
                },
            ));
        }
        let shown = format!("at most {limit} changes\n{text}");
        for formula in &formulas {
            let property = formula.to_string();
            let names = naive_inputs::mentioned(&format!("{property}{line}"));
            let mut explored = Explored::of(&text, &names, limit);
            if explored.nodes.len() > 120 {
                continue;
            }
            if let Some(justice) = &justice {
                let nodes = 0..explored.nodes.len();
                let nodes = nodes.map(|node| explored.is_true(node, justice)).collect();
                explored.graph.fairness = vec![Fair::Often(nodes, |_, _| false, 0)];
            }
            let expected =
                formula.is_satisfied(&explored.graph, &|node, it| explored.is_true(node, it));
            for (way, found) in all.iter().enumerate() {
                let checked = found.properties.iter().find(|it| it.text == property);
                let verdict = &checked.unwrap().verdict;
                assert_eq!(verdict.holds(), expected, "{way}: {property}\n{shown}");
                assert_eq!(
                    verdict.is_violated(),
                    !expected,
                    "{way}: {property}\n{shown}"
                );
            }
            held += u32::from(expected);
            violated += u32::from(!expected);
        }
    }
    assert!(held > 150 && violated > 150, "{held} {violated}");
}
