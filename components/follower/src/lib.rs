//! The trajectory follower: regulated pure pursuit.
//!
//! [`Pursuit`] is the control law, [`FollowTask`] the current order, [`TrajectoryFollower`] the component.

mod follower;
mod pursuit;
mod task;

pub use follower::TrajectoryFollower;
pub use pursuit::Pursuit;
pub use task::{FollowTask, FollowerEvent, MeasuredMotion, Tolerance};
