//! Comparison with a naive exploration: cloned machines, states as text, and every combination executed from scratch.

use crate::{open, verified};
use asmotion_lang::{Chooser, Environment, Machine, Value};
use asmotion_verify::Options;
use std::cell::RefCell;
use std::collections::BTreeSet;

/// Numbers that are drawn, each below a bound: the digits of a number with varying bases.
#[derive(Default)]
pub struct Digits {
    all: Vec<(usize, usize)>,
    at: usize,
}

impl Digits {
    pub fn draw(&mut self, bound: usize) -> usize {
        if self.at == self.all.len() {
            self.all.push((0, bound));
        }
        self.at += 1;
        self.all[self.at - 1].0
    }

    /// Returns `false` after the last combination.
    pub fn increment(&mut self) -> bool {
        self.at = 0;
        while let Some((digit, bound)) = self.all.pop() {
            if digit + 1 < bound {
                self.all.push((digit + 1, bound));
                return true;
            }
        }
        false
    }
}

struct Booleans<'a>(&'a RefCell<Digits>);

impl Environment for Booleans<'_> {
    fn read(
        &mut self,
        _: asmotion_lang::ir::FunctionId,
        _: &[Value],
    ) -> Result<Option<Value>, String> {
        Ok(Some(Value::Bool(self.0.borrow_mut().draw(2) == 1)))
    }
}

struct Choices<'a>(&'a RefCell<Digits>);

impl Chooser for Choices<'_> {
    fn choose(&mut self, count: usize) -> usize {
        self.0.borrow_mut().draw(count)
    }
}

/// The values of all locations that rules update.
fn state(machine: &Machine) -> Vec<Value> {
    let (state, program) = (machine.state(), machine.program());
    let slots = state.slots().filter(|slot| {
        let function = state.function(program, *slot).unwrap();
        program.functions[function.0 as usize].kind == asmotion_lang::ir::FunctionKind::Controlled
    });
    slots.map(|slot| state.get(slot).clone()).collect()
}

/// Numbers of states, and of executions that update a location, and whether a step fails.
fn explored(text: &str) -> (u64, u64, bool) {
    let machine = open(text).machine().unwrap();
    let mut seen = BTreeSet::from([state(&machine)]);
    let mut waiting = vec![machine];
    let (mut transitions, mut fails) = (1, false);
    while let Some(machine) = waiting.pop() {
        let digits = RefCell::new(Digits::default());
        loop {
            let mut next = machine.clone();
            match next.step(&mut Booleans(&digits), &mut Choices(&digits), 0) {
                Ok(step) => {
                    transitions += u64::from(!step.updates().is_empty());
                    if seen.insert(state(&next)) {
                        waiting.push(next);
                    }
                }
                Err(_) => fails = true,
            }
            if !digits.borrow_mut().increment() {
                break;
            }
        }
    }
    (seen.len() as u64, transitions, fails)
}

/// A pseudorandom sequence (xorshift).
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % bound
    }

    pub fn one_of<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[self.below(all.len() as u64) as usize]
    }

    pub fn condition(&mut self, depth: u32) -> String {
        match self.below(if depth == 0 { 5 } else { 8 }) {
            0 => self.one_of(&["left", "right", "p", "q"]).to_owned(),
            1 => format!("n = {}", self.below(4)),
            2 => format!("n < m({})", self.below(3)),
            3 => format!("m({}) != {}", self.below(3), self.below(3)),
            4 => {
                let location = self.one_of(&["colour", "p", "n", "m(0)"]);
                match self.below(3) {
                    0 => format!("isDef({location})"),
                    1 => format!("isUndef({location})"),
                    _ => "colour = RED".to_owned(),
                }
            }
            5 => format!(
                "({} and {})",
                self.condition(depth - 1),
                self.condition(depth - 1)
            ),
            6 => format!(
                "({} or {})",
                self.condition(depth - 1),
                self.condition(depth - 1)
            ),
            _ => format!("not ({})", self.condition(depth - 1)),
        }
    }

    fn rule(&mut self, depth: u32) -> String {
        match self.below(if depth == 0 { 6 } else { 11 }) {
            0 => format!("p := {}", self.condition(1)),
            1 => format!("q := {}", self.condition(1)),
            2 => format!(
                "n := {}",
                self.one_of(&["0", "3", "(n + 1) mod 4", "m(1)", "n + 1"])
            ),
            3 => format!(
                "m({}) := {}",
                self.below(3),
                self.one_of(&["0", "1", "(n + 2) mod 3", "2", "undef"])
            ),
            4 => "skip".to_owned(),
            5 => format!("colour := {}", self.one_of(&["RED", "GREEN", "undef"])),
            6 => format!(
                "if {} then {} endif",
                self.condition(2),
                self.rule(depth - 1)
            ),
            7 => format!(
                "if {} then {} else {} endif",
                self.condition(2),
                self.rule(depth - 1),
                self.rule(depth - 1)
            ),
            8 => format!(
                "par {} {} endpar",
                self.rule(depth - 1),
                self.rule(depth - 1)
            ),
            9 => format!(
                "seq {} {} endseq",
                self.rule(depth - 1),
                self.rule(depth - 1)
            ),
            _ => format!(
                "choose $c{depth} in Index with m($c{depth}) < 2 do par m($c{depth}) := m($c{depth}) + 1 {} endpar ifnone {}",
                self.rule(depth - 1),
                self.rule(depth - 1)
            ),
        }
    }

    pub fn specification(&mut self) -> String {
        let rule = self.rule(4);
        format!(
            "asm model
import StandardLibrary
signature:
  domain Index subsetof Integer
  domain Number subsetof Integer
  enum domain Colour = {{RED | GREEN}}
  monitored left: Boolean
  monitored right: Boolean
  controlled p: Boolean
  controlled q: Boolean
  controlled colour: Colour
  controlled n: Number
  controlled m: Index -> Index
definitions:
  domain Index = {{0 : 2}}
  domain Number = {{0 : 3}}
  main rule r_Main = {rule}
default init s0:
  function p = false
  function q = true
  function colour = RED
  function n = 1
  function m($i in Index) = $i
"
        )
    }
}

#[test]
fn random_specifications_have_the_states_that_a_naive_exploration_finds() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut large, mut failing) = (0, 0);
    for _ in 0..400 {
        let text = random.specification();
        let (states, transitions, fails) = explored(&text);
        let verification = verified(&text, &Options::default());
        let found = (verification.states, verification.transitions);
        assert_eq!(found, (states, transitions), "{text}");
        let no_fault = verification.properties.first().unwrap();
        assert_eq!(no_fault.verdict.is_violated(), fails, "{text}");
        large += u32::from(states > 4);
        failing += u32::from(fails);
    }
    // the specifications are not all trivial
    assert!(large > 40 && failing > 20, "{large} {failing}");
}
