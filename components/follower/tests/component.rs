//! The follower in a running system: when it drives, what it reports, and the commands of whole drives.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests"
)]

use std::f64::consts::PI;
use std::fmt::Write as _;

use asmotion_component::{Activity, Component, Interface, Span, Time, Transition};
use asmotion_datum::Datum;
use asmotion_follower::TrajectoryFollower;
use asmotion_geometry::{Point, Pose, heading, message, roll, yaw};
use asmotion_messages::{
    Bool, Event, Header, LaserScan, Odometry, Path, PoseWithCovariance, Twist, TwistWithCovariance,
};
use asmotion_runtime::{Log, Run, Simulation, System};

/// Period of the follower and of its robot, s.
const PERIOD: f64 = 0.05;

/// A follower and a robot that does at once what it is commanded.
struct Rig {
    run: Simulation,
    log: Log,
    pose: Pose,
    speed: f64,
    turn: f64,
    /// Frame of the odometry.
    frame: &'static str,
    /// The walls as points, seen by a laser at the centre of the robot; `None` without a laser.
    walls: Option<Vec<Point>>,
}

impl Rig {
    fn new(properties: &[(&str, Datum)]) -> Self {
        let (mut system, log) = (System::new(), Log::new());
        system.observe(log.clone());
        let follower = |interface: &mut Interface| -> Box<dyn Component> {
            Box::new(TrajectoryFollower::new(interface))
        };
        let activity = Activity::periodic(50.ms());
        let id = system.add("Follower", activity, follower).unwrap();
        for (name, value) in properties {
            system.set_property(id, name, value).unwrap();
        }
        Self {
            run: system.simulate(),
            log,
            pose: Pose::identity(),
            speed: 0.0,
            turn: 0.0,
            frame: "map",
            walls: None,
        }
    }

    fn header(&self) -> Header {
        Header {
            stamp: asmotion_messages::Time::from_nanos(self.run.now().nanos()),
            frame_id: self.frame.to_owned(),
        }
    }

    fn odometry(&self) -> Odometry {
        Odometry {
            header: self.header(),
            pose: PoseWithCovariance {
                pose: message::pose_message(&self.pose),
                ..PoseWithCovariance::default()
            },
            twist: TwistWithCovariance {
                twist: Twist::planar(self.speed, self.turn),
                ..TwistWithCovariance::default()
            },
            ..Odometry::default()
        }
    }

    /// A scan with one beam for each point of the walls that is within 5 m.
    fn scan(&self, walls: &[Point]) -> LaserScan {
        let beams = 360_u16;
        let mut ranges = vec![f32::INFINITY; usize::from(beams)];
        for wall in walls {
            let seen = (self.pose.inverse() * wall).coords;
            let beam = (seen.y.atan2(seen.x) + PI) / (2.0 * PI) * f64::from(beams);
            let range = &mut ranges[beam as usize % usize::from(beams)];
            *range = range.min(seen.norm() as f32);
        }
        LaserScan {
            header: self.header(),
            angle_min: -PI as f32,
            angle_increment: (2.0 * PI / f64::from(beams)) as f32,
            range_min: 0.02,
            range_max: 5.0,
            ranges,
            ..LaserScan::default()
        }
    }

    fn inject<T: asmotion_datum::Message>(&mut self, port: &str, sample: T) {
        let now = self.run.now();
        let port = format!("Follower.{port}");
        self.run.inject(now, &port, sample).unwrap();
    }

    /// Orders a path through these places, at this stamp.
    fn order(&mut self, nanos: i64, places: &[(f64, f64, f64)]) {
        let pose = |(x, y, yaw): &(f64, f64, f64)| asmotion_messages::Pose::planar(*x, *y, *yaw);
        let path = Path::from_poses(nanos, "map", places.iter().map(pose));
        self.inject("path", path);
    }

    /// Lets a period pass with new odometry and, with a laser, a new scan. Returns the command, if there was one.
    fn step(&mut self) -> Option<(f64, f64)> {
        self.inject("odom", self.odometry());
        if let Some(walls) = self.walls.clone() {
            let scan = self.scan(&walls);
            self.inject("scan", scan);
        }
        self.pass()
    }

    /// Lets a period pass without new data. Returns the command, if there was one.
    fn pass(&mut self) -> Option<(f64, f64)> {
        let before = self.commands().len();
        self.run.run_for(50.ms());
        let commands = self.commands();
        let (_, twist) = commands.get(before)?;
        (self.speed, self.turn) = (twist.linear.x, twist.angular.z);
        self.pose = roll(&self.pose, self.speed * PERIOD, self.turn * PERIOD);
        Some((self.speed, self.turn))
    }

    fn commands(&self) -> Vec<(Time, Twist)> {
        self.log.samples::<Twist>("Follower.twist")
    }

    fn events(&self) -> Vec<Event> {
        let events = self.log.samples::<Event>("Follower.event");
        events.into_iter().map(|(_, event)| event).collect()
    }

    /// Events that the follower has reported, without the time and the name.
    fn reports(&self) -> Vec<String> {
        let lines = self.log.lines();
        let report = |line: &String| {
            let (_, report) = line.split_once(" Follower: ")?;
            let hindered = report.starts_with("hindered") || report.starts_with("notice");
            hindered.then(|| report.replace('"', ""))
        };
        lines.iter().filter_map(report).collect()
    }

    /// Drives to the end of the order. Returns the number of periods.
    fn drive(&mut self) -> usize {
        let (limit, before) = (4000, self.events().len());
        let mut periods = 0;
        while self.events().len() == before {
            assert!(periods < limit, "it does not arrive: {}", self.pose);
            self.step();
            periods += 1;
        }
        periods
    }
}

const AHEAD: [(f64, f64, f64); 2] = [(0.0, 0.0, 0.0), (3.0, 0.0, 0.0)];

#[test]
fn it_publishes_the_plan_and_the_place_of_an_arrival_and_one_last_zero() {
    let mut rig = Rig::new(&[]);
    rig.step();
    assert_eq!(rig.commands().len(), 0, "silent without an order");
    rig.order(7_000_000_009, &AHEAD);
    rig.drive();
    let [arrived] = &rig.events()[..] else {
        panic!("{:?}", rig.events());
    };
    assert_eq!((arrived.plan.sec, arrived.plan.nanosec), (7, 9));
    assert_eq!(arrived.code, "REACHED");
    let place = rig.pose.translation;
    let detail = format!("at ({:.2}, {:.2}) by odometry", place.x, place.y);
    assert_eq!(arrived.detail, detail);
    assert_eq!(arrived.stamp.as_nanos(), rig.run.now().nanos());
    let commands = rig.commands();
    assert_eq!(commands.last().unwrap().1, Twist::default());
    assert_eq!(rig.step(), Some((0.0, 0.0)), "one final zero");
    assert_eq!((rig.step(), rig.step()), (None, None), "then silence");

    rig.order(8_000_000_000, &[]);
    rig.drive();
    let halted = rig.events().pop().unwrap();
    assert_eq!((halted.code.as_str(), halted.plan.sec), ("HALTED", 8));
}

/// Lets a hindrance come and go while a path is driven.
#[track_caller]
fn hinders(reason: &str, hinder: impl Fn(&mut Rig), free: impl Fn(&mut Rig)) {
    let mut rig = Rig::new(&[]);
    rig.walls = Some(Vec::new());
    rig.order(1, &AHEAD);
    rig.step();
    rig.step();
    assert!(rig.speed > 0.1, "it drives before");
    assert_eq!(rig.reports(), [""; 0]);
    hinder(&mut rig);
    assert_eq!(rig.reports(), [format!("hindered: {reason}")]);
    assert_eq!((rig.speed, rig.turn), (0.0, 0.0), "it stands");
    free(&mut rig);
    assert!(rig.speed > 0.1, "it drives afterwards");
    assert_eq!(rig.reports()[1..], ["hindered: no more"]);
}

#[test]
fn it_does_not_drive_on_stale_odometry() {
    hinders(
        "stale odometry",
        |rig| {
            // the newest is as old as permitted, 200 ms, in the fourth cycle
            for _ in 0..4 {
                assert!(rig.pass().unwrap().0 > 0.1);
            }
            rig.pass();
        },
        |rig| {
            rig.step();
        },
    );
}

#[test]
fn it_does_not_drive_on_odometry_in_another_frame() {
    hinders(
        "odometry in another frame",
        |rig| {
            rig.frame = "odom";
            rig.step();
        },
        |rig| {
            rig.frame = "map";
            rig.step();
        },
    );
    // a path without a frame is one in the frame of the odometry
    let mut rig = Rig::new(&[]);
    rig.frame = "odom";
    let mut path = Path::from_poses(
        1,
        "",
        AHEAD.map(|(x, y, yaw)| asmotion_messages::Pose::planar(x, y, yaw)),
    );
    path.header.frame_id.clear();
    rig.inject("path", path);
    assert!(rig.step().unwrap().0 > 0.1);
}

#[test]
fn it_does_not_drive_without_permission() {
    hinders(
        "no permission to drive",
        |rig| {
            rig.inject("permit", Bool { data: false });
            rig.step();
        },
        |rig| {
            rig.inject("permit", Bool { data: true });
            rig.step();
        },
    );
}

#[test]
fn it_does_not_drive_on_a_stale_scan() {
    hinders(
        "stale scan",
        |rig| {
            rig.walls = None;
            // the newest is as old as permitted, 500 ms, in the tenth cycle
            for _ in 0..10 {
                assert!(rig.step().unwrap().0 > 0.1);
            }
            rig.step();
        },
        |rig| {
            rig.walls = Some(Vec::new());
            rig.step();
        },
    );
}

#[test]
fn it_does_not_drive_before_it_knows_where_it_is() {
    let mut rig = Rig::new(&[]);
    rig.order(1, &AHEAD);
    assert_eq!(rig.pass(), Some((0.0, 0.0)));
    assert!(rig.reports().contains(&"hindered: no odometry".to_owned()));
    assert!(rig.step().unwrap().0 > 0.1);
}

#[test]
fn a_stop_needs_neither_permission_nor_a_scan() {
    let mut rig = Rig::new(&[]);
    rig.walls = Some(Vec::new());
    rig.inject("permit", Bool { data: false });
    rig.step();
    rig.walls = None;
    for _ in 0..20 {
        rig.step();
    }
    rig.order(5, &[]);
    rig.step();
    assert_eq!(rig.events().len(), 1);
    assert_eq!(rig.reports(), [""; 0]);
}

#[test]
fn it_reports_once_that_obstacles_do_not_limit_it() {
    let words = "notice: without a scan, obstacles do not limit the speed";
    let mut rig = Rig::new(&[]);
    rig.step();
    assert_eq!(rig.reports(), [""; 0], "not before it drives");
    for order in 1..3 {
        rig.order(order, &AHEAD);
        rig.step();
        rig.step();
        assert_eq!(rig.reports(), [words]);
    }
    // a scan of which most beams measured nothing shows nothing
    let mut blind = rig.scan(&[]);
    blind.ranges.fill(f32::NAN);
    let mut rig = Rig::new(&[]);
    rig.step();
    rig.inject("scan", blind);
    rig.order(1, &AHEAD);
    rig.step();
    assert_eq!(rig.reports(), [words]);
}

#[test]
fn a_start_forgets_the_order_and_what_it_reported() {
    let mut rig = Rig::new(&[]);
    rig.order(1, &AHEAD);
    rig.step();
    rig.step();
    let driven = rig.commands().len();
    rig.run.transition("Follower", Transition::Stop).unwrap();
    let after_stop = rig.commands().len();
    assert_eq!(after_stop, driven + 1, "the safe sample");
    assert_eq!(rig.commands().last().unwrap().1, Twist::default());
    rig.run.transition("Follower", Transition::Start).unwrap();
    assert_eq!((rig.step(), rig.step()), (None, None));
    rig.order(2, &AHEAD);
    rig.step();
    assert!(rig.speed > 0.1);
    assert_eq!(rig.reports().len(), 2, "{:?}", rig.reports());
}

/// Points every 2 cm from one place to another.
fn wall(from: (f64, f64), to: (f64, f64)) -> Vec<Point> {
    let (from, to) = (Point::new(from.0, from.1), Point::new(to.0, to.1));
    let count = ((to - from).norm() / 0.02).ceil().max(1.0) as u32;
    (0..=count)
        .map(|n| from + (to - from) * (f64::from(n) / f64::from(count)))
        .collect()
}

#[test]
fn it_stands_before_a_wall_at_the_margin() {
    for margin in [0.03, 0.25] {
        let mut rig = Rig::new(&[("stop_margin_m", Datum::Float(margin))]);
        rig.walls = Some(wall((2.0, -1.0), (2.0, 1.0)));
        rig.order(1, &AHEAD);
        for _ in 0..600 {
            rig.step();
        }
        let gap = 2.0 - 0.2 - rig.pose.translation.x;
        assert!((gap - margin).abs() < 0.01, "{gap} m at {margin}");
        assert!(rig.speed < 0.02, "{}", rig.speed);
    }
}

#[test]
fn the_mount_places_what_the_laser_sees() {
    // the laser sits 1 m left of the centre and looks back: it sees a wall at (2, 0) behind and to its left
    let turned = Datum::List(vec![Datum::Float(0.0), Datum::Float(1.0), Datum::Float(PI)]);
    let mut rig = Rig::new(&[("mount", turned)]);
    rig.order(1, &AHEAD);
    for _ in 0..600 {
        let robot = rig.pose;
        rig.pose = robot * heading(Point::new(0.0, 1.0), PI);
        let scan = rig.scan(&wall((2.0, -1.0), (2.0, 1.0)));
        rig.pose = robot;
        rig.inject("odom", rig.odometry());
        rig.inject("scan", scan);
        rig.pass();
    }
    let gap = 2.0 - 0.2 - rig.pose.translation.x;
    assert!((0.02..0.1).contains(&gap), "{gap}");
}

/// Describes a drive: where the robot was every half second, and what it was commanded.
fn described(rig: &mut Rig, places: &[(f64, f64, f64)]) -> String {
    let mut text = String::new();
    rig.order(1, places);
    let mut periods = 0;
    while rig.events().is_empty() {
        rig.step();
        if periods % 10 == 0 {
            let Pose {
                translation: at, ..
            } = rig.pose;
            let (speed, turn) = (rig.speed, rig.turn);
            let yaw = yaw(&rig.pose);
            writeln!(
                text,
                "{:5.1} s: ({:.9}, {:.9}, {yaw:.9})  {speed:.9} m/s  {turn:.9} rad/s",
                f64::from(periods) * PERIOD,
                at.x,
                at.y,
            )
            .unwrap();
        }
        periods += 1;
        assert!(periods < 2000, "{text}");
    }
    let detail = &rig.events()[0].detail;
    writeln!(text, "{:5.1} s: {detail}", f64::from(periods) * PERIOD).unwrap();
    text
}

/// A slalom with a turn on the spot at both ends, between walls that touch neither the path nor the robot.
fn slalom() -> (Vec<(f64, f64, f64)>, Vec<Point>) {
    let places = (0..=60).map(|n| {
        let x = f64::from(n) * 0.1;
        (x, 0.6 * (x * PI / 3.0).sin(), PI / 2.0)
    });
    let mut walls = wall((-0.5, 1.1), (6.5, 1.1));
    walls.extend(wall((1.5, 0.05), (1.5, 0.32)));
    walls.extend(wall((3.1, 0.26), (3.3, 0.4)));
    walls.extend(wall((4.5, -0.86), (4.6, -1.3)));
    (places.collect(), walls)
}

#[test]
fn the_commands_of_a_drive_are_those_of_the_snapshot() {
    let (places, walls) = slalom();
    for (name, walls) in [("without_a_laser", None), ("between_walls", Some(walls))] {
        let mut rig = Rig::new(&[]);
        rig.pose = heading(Point::new(0.0, 0.05), -2.0);
        rig.walls = walls;
        let drive = described(&mut rig, &places);
        insta::assert_snapshot!(format!("drive_{name}"), drive);
    }
}
