//! Rigid motions: rotation, then translation.

/// A vector in three dimensions, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector3 {
    /// First coordinate.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    /// Third coordinate.
    pub z: f64,
}

impl Vector3 {
    /// The vector with these coordinates.
    pub fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    fn plus(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }

    fn times(self, factor: f64) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }

    fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }
}

/// A rotation as a quaternion of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitQuaternion {
    w: f64,
    /// The imaginary part.
    v: Vector3,
}

/// Cosine of the half angle between two rotations above which they are interpolated on the chord: the sine in the other formula
/// would be close to 0.
const ALMOST_EQUAL: f64 = 0.9995;

impl UnitQuaternion {
    /// No rotation.
    pub const IDENTITY: Self = Self {
        w: 1.0,
        v: Vector3 {
            x: 0.0,
            y: 0.0,
            z: 0.0,
        },
    };

    /// The rotation of a quaternion in the order of ROS, with its length made 1; `None` for one that is far from that length, as
    /// tf2 refuses it, and for numbers that are not finite.
    pub fn normalized([x, y, z, w]: [f64; 4]) -> Option<Self> {
        /// Of the square of the length, as in tf2.
        const TOLERANCE: f64 = 10e-3;
        let square = x * x + y * y + z * z + w * w;
        if !square.is_finite() || (square - 1.0).abs() > TOLERANCE {
            return None;
        }
        Some(Self::of_any_length([x, y, z, w]))
    }

    fn of_any_length([x, y, z, w]: [f64; 4]) -> Self {
        let length = (x * x + y * y + z * z + w * w).sqrt();
        Self {
            w: w / length,
            v: Vector3::new(x, y, z).times(1.0 / length),
        }
    }

    /// The product with any quaternion in the order of ROS: this rotation after the other one.
    pub fn product(self, [x, y, z, w]: [f64; 4]) -> [f64; 4] {
        let (a, b) = (self, Vector3::new(x, y, z));
        let real = a.w * w - (a.v.x * b.x + a.v.y * b.y + a.v.z * b.z);
        let imaginary = b.times(a.w).plus(a.v.times(w)).plus(a.v.cross(b));
        [imaginary.x, imaginary.y, imaginary.z, real]
    }

    fn inverse(self) -> Self {
        Self {
            w: self.w,
            v: self.v.times(-1.0),
        }
    }

    fn after(self, other: Self) -> Self {
        // errors of rounding do not add up along a chain
        Self::of_any_length(self.product(other.to_array()))
    }

    /// The quaternion in the order of ROS: x, y, z, w.
    pub fn to_array(self) -> [f64; 4] {
        [self.v.x, self.v.y, self.v.z, self.w]
    }

    /// The rotated vector.
    pub fn rotate(self, vector: Vector3) -> Vector3 {
        let turned = self.v.cross(vector).times(2.0);
        let rotated = vector.plus(turned.times(self.w));
        rotated.plus(self.v.cross(turned))
    }

    /// The rotation between this one (0) and another (1), on the shorter way at constant angular speed.
    fn slerp(self, other: Self, ratio: f64) -> Self {
        let (a, b) = (self.to_array(), other.to_array());
        let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
        let sign = if dot < 0.0 { -1.0 } else { 1.0 };
        let cosine = dot.abs();
        let (of_a, of_b) = if cosine > ALMOST_EQUAL {
            (1.0 - ratio, ratio)
        } else {
            let angle = cosine.acos();
            let weight = |part: f64| (part * angle).sin() / angle.sin();
            (weight(1.0 - ratio), weight(ratio))
        };
        let mut mixed = a.map(|part| part * of_a);
        for (part, of) in mixed.iter_mut().zip(b) {
            *part += of * of_b * sign;
        }
        Self::of_any_length(mixed)
    }

    /// The rows of the matrix.
    pub(crate) fn rows(self) -> [[f64; 3]; 3] {
        let column = |x, y, z| self.rotate(Vector3::new(x, y, z));
        let (a, b, c) = (
            column(1.0, 0.0, 0.0),
            column(0.0, 1.0, 0.0),
            column(0.0, 0.0, 1.0),
        );
        [[a.x, b.x, c.x], [a.y, b.y, c.y], [a.z, b.z, c.z]]
    }
}

/// A motion that keeps distances: the pose of a frame in another, which takes points of the first to the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    /// Applied first.
    pub rotation: UnitQuaternion,
    /// Applied after the rotation.
    pub offset: Vector3,
}

impl RigidMotion {
    /// No motion.
    pub const IDENTITY: Self = Self {
        rotation: UnitQuaternion::IDENTITY,
        offset: Vector3 {
            x: 0.0,
            y: 0.0,
            z: 0.0,
        },
    };

    /// A translation without rotation.
    pub fn translation(x: f64, y: f64, z: f64) -> Self {
        Self {
            offset: Vector3::new(x, y, z),
            ..Self::IDENTITY
        }
    }

    /// The motion that takes a point to where this one takes what the other has moved.
    pub fn after(self, other: Self) -> Self {
        Self {
            rotation: self.rotation.after(other.rotation),
            offset: self.apply(other.offset),
        }
    }

    /// The motion back.
    #[must_use]
    pub fn inverse(self) -> Self {
        let rotation = self.rotation.inverse();
        Self {
            rotation,
            offset: rotation.rotate(self.offset).times(-1.0),
        }
    }

    /// Moves a point.
    pub fn apply(self, point: Vector3) -> Vector3 {
        self.rotation.rotate(point).plus(self.offset)
    }

    /// The motion between this one (0) and another (1).
    pub(crate) fn interpolate(self, other: Self, ratio: f64) -> Self {
        let (near, far) = (self.offset.times(1.0 - ratio), other.offset.times(ratio));
        Self {
            rotation: self.rotation.slerp(other.rotation, ratio),
            offset: near.plus(far),
        }
    }

    pub(crate) fn is_finite(self) -> bool {
        self.offset.is_finite()
    }
}
