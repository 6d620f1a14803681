//! The point of a run up to which it is replayed.

use asmotion_coordinator::RecordedCycle;

/// The point at which a replay stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopPoint {
    /// After the step with this number.
    Step(u64),
    /// After the last step that is not later than this time, in nanoseconds of the run.
    Time(i64),
}

/// Units of time, with their nanoseconds.
const UNITS: [(&str, f64); 4] = [("ms", 1e6), ("us", 1e3), ("min", 60e9), ("s", 1e9)];

impl StopPoint {
    /// Reads `213`, `12.5s` or `800ms`.
    ///
    /// # Errors
    /// The text is neither a number nor a time.
    pub fn parse(text: &str) -> Result<Self, String> {
        if let Ok(number) = text.parse::<u64>() {
            return match number {
                0 => Err(
                    "steps are counted from 1; `0s` is the time before the first one".to_owned(),
                ),
                number => Ok(Self::Step(number)),
            };
        }
        let wrong =
            || "expected the number of a step, as in `213`, or a time, as in `12.5s`".to_owned();
        let units = UNITS.iter();
        let found = units.filter_map(|(unit, ns)| Some((text.strip_suffix(unit)?, ns)));
        let mut times = found.filter_map(|(number, ns)| Some(number.parse::<f64>().ok()? * ns));
        let nanos = times.next().filter(|ns| ns.is_finite() && *ns >= 0.0);
        Ok(Self::Time(nanos.ok_or_else(wrong)?.round() as i64))
    }

    /// Returns whether a record belongs to what comes after this point. `last` is the number of the last step that was repeated.
    pub fn is_before(self, cycle: &RecordedCycle, last: u64) -> bool {
        match self {
            Self::Step(number) => last >= number && cycle.number != number,
            Self::Time(ns) => cycle.time_ns > ns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::StopPoint;

    #[test]
    fn a_point_is_a_step_or_a_time() {
        assert_eq!(StopPoint::parse("213"), Ok(StopPoint::Step(213)));
        assert_eq!(
            StopPoint::parse("12.5s"),
            Ok(StopPoint::Time(12_500_000_000))
        );
        assert_eq!(StopPoint::parse("800ms"), Ok(StopPoint::Time(800_000_000)));
        assert_eq!(
            StopPoint::parse("2min"),
            Ok(StopPoint::Time(120_000_000_000))
        );
        assert_eq!(StopPoint::parse("0s"), Ok(StopPoint::Time(0)));
        for wrong in [
            "", "0", "-1", "-1s", "12.5", "s", "NaNs", "infs", "1h", "12 s!",
        ] {
            assert!(StopPoint::parse(wrong).is_err(), "{wrong}");
        }
    }
}
