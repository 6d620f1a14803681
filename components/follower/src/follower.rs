//! The component: path and odometry in, twist and events out.

use asmotion_component::{Component, Cycle, Fault, Flow, In, Interface, Out, Property};
use asmotion_geometry::message;
use asmotion_messages::{Bool, Event, Odometry, Path, Twist};

use crate::pursuit::Settings;
use crate::task::{Motion, News, Task, Tolerance};

/// `nav::TrajectoryFollower`: follows the newest path; says `REACHED` once at its end, `HALTED` once after a stop.
pub struct TrajectoryFollower {
    path: In<Path>,
    odom: In<Odometry>,
    permit: In<Bool>,
    twist: Out<Twist>,
    event: Out<Event>,
    properties: Properties,

    task: Task,
    /// The frame of the newest path.
    frame: String,
    /// When the newest odometry came, ns.
    located: Option<i64>,
    /// Why the robot does not move although there is something to do; reported once.
    hindered: Option<&'static str>,
    /// Whether the last command was not zero or belonged to a task.
    commanding: bool,
}

struct Properties {
    max_speed: Property<f64>,
    min_curve_speed: Property<f64>,
    min_approach_speed: Property<f64>,
    max_turn: Property<f64>,
    braking: Property<f64>,
    turn_braking: Property<f64>,
    lookahead: Property<f64>,
    lookahead_min: Property<f64>,
    lookahead_max: Property<f64>,
    corner_cut: Property<f64>,
    curve_radius: Property<f64>,
    approach: Property<f64>,
    rotate_from: Property<f64>,
    goal_tolerance: Property<f64>,
    goal_heading: Property<bool>,
    heading_tolerance: Property<f64>,
    standing_speed: Property<f64>,
    standing_turn: Property<f64>,
    odom_timeout: Property<f64>,
}

impl TrajectoryFollower {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            path: interface.input("path", "the path to follow; without poses: stop"),
            odom: interface.input("odom", "where the robot is, in the frame of the path"),
            permit: interface.input("permit", "optional: whether it may drive"),
            twist: interface.output(
                "twist",
                "the velocity to drive: linear.x m/s, angular.z rad/s, base frame",
            ),
            event: interface.output("event", "REACHED once a path, HALTED once a stop"),
            properties: Properties::declare(interface),
            task: Task::default(),
            frame: String::new(),
            located: None,
            hindered: None,
            commanding: false,
        }
    }

    /// Why nothing may be driven on this odometry, if so.
    fn hindrance(&self, cycle: &Cycle<'_>, odometry: Option<&Odometry>) -> Option<&'static str> {
        let timeout = (cycle.property(self.properties.odom_timeout) * 1e9) as i64;
        let now = cycle.now().nanos();
        let fresh = self.located.is_some_and(|at| now - at <= timeout);
        let frame = |odometry: &Odometry| odometry.header.frame_id == self.frame;
        match odometry {
            None => Some("no odometry"),
            Some(odometry) if !motion(odometry).is_finite() => Some("odometry without numbers"),
            Some(_) if !self.is_permitted(cycle) => Some("no permission to drive"),
            Some(_) if !fresh || cycle.is_stale(self.odom) => Some("stale odometry"),
            Some(odometry) if !self.frame.is_empty() && !frame(odometry) => {
                Some("odometry in another frame")
            }
            Some(_) => None,
        }
    }
}

impl TrajectoryFollower {
    /// Whether a path may be driven: nobody has said no. A stop may always be finished.
    fn is_permitted(&self, cycle: &Cycle<'_>) -> bool {
        let permit = cycle.read(self.permit).any();
        !self.task.is_following() || permit.is_none_or(|permit| permit.data)
    }
}

impl Component for TrajectoryFollower {
    fn start(&mut self) -> Result<(), Fault> {
        self.task = Task::default();
        self.located = None;
        self.commanding = false;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let now = cycle.now().nanos();
        if let Flow::NewData(path) = cycle.read(self.path) {
            self.task.order(path);
            self.frame.clone_from(&path.header.frame_id);
        }
        let odometry = match cycle.read(self.odom) {
            Flow::NewData(odometry) => {
                self.located = Some(now);
                Some(odometry)
            }
            Flow::OldData(odometry) => Some(odometry),
            Flow::NoData => None,
        };
        let hindrance = self
            .hindrance(cycle, odometry)
            .filter(|_| self.task.is_busy());
        let motion = odometry.filter(|_| hindrance.is_none()).map(motion);
        if hindrance != self.hindered {
            self.hindered = hindrance;
            cycle.report("hindered", hindrance.unwrap_or("no more").into());
        }
        let busy = self.task.is_busy();
        let (twist, news) = match &motion {
            Some(motion) => {
                let (settings, tolerance) = (
                    self.properties.settings(cycle),
                    self.properties.tolerance(cycle),
                );
                self.task.step(&settings, &tolerance, motion)
            }
            None => (Twist::default(), None),
        };
        // a follower without a task is silent, so that others may drive; its last word is zero
        if busy || self.commanding {
            cycle.write(self.twist, twist);
        }
        self.commanding = busy;
        if let (Some(news), Some(motion)) = (news, motion) {
            cycle.write(self.event, event(now, news, &motion));
        }
        Ok(())
    }
}

fn motion(odometry: &Odometry) -> Motion {
    Motion {
        pose: message::pose(&odometry.pose.pose),
        speed: odometry.twist.twist.linear.x,
        turn: odometry.twist.twist.angular.z,
    }
}

fn event(now: i64, news: News, motion: &Motion) -> Event {
    let code = match news {
        News::Reached => Event::REACHED,
        News::Halted => Event::HALTED,
    };
    let place = motion.pose.translation;
    Event::new(now, code, format!("at ({:.2}, {:.2})", place.x, place.y))
}

impl Properties {
    fn declare(interface: &mut Interface) -> Self {
        let mut number =
            |name: &str, default: f64, least: f64, most: f64, unit: &str, doc: &str| {
                let setting = interface.setting(name, default, doc);
                setting.range(least..=most).unit(unit).declare()
            };
        Self {
            max_speed: number("max_speed", 0.5, 0.0, 10.0, "m/s", "on a straight line"),
            min_curve_speed: number(
                "min_curve_speed",
                0.15,
                0.01,
                10.0,
                "m/s",
                "never slower on account of a curve",
            ),
            min_approach_speed: number(
                "min_approach_speed",
                0.05,
                0.01,
                10.0,
                "m/s",
                "never slower before the goal",
            ),
            max_turn: number("max_turn", 1.2, 0.01, 20.0, "rad/s", "never turns faster"),
            braking: number(
                "braking",
                0.4,
                0.01,
                50.0,
                "m/s²",
                "the braking on which the approach counts",
            ),
            turn_braking: number(
                "turn_braking",
                1.5,
                0.01,
                100.0,
                "rad/s²",
                "the braking of a turn on the spot",
            ),
            lookahead: number(
                "lookahead_s",
                1.2,
                0.0,
                60.0,
                "s",
                "how far ahead the carrot is at the present speed",
            ),
            lookahead_min: number(
                "lookahead_min_m",
                0.25,
                0.01,
                100.0,
                "m",
                "the nearest carrot",
            ),
            lookahead_max: number(
                "lookahead_max_m",
                0.7,
                0.01,
                100.0,
                "m",
                "the farthest carrot",
            ),
            corner_cut: number(
                "corner_cut_m",
                0.04,
                0.001,
                10.0,
                "m",
                "how far the way to the carrot may leave the path",
            ),
            curve_radius: number(
                "curve_radius_m",
                0.8,
                0.0,
                100.0,
                "m",
                "tighter curves are driven more slowly",
            ),
            approach: number(
                "approach_m",
                0.6,
                0.0,
                100.0,
                "m",
                "from here to the goal the robot slows down",
            ),
            rotate_from: number(
                "rotate_from",
                0.785,
                0.2,
                1.57,
                "rad",
                "what is farther aside is first turned to on the spot",
            ),
            goal_tolerance: number(
                "goal_tolerance_m",
                0.05,
                0.005,
                10.0,
                "m",
                "so near the end is reached",
            ),
            heading_tolerance: number(
                "heading_tolerance",
                0.1,
                0.01,
                3.2,
                "rad",
                "so near the heading of the last pose is right",
            ),
            standing_speed: number(
                "standing_speed",
                0.01,
                1e-6,
                1.0,
                "m/s",
                "slower is standing",
            ),
            standing_turn: number(
                "standing_turn",
                0.02,
                1e-6,
                1.0,
                "rad/s",
                "slower is standing",
            ),
            odom_timeout: number(
                "odom_timeout_s",
                0.2,
                0.0,
                10.0,
                "s",
                "odometry older than this is not driven on",
            ),
            goal_heading: interface.property(
                "goal_heading",
                true,
                "whether the heading of the last pose matters",
            ),
        }
    }

    fn settings(&self, cycle: &Cycle<'_>) -> Settings {
        Settings {
            speed: cycle.property(self.max_speed),
            speed_in_curves: cycle.property(self.min_curve_speed),
            speed_at_goal: cycle.property(self.min_approach_speed),
            turn: cycle.property(self.max_turn),
            braking: cycle.property(self.braking),
            turn_braking: cycle.property(self.turn_braking),
            lookahead_time: cycle.property(self.lookahead),
            lookahead_min: cycle.property(self.lookahead_min),
            lookahead_max: cycle.property(self.lookahead_max),
            cut: cycle.property(self.corner_cut),
            regulated_radius: cycle.property(self.curve_radius),
            approach: cycle.property(self.approach),
            rotate_from: cycle.property(self.rotate_from),
        }
    }

    fn tolerance(&self, cycle: &Cycle<'_>) -> Tolerance {
        let heading = cycle.property(self.heading_tolerance);
        Tolerance {
            position: cycle.property(self.goal_tolerance),
            heading: cycle.property(self.goal_heading).then_some(heading),
            standing: cycle.property(self.standing_speed),
            standing_turn: cycle.property(self.standing_turn),
        }
    }
}
