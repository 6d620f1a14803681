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
