//! Actions: goals that take their time, tell how far they are, end with a result, and can be cancelled. Source: the ROS wiki,
//! "actionlib/DetailedDescription".

mod client;
mod message;
mod state;

pub use client::{ActionClient, ActionClientCounts, ActionError};
pub use message::{ActionType, ActionTypeError, GoalId};
pub use state::{ActionEvent, GoalOutcome, GoalPhase};
