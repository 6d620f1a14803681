//! Obstacles that no map shows, with the times at which they are present.

use asmotion_geometry::{ObstacleScene, Point, Pose, RoundObstacle, heading};
use serde::{Deserialize, Serialize};

asmotion_datum::message! {
    /// One obstacle, as the property `obstacles` lists it: `{ at_s = 8.0, until_s = 60.0, disc = [4.0, 0.0, 0.3] }`.
    pub struct Obstacle = "world/Obstacle" {
        /// Time at which it appears, s after the world's first cycle.
        pub at_s: f64,
        /// Time at which it disappears, s after the world's first cycle; never if omitted.
        pub until_s: Option<f64>,
        /// A disc: x, y, radius; m.
        pub disc: Option<[f64; 3]>,
        /// A rectangle: x and y of the centre, length, width, yaw; m and rad.
        pub block: Option<[f64; 5]>,
        /// Frame of x, y and yaw: `map`, or `robot` for the robot's true pose when the obstacle appears; then
        /// `[2.0, 0.0, 0.3]` is two metres in front of it.
        pub frame: String = "map".to_owned(),
    }
}

/// An invalid entry of the schedule.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("obstacle {number}: {problem}")]
pub struct ObstacleError {
    /// Number of the entry, from 1.
    pub number: usize,
    /// The violated requirement.
    pub problem: ObstacleProblem,
}

/// A requirement that an obstacle violates.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ObstacleProblem {
    /// No shape, or two shapes.
    #[error("needs either `disc = [x, y, radius]` or `block = [x, y, length, width, yaw]`")]
    Shape,
    /// A number that is not finite.
    #[error("its numbers must be finite")]
    NotFinite,
    /// A size that is not positive.
    #[error("its sizes must be above zero")]
    Size,
    /// A frame other than `map` and `robot`.
    #[error("its frame must be `map` or `robot`, not `{0}`")]
    Frame(String),
}

/// The shape of a present obstacle, map frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Solid {
    /// A disc.
    Disc(RoundObstacle),
    /// A polygon, given by its corners.
    Polygon(Vec<Point>),
}

/// The obstacles of a run and their states.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Schedule {
    entries: Vec<ScheduleEntry>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct ScheduleEntry {
    /// Time at which it appears, s.
    from: f64,
    /// Time at which it disappears, s; infinite if it stays.
    until: f64,
    frame: ScheduleFrame,
    /// Shape in `frame`.
    solid: Solid,
    state: ScheduleState,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ScheduleFrame {
    Map,
    Robot,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ScheduleState {
    Waiting,
    /// Present, with its shape in the map frame.
    There(Solid),
    Gone,
}

impl Schedule {
    /// Creates the schedule of these obstacles, none of which is present yet.
    ///
    /// # Errors
    /// The first obstacle with a contradiction, and its number from 1.
    pub fn new(obstacles: Vec<Obstacle>) -> Result<Self, ObstacleError> {
        let numbered = (1..).zip(obstacles);
        let entries = numbered.map(|(number, obstacle)| {
            let problem = |problem| ObstacleError { number, problem };
            ScheduleEntry::new(obstacle).map_err(problem)
        });
        Ok(Self {
            entries: entries.collect::<Result<_, _>>()?,
        })
    }

    /// Lets obstacles appear and disappear at `seconds` after the start. An obstacle within `radius` metres of the
    /// robot's pose waits until the robot has left. Returns whether the set of present obstacles has changed.
    pub fn advance(&mut self, seconds: f64, robot: &Pose, radius: f64) -> bool {
        let mut changed = false;
        for entry in &mut self.entries {
            let next = match entry.state {
                ScheduleState::Waiting | ScheduleState::There(_) if seconds >= entry.until => {
                    ScheduleState::Gone
                }
                ScheduleState::Waiting if seconds >= entry.from => {
                    let solid = entry.solid_at(robot);
                    if solid.distance(robot.translation.vector.into()) <= radius {
                        continue;
                    }
                    ScheduleState::There(solid)
                }
                ScheduleState::Waiting | ScheduleState::There(_) | ScheduleState::Gone => continue,
            };
            changed |= (&entry.state, &next) != (&ScheduleState::Waiting, &ScheduleState::Gone);
            entry.state = next;
        }
        changed
    }

    /// The obstacles that are present.
    pub fn present(&self) -> impl Iterator<Item = &Solid> {
        self.entries.iter().filter_map(|entry| match &entry.state {
            ScheduleState::There(solid) => Some(solid),
            ScheduleState::Waiting | ScheduleState::Gone => None,
        })
    }
}

impl Solid {
    /// Distance from a point, m; 0 within the obstacle.
    fn distance(&self, point: Point) -> f64 {
        let scene = match self {
            Self::Disc(disc) => ObstacleScene::new(Vec::new(), Vec::new(), vec![*disc]),
            Self::Polygon(corners) => {
                ObstacleScene::new(Vec::new(), vec![corners.clone()], Vec::new())
            }
        };
        scene.clearance(point)
    }
}

impl ScheduleEntry {
    fn new(obstacle: Obstacle) -> Result<Self, ObstacleProblem> {
        let until = obstacle.until_s.unwrap_or(f64::INFINITY);
        if !obstacle.at_s.is_finite() || until.is_nan() {
            return Err(ObstacleProblem::NotFinite);
        }
        let (solid, numbers, sizes) = match (obstacle.disc, obstacle.block) {
            (Some([x, y, radius]), None) => (disc(x, y, radius), [x, y, 0.0], [radius, radius]),
            (None, Some([x, y, length, width, yaw])) => (
                block(&heading(Point::new(x, y), yaw), length, width),
                [x, y, yaw],
                [length, width],
            ),
            (None, None) | (Some(_), Some(_)) => return Err(ObstacleProblem::Shape),
        };
        if !numbers
            .iter()
            .chain(&sizes)
            .all(|number| number.is_finite())
        {
            return Err(ObstacleProblem::NotFinite);
        }
        if sizes.iter().any(|size| *size <= 0.0) {
            return Err(ObstacleProblem::Size);
        }
        let frame = match obstacle.frame.as_str() {
            "map" => ScheduleFrame::Map,
            "robot" => ScheduleFrame::Robot,
            _ => return Err(ObstacleProblem::Frame(obstacle.frame)),
        };
        Ok(Self {
            from: obstacle.at_s,
            until,
            frame,
            solid,
            state: ScheduleState::Waiting,
        })
    }

    /// The obstacle's shape in the map frame, for a robot at this pose.
    fn solid_at(&self, robot: &Pose) -> Solid {
        match (self.frame, &self.solid) {
            (ScheduleFrame::Map, solid) => solid.clone(),
            (ScheduleFrame::Robot, Solid::Disc(disc)) => Solid::Disc(RoundObstacle {
                centre: robot * disc.centre,
                radius: disc.radius,
            }),
            (ScheduleFrame::Robot, Solid::Polygon(corners)) => {
                Solid::Polygon(corners.iter().map(|corner| robot * corner).collect())
            }
        }
    }
}

fn disc(x: f64, y: f64, radius: f64) -> Solid {
    Solid::Disc(RoundObstacle {
        centre: Point::new(x, y),
        radius,
    })
}

fn block(middle: &Pose, length: f64, width: f64) -> Solid {
    let corners = [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)];
    let corner = |(along, across)| middle * Point::new(along * length, across * width);
    Solid::Polygon(corners.map(corner).to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn obstacle() -> Obstacle {
        Obstacle {
            at_s: 2.0,
            until_s: Some(5.0),
            disc: Some([1.0, 0.0, 0.5]),
            ..Obstacle::default()
        }
    }

    fn present(schedule: &Schedule) -> Vec<Solid> {
        schedule.present().cloned().collect()
    }

    #[test]
    fn it_lets_things_come_and_go() {
        let mut schedule = Schedule::new(vec![obstacle()]).unwrap();
        let robot = Pose::identity();
        for (seconds, changes, count) in [
            (0.0, false, 0),
            (2.0, true, 1),
            (4.9, false, 1),
            (5.0, true, 0),
            (9.0, false, 0),
        ] {
            assert_eq!(
                (
                    schedule.advance(seconds, &robot, 0.2),
                    present(&schedule).len()
                ),
                (changes, count),
                "at {seconds}"
            );
        }
    }

    #[test]
    fn what_came_and_went_between_two_looks_changed_nothing() {
        let mut schedule = Schedule::new(vec![obstacle()]).unwrap();
        assert!(!schedule.advance(7.0, &Pose::identity(), 0.2));
    }

    #[test]
    fn it_puts_things_in_front_of_the_robot_and_leaves_them_there() {
        let in_front = Obstacle {
            frame: "robot".to_owned(),
            ..obstacle()
        };
        let mut schedule = Schedule::new(vec![in_front]).unwrap();
        schedule.advance(
            2.0,
            &heading(Point::new(3.0, 4.0), std::f64::consts::FRAC_PI_2),
            0.2,
        );
        schedule.advance(3.0, &Pose::identity(), 0.2);
        let Solid::Disc(disc) = &present(&schedule)[0] else {
            panic!("a disc was put");
        };
        assert!((disc.centre - Point::new(3.0, 5.0)).norm() < 1e-12);
    }

    #[test]
    fn it_puts_nothing_where_the_robot_is() {
        let mut schedule = Schedule::new(vec![obstacle()]).unwrap();
        for (x, there) in [(1.0, false), (0.35, false), (0.25, true)] {
            assert_eq!(
                schedule.advance(3.0, &heading(Point::new(x, 0.0), 0.0), 0.2),
                there
            );
        }
    }

    #[test]
    fn it_turns_blocks() {
        let turned = Obstacle {
            disc: None,
            block: Some([1.0, 1.0, 2.0, 0.2, std::f64::consts::FRAC_PI_2]),
            ..obstacle()
        };
        let mut schedule = Schedule::new(vec![turned]).unwrap();
        schedule.advance(2.0, &Pose::identity(), 0.2);
        let Solid::Polygon(corners) = &present(&schedule)[0] else {
            panic!("a block was put");
        };
        assert!((corners[0] - Point::new(0.9, 2.0)).norm() < 1e-12);
    }

    #[test]
    fn it_says_which_entry_is_none() {
        let two = Obstacle {
            block: Some([0.0; 5]),
            ..obstacle()
        };
        let none = Obstacle {
            disc: None,
            ..obstacle()
        };
        let flat = Obstacle {
            disc: Some([0.0, 0.0, 0.0]),
            ..obstacle()
        };
        let nowhere = Obstacle {
            disc: Some([f64::NAN, 0.0, 1.0]),
            ..obstacle()
        };
        let lost = Obstacle {
            frame: "laser".to_owned(),
            ..obstacle()
        };
        for (entry, words) in [
            (two, "either"),
            (none, "either"),
            (flat, "above zero"),
            (nowhere, "finite"),
            (lost, "`laser`"),
        ] {
            let error = Schedule::new(vec![obstacle(), entry])
                .unwrap_err()
                .to_string();
            assert!(
                error.starts_with("obstacle 2: ") && error.contains(words),
                "{error}"
            );
        }
    }
}
