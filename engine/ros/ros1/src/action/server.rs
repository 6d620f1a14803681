//! An action server.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use asmotion_bus::{Notifier, Overflow, QueuePolicy, Subscription};
use asmotion_datum::{Datum, DatumError};

use super::message::{self, ActionType, GoalId};
use super::state::GoalOutcome;
use super::status::{
    ABORTED, ACTIVE, PENDING, PREEMPTED, PREEMPTING, RECALLED, RECALLING, REJECTED, SUCCEEDED,
};
use crate::error::RosError;
use crate::interface::TopicType;
use crate::node::{RosNode, RosPublisher};
use crate::time::nanoseconds;

/// Messages that can wait for [`ActionServer::update`].
const QUEUE: usize = 100;
/// Goals that have not ended; others are rejected.
const MAX_GOALS: usize = 100;
/// Period of the statuses, in nanoseconds: 5 Hz, as actionlib does.
const STATUS_PERIOD: i64 = 200_000_000;
/// Time for which the status of a goal is published after its end, in nanoseconds.
const MEMORY: i64 = 5_000_000_000;

/// Receives goals and tells what becomes of them. Never blocks: requests arrive when [`update`](Self::update) is called.
pub struct ActionServer {
    name: Arc<str>,
    /// Number of goals without an identity so far.
    number: u64,
    goal: Subscription,
    cancel: Subscription,
    status: RosPublisher,
    feedback: RosPublisher,
    result: RosPublisher,
    goals: BTreeMap<GoalId, ServedGoal>,
    /// Goals that were cancelled before they arrived.
    cancelled: VecDeque<GoalId>,
    /// Goals of this time or before are cancelled.
    last_cancel: i64,
    now: i64,
    /// When the last statuses were told.
    told: Option<i64>,
    unreadable: u64,
}

struct ServedGoal {
    stamp: i64,
    status: i64,
    text: String,
    ended: Option<i64>,
}

/// A request of a client.
#[derive(Debug, Clone, PartialEq)]
pub enum ActionRequest {
    /// A goal has arrived: accept or reject it.
    Goal {
        /// The goal.
        goal: GoalId,
        /// Data of the type `NAMEGoal`.
        content: Datum,
    },
    /// A goal should be ended: with [`GoalOutcome::Recalled`] or [`GoalOutcome::Preempted`], unless it was reached.
    Cancel {
        /// The goal.
        goal: GoalId,
    },
}

/// A goal cannot be changed like this.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ServedGoalError {
    /// The server has no such goal that has not ended.
    #[error("there is no goal `{0}` that has not ended")]
    Unknown(GoalId),
    /// A goal ends otherwise in its state.
    #[error(
        "the goal `{goal}` cannot be {outcome:?}: accepted goals are, and only they, succeeded, aborted or preempted"
    )]
    State {
        /// The goal.
        goal: GoalId,
        /// The end that it cannot have.
        outcome: GoalOutcome,
    },
    /// The datum does not follow the type.
    #[error(transparent)]
    Content(#[from] DatumError),
}

impl ActionServer {
    /// Creates a server with this name, such as `/move_base`. The notifier is notified of every goal and cancellation.
    ///
    /// # Errors
    /// [`RosError::Name`], or [`RosError::Published`] if the node has a server of this name.
    pub fn new(
        node: &RosNode,
        server: &str,
        of: &ActionType,
        notifier: &Arc<Notifier>,
    ) -> Result<Self, RosError> {
        let queue = QueuePolicy::All {
            size: QUEUE,
            overflow: Overflow::DropNewest,
        };
        let subscribe = |topic: &str, of: &TopicType| {
            let topic = format!("{server}/{topic}");
            node.subscribe(&topic, Some(of.clone()), queue, Arc::clone(notifier))
        };
        let publish = |topic: &str, of: &TopicType, is_latched| {
            let topic = format!("{server}/{topic}");
            node.publisher(&topic, of.clone(), QUEUE, is_latched)
        };
        Ok(Self {
            name: node.name().shared(),
            number: 0,
            status: publish("status", &of.status, true)?,
            feedback: publish("feedback", &of.feedback, false)?,
            result: publish("result", &of.result, false)?,
            goal: subscribe("goal", &of.goal)?,
            cancel: subscribe("cancel", &of.cancel)?,
            goals: BTreeMap::new(),
            cancelled: VecDeque::new(),
            last_cancel: 0,
            now: 0,
            told: None,
            unreadable: 0,
        })
    }

    /// Reads what clients have sent since the last call, and tells the statuses, several times a second. `now` is the time in
    /// nanoseconds since 1970, on the clock of the ROS system.
    pub fn update(&mut self, now: i64) -> Vec<ActionRequest> {
        self.now = now;
        let mut requests = Vec::new();
        while let Some(envelope) = self.goal.try_next() {
            let datum = envelope.payload.to_datum().unwrap_or_default();
            if self.take_goal(&datum, &mut requests).is_none() {
                self.unreadable += 1;
            }
        }
        while let Some(envelope) = self.cancel.try_next() {
            let datum = envelope.payload.to_datum().unwrap_or_default();
            if self.take_cancel(&datum, &mut requests).is_none() {
                self.unreadable += 1;
            }
        }
        self.goals.retain(|_, goal| {
            goal.ended
                .is_none_or(|ended| (0..MEMORY).contains(&(now - ended)))
        });
        // also after the time has gone back
        let is_recent = |told: i64| (0..STATUS_PERIOD).contains(&(now - told));
        if !requests.is_empty() || !self.told.is_some_and(is_recent) {
            self.tell_statuses();
        }
        requests
    }

    /// Number of messages without the fields of actionlib.
    pub fn unreadable(&self) -> u64 {
        self.unreadable
    }

    /// Accepts a goal.
    ///
    /// # Errors
    /// [`ServedGoalError::Unknown`].
    pub fn accept(&mut self, goal: &GoalId) -> Result<(), ServedGoalError> {
        let open = self.open(goal)?;
        match open.status {
            PENDING => open.status = ACTIVE,
            RECALLING => open.status = PREEMPTING,
            _ => {}
        }
        self.tell_statuses();
        Ok(())
    }

    /// Tells how far an accepted goal is, in data of the type `NAMEFeedback`.
    ///
    /// # Errors
    /// [`ServedGoalError::Unknown`], [`ServedGoalError::Content`].
    pub fn tell(&mut self, goal: &GoalId, feedback: Datum) -> Result<(), ServedGoalError> {
        let now = self.now;
        let open = self.open(goal)?;
        let status = message::goal_status(goal, open.stamp, open.status, &open.text);
        let message = message::told(status, "feedback", feedback, now);
        Ok(self.feedback.publish(&message)?)
    }

    /// Ends a goal, with data of the type `NAMEResult` and an explanation. Goals that were accepted succeed, or are aborted or
    /// preempted; others are rejected or recalled.
    ///
    /// # Errors
    /// [`ServedGoalError`].
    pub fn end(
        &mut self,
        goal: &GoalId,
        outcome: GoalOutcome,
        result: Datum,
        text: &str,
    ) -> Result<(), ServedGoalError> {
        let now = self.now;
        let open = self.open(goal)?;
        let is_accepted = [ACTIVE, PREEMPTING].contains(&open.status);
        let status = match (outcome, is_accepted) {
            (GoalOutcome::Succeeded, true) => SUCCEEDED,
            (GoalOutcome::Aborted, true) => ABORTED,
            (GoalOutcome::Preempted, true) => PREEMPTED,
            (GoalOutcome::Rejected, false) => REJECTED,
            (GoalOutcome::Recalled, false) => RECALLED,
            (
                GoalOutcome::Succeeded
                | GoalOutcome::Aborted
                | GoalOutcome::Preempted
                | GoalOutcome::Rejected
                | GoalOutcome::Recalled
                | GoalOutcome::Lost,
                _,
            ) => {
                let goal = goal.clone();
                return Err(ServedGoalError::State { goal, outcome });
            }
        };
        let told = message::goal_status(goal, open.stamp, status, text);
        let message = message::told(told, "result", result, now);
        self.result.publish(&message)?;
        let open = self.open(goal)?;
        open.status = status;
        open.text = text.to_owned();
        open.ended = Some(now);
        self.tell_statuses();
        Ok(())
    }

    fn open(&mut self, goal: &GoalId) -> Result<&mut ServedGoal, ServedGoalError> {
        let open = self.goals.get_mut(goal).filter(|it| it.ended.is_none());
        open.ok_or_else(|| ServedGoalError::Unknown(goal.clone()))
    }

    fn tell_statuses(&mut self) {
        let statuses = self.goals.iter();
        let statuses = statuses
            .map(|(id, goal)| message::goal_status(id, goal.stamp, goal.status, &goal.text));
        let message = message::status_array(statuses.collect(), self.now);
        // it has the type of the topic
        let _ = self.status.publish(&message);
        self.told = Some(self.now);
    }

    /// Takes a goal. One that was sent twice is the same goal.
    fn take_goal(&mut self, datum: &Datum, requests: &mut Vec<ActionRequest>) -> Option<()> {
        let text = datum.get("goal_id.id")?.as_text()?.to_owned();
        let stamp = nanoseconds(&*datum.get("goal_id.stamp")?)?;
        let content = datum.get("goal")?.into_owned();
        let id = if text.is_empty() {
            self.number += 1;
            GoalId(format!("{}-{}-{}", self.name, self.number, self.now).into())
        } else {
            GoalId(text.into())
        };
        if self.goals.contains_key(&id) {
            return Some(());
        }
        let open = self.goals.values().filter(|it| it.ended.is_none()).count();
        let was_cancelled = self.cancelled.contains(&id) || stamp != 0 && stamp <= self.last_cancel;
        self.cancelled.retain(|it| *it != id);
        let goal = ServedGoal {
            stamp: if stamp == 0 { self.now } else { stamp },
            status: if was_cancelled { RECALLING } else { PENDING },
            text: String::new(),
            ended: None,
        };
        self.goals.insert(id.clone(), goal);
        if open >= MAX_GOALS {
            let text = format!("the server has {MAX_GOALS} goals");
            // with the fields' defaults; a result without defaults leaves the goal to its client's deadline
            let _ = self.end(&id, GoalOutcome::Rejected, Datum::Record(Vec::new()), &text);
            return Some(());
        }
        let goal = id.clone();
        requests.push(ActionRequest::Goal { goal, content });
        if was_cancelled {
            requests.push(ActionRequest::Cancel { goal: id });
        }
        Some(())
    }

    /// Takes a cancellation: of one goal, of all goals up to a time, or of all.
    fn take_cancel(&mut self, datum: &Datum, requests: &mut Vec<ActionRequest>) -> Option<()> {
        let id = GoalId(datum.get("id")?.as_text()?.into());
        let stamp = nanoseconds(&*datum.get("stamp")?)?;
        let is_all = stamp == 0 && id.0.is_empty();
        if !id.0.is_empty() && !self.goals.contains_key(&id) && !self.cancelled.contains(&id) {
            if self.cancelled.len() >= QUEUE {
                self.cancelled.pop_front();
            }
            self.cancelled.push_back(id.clone());
        }
        self.last_cancel = self.last_cancel.max(stamp);
        for (goal, served) in &mut self.goals {
            let is_meant = is_all || *goal == id || stamp != 0 && served.stamp <= stamp;
            if !is_meant {
                continue;
            }
            served.status = match served.status {
                PENDING => RECALLING,
                ACTIVE => PREEMPTING,
                _ => continue,
            };
            let goal = goal.clone();
            requests.push(ActionRequest::Cancel { goal });
        }
        Some(())
    }
}
