//! Stopping distances.

/// Deceleration in m/s² that the rover and all components that limit its speed assume by default.
pub const DECELERATION: f64 = 1.0;

/// A vehicle's ability to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brakes {
    /// Deceleration, m/s², positive.
    pub deceleration: f64,
    /// Time in s between the measurement of an obstacle and the beginning of braking, driven at constant speed.
    pub reaction_s: f64,
}

impl Brakes {
    /// Distance in m needed to stop from `speed` m/s, forward or backward.
    pub fn distance(&self, speed: f64) -> f64 {
        let speed = speed.abs();
        speed * self.reaction_s + speed * speed / (2.0 * self.deceleration)
    }

    /// The highest speed, m/s, that allows to stop within `distance` metres; 0 if the distance is not positive.
    pub fn speed(&self, distance: f64) -> f64 {
        self.speed_before(distance, 0.0)
    }

    /// The highest speed, m/s, that allows to slow down to `then` m/s within `distance` metres.
    pub fn speed_before(&self, distance: f64, then: f64) -> f64 {
        let distance = distance.max(0.0);
        // v · t + (v² − then²) / 2a = distance
        let lost = self.deceleration * self.reaction_s;
        let square = lost * lost + then * then + 2.0 * self.deceleration * distance;
        (square.sqrt() - lost).max(then)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn it_needs_two_metres_from_two_metres_per_second() {
        let brakes = Brakes {
            deceleration: 1.0,
            reaction_s: 0.25,
        };
        assert!((brakes.distance(2.0) - 2.5).abs() < 1e-12);
        assert_eq!(brakes.distance(2.0), brakes.distance(-2.0));
        assert_eq!(brakes.speed(-1.0), 0.0);
        assert_eq!(brakes.speed_before(0.0, 0.7), 0.7);
    }

    proptest! {
        #[test]
        fn it_stops_within_the_distance(
            distance in 0.0..20.0, deceleration in 0.01..50.0, reaction_s in 0.0..2.0,
        ) {
            let brakes = Brakes { deceleration, reaction_s };
            let speed = brakes.speed(distance);
            prop_assert!((brakes.distance(speed) - distance).abs() < 1e-9);
        }
    }
}
