//! Recordings as MCAP, read by the Python packages `mcap` and `rosbags`: what they contain, and what remains of one whose process is killed or
//! whose disk is full.

mod crossings;
mod rosbags;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use asmotion_recording::{FileEnd, RecordingItem, RunReader};
use serde_json::Value;

/// Versions of the readers.
const PACKAGES: [&str; 2] = ["mcap==1.3.0", "rosbags==0.11.9"];

/// Returns a Python with the packages in `target/mcap`, installed if one is missing.
pub(super) fn python() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/mcap/venv");
    let python = folder.join("bin/python");
    let has_package = || {
        let imports = ["-c", "import mcap, rosbags"];
        let tried = Command::new(&python).args(imports).output();
        tried.is_ok_and(|it| it.status.success())
    };
    if has_package() {
        return Some(python);
    }
    let made = Command::new("python3")
        .args(["-m", "venv"])
        .arg(&folder)
        .output();
    if made.is_ok_and(|it| it.status.success()) {
        let mut pip = Command::new(&python);
        pip.args(["-m", "pip", "install", "--quiet"]).args(PACKAGES);
        let _ = pip.output();
    }
    if has_package() {
        return Some(python);
    }
    asmotion_skip::PYPI.skip();
    None
}

/// Content of a file, according to the independent reader.
fn read(python: &Path, file: &Path) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recording/read.py");
    let output = Command::new(python).arg(script).arg(file).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn count(content: &Value, channel: &str) -> u64 {
    content["counts"][channel].as_u64().unwrap_or(0)
}

/// The end of a file, according to our reader.
fn end(file: &Path) -> FileEnd {
    let ends = RunReader::open(file).unwrap();
    let ends = ends.filter_map(|item| match item {
        RecordingItem::End(end) => Some(end),
        RecordingItem::Text { .. }
        | RecordingItem::Message { .. }
        | RecordingItem::Step { .. }
        | RecordingItem::Cut(_) => None,
    });
    ends.last().unwrap()
}

/// The components whose steps our reader finds in a file, all of them intact, and the reason that the file was cut.
fn steps(file: &Path) -> (u64, Option<String>) {
    let (mut steps, mut cut) = (0, None);
    for item in RunReader::open(file).unwrap() {
        match item {
            RecordingItem::Step { step, .. } => {
                assert!(step.is_intact, "{step:?}");
                steps += 1;
            }
            RecordingItem::Cut(reason) => cut = Some(reason),
            RecordingItem::Text { .. } | RecordingItem::Message { .. } | RecordingItem::End(_) => {}
        }
    }
    (steps, cut)
}

/// The composite of the navigation.
fn navigation() -> PathBuf {
    crate::processes::navigation().join("navigation.composite.toml")
}

fn asmotion(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(navigation());
    command.args(arguments);
    command
}

fn output(command: &mut Command) -> (Option<i32>, String) {
    let Output {
        status,
        stdout,
        stderr,
    } = command.output().unwrap();
    (
        status.code(),
        String::from_utf8([stdout, stderr].concat()).unwrap(),
    )
}

#[test]
fn d3_a_recording_has_the_steps_messages_calls_and_texts_of_the_run() {
    let Some(python) = python() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let path = file("run.mcap").display().to_string();
    let (code, said) = output(&mut asmotion(&["--record", &path]));
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("recording") && !said.contains("INCOMPLETE"),
        "{said}"
    );
    let content = read(&python, &file("run.mcap"));
    assert_eq!(content["cut"], Value::Null, "{}", content["counts"]);
    assert_eq!(
        content["broken"],
        Value::Array(Vec::new()),
        "{}",
        content["counts"]
    );
    assert!(
        count(&content, "asm/ASMCoordinator/step") > 100,
        "{}",
        content["counts"]
    );
    assert!(count(&content, "port/LaserDriver.scan") + count(&content, "topic/scan") > 100);
    assert!(count(&content, "call/ASMCoordinator.planner.plan") >= 2);
    assert!(count(&content, "events") > 10);
    // the text of the specification is attached under its hash
    let texts = content["texts"].as_object().unwrap();
    let text = |end: &str| {
        let found = texts.iter().find(|(name, _)| name.ends_with(end));
        found
            .unwrap_or_else(|| panic!("{end}: {:?}", texts.keys()))
            .1
            .as_str()
            .unwrap()
    };
    let navigate = std::fs::read_to_string("specs/navigation/navigate.asm").unwrap();
    assert_eq!(text("navigate.asm"), navigate);
    assert!(text("expanded.composite.toml").contains("TrajectoryFollower"));
    assert_eq!(
        content["facts"]["asmotion.run"]["seed"], "1",
        "{}",
        content["facts"]
    );
    let last = &content["facts"]["asmotion.end"]["ASMCoordinator.last_hash"];
    assert_eq!(*last, content["chain"]["asm/ASMCoordinator/step"]);
    // our own reader agrees
    let (read_steps, cut) = steps(&file("run.mcap"));
    assert_eq!(
        (read_steps, cut),
        (count(&content, "asm/ASMCoordinator/step"), None)
    );

    // equal runs have equal messages, and neither overwrites the other
    let (code, said) = output(&mut asmotion(&["--record", &path]));
    assert_eq!(code, Some(0), "{said}");
    let again = read(&python, &file("run-2.mcap"));
    assert_eq!(again["messages"], content["messages"]);
    let (code, said) = output(&mut asmotion(&["--record", &path, "--seed", "7"]));
    assert_eq!(code, Some(0), "{said}");
    let other = read(&python, &file("run-3.mcap"));
    assert_ne!(other["messages"], content["messages"]);
}

#[test]
fn a_run_takes_the_same_course_whether_it_is_recorded_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    let trace = |extra: &[&str]| {
        let name = file("trace.txt");
        let (code, said) = output(asmotion(&["--trace", &name, "--for", "20"]).args(extra));
        assert_eq!(code, Some(1), "{said}");
        std::fs::read_to_string(name).unwrap()
    };
    let without = trace(&[]);
    let with = trace(&["--record", &file("run.mcap")]);
    assert!(without.len() > 1000);
    assert!(without == with, "the trace differs");
}

#[test]
fn a_recording_is_readable_up_to_the_last_half_second_after_its_process_is_killed() {
    let Some(python) = python() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let path = file.display().to_string();
    let mut command = asmotion(&["--clock", "wall", "--record", &path]);
    let quiet = command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut process = quiet.spawn().unwrap();
    let until = Instant::now() + Duration::from_secs(60);
    while !std::fs::metadata(&file).is_ok_and(|it| it.len() > 200_000) {
        assert!(Instant::now() < until, "nothing is written");
        std::thread::sleep(Duration::from_millis(50));
    }
    // Rust's `kill` is SIGKILL
    process.kill().unwrap();
    process.wait().unwrap();
    let content = read(&python, &file);
    assert!(
        count(&content, "asm/ASMCoordinator/step") > 5,
        "{}",
        content["counts"]
    );
    assert_eq!(content["broken"], Value::Array(Vec::new()));
    assert_eq!(content["facts"]["asmotion.end"], Value::Null);
    let (read_steps, cut) = steps(&file);
    assert_eq!(read_steps, count(&content, "asm/ASMCoordinator/step"));
    assert!(cut.is_some());
}

#[test]
fn a_recording_on_a_full_disk_is_incomplete_and_the_mission_goes_on() {
    let Some(python) = python() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    // 3 MB, about a quarter of what this run writes; the signal would end the process
    let script = "trap '' XFSZ; ulimit -f 6000; exec \"$0\" run \"$1\" --record \"$2\"";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_asmotion")]);
    command.arg(navigation()).arg(&file);
    let (code, said) = output(&mut command);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("is INCOMPLETE"), "{said}");
    assert!(
        said.contains("messages are lost") && said.contains("cannot write"),
        "{said}"
    );
    let content = read(&python, &file);
    assert!(
        count(&content, "asm/ASMCoordinator/step") > 5,
        "{}",
        content["counts"]
    );
    assert_eq!(content["broken"], Value::Array(Vec::new()));
}

/// The composite of the navigation with a recording of its own.
pub(super) fn recorded(folder: &Path, record: &str) -> PathBuf {
    let base = navigation();
    let text = format!(
        "schema = \"composite/1\"\nbase = \"{}\"\n[deploy]\nrecord = {{ {record} }}\n",
        base.display()
    );
    let path = folder.join("recorded.composite.toml");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_composite_records_its_runs() {
    let Some(python) = python() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let files = |dir: &str| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder.path().join(dir))
            .into_iter()
            .flatten();
        let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        paths
    };
    let run = |record: &str| {
        let path = recorded(folder.path(), record);
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        let (code, said) = output(command.arg("run").arg(path));
        assert_eq!(code, Some(0), "{said}");
        assert!(said.contains("recording"), "{said}");
        said
    };
    run("dir = \"all\", rotate_mb = 1");
    let parts = files("all");
    assert!(parts.len() > 3, "{parts:?}");
    for part in &parts {
        let size = std::fs::metadata(part).unwrap().len();
        assert!(size < 3_000_000, "{size}: {parts:?}");
    }
    // each names the next one, so that a missing one is noticed
    let mut continues: Vec<_> = parts.iter().map(|part| end(part).continues).collect();
    continues.sort_unstable();
    let following = 2..=u32::try_from(parts.len()).unwrap();
    let expected: Vec<_> = [None].into_iter().chain(following.map(Some)).collect();
    assert_eq!(continues, expected);
    run("dir = \"some\", topics = [\"goal\"], calls = false, asm_states = false");
    let [file] = &*files("some") else {
        panic!("{:?}", files("some"));
    };
    let content = read(&python, file);
    let channels = content["counts"].as_object().unwrap().keys();
    let channels: Vec<_> = channels.map(String::as_str).collect();
    assert_eq!(
        channels,
        ["events", "queues", "topic/goal"],
        "{}",
        content["counts"]
    );
    // a topic that does not exist
    let path = recorded(folder.path(), "topics = [\"gaol\"]");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let (_, said) = output(command.arg("check").arg(path));
    assert!(said.contains("C073") && said.contains("`goal`"), "{said}");
    // the run goes on where nothing can be written
    std::fs::write(folder.path().join("taken"), "").unwrap();
    let said = run("dir = \"taken\"");
    assert!(said.contains("recording  none: cannot create"), "{said}");
}

#[test]
fn a_composite_records_its_runs_for_tools_of_ros_2() {
    let folder = tempfile::tempdir().unwrap();
    // the profile in the header of a file: after the magic number, and opcode and length of the first record
    let profile = |dir: &str, readers: &str| {
        let path = recorded(folder.path(), &format!("dir = \"{dir}\"{readers}"));
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        let (code, said) = output(command.arg("run").arg(path));
        assert_eq!(code, Some(0), "{said}");
        let mut files = std::fs::read_dir(folder.path().join(dir)).unwrap();
        let bytes = std::fs::read(files.next().unwrap().unwrap().path()).unwrap();
        let length = u32::from_le_bytes(bytes[17..21].try_into().unwrap()) as usize;
        String::from_utf8(bytes[21..21 + length].to_vec()).unwrap()
    };
    assert_eq!(profile("bags", ", for = \"ros2\""), "ros2");
    let usual = profile("usual", "");
    assert_ne!(usual, "ros2");
    assert_eq!(profile("views", ", for = \"viewers\""), usual);
    let path = recorded(folder.path(), "for = \"ros1\"");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let (_, said) = output(command.arg("check").arg(path));
    assert!(
        said.contains("`viewers`") && said.contains("`ros2`"),
        "{said}"
    );
}
