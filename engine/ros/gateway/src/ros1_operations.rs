//! Services and actions of ROS 1.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use asmotion_bus::{
    CallFailure, IncomingCall, Notifier, Payload, PendingCall, Refusal, Request, SenderId,
    ServedAddress,
};
use asmotion_component::ServiceFault;
use asmotion_datum::{Datum, Schema};
use asmotion_ros1::{
    ActionClient, ActionError, ActionEvent, ActionRequest, ActionServer, ActionType, DIED, FAILED,
    GoalId, GoalOutcome, MISMATCH, RosNode, RosServiceClient, ServiceType,
};

use crate::operation::{
    ABORTED, BAD_ARGUMENT, BAD_REPLY, CallNumber, CallProgress, LOST, NO_SERVER, OTHER_TYPE,
    OperationCaller, OperationServer, PREEMPTED, RECALLED, REFUSED, REJECTED, SERVER_DIED,
    ServedEnd, ServedRequest,
};

/// Time for which a goal waits for an action server, which another node may just be starting.
const SERVER_WAIT: Duration = Duration::from_secs(2);
/// Time without a status after which an action server counts as gone; servers send five a second.
const SILENCE: Duration = Duration::from_secs(5);
/// Interval at which states are checked of which nothing wakes the bridge.
const CHECK: Duration = Duration::from_millis(100);
/// Requests that wait for the bridge.
const WAITING: usize = 64;

/// Calls a service.
pub(crate) struct Ros1ServiceCaller {
    client: RosServiceClient,
    node: Arc<str>,
    notifier: Arc<Notifier>,
    open: BTreeMap<CallNumber, PendingCall>,
}

impl Ros1ServiceCaller {
    pub(crate) fn new(
        node: &RosNode,
        ros: &str,
        of: ServiceType,
        notifier: Arc<Notifier>,
    ) -> Result<Self, String> {
        let client = node.service_client(ros, of, false);
        Ok(Self {
            client: client.map_err(|error| error.to_string())?,
            node: node.name().to_string().into(),
            notifier,
            open: BTreeMap::new(),
        })
    }
}

impl OperationCaller for Ros1ServiceCaller {
    fn call(&mut self, call: CallNumber, request: &Datum, timeout: Duration) {
        let origin = SenderId::new(Arc::clone(&self.node), 0);
        let request = Request::new(origin, Payload::of(request.clone()), timeout);
        let pending = self.client.call(request, Arc::clone(&self.notifier));
        self.open.insert(call, pending);
    }

    fn cancel(&mut self, call: CallNumber) {
        if let Some(pending) = self.open.remove(&call) {
            pending.cancel();
        }
    }

    fn take(&mut self) -> Vec<CallProgress> {
        let mut ended = Vec::new();
        self.open.retain(|call, pending| {
            let Some(result) = pending.try_take() else {
                return true;
            };
            let result = match result {
                Ok(payload) => payload.to_datum().map_err(|error| {
                    // the node has decoded it
                    ServiceFault::new(BAD_REPLY, error.to_string())
                }),
                Err(failure) => Err(fault(failure)),
            };
            ended.push(CallProgress::Ended {
                call: *call,
                result,
            });
            false
        });
        ended
    }

    fn patience(&self) -> Option<Duration> {
        None
    }
}

/// The fault of a failed call.
fn fault(failure: CallFailure) -> ServiceFault {
    match failure {
        CallFailure::Refused(Refusal { code, detail }) => {
            let code = match &*code {
                FAILED => REFUSED,
                MISMATCH => OTHER_TYPE,
                DIED => SERVER_DIED,
                _ => BAD_REPLY,
            };
            ServiceFault::new(code, detail)
        }
        CallFailure::Unavailable | CallFailure::Stopped => {
            ServiceFault::new(NO_SERVER, "no node of ROS provides the service")
        }
        failure @ (CallFailure::Timeout | CallFailure::Cancelled) => {
            ServiceFault::new(SERVER_DIED, failure.to_string())
        }
    }
}

/// Sends goals to an action server.
pub(crate) struct Ros1GoalCaller {
    client: ActionClient,
    /// Goals for a server that is not connected yet, with the times at which they end.
    waiting: Vec<(CallNumber, Datum, Instant)>,
    goals: BTreeMap<GoalId, CallNumber>,
    ended: Vec<CallProgress>,
}

impl Ros1GoalCaller {
    pub(crate) fn new(
        node: &RosNode,
        ros: &str,
        of: &ActionType,
        notifier: &Arc<Notifier>,
    ) -> Result<Self, String> {
        let client = ActionClient::new(node, ros, of, notifier);
        Ok(Self {
            client: client.map_err(|error| error.to_string())?,
            waiting: Vec::new(),
            goals: BTreeMap::new(),
            ended: Vec::new(),
        })
    }

    fn fail(&mut self, call: CallNumber, code: &str, detail: impl Into<String>) {
        let result = Err(ServiceFault::new(code, detail));
        self.ended.push(CallProgress::Ended { call, result });
    }

    /// Sends a goal, if a server is connected. Returns whether it has been dealt with.
    fn send(&mut self, call: CallNumber, goal: &Datum) -> bool {
        match self.client.send(goal, 0) {
            Ok(id) => {
                self.goals.insert(id, call);
            }
            Err(ActionError::NoServer) => return false,
            Err(ActionError::Goal(error)) => self.fail(call, BAD_ARGUMENT, error.to_string()),
        }
        true
    }

    fn send_waiting(&mut self) {
        for (call, goal, until) in std::mem::take(&mut self.waiting) {
            if self.send(call, &goal) {
                continue;
            }
            if Instant::now() < until {
                self.waiting.push((call, goal, until));
            } else {
                self.fail(call, NO_SERVER, "no action server of ROS is connected");
            }
        }
    }

    /// Gives up the goals of a server that is silent. Should it come back, it is asked to cancel them.
    fn check_silence(&mut self) {
        if self.client.silence().is_none_or(|it| it <= SILENCE) {
            return;
        }
        for (goal, call) in std::mem::take(&mut self.goals) {
            self.client.cancel(&goal);
            let detail = format!("no status of the action server for {SILENCE:?}");
            self.fail(call, LOST, detail);
        }
    }

    fn done(&mut self, goal: &GoalId, outcome: GoalOutcome, text: String, result: Option<Datum>) {
        let Some(call) = self.goals.remove(goal) else {
            return;
        };
        let code = match outcome {
            GoalOutcome::Succeeded => {
                // a result belongs to every outcome of a server
                let result = result.unwrap_or_default();
                let result = Ok(result);
                return self.ended.push(CallProgress::Ended { call, result });
            }
            GoalOutcome::Aborted => ABORTED,
            GoalOutcome::Preempted => PREEMPTED,
            GoalOutcome::Recalled => RECALLED,
            GoalOutcome::Rejected => REJECTED,
            GoalOutcome::Lost => LOST,
        };
        self.ended.extend(result.map(CallProgress::Failure));
        self.fail(call, code, text);
    }
}

impl OperationCaller for Ros1GoalCaller {
    fn call(&mut self, call: CallNumber, request: &Datum, timeout: Duration) {
        if !self.send(call, request) {
            // an alternative of the reference has the rest of the time
            let wait = SERVER_WAIT.min(timeout / 2);
            let until = Instant::now() + wait;
            self.waiting.push((call, request.clone(), until));
        }
    }

    fn cancel(&mut self, call: CallNumber) {
        if let Some(at) = self.waiting.iter().position(|(of, ..)| *of == call) {
            self.waiting.remove(at);
            return self.fail(call, RECALLED, "cancelled before a server was connected");
        }
        let mut goals = self.goals.iter();
        if let Some((goal, _)) = goals.find(|(_, of)| **of == call) {
            self.client.cancel(goal);
        }
    }

    fn take(&mut self) -> Vec<CallProgress> {
        let mut feedback = Vec::new();
        for event in self.client.update() {
            match event {
                ActionEvent::Phase { .. } => {}
                ActionEvent::Feedback { goal, feedback: it } => {
                    if self.goals.contains_key(&goal) {
                        feedback.push(CallProgress::Feedback(it));
                    }
                }
                ActionEvent::Done {
                    goal,
                    outcome,
                    text,
                    result,
                } => self.done(&goal, outcome, text, result),
            }
        }
        self.check_silence();
        self.send_waiting();
        feedback.append(&mut self.ended);
        feedback
    }

    fn patience(&self) -> Option<Duration> {
        let is_idle = self.waiting.is_empty() && self.goals.is_empty() && self.ended.is_empty();
        (!is_idle).then_some(CHECK)
    }
}

impl Drop for Ros1GoalCaller {
    fn drop(&mut self) {
        for goal in self.goals.keys() {
            self.client.cancel(goal);
        }
    }
}

/// Provides a service.
pub(crate) struct Ros1ServiceServer {
    served: ServedAddress,
    last: CallNumber,
    open: BTreeMap<CallNumber, IncomingCall>,
}

impl Ros1ServiceServer {
    pub(crate) fn new(
        node: &RosNode,
        ros: &str,
        of: ServiceType,
        notifier: Arc<Notifier>,
    ) -> Result<Self, String> {
        let served = node.serve(ros, of, WAITING, notifier);
        Ok(Self {
            served: served.map_err(|error| error.to_string())?,
            last: 0,
            open: BTreeMap::new(),
        })
    }
}

impl OperationServer for Ros1ServiceServer {
    fn take(&mut self) -> Vec<ServedRequest> {
        let mut requests = Vec::new();
        self.open.retain(|call, incoming| {
            let is_awaited = incoming.is_awaited();
            if !is_awaited {
                requests.push(ServedRequest::Cancel(*call));
            }
            is_awaited
        });
        while let Some(incoming) = self.served.try_next() {
            // the node has decoded it
            let Ok(request) = incoming.argument.to_datum() else {
                continue;
            };
            self.last += 1;
            self.open.insert(self.last, incoming);
            requests.push(ServedRequest::Call(self.last, request));
        }
        requests
    }

    fn tell(&mut self, _: &Datum) -> Result<(), String> {
        Ok(())
    }

    fn end(&mut self, call: CallNumber, end: ServedEnd) -> Result<(), String> {
        let Some(incoming) = self.open.remove(&call) else {
            return Ok(());
        };
        let failed = |detail: String| {
            Err(Refusal {
                // rospy shows code and detail as one text
                code: String::new(),
                detail,
            })
        };
        incoming.reply(match end {
            ServedEnd::Done(response) => Ok(Payload::of(response)),
            ServedEnd::Failed(reason) => failed(reason),
            ServedEnd::Cancelled => failed("cancelled".to_owned()),
        });
        Ok(())
    }

    fn patience(&self) -> Option<Duration> {
        (!self.open.is_empty()).then_some(CHECK)
    }
}

/// Serves goals. A new goal replaces the one before, as in most servers of ROS.
pub(crate) struct Ros1GoalServer {
    server: ActionServer,
    /// A result without content, for goals that fail.
    empty: Datum,
    last: CallNumber,
    open: BTreeMap<CallNumber, GoalId>,
}

impl Ros1GoalServer {
    pub(crate) fn new(
        node: &RosNode,
        ros: &str,
        of: &ActionType,
        result: &Schema,
        notifier: &Arc<Notifier>,
    ) -> Result<Self, String> {
        let server = ActionServer::new(node, ros, of, notifier);
        let empty = result.complete(Datum::Record(Vec::new()));
        Ok(Self {
            server: server.map_err(|error| error.to_string())?,
            empty: empty.map_err(|error| error.to_string())?,
            last: 0,
            open: BTreeMap::new(),
        })
    }
}

/// The time of the system, in nanoseconds since 1970.
fn now() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let nanoseconds = since.map_or(0, |it| it.as_nanos());
    i64::try_from(nanoseconds).unwrap_or(i64::MAX)
}

impl OperationServer for Ros1GoalServer {
    fn take(&mut self) -> Vec<ServedRequest> {
        let mut requests = Vec::new();
        for request in self.server.update(now()) {
            match request {
                ActionRequest::Goal { goal, content } => {
                    if self.server.accept(&goal).is_err() {
                        continue;
                    }
                    requests.extend(self.open.keys().map(|call| ServedRequest::Cancel(*call)));
                    self.last += 1;
                    self.open.insert(self.last, goal);
                    requests.push(ServedRequest::Call(self.last, content));
                }
                ActionRequest::Cancel { goal } => {
                    let mut open = self.open.iter();
                    let call = open.find(|(_, of)| **of == goal).map(|(call, _)| *call);
                    requests.extend(call.map(ServedRequest::Cancel));
                }
            }
        }
        requests
    }

    fn tell(&mut self, feedback: &Datum) -> Result<(), String> {
        for goal in self.open.values() {
            let told = self.server.tell(goal, feedback.clone());
            told.map_err(|error| error.to_string())?;
        }
        Ok(())
    }

    fn end(&mut self, call: CallNumber, end: ServedEnd) -> Result<(), String> {
        let Some(goal) = self.open.remove(&call) else {
            return Ok(());
        };
        let empty = self.empty.clone();
        let (outcome, result, text) = match end {
            ServedEnd::Done(result) => (GoalOutcome::Succeeded, result, String::new()),
            ServedEnd::Failed(reason) => (GoalOutcome::Aborted, empty, reason),
            ServedEnd::Cancelled => (GoalOutcome::Preempted, empty, "cancelled".to_owned()),
        };
        let ended = self.server.end(&goal, outcome, result, &text);
        ended.map_err(|error| error.to_string())
    }

    fn patience(&self) -> Option<Duration> {
        // statuses are told several times a second
        Some(CHECK)
    }
}
