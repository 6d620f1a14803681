//! Environments: any value, values that are kept, scripts, and specifications.

use crate::{open, refused, verdict_of, verified_system};
use asmotion_lang::diagnostics::FileId;
use asmotion_lang::simulate::Script;
use asmotion_verify::{
    EnvironmentModel, Options, SystemSpecification, Verdict, Verification, verify_system,
};

/// A door that opens on request, unless it is locked.
const DOOR: &str = "asm door
import StandardLibrary
import CTLLibrary
signature:
  monitored request: Boolean
  monitored locked: Boolean
  controlled isOpen: Boolean
definitions:
  CTLSPEC locksHold: ag(locked implies ax(not isOpen))
  CTLSPEC opens: ef(isOpen)
  invariant never over isOpen: not isOpen
  main rule r_Main = isOpen := request and not locked
default init s0:
  function isOpen = false
";

fn in_environment(environment: &str) -> Verification {
    let environment = EnvironmentModel::Specification(Box::new(open(environment)));
    let system = SystemSpecification::of(open(DOOR)).with_environment(environment);
    verified_system(system, &Options::default())
}

fn refusal(environment: &str) -> String {
    let environment = EnvironmentModel::Specification(Box::new(open(environment)));
    let system = SystemSpecification::of(open(DOOR)).with_environment(environment);
    let refusal = verify_system(system, &Options::default(), &mut |_| true).unwrap_err();
    refused(&refusal)
}

#[test]
fn an_environment_provides_inputs_in_the_same_step() {
    // requests only while the door is locked
    let verification = in_environment(
        "asm visitor
import StandardLibrary
signature:
  monitored isOpen: Boolean
  out request: Boolean
  out locked: Boolean
definitions:
  main rule r_Main = choose $wants in Boolean with true do par request := $wants locked := $wants endpar
default init s0:
  function request = false
  function locked = false
",
    );
    assert_eq!(verdict_of(&verification, "locksHold"), "holds");
    assert_eq!(verdict_of(&verification, "opens"), "violated");
    assert_eq!(verdict_of(&verification, "never"), "holds");
    // the environment has made its first step in each initial state
    assert_eq!(verification.states, 2);
    assert!(verification.assumptions.is_empty());
}

#[test]
fn an_environment_reads_the_system_and_what_it_does_not_provide_is_free() {
    // requests once, when the door is closed
    let verification = in_environment(
        "asm visitor
import StandardLibrary
signature:
  monitored isOpen: Boolean
  out request: Boolean
  controlled hasEntered: Boolean
definitions:
  main rule r_Main = if isOpen then par request := false hasEntered := true endpar else request := not hasEntered endif
default init s0:
  function request = false
  function hasEntered = false
",
    );
    assert_eq!(verification.assumptions, ["any value of door.locked"]);
    assert_eq!(verdict_of(&verification, "opens"), "holds");
    let never = verification.properties.iter();
    let never = never.filter(|it| it.name.as_deref() == Some("never"));
    let never: Vec<_> = never.collect();
    let Verdict::Violated(Some(run)) = &never[0].verdict else {
        panic!("{:?}", never[0].verdict);
    };
    let steps = run.steps.iter();
    let steps: Vec<(usize, usize)> = steps.map(|it| (it.transition, it.machine)).collect();
    // the environment, the door, and the environment's step before the next one
    assert_eq!(steps, [(1, 1), (1, 0), (2, 1)]);
    assert_eq!(run.traces.len(), 2);
}

#[test]
fn an_environment_that_does_not_fit_is_refused() {
    let misspelt = refusal(
        "asm visitor
import StandardLibrary
signature:
  out requests: Boolean
definitions:
  main rule r_Main = requests := true
",
    );
    assert!(
        misspelt.contains("M009") && misspelt.contains("`request`"),
        "{misspelt}"
    );
    let blind = refusal(
        "asm visitor
import StandardLibrary
signature:
  monitored hour: Integer
  out request: Boolean
definitions:
  main rule r_Main = request := hour = 3
",
    );
    assert!(
        blind.contains("M010") && blind.contains("`hour`"),
        "{blind}"
    );
    let other = refusal(
        "asm visitor
import StandardLibrary
signature:
  out request: Integer
definitions:
  main rule r_Main = request := 1
",
    );
    assert!(
        other.contains("M008") && other.contains("Integer"),
        "{other}"
    );
}

#[test]
fn literals_of_an_environment_correspond_by_name() {
    let light = "asm light
import StandardLibrary
signature:
  enum domain Colour = {GREEN | YELLOW | RED}
  monitored colour: Colour
  controlled stands: Boolean
definitions:
  invariant inv over stands: not stands
  main rule r_Main = stands := colour = RED
default init s0:
  function stands = false
";
    let sequence = |last: &str| {
        format!(
            "asm lamp
import StandardLibrary
signature:
  enum domain Shown = {{RED | GREEN | YELLOW}}
  out colour: Shown
definitions:
  main rule r_Main = colour := if colour = GREEN then YELLOW else {last} endif
default init s0:
  function colour = GREEN
"
        )
    };
    for (last, verdict) in [("RED", "violated"), ("GREEN", "holds")] {
        let environment = EnvironmentModel::Specification(Box::new(open(&sequence(last))));
        let system = SystemSpecification::of(open(light)).with_environment(environment);
        let verification = verified_system(system, &Options::default());
        assert_eq!(verdict_of(&verification, "inv"), verdict);
    }
}

#[test]
fn a_script_gives_the_inputs_of_each_step_and_ends_the_runs() {
    let verification = |script: &str| {
        let door = open(DOOR);
        let script = Script::read(FileId::default(), script, &door.program).unwrap();
        let system =
            SystemSpecification::of(door).with_environment(EnvironmentModel::Script(script));
        verified_system(system, &Options::default())
    };
    let opens = verification(
        "[default]\nlocked = false\nrequest = false\n[[step]]\n[[step]]\nrequest = true\n[[step]]\n",
    );
    assert_eq!(verdict_of(&opens, "never"), "violated");
    assert_eq!(verdict_of(&opens, "no state is stuck"), "holds");
    assert_eq!(opens.states, 4);
    let locked = verification(
        "[default]\nlocked = true\n[[step]]\nrequest = true\n[[step]]\nrequest = true\n",
    );
    assert_eq!(verdict_of(&locked, "never"), "holds");
    assert_eq!(verdict_of(&locked, "locksHold"), "holds");
}

#[test]
fn held_inputs_change_one_at_a_time() {
    let both = "asm both
import StandardLibrary
import CTLLibrary
signature:
  monitored left: Boolean
  monitored right: Boolean
  controlled last: Boolean
definitions:
  CTLSPEC jump: ag((not left and not right) implies ax(not (left and right)))
  CTLSPEC kept: ag(last implies ex(last))
  main rule r_Main = if left or right then last := left else last := false endif
default init s0:
  function last = false
";
    let verdict = |changes| {
        let environment = EnvironmentModel::Hold { changes };
        let system = SystemSpecification::of(open(both)).with_environment(environment);
        let verification = verified_system(system, &Options::default());
        (
            verdict_of(&verification, "jump"),
            verdict_of(&verification, "kept"),
        )
    };
    assert_eq!(verdict(0).0, "holds");
    assert_eq!(verdict(1).0, "holds");
    assert_eq!(verdict(2).0, "violated");
}

#[test]
fn a_system_is_stuck_although_its_environment_goes_on() {
    let latch = "asm latch
import StandardLibrary
signature:
  monitored signal: Boolean
  controlled isSet: Boolean
definitions:
  main rule r_Main = if signal and not isSet then isSet := true endif
default init s0:
  function isSet = false
";
    let clock = |first: &str| {
        format!(
            "asm clock
import StandardLibrary
signature:
  out signal: Boolean
  controlled tick: Boolean
definitions:
  main rule r_Main = par tick := not tick signal := {first} endpar
default init s0:
  function tick = false
  function signal = false
"
        )
    };
    let stuck = |environment: EnvironmentModel, end: Option<&str>| {
        let system = SystemSpecification::of(open(latch)).with_environment(environment);
        let options = Options {
            ends: end.map(ToOwned::to_owned),
            ..Options::default()
        };
        let verification = verified_system(system, &options);
        let stuck = verification.properties.iter();
        let mut stuck = stuck.filter(|it| it.text == "no state is stuck");
        let run = stuck.next().unwrap().verdict.clone();
        match run {
            Verdict::Violated(Some(run)) => Some(run.steps.len()),
            Verdict::Holds(_) | Verdict::Violated(None) | Verdict::Unknown => None,
        }
    };
    let specification = |text: &str| EnvironmentModel::Specification(Box::new(open(text)));
    // set in the second step, after which only the clock goes on
    assert_eq!(stuck(specification(&clock("tick")), None), Some(5));
    assert_eq!(stuck(specification(&clock("tick")), Some("isSet")), None);
    // never set
    assert_eq!(stuck(specification(&clock("false")), None), Some(1));
    assert_eq!(stuck(EnvironmentModel::Hold { changes: 1 }, None), Some(1));
    assert_eq!(
        stuck(EnvironmentModel::Hold { changes: 1 }, Some("isSet")),
        None
    );
}
