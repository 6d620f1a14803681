//! Rules over short ranges and remainders, which native code unrolls and computes without divisions, run as closures do.

#![allow(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use asmotion_lang::ir::Origin;
use asmotion_lang::machine::back_end::NativeCompiler;
use asmotion_lang::{BackEnd, Chooser, Machine, MemoryFiles, NoInputs, Specification, Value};
use asmotion_native::Cranelift;

const SIGNATURE: &str = "
    enum domain Colour = {RED | GREEN | BLUE}
    domain Cell subsetof Integer
    domain Row subsetof Integer
    controlled light: Colour -> Boolean
    controlled level: Cell -> Integer
    controlled board: Prod(Row, Cell) -> Integer
    controlled flag: Boolean -> Integer
    controlled last: Colour
    controlled n: Integer
    controlled m: Integer
    controlled sum: Integer
    controlled product: Integer
    controlled high: Cell
";

fn specification(rules: &str) -> Specification {
    let text = format!(
        "asm t\nimport StandardLibrary\nsignature:{SIGNATURE}definitions:\n domain Cell = {{0 : 4}}\n domain Row = {{1 : 2}}\n\
         main rule r_Main = {rules}\ndefault init s:\n function light($c in Colour) = $c = GREEN\n \
         function level($i in Cell) = $i * 7\n function board($r in Row, $i in Cell) = $r + $i\n \
         function flag($b in Boolean) = 0\n function last = RED\n function n = 1\n function m = 0\n function sum = 0\n \
         function product = 1\n function high = 4\n"
    );
    let mut files = MemoryFiles::new();
    files.add("t", text.as_str());
    asmotion_lang::open("t", &files).unwrap_or_else(|failure| panic!("{failure}\n{text}"))
}

/// Chooses by a sequence of numbers, or picks a value for each variable.
#[derive(Clone)]
struct Choices {
    seed: usize,
    pick: Option<Value>,
}

impl Chooser for Choices {
    fn choose(&mut self, count: usize) -> usize {
        self.seed = self
            .seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.seed >> 33) % count
    }

    fn picked(&self, _: Origin) -> Option<Value> {
        self.pick.clone()
    }
}

fn run(specification: &Specification, back_end: BackEnd, pick: Option<Value>) -> Vec<String> {
    let mut machine: Machine = specification.machine().unwrap();
    machine.set_back_end(back_end).unwrap();
    let mut choices = Choices { seed: 7, pick };
    let mut steps = Vec::new();
    for _ in 0..40 {
        let stepped = machine.step(&mut NoInputs, &mut choices, 0).map(|_| ());
        let step = machine.last_step();
        let shown = format!(
            "{:?} {:?} {:?}",
            step.updates(),
            step.before(),
            step.choices()
        );
        steps.push(format!("{shown} {:?} {:?}", stepped.err(), machine.slots()));
    }
    steps
}

/// Checks that the rules have a direct rule that runs as closures do, also if each variable has a value that is picked.
fn agrees(rules: &str) {
    let specification = specification(rules);
    let machine = specification.machine().unwrap();
    let direct = Cranelift.compile_direct(&specification.program, machine.slots());
    assert!(direct.is_some(), "{rules}");
    for pick in [
        None,
        Some(Value::Int(0)),
        Some(Value::Int(3)),
        Some(Value::Int(99)),
    ] {
        let closures = run(&specification, BackEnd::Closures, pick.clone());
        let native = run(&specification, BackEnd::Native, pick);
        for (step, (native, closures)) in native.iter().zip(&closures).enumerate() {
            assert_eq!(native, closures, "{rules}, step {step}");
        }
    }
}

#[test]
fn loops_over_numbers_elements_and_truth_values_agree() {
    for rules in [
        "forall $i in Cell with level($i) mod 2 = 0 do level($i) := level($i) + $i + 1",
        "forall $c in Colour with not light($c) do par light($c) := true last := $c endpar",
        "forall $c in Colour do light($c) := $c = BLUE or not light($c)",
        "forall $b in Boolean with flag($b) < 9 do flag($b) := flag($b) + if $b then 2 else 1 endif",
        "forall $r in Row, $i in Cell with board($r, $i) < 20 do board($r, $i) := board(3 - $r, 4 - $i) + 1",
        "forall $r in Row do forall $i in Cell with $i != $r do board($r, $i) := board($r, ($i + 1) mod 5) + n",
        "par n := n + 1 forall $i in Cell with level(($i + 4) mod 5) > level($i) do level($i) := level(($i + 1) mod 5) endpar",
        "if (exist $c in Colour with light($c) and $c != last) then last := BLUE else light(RED) := not light(RED) endif",
        "if (forall $i in Cell with level($i) < 40) then level(3) := level(3) + 5 else level(3) := 0 endif",
        // a location of which two iterations write different values
        "forall $i in Cell with level($i) > 20 do n := level($i)",
        // off the axis for some iterations
        "forall $i in Cell with $i < 4 do level($i + 1) := level($i) + 1",
    ] {
        agrees(rules);
    }
}

#[test]
fn choices_agree_whether_there_are_candidates_or_not() {
    for rules in [
        "choose $i in Cell with level($i) mod 3 != 0 do level($i) := level($i) + 1 ifnone n := n + 1",
        "choose $i in Cell with level($i) > 1000 do n := 0 ifnone n := n + 1",
        "choose $i in Cell with level($i) < 12 do forall $j in Cell with $j != $i do level($j) := level($j) + 1",
    ] {
        agrees(rules);
    }
}

#[test]
fn remainders_of_bounded_and_unbounded_numbers_agree() {
    for rules in [
        "par n := (n * 8121 + 28411) mod 134456 m := n mod 6 sum := (sum + n) mod 1009 endpar",
        "par n := (n + 1) mod 1000 m := (n * n) mod 997 sum := n mod 8 endpar",
        "par n := n + 1 m := n mod 7 sum := (0 - n) mod 7 product := (product * 3) mod 1000003 endpar",
        "par n := n - 3 m := n mod 16 sum := n mod 12 endpar",
        "par n := n * 3 + 1 m := (n + 12345) mod 100 endpar",
        // constants, of which one does not exist
        "par n := n + 1 m := (7 mod 4) * 10 + 9 mod 10 endpar",
        "if n < 3 then n := n + 1 else m := (9 * 0) * (3 mod 0) endif",
    ] {
        agrees(rules);
    }
}

#[test]
fn sums_at_the_limits_of_integers_agree() {
    for rules in [
        "par n := n + 9223372036854775800 m := m - 9223372036854775800 endpar",
        "n := 9223372036854775800 + n",
        "par m := m + (0 - 9223372036854775807) n := 5 endpar",
        "seq n := n + 1 m := m + n sum := sum + m product := product * 2 endseq",
    ] {
        agrees(rules);
    }
}

/// The bounds of a location do not grow for ever if an update is always beyond its domain.
#[test]
fn an_update_beyond_every_value_of_its_domain_agrees() {
    agrees("high := high + 1");
    agrees("if n < 3 then n := n + 1 else high := high + 1 endif");
}
