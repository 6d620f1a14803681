//! Values whose parts must be elements of domains: updates, inputs and values set from outside are checked alike.

use crate::support::opened;
use asmotion_lang::ir::{DomainId, FunctionId};
use asmotion_lang::{
    BackEnd, Environment, FaultKind, FirstChoice, Machine, MemoryFiles, NoInputs, ReadOptions,
    Specification, Value,
};

/// Codomains, a value in each of them, a value with a part that is not, and that part with the name of its domain.
const CASES: [(&str, &str, &str, &str, &str); 16] = [
    ("Few", "3", "4", "4", "Few"),
    ("Seq(Few)", "[3, 5, 3]", "[3, 4]", "4", "Few"),
    ("Bag(Few)", "<3, 3, 5>", "<3, 4>", "4", "Few"),
    ("Powerset(Few)", "{3, 5}", "{3, 4}", "4", "Few"),
    ("Prod(Few, String)", "(3, \"a\")", "(4, \"a\")", "4", "Few"),
    ("Prod(Integer, Few)", "(4, 3)", "(4, 6)", "6", "Few"),
    (
        "Map(Few, Integer)",
        "{3 -> 4}",
        "{3 -> 4, 4 -> 3}",
        "4",
        "Few",
    ),
    (
        "Map(Integer, Few)",
        "{4 -> 3}",
        "{4 -> 3, 5 -> 4}",
        "4",
        "Few",
    ),
    ("Seq(Small)", "[1, 3]", "[1, 4]", "4", "Small"),
    (
        "Seq(Powerset(Small))",
        "[{}, {1}]",
        "[{}, {1, 0}]",
        "0",
        "Small",
    ),
    (
        "Map(Integer, Seq(Prod(Few, Small)))",
        "{9 -> [(3, 1)]}",
        "{9 -> [(3, 1), (3, 4)]}",
        "4",
        "Small",
    ),
    (
        "Bag(Bag(Few))",
        "<<3>, <3, 5>>",
        "<<3>, <3, 4>>",
        "4",
        "Few",
    ),
    ("Seq(Warm)", "[RED]", "[RED, BLUE]", "BLUE", "Warm"),
    ("Seq(Box)", "[b]", "[b, item]", "item", "Box"),
    (
        "Seq(Pair)",
        "[(1, 2)]",
        "[(1, 2), (2, 1)]",
        "(2, 1)",
        "Pair",
    ),
    (
        "Seq(Name)",
        "[\"ann\"]",
        "[\"ann\", \"eve\"]",
        "\"eve\"",
        "Name",
    ),
];

fn text(codomain: &str, rule: &str) -> String {
    format!(
        "asm parts
import StandardLibrary
signature:
  enum domain Colour = {{RED | BLUE | ORANGE}}
  abstract domain Item
  domain Box subsetof Item
  domain Few subsetof Integer
  domain Small subsetof Integer
  domain Warm subsetof Colour
  domain Pair subsetof Prod(Integer, Integer)
  domain Name subsetof String
  static b: Box
  static item: Item
  controlled x: {codomain}
  controlled f: Integer -> {codomain}
  controlled at: Integer -> {codomain}
  monitored m: {codomain}
  controlled n: Integer
definitions:
  domain Few = {{3, 5, 7}}
  domain Small = {{1 : 3}}
  domain Warm = {{RED, ORANGE}}
  domain Pair = {{(1, 2), (2, 3)}}
  domain Name = {{\"ann\", \"bob\"}}
  rule r_value = result := VALUE
  macro rule r_set($place in {codomain}, $value in {codomain}) = $place := $value
  main rule r_Main = {rule}
"
    )
}

/// Rules that give the location a value.
const UPDATES: [&str; 6] = [
    "x := VALUE",
    "f(7) := VALUE",
    "seq n := 1 x := VALUE endseq",
    "forall $k in {1 : 2} with true do f($k) := VALUE",
    "let ($v = VALUE) in x := $v endlet",
    "r_set[x, VALUE]",
];

/// Makes a step with this back end.
fn step(specification: &Specification, back_end: BackEnd) -> Result<Value, FaultKind> {
    let mut machine = specification.machine().unwrap();
    // without native code, closures run twice
    let _ = machine.set_back_end(back_end);
    match machine.step(&mut NoInputs, &mut FirstChoice, 0) {
        Ok(step) => Ok(step.updates().last().unwrap().value.clone()),
        Err(fault) => Err(fault.kind),
    }
}

fn domain(machine: &Machine, domain: DomainId) -> String {
    machine.program().symbols.domains[domain.0 as usize].to_string()
}

/// The part and the domain of a misfit.
fn misfit(kind: &FaultKind, machine: &Machine) -> (String, String) {
    let (FaultKind::Outside { misfit, .. } | FaultKind::OutsideInput { misfit, .. }) = kind else {
        panic!("{kind:?}");
    };
    let part = misfit.part.show(&machine.naming()).to_string();
    (part, domain(machine, misfit.domain))
}

#[test]
fn an_update_with_a_part_outside_its_domain_is_a_fault() {
    for (codomain, good, bad, part, of) in CASES {
        for update in UPDATES {
            let with = |value: &str| {
                let text = text(codomain, update).replace("VALUE", value);
                // a term whose static type is too wide is refused by the analysis
                crate::open("parts", &text)
            };
            let Ok(specification) = with(good) else {
                panic!(
                    "{codomain}: {update} with {good}: {}",
                    with(good).err().unwrap()
                );
            };
            for back_end in [BackEnd::Closures, BackEnd::Native] {
                let done = step(&specification, back_end);
                assert!(done.is_ok(), "{codomain}: {update} {good}: {done:?}");
            }
            let specification = with(bad);
            let specification =
                specification.unwrap_or_else(|failure| panic!("{update} {bad}: {failure}"));
            let machine = specification.machine().unwrap();
            for back_end in [BackEnd::Closures, BackEnd::Native] {
                let kind = step(&specification, back_end).unwrap_err();
                assert!(matches!(kind, FaultKind::Outside { .. }), "{kind:?}");
                let expected = (part.to_owned(), of.to_owned());
                assert_eq!(
                    misfit(&kind, &machine),
                    expected,
                    "{codomain}: {update} {bad}"
                );
            }
        }
    }
}

/// The value of a term.
fn value(codomain: &str, term: &str) -> Value {
    let text = text("Any", "at(1) := VALUE").replace("VALUE", term);
    let specification = opened("parts", &text);
    let value = step(&specification, BackEnd::Closures);
    value.unwrap_or_else(|kind| panic!("{codomain}: {term}: {kind:?}"))
}

/// Answers `m` with a value.
struct Given(Value);

impl Environment for Given {
    fn read(&mut self, _: FunctionId, _: &[Value]) -> Result<Option<Value>, String> {
        Ok(Some(self.0.clone()))
    }
}

#[test]
fn an_input_and_a_value_from_outside_are_checked_alike() {
    for (codomain, good, bad, part, of) in CASES {
        let expected = (part.to_owned(), of.to_owned());
        let text = text(codomain, "if isDef(m) then x := m endif").replace("VALUE", good);
        let specification = opened("parts", &text);
        for back_end in [BackEnd::Closures, BackEnd::Native] {
            let machine = || {
                let mut machine = specification.machine().unwrap();
                let _ = machine.set_back_end(back_end);
                machine
            };
            let read = |term: &str| {
                let mut machine = machine();
                let mut inputs = Given(value(codomain, term));
                let step = machine.step(&mut inputs, &mut FirstChoice, 0);
                step.map(|_| ()).map_err(|fault| fault.kind)
            };
            assert_eq!(read(good), Ok(()), "{codomain}");
            let kind = read(bad).unwrap_err();
            assert!(matches!(kind, FaultKind::OutsideInput { .. }), "{kind:?}");
            assert_eq!(misfit(&kind, &machine()), expected, "{codomain}");
            for name in ["x", "m"] {
                let function = specification.function(name, 0).unwrap();
                let mut machine = machine();
                machine.set(function, &[], value(codomain, good)).unwrap();
                let set = machine.set(function, &[], value(codomain, bad));
                let kind = set.unwrap_err().kind;
                assert_eq!(misfit(&kind, &machine), expected, "{codomain} {name}");
            }
        }
    }
}

#[test]
fn undef_is_a_part_of_every_value_and_a_domain_without_definition_restricts_nothing() {
    let few = text("Seq(Few)", "x := [3, undef]").replace("VALUE", "[3]");
    assert!(step(&opened("parts", &few), BackEnd::Closures).is_ok());
    let any = "asm parts
import StandardLibrary
signature:
  domain Unknown subsetof Integer
  domain Few subsetof Integer
  controlled x: Seq(Prod(Unknown, Few))
definitions:
  domain Few = {3, 5, 7}
  main rule r_Main = x := [(4, VALUE)]
";
    for (value, is_ok) in [("3", true), ("4", false)] {
        let done = step(
            &opened("parts", &any.replace("VALUE", value)),
            BackEnd::Closures,
        );
        assert_eq!(done.is_ok(), is_ok, "{value}: {done:?}");
    }
}

#[test]
fn the_reference_does_not_check_parts() {
    let mut files = MemoryFiles::new();
    let text = text("Seq(Few)", "x := VALUE").replace("VALUE", "[4]");
    files.add("parts.asm", text);
    let options = ReadOptions {
        compatible: true,
        ..ReadOptions::default()
    };
    let specification = asmotion_lang::open_with("parts.asm", &files, &options).unwrap();
    assert!(step(&specification, BackEnd::Closures).is_ok());
}
