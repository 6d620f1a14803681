//! The limits of the joints, for displays.

use asmotion_component::Properties;

use crate::arm::Arm;

/// Pairs of the least and the greatest value that are fine: one for each joint, or one for all of them. The dashboard draws them as
/// bands; the driver itself does not heed them.
#[derive(Properties)]
#[allow(
    dead_code,
    reason = "displays read them from the component's description"
)]
pub(crate) struct Limits {
    /// Least and greatest position of each joint, rad; those of the youBot by default.
    #[property(default = positions())]
    position_limits: Vec<[f64; 2]>,
    /// The same for the velocity, rad/s; none by default.
    velocity_limits: Vec<[f64; 2]>,
    /// The same for the current, A; none by default.
    current_limits: Vec<[f64; 2]>,
    /// The same for the temperature, °C; none by default.
    temperature_limits: Vec<[f64; 2]>,
}

/// The ranges of the youBot's joints, with four decimals.
fn positions() -> Vec<[f64; 2]> {
    let rounded = |angle: f64| (angle * 1e4).round() / 1e4;
    let ranges = Arm::default().ranges.into_iter();
    ranges
        .map(|(least, greatest)| [rounded(least), rounded(greatest)])
        .collect()
}
