//! `asmotion verify` with `--storage`, `--threads`, `--symmetry` and `--cone`, in combination, interrupted, and on full disks.

use super::{file, run};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A state space that is explored in no reasonable time, or, with a small limit, in a moment.
fn two_counters(limit: u32) -> String {
    format!(
        "asm counters
import StandardLibrary
import CTLLibrary
signature:
  domain Count subsetof Integer
  controlled a: Count
  controlled b: Count
  monitored up: Boolean
definitions:
  domain Count = {{0 : {limit}}}
  invariant inv_small over a: a < 3
  CTLSPEC af(a = 5)
  main rule r_Main = if up then a := (a + 1) mod {limit} else b := (b + 1) mod {limit} endif
default init s0:
  function a = 0
  function b = 0
"
    )
}

/// Agents that are used alike, and a counter on which no property depends.
const CRANES: &str = "asm cranes
import StandardLibrary
import CTLLibrary
signature:
  domain Crane subsetof Integer
  enum domain Phase = {REST | LIFT | MOVE}
  domain Count subsetof Integer
  controlled phase: Crane -> Phase
  controlled loads: Count
definitions:
  domain Crane = {0:3}
  domain Count = {0:9}
  CTLSPEC alike: ag(not (forall $c in Crane with phase($c) = MOVE))
  rule r_move($c in Crane) =
    switch phase($c)
      case REST: phase($c) := LIFT
      case LIFT: if (forall $o in Crane with phase($o) != MOVE) then phase($c) := MOVE endif
      case MOVE: par phase($c) := REST loads := (loads + 1) mod 10 endpar
    endswitch
  main rule r_Main = choose $c in Crane with true do r_move[$c]
default init s0:
  function phase($c in Crane) = REST
  function loads = 0
";

/// Removes the time of a verification, which differs from run to run.
fn without_time(text: &str) -> String {
    let lines = text.lines().map(|line| match line.rsplit_once(" deep, ") {
        Some((start, _)) => format!("{start} deep\n"),
        None => format!("{line}\n"),
    });
    lines.collect()
}

/// The numbers of states and transitions that an output contains.
fn size(output: &str) -> &str {
    let line = output.lines().find(|line| line.contains(" deep, "));
    let sizes = line.and_then(|line| line.split_once("not known: "));
    sizes
        .and_then(|(_, sizes)| sizes.split_once(" transitions"))
        .unwrap_or_else(|| panic!("{output}"))
        .0
}

#[test]
fn results_depend_neither_on_threads_nor_on_the_storage() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().display().to_string();
    let (_file, cranes) = file("cranes.asm", CRANES);
    for (specification, extra) in [
        (cranes.as_str(), [].as_slice()),
        (cranes.as_str(), ["--symmetry"].as_slice()),
        (
            cranes.as_str(),
            ["--cone", "--property", "alike"].as_slice(),
        ),
        ("specs/allocation/allocation.asm", [].as_slice()),
        // in an environment, steps are executed by machines
        (
            "specs/recovery/recovery.asm",
            ["--environment", "hold"].as_slice(),
        ),
        (
            "asm-lang/verify/tests/models/philosophers.asm",
            [].as_slice(),
        ),
    ] {
        let plain = [["verify", specification].as_slice(), extra].concat();
        let (exit, expected, _) = run(&plain);
        for threads in ["1", "2", "3"] {
            for storage in [
                ["--storage", "exact"].as_slice(),
                ["--storage", "disk", "--storage-folder", &path].as_slice(),
            ] {
                let all = [plain.as_slice(), &["--threads", threads], storage].concat();
                let (code, out, err) = run(&all);
                assert_eq!(code, exit, "{all:?}: {err}");
                assert_eq!(without_time(&out), without_time(&expected), "{all:?}");
            }
        }
    }
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

#[test]
fn symmetry_and_cones_leave_states_out() {
    let (_file, cranes) = file("cranes.asm", CRANES);
    let found = |extra: &[&str]| {
        let (exit, out, err) = run(&[["verify", &cranes].as_slice(), extra].concat());
        assert_eq!(exit, 0, "{out}{err}");
        size(&out).split(' ').next().unwrap_or_default().to_owned()
    };
    // states of the cranes: each rests or lifts, or one moves: 2^4 + 4 * 2^3, and 5 + 4 that do not tell them apart
    assert_eq!(found(&[]), "480");
    assert_eq!(found(&["--symmetry"]), "90");
    assert_eq!(found(&["--cone", "--property", "alike"]), "48");
    assert_eq!(found(&["--cone", "--symmetry", "--property", "alike"]), "9");
}

/// Starts a verification with its output in a file.
fn started(arguments: &[&str], log: &std::path::Path) -> Child {
    Command::new(env!("CARGO_BIN_EXE_asmotion"))
        .args(arguments)
        .stdout(std::fs::File::create(log).unwrap())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

fn interrupt(child: &Child) {
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
}

#[test]
fn an_interrupted_verification_reports_what_is_known_in_every_storage() {
    let (folder, path) = file("counters.asm", two_counters(3_000_000));
    let spilled = tempfile::tempdir().unwrap();
    let spilled_path = spilled.path().display().to_string();
    for (name, storage) in [
        ("exact", [].as_slice()),
        ("compact", ["--storage", "compact"].as_slice()),
        (
            "disk",
            ["--storage", "disk", "--storage-folder", &spilled_path].as_slice(),
        ),
    ] {
        for threads in ["1", "2"] {
            let log = folder.path().join("out.txt");
            let all = [["verify", &path, "--threads", threads].as_slice(), storage].concat();
            let child = started(&all, &log);
            // a handler that is not installed yet would end the process, whose exit code then differs
            std::thread::sleep(Duration::from_secs(2));
            interrupt(&child);
            let mut child = child;
            let code = child.wait().unwrap().code();
            let out = std::fs::read_to_string(&log).unwrap();
            assert_eq!(code, Some(1), "{name} {threads}: {out}");
            assert!(out.contains("violated  invariant inv_small"), "{out}");
            assert!(out.contains("unknown   CTLSPEC af(a = 5)"), "{out}");
            let reason = "not all states were explored: it was interrupted";
            assert!(out.contains(reason), "{out}");
        }
    }
    assert_eq!(spilled.path().read_dir().unwrap().count(), 0);
}

/// Runs a verification by a shell, which prepares something before. Returns the exit code and both outputs.
fn by_shell(preparation: &str, shell: &[&str], arguments: &[&str]) -> (Option<i32>, String) {
    let [program, options @ ..] = shell else {
        panic!("a shell");
    };
    let output = Command::new(program)
        .args(options)
        .args(["-c", &format!("{preparation} && exec \"$@\""), "bash"])
        .arg(env!("CARGO_BIN_EXE_asmotion"))
        .args(arguments)
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(text).unwrap())
}

fn is_refused(found: &(Option<i32>, String), reason: &str) {
    let (code, out) = found;
    assert_eq!(*code, Some(1), "{out}");
    let message = "error[M013]: the states that were found cannot be stored: a file in";
    assert!(out.contains(message) && out.contains(reason), "{out}");
    assert!(out.contains("help: provide more space"), "{out}");
    for verdict in ["holds", "violated", "unknown"] {
        assert!(!out.contains(verdict), "{out}");
    }
}

#[test]
fn a_full_disk_and_a_limit_for_files_give_no_verdict() {
    let (_file, path) = file("counters.asm", two_counters(300));
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().display().to_string();
    let disk = ["--storage", "disk", "--storage-folder", &folder];
    for threads in ["1", "2"] {
        let all = [["verify", &path, "--threads", threads].as_slice(), &disk].concat();
        // the property is violated in a state that is found before the limit is reached, but no verdict is given
        let found = by_shell("trap '' XFSZ && ulimit -f 64", &["bash"], &all);
        is_refused(&found, "File too large");
        // unless it is ignored, the signal of the limit ends the process, which has reported nothing
        let (code, out) = by_shell("ulimit -c 0 && ulimit -f 64", &["bash"], &all);
        assert_eq!((code, out.contains("holds")), (None, false), "{out}");

        let mounted = format!("mount -t tmpfs -o size=100k tmpfs {folder}");
        let namespace = ["unshare", "-rm", "bash"];
        let possible = Command::new("unshare")
            .args(["-rm", "bash", "-c", &mounted])
            .output();
        if possible.is_ok_and(|output| output.status.success()) {
            is_refused(
                &by_shell(&mounted, &namespace, &all),
                "No space left on device",
            );
        } else {
            eprintln!("*** SKIPPED: no file system can be mounted in a namespace of its own");
        }
    }
    // with enough space there are verdicts
    let (exit, out, _) = run(&[["verify", &path].as_slice(), &disk].concat());
    assert_eq!((exit, size(&out)), (1, "90,000 states, 180,001"), "{out}");
}

/// Waits until a file contains a text so many times.
fn shows(log: &std::path::Path, wanted: &str, times: usize) -> String {
    for _ in 0..600 {
        let text = std::fs::read_to_string(log).unwrap();
        if text.matches(wanted).count() >= times {
            return text;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    let text = std::fs::read_to_string(log).unwrap();
    panic!("{wanted} is missing: {text}");
}

#[test]
fn a_watched_specification_is_explored_with_symmetry_or_in_a_cone() {
    let cone = ["--cone", "--property", "alike"].as_slice();
    for (options, states) in [
        (["--symmetry"].as_slice(), "90 states"),
        (cone, "48 states"),
        (
            ["--symmetry", "--threads", "2", "--storage", "disk"].as_slice(),
            "90 states",
        ),
    ] {
        let (folder, path) = file("cranes.asm", CRANES);
        let log = folder.path().join("out.txt");
        let mut child = started(
            &[["verify", &path, "--watch"].as_slice(), options].concat(),
            &log,
        );
        shows(&log, states, 1);
        // now it does not hold: what stands for other states, or leaves locations out, is explored again
        let changed = CRANES
            .replace("ag(not (forall", "ag((exist")
            .replace("= MOVE))", "= REST))");
        assert_ne!(changed, CRANES);
        std::fs::write(&path, &changed).unwrap();
        let out = shows(&log, "changed   new: violated", 1);
        assert!(!out.contains("only properties have changed"), "{out}");
        std::fs::write(&path, CRANES).unwrap();
        let out = shows(&log, "changed   new: holds", 1);
        if options == cone {
            // the states of the whole specification, which the run needed, are known
            assert!(out.contains("only properties have changed"), "{out}");
            assert_eq!(out.matches("480 states").count(), 2, "{out}");
        } else {
            assert_eq!(out.matches(states).count(), 3, "{out}");
        }
        interrupt(&child);
        assert_eq!(child.wait().unwrap().code(), Some(0));
    }
}
