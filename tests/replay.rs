//! Replays of recordings: every step of every coordinator again, on what was recorded.

mod chaos;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::processes::{
    Running, navigation, over, run_any, three_processes, through, tool, wait_until_present,
};
use crate::recording::{python, recorded};

/// Runs asmotion. Returns the exit code and what it printed.
fn asmotion(arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let output = command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments)
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(text).unwrap())
}

/// Replays recordings. Returns the exit code, and the objects that it printed.
fn replay(arguments: &[&str]) -> (Option<i32>, Vec<Value>) {
    let (code, text) = asmotion(&[&["replay", "--json"], arguments].concat());
    let lines = text.lines().filter(|line| line.starts_with('{'));
    (
        code,
        lines
            .map(|line| serde_json::from_str(line).unwrap())
            .collect(),
    )
}

/// The object about the only coordinator.
#[track_caller]
fn coordinator(objects: &[Value]) -> &Value {
    let mut found = objects.iter().filter(|it| it["type"] == "coordinator");
    let first = found.next().unwrap_or_else(|| panic!("{objects:?}"));
    assert!(found.next().is_none(), "{objects:?}");
    first
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

/// Records the run of a composite in virtual time.
#[track_caller]
fn record(composite: &Path, file: &Path, more: &[&str]) {
    let (composite, file) = (text(composite), text(file));
    let (_, said) = asmotion(&[&["run", &composite, "--record", &file, "-q"], more].concat());
    assert!(said.contains("recording"), "{said}");
}

fn navigation_composite() -> PathBuf {
    navigation().join("navigation.composite.toml")
}

/// The navigation with an edited specification in a folder.
fn edited(folder: &Path, edits: &[(&str, &str)]) -> String {
    let mut text = std::fs::read_to_string(navigation().join("navigate.asm")).unwrap();
    for (from, to) in edits {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let path = folder.join("edited.asm");
    std::fs::write(&path, text).unwrap();
    self::text(&path)
}

/// All composites that run by themselves and have a coordinator, with the number of their coordinators.
const COMPOSITES: [(&str, usize); 6] = [
    ("allocation/allocation", 3),
    ("ball_tracker/ball_tracker", 3),
    ("courier/courier", 2),
    ("navigation/navigation", 1),
    ("navigation/two_rovers", 2),
    ("youbot/youbot", 1),
];

#[test]
fn d3_all_coordinators_of_all_composites_repeat_their_steps() {
    let folder = tempfile::tempdir().unwrap();
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs");
    for (name, coordinators) in COMPOSITES {
        let file = folder
            .path()
            .join(format!("{}.mcap", name.replace('/', "-")));
        record(
            &specs.join(format!("{name}.composite.toml")),
            &file,
            &["--for", "20", "--ports", "goal"],
        );
        let (code, objects) = replay(&[&text(&file)]);
        assert_eq!(code, Some(0), "{objects:?}");
        let found = objects.iter().filter(|it| it["type"] == "coordinator");
        let found: Vec<_> = found.collect();
        assert_eq!(found.len(), coordinators, "{objects:?}");
        for one in found {
            assert_eq!(one["result"], "equal", "{one}");
            assert_eq!(one["complete"], true, "{one}");
            assert!(one["steps"].as_u64().unwrap() >= 200, "{one}");
        }
    }
    // all at once, and as a folder
    let (code, objects) = replay(&[&text(folder.path())]);
    assert_eq!(code, Some(0), "{objects:?}");
    let total = objects.last().unwrap();
    assert_eq!(
        (&total["recordings"], &total["coordinators"]),
        (&6.into(), &12.into()),
        "{total}"
    );
}

#[test]
fn d3_a_run_in_real_time_repeats_up_to_the_last_half_second_before_it_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(navigation_composite());
    command
        .args(["--clock", "wall", "--goal", "3.4,4.7", "--record"])
        .arg(&file);
    let quiet = command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut process = quiet.spawn().unwrap();
    let until = Instant::now() + Duration::from_secs(60);
    let mut state = Value::Null;
    while state["steps"].as_u64().unwrap_or(0) < 30 {
        assert!(Instant::now() < until, "nothing is written: {state}");
        std::thread::sleep(Duration::from_millis(300));
        // a file that is being written can be replayed
        let (_, objects) = replay(&[&text(&file)]);
        state = objects.into_iter().next().unwrap_or_default();
    }
    process.kill().unwrap();
    process.wait().unwrap();
    let (code, objects) = replay(&[&text(&file)]);
    let one = coordinator(&objects);
    assert_eq!((code, &one["result"]), (Some(0), &"equal".into()), "{one}");
    assert_eq!(one["complete"], false, "{one}");
    assert!(
        one["incomplete"]
            .as_str()
            .unwrap()
            .contains("ends before its run"),
        "{one}"
    );
    let (_, said) = asmotion(&["replay", &text(&file)]);
    assert!(said.contains("INCOMPLETE"), "{said}");
}

#[test]
fn d3_both_processes_of_a_run_over_rabbitmq_repeat_their_steps() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = |process: &str| text(&folder.path().join(format!("{process}.mcap")));
    let run = |process: &'static str| {
        let mut command = over(&navigation_composite(), &broker, &vhost, Some(process));
        command.arg("--record").arg(file(process));
        command
    };
    let onboard = Running::start(&mut run("onboard"));
    wait_until_present(&vhost, "onboard");
    let supervisor = run("supervisor").output().unwrap();
    assert!(supervisor.status.success());
    assert!(onboard.interrupt().status.success());
    let (code, objects) = replay(&[&file("onboard"), &file("supervisor")]);
    assert_eq!(code, Some(0), "{objects:?}");
    let one = coordinator(&objects);
    assert_eq!(
        (&one["result"], &one["complete"]),
        (&"equal".into(), &true.into()),
        "{one}"
    );
    assert!(one["steps"].as_u64().unwrap() > 50, "{one}");
    assert_eq!(objects[0]["result"], "skipped", "{objects:?}");
    // alone, the process without coordinator is nothing that could be equal
    let (code, objects) = replay(&[&file("onboard")]);
    assert_eq!(code, Some(2), "{objects:?}");
}

#[test]
fn d3_two_specifications_that_talk_over_rabbitmq_repeat_their_messages() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = navigation()
        .with_file_name("courier")
        .join("courier.composite.toml");
    let processes = ["office", "street"];
    let file = |process: &str| text(&folder.path().join(format!("{process}.mcap")));
    let running = processes.map(|process| {
        let mut command = through(run_any(&composite), &broker, &vhost, Some(process));
        Running::start(command.arg("--record").arg(file(process)))
    });
    let until = Instant::now() + Duration::from_secs(60);
    let jobs = || {
        let (_, objects) = replay(&[&file("street"), "--until", "1000s"]);
        let jobs = objects[0]["state"]["state"]["jobs"].as_str();
        jobs.and_then(|jobs| jobs.parse().ok()).unwrap_or(0)
    };
    while jobs() < 2 {
        assert!(Instant::now() < until, "the courier gets no reply");
        std::thread::sleep(Duration::from_millis(300));
    }
    assert!(
        running
            .into_iter()
            .map(Running::interrupt)
            .all(|it| it.status.success())
    );
    let (code, objects) = replay(&[&text(folder.path())]);
    assert_eq!(code, Some(0), "{objects:?}");
    let results = objects.iter().filter(|it| it["type"] == "coordinator");
    let results: Vec<_> = results
        .map(|it| (&it["component"], &it["result"], &it["complete"]))
        .collect();
    let equal = |name: &str| (Value::from(name), Value::from("equal"), Value::from(true));
    let expected = [equal("Dispatcher"), equal("Courier")];
    let expected: Vec<_> = expected.iter().map(|it| (&it.0, &it.1, &it.2)).collect();
    assert_eq!(results, expected);
}

#[test]
fn c18_a_specification_that_is_replaced_while_it_runs_repeats_with_both_versions() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let folder = tempfile::tempdir().unwrap();
    let composite = three_processes(folder.path());
    let file = text(&folder.path().join("supervisor.mcap"));
    let names = ["onboard", "planning", "supervisor"];
    let running = names.map(|process| {
        let mut command = through(run_any(&composite), &broker, &vhost, Some(process));
        if process == "supervisor" {
            command.args(["--record", &file]);
        }
        Running::start(&mut command)
    });
    names
        .iter()
        .for_each(|name| wait_until_present(&vhost, name));
    let specification = folder.path().join("navigate.asm");
    let first = std::fs::read_to_string(&specification).unwrap();
    let second = first.replacen(
        "\tcontrolled tries: Tries",
        "\tcontrolled tries: Tries\n\tcontrolled laps: Integer",
        1,
    );
    std::fs::write(&specification, second).unwrap();
    let (code, out, err) = tool(&broker, &url, &["reconfigure", &text(&composite)]);
    assert_eq!(code, Some(0), "{out}{err}");
    // steps of the new version
    std::thread::sleep(Duration::from_millis(1500));
    assert!(
        running
            .into_iter()
            .map(Running::interrupt)
            .all(|process| process.status.success())
    );
    let (code, objects) = replay(&[&file]);
    let one = coordinator(&objects);
    assert_eq!((code, &one["result"]), (Some(0), &"equal".into()), "{one}");
    assert_eq!(
        (&one["machines"], &one["complete"]),
        (&2.into(), &true.into()),
        "{one}"
    );
    // the state goes over, and the new function is part of it
    let (_, objects) = replay(&[&file, "--until", "100s"]);
    assert_eq!(
        coordinator(&objects)["state"]["state"]["tries"],
        "0",
        "{objects:?}"
    );
    let (code, said) = asmotion(&["replay", &file, "--export", "scenario"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("the specification was replaced before"),
        "{said}"
    );
}

#[test]
fn d4_an_edited_specification_shows_its_first_different_step_rule_and_location() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&navigation_composite(), &file, &["--goal", "3.4,4.7"]);
    let file = text(&file);
    // an edit that changes nothing in this run
    let spec = edited(
        folder.path(),
        &[("tries < maxTries", "tries + 1 < maxTries")],
    );
    let (code, objects) = replay(&[&file, "--spec", &spec]);
    assert_eq!(
        (code, &coordinator(&objects)["notes"]),
        (Some(0), &Value::Array(Vec::new()))
    );
    let spec = edited(
        folder.path(),
        &[
            (
                "case REACHED: r_halt[ARRIVED]",
                "case REACHED: r_halt[FAILED]",
            ),
            (
                "\tcontrolled tries: Tries",
                "\tcontrolled tries: Tries\n\tcontrolled goals: Integer\n\tmonitored battery: Integer",
            ),
            (
                "\t\t\ttries := 0\n",
                "\t\t\ttries := 0\n\t\t\tgoals := 1\n\t\t\tif battery = 0 then tries := 3 endif\n",
            ),
        ],
    );
    let (code, objects) = replay(&[&file, "--spec", &spec]);
    let one = coordinator(&objects);
    assert_eq!(
        (code, &one["result"]),
        (Some(1), &"different".into()),
        "{one}"
    );
    let different = &one["difference"];
    assert_eq!(different["location"], "mode", "{different}");
    assert_eq!(different["recorded"]["after"], "ARRIVED", "{different}");
    assert_eq!(different["replayed"]["after"], "FAILED", "{different}");
    assert_eq!(different["replayed"]["rule"], "r_enter", "{different}");
    assert!(
        different["recorded"]["place"]
            .as_str()
            .unwrap()
            .starts_with("navigate.asm:"),
        "{different}"
    );
    assert!(
        different["replayed"]["place"]
            .as_str()
            .unwrap()
            .starts_with("edited.asm:"),
        "{different}"
    );
    let cause = different["cause"].as_array().unwrap();
    assert!(cause.contains(&"event".into()), "{different}");
    let said = different["text"].as_str().unwrap();
    assert!(
        said.contains("because: `event = REACHED`, with event = REACHED"),
        "{said}"
    );
    let notes = one["notes"].to_string();
    assert!(
        notes.contains("`battery` is read, and the recording has no value of it"),
        "{notes}"
    );
    assert!(
        notes.contains("`goals` is new: its updates are not compared"),
        "{notes}"
    );
    // the step that is named is the one in which the recorded mode becomes ARRIVED
    let number = different["step"].to_string();
    let (_, objects) = replay(&[&file, "--explain", "mode", "--until", &number]);
    let explained = &coordinator(&objects)["explanation"];
    assert_eq!(
        (&explained["value"], &explained["step"]),
        (&"ARRIVED".into(), &different["step"])
    );
    // a specification with another name stands for the only coordinator
    let spec = edited(folder.path(), &[("asm navigate", "asm edited")]);
    let (code, objects) = replay(&[&file, "--spec", &spec]);
    assert_eq!(
        (code, &coordinator(&objects)["result"]),
        (Some(0), &"equal".into())
    );
    // an edit with an error is reported at its place
    let spec = edited(
        folder.path(),
        &[("asm navigate", "asm edited"), ("tries := 0", "tires := 0")],
    );
    let (code, said) = asmotion(&["replay", &file, "--spec", &spec]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("edited.asm:") && said.contains("tires"),
        "{said}"
    );
}

#[test]
fn d4_a_folder_of_recordings_is_a_regression_suite() {
    let folder = tempfile::tempdir().unwrap();
    let runs = folder.path().join("runs");
    record(
        &navigation_composite(),
        &runs.join("a.mcap"),
        &["--goal", "3.4,4.7", "--ports", "goal"],
    );
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs");
    let two = specs.join("navigation/two_rovers.composite.toml");
    record(
        &two,
        &runs.join("b.mcap"),
        &["--for", "5", "--ports", "goal"],
    );
    let spec = edited(
        folder.path(),
        &[(
            "case REACHED: r_halt[ARRIVED]",
            "case REACHED: r_halt[FAILED]",
        )],
    );
    let report = folder.path().join("report.xml");
    let (code, objects) = replay(&[&text(&runs), "--spec", &spec, "--junit", &text(&report)]);
    assert_eq!(code, Some(1), "{objects:?}");
    let report = std::fs::read_to_string(report).unwrap();
    assert!(
        report.contains(r#"tests="3" skipped="0" errors="0" failures="1""#),
        "{report}"
    );
    assert!(
        report.contains(r#"<failure message="different in step "#),
        "{report}"
    );
    assert!(
        report.contains("update of `mode`") && report.contains(r#"name="Left/ASMCoordinator""#),
        "{report}"
    );
    std::fs::write(runs.join("c.mcap"), "no recording").unwrap();
    let (code, objects) = replay(&[&text(&runs), "--spec", &spec]);
    assert_eq!(code, Some(2), "{objects:?}");
    let results: Vec<_> = objects
        .iter()
        .map(|it| it["result"].as_str().unwrap())
        .collect();
    assert_eq!(
        results,
        ["different", "equal", "equal", "unusable", "unusable"]
    );
}

#[test]
fn a_recording_that_another_program_has_changed_is_different() {
    let Some(python) = python() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(format!("{name}.mcap"));
    record(
        &navigation_composite(),
        &file("run"),
        &["--goal", "3.4,4.7", "--ports", "goal"],
    );
    let change = |mode: &str| {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/replay/edit.py");
        let mut command = Command::new(&python);
        command
            .arg(script)
            .arg(file("run"))
            .arg(file(mode))
            .arg(mode);
        let output = command.output().unwrap();
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        replay(&[&text(&file(mode))])
    };
    // a changed value is found, also if all hashes are forged
    for (mode, altered) in [("value", true), ("forge", false)] {
        let (code, objects) = change(mode);
        let one = coordinator(&objects);
        let different = &one["difference"];
        assert_eq!(
            (code, &different["altered"]),
            (Some(1), &altered.into()),
            "{mode}: {one}"
        );
        assert_eq!(different["location"], "mode", "{one}");
        assert_eq!(different["recorded"]["after"], "STOPPING", "{one}");
        assert_eq!(different["replayed"]["after"], "WAIT_PATH", "{one}");
    }
    // a step that nobody counts as lost was removed
    let (code, objects) = change("remove");
    let one = coordinator(&objects);
    assert_eq!(
        (code, &one["result"]),
        (Some(1), &"different".into()),
        "{one}"
    );
    assert!(
        one["difference"]["text"]
            .as_str()
            .unwrap()
            .contains("steps are missing"),
        "{one}"
    );
    let (code, objects) = change("lose");
    let one = coordinator(&objects);
    assert_eq!(
        (code, &one["steps"], &one["complete"]),
        (Some(0), &39.into(), &false.into()),
        "{one}"
    );
    assert!(
        one["incomplete"]
            .as_str()
            .unwrap()
            .contains("could not be compared"),
        "{one}"
    );
    // without the first step, no other one can be repeated
    let (code, objects) = change("middle");
    let one = coordinator(&objects);
    assert_eq!(
        (code, &one["result"]),
        (Some(2), &"unusable".into()),
        "{one}"
    );
    assert!(
        one["reason"]
            .as_str()
            .unwrap()
            .contains("from the middle of the run"),
        "{one}"
    );
    let (code, objects) = change("frozen");
    let one = coordinator(&objects);
    assert_eq!(
        (code, &one["result"]),
        (Some(2), &"unusable".into()),
        "{one}"
    );
    assert!(
        one["reason"]
            .as_str()
            .unwrap()
            .contains("continued from a frozen state"),
        "{one}"
    );
    // a file of another program has none of our facts
    let (code, objects) = change("foreign");
    assert_eq!(
        (code, &objects[0]["result"]),
        (Some(2), &"unusable".into()),
        "{objects:?}"
    );
    assert!(
        objects[0]["reason"]
            .as_str()
            .unwrap()
            .contains("this is no recording"),
        "{objects:?}"
    );
}

#[test]
fn nothing_compared_is_never_a_success() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(format!("{name}.mcap"));
    record(&navigation_composite(), &file("run"), &["--for", "3"]);
    let bytes = std::fs::read(file("run")).unwrap();
    let cut = |name: &str, length: usize| {
        std::fs::write(file(name), &bytes[..length]).unwrap();
        let (code, said) = asmotion(&["replay", &text(&file(name))]);
        assert_eq!(code, Some(2), "{said}");
        said
    };
    let said = cut("short", 60_000);
    assert!(
        said.contains("ends before the first step of a coordinator"),
        "{said}"
    );
    let said = cut("empty", 0);
    assert!(said.contains("this is no recording"), "{said}");
    let driver =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/youbot/youbot_driver.composite.toml");
    record(&driver, &file("driver"), &["--for", "1"]);
    for (arguments, reason) in [
        (vec!["driver"], "no steps of a coordinator"),
        (vec!["nowhere"], "cannot be read"),
        (
            vec!["run", "--component", "ASMCoordinater"],
            "did you mean `ASMCoordinator`?",
        ),
        (
            vec!["run", "--until", "4000"],
            "it has no step 4000: the last one is step 61",
        ),
        (vec!["run", "--explain", "mod"], "did you mean `mode`?"),
        (
            vec!["run", "driver", "--explain", "mode"],
            "need one recording, and there are 2",
        ),
    ] {
        let named = arguments
            .iter()
            .enumerate()
            .map(|(index, argument)| match index {
                0 => text(&file(argument)),
                _ if *argument == "driver" => text(&file(argument)),
                _ => (*argument).to_owned(),
            });
        let named: Vec<_> = named.collect();
        let named: Vec<_> = named.iter().map(String::as_str).collect();
        let (code, said) = asmotion(&[&["replay"], named.as_slice()].concat());
        assert_eq!(code, Some(2), "{arguments:?}: {said}");
        assert!(said.contains(reason), "{arguments:?}: {said}");
    }
    // before the first step there is a state, but nothing was compared
    let (code, said) = asmotion(&["replay", &text(folder.path()), "--until", "x"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("expected the number of a step"), "{said}");
}

#[test]
fn a_recording_in_several_files_is_replayed_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path(), "dir = \"all\", rotate_mb = 1");
    let (code, said) = asmotion(&["run", &text(&path), "-q"]);
    assert_eq!(code, Some(0), "{said}");
    let files = std::fs::read_dir(folder.path().join("all")).unwrap();
    let mut files: Vec<_> = files.map(|entry| text(&entry.unwrap().path())).collect();
    files.sort_by_key(|path| (path.contains(".part"), path.len(), path.clone()));
    assert!(files.len() > 3, "{files:?}");
    let whole = replay(&[&files[0]]);
    let one = coordinator(&whole.1);
    assert_eq!(
        (whole.0, &one["complete"]),
        (Some(0), &true.into()),
        "{one}"
    );
    let steps = one["steps"].as_u64().unwrap();
    assert!(steps > 500, "{one}");
    // whatever their order, and as a folder
    let mut reversed: Vec<&str> = files.iter().map(String::as_str).collect();
    reversed.reverse();
    let folder_of_runs = text(&folder.path().join("all"));
    for arguments in [reversed, vec![folder_of_runs.as_str()]] {
        let (code, objects) = replay(&arguments);
        assert_eq!(
            (code, &coordinator(&objects)["steps"]),
            (Some(0), &steps.into())
        );
    }
    let (code, objects) = replay(&[&files[2]]);
    assert_eq!(code, Some(2), "{objects:?}");
    assert!(
        objects[0]["reason"].as_str().unwrap().contains("part 3"),
        "{objects:?}"
    );
    std::fs::remove_file(&files[1]).unwrap();
    let (code, objects) = replay(&[&files[0]]);
    let one = coordinator(&objects);
    assert_eq!((code, &one["complete"]), (Some(0), &false.into()), "{one}");
    assert!(
        one["incomplete"]
            .as_str()
            .unwrap()
            .contains("part 2 of it is missing"),
        "{one}"
    );
    assert!(one["steps"].as_u64().unwrap() < steps, "{one}");
}

#[test]
fn a_location_is_explained_and_a_state_is_shown_at_any_time() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(
        &navigation_composite(),
        &file,
        &["--goal", "3.4,4.7", "--ports", "goal"],
    );
    let file = text(&file);
    let (code, said) = asmotion(&["replay", &file, "--explain", "mode", "--until", "24"]);
    assert_eq!(code, Some(0), "{said}");
    for line in [
        "mode = FOLLOWING, written in step 24 at ",
        "`mode := $next` in r_enter, ",
        "because    `mode = WAIT_PATH`, with mode = WAIT_PATH",
        "because    `event = PATH_OK`, with event = PATH_OK",
        "cause      pose, planner.plan",
    ] {
        assert!(said.contains(line), "{line}: {said}");
    }
    let (_, objects) = replay(&[&file, "--until", "23"]);
    let before = &coordinator(&objects)["state"];
    assert_eq!(
        (&before["step"], &before["state"]["mode"]),
        (&23.into(), &"WAIT_PATH".into())
    );
    // a time between two steps shows the state after the first of them
    let at = before["time_s"].as_f64().unwrap() + 0.02;
    let (_, objects) = replay(&[&file, "--until", &format!("{at}s")]);
    assert_eq!(coordinator(&objects)["state"], *before, "{objects:?}");
    let (_, objects) = replay(&[&file, "--until", "24"]);
    assert_eq!(
        coordinator(&objects)["state"]["state"]["mode"],
        "FOLLOWING",
        "{objects:?}"
    );
    let (_, objects) = replay(&[&file, "--explain", "event"]);
    let explained = &coordinator(&objects)["explanation"];
    assert_eq!(
        (&explained["kind"], &explained["value"]),
        (&"input".into(), &"NOTHING".into())
    );
    let (_, objects) = replay(&[&file, "--explain", "maxTries"]);
    assert_eq!(
        coordinator(&objects)["explanation"]["kind"],
        "initial",
        "{objects:?}"
    );
}

#[test]
fn an_export_repeats_the_same_states_in_other_commands() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name));
    record(
        &navigation_composite(),
        Path::new(&path("run.mcap")),
        &["--goal", "3.4,4.7", "--ports", "goal"],
    );
    let export = |format: &str, name: &str| {
        let (code, said) = asmotion(&[
            "replay",
            &path("run.mcap"),
            "--export",
            format,
            "-o",
            &path(name),
        ]);
        assert_eq!(code, Some(0), "{said}");
        assert!(!said.contains("warning"), "{said}");
    };
    export("scenario", "run.avalla");
    let (code, said) = asmotion(&["test", &path("run.avalla")]);
    assert_eq!(code, Some(0), "{said}");
    let scenario = std::fs::read_to_string(path("run.avalla")).unwrap();
    assert!(scenario.contains("check mode = ARRIVED;"), "{scenario}");
    std::fs::write(
        path("wrong.avalla"),
        scenario.replace("check mode = ARRIVED", "check mode = IDLE"),
    )
    .unwrap();
    assert_eq!(asmotion(&["test", &path("wrong.avalla")]).0, Some(1));

    export("trace", "run.trace");
    let spec = text(&navigation().join("navigate.asm"));
    let again = [
        "sim",
        &spec,
        "--replay-inputs",
        &path("run.trace"),
        "-q",
        "--trace",
        &path("again.trace"),
    ];
    let (code, said) = asmotion(&again);
    assert_eq!(code, Some(0), "{said}");
    let trace = |name: &str| {
        let text = std::fs::read_to_string(path(name)).unwrap();
        let lines = text
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(str::to_owned);
        lines.collect::<Vec<_>>()
    };
    assert_eq!(trace("again.trace"), trace("run.trace"));

    export("csv", "run.csv");
    let mut table = csv::Reader::from_path(path("run.csv")).unwrap();
    let head = table.headers().unwrap().clone();
    let column = head.iter().position(|name| name == "mode").unwrap();
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    let (_, objects) = replay(&[&path("run.mcap")]);
    assert_eq!(
        rows.len() as u64,
        coordinator(&objects)["steps"].as_u64().unwrap()
    );
    let mut modes: Vec<&str> = rows.iter().map(|row| &row[column]).collect();
    modes.dedup();
    assert_eq!(
        modes,
        ["IDLE", "WAIT_MAP", "WAIT_PATH", "FOLLOWING", "ARRIVED"]
    );
}

#[test]
fn a_session_goes_back_and_forth_through_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(
        &navigation_composite(),
        &file,
        &["--goal", "3.4,4.7", "--ports", "goal"],
    );
    let talk = |arguments: &[&str], lines: &'static str| {
        let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .arg("repl")
            .args(arguments);
        let output = command.write_stdin(lines).output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(said).unwrap())
    };
    let file = text(&file);
    let (code, said) = talk(
        &["--from", &file],
        "step 24\nmode\nwho mode\nundo\nmode\nstep\nmode\nrun\nmode\n",
    );
    assert_eq!(code, Some(0), "{said}");
    let modes = said.lines().filter(|line| {
        let mut letters = line.chars();
        letters.all(|letter| letter.is_ascii_uppercase() || letter == '_')
    });
    let modes: Vec<_> = modes.filter(|line| !line.is_empty()).collect();
    assert_eq!(
        modes,
        ["FOLLOWING", "WAIT_PATH", "FOLLOWING", "ARRIVED"],
        "{said}"
    );
    assert!(
        said.contains("because `event = PATH_OK`, with event = PATH_OK"),
        "{said}"
    );
    // an edited specification gets the inputs that it still has
    let spec = edited(folder.path(), &[("contact", "bumper")]);
    let (code, said) = talk(&[&spec, "--from", &file], "step 24\nmode\nbumper\n");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("\nFOLLOWING\nundef\n"), "{said}");
    let (code, said) = talk(&["--from", &file, "--component", "Nobody"], "");
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("it has no coordinator `Nobody`"), "{said}");
    let (code, said) = talk(&["--from", &file, "--machine", "2"], "");
    assert_eq!(code, Some(2), "{said}");
    assert_eq!(talk(&[], "").0, Some(2));
}
