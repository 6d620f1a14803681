//! The trajectory follower: regulated pure pursuit.
//!
//! [`Pursuit`] is the control law, [`Caution`] limits its speed, [`FollowTask`] is the current order, [`TrajectoryFollower`] the component.

mod caution;
mod follower;
mod motion;
mod pursuit;
mod task;

pub use caution::{Caution, CautiousView};
pub use follower::TrajectoryFollower;
pub use motion::MeasuredMotion;
pub use pursuit::Pursuit;
pub use task::{FollowTask, FollowerEvent, Tolerance};

/// Protocol of the trajectory follower: what it sends, depending on what it receives.
pub const PROTOCOL: &str = include_str!("../protocol.asm");
