//! Times in messages.

use asmotion_datum::Datum;

/// A time of ROS: seconds and nanoseconds since 1970. Times before are 1970, times after 2106 are 2106.
pub(crate) fn time(nanoseconds: i64) -> Datum {
    let nanoseconds = nanoseconds.max(0);
    let seconds = (nanoseconds / 1_000_000_000).min(i64::from(u32::MAX));
    Datum::record([
        ("sec", Datum::Int(seconds)),
        ("nanosec", Datum::Int(nanoseconds % 1_000_000_000)),
    ])
}

/// Nanoseconds since 1970 of a time of ROS.
pub(crate) fn nanoseconds(time: &Datum) -> Option<i64> {
    let part = |name| time.get(name)?.as_int();
    Some(part("sec")? * 1_000_000_000 + part("nanosec")?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_unsigned() {
        for stamp in [0, 1, 999_999_999, 1_000_000_000, 1_795_544_262_000_000_781] {
            assert_eq!(nanoseconds(&time(stamp)), Some(stamp));
        }
        assert_eq!(nanoseconds(&time(-1)), Some(0));
        assert_eq!(
            time(i64::MAX).get("sec").unwrap().as_int(),
            Some(i64::from(u32::MAX))
        );
        assert_eq!(nanoseconds(&Datum::Null), None);
    }
}
