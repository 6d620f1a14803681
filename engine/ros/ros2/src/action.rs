//! Actions: goal, feedback, status, cancel and result.
//!
//! An action is three services and two topics below its name: `_action/send_goal`, `_action/cancel_goal`, `_action/get_result`,
//! `_action/feedback` and `_action/status`. Source: design.ros2.org, "Actions".

mod feedback;
mod kinds;
mod server;

pub use server::{ActionServer, GoalRequest};

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::Datum;
use asmotion_ros_interface::InterfaceName;

use self::feedback::{Feedback, Router, Statuses};
use self::kinds::ActionKinds;
use crate::error::{CallError, EndpointError};
use crate::gid::Gid;
use crate::mapping::ServiceMapping;
use crate::names;
use crate::node::Node;
use crate::notice::Waker;
use crate::participant::Inner;
use crate::qos::Qos;
use crate::queue::Queue;
use crate::reactor::Registration;
use crate::service::{Call, Client};

/// The id of a goal, unique in all systems.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GoalId(pub [u8; 16]);

impl fmt::Debug for GoalId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&Gid(self.0), f)
    }
}

/// The status of a goal (`action_msgs/msg/GoalStatus`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GoalStatus {
    /// Not known to the server, or a number that ROS does not define.
    Unknown,
    /// Accepted, and not yet executed.
    Accepted,
    /// Under way.
    Executing,
    /// A cancel request was accepted.
    Canceling,
    /// Ended with success.
    Succeeded,
    /// Ended after a cancel request.
    Canceled,
    /// Ended by the server without success.
    Aborted,
}

impl GoalStatus {
    pub(crate) fn of_number(number: i64) -> Self {
        match number {
            1 => Self::Accepted,
            2 => Self::Executing,
            3 => Self::Canceling,
            4 => Self::Succeeded,
            5 => Self::Canceled,
            6 => Self::Aborted,
            _ => Self::Unknown,
        }
    }

    fn number(self) -> i64 {
        match self {
            Self::Unknown => 0,
            Self::Accepted => 1,
            Self::Executing => 2,
            Self::Canceling => 3,
            Self::Succeeded => 4,
            Self::Canceled => 5,
            Self::Aborted => 6,
        }
    }

    fn is_end(self) -> bool {
        matches!(self, Self::Succeeded | Self::Canceled | Self::Aborted)
    }
}

/// An event of a goal.
#[derive(Debug, Clone, PartialEq)]
pub enum GoalEvent {
    /// The server accepted the goal.
    Accepted,
    /// The server rejected the goal. No event follows.
    Rejected,
    /// Feedback.
    Feedback(Datum),
    /// The server published another status of the goal.
    Status(GoalStatus),
    /// The server answered a cancel request: `ERROR_NONE` is 0 (`action_msgs/srv/CancelGoal`).
    CancelAnswered(i64),
    /// A cancel request failed; the goal goes on.
    CancelFailed(CallError),
    /// The goal ended. No event follows.
    Finished(GoalStatus, Datum),
    /// The goal or its result was not answered. No event follows.
    Failed(CallError),
}

/// Sends goals to an action.
pub struct ActionClient {
    inner: Arc<Inner>,
    send_goal: Client,
    cancel_goal: Arc<Client>,
    get_result: Arc<Client>,
    router: Arc<Router>,
    readers: [Gid; 2],
    _registrations: [Registration; 2],
}

/// Events of a goal that wait to be taken; the oldest is dropped.
const MOST_EVENTS: usize = 256;

impl Node {
    /// Creates a client of an action. Names as for [`publisher`](Self::publisher).
    ///
    /// # Errors
    /// The name is not valid, the type is not an action that is defined, the catalogue lacks `action_msgs`, or DDS refuses.
    pub fn action_client(
        &self,
        action: &str,
        of: &InterfaceName,
        mapping: ServiceMapping,
    ) -> Result<ActionClient, EndpointError> {
        ActionClient::new(self.inner(), &self.inner().absolute(action)?, of, mapping)
    }
}

impl ActionClient {
    fn new(
        inner: &Arc<Inner>,
        action: &str,
        of: &InterfaceName,
        mapping: ServiceMapping,
    ) -> Result<Self, EndpointError> {
        let kinds = ActionKinds::of(inner, of)?;
        let client = |suffix: &str, of| {
            Client::new(inner, format!("{action}/_action/{suffix}"), of, mapping)
        };
        let router = Arc::new(Router::default());
        let sink = Feedback {
            schema: kinds.feedback.schema,
            router: Arc::clone(&router),
        };
        let topic = names::topic(&format!("{action}/_action/feedback"));
        let (kind, qos) = (kinds.feedback.type_name, kinds::feedback_qos());
        let (feedback, first) = inner.reader(&topic, &kind, qos, None, |_| Box::new(sink))?;
        let sink = Statuses {
            schema: kinds.status.schema,
            router: Arc::clone(&router),
        };
        let topic = names::topic(&format!("{action}/_action/status"));
        let (kind, qos) = (kinds.status.type_name, Qos::latched());
        let hash = kinds.status_hash;
        let (status, second) = inner.reader(&topic, &kind, qos, hash, |_| Box::new(sink))?;
        Ok(Self {
            inner: Arc::clone(inner),
            send_goal: client("send_goal", kinds.send_goal)?,
            cancel_goal: Arc::new(client("cancel_goal", kinds.cancel_goal)?),
            get_result: Arc::new(client("get_result", kinds.get_result)?),
            router,
            readers: [feedback, status],
            _registrations: [first, second],
        })
    }

    /// Sets what is called after events of goals have arrived. A deadline that passes wakes nobody.
    pub fn wake_with(&self, waker: &Waker) {
        for client in [&self.send_goal, &*self.cancel_goal, &*self.get_result] {
            client.wake_with(Arc::clone(waker));
        }
        self.router.set_waker(Arc::clone(waker));
    }

    /// Returns whether a server can be called.
    pub fn is_ready(&self) -> bool {
        self.send_goal.is_ready() && self.get_result.is_ready() && self.cancel_goal.is_ready()
    }

    /// Number of feedback and status messages that could not be read.
    pub fn malformed(&self) -> u64 {
        self.router.malformed()
    }

    /// Sends a goal, which the server has to accept within `acceptance` and to end within `duration` after that. Never waits:
    /// [`Goal::take`] has the events.
    pub fn send(&self, goal: Datum, acceptance: Duration, duration: Duration) -> Goal {
        let id = self.next_id();
        let events = Arc::new(Queue::new(MOST_EVENTS));
        self.router.add(id, &events);
        let request = Datum::record([("goal_id", uuid(id)), ("goal", goal)]);
        Goal {
            id,
            duration,
            stage: Stage::Sent(self.send_goal.call(&request, acceptance)),
            cancelling: None,
            events,
            router: Arc::clone(&self.router),
            get_result: Arc::clone(&self.get_result),
            cancel_goal: Arc::clone(&self.cancel_goal),
        }
    }

    fn next_id(&self) -> GoalId {
        // the id of a participant is unique, and so is the number in it
        let mut id = self.inner.gid().0;
        id[12..].copy_from_slice(&self.inner.next_goal().to_le_bytes());
        GoalId(id)
    }
}

impl Drop for ActionClient {
    fn drop(&mut self) {
        for gid in self.readers {
            self.inner.forget(gid);
        }
    }
}

fn uuid(id: GoalId) -> Datum {
    Datum::record([("uuid", Datum::Bytes(id.0.into()))])
}

/// A goal that was sent.
pub struct Goal {
    id: GoalId,
    duration: Duration,
    stage: Stage,
    cancelling: Option<Call>,
    events: Arc<Queue<GoalEvent>>,
    router: Arc<Router>,
    get_result: Arc<Client>,
    cancel_goal: Arc<Client>,
}

enum Stage {
    /// The server has to accept the goal.
    Sent(Call),
    /// The server has to end the goal.
    Accepted(Call),
    /// The last event was taken.
    Over,
}

impl Goal {
    /// The id.
    pub fn id(&self) -> GoalId {
        self.id
    }

    /// Returns whether the last event was taken.
    pub fn is_over(&self) -> bool {
        matches!(self.stage, Stage::Over)
    }

    /// Returns whether the server was asked to cancel the goal, and has not answered.
    pub fn is_cancelling(&self) -> bool {
        self.cancelling.is_some()
    }

    /// Asks the server to cancel the goal. The answer is an event, the end of the goal another one.
    pub fn cancel(&mut self, deadline: Duration) {
        let none = Datum::record([("sec", Datum::Int(0)), ("nanosec", Datum::Int(0))]);
        let info = Datum::record([("goal_id", uuid(self.id)), ("stamp", none)]);
        let request = Datum::record([("goal_info", info)]);
        self.cancelling = Some(self.cancel_goal.call(&request, deadline));
    }

    /// Takes the oldest event; `None` if there is none now. Never waits.
    pub fn take(&mut self) -> Option<GoalEvent> {
        match &mut self.stage {
            Stage::Over => None,
            Stage::Sent(call) => {
                let result = call.take()?;
                Some(self.answered(result))
            }
            Stage::Accepted(call) => {
                if let Some(event) = self.events.take() {
                    return Some(event);
                }
                if let Some(answer) = self.cancelling.as_mut().and_then(Call::take) {
                    self.cancelling = None;
                    return Some(cancelled(answer));
                }
                let result = call.take()?;
                self.stage = Stage::Over;
                Some(finished(result))
            }
        }
    }

    fn answered(&mut self, result: Result<Datum, CallError>) -> GoalEvent {
        self.stage = Stage::Over;
        let response = match result {
            Ok(response) => response,
            Err(error) => return GoalEvent::Failed(error),
        };
        if response.get("accepted").as_deref() != Some(&Datum::Bool(true)) {
            return GoalEvent::Rejected;
        }
        let request = Datum::record([("goal_id", uuid(self.id))]);
        self.stage = Stage::Accepted(self.get_result.call(&request, self.duration));
        GoalEvent::Accepted
    }
}

fn cancelled(answer: Result<Datum, CallError>) -> GoalEvent {
    match answer {
        Ok(response) => {
            let code = response.get("return_code").and_then(|code| code.as_int());
            GoalEvent::CancelAnswered(code.unwrap_or_default())
        }
        Err(error) => GoalEvent::CancelFailed(error),
    }
}

fn finished(result: Result<Datum, CallError>) -> GoalEvent {
    match result {
        Ok(response) => {
            let status = response.get("status").and_then(|status| status.as_int());
            let result = response.get("result").map(std::borrow::Cow::into_owned);
            let status = GoalStatus::of_number(status.unwrap_or_default());
            GoalEvent::Finished(status, result.unwrap_or_default())
        }
        Err(error) => GoalEvent::Failed(error),
    }
}

impl Drop for Goal {
    fn drop(&mut self) {
        self.router.remove(self.id);
    }
}
