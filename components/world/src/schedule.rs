//! Obstacles that no map shows, and when they are there.

use geometry::{Disc, Point, Pose, heading};
use serde::Deserialize;

/// One obstacle, as the property `obstacles` lists it: `{ at_s = 8.0, until_s = 60.0, disc = [4.0, 0.0, 0.3] }`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// s after the world's start: it appears.
    #[serde(default)]
    pub at_s: f64,
    /// s after the world's start: it vanishes; never, if left out.
    #[serde(default)]
    pub until_s: Option<f64>,
    /// `[x, y, radius]`, m.
    #[serde(default)]
    pub disc: Option<[f64; 3]>,
    /// `[x, y, length, width, yaw]` of its middle, m and rad.
    #[serde(default, rename = "box")]
    pub cuboid: Option<[f64; 5]>,
    /// What x, y and yaw are relative to.
    #[serde(default)]
    pub frame: Frame,
}

/// What an obstacle's place is relative to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// The map.
    #[default]
    Map,
    /// The robot's true pose when the obstacle appears: `[2.0, 0.0, 0.3]` stands two metres in front of it.
    Robot,
}

/// An obstacle that is there, map frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    /// A round one.
    Disc(Disc),
    /// One with corners.
    Polygon(Vec<Point>),
}

/// The obstacles of a run, and which of them are there.
#[derive(Debug, Clone, Default)]
pub struct Schedule {
    entries: Vec<(Obstacle, State)>,
}

#[derive(Debug, Clone, PartialEq)]
enum State {
    Waiting,
    There(Solid),
    Gone,
}

impl Obstacle {
    /// Why the entry describes no obstacle, if so.
    pub fn problem(&self) -> Option<&'static str> {
        let shape = match (&self.disc, &self.cuboid) {
            (Some(_), Some(_)) => return Some("an obstacle is a `disc` or a `box`, not both"),
            (None, None) => return Some("an obstacle needs `disc = [x, y, radius]` or `box = [x, y, length, width, yaw]`"),
            (Some(disc), None) => &disc[..],
            (None, Some(cuboid)) => &cuboid[..],
        };
        let times = [self.at_s, self.until_s.unwrap_or(0.0)];
        if !shape.iter().chain(&times).all(|number| number.is_finite()) {
            return Some("an obstacle's numbers must be finite");
        }
        let sizes = if self.disc.is_some() { &shape[2..] } else { &shape[2..4] };
        if sizes.iter().any(|size| *size <= 0.0) {
            return Some("an obstacle's sizes must be above zero");
        }
        None
    }

    /// The obstacle put into the world of a robot at `robot`.
    fn put(&self, robot: &Pose) -> Option<Solid> {
        let base = match self.frame {
            Frame::Map => Pose::identity(),
            Frame::Robot => *robot,
        };
        if let Some([x, y, radius]) = self.disc {
            let centre = base * Point::new(x, y);
            return Some(Solid::Disc(Disc { centre, radius }));
        }
        let [x, y, length, width, yaw] = self.cuboid?;
        let middle = base * heading(Point::new(x, y), yaw);
        let corners = [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)];
        let corner = |(along, across)| middle * Point::new(along * length, across * width);
        Some(Solid::Polygon(corners.map(corner).to_vec()))
    }
}

impl Schedule {
    /// The schedule of these obstacles; none of them is there yet.
    pub fn new(obstacles: Vec<Obstacle>) -> Self {
        let waiting = |obstacle| (obstacle, State::Waiting);
        Self {
            entries: obstacles.into_iter().map(waiting).collect(),
        }
    }

    /// Lets obstacles appear and vanish at `seconds` after the start, with the robot at `robot`. Says whether any did.
    pub fn advance(&mut self, seconds: f64, robot: &Pose) -> bool {
        let mut changed = false;
        for (obstacle, state) in &mut self.entries {
            let over = obstacle.until_s.is_some_and(|until| seconds >= until);
            let next = match state {
                State::Waiting if over => State::Gone,
                State::Waiting if seconds >= obstacle.at_s => match obstacle.put(robot) {
                    Some(solid) => State::There(solid),
                    None => State::Gone,
                },
                State::There(_) if over => State::Gone,
                State::Waiting | State::There(_) | State::Gone => continue,
            };
            changed |= *state != State::Waiting || next != State::Gone;
            *state = next;
        }
        changed
    }

    /// The obstacles that are there.
    pub fn there(&self) -> impl Iterator<Item = &Solid> {
        self.entries.iter().filter_map(|(_, state)| match state {
            State::There(solid) => Some(solid),
            State::Waiting | State::Gone => None,
        })
    }
}
