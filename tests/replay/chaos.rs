//! Replays of missions with random faults: components fail, stop and start again, the coordinator among them.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use asmotion::mission::{Director, Mission, MissionOutcome, RecordingRequest};
use asmotion_component::{Fault, State, Time, Transition};
use asmotion_datum::Datum;
use asmotion_lang::Report;
use asmotion_plan::Plan;
use asmotion_runtime::Run;

use super::{asmotion, replay, text};

/// Number of missions, unless `ASMOTION_REPLAY_MISSIONS` is another one.
const MISSIONS: u64 = 16;

/// Causes random faults, by a seed.
struct Chaos {
    /// State of a generator of random numbers (Marsaglia's xorshift).
    random: u64,
    next: Time,
    components: Vec<String>,
    /// Boolean topics to write to.
    topics: &'static [&'static str],
}

impl Chaos {
    fn draw(&mut self, below: u64) -> u64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        self.random % below
    }

    fn write(&mut self, run: &mut dyn Run) {
        let topics = self.topics.len() as u64;
        let index = usize::try_from(self.draw(topics)).unwrap();
        let value = Datum::Bool(self.draw(2) == 0);
        let sample = Datum::record([("data".to_owned(), value)]);
        let now = run.now();
        run.publish_sample(now, self.topics[index], Arc::new(sample))
            .unwrap();
    }
}

/// Takes a component one step towards running, whatever its state.
fn restart(run: &mut dyn Run, component: &str) {
    if run.state(component) == Some(State::Exception) {
        let _ = run.transition(component, Transition::ResetException);
    }
    if run.state(component) == Some(State::PreOperational) {
        let _ = run.transition(component, Transition::Configure);
    }
    let _ = run.transition(component, Transition::Start);
}

impl Director for Chaos {
    fn prepare(&mut self, plan: &Plan) -> Result<(), Report> {
        self.components = plan.components.iter().map(|it| it.name.clone()).collect();
        Ok(())
    }

    fn has_goal(&self) -> bool {
        false
    }

    fn act(&mut self, run: &mut dyn Run) -> Option<MissionOutcome> {
        while self.is_due(run.now()) {
            let count = self.components.len() as u64;
            let index = usize::try_from(self.draw(count)).unwrap();
            let component = self.components[index].clone();
            match self.draw(8) {
                0 => {
                    let _ = run.inject_fault(&component, Fault::new("failed by the test"));
                }
                1 => {
                    let _ = run.transition(&component, Transition::Stop);
                }
                2 => {
                    let _ = run.transition(&component, Transition::Stop);
                    let _ = run.transition(&component, Transition::Cleanup);
                }
                3 if !self.topics.is_empty() => self.write(run),
                _ => {
                    let all = self.components.clone();
                    all.iter().for_each(|component| restart(run, component));
                }
            }
            let pause = 50 + self.draw(900);
            self.next += Duration::from_millis(pause);
        }
        None
    }

    fn finish(&mut self, _: Time) {}

    fn next(&self) -> Option<Time> {
        Some(self.next)
    }

    fn is_due(&self, now: Time) -> bool {
        now >= self.next
    }
}

/// Names of the components of a composite, as its text has them.
fn components(composite: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(composite).unwrap();
    let names = text
        .lines()
        .filter_map(|line| line.strip_prefix("[components."));
    let names = names.filter_map(|line| line.split([']', '.']).next());
    let mut names: Vec<_> = names.map(str::to_owned).collect();
    names.dedup();
    names
}

/// Records a mission with random faults.
fn record(composite: &Path, topics: &'static [&'static str], seed: u64, file: &Path) {
    let mut mission = Mission::new(text(composite));
    (mission.until, mission.unless) = (Some(Vec::new()), Some(Vec::new()));
    mission.limit = Some(Duration::from_secs(20));
    mission.may_fail = components(composite);
    (mission.seed, mission.seeds_composite) = (seed, true);
    mission.recording = RecordingRequest {
        file: Some(text(file)),
        ports: vec!["goal".to_owned()],
        ..RecordingRequest::default()
    };
    let mut chaos = Chaos {
        random: 0x9e37_79b9_7f4a_7c15 ^ (seed << 17) ^ seed,
        next: Time::from_nanos(1_500_000_000),
        components: Vec::new(),
        topics,
    };
    let stop = AtomicBool::new(false);
    let ended = mission.run_directed(&mut chaos, |_, _| (), |_, _, _| (), &stop);
    let recording = ended.unwrap().recording.unwrap();
    assert!(recording.is_complete(), "{recording:?}");
}

fn composite(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("specs/{name}.composite.toml"))
}

#[test]
fn d3_random_missions_with_faults_repeat_to_equal_hashes() {
    let missions = std::env::var("ASMOTION_REPLAY_MISSIONS").ok();
    let missions = missions
        .and_then(|count| count.parse().ok())
        .unwrap_or(MISSIONS);
    let composites: [(&str, &'static [&'static str]); 5] = [
        ("navigation/navigation", &["estop", "contact"]),
        ("courier/courier", &[]),
        ("ball_tracker/ball_tracker", &[]),
        ("allocation/allocation", &[]),
        ("youbot/youbot", &[]),
    ];
    let folder = tempfile::tempdir().unwrap();
    for seed in 0..missions {
        let (name, topics) = composites[usize::try_from(seed).unwrap() % composites.len()];
        let file = folder.path().join(format!("{seed:03}.mcap"));
        record(&composite(name), topics, seed, &file);
    }
    let (code, objects) = replay(&[&text(folder.path())]);
    let different = objects
        .iter()
        .filter(|it| it["type"] != "replay" && it["result"] != "equal");
    let different: Vec<_> = different.collect();
    assert_eq!((code, different.len()), (Some(0), 0), "{different:?}");
    let sum = |name: &str| {
        let counts = objects.iter().filter_map(|it| it[name].as_u64());
        counts.sum::<u64>()
    };
    let total = objects.last().unwrap();
    eprintln!("{total}");
    assert_eq!(total["recordings"], missions, "{total}");
    assert!(total["steps"].as_u64().unwrap() > missions * 100, "{total}");
    // coordinators began again
    assert!(
        sum("machines") > total["coordinators"].as_u64().unwrap() + 3,
        "{total}"
    );
}

/// A specification that fails in every eighth step, and chooses in every one.
const STUMBLER: &str = "asm stumbler
import StandardLibrary
signature:
	enum domain Side = {LEFT | MIDDLE | RIGHT}
	controlled n: Integer
	controlled side: Side
definitions:
	main rule r_Main =
		par
			n := n + 1
			if n = 7 then n := 0 endif
			choose $s in Side with $s != side do side := $s
		endpar
default init s0:
	function n = 0
	function side = LEFT
";

const STUMBLER_COMPOSITE: &str = "schema = \"composite/1\"
[composite]
name = \"stumbler\"
version = \"1.0.0\"

[components.Stumbler]
implementation = { asm = \"stumbler.asm\", main = \"r_Main\" }
task = { id = \"stumbler\", period_ms = 50, delay_ms = 0, run_on_startup = true, may_interrupt_if_running = false }
";

/// Starts what has failed again.
struct Nurse(Time);

impl Director for Nurse {
    fn prepare(&mut self, _: &Plan) -> Result<(), Report> {
        Ok(())
    }

    fn has_goal(&self) -> bool {
        false
    }

    fn act(&mut self, run: &mut dyn Run) -> Option<MissionOutcome> {
        while self.is_due(run.now()) {
            self.0 += Duration::from_millis(200);
            if run.state("Stumbler") == Some(State::Exception) {
                restart(run, "Stumbler");
            }
        }
        None
    }

    fn finish(&mut self, _: Time) {}

    fn next(&self) -> Option<Time> {
        Some(self.0)
    }

    fn is_due(&self, now: Time) -> bool {
        now >= self.0
    }
}

#[test]
fn steps_that_fail_fail_again_and_a_reset_begins_anew() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("stumbler.asm"), STUMBLER).unwrap();
    std::fs::write(path("stumbler.composite.toml"), STUMBLER_COMPOSITE).unwrap();
    let mut mission = Mission::new(text(&path("stumbler.composite.toml")));
    mission.limit = Some(Duration::from_secs(3));
    mission.may_fail = vec!["Stumbler".to_owned()];
    mission.recording.file = Some(text(&path("run.mcap")));
    let stop = AtomicBool::new(false);
    let mut nurse = Nurse(Time::from_nanos(0));
    mission
        .run_directed(&mut nurse, |_, _| (), |_, _, _| (), &stop)
        .unwrap();
    let file = text(&path("run.mcap"));
    let (code, objects) = replay(&[&file]);
    let one = &objects[0];
    assert_eq!((code, &one["result"]), (Some(0), &"equal".into()), "{one}");
    let (failed, machines) = (
        one["failed"].as_u64().unwrap(),
        one["machines"].as_u64().unwrap(),
    );
    assert!(
        failed >= 4 && (failed..=failed + 1).contains(&machines),
        "{one}"
    );

    // a specification that does not fail is different from where the recorded one fails
    let fixed = STUMBLER.replace(
        "\t\t\tn := n + 1\n\t\t\tif n = 7 then n := 0 endif\n",
        "\t\t\tn := (n + 1) mod 8\n",
    );
    std::fs::write(path("fixed.asm"), fixed).unwrap();
    let (code, objects) = replay(&[&file, "--spec", &text(&path("fixed.asm"))]);
    let different = &objects[0]["difference"];
    assert_eq!(
        (code, &different["step"]),
        (Some(1), &8.into()),
        "{different}"
    );
    let said = different["text"].as_str().unwrap();
    assert!(
        said.contains("what: failure") && said.contains("replay: none"),
        "{said}"
    );

    // a scenario has the steps of one machine; it picks what was chosen, whatever the seed
    let (code, said) = asmotion(&["replay", &file, "--export", "scenario"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("began again before"), "{said}");
    let scenario = text(&path("seven.avalla"));
    let (code, said) = asmotion(&[
        "replay", &file, "--export", "scenario", "--until", "7", "-o", &scenario,
    ]);
    assert_eq!(code, Some(0), "{said}");
    let written = std::fs::read_to_string(&scenario).unwrap();
    assert_eq!(
        written.matches("pick $s in r_Main := ").count(),
        7,
        "{written}"
    );
    for seed in ["1", "2", "3"] {
        let (code, said) = asmotion(&["test", &scenario, "--seed", seed]);
        assert_eq!(code, Some(0), "{said}{written}");
    }

    // a session repeats one machine, up to the step that fails
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.args(["repl", "--from", &file, "--machine", "2"]);
    let output = command
        .write_stdin("step 7\nn\nstep\nundo 3\nn\n")
        .output()
        .unwrap();
    let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    let values: Vec<_> = said.lines().filter(|line| line.len() == 1).collect();
    assert_eq!(values, ["7", "4"], "{said}");
    assert!(said.contains("R001"), "{said}");
    assert!(said.contains("machine 1 began at 0.000 s"), "{said}");
}
