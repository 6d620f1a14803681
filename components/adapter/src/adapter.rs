//! The component: reads path, scan and odometry; writes the adapted path, events and obstacles.

use std::time::Duration;

use asmotion_component::{
    Component, Cycle, Fault, Flow, Freeze, In, Interface, NOTICE_REPORT, Out, Ports, Properties,
    PropertySet, Time, freeze_by_fields,
};
use asmotion_geometry::{Distances, Point, Trail, heading, message};
use asmotion_messages::{
    Bool, Event, LaserScan, Obstacles, OccupancyGrid, Odometry, Path, Time as Stamp,
};

use crate::advice::{Advice, Adviser, BlockedCause, Patience};
use crate::bend_limits::BendLimits;
use crate::memory::ScanMemory;
use crate::obstacle_reports::{Blockers, obstacles_on_path};

/// `nav::TrajectoryAdapter`: passes the path on, bent around obstacles seen by the laser; publishes `BLOCKED` once for
/// a path.
#[derive(Freeze)]
#[freeze(component = "nav::TrajectoryAdapter", version = 1)]
pub struct TrajectoryAdapter {
    #[freeze(skip)]
    ports: AdapterPorts,
    properties: PropertySet<AdapterProperties>,

    adviser: Adviser,
    trail: Trail,
    memory: ScanMemory,
    blockers: Blockers,
    /// Distances to the map's obstacles.
    known: Option<Distances>,
    /// The cycle that received the newest usable scan.
    seen: Option<Time>,
    /// Time of the last publication of obstacles, and whether there were any.
    last_report: Option<(Time, bool)>,
}

#[derive(Ports)]
struct AdapterPorts {
    /// Planned path, map frame. A path without poses is an order to stop and is passed on at once.
    path: In<Path>,
    /// Scan of the laser at `mount`. Until the first one arrives paths are passed on unchanged.
    scan: In<LaserScan>,
    /// Pose of the robot, map frame; a scan is placed by its stamp, so a buffered connection is best.
    odom: In<Odometry>,
    /// Optional: map whose obstacles are known. They are neither remembered nor published, and detours keep clear of
    /// them.
    map: In<OccupancyGrid>,
    /// Optional: permission to drive. A robot without permission is not stuck.
    permit: In<Bool>,
    /// Path to follow, published whenever it changes: as planned, bent (same header and goal), or empty to stop.
    adapted: Out<Path>,
    /// `BLOCKED`, once for a path without a way through; the detail says where, `plan` is the stamp of the path.
    event: Out<Event>,
    /// Obstacles for the planner, map frame: with a map, those that it does not show; without one, those that recently
    /// blocked a path. Always published before `BLOCKED`.
    obstacles: Out<Obstacles>,
}

#[derive(Properties)]
struct AdapterProperties {
    #[property(flatten)]
    limits: BendLimits,
    #[property(flatten)]
    patience: Patience,
    /// Range beyond which hits of the laser are ignored.
    #[property(unit = "m", range = 0.1..=100.0, default = 6.0)]
    sight_m: f64,
    /// Time for which an obstacle out of sight is remembered.
    #[property(range = "0s"..="3600s", default = "60s")]
    memory_s: Duration,
    /// Time without a scan after which the robot is stopped until the laser works again.
    #[property(range = "0s"..="60s", default = "500ms")]
    scan_timeout_s: Duration,
    /// Distance from an occupied cell of the map up to which a hit counts as shown by the map.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.15)]
    map_tolerance_m: f64,
    /// Interval between two publications of obstacles, if there is a map.
    #[property(range = "0s"..="60s", default = "500ms")]
    obstacles_period_s: Duration,
    /// Pose of the laser on the robot: x m, y m, yaw rad, base frame. Must equal the laser driver's.
    mount: [f64; 3],
}

impl TrajectoryAdapter {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            properties: interface.properties(),
            adviser: Adviser::default(),
            trail: Trail::default(),
            memory: ScanMemory::default(),
            blockers: Blockers::default(),
            known: None,
            seen: None,
            last_report: None,
        }
    }

    /// Reads odometry, map and scan.
    fn process_scan(&mut self, cycle: &mut Cycle<'_>, now: Time) {
        for odometry in cycle.all(self.ports.odom) {
            let pose = message::pose(&odometry.pose.pose);
            self.trail.add(odometry.header.stamp.as_nanos(), pose);
        }
        if let Flow::NewData(map) = cycle.read(self.ports.map) {
            match message::grid(map) {
                Ok(grid) => {
                    self.known = Some(Distances::to_occupied(&grid));
                    self.memory.clear();
                }
                Err(error) => cycle.report(NOTICE_REPORT, format!("no map: {error}").into()),
            }
        }
        if let Flow::NewData(scan) = cycle.read(self.ports.scan) {
            let nanos = scan.header.stamp.as_nanos();
            if let Some(robot) = self.trail.at(nanos) {
                let AdapterProperties {
                    mount: [x, y, yaw],
                    map_tolerance_m,
                    sight_m,
                    ..
                } = *self.properties;
                let laser = robot * heading(Point::new(x, y), yaw);
                let radius = self.properties.limits.robot_radius_m;
                self.memory
                    .forget_under(robot.translation.vector.into(), radius);
                let known = self.known.as_ref();
                let is_news =
                    |point| !known.is_some_and(|known| is_mapped(known, point, map_tolerance_m));
                self.memory.update(scan, &laser, nanos, sight_m, is_news);
                self.seen = Some(now);
            }
        }
        let since = now - self.properties.memory_s;
        self.memory.forget_before(since.nanos());
    }

    /// Decides on the path.
    fn advise(&mut self, cycle: &Cycle<'_>, now: Time) -> Advice {
        if let Flow::NewData(path) = cycle.read(self.ports.path) {
            let advice = self.adviser.set_path(path);
            if advice.path.is_some() {
                return advice;
            }
        }
        let timeout = self.properties.scan_timeout_s;
        let sees = self.seen.is_some_and(|at| now.since(at) <= timeout);
        match self.trail.newest() {
            Some(robot) if sees => {
                if cycle
                    .read(self.ports.permit)
                    .any()
                    .is_some_and(|permit| !permit.data)
                {
                    self.adviser.reset_progress();
                }
                let AdapterProperties {
                    limits, patience, ..
                } = &*self.properties;
                let (points, known) = (self.memory.points(), self.known.as_ref());
                self.adviser
                    .advise(now, robot, points, known, limits, patience)
            }
            _ => self.adviser.advise_without_scan(self.seen.is_some()),
        }
    }

    /// Publishes obstacles for the planner. With a map: everything that the map does not show, every
    /// `obstacles_period_s`, at once when the path is blocked, and once when nothing is left. Without a map: the
    /// obstacles that have blocked a path.
    fn report_obstacles(&mut self, cycle: &mut Cycle<'_>, now: Time, blocked: bool) {
        let points = match &self.known {
            Some(_) => self
                .is_report_due(now, blocked)
                .then(|| self.memory.points().collect()),
            None => {
                let since = now - self.properties.memory_s;
                let forgot = self.blockers.forget_before(since.nanos());
                if let (Some(route), true) = (self.adviser.route(), blocked) {
                    let on_it =
                        obstacles_on_path(self.memory.points(), route, &self.properties.limits);
                    self.blockers.add(&on_it, now.nanos());
                }
                (blocked || forgot).then(|| self.blockers.points())
            }
        };
        let Some(points) = points else {
            return;
        };
        let had_any = self.last_report.is_some_and(|(_, any)| any);
        self.last_report = Some((now, !points.is_empty()));
        if !points.is_empty() || had_any {
            cycle.write(self.ports.obstacles, obstacles(now, &points));
        }
    }

    /// Returns whether obstacles must be published in this cycle.
    fn is_report_due(&self, now: Time, blocked: bool) -> bool {
        let period = self.properties.obstacles_period_s;
        blocked
            || self
                .last_report
                .is_none_or(|(at, _)| now.since(at) >= period)
    }
}

impl Component for TrajectoryAdapter {
    freeze_by_fields!();

    fn start(&mut self) -> Result<(), Fault> {
        self.adviser = Adviser::default();
        self.trail = Trail::default();
        self.memory.clear();
        self.blockers = Blockers::default();
        self.seen = None;
        self.last_report = None;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let now = cycle.now();
        self.properties.refresh(cycle);
        self.process_scan(cycle, now);
        let advice = self.advise(cycle, now);
        if let Some(path) = advice.path {
            cycle.write(self.ports.adapted, path);
        }
        self.report_obstacles(cycle, now, advice.blocked.is_some());
        if let Some(cause) = advice.blocked {
            let plan = self
                .adviser
                .route()
                .map(|route| route.planned().header.stamp);
            let event = blocked(now, cause).about(plan.unwrap_or_default());
            cycle.write(self.ports.event, event);
        }
        Ok(())
    }
}

/// Returns whether the map shows an obstacle within `tolerance` metres of a point.
fn is_mapped(known: &Distances, point: Point, tolerance: f64) -> bool {
    let cell = known.layout().cell(point);
    let distance = cell.and_then(|cell| known.metres(cell));
    distance.is_some_and(|distance| distance <= tolerance)
}

fn obstacles(now: Time, points: &[Point]) -> Obstacles {
    Obstacles {
        stamp: Stamp::from_nanos(now.nanos()),
        points: points.iter().map(message::vertex_message).collect(),
    }
}

fn blocked(now: Time, cause: BlockedCause) -> Event {
    let detail = match cause {
        BlockedCause::Barrier(barrier) => {
            let (at, ahead) = (barrier.point, barrier.ahead);
            format!("no way past ({:.2}, {:.2}), {ahead:.2} m ahead", at.x, at.y)
        }
        BlockedCause::Stuck(at) => {
            format!("the robot gets no farther than ({:.2}, {:.2})", at.x, at.y)
        }
    };
    Event::new(now.nanos(), Event::BLOCKED, detail)
}
