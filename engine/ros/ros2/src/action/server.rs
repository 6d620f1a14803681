//! Servers of actions: goals to be accepted, feedback, cancel requests and results.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use asmotion_datum::{Datum, Schema};
use asmotion_ros_interface::InterfaceName;

use super::feedback::id;
use super::kinds::{self, ActionKinds};
use super::{GoalId, GoalStatus, uuid};
use crate::error::{EndpointError, SendError};
use crate::mapping::ServiceMapping;
use crate::names;
use crate::node::Node;
use crate::notice::Waker;
use crate::participant::Inner;
use crate::publisher::Publisher;
use crate::qos::Qos;
use crate::service::{ReplyTo, Request, Server};

/// Requests of each service that wait to be taken.
const WAITING: usize = 64;
/// Time for which the result of a goal is kept for clients that ask late, as in `rcl_action`.
const KEPT: Duration = Duration::from_secs(15 * 60);
/// Most results that are kept.
const MOST_KEPT: usize = 64;

/// Codes of `action_msgs/srv/CancelGoal`.
const NO_ERROR: i64 = 0;
const REJECTED: i64 = 1;
const UNKNOWN_GOAL: i64 = 2;
const GOAL_TERMINATED: i64 = 3;

/// What a client of an action asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum GoalRequest {
    /// A goal, which has to be [accepted](ActionServer::accept) or [rejected](ActionServer::reject).
    Goal {
        /// Its id.
        goal: GoalId,
        /// Its content.
        content: Datum,
    },
    /// A goal that was accepted is to be cancelled. It goes on until it is [ended](ActionServer::end).
    Cancel {
        /// Its id.
        goal: GoalId,
    },
}

/// Offers an action. Nothing waits; [`take`](Self::take) has to be called in every cycle, because it also answers clients that ask
/// for results.
pub struct ActionServer {
    send_goal: Server,
    cancel_goal: Server,
    get_result: Server,
    feedback: Publisher,
    status: Publisher,
    /// A result without content, for goals that are not known.
    empty: Datum,
    /// Goals that were neither accepted nor rejected.
    asked: BTreeMap<GoalId, ReplyTo>,
    goals: BTreeMap<GoalId, ServedGoal>,
}

/// A goal that was accepted.
struct ServedGoal {
    status: GoalStatus,
    /// Nanoseconds since 1970 at which it was accepted.
    stamp: i64,
    /// Clients that wait for the result.
    waiting: Vec<ReplyTo>,
    /// The result, with the time at which the goal ended.
    result: Option<(Datum, Instant)>,
}

impl Node {
    /// Offers an action. Names as for [`publisher`](Self::publisher).
    ///
    /// # Errors
    /// The name is not valid, the type is not an action that is defined, the catalogue lacks `action_msgs`, or DDS refuses.
    pub fn action_server(
        &self,
        action: &str,
        of: &InterfaceName,
        mapping: ServiceMapping,
    ) -> Result<ActionServer, EndpointError> {
        let action = self.inner().absolute(action)?;
        ActionServer::new(self.inner(), &action, of, mapping)
    }
}

impl ActionServer {
    fn new(
        inner: &Arc<Inner>,
        action: &str,
        of: &InterfaceName,
        mapping: ServiceMapping,
    ) -> Result<Self, EndpointError> {
        let kinds = ActionKinds::of(inner, of)?;
        let server = |suffix: &str, kind| {
            let service = format!("{action}/_action/{suffix}");
            Server::new(inner, &service, kind, mapping, WAITING)
        };
        let publisher = |suffix: &str, kind: &str, schema: &Schema, qos, hash| {
            let topic = names::topic(&format!("{action}/_action/{suffix}"));
            Ok::<_, EndpointError>(Publisher {
                inner: Arc::clone(inner),
                outbox: inner.writer(&topic, kind, qos, hash)?,
                schema: schema.clone(),
            })
        };
        let (feedback, status) = (&kinds.feedback, &kinds.status);
        let empty = kinds.result.complete(Datum::Record(Vec::new()));
        Ok(Self {
            feedback: publisher(
                "feedback",
                &feedback.type_name,
                &feedback.schema,
                kinds::feedback_qos(),
                None,
            )?,
            status: publisher(
                "status",
                &status.type_name,
                &status.schema,
                Qos::latched(),
                kinds.status_hash,
            )?,
            send_goal: server("send_goal", kinds.send_goal)?,
            cancel_goal: server("cancel_goal", kinds.cancel_goal)?,
            get_result: server("get_result", kinds.get_result)?,
            empty: empty.map_err(|reason| EndpointError::Uncarried {
                of: of.clone(),
                reason,
            })?,
            asked: BTreeMap::new(),
            goals: BTreeMap::new(),
        })
    }

    /// Sets what is called after a request has arrived.
    pub fn wake_with(&self, waker: &Waker) {
        for server in [&self.send_goal, &self.cancel_goal, &self.get_result] {
            server.wake_with(Arc::clone(waker));
        }
    }

    /// Takes the goals and cancel requests that have arrived, and answers requests for results.
    pub fn take(&mut self) -> Vec<GoalRequest> {
        let mut requests = Vec::new();
        while let Some(Request { request, reply_to }) = self.send_goal.take() {
            let content = request.get("goal").map(std::borrow::Cow::into_owned);
            let (Some(goal), Some(content)) = (id(&request, "goal_id.uuid"), content) else {
                continue;
            };
            if self.goals.contains_key(&goal) || self.asked.contains_key(&goal) {
                // an id is used once
                self.answer_goal(&reply_to, false);
                continue;
            }
            self.asked.insert(goal, reply_to);
            requests.push(GoalRequest::Goal { goal, content });
        }
        while let Some(Request { request, reply_to }) = self.cancel_goal.take() {
            let cancelled = self.cancel(&request, &reply_to);
            requests.extend(
                cancelled
                    .into_iter()
                    .map(|goal| GoalRequest::Cancel { goal }),
            );
        }
        while let Some(Request { request, reply_to }) = self.get_result.take() {
            self.ask_result(&request, reply_to);
        }
        self.forget_results();
        requests
    }

    /// Accepts a goal, which is executed from now on. Does nothing if it was answered before.
    pub fn accept(&mut self, goal: GoalId) {
        let Some(reply_to) = self.asked.remove(&goal) else {
            return;
        };
        let accepted = ServedGoal {
            status: GoalStatus::Executing,
            stamp: now(),
            waiting: Vec::new(),
            result: None,
        };
        self.goals.insert(goal, accepted);
        self.answer_goal(&reply_to, true);
        self.publish_status();
    }

    /// Rejects a goal. Does nothing if it was answered before.
    pub fn reject(&mut self, goal: GoalId) {
        if let Some(reply_to) = self.asked.remove(&goal) {
            self.answer_goal(&reply_to, false);
        }
    }

    /// Tells the clients how far a goal is.
    ///
    /// # Errors
    /// The feedback does not fit the type, or DDS refuses it.
    pub fn tell(&self, goal: GoalId, feedback: Datum) -> Result<(), SendError> {
        let message = Datum::record([("goal_id", uuid(goal)), ("feedback", feedback)]);
        self.feedback.send(&message)
    }

    /// Ends a goal, [`Succeeded`](GoalStatus::Succeeded), [`Canceled`](GoalStatus::Canceled) if a client has asked for it, or
    /// else [`Aborted`](GoalStatus::Aborted). Does nothing if it has ended.
    ///
    /// # Errors
    /// The result does not fit the type. The goal has ended nevertheless, without a result.
    pub fn end(
        &mut self,
        goal: GoalId,
        status: GoalStatus,
        result: Datum,
    ) -> Result<(), SendError> {
        let Some(served) = self.goals.get_mut(&goal) else {
            return Ok(());
        };
        if served.status.is_end() {
            return Ok(());
        }
        let is_asked_for = served.status == GoalStatus::Canceling;
        served.status = match status {
            GoalStatus::Succeeded => status,
            GoalStatus::Canceled if is_asked_for => status,
            GoalStatus::Canceled
            | GoalStatus::Aborted
            | GoalStatus::Unknown
            | GoalStatus::Accepted
            | GoalStatus::Executing
            | GoalStatus::Canceling => GoalStatus::Aborted,
        };
        let status = served.status;
        let waiting = std::mem::take(&mut served.waiting);
        served.result = Some((result.clone(), Instant::now()));
        let mut answered = Ok(());
        for reply_to in waiting {
            answered = answered.and(self.answer_result(&reply_to, status, result.clone()));
        }
        self.publish_status();
        answered
    }

    fn answer_goal(&self, to: &ReplyTo, accepted: bool) {
        let response = Datum::record([("accepted", Datum::Bool(accepted)), ("stamp", time(now()))]);
        // the response is ours, and fits
        let _ = self.send_goal.reply(to, &response);
    }

    fn answer_result(
        &self,
        to: &ReplyTo,
        status: GoalStatus,
        result: Datum,
    ) -> Result<(), SendError> {
        let status = ("status", Datum::Int(status.number()));
        let response = Datum::record([status.clone(), ("result", result)]);
        self.get_result.reply(to, &response).inspect_err(|_| {
            let response = Datum::record([status, ("result", self.empty.clone())]);
            // this one is ours, and fits
            let _ = self.get_result.reply(to, &response);
        })
    }

    fn ask_result(&mut self, request: &Datum, reply_to: ReplyTo) {
        let Some(goal) = id(request, "goal_id.uuid") else {
            return;
        };
        let (status, result) = match self.goals.get_mut(&goal) {
            Some(served) => match &served.result {
                Some((result, _)) => (served.status, result.clone()),
                None => return served.waiting.push(reply_to),
            },
            None => (GoalStatus::Unknown, self.empty.clone()),
        };
        // an error of the result was reported when the goal ended
        let _ = self.answer_result(&reply_to, status, result);
    }

    /// Answers a cancel request. Returns the goals that it is about.
    fn cancel(&mut self, request: &Datum, reply_to: &ReplyTo) -> Vec<GoalId> {
        let none = GoalId([0; 16]);
        let named = id(request, "goal_info.goal_id.uuid").unwrap_or(none);
        let until = nanoseconds(request, "goal_info.stamp");
        // without an id, all goals until the time; without either, all; with an id, this one, and those until the time
        let is_meant = |goal: GoalId, served: &ServedGoal| {
            let is_before = until != 0 && served.stamp <= until;
            goal == named || is_before || named == none && until == 0
        };
        let mut cancelled = Vec::new();
        for (goal, served) in &mut self.goals {
            if is_meant(*goal, served) && !served.status.is_end() {
                served.status = GoalStatus::Canceling;
                cancelled.push((*goal, served.stamp));
            }
        }
        let code = if !cancelled.is_empty() {
            NO_ERROR
        } else if named == none {
            REJECTED
        } else if self.goals.contains_key(&named) {
            GOAL_TERMINATED
        } else {
            UNKNOWN_GOAL
        };
        let infos = cancelled.iter().map(|(goal, stamp)| info(*goal, *stamp));
        let response = Datum::record([
            ("return_code", Datum::Int(code)),
            ("goals_canceling", Datum::List(infos.collect())),
        ]);
        // the response is ours, and fits
        let _ = self.cancel_goal.reply(reply_to, &response);
        if !cancelled.is_empty() {
            self.publish_status();
        }
        cancelled.into_iter().map(|(goal, _)| goal).collect()
    }

    fn publish_status(&self) {
        let statuses = self.goals.iter().map(|(goal, served)| {
            let number = Datum::Int(served.status.number());
            Datum::record([("goal_info", info(*goal, served.stamp)), ("status", number)])
        });
        let message = Datum::record([("status_list", Datum::List(statuses.collect()))]);
        // the message is ours, and fits
        let _ = self.status.send(&message);
    }

    /// Forgets results that are old, or too many.
    fn forget_results(&mut self) {
        self.goals.retain(|_, served| {
            let ended = served.result.as_ref();
            ended.is_none_or(|(_, ended)| ended.elapsed() < KEPT)
        });
        let ended = self.goals.iter().filter_map(|(goal, served)| {
            let (_, ended) = served.result.as_ref()?;
            Some((*ended, *goal))
        });
        let mut ended: Vec<_> = ended.collect();
        ended.sort_unstable();
        let too_many = ended.len().saturating_sub(MOST_KEPT);
        for (_, goal) in ended.into_iter().take(too_many) {
            self.goals.remove(&goal);
        }
    }
}

/// The time of the system, in nanoseconds since 1970.
fn now() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let nanoseconds = since.map_or(0, |it| it.as_nanos());
    i64::try_from(nanoseconds).unwrap_or(i64::MAX)
}

const SECOND: i64 = 1_000_000_000;

/// A `builtin_interfaces/msg/Time`.
fn time(nanoseconds: i64) -> Datum {
    Datum::record([
        ("sec", Datum::Int(nanoseconds.div_euclid(SECOND))),
        ("nanosec", Datum::Int(nanoseconds.rem_euclid(SECOND))),
    ])
}

fn nanoseconds(datum: &Datum, path: &str) -> i64 {
    let field = |name: &str| {
        let found = datum.get(&format!("{path}.{name}"));
        found.and_then(|it| it.as_int()).unwrap_or_default()
    };
    field("sec")
        .saturating_mul(SECOND)
        .saturating_add(field("nanosec"))
}

/// An `action_msgs/msg/GoalInfo`.
fn info(goal: GoalId, stamp: i64) -> Datum {
    Datum::record([("goal_id", uuid(goal)), ("stamp", time(stamp))])
}
