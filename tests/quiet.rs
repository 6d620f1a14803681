//! Quiet runs, in which most steps do not become text: they end, count and record as any other run does.

use std::path::Path;
use std::process::Command;

/// A specification with a control state that is written with its old value, too.
const PHASES: &str = "asm phases
import StandardLibrary
signature:
	enum domain Mode = {IDLE | RUN | END}
	controlled mode: Mode
	controlled n: Integer
	controlled even: Boolean
definitions:
	main rule r_Main = par
		n := n + 1
		even := not even
		if n = 2 or n = 4 then mode := RUN endif
		if n = 7 then mode := END endif
	endpar
default init s0:
	function mode = IDLE
	function n = 0
	function even = true
";

/// Agents with a control state each, of which one is written with its initial value.
const AGENTS: &str = "asm phases
import StandardLibrary
signature:
	domain Robot subsetof Integer
	enum domain Mode = {IDLE | RUN | END}
	controlled mode: Robot -> Mode
	controlled n: Integer
definitions:
	domain Robot = {1 : 3}
	main rule r_Main = par
		n := n + 1
		if n = 3 then mode(1) := IDLE endif
		if n = 5 then forall $r in Robot with $r > 1 do mode($r) := RUN endif
	endpar
default init s0:
	function mode($r in Robot) = IDLE
	function n = 0
";

const COMPOSITE: &str = "schema = \"composite/1\"
[composite]
name = \"phases\"
[components.Phases]
for = \"$n in 1..2\"
implementation = { asm = \"phases.asm\" }
task.period_ms = 100
";

/// What a run prints on standard output and on standard error, without its wall-clock time.
fn run(folder: &Path, specification: &str, arguments: &[&str]) -> (String, String) {
    std::fs::write(folder.join("phases.asm"), specification).unwrap();
    std::fs::write(folder.join("phases.composite.toml"), COMPOSITE).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.current_dir(folder);
    command.args(["run", "phases.composite.toml"]);
    let output = command.args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| {
        let text = String::from_utf8(bytes).unwrap();
        let lines = text.lines().filter(|it| !it.contains("wall"));
        lines.map(|it| format!("{it}\n")).collect::<String>()
    };
    (text(output.stdout), text(output.stderr))
}

#[test]
fn a_quiet_run_ends_and_counts_as_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let ends: &[&[&str]] = &[
        &["--for", "1"],
        &["--until", "mode=END"],
        &["--until", "mode=RUN"],
        // not a control state: all steps have to be read
        &["--until", "n=4"],
        &["--for", "1", "--unless", "mode=END"],
        &["--until", "n=100", "--unless", "mode=RUN", "--for", "1"],
    ];
    let begun = PHASES.replace("function mode = IDLE", "function mode = RUN");
    // awaited from the beginning, and written again with the value that it has
    let of_agents: &[&[&str]] = &[
        &["--until", "mode(1)=IDLE"],
        &["--until", "mode(2)=RUN"],
        &["--until", "mode(3)=END", "--for", "1"],
    ];
    let cases = [(PHASES, ends), (&begun, ends), (AGENTS, of_agents)];
    for (specification, all) in cases {
        for arguments in all {
            let (told, story) = run(folder.path(), specification, arguments);
            let quiet = [&["-q"], *arguments].concat();
            let (summary, nothing) = run(folder.path(), specification, &quiet);
            assert_eq!(summary, told, "{arguments:?}");
            assert!(told.contains("with updates"), "{arguments:?}: {told}");
            assert!(story.contains("step "), "{arguments:?}: {story}");
            assert!(!nothing.contains("step"), "{arguments:?}: {nothing}");
            assert!(!nothing.contains(":="), "{arguments:?}: {nothing}");
        }
    }
}

#[test]
fn a_quiet_run_is_traced_and_recorded_as_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let traced = |name, quiet: &[&str]| {
        let arguments = [&["--for", "1", "--trace", name], quiet].concat();
        run(folder.path(), PHASES, &arguments);
        read(name)
    };
    let trace = traced("told.trace", &[]);
    assert!(trace.len() > 1000, "{}", trace.len());
    assert!(trace == traced("quiet.trace", &["-q"]));
    // repeats each step from its causes, and compares hashes of states
    let replayed = |name, quiet: &[&str]| {
        let arguments = [&["--for", "1", "--record", name], quiet].concat();
        run(folder.path(), PHASES, &arguments);
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.current_dir(folder.path());
        let output = command.args(["replay", name, "--json"]).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let text = String::from_utf8(output.stdout).unwrap();
        let mut summary: serde_json::Value =
            serde_json::from_str(text.lines().last().unwrap()).unwrap();
        let summary = summary.as_object_mut().unwrap();
        summary.retain(|key, _| !["speed", "wall_s"].contains(&&**key));
        serde_json::Value::from(summary.clone())
    };
    let told = replayed("told.mcap", &[]);
    assert_eq!(
        (&told["result"], &told["steps"]),
        (&"equal".into(), &21.into())
    );
    assert_eq!(replayed("quiet.mcap", &["-q"]), told);
}

#[test]
fn a_quiet_run_counts_messages_calls_and_ways_as_any_other() {
    let composite = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation");
    let summary = |quiet: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.current_dir(&composite);
        command.args(["run", "navigation.composite.toml"]);
        let output = command.args(quiet).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let told = summary(&[]);
    let counted = [
        "27.2 m",
        "0.05 m from the goal",
        "goal ×1, event REACHED ×1",
        "planner.plan ×1; 0 failed",
    ];
    assert!(counted.iter().all(|it| told.contains(it)), "{told}");
    assert_eq!(summary(&["-q"]), told);
}
