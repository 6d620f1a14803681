//! `asmotion verify --itf`, read by another program: the Python package `itf-py`.

use super::{file, run};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The package with its version.
const PACKAGE: &str = "itf-py==0.5.0";

const SPEC: &str = "asm shelf
import StandardLibrary
import CTLLibrary
signature:
  enum domain Box = {RED | BLUE}
  domain Place subsetof Integer
  monitored moves: Boolean
  monitored weight: Real
  controlled at: Box -> Place
  controlled holds: Prod(Place, Box) -> Boolean
  controlled last: Prod(Box, Integer)
  controlled log: Seq(Box)
  controlled seen: Powerset(Place)
  controlled groups: Powerset(Powerset(Place))
  controlled names: Map(Place, String)
  controlled counts: Bag(Box)
  controlled ratio: Real
  controlled note: String
  controlled nothing: Integer
  controlled isHeavy: Boolean
definitions:
  domain Place = {0:2}
  invariant never over at: at(RED) < 2
  main rule r_Main =
    if moves and at(RED) < 2 then par
      at(RED) := at(RED) + 1
      holds(at(RED), RED) := true
      last := (RED, at(RED))
      log := append(log, RED)
      seen := including(seen, at(RED))
      groups := including(groups, seen)
      names := {at(RED) -> \"a \\\"quoted\\\" name\"}
      counts := <RED, RED, BLUE>
      ratio := ratio / 2.0
      note := \"moved\"
      isHeavy := weight > 2.5
    endpar endif
default init s0:
  function at($b in Box) = 0
  function log = []
  function seen = {}
  function groups = {}
  function ratio = 1.0
";

/// Prints the values of the last state, and whether the trace is the same after it was written again.
const READER: &str = "
import json, sys, itf_py
data = json.load(open(sys.argv[1]))
trace = itf_py.trace_from_json(data)
for name, value in sorted(trace.states[-1].values.items()):
    print(name, '=', value)
again = itf_py.trace_to_json(trace)
def plain(value):
    if isinstance(value, dict):
        if '#set' in value or '#map' in value:
            (key, items), = value.items()
            return {key: sorted((plain(item) for item in items), key=str)}
        return {key: plain(item) for key, item in value.items() if key != '#meta'}
    if isinstance(value, list):
        return [plain(item) for item in value]
    return value
print('same' if plain(again['states']) == plain(data['states']) else 'different')
print('variables', trace.vars == sorted(trace.states[0].values), 'loop', trace.loop, 'states', len(trace.states))
";

/// Returns a Python with the package in `target/itf`, installed if it is missing.
fn python() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/itf/venv");
    let python = folder.join("bin/python");
    let has_package = || {
        let tried = Command::new(&python).args(["-c", "import itf_py"]).output();
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
        pip.args(["-m", "pip", "install", "--quiet", PACKAGE]);
        let _ = pip.output();
    }
    if has_package() {
        return Some(python);
    }
    asmotion_skip::PYPI.skip();
    None
}

#[test]
fn an_independent_reader_reads_values_of_every_kind() {
    let Some(python) = python() else {
        return;
    };
    let (_folder, spec) = file("shelf.asm", SPEC);
    let (_trace_folder, trace) = file("run.itf.json", "");
    let (exit, out, err) = run(&["verify", &spec, "--itf", &trace]);
    assert_eq!(exit, 1, "{out}{err}");
    let read = |trace: &str| {
        let output = Command::new(&python)
            .args(["-c", READER, trace])
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
        String::from_utf8(output.stdout).unwrap()
    };
    insta::assert_snapshot!("itf_read", read(&trace));
    // a run with a cycle, and functions with arguments
    let lamp = "asm-lang/verify/tests/models/lamp.asm";
    let (exit, _, err) = run(&["verify", lamp, "--property", "darkens", "--itf", &trace]);
    assert_eq!(exit, 1, "{err}");
    insta::assert_snapshot!("itf_read_cycle", read(&trace));
}
