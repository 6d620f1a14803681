//! The trajectory follower: regulated pure pursuit.
//!
//! [`Settings`] is the control law, [`Task`] what the follower is doing, [`TrajectoryFollower`] the component.

mod follower;
mod pursuit;
mod task;

pub use follower::TrajectoryFollower;
pub use pursuit::Settings;
pub use task::{Motion, News, Task, Tolerance};
