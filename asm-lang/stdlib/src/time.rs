//! Functions that return the time of the step.

use crate::builtin::{Builtin, strict};
use asmotion_value::Value;

const NANOS_PER_MILLI: i64 = 1_000_000;
const NANOS_PER_SEC: i64 = 1_000_000_000;

pub(crate) const TABLE: &[Builtin] = &[
    strict("currTimeNanosecs", "", |_, context| {
        Ok(Value::Int(context.now_ns))
    }),
    strict("currTimeMillisecs", "", |_, context| {
        Ok(Value::Int(context.now_ns / NANOS_PER_MILLI))
    }),
    strict("currTimeSecs", "", |_, context| {
        Ok(Value::Int(context.now_ns / NANOS_PER_SEC))
    }),
];

#[cfg(test)]
mod tests {
    use crate::testing::*;

    #[test]
    fn units_are_cut() {
        check("currTimeNanosecs", "", &[], "1999999999");
        check("currTimeMillisecs", "", &[], "1999");
        check("currTimeSecs", "", &[], "1");
    }
}
