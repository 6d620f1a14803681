//! Services and actions of ROS 2.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_component::ServiceFault;
use asmotion_datum::{Datum, Schema};
use asmotion_ros_interface::InterfaceName;
use asmotion_ros2::{
    ActionClient, ActionServer, Call, CallError, Client, Goal, GoalEvent, GoalId, GoalRequest,
    GoalStatus, Node, ReplyTo, Server, ServiceMapping,
};

use crate::operation::{
    ABORTED, BAD_ARGUMENT, BAD_REPLY, CallNumber, CallProgress, LOST, NO_SERVER, OperationCaller,
    OperationServer, PREEMPTED, RECALLED, REJECTED, SERVER_DIED, ServedEnd, ServedRequest,
};
use crate::wake::Wake;

/// Time for which a request waits for a server, which another node may just be starting.
const SERVER_WAIT: Duration = Duration::from_secs(2);
/// Time in which a server accepts or rejects a goal, or answers a request to cancel.
const ACCEPTANCE: Duration = Duration::from_secs(5);
/// Time without a server after which its goals count as lost.
const ABSENCE: Duration = Duration::from_secs(2);
/// Time in which a server replaces a goal by the next one.
const REPLACEMENT: Duration = Duration::from_secs(1);
/// Time in which the next goal of a caller follows after it has given up one. Both leave the caller in the same cycle, but the bridge can
/// run between them.
const SUCCESSION: Duration = Duration::from_millis(20);
/// Longest goal. Callers with a deadline cancel theirs before.
const LONGEST: Duration = Duration::from_secs(24 * 3600);
/// Interval at which states are checked of which nothing wakes the bridge.
const CHECK: Duration = Duration::from_millis(50);
/// Requests that wait for the bridge.
const WAITING: usize = 64;

/// A request for a server that has not been found yet.
struct Waiting {
    call: CallNumber,
    request: Datum,
    timeout: Duration,
    until: Instant,
}

impl Waiting {
    fn new(call: CallNumber, request: &Datum, timeout: Duration) -> Self {
        Self {
            call,
            request: request.clone(),
            timeout,
            // an alternative of the reference has the rest of the time
            until: Instant::now() + SERVER_WAIT.min(timeout / 2),
        }
    }
}

fn ended(call: CallNumber, code: &str, detail: impl Into<String>) -> CallProgress {
    let result = Err(ServiceFault::new(code, detail));
    CallProgress::Ended { call, result }
}

/// The fault of a failed call.
fn fault(error: &CallError) -> ServiceFault {
    let code = match error {
        CallError::Request(_) => BAD_ARGUMENT,
        CallError::NoServer { .. } | CallError::TooMany(..) | CallError::Send(_) => NO_SERVER,
        CallError::Deadline { .. } => SERVER_DIED,
        CallError::Malformed { .. } => BAD_REPLY,
    };
    ServiceFault::new(code, error.to_string())
}

/// Takes the requests whose server has come, and ends those that have waited for too long.
fn due(waiting: &mut Vec<Waiting>, is_ready: bool, ends: &mut Vec<CallProgress>) -> Vec<Waiting> {
    if is_ready {
        return std::mem::take(waiting);
    }
    let now = Instant::now();
    waiting.retain(|it| {
        let is_over = now >= it.until;
        if is_over {
            ends.push(ended(it.call, NO_SERVER, "no node of ROS provides it"));
        }
        !is_over
    });
    Vec::new()
}

/// Calls a service.
pub(crate) struct Ros2ServiceCaller {
    client: Client,
    waiting: Vec<Waiting>,
    open: BTreeMap<CallNumber, Call>,
}

impl Ros2ServiceCaller {
    pub(crate) fn new(
        node: &Node,
        ros: &str,
        of: &InterfaceName,
        wake: &Wake,
    ) -> Result<Self, String> {
        let client = node.client(ros, of, ServiceMapping::OfPeer);
        let client = client.map_err(|error| error.to_string())?;
        client.wake_with(Arc::clone(wake));
        Ok(Self {
            client,
            waiting: Vec::new(),
            open: BTreeMap::new(),
        })
    }
}

impl OperationCaller for Ros2ServiceCaller {
    fn call(&mut self, call: CallNumber, request: &Datum, timeout: Duration) {
        self.waiting.push(Waiting::new(call, request, timeout));
    }

    fn cancel(&mut self, call: CallNumber) {
        self.waiting.retain(|it| it.call != call);
        self.open.remove(&call);
    }

    fn take(&mut self) -> Vec<CallProgress> {
        let mut ends = Vec::new();
        let is_ready = self.client.is_ready();
        for it in due(&mut self.waiting, is_ready, &mut ends) {
            let call = self.client.call(&it.request, it.timeout);
            self.open.insert(it.call, call);
        }
        self.open.retain(|call, pending| {
            let Some(result) = pending.take() else {
                return true;
            };
            let result = result.map_err(|error| fault(&error));
            ends.push(CallProgress::Ended {
                call: *call,
                result,
            });
            false
        });
        ends
    }

    fn patience(&self) -> Option<Duration> {
        let is_idle = self.waiting.is_empty() && self.open.is_empty();
        (!is_idle).then_some(CHECK)
    }
}

/// Sends goals to an action server.
pub(crate) struct Ros2GoalCaller {
    client: ActionClient,
    waiting: Vec<Waiting>,
    goals: BTreeMap<CallNumber, Goal>,
    /// Goals to be cancelled: at once, or when their server has accepted them.
    cancelled: BTreeSet<CallNumber>,
    /// Goals that their callers have given up, with the time; the next goal can replace them.
    given_up: BTreeMap<CallNumber, Instant>,
    replaced: Vec<Replaced>,
    /// Since when no server has been seen although goals are under way.
    absent: Option<Instant>,
    ends: Vec<CallProgress>,
}

/// A goal that its caller has cancelled by sending another one. A server that executes one goal at a time replaces it without
/// stopping the robot, as a cancellation would do. It is cancelled if it has not ended soon after the other one was accepted.
struct Replaced {
    call: CallNumber,
    goal: Goal,
    by: CallNumber,
    /// When the other one was accepted.
    since: Option<Instant>,
    is_cancelled: bool,
}

impl Ros2GoalCaller {
    pub(crate) fn new(
        node: &Node,
        ros: &str,
        of: &InterfaceName,
        wake: &Wake,
    ) -> Result<Self, String> {
        let client = node.action_client(ros, of, ServiceMapping::OfPeer);
        let client = client.map_err(|error| error.to_string())?;
        client.wake_with(wake);
        Ok(Self {
            client,
            waiting: Vec::new(),
            goals: BTreeMap::new(),
            cancelled: BTreeSet::new(),
            given_up: BTreeMap::new(),
            replaced: Vec::new(),
            absent: None,
            ends: Vec::new(),
        })
    }

    /// Sends the goals whose server is there, and cancels those of before that are not replaced by one of them.
    fn send(&mut self, is_ready: bool) {
        let mut last = None;
        for it in due(&mut self.waiting, is_ready, &mut self.ends) {
            let goal = self.client.send(it.request, ACCEPTANCE, LONGEST);
            self.goals.insert(it.call, goal);
            last = Some(it.call);
        }
        self.given_up.retain(|call, since| {
            let is_due = last.is_some() || since.elapsed() >= SUCCESSION;
            if is_due {
                self.cancelled.insert(*call);
            }
            !is_due
        });
        for call in std::mem::take(&mut self.cancelled) {
            let Some(mut goal) = self.goals.remove(&call) else {
                continue;
            };
            match last {
                Some(by) if by != call => self.replaced.push(Replaced {
                    call,
                    goal,
                    by,
                    since: None,
                    is_cancelled: false,
                }),
                _ => {
                    goal.cancel(ACCEPTANCE);
                    self.goals.insert(call, goal);
                }
            }
        }
    }

    /// Takes the events of all goals.
    fn events(&mut self) -> Vec<CallProgress> {
        let mut progress = Vec::new();
        let Self {
            goals,
            replaced,
            cancelled,
            ..
        } = self;
        goals.retain(|call, goal| {
            while let Some(event) = goal.take() {
                if event == GoalEvent::Accepted {
                    for it in replaced.iter_mut().filter(|it| it.by == *call) {
                        it.since = Some(Instant::now());
                    }
                    if goal.is_cancelling() {
                        // the server did not know the goal when it was asked to cancel it
                        cancelled.insert(*call);
                    }
                }
                progress.extend(told(*call, event));
            }
            !goal.is_over()
        });
        replaced.retain_mut(|it| {
            while let Some(event) = it.goal.take() {
                let is_end = it.goal.is_over();
                if is_end {
                    progress.extend(told(it.call, event));
                }
            }
            let is_due = it.since.is_some_and(|since| since.elapsed() >= REPLACEMENT);
            let has_ended = !goals.contains_key(&it.by);
            if (is_due || has_ended) && !it.is_cancelled {
                it.is_cancelled = true;
                it.goal.cancel(ACCEPTANCE);
            }
            !it.goal.is_over()
        });
        progress
    }

    /// Gives up the goals of a server that has left.
    fn check_absence(&mut self, is_ready: bool) {
        if is_ready || self.goals.is_empty() {
            self.absent = None;
            return;
        }
        let since = *self.absent.get_or_insert_with(Instant::now);
        if since.elapsed() < ABSENCE {
            return;
        }
        self.replaced.clear();
        for (call, _) in std::mem::take(&mut self.goals) {
            let detail = "the action server has left";
            self.ends.push(ended(call, LOST, detail));
        }
    }
}

impl OperationCaller for Ros2GoalCaller {
    fn call(&mut self, call: CallNumber, request: &Datum, timeout: Duration) {
        self.waiting.push(Waiting::new(call, request, timeout));
    }

    fn cancel(&mut self, call: CallNumber) {
        let before = self.waiting.len();
        self.waiting.retain(|it| it.call != call);
        if self.waiting.len() < before {
            let detail = "cancelled before a server was found";
            self.ends.push(ended(call, RECALLED, detail));
        } else {
            self.given_up.remove(&call);
            self.cancelled.insert(call);
        }
    }

    fn give_up(&mut self, call: CallNumber) {
        if self.goals.contains_key(&call) {
            self.given_up.entry(call).or_insert_with(Instant::now);
        } else {
            self.cancel(call);
        }
    }

    fn take(&mut self) -> Vec<CallProgress> {
        let is_ready = self.client.is_ready();
        self.send(is_ready);
        let mut progress = self.events();
        self.check_absence(is_ready);
        progress.append(&mut self.ends);
        progress
    }

    fn patience(&self) -> Option<Duration> {
        let is_idle = self.waiting.is_empty()
            && self.goals.is_empty()
            && self.replaced.is_empty()
            && self.ends.is_empty();
        let check = if self.given_up.is_empty() {
            CHECK
        } else {
            SUCCESSION
        };
        (!is_idle).then_some(check)
    }
}

impl Drop for Ros2GoalCaller {
    fn drop(&mut self) {
        let replaced = self.replaced.iter_mut().map(|it| &mut it.goal);
        for goal in self.goals.values_mut().chain(replaced) {
            goal.cancel(ACCEPTANCE);
        }
    }
}

/// What an event of a goal is for its caller.
fn told(call: CallNumber, event: GoalEvent) -> Vec<CallProgress> {
    let mut progress = Vec::new();
    let result = match event {
        GoalEvent::Accepted
        | GoalEvent::Status(_)
        | GoalEvent::CancelAnswered(_)
        | GoalEvent::CancelFailed(_) => return progress,
        GoalEvent::Feedback(feedback) => return vec![CallProgress::Feedback(feedback)],
        GoalEvent::Rejected => Err(ServiceFault::new(REJECTED, "the server refuses the goal")),
        GoalEvent::Failed(CallError::Deadline { service, .. }) => {
            let detail = format!("`{service}` does not answer");
            Err(ServiceFault::new(LOST, detail))
        }
        GoalEvent::Failed(error) => Err(fault(&error)),
        GoalEvent::Finished(GoalStatus::Succeeded, result) => Ok(result),
        GoalEvent::Finished(status, result) => {
            let fault = failed(status, &result);
            progress.push(CallProgress::Failure(result));
            Err(fault)
        }
    };
    progress.push(CallProgress::Ended { call, result });
    progress
}

/// The fault of a goal that ended without success. Results of Nav2 have an error code and a text.
fn failed(status: GoalStatus, result: &Datum) -> ServiceFault {
    let error = result.get("error_code").and_then(|code| code.as_int());
    let error = error.filter(|code| *code != 0);
    let text = match result.get("error_msg").as_deref() {
        Some(Datum::Text(text)) if !text.is_empty() => text.to_string(),
        _ => String::new(),
    };
    match (status, error) {
        (GoalStatus::Canceled, _) => ServiceFault::new(PREEMPTED, "the goal was cancelled"),
        (GoalStatus::Aborted, Some(code)) => ServiceFault::new(format!("ERROR_{code}"), text),
        (GoalStatus::Aborted, None) => ServiceFault::new(ABORTED, text),
        _ => ServiceFault::new(LOST, "the server does not know the goal any more"),
    }
}

/// Provides a service.
pub(crate) struct Ros2ServiceServer {
    server: Server,
    last: CallNumber,
    open: BTreeMap<CallNumber, ReplyTo>,
}

impl Ros2ServiceServer {
    pub(crate) fn new(
        node: &Node,
        ros: &str,
        of: &InterfaceName,
        wake: &Wake,
    ) -> Result<Self, String> {
        let server = node.server(ros, of, ServiceMapping::OfPeer, WAITING);
        let server = server.map_err(|error| error.to_string())?;
        server.wake_with(Arc::clone(wake));
        Ok(Self {
            server,
            last: 0,
            open: BTreeMap::new(),
        })
    }
}

impl OperationServer for Ros2ServiceServer {
    fn take(&mut self) -> Vec<ServedRequest> {
        let mut requests = Vec::new();
        while let Some(request) = self.server.take() {
            self.last += 1;
            self.open.insert(self.last, request.reply_to);
            requests.push(ServedRequest::Call(self.last, request.request));
        }
        requests
    }

    fn tell(&mut self, _: &Datum) -> Result<(), String> {
        Ok(())
    }

    fn end(&mut self, call: CallNumber, end: ServedEnd) -> Result<(), String> {
        let Some(reply_to) = self.open.remove(&call) else {
            return Ok(());
        };
        let no_reply = |reason: String| {
            // services of ROS 2 have no errors
            Err(format!("{reason}: the client receives no response"))
        };
        match end {
            ServedEnd::Done(response) => {
                let replied = self.server.reply(&reply_to, &response);
                replied.or_else(|error| no_reply(error.to_string()))
            }
            ServedEnd::Failed(reason) => no_reply(reason),
            ServedEnd::Cancelled => no_reply("cancelled".to_owned()),
        }
    }

    fn patience(&self) -> Option<Duration> {
        None
    }
}

/// Serves goals. A new goal replaces the one before, as in the servers of Nav2.
pub(crate) struct Ros2GoalServer {
    server: ActionServer,
    /// A result without content, for goals that fail.
    empty: Datum,
    last: CallNumber,
    open: BTreeMap<CallNumber, GoalId>,
}

impl Ros2GoalServer {
    pub(crate) fn new(
        node: &Node,
        ros: &str,
        of: &InterfaceName,
        result: &Schema,
        wake: &Wake,
    ) -> Result<Self, String> {
        let server = node.action_server(ros, of, ServiceMapping::OfPeer);
        let server = server.map_err(|error| error.to_string())?;
        server.wake_with(wake);
        let empty = result.complete(Datum::Record(Vec::new()));
        Ok(Self {
            server,
            empty: empty.map_err(|error| error.to_string())?,
            last: 0,
            open: BTreeMap::new(),
        })
    }
}

impl OperationServer for Ros2GoalServer {
    fn take(&mut self) -> Vec<ServedRequest> {
        let mut requests = Vec::new();
        for request in self.server.take() {
            match request {
                GoalRequest::Goal { goal, content } => {
                    self.server.accept(goal);
                    requests.extend(self.open.keys().map(|call| ServedRequest::Cancel(*call)));
                    self.last += 1;
                    self.open.insert(self.last, goal);
                    requests.push(ServedRequest::Call(self.last, content));
                }
                GoalRequest::Cancel { goal } => {
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
            let told = self.server.tell(*goal, feedback.clone());
            told.map_err(|error| error.to_string())?;
        }
        Ok(())
    }

    fn end(&mut self, call: CallNumber, end: ServedEnd) -> Result<(), String> {
        let Some(goal) = self.open.remove(&call) else {
            return Ok(());
        };
        let empty = || self.empty.clone();
        let (status, result, reason) = match end {
            ServedEnd::Done(result) => (GoalStatus::Succeeded, result, None),
            // results of ROS 2 have no text
            ServedEnd::Failed(reason) => (GoalStatus::Aborted, empty(), Some(reason)),
            ServedEnd::Cancelled => (GoalStatus::Canceled, empty(), None),
        };
        let ended = self.server.end(goal, status, result);
        ended.map_err(|error| error.to_string())?;
        reason.map_or(Ok(()), |reason| {
            Err(format!("a goal was aborted: {reason}"))
        })
    }

    fn patience(&self) -> Option<Duration> {
        None
    }
}
