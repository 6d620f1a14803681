//! Actions: goals that take their time, tell how far they are, end with a result, and can be cancelled. Source: the ROS wiki,
//! "actionlib/DetailedDescription".

mod client;
mod message;
mod server;
mod state;
mod status;

pub use client::{ActionClient, ActionClientCounts, ActionError};
pub use message::{ActionType, ActionTypeError, GoalId};
pub use server::{ActionRequest, ActionServer, ServedGoalError};
pub use state::{ActionEvent, GoalOutcome, GoalPhase};
