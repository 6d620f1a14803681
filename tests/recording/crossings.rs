//! Recordings of runs that do something else at the same time: several processes, a dashboard, a new version, a reset.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use asmotion_broker::{SharedBroker, Vhost};
use asmotion_recording::{RecordingItem, RunReader};
use serde_json::Value;

use super::{asmotion, end, navigation, output, steps};
use crate::processes::{Running, queues, tool, wait_until_present};

/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(30);

/// Counts its steps. Breaks in the fourth one if it is told to.
const WORKER: &str = "asm worker
import StandardLibrary
signature:
	controlled n: Integer
	controlled breaks: Boolean
definitions:
	main rule r_Main =
		par
			n := n + 1
			if breaks and n = 3 then n := 0 endif
		endpar
default init s0:
	function n = 0
	function breaks = false
";

/// Two workers, each in a process of its own if there are several.
const WORKERS: &str = r#"
schema = "composite/1"
[composite]
name = "workers"
[components.One]
implementation = { asm = "worker.asm" }
task = { period_ms = 20 }
[components.Two]
implementation = { asm = "worker.asm" }
task = { period_ms = 10 }
[deploy]
restart = { policy = "on_failure", max = 2, window_s = 600, backoff_ms = [20] }
record = { dir = "runs", rotate_mb = 256 }
processes = [
  { name = "near", components = ["One"] },
  { name = "far", components = ["Two"] },
]
"#;

/// A folder with the workers, whose composite is changed.
fn workers(changes: &[(&str, &str)]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("worker.asm"), WORKER).unwrap();
    let mut text = WORKERS.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let composite = folder.path().join("workers.composite.toml");
    std::fs::write(&composite, text).unwrap();
    (folder, composite)
}

/// The files in a folder of recordings, by name.
fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter(|name| name.ends_with(".mcap")).collect();
    names.sort();
    names
}

fn facts(file: &Path) -> BTreeMap<String, String> {
    RunReader::open(file).unwrap().facts().clone()
}

/// Channels of messages in a file, in order and without repetitions.
fn channels(file: &Path) -> BTreeSet<String> {
    let items = RunReader::open(file).unwrap();
    let channels = items.filter_map(|item| match item {
        RecordingItem::Message { channel, .. } => Some(channel),
        RecordingItem::Text { .. }
        | RecordingItem::Step { .. }
        | RecordingItem::End(_)
        | RecordingItem::Cut(_) => None,
    });
    channels.collect()
}

/// The object `recording` of the summary that `--json` prints.
fn summary(output: &[u8]) -> Value {
    let text = String::from_utf8_lossy(output);
    let last: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    last["recording"].clone()
}

/// A command over the broker of a test.
fn over(broker: &SharedBroker, vhost: &Vhost<'_>, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.args(arguments).args(["--bus", &vhost.url()]);
    command.env("ASMOTION_PASSWORD", broker.password());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

#[test]
fn each_process_of_a_system_has_a_file_of_its_own() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    // both get the same name, and the second one keeps the file of the first one
    let file = folder.path().join("run.mcap");
    let composite = navigation();
    let start = |process: &str| {
        let path = composite.display().to_string();
        let arguments = ["run", &path, "--process", process, "--json", "--for", "120"];
        let mut command = over(&broker, &vhost, &arguments);
        command.args(["--goal", "3.4,4.7", "--record"]).arg(&file);
        Running::start(&mut command)
    };
    let onboard = start("onboard");
    wait_until_present(&vhost, "onboard");
    let supervisor = start("supervisor").end();
    let onboard = onboard.interrupt();
    let [first, second] = ["run.mcap", "run-2.mcap"].map(|name| folder.path().join(name));
    for (process, output, file) in [
        ("onboard", onboard, &first),
        ("supervisor", supervisor, &second),
    ] {
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let recording = summary(&output.stdout);
        assert_eq!(recording["paths"], serde_json::json!([file]));
        assert_eq!(recording["complete"], true, "{recording}");
        assert_eq!(facts(file)["process"], process);
        assert_eq!(steps(file).1, None);
    }
    assert_eq!(files(folder.path()).len(), 2);
    // a message that goes from one to the other is in both
    let coordinator = steps(&second).0;
    assert!(coordinator > 10, "{coordinator}");
    assert_eq!(steps(&first).0, 0);
    for (file, channel) in [
        (&first, "topic/odom"),
        (&second, "port/ASMCoordinator.pose"),
        (&second, "call/ASMCoordinator.planner.plan"),
        (&first, "port/LaserDriver.scan"),
    ] {
        let channels = channels(file);
        assert!(channels.contains(channel), "{channel}: {channels:?}");
    }
}

/// `asmotion up`, told to end so that it ends its processes.
struct Supervised(Child);

impl Drop for Supervised {
    fn drop(&mut self) {
        if let Ok(None) = self.0.try_wait() {
            signal("-TERM", &self.0.id().to_string());
            let _ = self.0.wait();
        }
    }
}

fn signal(signal: &str, id: &str) {
    let status = Command::new("kill").args([signal, id]).status().unwrap();
    assert!(status.success());
}

/// Waits until something holds.
fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !holds() {
        assert!(begin.elapsed() < LONG, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn up_records_each_process_and_its_restart() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (folder, composite) = workers(&[]);
    let path = composite.display().to_string();
    let mut command = over(&broker, &vhost, &["up", &path]);
    let mut running = Supervised(command.stdout(Stdio::null()).spawn().unwrap());
    let mut lines = BufReader::new(running.0.stderr.take().unwrap()).lines();
    let near = loop {
        let line = lines.next().unwrap().unwrap();
        if let Some((_, id)) = line.split_once("Started near, process ") {
            break id.to_owned();
        }
    };
    std::thread::spawn(move || lines.for_each(drop));
    let runs = folder.path().join("runs");
    let of = |process: &str| -> Vec<PathBuf> {
        let prefix = format!("workers-{process}-");
        let names = files(&runs).into_iter();
        let mine = names.filter(|name| name.starts_with(&prefix));
        mine.map(|name| runs.join(name)).collect()
    };
    let has_steps = |file: &Path| RunReader::open(file).is_ok() && steps(file).0 > 10;
    until("recordings of both", || {
        ["near", "far"].iter().all(|process| of(process).len() == 1)
    });
    let (killed, far) = (of("near").remove(0), of("far").remove(0));
    until("steps", || has_steps(&killed) && has_steps(&far));
    signal("-KILL", &near);
    until("a recording of the restart", || of("near").len() == 2);
    let again = of("near").into_iter().find(|file| *file != killed).unwrap();
    until("steps after the restart", || has_steps(&again));
    signal("-TERM", &running.0.id().to_string());
    assert_eq!(running.0.wait().unwrap().code(), Some(0));
    assert!(steps(&killed).1.is_some(), "the killed one is cut");
    for file in [&again, &far] {
        assert_eq!(steps(file).1, None);
        assert_eq!((end(file).lost, end(file).failure), (0, None));
    }
}

#[test]
fn a_new_version_is_recorded_with_its_texts_and_the_chain_goes_on() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (folder, composite) = workers(&[]);
    let path = composite.display().to_string();
    let mut command = over(&broker, &vhost, &["run", &path, "--json", "--for", "60"]);
    let file = folder.path().join("run.mcap");
    command.arg("--record").arg(&file);
    let running = Running::start(&mut command);
    queues(&vhost, "robots.services.workers.control.workers");
    until("steps", || {
        RunReader::open(&file).is_ok() && steps(&file).0 > 10
    });
    let spec = folder.path().join("worker.asm");
    std::fs::write(&spec, WORKER.replace("n := n + 1", "n := n + 2")).unwrap();
    let third = "[components.Three]\nimplementation = { asm = \"worker.asm\" }\ntask = { period_ms = 10 }\n[deploy]";
    let text = std::fs::read_to_string(&composite).unwrap();
    let text = text.replace("[deploy]", third);
    let text = text.replace("[\"Two\"]", "[\"Two\", \"Three\"]");
    std::fs::write(&composite, text).unwrap();
    let (code, _, said) = tool(&broker, &vhost.url(), &["reconfigure", &path]);
    assert_eq!(code, Some(0), "{said}");
    std::thread::sleep(Duration::from_millis(500));
    let output = running.interrupt();
    assert_eq!(summary(&output.stdout)["complete"], true, "{output:?}");
    // records of all three are intact, and those of the new version begin with the new text
    let (mut texts, mut begins) = (Vec::new(), Vec::new());
    for item in RunReader::open(&file).unwrap() {
        match item {
            RecordingItem::Text { name, text, .. } => texts.push((name, text)),
            RecordingItem::Step { component, step } => {
                assert!(step.is_intact);
                let sources = step.cycle.begins.iter().flat_map(|begin| &begin.sources);
                begins.extend(sources.map(|source| (component.clone(), source.hash.clone())));
            }
            RecordingItem::Cut(reason) => panic!("{reason}"),
            RecordingItem::Message { .. } | RecordingItem::End(_) => {}
        }
    }
    let text = |begin: &str, end: &str| {
        let mut found = texts.iter();
        let found = found.find(|(name, _)| name.starts_with(begin) && name.ends_with(end));
        found
            .unwrap_or_else(|| panic!("{begin}…{end}: {texts:?}"))
            .1
            .clone()
    };
    assert!(text("version/2/", "expanded.composite.toml").contains("Three"));
    assert!(text("version/2/composite/", "workers.composite.toml").contains("Three"));
    assert!(!text("expanded", "composite.toml").contains("Three"));
    let new = text("specification/", "worker.asm");
    assert!(new.contains("n + 1"), "{new}");
    let of = |component: &str| -> Vec<&str> {
        let mine = begins.iter().filter(|(name, _)| name == component);
        mine.map(|(_, hash)| hash.as_str()).collect()
    };
    assert_eq!((of("One").len(), of("Three").len()), (2, 1), "{begins:?}");
    assert_eq!(of("One")[1], of("Three")[0]);
    assert_ne!(of("One")[0], of("One")[1]);
}

#[test]
fn a_reset_coordinator_begins_again_in_the_chain_of_its_records() {
    let reset = "implementation = { asm = \"worker.asm\" }\nlifecycle = { on_exception = \"reset\", max_resets = 1 }\ntask = { period_ms = 20";
    let (folder, composite) = workers(&[(
        "implementation = { asm = \"worker.asm\" }\ntask = { period_ms = 20",
        reset,
    )]);
    let spec = folder.path().join("worker.asm");
    std::fs::write(&spec, WORKER.replace("breaks = false", "breaks = true")).unwrap();
    let file = folder.path().join("run.mcap");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(&composite).args(["--for", "2"]);
    command.arg("--record").arg(&file);
    let (_, said) = output(&mut command);
    assert!(said.contains("recording"), "{said}");
    let mut records = BTreeMap::<String, Vec<_>>::new();
    for item in RunReader::open(&file).unwrap() {
        if let RecordingItem::Step { component, step } = item {
            assert!(step.is_intact);
            records.entry(component).or_default().push(step);
        }
    }
    let one = &records["One"];
    let shape: Vec<_> = one
        .iter()
        .map(|step| {
            (
                step.cycle.number,
                step.cycle.begins.len(),
                step.cycle.fault.is_some(),
            )
        })
        .collect();
    // the fourth step fails, and has the number of the next one
    let course = [(1, 1, false), (2, 0, false), (3, 0, false), (4, 0, true)];
    assert_eq!(shape, [course, course].concat());
    // the same course from the initial state, in one chain
    for (first, second) in one[..4].iter().zip(&one[4..]) {
        assert_eq!(first.hashes.state_hash, second.hashes.state_hash);
    }
    assert!(
        one.windows(2)
            .all(|it| it[1].hashes.previous == it[0].hashes.hash)
    );
    assert_eq!(end(&file).coordinators["One"].last_hash, one[7].hashes.hash);
    // without a reset, it stays as it is
    assert_eq!(records["Two"].len(), 4);
}

#[test]
fn two_coordinators_have_chains_of_their_own_through_all_parts() {
    let (folder, composite) = workers(&[
        ("rotate_mb = 256", "rotate_mb = 1"),
        ("period_ms = 10 ", "period_ms = 1 "),
    ]);
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let command = command.arg("run").arg(&composite);
    let output = command.args(["--json", "--for", "7"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let said = String::from_utf8_lossy(&output.stderr);
    // no pattern was given, so none is in vain
    assert!(!said.contains("no port of this name"), "{said}");
    let recording = summary(&output.stdout);
    let paths = recording["paths"].as_array().unwrap().iter();
    let paths: Vec<_> = paths
        .map(|path| Path::new(path.as_str().unwrap()))
        .collect();
    assert!(paths.len() > 2, "{recording}");
    assert_eq!(files(&folder.path().join("runs")).len(), paths.len());
    let mut last = BTreeMap::<String, String>::new();
    for path in &paths {
        for item in RunReader::open(path).unwrap() {
            if let RecordingItem::Step { component, step } = item {
                assert!(step.is_intact);
                let before = last.insert(component, step.hashes.hash);
                assert_eq!(step.hashes.previous, before.unwrap_or("0".repeat(32)));
            }
        }
    }
    let ends = end(paths.last().unwrap()).coordinators.into_iter();
    let ends: BTreeMap<_, _> = ends.map(|(name, it)| (name, it.last_hash)).collect();
    assert_eq!((ends.len(), ends), (2, last));
}

#[test]
fn a_dashboard_changes_nothing_in_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let record = |name: &str, more: &[&str]| {
        let file = folder.path().join(name);
        let path = file.display().to_string();
        let (code, said) = output(asmotion(&["--record", &path]).args(more));
        assert_eq!(code, Some(0), "{said}");
        let items = RunReader::open(&file).unwrap();
        let messages = items.filter_map(|item| match item {
            RecordingItem::Message { channel, at, data } => Some((channel, Some((at, data)), None)),
            RecordingItem::Step { component, step } => {
                Some((component, None, Some(step.hashes.hash)))
            }
            RecordingItem::Text { .. } | RecordingItem::End(_) | RecordingItem::Cut(_) => None,
        });
        messages.collect::<Vec<_>>()
    };
    let alone = record("alone.mcap", &[]);
    let shown = record(
        "shown.mcap",
        &["--dashboard", "127.0.0.1:0", "--speed", "0"],
    );
    assert!(alone.len() > 1000);
    assert!(alone == shown, "the recordings differ");
}

#[test]
fn a_mission_that_is_tested_records_nothing() {
    let (folder, _) = workers(&[]);
    let mission = "schema = \"mission/1\"\ncomposite = \"workers.composite.toml\"\nlimit_s = 1\n[[expect]]\neventually = \"One.n = 5\"\n";
    let path = folder.path().join("counts.mission.toml");
    std::fs::write(&path, mission).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let (code, said) = output(command.arg("test").arg(&path));
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(files(&folder.path().join("runs")), Vec::<String>::new());
}

#[test]
fn a_full_disk_costs_a_run_in_real_time_its_recording_and_nothing_else() {
    let (folder, composite) = workers(&[("period_ms = 10 ", "period_ms = 1 ")]);
    let file = folder.path().join("run.mcap");
    // 500 kB, less than half of what this run writes; the signal would end the process
    let script = "trap '' XFSZ; ulimit -f 1000; exec \"$0\" run \"$1\" --record \"$2\" --clock wall --for 3 --json";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_asmotion")]);
    let output = command.arg(&composite).arg(&file).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let recording = summary(&output.stdout);
    assert_eq!(recording["complete"], false, "{recording}");
    assert!(recording["lost"].as_u64().unwrap() > 100, "{recording}");
    // the reason is that of the system
    let failure = recording["failure"].as_str().unwrap();
    assert!(
        failure.starts_with("cannot write `") && failure.contains("large"),
        "{failure}"
    );
    let last: Value = serde_json::from_slice(
        output
            .stdout
            .trim_ascii_end()
            .split(|it| *it == b'\n')
            .next_back()
            .unwrap(),
    )
    .unwrap();
    let all = last["steps"].as_u64().unwrap();
    assert!(all > 1000, "{all}");
    let (read, _) = steps(&file);
    assert!(read > 10 && read < all, "{read} of {all}");
}
