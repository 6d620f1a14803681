//! Limits of the symbolic engine: they end what a single operation on diagrams does, and hold for many inputs and locations.

use crate::{open, verdict_of};
use asmotion_verify::{Engine, Incomplete, Limits, Options, Verdict, Verification, verify};

/// `last + 1` inputs of a step, which it stores in `a`, and in `b` with the opposite indices if `mirrored`.
fn stored(last: u32, mirrored: bool) -> String {
    let mirror = if mirrored {
        format!("b($i) := x({last} - $i)")
    } else {
        "skip".to_owned()
    };
    format!(
        "asm stored
import StandardLibrary
signature:
  domain Place subsetof Integer
  monitored x: Place -> Boolean
  controlled a: Place -> Boolean
  controlled b: Place -> Boolean
definitions:
  domain Place = {{0 : {last}}}
  invariant inv over a: not (a(0) and not a(0))
  main rule r_Main = forall $i in Place with true do par a($i) := x($i) {mirror} endpar
default init s0:
  function a($i in Place) = false
  function b($i in Place) = false
"
    )
}

fn symbolic(
    text: &str,
    possible: &str,
    memory: u64,
    proceed: &mut dyn FnMut() -> bool,
) -> Verification {
    let options = Options {
        engine: Engine::Symbolic,
        possible: vec![possible.to_owned()],
        limits: Limits {
            memory: Some(memory),
            ..Limits::default()
        },
        ..Options::default()
    };
    let found = verify(open(text), &options, &mut |_| proceed());
    found.unwrap_or_else(|refusal| panic!("{}", crate::refused(&refusal)))
}

/// The diagram of the states after one step has far more than a million nodes, since `b(0)` is next to `a(0)` and equal to `a(43)`.
#[test]
fn a_single_operation_is_ended_while_it_runs() {
    let mut calls = 0;
    let found = symbolic(&stored(43, true), "a(0)", 200 << 20, &mut || {
        calls += 1;
        calls < 40
    });
    assert_eq!(found.incomplete, Some(Incomplete::Stopped));
    // a stopped exploration asks a few times more: nothing goes on
    assert!((40..60).contains(&calls), "{calls}");
    let unknown = found.properties.iter();
    let mut unknown = unknown.filter(|it| it.name.as_deref() == Some("inv"));
    assert!(matches!(unknown.next().unwrap().verdict, Verdict::Unknown));
}

#[test]
fn an_operation_without_enough_memory_leaves_nothing_said_to_hold() {
    let found = symbolic(&stored(43, true), "a(0)", 8 << 20, &mut || true);
    assert_eq!(found.incomplete, Some(Incomplete::Memory));
    assert!(found.memory <= 8 << 20, "{}", found.memory);
    assert_eq!(verdict_of(&found, "inv"), "unknown");
}

/// A run is found without trying the combinations of inputs.
#[test]
fn forty_inputs_of_a_step_are_verified() {
    let all = "(forall $i in Place with a($i))";
    let found = symbolic(&stored(39, false), all, 64 << 20, &mut || true);
    assert_eq!(found.incomplete, None);
    assert_eq!(found.states, 1 << 40);
    assert_eq!(verdict_of(&found, "inv"), "holds");
    let property = found.properties.iter().find(|it| it.text == all);
    let run = property.unwrap().verdict.run().unwrap();
    assert_eq!(run.steps.len(), 1);
    assert_eq!(run.steps[0].updates.len(), 40);
}

#[test]
fn forty_inputs_of_a_condition_and_a_fault_are_shown() {
    let text = stored(39, false).replace(
        "  main rule r_Main = ",
        "  main rule r_Main = if (forall $i in Place with x($i) and a($i)) then par a(0) := true a(0) := false endpar else ",
    );
    let text = text.replace("default init", "endif\ndefault init");
    let seen = "(forall $i in Place with a($i) and not x($i))";
    let found = symbolic(&text, seen, 64 << 20, &mut || true);
    let property = found.properties.iter().find(|it| it.text == seen);
    let run = property.unwrap().verdict.run().unwrap();
    assert_eq!((run.steps.len(), run.inputs.len()), (1, 40));
    let fault = found
        .properties
        .iter()
        .find(|it| it.text == "no step fails");
    let run = fault.unwrap().verdict.run().unwrap();
    assert_eq!(run.steps.len(), 2);
    assert!(run.steps[1].fault.is_some());
}

#[test]
fn forty_inputs_are_too_many_to_try_one_by_one() {
    for without_grounding in [false, true] {
        let options = Options {
            without_grounding,
            ..Options::default()
        };
        let refusal = verify(open(&stored(39, false)), &options, &mut |_| true);
        let refused = crate::refused(&refusal.unwrap_err());
        assert!(refused.contains("M002"), "{refused}");
        assert!(refused.contains("--engine symbolic"), "{refused}");
    }
}
