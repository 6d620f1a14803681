//! A client of an action server.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_bus::{Notifier, Overflow, QueuePolicy, Subscription};
use asmotion_datum::{Datum, DatumError};

use super::message::{self, ActionType, GoalId, StatedStatus};
use super::state::{ActionEvent, GoalOutcome, GoalPhase};
use crate::error::RosError;
use crate::node::{RosNode, RosPublisher};
use crate::subscription::TopicSubscription;

/// Messages that can wait for [`ActionClient::update`].
const QUEUE: usize = 100;

/// Sends goals to a server, and follows them. Never blocks: events arrive when [`update`](Self::update) is called.
pub struct ActionClient {
    node: Arc<str>,
    /// Distinguishes goals of this client from those of an earlier run of its node.
    begun: i64,
    number: u64,
    goal: RosPublisher,
    cancel: RosPublisher,
    status: Subscription,
    feedback: Subscription,
    result: Subscription,
    /// The subscriptions of feedback and results, as the node has them.
    answers: Vec<Arc<TopicSubscription>>,
    goals: BTreeMap<GoalId, GoalPhase>,
    /// Name of the server, and when it has sent its last status.
    server: Option<(Arc<str>, Instant)>,
    unreadable: u64,
}

/// A goal was not sent.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ActionError {
    /// No server is connected: the goal would be lost.
    #[error("no action server is connected")]
    NoServer,
    /// The datum does not follow the type of the goal.
    #[error(transparent)]
    Goal(#[from] DatumError),
}

/// Counts of an action client.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ActionClientCounts {
    /// Goals sent.
    pub sent: u64,
    /// Goals that have not ended.
    pub open: usize,
    /// Messages dropped because [`ActionClient::update`] was not called often enough.
    pub dropped: u64,
    /// Messages without the fields of actionlib.
    pub unreadable: u64,
}

impl ActionClient {
    /// Creates a client of the server with this name, such as `/move_base`. The notifier is notified of every message of the
    /// server.
    ///
    /// # Errors
    /// [`RosError::Name`], or [`RosError::Published`] if the node has a client of this server.
    pub fn new(
        node: &RosNode,
        server: &str,
        of: &ActionType,
        notifier: &Arc<Notifier>,
    ) -> Result<Self, RosError> {
        let queue = QueuePolicy::All {
            size: QUEUE,
            overflow: Overflow::DropOldest,
        };
        let subscribe = |topic: &str, of: &crate::interface::TopicType| {
            let topic = format!("{server}/{topic}");
            node.subscribe(&topic, Some(of.clone()), queue, Arc::clone(notifier))
        };
        let publish = |topic: &str, of: &crate::interface::TopicType| {
            node.publisher(&format!("{server}/{topic}"), of.clone(), QUEUE, false)
        };
        let status = subscribe("status", &of.status)?;
        let feedback = subscribe("feedback", &of.feedback)?;
        let result = subscribe("result", &of.result)?;
        let mut answers = Vec::new();
        for topic in ["feedback", "result"] {
            answers.extend(node.topic_subscription(&format!("{server}/{topic}"))?);
        }
        Ok(Self {
            node: node.name().shared(),
            begun: crate::subscription::now(),
            number: 0,
            goal: publish("goal", &of.goal)?,
            cancel: publish("cancel", &of.cancel)?,
            status,
            feedback,
            result,
            answers,
            goals: BTreeMap::new(),
            server: None,
            unreadable: 0,
        })
    }

    /// Returns `true` if goals reach a server, and its answers this client: one has sent a status and is subscribed to goals and
    /// cancellations, and feedback and results are connected. The result of a goal that ends at once would else be lost.
    pub fn is_connected(&self) -> bool {
        let Some((server, _)) = &self.server else {
            return false;
        };
        if self.answers.iter().any(|it| it.counts().publishers == 0) {
            return false;
        }
        [&self.goal, &self.cancel].iter().all(|publisher| {
            let subscribers = publisher.counts().subscribers;
            subscribers.iter().any(|it| it.node == *server)
        })
    }

    /// Time since the last status of the server, which sends several a second; `None` before the first one.
    pub fn silence(&self) -> Option<Duration> {
        self.server.as_ref().map(|(_, at)| at.elapsed())
    }

    /// Sends a goal, of the type `NAMEGoal`. `stamp` is the time in nanoseconds since 1970, on the clock of the ROS system;
    /// with 0, the server takes the time at which the goal arrives. Servers recall goals that are older than the one they have.
    ///
    /// # Errors
    /// [`ActionError`].
    pub fn send(&mut self, goal: &Datum, stamp: i64) -> Result<GoalId, ActionError> {
        if !self.is_connected() {
            return Err(ActionError::NoServer);
        }
        let number = self.number + 1;
        let id = GoalId(format!("{}-{number}-{}", self.node, self.begun).into());
        self.goal.publish(&message::action_goal(&id, goal, stamp))?;
        self.number = number;
        self.goals.insert(id.clone(), GoalPhase::WaitingForGoalAck);
        Ok(id)
    }

    /// Asks the server to cancel a goal. Returns whether the goal is one of this client that has not ended.
    pub fn cancel(&mut self, goal: &GoalId) -> bool {
        let Some(phase) = self.goals.get_mut(goal) else {
            return false;
        };
        match phase {
            GoalPhase::WaitingForGoalAck | GoalPhase::Pending | GoalPhase::Active => {
                *phase = GoalPhase::WaitingForCancelAck;
            }
            GoalPhase::WaitingForCancelAck
            | GoalPhase::Recalling
            | GoalPhase::Preempting
            | GoalPhase::WaitingForResult => {}
        }
        // with the time 0, it cancels this goal alone; it has the type of the topic
        let _ = self.cancel.publish(&message::goal_id(goal, 0));
        true
    }

    /// The phase of a goal that has not ended.
    pub fn phase(&self, goal: &GoalId) -> Option<GoalPhase> {
        self.goals.get(goal).copied()
    }

    /// Counts of this client.
    pub fn counts(&self) -> ActionClientCounts {
        let queues = [&self.status, &self.feedback, &self.result];
        ActionClientCounts {
            sent: self.number,
            open: self.goals.len(),
            dropped: queues.iter().map(|it| it.dropped()).sum(),
            unreadable: self.unreadable,
        }
    }

    /// Reads what the server has sent since the last call, and returns the events of the goals of this client. A goal ends
    /// with its result; its feedback comes before that.
    pub fn update(&mut self) -> Vec<ActionEvent> {
        let mut events = Vec::new();
        while let Some(envelope) = self.status.try_next() {
            let datum = envelope.payload.to_datum().unwrap_or_default();
            self.server = Some((envelope.source, Instant::now()));
            match message::statuses(&datum) {
                Some(statuses) => self.take_statuses(&statuses, &mut events),
                None => self.unreadable += 1,
            }
        }
        while let Some(envelope) = self.feedback.try_next() {
            let datum = envelope.payload.to_datum().unwrap_or_default();
            match part(&datum, "feedback") {
                Some((status, feedback)) => self.take_feedback(&status, feedback, &mut events),
                None => self.unreadable += 1,
            }
        }
        while let Some(envelope) = self.result.try_next() {
            let datum = envelope.payload.to_datum().unwrap_or_default();
            match part(&datum, "result") {
                Some((status, result)) => self.take_result(status, result, &mut events),
                None => self.unreadable += 1,
            }
        }
        events
    }

    fn take_statuses(&mut self, statuses: &[StatedStatus], events: &mut Vec<ActionEvent>) {
        let mut lost = Vec::new();
        for (goal, phase) in &mut self.goals {
            match statuses.iter().find(|it| it.id == *goal) {
                Some(status) => {
                    let next = phase.after(status.status);
                    if std::mem::replace(phase, next) != next {
                        let goal = goal.clone();
                        events.push(ActionEvent::Phase { goal, phase: next });
                    }
                }
                // a cancelled goal that the server has not seen yet is not lost
                None if phase.is_known() && *phase != GoalPhase::WaitingForCancelAck => {
                    lost.push(goal.clone());
                }
                None => {}
            }
        }
        for goal in lost {
            self.goals.remove(&goal);
            events.push(ActionEvent::Done {
                goal,
                outcome: GoalOutcome::Lost,
                text: "the server no longer knows the goal".to_owned(),
                result: None,
            });
        }
    }

    fn take_feedback(
        &mut self,
        status: &StatedStatus,
        feedback: Datum,
        events: &mut Vec<ActionEvent>,
    ) {
        if self.goals.contains_key(&status.id) {
            let goal = status.id.clone();
            events.push(ActionEvent::Feedback { goal, feedback });
        }
    }

    fn take_result(&mut self, status: StatedStatus, result: Datum, events: &mut Vec<ActionEvent>) {
        let Some(outcome) = GoalOutcome::of_status(status.status) else {
            self.unreadable += 1;
            return;
        };
        // results of other clients' goals arrive as well
        if self.goals.remove(&status.id).is_some() {
            events.push(ActionEvent::Done {
                goal: status.id,
                outcome,
                text: status.text,
                result: Some(result),
            });
        }
    }
}

/// The status and one more field of a message.
fn part(of: &Datum, field: &str) -> Option<(StatedStatus, Datum)> {
    let status = message::status(&*of.get("status")?)?;
    Some((status, of.get(field)?.into_owned()))
}
