//! Ranges whose guard begins with an equation: `choose $w in Robot with target($w) = $z`.

use asmotion_lang::simulate::Seeded;
use asmotion_lang::{BackEnd, Chooser, FirstChoice, MemoryFiles, NoInputs, Specification};

/// Each zone takes one of the robots that go there, in parallel.
fn zones(robots: u32, zones: u32, guard: &str, rule: &str) -> String {
    format!(
        "asm zones
import StandardLibrary
signature:
  domain Robot subsetof Integer
  domain Zone subsetof Integer
  controlled target: Robot -> Zone
  controlled charge: Robot -> Integer
  controlled taken: Zone -> Robot
definitions:
  domain Robot = {{1 : {robots}}}
  domain Zone = {{0 : {last}}}
  main rule r_Main = forall $z in Zone with true do
    {rule} $w in Robot with {guard} do par
      taken($z) := $w
      target($w) := ($z + 1) mod {zones}
      charge($w) := charge($w) - 1
    endpar
default init s0:
  function target($w in Robot) = $w * $w mod {zones}
  function charge($w in Robot) = $w mod 7
",
        last = zones - 1
    )
}

fn open(text: &str) -> Specification {
    let mut files = MemoryFiles::new();
    files.add("zones.asm", text);
    asmotion_lang::open("zones.asm", &files).unwrap()
}

/// Returns the updates and choices of some steps; those of a failed one are its fault.
fn steps(text: &str, back_end: BackEnd, chooser: &mut dyn Chooser) -> Vec<String> {
    let specification = open(text);
    let mut machine = specification.machine().unwrap();
    // without native code, closures are compared with themselves
    let _ = machine.set_back_end(back_end);
    let step = |_| {
        let done = machine.step(&mut NoInputs, chooser, 0);
        let done = done.map(|step| {
            let updates = step.updates().iter();
            let updates: Vec<_> = updates.map(|it| (it.slot, &it.value)).collect();
            let choices = step.choices().iter();
            let choices: Vec<_> = choices.map(|it| (it.index, it.count)).collect();
            format!("{updates:?} {choices:?}")
        });
        done.unwrap_or_else(|fault| format!("{:?}", std::mem::discriminant(&fault.kind)))
    };
    (0..5).map(step).collect()
}

#[test]
fn an_equation_selects_the_same_elements_as_any_other_guard() {
    let guards = [
        ("target($w) = $z", "not (target($w) != $z)"),
        (
            "$z = target($w) and charge($w) > 2",
            "not ($z != target($w)) and charge($w) > 2",
        ),
        ("target($w) = $z + 3", "not (target($w) != $z + 3)"),
        // a choice that clashes in most steps
        ("target($w) = 0", "not (target($w) != 0)"),
    ];
    for (equation, other) in guards {
        for back_end in [BackEnd::Closures, BackEnd::Native] {
            let of = |guard: &str, chooser: &mut dyn Chooser| {
                steps(&zones(200, 20, guard, "choose"), back_end, chooser)
            };
            assert_eq!(
                of(equation, &mut Seeded::new(3)),
                of(other, &mut Seeded::new(3)),
                "{equation}"
            );
            assert_eq!(
                of(equation, &mut FirstChoice),
                of(other, &mut FirstChoice),
                "{equation}"
            );
            let all = |guard: &str| {
                let text = zones(200, 20, guard, "forall");
                steps(&text, back_end, &mut FirstChoice)
            };
            assert_eq!(all(equation), all(other), "{equation}");
        }
    }
}

#[test]
fn each_of_many_zones_chooses_one_of_many_robots() {
    let text = zones(10_000, 2_000, "target($w) = $z", "choose");
    for back_end in [BackEnd::Closures, BackEnd::Native] {
        for step in steps(&text, back_end, &mut Seeded::new(3)) {
            assert!(step.contains('['), "the step failed: {step}");
        }
    }
}

#[test]
fn a_range_that_is_bound_too_often_is_advised_to_begin_with_an_equation() {
    let text = zones(10_000, 2_000, "not (target($w) != $z)", "choose");
    let specification = open(&text);
    let mut machine = specification.machine().unwrap();
    let fault = machine
        .step(&mut NoInputs, &mut Seeded::new(3), 0)
        .map(|_| ())
        .unwrap_err();
    let said = specification.explain_in(&fault, &machine);
    assert_eq!(said.code.to_string(), "R011");
    let help = format!("{said:?}");
    assert!(help.contains("f($x) = t"), "{help}");
    assert!(!help.contains("the body"), "{help}");
}
