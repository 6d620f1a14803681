//! The component: receives requests, returns and publishes paths.

use asmotion_component::{
    CallId, Component, Cycle, Fault, Freeze, In, Interface, Out, Ports, Properties, PropertySet,
    Provided, RequestId, Required, ServiceFault, freeze_by_fields,
};
use asmotion_geometry::{Grid, OCCUPIED, Point, Pose, message};
use asmotion_messages::{
    GetMap, Obstacles, OccupancyGrid, Path, Place, Plan as PlanOperation, PlanRequest,
};

use crate::planner::{NoPath, PlannedPath, Planner, PlannerSettings};
use crate::planners::{PLANNERS, Planners};

/// `nav::TrajectoryPlanner`: provides `plan`, and publishes each path that it finds.
///
/// A request without a map uses the map from the reference `maps`. Obstacles that the robot saw and the map does not
/// show are read from the port `obstacles`.
#[derive(Freeze)]
#[freeze(component = "nav::TrajectoryPlanner", version = 1)]
pub struct TrajectoryPlanner {
    #[freeze(skip)]
    ports: PlannerPorts,
    properties: PropertySet<PlannerProperties>,
    #[freeze(skip)]
    planners: Planners,

    /// Planner with the name and settings it was created from. Not part of the state, since plans do not depend on
    /// earlier ones.
    #[freeze(reset)]
    made: Option<(String, PlannerSettings, Box<dyn Planner>)>,
    /// Requests that wait for a map, with the calls that fetch it.
    waiting: Vec<(CallId, RequestId, PlanRequest)>,
}

#[derive(Ports)]
struct PlannerPorts {
    /// `plan`: a path for a round robot, in the frame of the map. Faults `NO_PATH`, `START_OCCUPIED`, `GOAL_OCCUPIED`,
    /// `OUTSIDE`, `BAD_MAP`.
    planning: Provided<PlanOperation>,
    /// Map for requests without one.
    #[port(optional)]
    maps: Required<GetMap>,
    /// Optional: obstacles the map does not show, map frame. The cells that contain their points count as occupied, except
    /// the cell of the robot itself.
    obstacles: In<Obstacles>,
    /// Every path that was found, in the frame of the map.
    trajectory: Out<Path>,
}

#[derive(Properties)]
struct PlannerProperties {
    /// Planning algorithm.
    #[property(default = "astar", choices = PLANNERS.iter().map(|(name, _)| *name))]
    algorithm: String,
    #[property(flatten)]
    settings: PlannerSettings,
    /// Reduction of `inflation_m` for a second search if the first finds no path, because cells and measurements are not
    /// exact. With 0 there is no second search.
    #[property(unit = "m", range = 0.0..=1.0, default = 0.04)]
    squeeze_m: f64,
    /// Place whose map is requested from `maps` for a request without a map.
    place: String,
}

impl TrajectoryPlanner {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self::with_planners(interface, Planners::standard())
    }

    /// Declares ports and properties; `algorithm` chooses among these planners.
    pub fn with_planners(interface: &mut Interface, planners: Planners) -> Self {
        let ports = interface.ports();
        let properties = interface.properties();
        interface.set_choices("algorithm", planners.names());
        Self {
            ports,
            properties,
            planners,
            made: None,
            waiting: Vec::new(),
        }
    }

    /// Plans at once, or requests the map first.
    fn take(&mut self, cycle: &mut Cycle<'_>, id: RequestId, request: PlanRequest) {
        if !request.map.data.is_empty() {
            self.answer(cycle, id, &request.map, &request);
            return;
        }
        let name = self.properties.place.clone();
        let call = cycle.call(self.ports.maps, Place { name });
        self.waiting.push((call, id, request));
    }

    /// Continues the requests for which the map arrived or failed to.
    fn go_on(&mut self, cycle: &mut Cycle<'_>) {
        for reply in cycle.replies(self.ports.maps) {
            let Some(at) = self
                .waiting
                .iter()
                .position(|(call, ..)| *call == reply.call)
            else {
                continue;
            };
            let (_, id, request) = self.waiting.swap_remove(at);
            match reply.result {
                Ok(map) => self.answer(cycle, id, &map, &request),
                Err(error) => {
                    let detail = format!("the request has no map, and `maps` gave none: {error}");
                    self.refuse(cycle, id, ServiceFault::new("BAD_MAP", detail));
                }
            }
        }
    }

    fn answer(
        &mut self,
        cycle: &mut Cycle<'_>,
        id: RequestId,
        map: &OccupancyGrid,
        request: &PlanRequest,
    ) {
        match self.plan(cycle, map, request) {
            Ok(path) => {
                cycle.write(self.ports.trajectory, path.clone());
                cycle.reply(self.ports.planning, id, Ok(path));
            }
            Err(fault) => self.refuse(cycle, id, fault),
        }
    }

    fn refuse(&self, cycle: &mut Cycle<'_>, id: RequestId, fault: ServiceFault) {
        cycle.report("plan", fault.to_string().into());
        cycle.reply(self.ports.planning, id, Err(fault));
    }

    fn plan(
        &mut self,
        cycle: &mut Cycle<'_>,
        map: &OccupancyGrid,
        request: &PlanRequest,
    ) -> Result<Path, ServiceFault> {
        let frame = &map.header.frame_id;
        for (end, given) in [("start", &request.start), ("goal", &request.goal)] {
            let other = &given.header.frame_id;
            if !other.is_empty() && other != frame {
                let detail = format!("the {end} is in frame `{other}`, the map in `{frame}`");
                return Err(ServiceFault::new(PlanOperation::OUTSIDE, detail));
            }
        }
        let bad_map = |error: asmotion_geometry::GridLayoutError| {
            ServiceFault::new("BAD_MAP", error.to_string())
        };
        let mut grid = message::grid(map).map_err(bad_map)?;
        let (start, goal) = (
            message::pose(&request.start.pose),
            message::pose(&request.goal.pose),
        );
        if let Some(seen) = cycle.read(self.ports.obstacles).any() {
            add(&mut grid, seen, start.translation.vector.into());
        }
        let planned = match self.planner()?.plan(&grid, &start, &goal) {
            Err(why @ NoPath::Unreachable { .. }) => {
                let narrow = self.plan_narrowly(&grid, &start, &goal);
                narrow
                    .ok_or(why)
                    .map(|plan| (plan, " through a narrow place"))
            }
            planned => planned.map(|plan| (plan, "")),
        };
        let (plan, narrow) = planned.map_err(|why| fault(&why))?;
        let (length, explored) = (plan.length, plan.explored);
        cycle.report(
            "plan",
            format!("{length:.2} m{narrow}, {explored} cells searched").into(),
        );
        Ok(message::path(&plan.poses, cycle.now().nanos(), frame))
    }

    /// The path of a second search, with the inflation reduced by `squeeze_m`.
    fn plan_narrowly(&self, grid: &Grid, start: &Pose, goal: &Pose) -> Option<PlannedPath> {
        let PlannerProperties {
            algorithm,
            settings,
            squeeze_m,
            ..
        } = &*self.properties;
        let narrow = PlannerSettings {
            inflation_m: (settings.inflation_m - squeeze_m).max(0.0),
            ..settings.clone()
        };
        let planner = self.planners.make(algorithm, &narrow);
        let mut planner = planner.filter(|_| narrow != *settings)?;
        planner.plan(grid, start, goal).ok()
    }

    /// The planner for the current properties; the existing one if they have not changed.
    fn planner(&mut self) -> Result<&mut Box<dyn Planner>, ServiceFault> {
        let PlannerProperties {
            algorithm: name,
            settings,
            ..
        } = &*self.properties;
        let same = |(known, of, _): &(String, PlannerSettings, _)| known == name && of == settings;
        let made = match self.made.take().filter(same) {
            Some(made) => made,
            None => {
                let made = self.planners.make(name, settings).ok_or_else(|| {
                    ServiceFault::new("BAD_ALGORITHM", format!("no planner is called `{name}`"))
                })?;
                (name.clone(), settings.clone(), made)
            }
        };
        Ok(&mut self.made.insert(made).2)
    }
}

/// Marks the cells that contain points of seen obstacles. The robot is at `start`, so its cell is free.
fn add(grid: &mut Grid, seen: &Obstacles, start: Point) {
    let layout = *grid.layout();
    let robot = layout.cell(start);
    let hits = seen.points.iter().map(message::vertex);
    let cells = hits.filter_map(|point| layout.cell(point));
    for cell in cells.filter(|cell| Some(*cell) != robot) {
        grid.set(cell, OCCUPIED);
    }
}

fn fault(why: &NoPath) -> ServiceFault {
    ServiceFault::new(why.code(), why.to_string())
}

impl Component for TrajectoryPlanner {
    freeze_by_fields!();

    fn stop(&mut self, _: &mut Cycle<'_>) {
        self.waiting.clear();
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.properties.refresh(cycle);
        let cancelled = cycle.cancelled(self.ports.planning);
        self.waiting.retain(|(_, id, _)| !cancelled.contains(id));
        self.go_on(cycle);
        for request in cycle.requests(self.ports.planning) {
            self.take(cycle, request.id, request.argument);
        }
        Ok(())
    }
}
