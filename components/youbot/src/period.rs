//! The period that others set: through a port, or with an operation.

use std::time::Duration;

use asmotion_component::{Cycle, Flow, In};
use asmotion_messages::Float64;

/// Sets the period (s) from the next cycle on. Returns whether it is between 0.001 s and 10 s.
pub(crate) fn follow(period: f64, cycle: &mut Cycle<'_>) -> bool {
    let is_valid = (0.001..=10.0).contains(&period);
    if is_valid {
        cycle.set_period(Duration::from_secs_f64(period));
    }
    is_valid
}

/// Sets the period to that of the newest sample, if it is new. Any other than those of [`follow`] is refused.
pub(crate) fn follow_port(port: In<Float64>, cycle: &mut Cycle<'_>) {
    if let Flow::NewData(&Float64 { data }) = cycle.read(port)
        && !follow(data, cycle)
    {
        cycle.refuse(port, format!("{data} s is not 0.001 to 10 s"));
    }
}
