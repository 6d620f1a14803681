//! Agents that rules create: `choose`, `forall` and quantifiers over extended domains, compared with a naive exploration in every storage,
//! with reductions and threads.

use crate::naive::{Digits, Random};
use crate::naive_fairness::ways;
use crate::naive_logic::{Condition, Formula, Graph};
use crate::{open, verified};
use asmotion_lang::simulate::location;
use asmotion_lang::{Chooser, Machine, NoInputs, Value};
use asmotion_verify::Options;
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Largest number of states that is compared.
const MAX_STATES: usize = 150;

const ATOMS: &[&str] = &[
    "made = 1",
    "made < 2",
    "common = 0",
    "place(first) = 1",
    "(exists $a in Agent with place($a) = 2)",
    "(forall $a in Agent with place($a) > 0)",
];

struct Choices<'a>(&'a RefCell<Digits>);

impl Chooser for Choices<'_> {
    fn choose(&mut self, count: usize) -> usize {
        self.0.borrow_mut().draw(count)
    }
}

fn guard(random: &mut Random, agent: &str) -> String {
    let number = random.below(3);
    match random.below(6) {
        0 => format!("place({agent}) = {number}"),
        1 => format!("common = {number}"),
        2 => format!("(exists $o in Agent with $o != {agent} and place($o) = {number})"),
        3 => "made < 2".to_owned(),
        4 => format!("place(first) != {number}"),
        _ => "true".to_owned(),
    }
}

fn update(random: &mut Random, agent: &str) -> String {
    let number = random.below(3);
    match random.below(7) {
        0 => format!("common := {number}"),
        1 => format!("place({agent}) := {number}"),
        2 => "common := (common + 1) mod 3".to_owned(),
        3 => format!("forall $z in Agent with place($z) = {number} do place($z) := 0"),
        4 => format!(
            "choose $o in Agent with {} do place($o) := {number} ifnone common := 0",
            guard(random, "$o")
        ),
        // outside of its domain at last
        5 if random.below(4) == 0 => format!("place({agent}) := place({agent}) + 1"),
        _ => format!("place({agent}) := (place({agent}) + 1) mod 3"),
    }
}

fn specification(random: &mut Random) -> String {
    let steps = (0..3).map(|_| {
        let guard = guard(random, "$a");
        match random.below(3) {
            0 => format!(
                "if {guard} and made < 2 then extend Agent with $n do par place($n) := {} made := made + 1 endpar endif",
                random.below(3)
            ),
            _ => format!("if {guard} then {} endif", update(random, "$a")),
        }
    });
    let steps: Vec<String> = steps.collect();
    format!(
        "asm model
import StandardLibrary
import CTLLibrary
signature:
  abstract domain Agent
  domain Place subsetof Integer
  domain Act subsetof Integer
  static first: Agent
  controlled place: Agent -> Place
  controlled made: Place
  controlled common: Place
definitions:
  domain Place = {{0 : 2}}
  domain Act = {{0 : 2}}
  main rule r_Main = choose $a in Agent, $act in Act with true do
    switch $act case 0 : {} case 1 : {} case 2 : {} endswitch
default init s0:
  function place($a in Agent) = 0
  function made = 0
  function common = 0
",
        steps[0], steps[1], steps[2]
    )
}

/// The values of locations, without those of `place` that are 0, which a location may have before it is used.
type State = BTreeMap<String, i64>;

fn state(machine: &Machine) -> State {
    let state = machine.state();
    let named = state.slots().filter_map(|slot| {
        let Value::Int(number) = state.get(slot) else {
            return None;
        };
        let name = location(machine, slot);
        (*number != 0 || !name.starts_with("place")).then_some((name, *number))
    });
    named.collect()
}

fn is_true(state: &State, atom: &str) -> bool {
    let mut places = state.iter().filter(|(name, _)| name.starts_with("place"));
    match atom {
        "made = 1" => state["made"] == 1,
        "made < 2" => state["made"] < 2,
        "common = 0" => state["common"] == 0,
        "place(first) = 1" => state.get("place(first)") == Some(&1),
        "(exists $a in Agent with place($a) = 2)" => places.any(|(_, number)| *number == 2),
        _ => places.count() as i64 == 1 + state["made"],
    }
}

/// The states and the graph; `None` if there are too many. The number of transitions and whether steps fail.
fn explored(text: &str) -> Option<(Vec<State>, Graph, u64, bool)> {
    let machine = open(text).machine().unwrap();
    let mut states = vec![state(&machine)];
    let mut known = BTreeMap::from([(state(&machine), 0)]);
    let mut machines = vec![machine];
    let mut graph = Graph {
        initial: vec![0],
        ..Graph::default()
    };
    let (mut transitions, mut fails) = (1, false);
    while graph.edges.len() < machines.len() {
        let at = graph.edges.len();
        let digits = RefCell::new(Digits::default());
        let mut edges = Vec::new();
        loop {
            let mut next = machines[at].clone();
            match next.step(&mut NoInputs, &mut Choices(&digits), 0) {
                Ok(step) => {
                    transitions += u64::from(!step.updates().is_empty());
                    let after = state(&next);
                    let count = machines.len();
                    let target = *known.entry(after.clone()).or_insert(count);
                    if target == count {
                        states.push(after);
                        machines.push(next);
                    }
                    edges.push((target, 0));
                }
                Err(_) => fails = true,
            }
            if !digits.borrow_mut().increment() {
                break;
            }
        }
        graph.edges.push(edges);
        if machines.len() > MAX_STATES {
            return None;
        }
    }
    graph.close(0);
    Some((states, graph, transitions, fails))
}

#[test]
fn created_agents_have_the_states_and_verdicts_that_a_naive_exploration_finds() {
    let seed = std::env::var("ASMOTION_NAIVE_SEED").ok();
    let seed = seed.and_then(|it| it.parse().ok());
    let mut random = Random(seed.unwrap_or(0xe87e_4ded_a9e4_7500));
    let (mut held, mut violated, mut compared, mut failing) = (0, 0, 0, 0);
    for _ in 0..200 {
        let text = specification(&mut random);
        let Some((states, graph, transitions, fails)) = explored(&text) else {
            continue;
        };
        compared += 1;
        failing += u32::from(fails);
        let all = verified(&text, &Options::default());
        assert_eq!(all.states, states.len() as u64, "{text}");
        assert_eq!(all.transitions, transitions, "{text}");
        assert!(all.incomplete.is_none(), "{text}");
        assert_eq!(all.properties[0].verdict.is_violated(), fails, "{text}");
        let formulas: Vec<Formula> = (0..5)
            .map(|at| Formula::temporal(&mut random, ATOMS, at % 3))
            .collect();
        let properties: Vec<String> = formulas.iter().map(ToString::to_string).collect();
        let plain = Options {
            only: properties.clone(),
            properties,
            ..Options::default()
        };
        let ways = ways(&mut random, &plain);
        let found: Vec<_> = ways.iter().map(|way| verified(&text, way)).collect();
        let truth = |node: usize, condition: &Condition| {
            condition.is_true(&|atom| is_true(&states[node], atom))
        };
        for formula in &formulas {
            let expected = graph.satisfies(formula, &truth);
            let property = formula.to_string();
            for (found, way) in found.iter().zip(&ways) {
                let checked = found.properties.iter().find(|it| it.text == property);
                let verdict = &checked.unwrap().verdict;
                assert_eq!(verdict.holds(), expected, "{property}\n{way:?}\n{text}");
                assert_eq!(
                    verdict.is_violated(),
                    !expected,
                    "{property}\n{way:?}\n{text}"
                );
            }
            held += u32::from(expected);
            violated += u32::from(!expected);
        }
    }
    assert!(
        held > 100 && violated > 100 && compared > 100 && failing > 1,
        "{held} {violated} {compared} {failing}"
    );
}
