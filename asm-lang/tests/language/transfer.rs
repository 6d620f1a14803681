//! A machine continues in the state of another version of its specification: locations keep their values if their functions and
//! elements have counterparts.

use crate::support::opened;
use asmotion_lang::machine::TransferError;
use asmotion_lang::simulate::{applied, state};
use asmotion_lang::{Environment, FaultKind, FirstChoice, Machine, NoInputs, Value, ir};

const OLD: &str = "asm old
import StandardLibrary
signature:
  enum domain Phase = {IDLE | BUSY | DONE}
  abstract domain Item
  domain Slot subsetof Integer
  monitored asked: Integer
  controlled phase: Phase
  controlled steps: Integer
  controlled place: Item -> Integer
  controlled load: Slot -> Integer
  controlled any: Integer -> Phase
  controlled pair: Prod(Phase, Integer)
  controlled row: Seq(Phase)
  controlled set: Powerset(Phase)
  controlled bag: Bag(Phase)
  controlled map: Map(Phase, Integer)
  controlled act: Rule
  controlled other: Integer
  controlled codomain: Integer
  controlled gone: Integer
  static const: Integer
definitions:
  domain Slot = {0 : 3}
  function const = 1
  rule r_idle = skip
  rule r_work = steps := steps + 100
  main rule r_Main = par
    steps := steps + 1
    phase := BUSY
    any(1000) := DONE
    any(-1) := BUSY
    extend Item with $a, $b do par place($a) := steps + asked place($b) := 7 endpar
    forall $s in Slot do load($s) := 10 * $s
    pair := (DONE, 5)
    row := [DONE, IDLE, DONE]
    set := {BUSY, IDLE}
    bag := <BUSY, BUSY>
    map := {DONE -> 1, IDLE -> 2}
    act := <<r_work>>
    other := 3
    codomain := 4
    gone := 5
  endpar
default init s0:
  function steps = 0
";

/// The other version has its declarations in another order, so that elements, functions and rules have other numbers.
const NEW: &str = "asm new
import StandardLibrary
signature:
  controlled added: Integer
  controlled act: Rule
  controlled map: Map(Phase, Integer)
  controlled bag: Bag(Phase)
  controlled set: Powerset(Phase)
  controlled row: Seq(Phase)
  controlled pair: Prod(Phase, Integer)
  controlled any: Integer -> Phase
  controlled load: Slot -> Integer
  controlled place: Item -> Integer
  controlled steps: Integer
  controlled phase: Phase
  controlled asked: Integer
  controlled other: Slot -> Integer
  controlled codomain: Phase
  controlled const: Integer
  controlled first: Integer
  monitored given: Integer
  domain Slot subsetof Integer
  abstract domain Other
  abstract domain Item
  enum domain Phase = {WAIT | DONE | BUSY | IDLE}
definitions:
  domain Slot = {0 : 1}
  rule r_other = skip
  rule r_work = steps := steps + 1000
  rule r_idle = skip
  main rule r_Main = par
    act
    if added = 0 then act := <<r_work>> endif
    extend Item with $c do place($c) := 8
  endpar
default init s0:
  function act = <<r_other>>
  function steps = 50
  function added = 9
  function first = given
";

/// Answers every input with the same number.
struct Given(i64);

impl Environment for Given {
    fn read(&mut self, _: ir::FunctionId, _: &[Value]) -> Result<Option<Value>, String> {
        Ok(Some(Value::Int(self.0)))
    }
}

fn machine(name: &str, text: &str) -> Machine {
    opened(name, text).machine().unwrap()
}

fn step(machine: &mut Machine, given: i64) {
    machine
        .step(&mut Given(given), &mut FirstChoice, 0)
        .unwrap();
}

/// Returns each location that has a value, with it.
fn listed(machine: &Machine) -> Vec<String> {
    let all = state(machine).into_iter();
    all.map(|(location, value)| format!("{location} = {value}"))
        .collect()
}

#[test]
fn locations_with_a_counterpart_keep_their_values() {
    let mut old = machine("old", OLD);
    step(&mut old, 20);
    step(&mut old, 30);
    let mut new = machine("new", NEW);
    // elements that exist already are not created again
    let _ = new.adopt_elements(&old);
    let elements = new.adopt_elements(&old);
    new.continue_from(&old, &elements, &mut Given(6), 0)
        .unwrap();
    assert_eq!(new.steps(), 2);
    let kept = [
        "act = <<r_work>>",
        "added = 9",
        "any(-1) = BUSY",
        "any(1000) = DONE",
        "bag = <BUSY, BUSY>",
        "first = 6",
        "given = 6",
        "load(0) = 0",
        "load(1) = 10",
        "map = {DONE -> 1, IDLE -> 2}",
        "pair = (DONE, 5)",
        "phase = BUSY",
        "place(item!1) = 20",
        "place(item!2) = 7",
        "place(item!3) = 31",
        "place(item!4) = 7",
        "row = [DONE, IDLE, DONE]",
        "set = {BUSY, IDLE}",
        "steps = 2",
    ];
    assert_eq!(listed(&new), kept);
    assert_eq!(new.last_step().updates(), []);
    // the rule and the elements are those of the new version
    step(&mut new, 6);
    assert_eq!(new.steps(), 3);
    let after = listed(&new);
    assert!(after.contains(&"steps = 1002".to_owned()), "{after:?}");
    assert!(after.contains(&"place(item!5) = 8".to_owned()), "{after:?}");
}

#[test]
fn only_functions_with_equal_signatures_correspond() {
    let old = opened("old", OLD);
    let mut new = machine("new", NEW);
    let elements = new.adopt_elements(&old.machine().unwrap());
    let symbols = &old.program.symbols.functions;
    let own = (0..symbols.len()).filter(|index| old.program.functions[*index].own);
    let without = own.filter(|index| elements.function(ir::FunctionId(*index as u32)).is_none());
    let without: Vec<&str> = without.map(|index| &*symbols[index]).collect();
    assert_eq!(without, ["asked", "other", "codomain", "gone", "const"]);
}

#[test]
fn a_machine_without_steps_passes_nothing_on() {
    let old = machine("old", OLD);
    let mut new = machine("new", NEW);
    let before = new.snapshot();
    let elements = new.adopt_elements(&old);
    new.continue_from(&old, &elements, &mut NoInputs, 0)
        .unwrap();
    assert_eq!(new.snapshot(), before);
}

/// Returns the reason that the new version cannot continue in the state after a step of the old one.
fn refused(new: &str) -> TransferError {
    let mut old = machine("old", OLD);
    step(&mut old, 1);
    let mut new = machine("new", new);
    let elements = new.adopt_elements(&old);
    let before = new.snapshot();
    let error = new
        .continue_from(&old, &elements, &mut Given(6), 0)
        .unwrap_err();
    assert_eq!(new.snapshot(), before, "{error:?}");
    error
}

#[test]
fn a_value_without_a_counterpart_is_refused() {
    // one element or rule is missing in turn, and with it a part of some value
    let cases = [
        ("WAIT | DONE | BUSY | IDLE", "WAIT | DONE | IDLE", "phase"),
        ("WAIT | DONE | BUSY | IDLE", "WAIT | BUSY | IDLE", "pair"),
        ("r_work", "r_works", "act"),
        // the rule is there, but could not be executed as a value
        ("if added = 0 then act := <<r_work>> endif", "skip", "act"),
    ];
    for (part, with, expected) in cases {
        let error = refused(&NEW.replace(part, with));
        let TransferError::Value {
            function,
            arguments,
            ..
        } = error
        else {
            panic!("{error:?}");
        };
        let location = applied(&machine("old", OLD), function, &arguments);
        assert_eq!(location, expected, "{with}");
    }
}

#[test]
fn a_value_outside_its_codomain_is_refused() {
    let narrow = NEW
        .replace(
            "any: Integer -> Phase",
            "any: Integer -> Phase\n  controlled level: Level",
        )
        .replace(
            "domain Slot subsetof",
            "domain Level subsetof Integer\n  domain Slot subsetof",
        )
        .replace("domain Slot =", "domain Level = {0 : 4}\n  domain Slot =");
    let text = OLD
        .replace(
            "any: Integer -> Phase",
            "any: Integer -> Phase\n  controlled level: Level",
        )
        .replace(
            "domain Slot subsetof",
            "domain Level subsetof Integer\n  domain Slot subsetof",
        )
        .replace("domain Slot =", "domain Level = {0 : 9}\n  domain Slot =")
        .replace("other := 3", "level := asked");
    for (level, is_kept) in [(4, true), (5, false)] {
        let mut old = machine("old", &text);
        step(&mut old, level);
        let mut new = machine("new", &narrow);
        let elements = new.adopt_elements(&old);
        let result = new.continue_from(&old, &elements, &mut Given(6), 0);
        match result {
            Ok(()) => assert!(is_kept && listed(&new).contains(&"level = 4".to_owned())),
            Err(TransferError::Fault(fault)) => {
                assert!(!is_kept && matches!(fault.kind, FaultKind::Outside { .. }));
            }
            Err(error) => panic!("{error:?}"),
        }
    }
}

#[test]
fn elements_that_were_created_are_adopted() {
    let mut old = machine("old", OLD);
    step(&mut old, 20);
    step(&mut old, 30);
    let mut new = machine("new", NEW);
    let elements = new.adopt_elements(&old);
    new.continue_from(&old, &elements, &mut Given(6), 0)
        .unwrap();
    let mut places = listed(&new);
    places.retain(|it| it.starts_with("place"));
    let kept = [
        "place(item!1) = 20",
        "place(item!2) = 7",
        "place(item!3) = 31",
        "place(item!4) = 7",
    ];
    assert_eq!(places, kept);
    // the domain consists of the elements that have places
    let placed: Vec<Value> = new
        .state()
        .locations(new.program())
        .into_iter()
        .filter(|(function, ..)| &*new.program().symbols.functions[function.0 as usize] == "place")
        .map(|(_, arguments, _)| arguments[0].clone())
        .collect();
    let domains = (0..new.program().domains.len() as u32).map(ir::DomainId);
    let domains: Vec<&[Value]> = domains.map(|it| new.state().extent(it)).collect();
    assert!(domains.contains(&&*placed), "{placed:?}, {domains:?}");
}
