//! One sweep of the laser: casts beams through the scene, adds noise, and represents invalid ranges as REP-117
//! specifies.

use std::f64::consts::PI;

use asmotion_component::Properties;
use asmotion_geometry::{ObstacleScene, Point, Pose, Vector};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// Geometry and errors of the laser.
#[derive(Debug, Clone, PartialEq, Properties)]
pub struct Optics {
    /// Standard deviation of a range.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.01)]
    pub noise_m: f64,
    /// Share of beams whose measurement fails (NaN).
    #[property(range = 0.0..=1.0)]
    pub dropout: f64,
    /// Bearing of the first beam, counter-clockwise; 0 is straight ahead of the laser.
    #[property(unit = "rad", range = -2.0 * PI..=2.0 * PI, default = -PI)]
    pub angle_min: f64,
    /// Bearing of the last beam.
    #[property(unit = "rad", range = -2.0 * PI..=2.0 * PI, default = PI)]
    pub angle_max: f64,
    /// Shortest measurable range; a nearer hit reads -Inf.
    #[property(unit = "m", range = 0.0..=1000.0, default = 0.05)]
    pub range_min: f64,
    /// Longest measurable range; without a hit up to there a beam reads +Inf.
    #[property(unit = "m", range = 0.0..=1000.0, default = 8.0)]
    pub range_max: f64,
    /// Beams of a sweep, from the first bearing to the last, both included.
    #[property(range = 1..=100_000, default = 721)]
    pub beams: u32,
}

impl Optics {
    /// Angle between two beams, rad; 0 with a single beam.
    pub fn increment(&self) -> f64 {
        match self.beams {
            0 | 1 => 0.0,
            beams => (self.angle_max - self.angle_min) / f64::from(beams - 1),
        }
    }

    /// The ranges of one sweep from `pose` through both scenes, m, beam by beam into `ranges`: `+Inf` where nothing is in range, `-Inf`
    /// where something is too near, NaN where the measurement failed (REP-117).
    ///
    /// Every beam draws the same number of random numbers whether it hits or not, so that a change in one part of the
    /// scene does not affect the noise elsewhere.
    pub fn sweep(
        &self,
        scenes: [&ObstacleScene; 2],
        pose: &Pose,
        chance: &mut impl Rng,
        ranges: &mut Vec<f32>,
    ) {
        let origin = Point::from(pose.translation.vector);
        // noise may bring an obstacle beyond the range into it
        let sight = self.range_max + 5.0 * self.noise_m;
        ranges.clear();
        ranges.extend((0..self.beams).map(|beam| {
            let angle = self.angle_min + f64::from(beam) * self.increment();
            let direction = pose.rotation * Vector::new(angle.cos(), angle.sin());
            let noise: f64 = StandardNormal.sample(chance);
            let fails = chance.random::<f64>() < self.dropout;
            let hits = scenes.iter();
            let hits = hits.filter_map(|scene| scene.raycast(origin, direction, sight));
            match hits.min_by(f64::total_cmp) {
                _ if fails => f32::NAN,
                Some(distance) => self.reading(distance + noise * self.noise_m),
                None => f32::INFINITY,
            }
        }));
    }

    /// Converts a measured distance to a range (REP-117).
    fn reading(&self, distance: f64) -> f32 {
        if distance < self.range_min {
            f32::NEG_INFINITY
        } else if distance > self.range_max {
            f32::INFINITY
        } else {
            distance as f32
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_geometry::{RoundObstacle, heading};
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use std::f64::consts::FRAC_PI_2;

    /// Four beams: ahead, left, behind, right.
    fn cross() -> Optics {
        Optics {
            beams: 4,
            angle_min: 0.0,
            angle_max: 3.0 * FRAC_PI_2,
            range_min: 0.1,
            range_max: 5.0,
            noise_m: 0.0,
            dropout: 0.0,
        }
    }

    fn sweep(optics: &Optics, scene: &ObstacleScene, pose: &Pose, seed: u64) -> Vec<f32> {
        let mut ranges = Vec::new();
        optics.sweep(
            [scene, &ObstacleScene::default()],
            pose,
            &mut ChaCha8Rng::seed_from_u64(seed),
            &mut ranges,
        );
        ranges
    }

    fn wall(x: f64) -> ObstacleScene {
        let ends = [Point::new(x, -50.0), Point::new(x, 50.0)];
        ObstacleScene::new(vec![ends], Vec::new(), Vec::new())
    }

    #[test]
    fn it_measures_what_is_there() {
        let disc = RoundObstacle {
            centre: Point::new(0.0, 2.0),
            radius: 0.5,
        };
        let room = ObstacleScene::new(wall(3.0).segments().to_vec(), Vec::new(), vec![disc]);
        let ranges = sweep(&cross(), &room, &Pose::identity(), 0);
        assert_eq!(ranges, [3.0, 1.5, f32::INFINITY, f32::INFINITY]);
        // after a turn to the left, the wall ahead is on the right
        let turned = sweep(&cross(), &room, &heading(Point::origin(), FRAC_PI_2), 0);
        assert!((turned[3] - 3.0).abs() < 1e-5 && (turned[0] - 1.5).abs() < 1e-5);
    }

    #[test]
    fn n2_it_says_too_near_too_far_and_failed_as_rep_117_does() {
        let ahead = |distance: f64| sweep(&cross(), &wall(distance), &Pose::identity(), 0)[0];
        assert_eq!(ahead(0.05), f32::NEG_INFINITY);
        assert_eq!(ahead(5.01), f32::INFINITY);
        assert_eq!(ahead(4.5), 4.5);
        let failing = Optics {
            dropout: 1.0,
            ..cross()
        };
        let ranges = sweep(&failing, &wall(1.0), &Pose::identity(), 0);
        assert!(ranges.iter().all(|range| range.is_nan()));
    }

    #[test]
    fn its_noise_has_the_width_that_was_asked_for() {
        let optics = Optics {
            beams: 20_000,
            angle_max: 0.0,
            noise_m: 0.02,
            ..cross()
        };
        let ranges = sweep(&optics, &wall(2.0), &Pose::identity(), 7);
        let errors = ranges.iter().map(|range| f64::from(*range) - 2.0);
        let (sum, squares) = errors.fold((0.0, 0.0), |(sum, squares), error| {
            (sum + error, squares + error * error)
        });
        let count = ranges.len() as f64;
        assert!((sum / count).abs() < 5e-4);
        assert!(((squares / count).sqrt() - 0.02).abs() < 5e-4);
    }

    proptest! {
        #[test]
        fn the_same_seed_gives_the_same_noise(seed: u64, distance in 0.0..6.0) {
            let optics = Optics { noise_m: 0.05, dropout: 0.3, ..cross() };
            let bits = |ranges: Vec<f32>| ranges.iter().map(|range| range.to_bits()).collect::<Vec<_>>();
            let again = || bits(sweep(&optics, &wall(distance), &Pose::identity(), seed));
            prop_assert_eq!(again(), again());
        }

        #[test]
        fn a_change_elsewhere_leaves_a_beam_alone(seed: u64, distance in 0.2..4.0) {
            let optics = Optics { noise_m: 0.05, ..cross() };
            let disc = RoundObstacle { centre: Point::new(0.0, distance), radius: 0.1 };
            let more = ObstacleScene::new(wall(3.0).segments().to_vec(), Vec::new(), vec![disc]);
            let (plain, changed) = (sweep(&optics, &wall(3.0), &Pose::identity(), seed), sweep(&optics, &more, &Pose::identity(), seed));
            prop_assert_eq!((plain[0], plain[2], plain[3]), (changed[0], changed[2], changed[3]));
            prop_assert_ne!(plain[1], changed[1]);
        }
    }
}
