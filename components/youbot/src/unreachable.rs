//! Reasons why a goal cannot be reached.

/// The reason that no posture brings the hand to a goal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unreachable {
    /// A coordinate is not finite, or the orientation has no length.
    #[error("the goal has a coordinate that is no number, or no orientation")]
    BadPose,
    /// The hand would point out of the arm's plane.
    #[error(
        "the hand can only point along the plane of the arm, and the goal points {angle:.3} rad out of it"
    )]
    OutOfPlane {
        /// Angle between the goal and the plane of the arm, rad.
        angle: f64,
    },
    /// The wrist would be too far away.
    #[error(
        "the wrist would be {distance:.3} m from the shoulder, and the arm is {reach:.3} m long"
    )]
    TooFar {
        /// Distance from axis 2 to axis 4, m.
        distance: f64,
        /// Length of upper arm and forearm together, m.
        reach: f64,
    },
    /// The wrist would be too near.
    #[error(
        "the wrist would be {distance:.3} m from the shoulder, and the arm folds to {least:.3} m only"
    )]
    TooNear {
        /// Distance from axis 2 to axis 4, m.
        distance: f64,
        /// Difference between the lengths of upper arm and forearm, m.
        least: f64,
    },
    /// A joint would exceed its range.
    #[error(
        "joint {joint} would be at {position:.3} rad, and turns from {least:.3} to {greatest:.3} only"
    )]
    JointLimit {
        /// Number of the joint, from 1 at the base.
        joint: usize,
        /// Required position, rad.
        position: f64,
        /// Lower end of the joint's range, rad.
        least: f64,
        /// Upper end of the joint's range, rad.
        greatest: f64,
    },
}

impl Unreachable {
    /// The fault code in the service.
    pub fn code(&self) -> &'static str {
        match self {
            Self::BadPose => "BAD_POSE",
            Self::OutOfPlane { .. } => "OUT_OF_PLANE",
            Self::TooFar { .. } => "TOO_FAR",
            Self::TooNear { .. } => "TOO_NEAR",
            Self::JointLimit { .. } => "JOINT_LIMIT",
        }
    }
}
