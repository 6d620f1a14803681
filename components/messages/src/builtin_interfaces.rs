//! `builtin_interfaces`: time.

use asmotion_datum::DatumError;

use crate::plausible::implausible;

asmotion_datum::message! {
    /// An instant: seconds and nanoseconds since the zero of the clock in use.
    #[derive(Copy)]
    pub struct Time = "builtin_interfaces/Time", check = check_time {
        /// Whole seconds, rounded towards minus infinity.
        pub sec: i32,
        /// Nanoseconds in `0..1_000_000_000`, counted forward from `sec`.
        pub nanosec: u32,
    }
}

const NANOS_PER_SECOND: i64 = 1_000_000_000;

impl Time {
    /// The instant `nanos` nanoseconds after the clock's zero. Saturates at the limits of ROS's 32-bit seconds.
    pub fn from_nanos(nanos: i64) -> Self {
        match i32::try_from(nanos.div_euclid(NANOS_PER_SECOND)) {
            Ok(sec) => Self {
                sec,
                nanosec: nanos.rem_euclid(NANOS_PER_SECOND) as u32,
            },
            Err(_) if nanos < 0 => Self {
                sec: i32::MIN,
                nanosec: 0,
            },
            Err(_) => Self {
                sec: i32::MAX,
                nanosec: 999_999_999,
            },
        }
    }

    /// Nanoseconds since the clock's zero.
    pub fn as_nanos(&self) -> i64 {
        i64::from(self.sec) * NANOS_PER_SECOND + i64::from(self.nanosec)
    }
}

fn check_time(time: &Time) -> Result<(), DatumError> {
    if i64::from(time.nanosec) < NANOS_PER_SECOND {
        Ok(())
    } else {
        Err(implausible("nanosec", "a second or more"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_counts_forward_from_whole_seconds() {
        for (nanos, sec, nanosec) in [
            (0, 0, 0),
            (1_500_000_000, 1, 500_000_000),
            (-1, -1, 999_999_999),
            (i64::MAX, i32::MAX, 999_999_999),
            (i64::MIN, i32::MIN, 0),
        ] {
            assert_eq!(Time::from_nanos(nanos), Time { sec, nanosec });
        }
        assert_eq!(Time::from_nanos(-7_300_000_001).as_nanos(), -7_300_000_001);
    }
}
