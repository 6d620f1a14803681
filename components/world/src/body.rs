//! The robot's body in the world: a disc on two wheels that moves until it touches an obstacle.

use asmotion_geometry::{ObstacleScene, Point, Pose, roll};
use asmotion_messages::{RoverDisc, WheelSpeeds};
use asmotion_rover::DifferentialDrive;
use serde::{Deserialize, Serialize};

/// A round robot on two driven wheels.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Body {
    /// Geometry of the drive.
    pub drive: DifferentialDrive,
    /// Radius in m of the disc that covers the body, about the midpoint between the wheels.
    pub radius: f64,
    /// True pose, map frame.
    pub pose: Pose,
    /// Angle of the left wheel, rad, cumulative.
    pub left: f64,
    /// Angle of the right wheel, rad, cumulative.
    pub right: f64,
}

/// Relative excess of the distance that a wheel rolls over the distance its angle implies; 0 without slip.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slip {
    /// Slip of the left wheel.
    pub left: f64,
    /// Slip of the right wheel.
    pub right: f64,
}

/// Everything that a body can touch.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'s> {
    /// Walls and obstacles.
    pub scene: &'s ObstacleScene,
    /// The other robots nearby.
    pub rovers: &'s [RoverDisc],
}

impl<'s> From<&'s ObstacleScene> for Surroundings<'s> {
    fn from(scene: &'s ObstacleScene) -> Self {
        Self { scene, rovers: &[] }
    }
}

impl Surroundings<'_> {
    /// Distance in m from `point` to the nearest thing, as [`ObstacleScene::clearance_within`]; negative within a robot.
    fn clearance_within(&self, point: Point, max: f64) -> f64 {
        let rovers = self.rovers.iter().map(|rover| distance(rover, point));
        rovers.fold(self.scene.clearance_within(point, max), f64::min)
    }
}

/// Distance in m from a point to the edge of a robot; negative within it.
pub fn distance(rover: &RoverDisc, point: Point) -> f64 {
    let centre = Point::new(rover.disc.x, rover.disc.y);
    (centre - point).norm() - rover.disc.radius
}

impl Body {
    /// A body at `pose` with both wheels at angle 0.
    pub fn new(drive: DifferentialDrive, radius: f64, pose: Pose) -> Self {
        Self {
            drive,
            radius,
            pose,
            left: 0.0,
            right: 0.0,
        }
    }

    /// Moves for `dt` seconds. If the body would touch an obstacle, it does not roll on: the wheels stall as far as
    /// they push against it, and only the turn on the spot remains. Returns whether it touched.
    pub fn step<'s>(
        &mut self,
        wheels: WheelSpeeds,
        slip: Slip,
        around: impl Into<Surroundings<'s>>,
        dt: f64,
    ) -> bool {
        let around = around.into();
        let (left, right) = (wheels.left * dt, wheels.right * dt);
        let moved = self.moved(left, right, slip);
        if self.may_stand(&moved, around) {
            self.take(moved, left, right);
            return false;
        }
        let push = (left + right) / 2.0;
        let turned = self.moved(left - push, right - push, slip);
        if self.may_stand(&turned, around) {
            self.take(turned, left - push, right - push);
        }
        true
    }

    /// Distance in m between the body and the nearest obstacle; 0 if they touch or overlap.
    pub fn clearance<'s>(&self, around: impl Into<Surroundings<'s>>) -> f64 {
        let clearance = around.into();
        let clearance = clearance.clearance_within(position(&self.pose), f64::INFINITY);
        (clearance - self.radius).max(0.0)
    }

    fn moved(&self, left: f64, right: f64, slip: Slip) -> Pose {
        let rolled = self
            .drive
            .body(left * (1.0 + slip.left), right * (1.0 + slip.right));
        roll(&self.pose, rolled.speed, rolled.turn)
    }

    /// Returns whether the body may be at a pose. A body that overlaps an obstacle may leave, but not move deeper.
    fn may_stand(&self, pose: &Pose, around: Surroundings<'_>) -> bool {
        let clearance = around.clearance_within(position(pose), self.radius);
        clearance >= self.radius
            || clearance >= around.clearance_within(position(&self.pose), self.radius)
    }

    fn take(&mut self, pose: Pose, left: f64, right: f64) {
        self.pose = pose;
        self.left += left;
        self.right += right;
    }
}

/// The place of a pose.
pub(crate) fn position(pose: &Pose) -> Point {
    pose.translation.vector.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_geometry::{RoundObstacle, heading, yaw};
    use proptest::prelude::*;

    fn robot() -> Body {
        let drive = DifferentialDrive {
            wheel_radius_m: 0.05,
            track_m: 0.3,
        };
        Body::new(drive, 0.2, Pose::identity())
    }

    fn wall_at(x: f64) -> ObstacleScene {
        ObstacleScene::new(
            vec![[Point::new(x, -9.0), Point::new(x, 9.0)]],
            Vec::new(),
            Vec::new(),
        )
    }

    fn wheels(left: f64, right: f64) -> WheelSpeeds {
        WheelSpeeds { left, right }
    }

    #[test]
    fn it_rolls_as_its_wheels_turn() {
        let mut body = robot();
        assert!(!body.step(
            wheels(10.0, 10.0),
            Slip::default(),
            &ObstacleScene::default(),
            0.5
        ));
        assert!((body.pose.translation.x - 0.25).abs() < 1e-12);
        assert_eq!((body.left, body.right), (5.0, 5.0));
    }

    #[test]
    fn slip_moves_the_body_but_not_the_encoders() {
        let mut body = robot();
        let slip = Slip {
            left: 0.1,
            right: 0.1,
        };
        body.step(wheels(10.0, 10.0), slip, &ObstacleScene::default(), 0.5);
        assert!((body.pose.translation.x - 0.275).abs() < 1e-12);
        assert_eq!(body.left, 5.0);
    }

    #[test]
    fn a_wall_stops_it_and_stalls_its_wheels() {
        let (mut body, scene) = (robot(), wall_at(1.0));
        let mut touched = false;
        for _ in 0..500 {
            touched |= body.step(wheels(10.0, 10.0), Slip::default(), &scene, 0.02);
        }
        assert!(touched);
        assert!((0.78..0.8001).contains(&body.pose.translation.x));
        assert!((body.left * 0.05 - body.pose.translation.x).abs() < 1e-9);
        // it can turn there, and leave
        assert!(body.step(wheels(8.0, 12.0), Slip::default(), &scene, 0.1));
        assert!(yaw(&body.pose) > 0.0);
        assert!(!body.step(wheels(-10.0, -10.0), Slip::default(), &scene, 0.1));
    }

    #[test]
    fn it_gets_out_from_under_a_thing_but_not_deeper_in() {
        let disc = RoundObstacle {
            centre: Point::new(0.25, 0.0),
            radius: 0.1,
        };
        let scene = ObstacleScene::new(Vec::new(), Vec::new(), vec![disc]);
        let mut body = robot();
        assert_eq!(body.clearance(&scene), 0.0);
        assert!(body.step(wheels(1.0, 1.0), Slip::default(), &scene, 0.1));
        assert!(!body.step(wheels(-1.0, -1.0), Slip::default(), &scene, 0.1));
        assert!(body.pose.translation.x < 0.0);
    }

    #[test]
    fn it_stops_at_another_robot_and_leaves_it_again() {
        let disc = asmotion_messages::Disc {
            x: 1.0,
            y: 0.0,
            radius: 0.3,
        };
        let rover = "other".to_owned();
        let scene = ObstacleScene::default();
        let around = Surroundings {
            scene: &scene,
            rovers: &[RoverDisc { rover, disc }],
        };
        let mut body = robot();
        let mut touched = false;
        for _ in 0..500 {
            touched |= body.step(wheels(10.0, 10.0), Slip::default(), around, 0.02);
        }
        assert!(touched);
        // radii of 0.2 m and 0.3 m
        assert!((0.48..0.5001).contains(&body.pose.translation.x));
        assert!(body.clearance(around) < 0.02);
        assert!(!body.step(wheels(-10.0, -10.0), Slip::default(), around, 0.1));
    }

    proptest! {
        #[test]
        fn it_never_enters_a_wall(
            x in -0.7..0.7, y in -0.7..0.7, angle in -3.0..3.0,
            drives in prop::collection::vec((-12.0..12.0, -12.0..12.0), 1..100),
        ) {
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Point::new(x, y));
            let walls = (0..4).map(|side| [corners[side], corners[(side + 1) % 4]]).collect();
            let room = ObstacleScene::new(walls, Vec::new(), Vec::new());
            let mut body = robot();
            body.pose = heading(Point::new(x, y), angle);
            for (left, right) in drives {
                body.step(wheels(left, right), Slip::default(), &room, 0.02);
                prop_assert!(room.clearance(position(&body.pose)) >= body.radius - 1e-6);
            }
        }
    }
}
