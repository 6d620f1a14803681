//! `sensor_msgs`: the laser.

use crate::std_msgs::Header;

asmotion_datum::message! {
    /// One sweep of a planar laser. A range is `-Inf` where something is nearer than `range_min`, `+Inf` where nothing
    /// is within `range_max`, NaN where the measurement failed (REP-117).
    pub struct LaserScan = "sensor_msgs/LaserScan" {
        /// Time of the first beam; the frame is the laser's, angles about its z axis.
        pub header: Header,
        /// rad, of the first beam; 0 is straight ahead, counter-clockwise positive.
        pub angle_min: f32,
        /// rad, of the last beam.
        pub angle_max: f32,
        /// rad, from one beam to the next.
        pub angle_increment: f32,
        /// s, from one beam to the next.
        pub time_increment: f32,
        /// s, from one sweep to the next.
        pub scan_time: f32,
        /// m, the nearest range that can be measured.
        pub range_min: f32,
        /// m, the farthest range that can be measured.
        pub range_max: f32,
        /// m, a beam each.
        pub ranges: Vec<f32>,
        /// Echo strength in the device's unit, a beam each, or empty.
        pub intensities: Vec<f32>,
    }
}

impl LaserScan {
    /// The angle of beam `index`, rad in the laser's frame.
    pub fn angle(&self, index: usize) -> f64 {
        f64::from(self.angle_min) + index as f64 * f64::from(self.angle_increment)
    }

    /// The beams that met something measurable: (angle in rad, range in m).
    pub fn hits(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let measurable = self.range_min..=self.range_max;
        self.ranges
            .iter()
            .enumerate()
            .filter(move |(_, range)| measurable.contains(range))
            .map(|(index, range)| (self.angle(index), f64::from(*range)))
    }
}
