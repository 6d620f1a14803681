//! How a bridge calls services and actions of ROS, and offers operations as such; each generation of ROS implements it.

use std::time::Duration;

use asmotion_component::ServiceFault;
use asmotion_component::declaration::OperationDeclaration;
use asmotion_datum::{Datum, Schema};

use crate::mapped::RosDirection;

/// No server of ROS took the request: a call goes to the next alternative of its reference.
pub use asmotion_component::NO_SERVER;
/// The server ended before it answered; it may have carried out the request.
pub const SERVER_DIED: &str = "SERVER_DIED";
/// The service failed, in its words.
pub const REFUSED: &str = "REFUSED";
/// The server has another type.
pub const OTHER_TYPE: &str = "OTHER_TYPE";
/// The request does not fit the type.
pub const BAD_ARGUMENT: &str = "BAD_ARGUMENT";
/// The response does not fit the type.
pub const BAD_REPLY: &str = "BAD_REPLY";
/// The server has given up the goal.
pub const ABORTED: &str = "ABORTED";
/// The goal was cancelled, or replaced by another one, after it had begun.
pub const PREEMPTED: &str = "PREEMPTED";
/// The goal was cancelled before it had begun.
pub const RECALLED: &str = "RECALLED";
/// The server has refused the goal.
pub const REJECTED: &str = "REJECTED";
/// The server no longer knows the goal, or is silent.
pub const LOST: &str = "LOST";

/// An operation of a component that a bridge joins with a service or an action of ROS.
#[derive(Clone, Debug, PartialEq)]
pub struct MappedOperation {
    /// Service of the bridge (to ROS), or its reference (from ROS).
    pub port: String,
    /// Interface of the service or reference.
    pub interface: String,
    /// The operation.
    pub operation: OperationDeclaration,
    /// Operation of the same service that cancels all goals.
    pub cancel: Option<OperationDeclaration>,
    /// Port with the feedback of the goals: an output (to ROS), or an input (from ROS).
    pub feedback: Option<MappedFeedback>,
    /// Output with the results of goals that end without success (to ROS).
    pub result: Option<MappedFeedback>,
    /// Service or action of ROS, such as `/make_plan`.
    pub ros: String,
    /// Type in ROS, such as `nav_msgs/GetPlan`.
    pub kind: String,
    /// Direction of the requests.
    pub direction: RosDirection,
}

/// The port with the feedback of an action, or with the results of goals that fail.
#[derive(Clone, Debug, PartialEq)]
pub struct MappedFeedback {
    /// Port of the bridge.
    pub port: String,
    /// Schema of the port.
    pub schema: Schema,
}

/// The type of a service or an action, with the fields that only one generation of ROS has.
#[derive(Clone, Debug, PartialEq)]
pub struct OperationSchemas {
    /// Of the request, or the goal.
    pub request: Schema,
    /// Of the response, or the result.
    pub response: Schema,
    /// Of the feedback; `None` for a service.
    pub feedback: Option<Schema>,
}

/// Identifies a call or a goal of one operation.
pub type CallNumber = u64;

/// Calls a service of ROS, or sends goals to an action server. Nothing blocks.
pub trait OperationCaller: Send {
    /// Sends a request, or a goal. It ends in [`take`](Self::take), at the latest after `timeout` if it is a request.
    fn call(&mut self, call: CallNumber, request: &Datum, timeout: Duration);

    /// Stops waiting for a call that has not ended; a goal is cancelled at its server. It still may end in
    /// [`take`](Self::take).
    fn cancel(&mut self, call: CallNumber);

    /// As [`cancel`](Self::cancel), for a call whose caller does not wait any longer. It may be about to make another one in its place.
    fn give_up(&mut self, call: CallNumber) {
        self.cancel(call);
    }

    /// Takes what has become of the calls. A call ends once.
    fn take(&mut self) -> Vec<CallProgress>;

    /// Time after which [`take`](Self::take) is to be called also if nothing has woken the bridge.
    fn patience(&self) -> Option<Duration>;
}

/// What has become of a call.
#[derive(Clone, Debug, PartialEq)]
pub enum CallProgress {
    /// The server has told how far it is.
    Feedback(Datum),
    /// A goal has ended without success, and with this result. Its end follows.
    Failure(Datum),
    /// The call has ended.
    Ended {
        /// The call.
        call: CallNumber,
        /// The response, or the reason that there is none.
        result: Result<Datum, ServiceFault>,
    },
}

/// Offers a service or an action to nodes of ROS. Nothing blocks.
pub trait OperationServer: Send {
    /// Takes the requests that have arrived, and the cancellations of earlier ones.
    fn take(&mut self) -> Vec<ServedRequest>;

    /// Tells the clients of all goals how far they are.
    ///
    /// # Errors
    /// The reason that the feedback cannot be encoded.
    fn tell(&mut self, feedback: &Datum) -> Result<(), String>;

    /// Ends a request. Does nothing if it has ended.
    ///
    /// # Errors
    /// The reason that the response cannot be encoded; the client receives an error.
    fn end(&mut self, call: CallNumber, end: ServedEnd) -> Result<(), String>;

    /// Time after which [`take`](Self::take) is to be called also if nothing has woken the bridge.
    fn patience(&self) -> Option<Duration>;
}

/// What a client of ROS asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum ServedRequest {
    /// A request, or a goal.
    Call(CallNumber, Datum),
    /// The client no longer waits for a request, or cancels a goal.
    Cancel(CallNumber),
}

/// How a request from ROS ends.
#[derive(Clone, Debug, PartialEq)]
pub enum ServedEnd {
    /// With a response.
    Done(Datum),
    /// With an error.
    Failed(String),
    /// As its client has asked for.
    Cancelled,
}
