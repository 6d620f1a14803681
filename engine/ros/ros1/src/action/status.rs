//! The statuses of `actionlib_msgs/GoalStatus`.

pub(super) const PENDING: i64 = 0;
pub(super) const ACTIVE: i64 = 1;
pub(super) const PREEMPTED: i64 = 2;
pub(super) const SUCCEEDED: i64 = 3;
pub(super) const ABORTED: i64 = 4;
pub(super) const REJECTED: i64 = 5;
pub(super) const PREEMPTING: i64 = 6;
pub(super) const RECALLING: i64 = 7;
pub(super) const RECALLED: i64 = 8;
pub(super) const LOST: i64 = 9;
