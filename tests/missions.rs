//! Missions of the rover in virtual time, with reviewed snapshots of their stories.

use asmotion::mission::{Mission, MissionEnd, MissionOutcome};
use asmotion::trace::MissionTrace;
use asmotion_datum::Datum;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

/// The goal of most missions: the lobby.
const TO_LOBBY: &str = "1 goal 26.4 4.2";

fn navigation() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation")
}

/// The navigation composite with an operator's script and unmapped obstacles.
fn mission(script: &[&str], obstacles: &str) -> Mission {
    let composite = navigation().join("navigation.composite.toml");
    let mut mission = Mission::new(composite.display().to_string());
    let script = Datum::List(script.iter().map(|line| Datum::text(*line)).collect());
    mission
        .properties
        .push(("Operator".to_owned(), "script".to_owned(), script));
    let obstacles: Datum = asmotion_datum::json::decode(obstacles).unwrap();
    mission
        .properties
        .push(("World".to_owned(), "obstacles".to_owned(), obstacles));
    mission
}

fn seeded(mut mission: Mission, seed: u64) -> Mission {
    mission.seed = seed;
    mission.settings.push(("seed".to_owned(), seed.to_string()));
    mission
}

/// Runs a mission. Returns its story without reports of progress, and its end.
fn tell(mission: &Mission) -> (String, MissionEnd) {
    let story = Arc::new(Mutex::new(String::new()));
    let teller = story.clone();
    let ended = mission
        .run(
            |_, _| (),
            move |_, _, line| {
                if let Some(line) = line.filter(|line| !line.contains("m from the goal")) {
                    let plain = anstream::adapter::strip_str(line).to_string();
                    *teller.lock().unwrap() += &format!("{plain}\n");
                }
            },
            &AtomicBool::new(false),
        )
        .unwrap();
    let mut story = story.lock().unwrap().clone();
    let summary = &ended.summary;
    let way = summary.robots.only().into_iter().map(|robot| {
        let (driven, left) = (robot.path.driven_m, robot.to_goal_m().unwrap_or(f64::NAN));
        format!(", {driven:.1} m driven, {left:.2} m from the goal")
    });
    story += &format!(
        "\n{:?} in {} after {:.2} s{}\n",
        ended.outcome,
        summary.control_state().unwrap_or("-"),
        ended.time.as_secs_f64(),
        way.collect::<String>(),
    );
    (story, ended)
}

/// The trace of a mission.
fn trace(mission: &Mission) -> String {
    let trace = Arc::new(Mutex::new(MissionTrace::new()));
    let writer = trace.clone();
    mission
        .run(
            |_, _| (),
            move |at, event, _| writer.lock().unwrap().note(at, event),
            &AtomicBool::new(false),
        )
        .unwrap();
    trace.lock().unwrap().text().to_owned()
}

#[test]
fn an_arm_is_told_by_what_it_is() {
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs");
    let composite = specs.join("youbot/youbot.composite.toml");
    let mut mission = Mission::new(composite.display().to_string());
    mission.until = Some(vec![("mode".to_owned(), "IDLE".to_owned())]);
    let (story, ended) = tell(&mission);
    assert_eq!(ended.summary.robots.only(), None, "nothing drives");
    assert_eq!(ended.summary.calls.of("notifying.notify"), 24);
    insta::assert_snapshot!(story);
}

const CLOSED_CORRIDOR: &str = r#"[{ "at_s": 12.0, "block": [15.0, 7.0, 0.4, 2.0, 0.0] }]"#;

#[test]
fn it_goes_straight_to_the_goal() {
    let (story, ended) = tell(&mission(&[TO_LOBBY], "[]"));
    assert_eq!(ended.outcome, MissionOutcome::Reached);
    insta::assert_snapshot!(story);
}

#[test]
fn it_goes_around_what_stands_in_the_way() {
    let (story, ended) = tell(&mission(&[TO_LOBBY], r#"[{ "disc": [19.0, 7.45, 0.25] }]"#));
    assert_eq!(ended.outcome, MissionOutcome::Reached);
    assert_eq!(ended.summary.received.of("event BLOCKED"), 0);
    insta::assert_snapshot!(story);
}

#[test]
fn n9_it_plans_anew_where_the_corridor_is_closed() {
    let (story, ended) = tell(&mission(&[TO_LOBBY], CLOSED_CORRIDOR));
    assert_eq!(ended.outcome, MissionOutcome::Reached);
    assert_eq!(ended.summary.received.of("event BLOCKED"), 1);
    insta::assert_snapshot!(story);
}

/// A site leaves one of two writers of a topic out. The events of the other one still arrive.
#[test]
fn o13_a_site_leaves_one_writer_of_a_topic_out() {
    let folder = tempfile::tempdir().unwrap();
    let site = |without: &str| {
        let text = format!(
            "schema = \"composite/1\"\nbase = {:?}\nwithout = [{without}]\n",
            navigation().join("navigation.composite.toml")
        );
        let path = folder.path().join("site.composite.toml");
        std::fs::write(&path, text).unwrap();
        let mut mission = mission(&[TO_LOBBY], CLOSED_CORRIDOR);
        mission.composite = path.display().to_string();
        mission.limit = Some(std::time::Duration::from_secs(150));
        tell(&mission).1.summary.received
    };
    let both = site("");
    assert!(both.of("event BLOCKED") > 0 && both.of("event REACHED") == 1);
    let follower = site(r#""connections.TrajectoryAdapter.event -> topic:event""#);
    assert_eq!(follower.of("event BLOCKED"), 0);
    let adapter = site(r#""connections.TrajectoryFollower.event""#);
    assert!(adapter.of("event BLOCKED") > 0 && adapter.of("event REACHED") == 0);
}

/// A pillar that appears a hand's breadth in front of the rover, which cannot brake in time.
const SUDDEN_PILLAR: &str = r#"[{ "at_s": 12.0, "frame": "robot", "disc": [0.31, 0.0, 0.05] }]"#;

#[test]
fn it_plans_anew_after_a_contact() {
    let (story, ended) = tell(&mission(&[TO_LOBBY], SUDDEN_PILLAR));
    assert_eq!(ended.summary.received.of("contact"), 1, "{story}");
    assert_eq!(ended.outcome, MissionOutcome::Reached, "{story}");
    assert!(story.contains("collision at"), "{story}");
    // the pillar appears at 12 s; the rover driver brakes in its next cycle, 20 ms after the monitor
    let line = story.lines().find(|line| line.contains("stops the robot"));
    let (stops, _) = line.unwrap().split_once(" s ").unwrap();
    let stops: f64 = stops.trim().parse().unwrap();
    assert!(stops <= 12.08, "{story}");
    insta::assert_snapshot!(story);
    // it is the same each time
    let mission = seeded(mission(&[TO_LOBBY], SUDDEN_PILLAR), 3);
    assert_eq!(trace(&mission), trace(&mission));
}

#[test]
fn an_estop_in_contact_comes_first() {
    // the rover touches the pillar within the second before the e-stop
    let script = [
        TO_LOBBY,
        "12.3 estop on",
        "14 estop off",
        "15 goal 26.4 4.2",
    ];
    let (story, ended) = tell(&mission(&script, SUDDEN_PILLAR));
    assert!(story.contains("collision at"), "{story}");
    assert_eq!(ended.summary.control_state(), Some("ARRIVED"), "{story}");
    insta::assert_snapshot!(story);
}

#[test]
fn it_stops_before_it_turns_to_a_new_goal() {
    let (story, ended) = tell(&mission(&[TO_LOBBY, "20 goal 4.2 15.6"], "[]"));
    assert_eq!(ended.outcome, MissionOutcome::Reached);
    insta::assert_snapshot!(story);
}

#[test]
fn it_stops_at_the_estop_and_goes_on_with_a_new_goal() {
    let script = [TO_LOBBY, "15 estop on", "18 estop off", "20 goal 26.4 4.2"];
    let (story, ended) = tell(&mission(&script, "[]"));
    assert_eq!(ended.outcome, MissionOutcome::Reached);
    insta::assert_snapshot!(story);
}

#[test]
fn it_gives_up_where_there_is_no_path() {
    // the table of the meeting room
    let (story, ended) = tell(&mission(&["1 goal 21.1 17.2"], "[]"));
    assert_eq!(ended.outcome, MissionOutcome::Failed);
    insta::assert_snapshot!(story);
}

#[test]
fn it_asks_a_late_planner_again_until_the_bound() {
    // a planner with a period of one minute, and a wire with a timeout of one second
    let folder = tempfile::tempdir().unwrap();
    let composite =
        std::fs::read_to_string(navigation().join("navigation.composite.toml")).unwrap();
    let punctual = r#"id = "planner", period_ms = 100, delay_ms = 0"#;
    let late = composite.replace(
        punctual,
        r#"id = "planner", period_ms = 60000, delay_ms = 60000"#,
    );
    assert_ne!(
        composite, late,
        "the composite has changed: adapt this test"
    );
    let path = folder.path().join("navigation.composite.toml");
    std::fs::write(&path, late).unwrap();
    std::fs::create_dir(folder.path().join("maps")).unwrap();
    for file in ["navigate.asm", "maps/office.geojson"] {
        std::fs::copy(navigation().join(file), folder.path().join(file)).unwrap();
    }
    let (story, ended) = tell(&Mission::new(path.display().to_string()));
    assert_eq!(ended.outcome, MissionOutcome::Failed);
    // one call and three retries: maxTries
    assert_eq!(
        ended.summary.calls.to_string(),
        "maps.getMap ×1, planner.plan ×4"
    );
    insta::assert_snapshot!(story);
}

#[test]
fn the_same_seed_gives_the_same_trace_byte_for_byte() {
    let mission = seeded(mission(&[TO_LOBBY], CLOSED_CORRIDOR), 7);
    let first = trace(&mission);
    assert!(first.contains("U mode = ARRIVED"));
    assert_eq!(first, trace(&mission));
}

#[test]
fn another_seed_gives_another_trace() {
    let mission = mission(&[TO_LOBBY], "[]");
    assert_ne!(
        trace(&seeded(mission.clone(), 1)),
        trace(&seeded(mission, 2))
    );
}

#[test]
fn every_seed_reaches_the_goal() {
    for seed in 0..20 {
        let mission = seeded(mission(&[TO_LOBBY], CLOSED_CORRIDOR), seed);
        let (story, ended) = tell(&mission);
        assert_eq!(
            ended.outcome,
            MissionOutcome::Reached,
            "seed {seed}:\n{story}"
        );
        assert!(
            ended.summary.robots.only().unwrap().to_goal_m().unwrap() < 0.15,
            "seed {seed}:\n{story}"
        );
        assert!(!story.contains("collision"), "seed {seed}:\n{story}");
    }
}
