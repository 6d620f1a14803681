//! Several robots in one world: they see each other, stop at each other, and their collisions are reported.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use asmotion_component::{Activity, Interface, NOTICE_REPORT, Policy, Span, Time};
use asmotion_datum::Datum;
use asmotion_laser::LaserDriver;
use asmotion_messages::{Event as RobotEvent, LaserScan, PoseStamped, WheelSpeeds};
use asmotion_runtime::{Event, Run, Simulation, System};
use asmotion_world::{Traffic, World};

/// Radius of each robot, m.
const RADIUS: f64 = 0.2;

/// Samples that were published, by port.
#[derive(Default)]
struct Seen {
    events: Vec<(String, RobotEvent)>,
    scans: Vec<(String, LaserScan)>,
    places: Vec<(String, f64)>,
    notices: Vec<String>,
}

type Log = Arc<Mutex<Seen>>;

fn observe(seen: &Log) -> impl FnMut(Time, &Event<'_>) + Send + 'static {
    let seen = Arc::clone(seen);
    move |_: Time, event: &Event<'_>| {
        let mut seen = seen.lock().unwrap();
        match event {
            Event::Published {
                component, sample, ..
            } => {
                let of = || (*component).to_owned();
                if let Some(event) = sample.downcast_ref::<RobotEvent>() {
                    seen.events.push((of(), event.clone()));
                }
                if let Some(scan) = sample.downcast_ref::<LaserScan>() {
                    seen.scans.push((of(), scan.clone()));
                }
                if let Some(truth) = sample.downcast_ref::<PoseStamped>() {
                    seen.places.push((of(), truth.pose.position.x));
                }
            }
            Event::Report { kind, data, .. } if *kind == NOTICE_REPORT => {
                seen.notices.push(data.to_string());
            }
            _ => {}
        }
    }
}

/// Robots on the x axis, each with its name, its place and its direction.
fn robots(robots: &[(&str, f64, f64)], seen: &Log) -> Simulation {
    let mut system = System::new();
    system.observe(observe(seen));
    let every = |ms: u64| Activity::periodic(ms.ms());
    let traffic = |interface: &mut Interface| -> Box<dyn asmotion_component::Component> {
        Box::new(Traffic::new(interface))
    };
    system.add("Traffic", every(20), traffic).unwrap();
    for (number, (rover, x, yaw)) in robots.iter().enumerate() {
        let [world, laser] = ["World", "Laser"].map(|kind| format!("{kind}{number}"));
        let made = |interface: &mut Interface| -> Box<dyn asmotion_component::Component> {
            Box::new(World::new(interface))
        };
        let id = system.add(&world, every(20), made).unwrap();
        let start = Datum::of(&[*x, 0.0, *yaw]).unwrap();
        system.set_property(id, "start", &start).unwrap();
        system
            .set_property(id, "rover", &Datum::text(*rover))
            .unwrap();
        system.set_property(id, "slip", &Datum::Float(0.0)).unwrap();
        let made = |interface: &mut Interface| -> Box<dyn asmotion_component::Component> {
            Box::new(LaserDriver::new(interface))
        };
        let id = system.add(&laser, every(50), made).unwrap();
        system
            .set_property(id, "rover", &Datum::text(*rover))
            .unwrap();
        for (name, value) in [("noise_m", 0.0), ("angle_min", 0.0), ("angle_max", 0.1)] {
            system.set_property(id, name, &Datum::Float(value)).unwrap();
        }
        system.set_property(id, "beams", &Datum::Int(2)).unwrap();
        let mut connect = |from: &str, to: &str, policy: Policy| {
            system.connect(from, to, policy).unwrap();
        };
        let data = Policy::data;
        connect(
            &format!("{world}.disc"),
            "Traffic.discs",
            Policy::circular(64),
        );
        connect("Traffic.rovers", &format!("{world}.rovers"), data());
        connect("Traffic.rovers", &format!("{laser}.rovers"), data());
        connect(&format!("{world}.truth"), &format!("{laser}.truth"), data());
        connect(
            &format!("{world}.scene"),
            &format!("{laser}.scene"),
            data().init(),
        );
    }
    system.simulate()
}

/// Turns the wheels of a world for a while.
fn drive(run: &mut Simulation, worlds: &[usize], wheel: f64, span: Duration) {
    let end = run.now() + span;
    while run.now() < end {
        for world in worlds {
            let speeds = WheelSpeeds {
                left: wheel,
                right: wheel,
            };
            let port = format!("World{world}.wheels");
            run.inject_sample(run.now(), &port, Arc::new(speeds))
                .unwrap();
        }
        run.run_for(100.ms());
    }
}

#[test]
fn robots_see_each_other_and_not_themselves() {
    let seen = Log::default();
    let mut run = robots(&[("left", 0.0, 0.0), ("right", 3.0, 0.0)], &seen);
    run.run_for(1.s());
    let seen = seen.lock().unwrap();
    let ahead = |laser: &str| {
        let scans = seen.scans.iter().rfind(|(of, _)| of == laser);
        f64::from(scans.unwrap().1.ranges[0])
    };
    let range = ahead("Laser0");
    assert!((range - (3.0 - RADIUS)).abs() < 1e-3, "{range}");
    assert_eq!(ahead("Laser1"), f64::INFINITY, "nothing is ahead of it");
    assert!(seen.events.is_empty(), "{:?}", seen.events);
}

#[test]
fn a_robot_that_drives_into_another_stops_there_and_its_world_names_the_other() {
    let seen = Log::default();
    let mut run = robots(&[("left", 0.0, 0.0), ("right", 1.0, 0.0)], &seen);
    // 0.5 m/s with wheels of 0.05 m
    drive(&mut run, &[0], 10.0, 3.s());
    let seen = seen.lock().unwrap();
    let [(component, event)] = seen.events.as_slice() else {
        panic!("once per contact: {:?}", seen.events);
    };
    assert_eq!(
        (component.as_str(), event.code.as_str()),
        ("World0", "COLLISION")
    );
    assert!(
        event.detail.starts_with("with right at (0."),
        "{}",
        event.detail
    );
    let places = seen.places.iter().filter(|(of, _)| of == "World0");
    let furthest = places.map(|(_, x)| *x).fold(0.0, f64::max);
    assert!((1.0 - furthest - 2.0 * RADIUS).abs() < 0.02, "{furthest}");
}

#[test]
fn robots_that_meet_head_on_do_not_pass_through_each_other() {
    let seen = Log::default();
    let facing = std::f64::consts::PI;
    let mut run = robots(&[("left", 0.0, 0.0), ("right", 2.0, facing)], &seen);
    drive(&mut run, &[0, 1], 10.0, 4.s());
    let seen = seen.lock().unwrap();
    let last = |world: &str| seen.places.iter().rfind(|(of, _)| of == world).unwrap().1;
    let gap = last("World1") - last("World0") - 2.0 * RADIUS;
    // each knows where the other was a cycle or two ago
    assert!((-0.05..0.05).contains(&gap), "{gap}");
    let names: Vec<_> = seen.events.iter().map(|(_, it)| &*it.detail).collect();
    assert!(names.iter().any(|it| it.starts_with("with ")), "{names:?}");
}

#[test]
fn two_robots_with_one_name_are_reported() {
    let seen = Log::default();
    let mut run = robots(&[("twin", 0.0, 0.0), ("twin", 3.0, 0.0)], &seen);
    run.run_for(1.s());
    let seen = seen.lock().unwrap();
    let [notice] = seen.notices.as_slice() else {
        panic!("once: {:?}", seen.notices);
    };
    assert!(
        notice.contains("several robots are called `twin`"),
        "{notice}"
    );
}
