//! rFSM's ball tracker as a specification: hierarchical states, completion, guards, timeouts, priorities.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use asmotion::mission::{Mission, MissionOutcome};
use asmotion_component::Time;
use asmotion_coordinator::{STEP_REPORT, StepRecord};
use asmotion_runtime::Event;

fn composite() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/ball_tracker/ball_tracker.composite.toml")
}

/// The states of the coordinator until one of these is reached; inner states follow a slash.
fn states(mut mission: Mission, until: &str) -> (Vec<String>, MissionOutcome, Duration) {
    mission.until = Some(vec![("mode".to_owned(), until.to_owned())]);
    mission.unless = Some(Vec::new());
    mission.limit = Some(Duration::from_secs(60));
    let all = Arc::new(Mutex::new(Vec::new()));
    let listener = Arc::clone(&all);
    let hear = move |_: Time, event: &Event<'_>, _: Option<&str>| {
        if let Event::Report {
            kind: STEP_REPORT,
            component: "Coordinator",
            data: what,
        } = event
        {
            let step: StepRecord = what.to().unwrap();
            let state = |location: &str| {
                let mut updates = step.updates.iter();
                let update = updates.find(|it| it.location == location);
                update.filter(|it| it.before != it.after || location == "operate")
            };
            let entered = state("mode").map(|it| it.after.clone());
            let within = state("operate").map(|it| format!("/{}", it.after));
            listener
                .lock()
                .unwrap()
                .extend(entered.into_iter().chain(within));
        }
    };
    let ended = mission.run(hear, &AtomicBool::new(false)).unwrap();
    let states = all.lock().unwrap().clone();
    (states, ended.outcome, ended.time)
}

fn shipped() -> Mission {
    Mission::new(composite().display().to_string())
}

/// The composite with a change in one of its specifications.
fn changed(file: &str, from: &str, to: &str) -> (Mission, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(composite().parent().unwrap()).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let changed = folder.path().join(file);
    let text = std::fs::read_to_string(&changed).unwrap();
    assert!(text.contains(from), "{file} has changed: adapt this test");
    std::fs::write(&changed, text.replace(from, to)).unwrap();
    let composite = folder.path().join("ball_tracker.composite.toml");
    (Mission::new(composite.display().to_string()), folder)
}

#[test]
fn o16_the_ball_is_searched_followed_and_held_until_the_work_is_complete() {
    let (states, outcome, time) = states(shipped(), "DONE");
    assert_eq!(states, ["OPERATE", "/SEARCH", "/FOLLOW", "/HOLD", "DONE"]);
    assert_eq!(outcome, MissionOutcome::Reached);
    // one second of warming up, and one of holding
    assert!(time > Duration::from_secs(2), "{time:?}");
}

#[test]
fn o16_a_ball_that_hides_is_searched_again() {
    // held long enough for the ball to roll behind something
    let (mission, _folder) = changed("ball_tracker.asm", "then 1000", "then 8000");
    let (states, ..) = states(mission, "DONE");
    let begin = ["OPERATE", "/SEARCH", "/FOLLOW", "/HOLD", "/SEARCH"];
    assert_eq!(states[..5], begin, "{states:?}");
}

#[test]
fn o16_a_camera_that_does_not_warm_up_in_time_is_given_up() {
    let (mission, _folder) = changed("camera.asm", "warmth = 10", "warmth = 100");
    let (states, _, time) = states(mission, "FAILED");
    assert_eq!(states, ["FAILED"]);
    assert!((2000..2200).contains(&time.as_millis()), "{time:?}");
}

#[test]
fn o16_a_search_without_end_times_out() {
    let (mission, _folder) = changed("camera.asm", "hidden <= 0", "hidden > 1000");
    let (states, _, time) = states(mission, "FAILED");
    assert_eq!(states, ["OPERATE", "/SEARCH", "FAILED"]);
    assert!((9000..9500).contains(&time.as_millis()), "{time:?}");
}
