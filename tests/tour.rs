//! A tour over the waypoints of a list in the composite, with a wait at each, in both clocks.

use asmotion::mission::{Mission, MissionClock};
use asmotion_component::Time;
use asmotion_coordinator::{STEP_REPORT, StepRecord};
use asmotion_runtime::Event;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::Duration;

const TOUR: &str = "
asm tour
import StandardLibrary
signature:
	enum domain Mode = {READY | DRIVING | WAITING | DONE}
	monitored tour: Seq(Prod(Real, Real))
	monitored arrived: Boolean
	monitored waited: Boolean
	controlled mode: Mode
	controlled left: Seq(Prod(Real, Real))
	controlled goal: Prod(Real, Real)
	out go: Boolean
definitions:
	rule r_next =
		if length(left) > 0 then
			par
				goal := first(left)
				left := tail(left)
				go := true
				mode := DRIVING
			endpar
		else
			mode := DONE
		endif
	main rule r_Main =
		switch mode
			case READY: par left := tour mode := WAITING endpar
			case DRIVING: if arrived then mode := WAITING endif
			case WAITING: if waited then r_next[] endif
		endswitch
default init s0:
	function mode = READY
";

const ROBOT: &str = "
asm robot
import StandardLibrary
signature:
	monitored x: Real
	monitored y: Real
	controlled place: Prod(Real, Real)
	out arrived: Boolean
definitions:
	main rule r_Main =
		if isDef(x) then
			par
				place := (x, y)
				arrived := true
			endpar
		endif
";

const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "tour"

[components.Tour]
implementation = { asm = "tour.asm", main = "r_Main" }
activity  = { period_ms = 50 }
subscribe = { arrived = "std_msgs/Bool" }
publish   = { goal = "geometry_msgs/PoseStamped" }

[components.Tour.bind.monitored]
tour    = { value = [[3.0, 7.0], [12.5, 4.2], [26.4, 4]] }
arrived = { topic = "arrived", edge = true }
waited  = { timer = "mode = WAITING", ms = 300 }

[components.Tour.bind.out.go]
true = { publish = "goal", value = { pose = { position = { x = "@(first(goal))", y = "@(second(goal))" } } } }

[components.Robot]
implementation = { asm = "robot.asm", main = "r_Main" }
activity  = { period_ms = 20 }
subscribe = { goal = "geometry_msgs/PoseStamped" }
publish   = { arrived = "std_msgs/Bool" }

[components.Robot.bind.monitored]
x = { topic = "goal", receive = "all", field = "pose.position.x" }
y = { topic = "goal", receive = "all", field = "pose.position.y" }

[components.Robot.bind.out]
arrived = { topic = "arrived", publish = "on_update" }
"#;

/// The updates of a location of a component: milliseconds and values.
type Updates = Vec<(i64, String)>;

/// Runs the tour. Returns the places of the robot, and the modes of the tour.
fn run(clock: MissionClock) -> (Updates, Updates) {
    let folder = tempfile::tempdir().unwrap();
    let files = [
        ("tour.asm", TOUR),
        ("robot.asm", ROBOT),
        ("tour.composite.toml", COMPOSITE),
    ];
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let composite = folder.path().join("tour.composite.toml");
    let mut mission = Mission::new(composite.display().to_string());
    mission.until = Some(Vec::new());
    mission.unless = Some(Vec::new());
    mission.limit = Some(Duration::from_secs(3));
    mission.clock = clock;
    let all = Arc::new(Mutex::new((Updates::new(), Updates::new())));
    let listener = Arc::clone(&all);
    let hear = move |at: Time, event: &Event<'_>, _: Option<&str>| {
        if let Event::Report {
            kind: STEP_REPORT,
            data,
            ..
        } = event
        {
            let step: StepRecord = data.to().unwrap();
            let (places, modes) = &mut *listener.lock().unwrap();
            for update in step.updates {
                let update_at = (at.nanos() / 1_000_000, update.after);
                match update.location.as_str() {
                    "place" => places.push(update_at),
                    "mode" => modes.push(update_at),
                    _ => {}
                }
            }
        }
    };
    mission
        .run(|_, _| (), hear, &AtomicBool::new(false))
        .unwrap();
    let updates = all.lock().unwrap();
    updates.clone()
}

#[test]
fn a_tour_visits_the_waypoints_of_a_list_and_waits_at_each() {
    let (simulated, real) = std::thread::scope(|scope| {
        let real = scope.spawn(|| run(MissionClock::Wall));
        (run(MissionClock::Virtual(0.0)), real.join().unwrap())
    });
    // a step is at most a period late in virtual time; a busy machine delays it in real time
    let clocks = [("virtual", simulated, 350), ("wall", real, 900)];
    for (clock, (places, modes), latest) in clocks {
        let visited: Vec<&str> = places.iter().map(|(_, place)| place.as_str()).collect();
        assert_eq!(
            visited,
            ["(3.0, 7.0)", "(12.5, 4.2)", "(26.4, 4.0)"],
            "{clock}"
        );
        let entered: Vec<&str> = modes.iter().map(|(_, mode)| mode.as_str()).collect();
        let once = ["WAITING", "DRIVING"];
        let expected = [&once[..], &once, &once, &["WAITING", "DONE"]].concat();
        assert_eq!(entered, expected, "{clock}");
        for wait in modes.chunks(2) {
            let waited = wait[1].0 - wait[0].0;
            assert!((299..=latest).contains(&waited), "{clock}: {modes:?}");
        }
    }
}
