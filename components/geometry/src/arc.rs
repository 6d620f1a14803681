//! Motion with constant velocity: the distance that a disc can move before it touches a point.

use std::f64::consts::TAU;

use crate::pose::{Point, Pose, roll};

/// A motion along a circle or a straight line, in the frame of the moving body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// 1/m, positive to the left; 0 is straight on.
    curvature: f64,
    /// `true` if the body moves backward.
    backward: bool,
}

/// Smallest curvature in 1/m that is not treated as straight on: 1 mm aside after 4 m.
const STRAIGHT: f64 = 1e-4;

/// Distance in m up to which a disc counts as touching a point.
const TOUCHING: f64 = 1e-6;

impl Arc {
    /// The motion at a forward speed (m/s) and a turn rate (rad/s, counter-clockwise). `None` for a body that turns on
    /// the spot or stands, and for numbers that are not finite.
    pub fn of(speed: f64, turn: f64) -> Option<Self> {
        let curvature = turn / speed;
        let moves = speed != 0.0 && speed.is_finite() && curvature.is_finite();
        moves.then_some(Self {
            curvature,
            backward: speed < 0.0,
        })
    }

    /// Curvature, 1/m, positive to the left.
    pub fn curvature(&self) -> f64 {
        self.curvature
    }

    /// Pose of the body after `distance` metres along the arc, in the frame that it had at the beginning.
    pub fn at(&self, distance: f64) -> Pose {
        let distance = if self.backward { -distance } else { distance };
        roll(&Pose::identity(), distance, distance * self.curvature)
    }

    /// The distance in m along the arc that a disc of `radius` about the body's origin moves before it touches one of
    /// `points`; infinite if it touches none. A point within the disc counts only while the motion approaches it, so
    /// that a robot that touches something can move away. Points that are not finite are ignored.
    pub fn free(&self, points: impl IntoIterator<Item = Point>, radius: f64) -> f64 {
        let points = points.into_iter();
        points
            .filter(|point| point.coords.iter().all(|value| value.is_finite()))
            .map(|point| self.free_of(point, radius))
            .fold(f64::INFINITY, f64::min)
    }

    fn free_of(&self, point: Point, radius: f64) -> f64 {
        // mirrored so that the body moves forward, and to the left or straight on
        let ahead = if self.backward { -point.x } else { point.x };
        let aside = point.y * self.curvature.signum();
        if self.curvature.abs() < STRAIGHT {
            return straight(ahead, aside, radius);
        }
        let circle = 1.0 / self.curvature.abs();
        // the point in polar coordinates about the centre of the circle; the body is at angle 0
        let off = (circle - aside).hypot(ahead);
        let angle = ahead.atan2(circle - aside);
        if ahead.hypot(aside) <= radius + TOUCHING {
            return if angle > 0.0 { 0.0 } else { f64::INFINITY };
        }
        // law of cosines for the triangle of centre, body and point when the disc touches
        let cosine = (circle * circle + off * off - radius * radius) / (2.0 * circle * off);
        if !(-1.0..1.0).contains(&cosine) {
            return f64::INFINITY;
        }
        let touches = angle - cosine.acos();
        circle
            * if touches < 0.0 {
                touches + TAU
            } else {
                touches
            }
    }
}

fn straight(ahead: f64, aside: f64, radius: f64) -> f64 {
    let reach = radius * radius - aside * aside;
    if ahead <= 0.0 || reach <= 0.0 {
        return f64::INFINITY;
    }
    (ahead - reach.sqrt()).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn free(speed: f64, turn: f64, x: f64, y: f64) -> f64 {
        Arc::of(speed, turn).unwrap().free([Point::new(x, y)], 0.2)
    }

    #[test]
    fn straight_on_it_touches_what_is_ahead() {
        assert!((free(0.5, 0.0, 1.0, 0.0) - 0.8).abs() < 1e-9);
        assert!((free(0.5, 0.0, 1.0, 0.12) - 0.84).abs() < 1e-9);
        assert!((free(-0.5, 0.0, -1.0, 0.0) - 0.8).abs() < 1e-9);
        for (speed, x, y) in [(0.5, 1.0, 0.21), (0.5, -1.0, 0.0), (-0.5, 1.0, 0.0)] {
            assert_eq!(free(speed, 0.0, x, y), f64::INFINITY);
        }
    }

    #[test]
    fn in_a_curve_it_touches_what_is_in_the_curve() {
        // a quarter of a circle of radius 1 m leads to (1, 1)
        let quarter = free(1.0, 1.0, 1.0, 1.0);
        assert!((TAU / 4.0 - quarter - 0.2).abs() < 2e-3, "{quarter}");
        assert_eq!(free(1.0, 1.0, 1.5, 0.0), f64::INFINITY);
        assert!((free(1.0, -1.0, 1.0, -1.0) - quarter).abs() < 1e-12);
        assert!((free(-1.0, -1.0, -1.0, 1.0) - quarter).abs() < 1e-12);
    }

    #[test]
    fn it_moves_away_from_what_it_touches() {
        for turn in [0.0, 0.3, -0.3] {
            assert_eq!(free(0.5, turn, 0.15, 0.0), 0.0);
            assert_eq!(free(-0.5, turn, 0.15, 0.0), f64::INFINITY);
        }
    }

    #[test]
    fn on_the_spot_it_goes_nowhere() {
        for (speed, turn) in [(0.0, 0.0), (0.0, 1.0), (f64::NAN, 0.0), (0.1, f64::NAN)] {
            assert_eq!(Arc::of(speed, turn), None);
        }
    }

    proptest! {
        #[test]
        fn it_touches_after_the_distance_and_not_before(
            speed in prop_oneof![-1.0..-0.1, 0.1..1.0], turn in -2.0..2.0, x in -2.0..2.0, y in -2.0..2.0,
        ) {
            let arc = Arc::of(speed, turn).unwrap();
            let point = Point::new(x, y);
            prop_assume!(point.coords.norm() > 0.21);
            let free = arc.free([point], 0.2);
            let end = free.min(TAU / arc.curvature().abs().max(0.2));
            let off = |along: f64| (arc.at(along).inverse() * point).coords.norm();
            for sample in 0..200 {
                prop_assert!(off(end * f64::from(sample) / 200.0) > 0.2 - 1e-4);
            }
            if free.is_finite() {
                prop_assert!((off(free) - 0.2).abs() < 1e-4, "{}", off(free));
            }
        }
    }
}
