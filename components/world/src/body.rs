//! The robot's body in the world: wheels that turn, a disc that moves, and what it bumps into.

use geometry::{Point, Pose, Scene};
use messages::WheelSpeeds;
use rover::{Drive, roll};

/// A round robot on two driven wheels.
#[derive(Debug, Clone)]
pub struct Body {
    /// Its wheels.
    pub drive: Drive,
    /// m, of the disc that covers it, about the midpoint between the wheels.
    pub radius: f64,
    /// Where it truly is, map frame.
    pub pose: Pose,
    /// rad, how far the left wheel has turned.
    pub left: f64,
    /// rad, how far the right wheel has turned.
    pub right: f64,
}

/// How much farther a wheel rolls than its angle says, as a share: 0 without slip.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slip {
    /// Of the left wheel.
    pub left: f64,
    /// Of the right wheel.
    pub right: f64,
}

impl Body {
    /// Moves for `dt` seconds. Where the body would touch something it does not roll on: the wheels stall as far as
    /// they push against it, and only the turn on the spot is left. Says whether it touched.
    pub fn step(&mut self, wheels: WheelSpeeds, slip: Slip, scene: &Scene, dt: f64) -> bool {
        let (left, right) = (wheels.left * dt, wheels.right * dt);
        let moved = self.moved(left, right, slip);
        if self.may_stand(&moved, scene) {
            self.take(moved, left, right);
            return false;
        }
        let push = (left + right) / 2.0;
        let turned = self.moved(left - push, right - push, slip);
        if self.may_stand(&turned, scene) {
            self.take(turned, left - push, right - push);
        }
        true
    }

    /// m between the body and the nearest thing; 0 if it touches or overlaps.
    pub fn clearance(&self, scene: &Scene) -> f64 {
        (scene.clearance(place(&self.pose)) - self.radius).max(0.0)
    }

    fn moved(&self, left: f64, right: f64, slip: Slip) -> Pose {
        let rolled = self.drive.body(left * (1.0 + slip.left), right * (1.0 + slip.right));
        roll(&self.pose, rolled.speed, rolled.turn)
    }

    /// A body that something was put upon may leave, but not go deeper.
    fn may_stand(&self, pose: &Pose, scene: &Scene) -> bool {
        let there = scene.clearance_within(place(pose), self.radius);
        there >= self.radius || there >= scene.clearance_within(place(&self.pose), self.radius)
    }

    fn take(&mut self, pose: Pose, left: f64, right: f64) {
        self.pose = pose;
        self.left += left;
        self.right += right;
    }
}

fn place(pose: &Pose) -> Point {
    pose.translation.vector.into()
}
