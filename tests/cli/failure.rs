//! Runs in which a component fails, or a demand of the composite cannot be met.

use super::run;
use std::path::Path;

/// Counts its steps.
const COUNTS: &str = "asm counts
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = n := n + 1
default init s0:
  function n = 0
";

/// Fails in its third step, because nothing writes `input`.
const FAILS: &str = "asm fails
import StandardLibrary
signature:
  controlled k: Integer
  monitored input: Boolean
definitions:
  main rule r_Main = par k := k + 1 if k > 1 then if input then skip endif endif endpar
default init s0:
  function k = 0
";

/// Has a false property.
const PROMISES: &str = "asm promises
import StandardLibrary
import CTLLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = n := n + 1
  CTLSPEC ag(n = 0)
  CTLSPEC ag(n = 1)
  CTLSPEC ef(n = 3)
default init s0:
  function n = 0
";

/// Its property holds only as long as a constraint does, which the first step leaves.
const CONSTRAINED: &str = "asm constrained
import StandardLibrary
import CTLLibrary
signature:
  controlled n: Integer
definitions:
  INVAR n = 0
  CTLSPEC ag(n = 0)
  main rule r_Main = n := n + 1
default init s0:
  function n = 0
";

const HEAD: &str = "schema = \"composite/1\"\n[composite]\nname = \"test\"\n";

fn component(name: &str, rest: &str) -> String {
    format!("[components.{name}]\nactivity = {{ period_ms = 100 }}\n{rest}\n")
}

/// Runs a composite of these components; returns the exit code and both outputs.
fn run_composite(components: &[String], arguments: &[&str]) -> (i32, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    for (name, text) in [
        ("counts", COUNTS),
        ("fails", FAILS),
        ("promises", PROMISES),
        ("constrained", CONSTRAINED),
        ("expects", EXPECTS),
    ] {
        write(&format!("{name}.asm"), text);
    }
    write("hall.geojson", "{");
    write(
        "test.composite.toml",
        &(HEAD.to_owned() + &components.concat()),
    );
    let path = |path: &Path| path.to_str().unwrap().to_owned();
    let composite = path(&folder.path().join("test.composite.toml"));
    run(&[&["run", &composite], arguments].concat())
}

const UNTIL: [&str; 4] = ["--until", "n=20", "--for", "5"];

fn counter() -> String {
    component("Counter", "implementation = { asm = \"counts.asm\" }")
}

/// A map server that fails in its first cycle, since its map cannot be read.
fn failing_server(lifecycle: &str) -> String {
    let rest = format!(
        "implementation = {{ rust = \"nav::MapServer\" }}
services = {{ maps = \"nav/MapService\" }}
properties = {{ source = \".\", place = \"hall\" }}\n{lifecycle}"
    );
    component("Maps", &rest)
}

#[test]
fn a_component_that_fails_is_isolated_and_named_at_the_end() {
    let components = [failing_server(""), counter()];
    let (code, out, err) = run_composite(&components, &UNTIL);
    assert_eq!(code, 0, "{out}{err}");
    assert!(out.starts_with("reached"), "{out}");
    assert!(out.contains("Maps: not running at the end"), "{out}");
    let (code, out, _) = run_composite(&components, &["--until", "n=0", "--for", "5"]);
    assert_eq!(code, 3, "the limit is reached with a dead component: {out}");
}

#[test]
fn a_component_that_fails_is_reset_as_often_as_the_composite_says() {
    let lifecycle = "lifecycle = { on_exception = \"reset\", max_resets = 4 }";
    let (code, out, err) = run_composite(&[failing_server(lifecycle), counter()], &UNTIL);
    assert_eq!(code, 0, "{out}{err}");
    assert_eq!(err.matches("fault of Maps").count(), 5, "{err}");
    let specification = format!("implementation = {{ asm = \"fails.asm\" }}\n{lifecycle}");
    let components = [component("Failing", &specification), counter()];
    let (code, out, err) = run_composite(&components, &UNTIL);
    assert_eq!(
        code, 3,
        "a specification that is dead for good ends the run: {out}{err}"
    );
    // each time it begins in its initial state a period later, and fails in its third step
    let faults = err.lines().filter(|line| line.contains("fault of Failing"));
    let times: Vec<&str> = faults
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert_eq!(times, ["0.20", "0.50", "0.80", "1.10", "1.40"], "{err}");
}

#[test]
fn a_failure_that_escalates_ends_the_run() {
    let lifecycle = "lifecycle = { on_exception = \"escalate\" }";
    let (code, out, err) = run_composite(&[failing_server(lifecycle), counter()], &UNTIL);
    assert_eq!(code, 3, "{out}{err}");
    assert!(out.starts_with("fault"), "{out}");
}

#[test]
fn a_component_that_cannot_be_configured_ends_the_run_at_once() {
    let rest = "implementation = { rust = \"nav::MapServer\" }
services = { maps = \"nav/MapService\" }
properties = { source = \"\" }";
    let (code, out, err) = run_composite(&[component("Maps", rest), counter()], &UNTIL);
    assert_eq!(code, 3, "{out}{err}");
}

#[test]
fn properties_that_are_neither_verified_nor_watched_are_said_before_the_start() {
    let guarded = |verify: &str| {
        let rest = format!("implementation = {{ asm = \"promises.asm\" }}\n{verify}");
        run_composite(&[component("Guard", &rest)], &UNTIL)
    };
    let (code, out, err) = guarded("");
    assert_eq!(code, 0, "{out}{err}");
    let warning = err.find("C201").expect("the warning");
    assert!(
        err.contains("1 temporal property, which a run cannot watch"),
        "{err}"
    );
    // the others are watched
    assert!(err.contains("step 1 violates CTLSPEC `ag(n = 0)`"), "{err}");
    assert!(
        err.find("n: 0 → 1").is_none_or(|step| warning < step),
        "{err}"
    );
    // the specification states both kinds: a CTL property that does not hold, and one of LTL
    let (code, out, err) = guarded("verify = { ctl = true, ltl = true, bound = 5 }");
    assert_eq!(code, 0, "{out}{err}");
    assert!(err.contains("of `Guard` is violated"), "{err}");
    assert!(!err.contains("C201"), "{err}");
    let (code, out, err) =
        guarded("verify = { ctl = true, bound = 5, refuse_start_on_failure = true }");
    assert_eq!(code, 1, "{out}{err}");
    assert!(
        err.contains("does not start") && err.contains("step 1") && !out.contains("reached"),
        "{out}{err}"
    );
    let (code, out, err) =
        guarded("verify = { invariants = true, refuse_start_on_failure = true, bound = 1 }");
    assert_eq!(code, 1, "{out}{err}");
    assert!(err.contains("does not start"), "{err}");
}

#[test]
fn a_constraint_that_the_specification_leaves_makes_nothing_true_of_a_run() {
    let rest = "implementation = { asm = \"constrained.asm\" }
verify = { ctl = true, bound = 5, refuse_start_on_failure = true }";
    let (code, out, err) = run_composite(&[component("Guard", rest)], &UNTIL);
    assert_eq!(code, 1, "{out}{err}");
    assert!(
        err.contains("does not start") && err.contains("`n = 0` of `Guard` is violated"),
        "{out}{err}"
    );
}

/// Expects a pair where the driver sends lists.
const EXPECTS: &str = "asm expects
import StandardLibrary
signature:
  domain Flags subsetof Integer
  monitored status: Seq(Flags)
  controlled n: Integer
definitions:
  domain Flags = {1024 : 2048}
  main rule r_Main = par n := n + 1 if isDef(status) then n := 0 endif endpar
default init s0:
  function n = 0
";

#[test]
fn what_a_run_drops_is_in_its_json() {
    let driver = component(
        "Driver",
        "implementation = { rust = \"youbot::DummyDriver\" }
ports.out = { jointStatus = \"youbot/JointStatus\" }",
    );
    let reader = component(
        "Reader",
        "implementation = { asm = \"expects.asm\" }
ports.in = { st = \"youbot/JointStatus\" }
bind.monitored = { status = { topic = \"st\", field = \"error_flags\" } }
[[connections]]
from = \"Driver.jointStatus\"
to = \"Reader.st\"",
    );
    let (_, out, err) = run_composite(&[driver, reader], &["--for", "1", "--json"]);
    let mut losses = out.lines().filter(|line| line.contains("\"losses\""));
    let last: serde_json::Value = serde_json::from_str(losses.next_back().expect(&err)).unwrap();
    assert_eq!(
        (&last["component"], &last["dropped"]),
        (&"Reader".into(), &0.into())
    );
    assert!(last["misfits"].as_u64() > Some(5), "{out}");
}

#[test]
fn a_promotion_over_a_transport_that_is_not_in_the_build_does_not_start() {
    let promotion = "[[promote]]\nservice = \"Maps.maps\"\nas = \"maps\"\nbinding = \"ros\"\n";
    let maps = component(
        "Maps",
        "implementation = { rust = \"nav::MapServer\" }
services = { maps = \"nav/MapService\" }
properties = { source = \".\", place = \"hall\" }",
    );
    let (code, out, err) = run_composite(&[maps, promotion.to_owned()], &["--for", "1"]);
    assert_eq!(code, 2, "{out}{err}");
    let refused = "the promotion `maps` uses `ros`, which is not in this build";
    assert!(err.contains(refused), "{err}");
}
