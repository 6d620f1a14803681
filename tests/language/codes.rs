//! The pages of the codes: every code has one, its wrong example produces the code, the corrected one does not, and a
//! snapshot shows the rendered finding.

use super::said;
use asmotion::codes::all;
use asmotion_diagnostics::Code;
use asmotion_lang::scenario::ScenarioSettings;
use asmotion_lang::simulate::scenario::ScenarioOptions;
use asmotion_lang::simulate::{Causes, Random, Script, Simulation, SimulationError};
use asmotion_lang::{MemoryFiles, OpenFailure, Report, Sources, Style, render_all};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Codes without a self-contained example: they concern files, limits and inputs outside of specifications.
const WITHOUT_EXAMPLE: &[&str] = &[
    "A012", "A013", "L063", "S000", "V010", "V017", "V018", "V019", "V022", "V023", "V030", "V031",
];

/// A file that is not listed is not compiled, and a code that is listed twice has two meanings.
#[test]
fn have_a_file_each() {
    let mut files = Vec::new();
    for folder in ["asm-lang", "engine", "src"] {
        each_file(&root().join(folder), &mut |path| {
            let folder = path.parent().and_then(Path::file_name);
            if folder.is_some_and(|folder| folder == "codes")
                && path.extension() == Some("rs".as_ref())
            {
                files.push(path.file_stem().unwrap().to_str().unwrap().to_uppercase());
            }
        });
    }
    files.sort();
    let mut names: Vec<_> = all().map(|code| code.name.to_owned()).collect();
    names.sort();
    assert_eq!(files, names);
}

#[test]
fn have_a_title_that_fits_a_line() {
    for code in all() {
        let is_title = code.title.len() < 80 && !code.title.ends_with('.');
        assert!(
            is_title && !code.text.trim().is_empty(),
            "{code}: {}",
            code.title
        );
    }
}
#[test]
fn have_examples_that_are_true() {
    let mut wrong = String::new();
    for code in asmotion_lang::codes::all().chain(asmotion::codes::CODES.iter().copied()) {
        let examples = (example(code, "wrong"), example(code, "corrected"));
        let (Some(before), Some(after)) = examples else {
            let excused = WITHOUT_EXAMPLE.contains(&code.name);
            assert!(excused, "{} has no example", code.name);
            continue;
        };
        if !before.contains(code.name) {
            wrong.push_str(&format!(
                "{}: the wrong example earns {before:?}\n",
                code.name
            ));
        }
        // a well-formed module has nothing to run
        let is_wrong = |code: &String| !code.starts_with('W') && code != "R015";
        if after.contains(code.name) || after.iter().any(is_wrong) {
            wrong.push_str(&format!(
                "{}: the corrected example earns {after:?}\n",
                code.name
            ));
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// The codes found in an example, which may be a script or a trace that has no snapshots elsewhere.
fn example(code: &Code, which: &str) -> Option<BTreeSet<String>> {
    let (found, rendered) = if let Some(text) = code.example(&format!("asm {which}")) {
        let (found, _) = said("example", text);
        return Some(found.iter().map(|(_, code)| (*code).to_owned()).collect());
    } else if let Some(text) = code.example(&format!("asm random {which}")) {
        of_random(text)
    } else if let Some(mission) = code.example(&format!("toml mission {which}")) {
        of_mission(mission)
    } else if let Some(script) = code.example(&format!("toml {which}")) {
        of_script(code.example("asm")?, script)
    } else {
        let scenario = code.example(&format!("avalla {which}"))?;
        of_scenario(code.example("asm")?, scenario)
    };
    if which == "wrong" {
        snapshot(code.name, &rendered);
    }
    Some(found)
}

/// The specification and the composite of the examples of missions.
const ROBOT: &str = "asm robot
import StandardLibrary
signature:
    enum domain Mode = {IDLE | BUSY}
    monitored start: Boolean
    controlled mode: Mode
definitions:
    //@Final BUSY
    main rule r_Main = if start then mode := BUSY endif
default init s0:
    function mode = IDLE
";
const ROBOT_COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "robot"
[components.Robot]
implementation = { asm = "robot.asm" }
task = { id = "robot", period_ms = 100 }
subscribe = { start = "std_msgs/Bool" }
[components.Robot.bind.monitored]
start = { topic = "start", receive = "last", field = "data", none = false }
"#;

/// Runs a mission with the program.
fn of_mission(mission: &str) -> (BTreeSet<String>, String) {
    let folder = tempfile::tempdir().unwrap();
    for (file, text) in [
        ("robot.asm", ROBOT),
        ("robot.composite.toml", ROBOT_COMPOSITE),
        ("robot.mission.toml", mission),
    ] {
        std::fs::write(folder.path().join(file), text).unwrap();
    }
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let command = command.args(["test", "robot.mission.toml"]);
    let output = command.current_dir(folder.path()).output().unwrap();
    let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    let lines: Vec<&str> = text.lines().filter(|it| !it.contains("Tested")).collect();
    let codes = lines.iter().filter_map(|line| {
        let (_, rest) = line.split_once('[')?;
        let code = rest.split(']').next()?;
        let is_code = code.len() == 4 && code[1..].bytes().all(|it| it.is_ascii_digit());
        is_code.then(|| code.to_owned())
    });
    (codes.collect(), lines.join("\n"))
}

/// Simulates a specification with random inputs.
fn of_random(text: &str) -> (BTreeSet<String>, String) {
    let specification = super::opened("example", text);
    let machine = specification.machine().unwrap();
    let inputs = Random::new(specification.program.clone(), &machine, 1);
    let mut simulation = Simulation::new(machine, Causes::Random(Box::new(inputs)), 1);
    let mut report = Report::new();
    for _ in 0..10 {
        if let Err(SimulationError::Fault(fault)) = simulation.step() {
            report.push(specification.explain_in(&fault, simulation.machine()));
            break;
        }
    }
    shown(&report, &specification.sources)
}

fn of_script(specification: &str, script: &str) -> (BTreeSet<String>, String) {
    let mut specification = super::opened("example", specification);
    let file = specification.sources.add("inputs.toml", script);
    let report = match Script::read(file, script, &specification.program) {
        Ok(_) => Report::new(),
        Err(report) => report,
    };
    shown(&report, &specification.sources)
}

fn of_scenario(specification: &str, scenario: &str) -> (BTreeSet<String>, String) {
    let mut files = MemoryFiles::new();
    files.add("example.asm", specification);
    files.add("example.avalla", scenario);
    let options = ScenarioOptions {
        max_steps: 100,
        ..ScenarioOptions::default()
    };
    let settings = ScenarioSettings {
        options,
        ..ScenarioSettings::default()
    };
    let tested = asmotion_lang::scenario::test("example.avalla", &files, &settings);
    match tested {
        Ok(tested) => shown(&tested.report, &tested.specification.sources),
        Err(failure) => shown(&failure.report, &failure.sources),
    }
}

fn shown(report: &Report, sources: &Sources) -> (BTreeSet<String>, String) {
    let findings = &report.diagnostics;
    let codes = findings.iter().map(|finding| finding.code.to_string());
    (codes.collect(), render_all(report, sources, Style::Plain))
}

/// Findings about texts that are too large for a page, or missing.
#[test]
fn are_rendered_for_limits_and_missing_files() {
    let block = |index: usize, inside: &str| format!("begin b{index}\n{inside}end\n");
    let nested = (0..65).fold("step\n".to_owned(), |inside, index| block(index, &inside));
    let chain = |length: usize, calls: usize| -> String {
        let call = |index: usize| format!("execblock b{};\n", index + 1).repeat(calls);
        let blocks = (0..length).map(|index| block(index, &call(index)));
        let last = block(length, "step\n");
        blocks.collect::<String>() + &last + "execblock b0;\n"
    };
    let until = "step until false;\n".to_owned();
    for (code, commands) in [
        ("V010", nested),
        ("V017", chain(20, 2)),
        ("V019", chain(100, 1)),
        ("V022", until),
    ] {
        let specification = "asm example\nsignature:\ndefinitions:\n  main rule r_Main = skip\n";
        let scenario = format!("scenario example\nload example.asm\n{commands}");
        let (found, rendered) = of_scenario(specification, &scenario);
        assert!(found.contains(code), "{code}: {rendered}");
        snapshot(code, &rendered);
    }
    let (found, rendered) = failed(asmotion_lang::open("nowhere.asm", &MemoryFiles::new()));
    assert!(found.contains("A013"), "{rendered}");
    snapshot("A013", &rendered);
    let mut files = MemoryFiles::new();
    for index in 0..100 {
        let next = index + 1;
        let text = format!("module m{index}\nimport m{next}\nexport *\nsignature:\ndefinitions:\n");
        files.add(&format!("m{index}.asm"), text);
    }
    let (found, rendered) = failed(asmotion_lang::open("m0.asm", &files));
    assert!(found.contains("A012"), "{rendered}");
    snapshot("A012", &rendered);
}

fn failed<T>(opened: Result<T, OpenFailure>) -> (BTreeSet<String>, String) {
    match opened {
        Ok(_) => (BTreeSet::new(), String::new()),
        Err(failure) => shown(&failure.report, &failure.sources),
    }
}

fn snapshot(code: &str, rendered: &str) {
    insta::with_settings!({
        snapshot_path => "codes",
        prepend_module_to_snapshot => false,
        omit_expression => true,
    }, { insta::assert_snapshot!(code, rendered); });
}

/// Every code in the sources is rendered in a snapshot.
#[test]
fn are_seen_in_a_snapshot_each() {
    let mut shown = String::new();
    let folders = ["tests", "asm-lang", "engine"];
    for folder in folders {
        each_file(&root().join(folder), &mut |path| {
            if path.extension().is_some_and(|end| end == "snap") {
                shown.push_str(&std::fs::read_to_string(path).unwrap());
            }
        });
    }
    let names = all().map(|code| code.name);
    let unseen: Vec<&str> = names.filter(|name| !shown.contains(name)).collect();
    assert_eq!(unseen, Vec::<&str>::new());
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

fn each_file(folder: &Path, see: &mut dyn FnMut(&Path)) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            each_file(&path, see)
        } else {
            see(&path)
        }
    }
}
