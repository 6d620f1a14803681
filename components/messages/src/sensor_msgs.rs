//! `sensor_msgs`: the laser.

use crate::std_msgs::Header;
use asmotion_datum::DatumError;

use crate::plausible::{LARGEST_DURATION, LARGEST_POSITION, bounded, positive};

asmotion_datum::message! {
    /// One sweep of a planar laser. A range is `-Inf` if an obstacle is nearer than `range_min`, `+Inf` if there is
    /// none within `range_max`, NaN if the measurement failed (REP-117).
    pub struct LaserScan = "sensor_msgs/LaserScan", check = check_scan {
        /// Time of the first beam, and frame of the laser; angles are about its z axis.
        pub header: Header,
        /// Angle of the first beam, rad; 0 is straight ahead, counter-clockwise is positive.
        pub angle_min: f32,
        /// Angle of the last beam, rad.
        pub angle_max: f32,
        /// Angle between two beams, rad.
        pub angle_increment: f32,
        /// Time between two beams, s.
        pub time_increment: f32,
        /// Time between two sweeps, s.
        pub scan_time: f32,
        /// Smallest measurable range, m.
        pub range_min: f32,
        /// Largest measurable range, m.
        pub range_max: f32,
        /// One range per beam, m.
        pub ranges: Vec<f32>,
        /// Echo strength per beam in the device's unit, or empty.
        pub intensities: Vec<f32>,
    }
}

impl LaserScan {
    /// Angle of beam `index` in the laser's frame, rad.
    pub fn angle(&self, index: usize) -> f64 {
        f64::from(self.angle_min) + index as f64 * f64::from(self.angle_increment)
    }

    /// The beams with a valid range: (angle in rad, range in m).
    pub fn hits(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let measurable = self.range_min..=self.range_max;
        self.ranges
            .iter()
            .enumerate()
            .filter(move |(_, range)| measurable.contains(range))
            .map(|(index, range)| (self.angle(index), f64::from(*range)))
    }

    /// The beams that end at an obstacle, (angle in rad, range in m): those with a valid range, and at `range_min` those
    /// that ended nearer.
    pub fn obstacles(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let near = f64::from(self.range_min);
        let too_near = self
            .ranges
            .iter()
            .enumerate()
            .filter(|(_, range)| **range == f32::NEG_INFINITY)
            .map(move |(index, _)| (self.angle(index), near));
        self.hits().chain(too_near)
    }

    /// Returns whether at least half of the beams measured something, be it that nothing is in range.
    pub fn sees(&self) -> bool {
        let measured = self.ranges.iter().filter(|range| !range.is_nan()).count();
        measured > 0 && 2 * measured >= self.ranges.len()
    }
}

/// Limit of the angle of a beam, rad.
const LARGEST_BEAM_ANGLE: f64 = 100.0;

/// Ranges are not checked: all their values have a meaning.
fn check_scan(scan: &LaserScan) -> Result<(), DatumError> {
    for (field, angle) in [
        ("angle_min", scan.angle_min),
        ("angle_max", scan.angle_max),
        ("angle_increment", scan.angle_increment),
    ] {
        bounded(field, angle.into(), LARGEST_BEAM_ANGLE)?;
    }
    for (field, time) in [
        ("time_increment", scan.time_increment),
        ("scan_time", scan.scan_time),
    ] {
        positive(field, time.into(), LARGEST_DURATION)?;
    }
    positive("range_min", scan.range_min.into(), LARGEST_POSITION)?;
    positive("range_max", scan.range_max.into(), LARGEST_POSITION)
}
