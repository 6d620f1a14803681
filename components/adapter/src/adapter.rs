//! The component: path, scan and odometry in; the adapted path, events and obstacles out.

use asmotion_component::{Component, Cycle, Fault, Flow, In, Interface, Out, Property};
use asmotion_geometry::{Distances, Point, heading, message};
use asmotion_messages::{
    Bool, Disc, Event, LaserScan, Obstacles, OccupancyGrid, Odometry, Path, Time,
};

use crate::advice::{Advice, Adviser, Cause, Patience};
use crate::bend::Limits;
use crate::memory::Memory;
use crate::news::{Blockers, everything, on_the_path};
use crate::trail::Trail;

/// `nav::TrajectoryAdapter`: passes the path on, bent around what the laser sees; says `BLOCKED` once a path.
pub struct TrajectoryAdapter {
    path: In<Path>,
    scan: In<LaserScan>,
    odom: In<Odometry>,
    map: In<OccupancyGrid>,
    permit: In<Bool>,
    adapted: Out<Path>,
    event: Out<Event>,
    obstacles: Out<Obstacles>,
    properties: Properties,

    adviser: Adviser,
    trail: Trail,
    memory: Memory,
    blockers: Blockers,
    /// How far each place on the map is from what the map knows.
    known: Option<Distances>,
    /// When the newest usable scan came, ns.
    seen: Option<i64>,
    /// When obstacles were told last, ns, and whether there were any.
    told: Option<(i64, bool)>,
}

struct Properties {
    robot_radius: Property<f64>,
    margin: Property<f64>,
    comfort: Property<f64>,
    reach: Property<f64>,
    horizon: Property<f64>,
    hold: Property<f64>,
    looks: Property<u32>,
    stuck: Property<f64>,
    sight: Property<f64>,
    memory: Property<f64>,
    scan_timeout: Property<f64>,
    map_tolerance: Property<f64>,
    obstacles_period: Property<f64>,
    mount: Property<[f64; 3]>,
}

impl TrajectoryAdapter {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            path: interface.input("path", "the planned path, map frame; without poses: stop"),
            scan: interface.input(
                "scan",
                "what the laser sees; without any scan the path is passed on",
            ),
            odom: interface.input("odom", "where the robot is, map frame"),
            map: interface.input(
                "map",
                "optional: what it shows is no news, and detours keep clear of it",
            ),
            permit: interface.input(
                "permit",
                "optional: whether the robot may drive; one that may not is not stuck",
            ),
            adapted: interface.output(
                "adapted",
                "the path to follow, whenever it is another; without poses: stop",
            ),
            event: interface.output("event", "BLOCKED once a path that leads nowhere"),
            obstacles: interface.output(
                "obstacles",
                "what a planner should know: all that the map does not show, or without a map what blocked the way; map frame",
            ),
            properties: Properties::declare(interface),
            adviser: Adviser::default(),
            trail: Trail::default(),
            memory: Memory::default(),
            blockers: Blockers::default(),
            known: None,
            seen: None,
            told: None,
        }
    }

    /// Takes in where the robot is, what the map knows and what the laser sees.
    fn perceive(&mut self, cycle: &Cycle<'_>, now: i64) -> Result<(), Fault> {
        for odometry in cycle.all(self.odom) {
            let pose = message::pose(&odometry.pose.pose);
            self.trail.add(odometry.header.stamp.as_nanos(), pose);
        }
        if let Flow::NewData(map) = cycle.read(self.map) {
            self.known = Some(Distances::to_occupied(&message::grid(map)?));
            self.memory.clear();
        }
        if let Flow::NewData(scan) = cycle.read(self.scan) {
            let nanos = scan.header.stamp.as_nanos();
            if let Some(robot) = self.trail.at(nanos) {
                let [x, y, yaw] = cycle.property(self.properties.mount);
                let laser = robot * heading(Point::new(x, y), yaw);
                let tolerance = cycle.property(self.properties.map_tolerance);
                let sight = cycle.property(self.properties.sight);
                let known = self.known.as_ref();
                let is_news = |point| !known.is_some_and(|known| shows(known, point, tolerance));
                self.memory.look(scan, &laser, nanos, sight, is_news);
                self.seen = Some(now);
            }
        }
        self.memory.forget_before(now - self.properties.kept(cycle));
        Ok(())
    }

    /// Makes up its mind about the path.
    fn advise(&mut self, cycle: &Cycle<'_>, now: i64) -> Advice {
        if let Flow::NewData(path) = cycle.read(self.path) {
            let advice = self.adviser.order(path);
            if advice.path.is_some() {
                return advice;
            }
        }
        let timeout = (cycle.property(self.properties.scan_timeout) * 1e9) as i64;
        let sees = self.seen.is_some_and(|at| now - at <= timeout);
        match self.trail.newest() {
            Some(robot) if sees => {
                let (limits, patience) = (
                    self.properties.limits(cycle),
                    self.properties.patience(cycle),
                );
                if (cycle.read(self.permit).any()).is_some_and(|permit| !permit.data) {
                    self.adviser.wait();
                }
                let points = self.memory.points();
                self.adviser
                    .look(now, robot, points, self.known.as_ref(), &limits, &patience)
            }
            _ => self.adviser.blind(self.seen.is_some()),
        }
    }

    /// Tells a planner what it should know. With a map that is everything the map does not show: now and then, at once
    /// when the way is blocked, and once when nothing is left. Without a map it is what blocked the way.
    fn tell(&mut self, cycle: &mut Cycle<'_>, now: i64, blocked: bool) {
        let discs = match &self.known {
            Some(_) => self.due(cycle, now, blocked).then(|| {
                let points: Vec<Point> = self.memory.points().collect();
                everything(&points)
            }),
            None => {
                let limits = self.properties.limits(cycle);
                let forgot = self
                    .blockers
                    .forget_before(now - self.properties.kept(cycle));
                if let (Some(route), true) = (self.adviser.route(), blocked) {
                    let on_it = on_the_path(self.memory.points(), route, &limits);
                    self.blockers.add(&on_it, now);
                }
                (blocked || forgot).then(|| self.blockers.discs())
            }
        };
        let Some(discs) = discs else {
            return;
        };
        let had_any = self.told.is_some_and(|(_, any)| any);
        self.told = Some((now, !discs.is_empty()));
        if !discs.is_empty() || had_any {
            cycle.write(self.obstacles, obstacles(now, &discs));
        }
    }

    /// Whether it is time to tell again.
    fn due(&self, cycle: &Cycle<'_>, now: i64, blocked: bool) -> bool {
        let period = (cycle.property(self.properties.obstacles_period) * 1e9) as i64;
        blocked || self.told.is_none_or(|(at, _)| now - at >= period)
    }
}

impl Component for TrajectoryAdapter {
    fn start(&mut self) -> Result<(), Fault> {
        self.adviser = Adviser::default();
        self.trail = Trail::default();
        self.memory.clear();
        self.blockers = Blockers::default();
        self.seen = None;
        self.told = None;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let now = cycle.now().nanos();
        self.perceive(cycle, now)?;
        let advice = self.advise(cycle, now);
        if let Some(path) = advice.path {
            cycle.write(self.adapted, path);
        }
        self.tell(cycle, now, advice.blocked.is_some());
        if let Some(cause) = advice.blocked {
            cycle.write(self.event, blocked(now, cause));
        }
        Ok(())
    }
}

/// Whether the map shows something within `tolerance` metres of a point.
fn shows(known: &Distances, point: Point, tolerance: f64) -> bool {
    let cell = known.layout().cell(point);
    let distance = cell.and_then(|cell| known.metres(cell));
    distance.is_some_and(|distance| distance <= tolerance)
}

fn obstacles(now: i64, discs: &[asmotion_geometry::Disc]) -> Obstacles {
    let disc = |disc: &asmotion_geometry::Disc| Disc {
        x: disc.centre.x,
        y: disc.centre.y,
        radius: disc.radius,
    };
    Obstacles {
        stamp: Time::from_nanos(now),
        discs: discs.iter().map(disc).collect(),
    }
}

fn blocked(now: i64, cause: Cause) -> Event {
    let detail = match cause {
        Cause::Barrier(barrier) => {
            let (at, ahead) = (barrier.point, barrier.ahead);
            format!("no way past ({:.2}, {:.2}), {ahead:.2} m ahead", at.x, at.y)
        }
        Cause::Stuck(at) => format!("the robot gets no farther than ({:.2}, {:.2})", at.x, at.y),
    };
    Event::new(now, Event::BLOCKED, detail)
}

impl Properties {
    fn declare(interface: &mut Interface) -> Self {
        let mut number =
            |name: &str, default: f64, least: f64, most: f64, unit: &str, doc: &str| {
                let setting = interface.setting(name, default, doc);
                setting.range(least..=most).unit(unit).declare()
            };
        Self {
            robot_radius: number(
                "robot_radius_m",
                0.2,
                0.0,
                10.0,
                "m",
                "of the disc that covers the robot",
            ),
            margin: number(
                "margin_m",
                0.08,
                0.0,
                10.0,
                "m",
                "between the robot and an obstacle at least",
            ),
            comfort: number(
                "comfort_m",
                0.2,
                0.0,
                10.0,
                "m",
                "between the robot and an obstacle if it costs little",
            ),
            reach: number(
                "reach_m",
                1.0,
                0.05,
                10.0,
                "m",
                "how far from the planned path a detour may lead",
            ),
            horizon: number(
                "horizon_m",
                4.0,
                0.5,
                50.0,
                "m",
                "how far ahead the path is looked at",
            ),
            hold: number(
                "hold_m",
                1.0,
                0.0,
                50.0,
                "m",
                "a barrier nearer than this stops the robot at once",
            ),
            stuck: number(
                "stuck_s",
                10.0,
                0.5,
                3600.0,
                "s",
                "a robot that gets no farther for so long is blocked",
            ),
            sight: number(
                "sight_m",
                6.0,
                0.1,
                100.0,
                "m",
                "hits farther away are not looked at",
            ),
            memory: number(
                "memory_s",
                60.0,
                0.0,
                3600.0,
                "s",
                "how long an obstacle out of sight is remembered",
            ),
            scan_timeout: number(
                "scan_timeout_s",
                0.5,
                0.0,
                60.0,
                "s",
                "without a scan for so long the robot is stopped",
            ),
            map_tolerance: number(
                "map_tolerance_m",
                0.15,
                0.0,
                10.0,
                "m",
                "a hit this near to an occupied cell is no news",
            ),
            obstacles_period: number(
                "obstacles_period_s",
                0.5,
                0.0,
                60.0,
                "s",
                "how often obstacles are told, if there is a map",
            ),
            looks: interface
                .setting(
                    "looks",
                    3,
                    "how many looks in a row must find no way before the path counts as blocked",
                )
                .range(1..=100)
                .declare(),
            mount: interface.property(
                "mount",
                [0.0; 3],
                "the laser on the robot: x m, y m, yaw rad, base frame",
            ),
        }
    }

    fn limits(&self, cycle: &Cycle<'_>) -> Limits {
        let radius = cycle.property(self.robot_radius);
        let margin = cycle.property(self.margin);
        Limits {
            clearance: radius + margin,
            comfort: radius + cycle.property(self.comfort).max(margin),
            reach: cycle.property(self.reach),
            horizon: cycle.property(self.horizon),
        }
    }

    /// ns, how long things are remembered.
    fn kept(&self, cycle: &Cycle<'_>) -> i64 {
        (cycle.property(self.memory) * 1e9) as i64
    }

    fn patience(&self, cycle: &Cycle<'_>) -> Patience {
        Patience {
            looks: cycle.property(self.looks),
            hold: cycle.property(self.hold),
            stuck: (cycle.property(self.stuck) * 1e9) as i64,
        }
    }
}
