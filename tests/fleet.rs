//! Functions with arguments in a running system: the allocation of tasks to robots, in both clocks.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use asmotion::mission::{Mission, MissionClock};
use asmotion_component::Time;
use asmotion_coordinator::{STEP_REPORT, StepRecord};
use asmotion_runtime::Event;

/// Runs the shipped composite and returns the values that each location of the allocation took, in order.
fn values(wall: bool) -> BTreeMap<String, Vec<String>> {
    let composite = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/specs/allocation/allocation.composite.toml"
    );
    let mut mission = Mission::new(composite.to_owned());
    mission.until = Some(Vec::new());
    mission.unless = Some(Vec::new());
    mission.limit = Some(Duration::from_secs(4));
    if wall {
        mission.clock = MissionClock::Wall;
    }
    let all = Arc::new(Mutex::new(BTreeMap::new()));
    let listener = Arc::clone(&all);
    let hear = move |_: Time, event: &Event<'_>, _: Option<&str>| {
        if let Event::Report {
            kind: STEP_REPORT,
            component: "Allocation",
            data,
        } = event
        {
            let step: StepRecord = data.to().unwrap();
            let mut all = listener.lock().unwrap();
            for update in step.updates {
                let values: &mut Vec<String> = all.entry(update.location).or_default();
                values.push(update.after);
            }
        }
    };
    mission
        .run(|_, _| (), hear, &AtomicBool::new(false))
        .unwrap();
    let values = all.lock().unwrap();
    values.clone()
}

#[test]
fn robots_receive_orders_by_pattern_and_report_by_topic_and_by_key() {
    let (real, simulated) = std::thread::scope(|scope| {
        let real = scope.spawn(|| values(true));
        (values(false), real.join().unwrap())
    });
    for (clock, values) in [("virtual", simulated), ("wall", real)] {
        for task in ["TASK1", "TASK2", "TASK3"] {
            let states = &values[&format!("tstate({task})")];
            assert_eq!(states.last().unwrap(), "DONE", "{clock}: {values:?}");
        }
        // the robot with two orders breaks down, and its task is given away again
        let mut states = values.iter().filter(|(name, _)| name.starts_with("tstate"));
        let released = states.any(|(_, states)| states.contains(&"PENDING".to_owned()));
        assert!(released, "{clock}: {values:?}");
        let orders = ["order(ROB1)", "order(ROB2)"].map(|location| values[location].len());
        assert!(orders.iter().sum::<usize>() >= 4, "{clock}: {values:?}");
    }
}

/// Two robots that are sent away, and one that stays.
const MODES: &str = "asm modes
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
		forall $r in Robot with $r > 1 do
			if mode($r) = IDLE then mode($r) := RUN
			else if mode($r) = RUN and n = 2 then mode($r) := END endif endif
	endpar
default init s0:
	function mode($r in Robot) = IDLE
	function n = 0
";

#[test]
fn the_control_states_of_agents_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let composite = folder.path().join("modes.composite.toml");
    let text = "schema = \"composite/1\"\n[composite]\nname = \"modes\"\n[components.Fleet]\nimplementation = { asm = \"modes.asm\" }\n\
                task.period_ms = 100\n";
    std::fs::write(&composite, text).unwrap();
    let run = |specification: &str, json: bool| {
        std::fs::write(folder.path().join("modes.asm"), specification).unwrap();
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.arg("run").arg(&composite).args(["--for", "0.5"]);
        command.args(json.then_some("--json"));
        let output = command.output().unwrap();
        String::from_utf8([output.stderr, output.stdout].concat()).unwrap()
    };
    let said = run(MODES, false);
    assert!(said.contains("in END ×2, IDLE ×1"), "{said}");
    assert!(said.contains("4 changes of control state"), "{said}");
    let said = run(MODES, true);
    let summary: serde_json::Value =
        serde_json::from_str(said.lines().last().unwrap()).unwrap_or_else(|_| panic!("{said}"));
    assert_eq!(summary["transitions"], 4);
    assert_eq!(
        summary["control_states"],
        serde_json::json!([{ "component": "Fleet", "state": "END ×2, IDLE ×1" }])
    );
    // the locations of a large fleet are not listed, and agents in one state are in that state
    let said = run(&MODES.replace("{1 : 3}", "{1 : 40}"), false);
    assert!(said.contains("in END ×39, IDLE ×1"), "{said}");
    let said = run(&MODES.replace(" with $r > 1", ""), false);
    assert!(said.contains("in END after"), "{said}");
}
