//! Units of measurement, with their sizes.

/// A unit of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    pub(crate) name: &'static str,
    pub(crate) quantity: &'static str,
    /// Size in the unit of the SI.
    pub(crate) size: f64,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

const UNITS: &[(&str, &str, f64)] = &[
    ("rad", "angle", 1.0),
    ("deg", "angle", DEGREE),
    ("m", "length", 1.0),
    ("km", "length", 1000.0),
    ("cm", "length", 0.01),
    ("mm", "length", 0.001),
    ("s", "time", 1.0),
    ("ms", "time", 0.001),
    ("us", "time", 1e-6),
    ("ns", "time", 1e-9),
    ("m/s", "speed", 1.0),
    ("km/h", "speed", 1.0 / 3.6),
    ("mm/s", "speed", 0.001),
    ("rad/s", "angular speed", 1.0),
    ("deg/s", "angular speed", DEGREE),
    ("rpm", "angular speed", std::f64::consts::PI / 30.0),
    ("kg", "mass", 1.0),
    ("g", "mass", 0.001),
    ("N", "force", 1.0),
    ("kN", "force", 1000.0),
    ("Nm", "torque", 1.0),
    ("mNm", "torque", 0.001),
    ("V", "voltage", 1.0),
    ("mV", "voltage", 0.001),
    ("A", "current", 1.0),
    ("mA", "current", 0.001),
    ("1", "ratio", 1.0),
    ("%", "ratio", 0.01),
];

impl Unit {
    /// The unit with this name.
    pub(crate) fn find(name: &str) -> Option<Self> {
        let found = UNITS.iter().find(|(known, ..)| *known == name);
        found.map(|&(name, quantity, size)| Self {
            name,
            quantity,
            size,
        })
    }
}
