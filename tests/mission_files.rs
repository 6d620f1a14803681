//! `asmotion test` with missions: a composite, actions and faults, and what must hold.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// A copy of the specifications.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs");
    let copied = Command::new("cp")
        .arg("-r")
        .arg(specs)
        .arg(folder.path())
        .status();
    assert!(copied.unwrap().success());
    folder
}

fn asmotion(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.args(arguments).current_dir(folder).env("CI", "");
    command.output().unwrap()
}

/// Exit code and findings of `asmotion test` with these arguments, without the time it took.
fn test(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut all = vec!["test"];
    all.extend(arguments);
    let output = asmotion(folder, &all);
    let text = [output.stdout, output.stderr].concat();
    let text = String::from_utf8(text).unwrap();
    let lines = text.lines().filter(|line| !line.contains("Tested"));
    (output.status.code(), lines.collect::<Vec<_>>().join("\n"))
}

/// A mission below `specs`, changed: each text is replaced by the other.
fn changed(mission: &str, changes: &[(&str, &str)]) -> (tempfile::TempDir, String) {
    let folder = folder();
    let path = format!("specs/{mission}.mission.toml");
    let mut text = std::fs::read_to_string(folder.path().join(&path)).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "`{from}` is not in {path}");
        text = text.replacen(from, to, 1);
    }
    std::fs::write(folder.path().join(&path), text).unwrap();
    (folder, path)
}

/// Tests a changed mission.
fn test_changed(mission: &str, changes: &[(&str, &str)]) -> (Option<i32>, String) {
    let (folder, path) = changed(mission, changes);
    test(folder.path(), &[&path])
}

#[test]
fn every_mission_of_the_specifications_passes() {
    let folder = folder();
    let (code, out) = test(folder.path(), &["specs", "--filter", ".mission.toml"]);
    assert_eq!(code, Some(0), "{out}");
    assert_eq!(out.matches("     pass ").count(), 10, "{out}");
}

#[test]
fn an_expectation_that_does_not_hold_shows_when_and_the_values() {
    let strict = [("within_s = 0.6", "within_s = 0.05")];
    let (code, out) = test_changed("navigation/estop", &strict);
    assert_eq!(code, Some(1));
    insta::assert_snapshot!(out);
}

#[test]
fn a_mission_without_its_end_says_what_the_coordinator_waits_for() {
    let (code, out) = test_changed(
        "navigation/planner_dies",
        &[(
            "limit_s   = 40",
            "limit_s   = 40\nend = \"ASMCoordinator.mode = ARRIVED\"\n",
        )],
    );
    assert_eq!(code, Some(1));
    assert!(out.contains("the mission did not end in 40 s"), "{out}");
    assert!(out.contains("ASMCoordinator in mode = FAILED"), "{out}");
}

#[test]
fn names_that_the_composite_does_not_have_are_reported_with_their_place() {
    let condition = "distance(World.truth, [26.4, 4.2]) < 0.2 and ASMCoordinator.mode = ARRIVED";
    let wrong = [
        ("distance(Wurld.truth, [0, 0]) < 1", "did you mean `World`?"),
        (
            "distance(World.trooth, [0, 0]) < 1",
            "did you mean `truth`?",
        ),
        ("distance(LaserDriver.scan, [0, 0]) < 1", "has no position"),
        ("ASMCoordinator.moode = ARRIVED", "did you mean `mode`?"),
        ("ASMCoordinator.mode = ARIVED", "did you mean `ARRIVED`?"),
        ("ASMCoordinator.mode < ARRIVED", "has no order"),
        ("topic:evnt.code = BLOCKED", "did you mean `event`?"),
        ("topic:event.cod = BLOCKED", "did you mean `code`?"),
        ("topic:event = BLOCKED", "has several fields; name one"),
        ("topic:event.code = 3", "is a text, and `3` is a number"),
        (
            "RoverDriver.twist.linear.x > 1",
            "observe the output that writes it: `CollisionMonitor.twist`",
        ),
        ("state(World) = Runing", "did you mean `Running`?"),
        ("speed(World.truth)", "is a number: compare it with one"),
        ("ASMCoordinator", "is a component"),
        (
            "ASMCoordinator.mode = ",
            "expected a value, found the end of the condition",
        ),
        (
            "ASMCoordinator.mode = ARRIVED andd",
            "expected `and`, `or` or the end",
        ),
        ("(ASMCoordinator.mode = ARRIVED", "expected `)`"),
    ];
    let folder = folder();
    let path = folder.path().join("specs/navigation/goal.mission.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    for (written, expected) in wrong {
        std::fs::write(&path, text.replacen(condition, written, 1)).unwrap();
        let (code, out) = test(folder.path(), &["specs/navigation/goal.mission.toml"]);
        assert_eq!(code, Some(2), "{written}: {out}");
        assert!(
            out.contains(expected) && out.contains("V032"),
            "{written}: {out}"
        );
        assert!(out.contains("goal.mission.toml:1"), "{written}: {out}");
        let checked = asmotion(
            folder.path(),
            &["check", "specs/navigation/goal.mission.toml"],
        );
        let checked = String::from_utf8(checked.stderr).unwrap();
        assert!(checked.contains(expected), "{written}: {checked}");
    }
}

/// A coordinator whose fourth step fails and publishes the reason, and its mission with these expectations.
fn test_problem(expectations: &str) -> (Option<i32>, String) {
    let folder = tempfile::tempdir().unwrap();
    let specification = "\
asm grasp
import StandardLibrary
signature:
  enum domain Mode = {CLOSING | FAILED}
  out problem: String
  controlled mode: Mode
  controlled tries: Integer
definitions:
  main rule r_Main =
    if mode = CLOSING then
      if tries < 3 then
        tries := tries + 1
      else
        par
          mode := FAILED
          problem := \"not held\"
        endpar
      endif
    endif
default init s0:
  function mode = CLOSING
  function tries = 0
";
    let composite = r#"
schema = "composite/1"
[composite]
name = "grasp"
[components.Coordinator]
implementation = { asm = "grasp.asm" }
task = { period_ms = 20 }
publish = { problem = "std_msgs/String" }
[components.Coordinator.bind.out]
problem = { topic = "problem", publish = "on_change" }
"#;
    let mission = format!(
        "schema = \"mission/1\"\ncomposite = \"grasp.composite.toml\"\n\
         end = \"Coordinator.mode = FAILED\"\n{expectations}"
    );
    for (name, text) in [
        ("grasp.asm", specification),
        ("grasp.composite.toml", composite),
        ("grasp.mission.toml", &mission),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    test(folder.path(), &["grasp.mission.toml"])
}

#[test]
fn the_step_that_ends_a_mission_counts_with_its_messages() {
    let (code, out) = test_problem(
        "[[expect]]\neventually = 'topic:problem.data = \"not held\"'\n\
         [[expect]]\neventually = 'Coordinator.mode = FAILED and topic:problem.data != \"lost\"'",
    );
    assert_eq!(code, Some(0), "{out}");
    let (code, out) = test_problem("[[expect]]\nnever = 'topic:problem.data = \"not held\"'");
    assert_eq!(code, Some(1), "{out}");
    assert!(out.contains("V033") && out.contains("0.06 s"), "{out}");
}

#[test]
fn a_location_is_compared_with_a_text_in_quotes() {
    let (code, out) = test_problem(
        "[[expect]]\neventually = 'Coordinator.problem = \"not held\"'\n\
         [[expect]]\nalways = 'Coordinator.problem != \"lost\"'",
    );
    assert_eq!(code, Some(0), "{out}");
    let (code, out) = test_problem("[[expect]]\nnever = 'Coordinator.problem = \"not held\"'");
    assert_eq!(code, Some(1), "{out}");
    assert!(out.contains("Coordinator.problem = not held"), "{out}");
    let (code, out) = test_problem("[[expect]]\neventually = 'Coordinator.mode = \"FALLEN\"'");
    assert_eq!(code, Some(2), "{out}");
    assert!(out.contains("`FALLEN` is not a value of `mode`"), "{out}");
}

#[test]
fn an_unknown_key_is_an_error_with_a_suggestion() {
    let (code, out) = test_changed("navigation/estop", &[("within_s = 0.6", "wihtin_s = 0.6")]);
    assert_eq!(code, Some(2), "{out}");
    assert!(out.contains("C003") && out.contains("within_s"), "{out}");
}

#[test]
fn an_action_has_one_trigger() {
    let both = [("delay_s = 8", "time_s = 8")];
    let (code, out) = test_changed("navigation/estop", &both);
    assert_eq!(code, Some(2), "{out}");
    assert!(out.contains("an action has one trigger"), "{out}");
    let none = [(
        "when = \"ASMCoordinator.mode = FOLLOWING\"\nfail = ",
        "fail = ",
    )];
    let (code, out) = test_changed("navigation/planner_dies", &none);
    assert_eq!(code, Some(2), "{out}");
    assert!(out.contains("missing key `time_s`"), "{out}");
}

#[test]
fn an_expectation_that_never_begins_fails() {
    let never = [(
        "after    = \"topic:estop.data\"",
        "after    = \"ASMCoordinator.mode = FAILED\"",
    )];
    let (code, out) = test_changed("navigation/estop", &never);
    assert_eq!(code, Some(1), "{out}");
    assert!(
        out.contains("never checked, because it never began"),
        "{out}"
    );
}

#[test]
fn an_action_that_does_not_happen_or_is_refused_fails() {
    let late = [("time_s = 15", "time_s = 50")];
    let (code, out) = test_changed("navigation/planner_dies", &late);
    assert_eq!(code, Some(1), "{out}");
    assert!(
        out.contains("the mission ended at 40 s, before 50 s"),
        "{out}"
    );
    let (code, out) = test_changed(
        "navigation/planner_dies",
        &[(
            "fail = \"TrajectoryPlanner\"",
            "start = \"TrajectoryPlanner\"",
        )],
    );
    assert_eq!(code, Some(1), "{out}");
    assert!(out.contains("V034"), "{out}");
    let (code, out) = test_changed(
        "navigation/planner_dies",
        &[(
            "value  = { header = { frame_id = \"map\" }",
            "value  = { heeder = { frame_id = \"map\" }",
        )],
    );
    assert_eq!(code, Some(2), "{out}");
    assert!(out.contains("does not take this message"), "{out}");
}

#[test]
fn a_component_that_fails_unexpectedly_fails_the_mission() {
    let bad_map = [(
        "limit_s   = 40",
        "limit_s   = 5\n[components.World]\nproperties = { walls = [1.0] }\n",
    )];
    let (code, out) = test_changed("navigation/planner_dies", &bad_map);
    assert_eq!(code, Some(1), "{out}");
    assert!(
        out.contains("`World` failed") && out.contains("may_fail = [\"World\"]"),
        "{out}"
    );
}

#[test]
fn a_snapshot_is_accepted_compared_and_replayed_with_the_specification_alone() {
    let folder = folder();
    let mission = "specs/navigation/estop.mission.toml";
    let snapshot = folder.path().join("specs/navigation/estop.mission.snap");
    let accepted = std::fs::read_to_string(&snapshot).unwrap();
    std::fs::remove_file(&snapshot).unwrap();
    let (code, out) = test(folder.path(), &[mission]);
    assert_eq!(code, Some(1), "{out}");
    assert!(out.contains("V030"), "{out}");
    let (code, _) = test(folder.path(), &[mission, "--accept"]);
    assert_eq!(code, Some(0));
    assert_eq!(std::fs::read_to_string(&snapshot).unwrap(), accepted);
    let replay = [
        "sim",
        "specs/navigation/navigate.asm",
        "--replay-inputs",
        "specs/navigation/estop.mission.snap",
    ];
    let replayed = asmotion(folder.path(), &replay);
    assert_eq!(replayed.status.code(), Some(0));
    let replayed = String::from_utf8(replayed.stdout).unwrap();
    assert!(replayed.contains("mode = ARRIVED"), "{replayed}");
    // another run differs
    let path = folder.path().join(mission);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replacen("delay_s = 8", "delay_s = 7", 1)).unwrap();
    let (code, out) = test(folder.path(), &[mission]);
    assert_eq!(code, Some(1), "{out}");
    assert!(out.contains("V031"), "{out}");
}

#[test]
fn a_mission_is_an_object_of_the_json_output() {
    let (folder, path) = changed("navigation/estop", &[("within_s = 0.6", "within_s = 0.05")]);
    let output = asmotion(folder.path(), &["test", "--json", &path]);
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(result["verdict"], "fail");
    assert_eq!(result["checks"], 3);
    // the key `doc`
    assert_eq!(
        result["name"],
        "the e-stop stops the rover, and a new goal lets it go on"
    );
    assert_eq!(result["findings"][0]["code"], "V033");
    assert_eq!(result["findings"][0]["at"]["path"], *path);
}

#[test]
fn a_composite_names_its_missions() {
    let folder = folder();
    let (code, out) = test(folder.path(), &["specs/youbot/youbot.composite.toml"]);
    assert_eq!(code, Some(0), "{out}");
    assert_eq!(out.matches(".mission.toml").count(), 2, "{out}");
    let (code, out) = test(folder.path(), &["specs/courier/courier.composite.toml"]);
    assert_eq!(code, Some(2), "{out}");
    assert!(out.contains("no mission"), "{out}");
}

/// A change of a mission for each key, and a part of the output that shows its effect.
const KEYS: [(&str, &str, &str, &str, &str); 24] = [
    (
        "schema",
        "navigation/estop",
        "mission/1",
        "mission/2",
        "C008",
    ),
    (
        "composite",
        "navigation/estop",
        "\"navigation.composite.toml\"",
        "\"web.toml\"",
        "web.toml",
    ),
    (
        "expect.doc",
        "navigation/estop",
        "doc      = \"e-stop: stands",
        "doc      = \"e-stop: rests",
        "V033]: e-stop: rests",
    ),
    (
        "profile",
        "navigation/estop",
        "limit_s   = 90",
        "profile = \"sim\"",
        "no profiles",
    ),
    (
        "seed",
        "allocation/fleet",
        "limit_s   = 20",
        "limit_s = 20\nseed = 9",
        "V031",
    ),
    (
        "properties",
        "navigation/estop",
        "limit_s   = 90",
        "properties = { plaace = \"office\" }",
        "plaace",
    ),
    (
        "components.*.properties",
        "navigation/goal",
        "disc = [19.0, 7.45, 0.25]",
        "desc = 1",
        "desc",
    ),
    (
        "end",
        "navigation/estop",
        "end       = \"ASMCoordinator.mode = ARRIVED\"",
        "end = \"ASMCoordinator.mode = FAILED\"",
        "V035",
    ),
    (
        "limit_s",
        "navigation/estop",
        "limit_s   = 90",
        "limit_s   = 9",
        "did not end in 9 s",
    ),
    (
        "may_fail",
        "navigation/planner_dies",
        "limit_s   = 40",
        "limit_s = 5\nmay_fail = [\"Wurld\"]",
        "did you mean `World`?",
    ),
    (
        "snapshot",
        "navigation/closed_corridor",
        "limit_s   = 180",
        "limit_s = 180\nsnapshot = true",
        "V030",
    ),
    (
        "at.time_s",
        "navigation/planner_dies",
        "time_s = 15",
        "time_s = 41",
        "V034",
    ),
    (
        "at.when",
        "navigation/planner_dies",
        "when = \"ASMCoordinator.mode = FOLLOWING\"",
        "when = \"ASMCoordinator.tries = 3\"",
        "its condition did not become true",
    ),
    (
        "at.delay_s",
        "navigation/estop",
        "delay_s = 8",
        "delay_s = 80",
        "V034",
    ),
    (
        "at.write",
        "navigation/planner_dies",
        "write  = \"topic:goal\"",
        "write  = \"topic:gaol\"",
        "did you mean `goal`?",
    ),
    (
        "at.value",
        "navigation/estop",
        "value   = { data = true }",
        "value   = { data = 3 }",
        "does not take this message",
    ),
    (
        "at.set",
        "navigation/planner_dies",
        "fail = \"TrajectoryPlanner\"",
        "set = \"TrajectoryFollower\"\nproperties = { nothing = 1 }",
        "nothing",
    ),
    (
        "at.properties",
        "navigation/planner_dies",
        "fail = \"TrajectoryPlanner\"",
        "set = \"TrajectoryFollower\"\nproperties = { deceleration = \"no\" }",
        "deceleration",
    ),
    (
        "at.stop",
        "youbot/link_lost",
        "stop    = \"Driver/youBotDriver\"",
        "stop    = \"Kinematics\"",
        "never began",
    ),
    (
        "at.start",
        "youbot/link_lost",
        "start   = \"Driver/youBotDriver\"",
        "start   = \"Kinematics\"",
        "V034",
    ),
    (
        "at.fail",
        "navigation/planner_dies",
        "fail = \"TrajectoryPlanner\"",
        "fail = \"LaserDriver\"",
        "V033",
    ),
    (
        "expect.after",
        "navigation/estop",
        "after      = \"not topic:estop.data\"\nwithin_s   = 5",
        "within_s = 0.1",
        "not true by 0.1 s",
    ),
    (
        "expect.until",
        "navigation/estop",
        "until    = \"not topic:estop.data\"\nwithin_s = 0.6",
        "within_s = 0.6",
        "V033",
    ),
    (
        "expect.within_s",
        "navigation/estop",
        "within_s = 0.6",
        "within_s = 0.05",
        "V033",
    ),
];

/// Keys that the shipped missions need in order to pass, which the other tests change.
const REQUIREMENTS: [&str; 3] = ["expect.always", "expect.eventually", "expect.never"];

#[test]
fn every_key_of_missions_has_an_effect() {
    for (key, mission, from, to, effect) in KEYS {
        let also = match key {
            "expect.doc" => &[("within_s = 0.6", "within_s = 0.05")][..],
            _ => &[],
        };
        let changes = [&[(from, to)][..], also].concat();
        let (_, out) = test_changed(mission, &changes);
        assert!(out.contains(effect), "{key}: {out}");
    }
}

#[test]
fn every_key_of_the_schema_of_missions_is_observed() {
    let output = asmotion(Path::new("."), &["schema", "--missions"]);
    let schema: Value = serde_json::from_slice(&output.stdout).unwrap();
    let keys = |node: &Value, prefix: &str| -> Vec<String> {
        let keys = node["properties"].as_object().unwrap().keys();
        keys.map(|key| format!("{prefix}{key}")).collect()
    };
    let mut all = keys(&schema, "");
    all.retain(|key| !["at", "expect", "components"].contains(&&**key));
    for list in ["at", "expect"] {
        all.extend(keys(
            &schema["properties"][list]["items"],
            &format!("{list}."),
        ));
    }
    let components = &schema["properties"]["components"]["additionalProperties"];
    all.extend(keys(components, "components.*."));
    let observed = KEYS.iter().map(|(key, ..)| *key).chain(REQUIREMENTS);
    let mut observed: Vec<String> = observed.map(str::to_owned).collect();
    observed.push("doc".to_owned());
    all.sort();
    observed.sort();
    assert_eq!(all, observed);
}

/// `specs/navigation` with a broker whose address is `url`, and a map server of this composite or, in the profile `depot`, of
/// another robot; and the mission `goal` with it.
fn with_broker(url: &str, profile: &str) -> (tempfile::TempDir, &'static str) {
    let folder = folder();
    let navigation = folder.path().join("specs/navigation");
    let read = |name: &str| std::fs::read_to_string(navigation.join(name)).unwrap();
    let composite = read("navigation.composite.toml");
    let wire = "reference  = \"ASMCoordinator.maps\"\nservice    = \"MapServer.maps\"\n";
    let other = format!(
        "profile = \"alone\"\n{wire}timeout_ms = 3000\n\n[[wires]]\nprofile = \"depot\"\nreference = \"ASMCoordinator.maps\"\n\
         binding = \"amqp\"\nurl = \"robot://depot/MapServer.maps\"\n"
    );
    assert_eq!(composite.matches(wire).count(), 1);
    let composite = composite.replace(wire, &other);
    let operator = |profile: &str| {
        format!(
            "[components.Operator_{profile}]\nimplementation = {{ rust = \"nav::Operator\" }}\nprofile = \"{profile}\"\n\
             activity = {{ period_ms = 100 }}\n"
        )
    };
    let operators = ["alone", "depot"].map(operator).concat();
    let composite = composite.replace(
        "components = [\"Operator\",",
        "components = [\"Operator\", \"Operator_alone\", \"Operator_depot\",",
    );
    let broker = format!("\n{operators}\n[brokers.cell]\nurl = \"{url}\"\n");
    std::fs::write(navigation.join("depot.composite.toml"), composite + &broker).unwrap();
    let goal =
        read("goal.mission.toml").replace("navigation.composite.toml", "depot.composite.toml");
    let goal = format!("profile = \"{profile}\"\n{goal}");
    std::fs::write(navigation.join("depot.mission.toml"), goal).unwrap();
    (folder, "specs/navigation/depot.mission.toml")
}

#[test]
fn a_mission_selects_a_profile_and_needs_no_broker_of_its_composite() {
    // nothing listens there
    let (folder, mission) = with_broker("amqp://rover@127.0.0.1:1/cell", "alone");
    let (code, out) = test(folder.path(), &[mission]);
    assert_eq!(code, Some(0), "{out}");
    assert!(out.contains("     pass "), "{out}");
}

#[test]
fn a_mission_that_leads_outside_says_why_not_and_what_to_do() {
    let (folder, mission) = with_broker("amqp://rover@127.0.0.1:1/cell", "depot");
    let reason = "error[V036]: `robot://depot/MapServer.maps` is a service of another robot, which is called over a broker; a \
                  mission runs in virtual time and without brokers";
    let help = "select another one with `profile` in the mission";
    let (code, out) = test(folder.path(), &[mission]);
    assert_eq!(code, Some(2), "{out}");
    assert!(out.contains(reason) && out.contains(help), "{out}");
    assert!(out.contains("depot.mission.toml:"), "at its place: {out}");
    assert!(!out.contains("--bus"), "{out}");
    // before it is run
    let checked = asmotion(folder.path(), &["check", mission]);
    let said = String::from_utf8(checked.stderr).unwrap();
    assert_eq!(checked.status.code(), Some(1), "{said}");
    assert!(said.contains(reason) && said.contains(help), "{said}");
}

#[test]
fn a_mission_whose_broker_uses_an_unset_variable_says_that_any_value_will_do() {
    let (folder, mission) = with_broker("amqp://${NO_SUCH_USER}@127.0.0.1:1/cell", "alone");
    let (code, out) = test(folder.path(), &[mission]);
    assert_eq!(code, Some(2), "{out}");
    assert!(out.contains("not set: NO_SUCH_USER"), "{out}");
    assert!(out.contains("any value will do"), "{out}");
}
