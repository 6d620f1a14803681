//! `asmotion verify --watch`: edits of specifications and of their imports, as editors make them.
#![cfg(unix)]

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

const LAMP: &str = "asm lamp
import StandardLibrary
import CTLLibrary
import Limits
signature:
  domain Level subsetof Integer
  monitored button: Boolean
  controlled level: Level
definitions:
  domain Level = {0 : 9}
  CTLSPEC goes_out: ag(ef(level = 0))
  CTLSPEC stays_low: ag(level <= limit)
  main rule r_Main = if button then level := (level + 1) mod (limit + 1) endif
default init s0:
  function level = 0
";

const LIMITS: &str = "module Limits
import StandardLibrary
export limit
signature:
  static limit: Integer
definitions:
  function limit = 2
";

/// Shown at the end of each verification.
const WATCHING: &str = "Watching";

/// A verification that is repeated when files change.
struct Watched {
    folder: tempfile::TempDir,
    child: Child,
}

impl Watched {
    /// Watches `lamp.asm` in a folder with these files.
    fn of(files: &[(&str, &str)]) -> Self {
        Self::with(files, &["verify", "lamp.asm", "--watch"])
    }

    /// Runs a command in a folder with these files.
    fn with(files: &[(&str, &str)], arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let log = std::fs::File::create(folder.path().join("log")).unwrap();
        let child = Command::new(env!("CARGO_BIN_EXE_asmotion"))
            .args(arguments)
            .current_dir(folder.path())
            .stdout(log.try_clone().unwrap())
            .stderr(Stdio::from(log))
            .spawn()
            .unwrap();
        Self { folder, child }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// Replaces a file by another one, as many editors do.
    fn replace(&self, name: &str, text: &str) {
        let new = self.path("new~");
        std::fs::write(&new, text).unwrap();
        std::fs::rename(new, self.path(name)).unwrap();
    }

    fn log(&self) -> String {
        std::fs::read_to_string(self.path("log")).unwrap()
    }

    /// Waits for the end of the verification with this number, and returns its output.
    fn verification(&self, number: usize) -> String {
        for _ in 0..600 {
            let log = self.log();
            let mut parts = log.split(WATCHING);
            if log.matches(WATCHING).count() >= number
                && let Some(part) = parts.nth(number - 1)
            {
                return part.to_owned();
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        panic!("no verification {number}: {}", self.log());
    }

    /// Waits so long that a change would have been noticed, and returns the number of verifications.
    fn verifications(&self) -> usize {
        std::thread::sleep(Duration::from_secs(2));
        self.log().matches(WATCHING).count()
    }

    /// Ends the watching with Ctrl-C; returns the exit code.
    fn end(mut self) -> Option<i32> {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args(["-INT", &id]).status().unwrap();
        assert!(sent.success());
        self.child.wait().unwrap().code()
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        // an error means that it has ended
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

const FILES: &[(&str, &str)] = &[("lamp.asm", LAMP), ("Limits.asm", LIMITS)];

const REUSED: &str = "only properties have changed";

#[test]
fn only_what_has_changed_is_explored_again() {
    let watched = Watched::of(FILES);
    let first = watched.verification(1);
    assert!(first.contains("holds     CTLSPEC stays_low"), "{first}");
    assert!(
        !first.contains(REUSED) && !first.contains("changed"),
        "{first}"
    );
    // a property
    let property = LAMP.replace("ag(level <= limit)", "ag(level < limit)");
    watched.write("lamp.asm", &property);
    let second = watched.verification(2);
    assert!(second.contains(REUSED), "{second}");
    assert!(
        second.contains("changed   new: violated, CTLSPEC stays_low: ag(level < limit)")
            && second.contains("changed   gone: CTLSPEC stays_low: ag(level <= limit)"),
        "{second}"
    );
    assert!(!second.contains("changed   new: holds"), "{second}");
    // a comment
    watched.write(
        "lamp.asm",
        &property.replace("main rule", "// nothing new\n  main rule"),
    );
    let third = watched.verification(3);
    assert!(third.contains("no verdict has changed"), "{third}");
    // a rule
    watched.write("lamp.asm", &property.replace("(limit + 1)", "limit"));
    let fourth = watched.verification(4);
    assert!(!fourth.contains(REUSED), "{fourth}");
    assert!(
        fourth.contains("changed   now holds (was violated): CTLSPEC stays_low"),
        "{fourth}"
    );
    assert_eq!(watched.end(), Some(0));
}

#[test]
fn an_editor_may_replace_the_file() {
    let watched = Watched::of(FILES);
    watched.verification(1);
    let changed = LAMP.replace("level + 1", "level + 2");
    watched.replace("lamp.asm", &changed);
    let second = watched.verification(2);
    assert!(second.contains("5 hold, 0 violated"), "{second}");
    // the new file is watched in turn, also if its length and time are those of the one before
    let path = watched.path("lamp.asm");
    let time = std::fs::metadata(&path).unwrap().modified().unwrap();
    let again = changed.replace("level + 2", "level + 9");
    let new = watched.path("new~");
    std::fs::write(&new, &again).unwrap();
    let file = std::fs::File::options().write(true).open(&new).unwrap();
    file.set_modified(time).unwrap();
    std::fs::rename(new, path).unwrap();
    let third = watched.verification(3);
    assert!(!third.contains(REUSED), "{third}");
}

#[test]
fn imports_are_watched_too() {
    let watched = Watched::of(FILES);
    assert!(watched.verification(1).contains("3 states"));
    watched.replace("Limits.asm", &LIMITS.replace("= 2", "= 4"));
    let second = watched.verification(2);
    assert!(second.contains("5 states"), "{second}");
    assert!(second.contains("no verdict has changed"), "{second}");
}

#[test]
fn a_mistake_in_an_import_is_corrected_there() {
    let watched = Watched::of(FILES);
    watched.verification(1);
    watched.write(
        "Limits.asm",
        &LIMITS.replace("function limit", "function limt"),
    );
    let second = watched.verification(2);
    assert!(
        second.contains("Limits.asm") && second.contains("error"),
        "{second}"
    );
    watched.write("Limits.asm", &LIMITS.replace("= 2", "= 3"));
    let third = watched.verification(3);
    assert!(third.contains("4 states"), "{third}");
    assert_eq!(watched.end(), Some(0));
}

#[test]
fn a_missing_import_is_noticed_when_it_appears() {
    let watched = Watched::of(&[("lamp.asm", LAMP)]);
    let first = watched.verification(1);
    assert!(
        first.contains("error") && first.contains("Limits"),
        "{first}"
    );
    watched.write("Limits.asm", LIMITS);
    let second = watched.verification(2);
    assert!(second.contains("holds     CTLSPEC stays_low"), "{second}");
}

#[test]
fn a_file_may_disappear_for_a_moment() {
    let watched = Watched::of(FILES);
    watched.verification(1);
    for name in ["lamp.asm", "Limits.asm"] {
        let aside = watched.path("aside~");
        std::fs::rename(watched.path(name), &aside).unwrap();
        std::thread::sleep(Duration::from_millis(500));
        std::fs::rename(&aside, watched.path(name)).unwrap();
        // it is as it was
        assert_eq!(watched.verifications(), 1);
    }
    let aside = watched.path("aside~");
    std::fs::rename(watched.path("Limits.asm"), &aside).unwrap();
    std::thread::sleep(Duration::from_millis(500));
    watched.write("Limits.asm", &LIMITS.replace("= 2", "= 3"));
    let second = watched.verification(2);
    assert!(second.contains("4 states"), "{second}");
    // one that stays away is an error, until it is there again
    std::fs::remove_file(watched.path("lamp.asm")).unwrap();
    let gone = watched.verification(3);
    assert!(gone.contains("file not found"), "{gone}");
    watched.write("lamp.asm", LAMP);
    let back = watched.verification(4);
    assert!(back.contains("no verdict has changed"), "{back}");
    assert_eq!(watched.end(), Some(0));
}

const MAPS: &str = "asm maps
import CTLLibrary
import StandardLibrary
signature:
  enum domain Mode = {ASKING | READY}
  enum domain Answer = {NOTHING | FOUND | LOST}
  enum domain Order = {REST | ASK}
  monitored answer: Answer
  out order: Order
  controlled mode: Mode
definitions:
  CTLSPEC gets_it: ef(mode = READY)
  main rule r_Main =
    switch mode
      case ASKING: if answer = FOUND then mode := READY else order := ASK endif
      case READY: order := REST
    endswitch
default init s0:
  function mode = ASKING
  function order = REST
";

const MAPS_COMPOSITE: &str = "schema = \"composite/1\"
[composite]
name = \"maps\"
[components.Coordinator]
implementation = { asm = \"maps.asm\" }
activity = { period_ms = 100 }
references = { maps = \"nav/MapService\" }
[components.Coordinator.bind.out.order]
ASK = { call = \"maps.getMap\", with = { name = \"office\" }, ok = \"FOUND\", failed = \"LOST\", event = \"answer\" }
[components.Lamp]
implementation = { asm = \"lamp.asm\" }
activity = { period_ms = 100 }
[components.Server]
implementation = { rust = \"nav::MapServer\" }
activity = { period_ms = 100 }
services = { maps = \"nav/MapService\" }
properties = { source = \"office=office.yaml\" }
[[wires]]
reference = \"Coordinator.maps\"
service = \"Server.maps\"
timeout_ms = 500
";

const MAPS_FILE: &str = "maps.composite.toml";

/// Each component keeps its own states and verdicts; the composite is watched as its specifications are.
#[test]
fn the_files_of_a_composite_are_watched() {
    // without an input, to which no connection leads
    let lamp = LAMP
        .replace("if button then ", "")
        .replace(" endif", "")
        .replace("  monitored button: Boolean\n", "");
    let specification = "maps.asm";
    let files = [
        (MAPS_FILE, MAPS_COMPOSITE),
        (specification, MAPS),
        ("lamp.asm", &lamp),
        ("Limits.asm", LIMITS),
    ];
    let watched = Watched::with(&files, &["verify", MAPS_FILE, "--watch"]);
    let first = watched.verification(1);
    assert!(first.contains("holds     CTLSPEC gets_it"), "{first}");
    assert!(first.contains("holds     CTLSPEC stays_low"), "{first}");
    // a property of one component
    let asked = MAPS.replace("ef(mode = READY)", "ag(mode = ASKING)");
    watched.replace(specification, &asked);
    let second = watched.verification(2);
    assert_eq!(second.matches(REUSED).count(), 2, "{second}");
    assert!(
        second.contains("changed   new: violated, CTLSPEC gets_it: ag(mode = ASKING)"),
        "{second}"
    );
    assert!(second.contains("no verdict has changed"), "{second}");
    // the binding of its input, in the composite
    let lost = MAPS_COMPOSITE.replace("ok = \"FOUND\"", "ok = \"LOST\"");
    watched.write(MAPS_FILE, &lost);
    let third = watched.verification(3);
    assert_eq!(third.matches(REUSED).count(), 1, "{third}");
    assert!(
        third.contains("changed   now holds (was violated): CTLSPEC gets_it: ag(mode = ASKING)"),
        "{third}"
    );
    // a mistake in it
    watched.write(MAPS_FILE, &lost.replace("ok = ", "okay = "));
    let wrong = watched.verification(4);
    assert!(wrong.contains("okay"), "{wrong}");
    watched.write(MAPS_FILE, MAPS_COMPOSITE);
    let fifth = watched.verification(5);
    assert!(
        fifth.contains("changed   now violated (was holds): CTLSPEC gets_it: ag(mode = ASKING)"),
        "{fifth}"
    );
    // a file that only one of them imports
    watched.replace("Limits.asm", &LIMITS.replace("= 2", "= 4"));
    let sixth = watched.verification(6);
    assert_eq!(sixth.matches(REUSED).count(), 1, "{sixth}");
    assert!(sixth.contains("5 states"), "{sixth}");
    assert_eq!(watched.end(), Some(1));
}

/// Two lamps as machines of one system, which import one file.
#[test]
fn specifications_that_are_verified_together_are_watched() {
    let other = LAMP.replace("asm lamp", "asm light");
    let files = [
        ("lamp.asm", LAMP),
        ("light.asm", &other),
        ("Limits.asm", LIMITS),
    ];
    let together = ["verify", "--together", "lamp.asm", "light.asm", "--watch"];
    let watched = Watched::with(&files, &together);
    let first = watched.verification(1);
    assert!(first.contains("9 states"), "{first}");
    watched.replace("light.asm", &other.replace("level + 1", "level + 2"));
    let second = watched.verification(2);
    assert!(second.contains("no verdict has changed"), "{second}");
    watched.replace("Limits.asm", &LIMITS.replace("= 2", "= 3"));
    let third = watched.verification(3);
    assert!(third.contains("8 states"), "{third}");
    assert_eq!(watched.end(), Some(0));
}
