//! What to do about the obstacles: let the path be, bend it, hold, or give up.

use geometry::{Distances, Disc, Point, Pose};
use messages::Path;

use crate::bend::{Barrier, Bender, Limits, Obstacles, Window};
use crate::cluster::{clusters, cover};
use crate::route::Route;

/// When to hold and when to give up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patience {
    /// How many looks in a row must find no way before the path counts as blocked.
    pub looks: u32,
    /// m, a barrier nearer than this stops the robot at once.
    pub hold: f64,
}

/// What came out of a look; most often nothing is to be said.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Advice {
    /// The path to follow from now on, if it is another than before; without poses: stop.
    pub path: Option<Path>,
    /// Said once a path: there is no way past this.
    pub blocked: Option<Barrier>,
}

/// What the follower was told last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Told {
    /// Nothing of this path.
    Nothing,
    /// The path as it was planned.
    Planned,
    /// The path, bent.
    Bent,
    /// To stop, for now.
    Hold,
    /// To stop, for good: the path is blocked.
    Blocked,
}

/// The adapter's mind: the path, how it is bent, and what was said about it.
#[derive(Debug, Clone)]
pub struct Adviser {
    route: Option<Route>,
    told: Told,
    fruitless: u32,
    /// Whether the path leads back from a bend that is no longer needed.
    returns: bool,
    bender: Bender,
    /// The remembered points near the robot; kept for its memory.
    near: Vec<Point>,
}

/// m, a way that is being driven may be this much nearer to an obstacle than a new one: noise shall not bend it.
const DRIVEN: f64 = 0.04;

/// m, the planned path must be this much freer than needed before the robot goes back to it.
const FREED: f64 = 0.03;

/// m, the discs that cover an obstacle are at most this large.
const COVER: f64 = 0.25;

impl Default for Adviser {
    fn default() -> Self {
        Self {
            route: None,
            told: Told::Nothing,
            fruitless: 0,
            returns: false,
            bender: Bender::default(),
            near: Vec::new(),
        }
    }
}

impl Adviser {
    /// Takes a new path; the advice passes an empty one on.
    pub fn order(&mut self, path: &Path) -> Advice {
        self.route = Route::new(path.clone());
        self.told = Told::Nothing;
        self.fruitless = 0;
        self.returns = false;
        Advice {
            path: self.route.is_none().then(|| empty(path)),
            blocked: None,
        }
    }

    /// Whether there is a path to care for.
    pub fn is_busy(&self) -> bool {
        self.route.is_some() && self.told != Told::Blocked
    }

    /// Without eyes: a path is passed on as planned if the robot never had any, and held if it lost them.
    pub fn blind(&mut self, has_seen: bool) -> Advice {
        let Some(route) = &self.route else {
            return Advice::default();
        };
        match self.told {
            Told::Nothing | Told::Planned | Told::Bent if has_seen => {
                self.told = Told::Hold;
                say(empty(route.planned()))
            }
            Told::Nothing => {
                self.told = Told::Planned;
                say(route.planned().clone())
            }
            Told::Planned | Told::Bent | Told::Hold | Told::Blocked => Advice::default(),
        }
    }

    /// Looks at the way ahead of the robot.
    pub fn look(
        &mut self,
        robot: &Pose,
        seen: impl Iterator<Item = Point>,
        map: Option<&Distances>,
        limits: &Limits,
        patience: &Patience,
    ) -> Advice {
        if !self.is_busy() {
            return Advice::default();
        }
        let Some(route) = &mut self.route else {
            return Advice::default();
        };
        let (from, offset) = route.locate(robot);
        let place = Point::from(robot.translation.vector);
        let around = limits.horizon + limits.reach + limits.comfort;
        self.near.clear();
        self.near.extend(seen.filter(|point| (point - place).norm() <= around));
        let obstacles = Obstacles {
            seen: &self.near,
            mapped: map,
        };
        let window = Window {
            route,
            from,
            robot: place,
            offset,
        };
        let driven = window.is_free(limits, &obstacles, -DRIVEN, |station| route.offsets()[station]);
        if driven && (self.returns || !route.is_bent(from)) {
            self.fruitless = 0;
            return self.go_on();
        }
        if let Some(back) = window.back(limits, &obstacles, FREED) {
            self.fruitless = 0;
            self.returns = true;
            return self.take(from, &back);
        }
        if driven {
            self.fruitless = 0;
            return self.go_on();
        }
        self.returns = false;
        match self.bender.bend(&window, limits, &obstacles) {
            Ok(offsets) => {
                self.fruitless = 0;
                self.take(from, &offsets)
            }
            Err(barrier) => {
                self.fruitless += 1;
                self.resist(barrier, patience)
            }
        }
    }

    /// The way is free: says so to a robot that does not know or that holds.
    fn go_on(&mut self) -> Advice {
        match (&self.route, self.told) {
            (Some(route), Told::Nothing | Told::Hold) => {
                let (told, path) = match route.is_bent(0) {
                    true => (Told::Bent, route.bent()),
                    false => (Told::Planned, route.planned().clone()),
                };
                self.told = told;
                say(path)
            }
            (Some(_), Told::Planned | Told::Bent | Told::Blocked) | (None, _) => Advice::default(),
        }
    }

    /// There is a way: says it if it is another.
    fn take(&mut self, from: usize, offsets: &[f64]) -> Advice {
        let Some(route) = &mut self.route else {
            return Advice::default();
        };
        let before: Vec<f64> = route.offsets().to_vec();
        route.bend(from, offsets);
        if before != route.offsets() && self.told != Told::Nothing {
            self.told = Told::Hold; // whatever it was told, it is to be told anew
        }
        self.go_on()
    }

    /// There is no way: holds before a barrier that is near, and gives up when it stays.
    fn resist(&mut self, barrier: Barrier, patience: &Patience) -> Advice {
        let Some(route) = &self.route else {
            return Advice::default();
        };
        let stop = empty(route.planned());
        if self.fruitless >= patience.looks {
            let stands = self.told == Told::Hold;
            self.told = Told::Blocked;
            return Advice {
                path: (!stands).then_some(stop),
                blocked: Some(barrier),
            };
        }
        if barrier.ahead <= patience.hold && self.told != Told::Hold {
            self.told = Told::Hold;
            return say(stop);
        }
        Advice::default()
    }

    /// The remembered things that a planner should know: all of them if the map has taken out what it knows, else
    /// those that stand on the planned path, as far as they are near it.
    pub fn obstacles(&self, seen: &[Point], map: Option<&Distances>, limits: &Limits) -> Vec<Disc> {
        let mut discs = Vec::new();
        if map.is_some() {
            for cluster in clusters(seen) {
                cover(cluster, COVER, &mut discs);
            }
        } else if let Some(route) = &self.route {
            let from_path = |point: &Point| route.distance(*point);
            let near = seen.iter().copied();
            let near: Vec<Point> = near.filter(|point| from_path(point) <= limits.reach).collect();
            for cluster in clusters(&near) {
                if cluster.iter().any(|point| from_path(point) < limits.clearance) {
                    cover(cluster, COVER, &mut discs);
                }
            }
        }
        discs
    }
}

fn say(path: Path) -> Advice {
    Advice {
        path: Some(path),
        blocked: None,
    }
}

/// The order to stop, with the header of the path that it ends.
fn empty(path: &Path) -> Path {
    Path {
        header: path.header.clone(),
        poses: Vec::new(),
    }
}
