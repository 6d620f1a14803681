//! Comparison of branching time under inputs that are free or held with a naive exploration: a node is the values of the locations, the
//! inputs that the last step read, and those that the property mentions.

use crate::naive::{Digits, Random};
use crate::naive_logic::{Condition, Fair, Formula, Graph};
use crate::{open, verified_system};
use asmotion_lang::ir::{FunctionId, FunctionKind};
use asmotion_lang::{Chooser, Environment, Machine, Value};
use asmotion_verify::{EnvironmentModel, Options, PropertyKind, SystemSpecification};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

pub const ATOMS: &[&str] = &["left", "right", "p", "q", "n = 1", "n < 3", EITHER];

/// Reads one of two inputs only.
const EITHER: &str = "(if p then left else right endif)";

/// Values of inputs.
type Inputs = BTreeMap<String, bool>;

/// Returns the number of inputs that have another value than they had.
fn changes(held: &Inputs, now: &Inputs) -> usize {
    let changed = now.iter().filter(|(name, value)| {
        let before = held.get(*name);
        before.is_some_and(|before| before != *value)
    });
    changed.count()
}

/// All values of some inputs.
fn assignments(names: &[String]) -> Vec<Inputs> {
    let mut all = vec![Inputs::new()];
    for name in names {
        let with = |value: bool| {
            let with = all.iter().cloned().map(move |mut inputs| {
                inputs.insert(name.clone(), value);
                inputs
            });
            with.collect::<Vec<_>>()
        };
        all = [with(false), with(true)].concat();
    }
    all
}

struct Reading<'a> {
    names: Vec<Arc<str>>,
    known: &'a Inputs,
    digits: &'a RefCell<Digits>,
    read: Inputs,
}

impl Environment for Reading<'_> {
    fn read(&mut self, function: FunctionId, _: &[Value]) -> Result<Option<Value>, String> {
        let name = self.names[function.0 as usize].to_string();
        let known = self.known.get(&name).copied();
        let value = known.unwrap_or_else(|| self.digits.borrow_mut().draw(2) == 1);
        self.read.insert(name, value);
        Ok(Some(Value::Bool(value)))
    }
}

struct Choices<'a>(&'a RefCell<Digits>);

impl Chooser for Choices<'_> {
    fn choose(&mut self, count: usize) -> usize {
        self.0.borrow_mut().draw(count)
    }
}

fn value(machine: &Machine, name: &str) -> Value {
    let program = machine.program();
    let mut names = program.symbols.functions.iter();
    let function = names.position(|known| &**known == name).unwrap();
    let slot = machine
        .state()
        .slot(program, FunctionId(function as u32), &[]);
    machine.state().get(slot.unwrap()).clone()
}

fn is_true(machine: &Machine, inputs: &Inputs, atom: &str) -> bool {
    match atom {
        "p" | "q" => value(machine, atom) == Value::Bool(true),
        "n = 1" => value(machine, "n") == Value::Int(1),
        "n < 3" => matches!(value(machine, "n"), Value::Int(n) if n < 3),
        EITHER if is_true(machine, inputs, "p") => inputs["left"],
        EITHER => inputs["right"],
        input => inputs[input],
    }
}

/// A node, with its machine.
pub struct Node {
    machine: Machine,
    held: Inputs,
    mentioned: Inputs,
}

/// The graph of a specification for properties that mention some inputs, of which so many change in a step.
pub struct Explored {
    pub graph: Graph,
    pub nodes: Vec<Node>,
    known: BTreeMap<(Vec<Value>, Inputs, Inputs), usize>,
    fails: bool,
}

fn locations(machine: &Machine) -> Vec<Value> {
    let (state, program) = (machine.state(), machine.program());
    let slots = state.slots().filter(|slot| {
        let function = state.function(program, *slot).unwrap();
        program.functions[function.0 as usize].kind == FunctionKind::Controlled
    });
    slots.map(|slot| state.get(slot).clone()).collect()
}

impl Explored {
    pub fn of(text: &str, mentioned: &[String], limit: usize) -> Self {
        let machine = open(text).machine().unwrap();
        let mut explored = Self {
            graph: Graph::default(),
            nodes: Vec::new(),
            known: BTreeMap::new(),
            fails: false,
        };
        explored.graph.initial = explored.enter(&machine, &Inputs::new(), mentioned, limit);
        let mut at = 0;
        while at < explored.nodes.len() {
            explored.expand(at, mentioned, limit);
            at += 1;
        }
        explored.graph.close(0);
        explored
    }

    /// Adds a state with each value of the mentioned inputs, as far as they may change; returns the nodes.
    fn enter(
        &mut self,
        machine: &Machine,
        held: &Inputs,
        mentioned: &[String],
        limit: usize,
    ) -> Vec<usize> {
        let all = assignments(mentioned).into_iter();
        let all = all.filter(|inputs| changes(held, inputs) <= limit);
        let all: Vec<Inputs> = all.collect();
        let nodes = all.into_iter().map(|inputs| {
            let key = (locations(machine), held.clone(), inputs.clone());
            if let Some(known) = self.known.get(&key) {
                return *known;
            }
            self.nodes.push(Node {
                machine: machine.clone(),
                held: held.clone(),
                mentioned: inputs,
            });
            self.graph.edges.push(Vec::new());
            self.known.insert(key, self.nodes.len() - 1);
            self.nodes.len() - 1
        });
        nodes.collect()
    }

    fn expand(&mut self, at: usize, mentioned: &[String], limit: usize) {
        let digits = RefCell::new(Digits::default());
        loop {
            let node = &self.nodes[at];
            let mut next = node.machine.clone();
            let mut inputs = Reading {
                names: next.program().symbols.functions.to_vec(),
                known: &node.mentioned,
                digits: &digits,
                read: Inputs::new(),
            };
            let is_done = next.step(&mut inputs, &mut Choices(&digits), 0).is_ok();
            let read = inputs.read;
            let mut all = node.mentioned.clone();
            all.extend(read.clone());
            if changes(&node.held, &all) <= limit {
                if is_done {
                    let held = if limit == usize::MAX {
                        Inputs::new()
                    } else {
                        read
                    };
                    let targets = self.enter(&next, &held, mentioned, limit);
                    self.graph.edges[at].extend(targets.into_iter().map(|it| (it, 0)));
                } else {
                    self.fails = true;
                }
            }
            if !digits.borrow_mut().increment() {
                return;
            }
        }
    }

    fn satisfies(&self, formula: &Formula) -> bool {
        self.graph
            .satisfies(formula, &|node, condition| self.is_true(node, condition))
    }

    pub fn is_true(&self, node: usize, condition: &Condition) -> bool {
        let node = &self.nodes[node];
        condition.is_true(&|atom| is_true(&node.machine, &node.mentioned, atom))
    }
}

/// The inputs that a text mentions.
pub fn mentioned(text: &str) -> Vec<String> {
    let inputs = ["left", "right"].into_iter();
    let inputs = inputs.filter(|input| text.contains(input));
    inputs.map(ToOwned::to_owned).collect()
}

#[test]
fn formulas_with_inputs_have_the_values_of_a_naive_exploration() {
    let seed = std::env::var("ASMOTION_NAIVE_SEED").ok();
    let seed = seed.and_then(|it| it.parse().ok());
    let mut random = Random(seed.unwrap_or(0x1e97_0a5e_55ed_0001));
    let (mut held, mut violated) = (0, 0);
    for round in 0..240 {
        let justice = (round % 4 == 0).then(|| Condition::random(&mut random, ATOMS, 1));
        let line = justice.as_ref().map(|it| format!("  JUSTICE {it}\n"));
        let text = random.specification();
        let text = text
            .replace("colour := undef", "colour := RED")
            .replace(":= undef", ":= 0")
            .replace(
                "import StandardLibrary\n",
                "import StandardLibrary\nimport CTLLibrary\n",
            )
            .replace(
                "  main rule",
                &format!("{}  main rule", line.clone().unwrap_or_default()),
            );
        let limit = [usize::MAX, 0, 1, 1][(round % 4) ^ (round / 4 % 4)];
        let formulas: Vec<Formula> = (0..6)
            .map(|at| Formula::temporal(&mut random, ATOMS, at % 3))
            .collect();
        let environment = if limit == usize::MAX {
            EnvironmentModel::Free
        } else {
            EnvironmentModel::Hold {
                changes: limit as u32,
            }
        };
        let system = SystemSpecification::of(open(&text)).with_environment(environment);
        let options = Options {
            properties: formulas.iter().map(ToString::to_string).collect(),
            ..Options::default()
        };
        let found = verified_system(system, &options);
        let plain = Explored::of(&text, &[], limit);
        let shown = format!("at most {limit} changes\n{text}");
        assert_eq!(found.states, plain.nodes.len() as u64, "{shown}");
        let mut general = found.properties.iter();
        let fails = general.find(|it| it.kind == PropertyKind::NoFault).unwrap();
        assert_eq!(fails.verdict.is_violated(), plain.fails, "{shown}");
        for formula in &formulas {
            let property = formula.to_string();
            let names = mentioned(&format!("{property}{}", line.as_deref().unwrap_or("")));
            let mut explored = Explored::of(&text, &names, limit);
            if let Some(justice) = &justice {
                let nodes = 0..explored.nodes.len();
                let nodes = nodes.map(|node| explored.is_true(node, justice)).collect();
                explored.graph.fairness = vec![Fair::Often(nodes, |_, _| false, 0)];
            }
            let expected = explored.satisfies(formula);
            let checked = found.properties.iter().find(|it| it.text == property);
            let verdict = &checked.unwrap().verdict;
            assert_eq!(verdict.holds(), expected, "{property}\n{shown}");
            assert_eq!(verdict.is_violated(), !expected, "{property}\n{shown}");
            held += u32::from(expected);
            violated += u32::from(!expected);
        }
    }
    assert!(held > 200 && violated > 200, "{held} {violated}");
}
