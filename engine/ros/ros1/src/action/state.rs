//! The state of a goal, as its client knows it.

use asmotion_datum::Datum;

use super::message::GoalId;
use super::status::{
    ABORTED, ACTIVE, LOST, PENDING, PREEMPTED, PREEMPTING, RECALLED, RECALLING, REJECTED, SUCCEEDED,
};

/// Phase of a goal at its client. The names are those of actionlib.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GoalPhase {
    /// The goal was sent, and no status has it yet.
    WaitingForGoalAck,
    /// The server has it, and has not begun.
    Pending,
    /// The server works on it.
    Active,
    /// The client has cancelled it, and no status says so yet.
    WaitingForCancelAck,
    /// The server cancels it before it has begun.
    Recalling,
    /// The server cancels it after it has begun.
    Preempting,
    /// It has ended; its result is on the way.
    WaitingForResult,
}

/// End of a goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GoalOutcome {
    /// Cancelled, or replaced by another goal, after it had begun.
    Preempted,
    /// Reached.
    Succeeded,
    /// Ended by the server with an error.
    Aborted,
    /// Refused by the server.
    Rejected,
    /// Cancelled before it had begun.
    Recalled,
    /// The server no longer knows it.
    Lost,
}

/// An event of a goal.
#[derive(Debug, Clone, PartialEq)]
pub enum ActionEvent {
    /// The goal is in another phase.
    Phase {
        /// The goal.
        goal: GoalId,
        /// Its phase.
        phase: GoalPhase,
    },
    /// The server has told how far it is.
    Feedback {
        /// The goal.
        goal: GoalId,
        /// Data of the type `NAMEFeedback`.
        feedback: Datum,
    },
    /// The goal has ended.
    Done {
        /// The goal.
        goal: GoalId,
        /// How.
        outcome: GoalOutcome,
        /// Explanation of the server; may be empty.
        text: String,
        /// Data of the type `NAMEResult`; absent if the goal was lost.
        result: Option<Datum>,
    },
}

impl GoalOutcome {
    /// The outcome that a status means; `None` for a goal that has not ended.
    pub(super) fn of_status(status: i64) -> Option<Self> {
        match status {
            PREEMPTED => Some(Self::Preempted),
            SUCCEEDED => Some(Self::Succeeded),
            ABORTED => Some(Self::Aborted),
            REJECTED => Some(Self::Rejected),
            RECALLED => Some(Self::Recalled),
            LOST => Some(Self::Lost),
            _ => None,
        }
    }
}

impl GoalPhase {
    /// The phase after a status. One that does not follow changes nothing: statuses are periodic, and an old one can arrive
    /// after a cancellation.
    pub(super) fn after(self, status: i64) -> Self {
        if self == Self::WaitingForResult || GoalOutcome::of_status(status).is_some() {
            return Self::WaitingForResult;
        }
        let is_begun = matches!(self, Self::Active | Self::Preempting);
        let is_cancelled = matches!(
            self,
            Self::WaitingForCancelAck | Self::Recalling | Self::Preempting
        );
        match status {
            PENDING if !is_begun && !is_cancelled => Self::Pending,
            ACTIVE if !is_cancelled => Self::Active,
            PREEMPTING => Self::Preempting,
            RECALLING if !is_begun => Self::Recalling,
            _ => self,
        }
    }

    /// Whether the server must know a goal in this phase.
    pub(super) fn is_known(self) -> bool {
        !matches!(self, Self::WaitingForGoalAck | Self::WaitingForResult)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_follow_the_statuses() {
        use GoalPhase::*;
        let run = |from: GoalPhase, statuses: &[i64]| {
            statuses
                .iter()
                .fold(from, |phase, status| phase.after(*status))
        };
        assert_eq!(run(WaitingForGoalAck, &[PENDING]), Pending);
        assert_eq!(run(WaitingForGoalAck, &[PENDING, ACTIVE]), Active);
        // an old status, and an unknown one
        assert_eq!(run(Active, &[PENDING, 77]), Active);
        assert_eq!(
            run(WaitingForCancelAck, &[PENDING, ACTIVE]),
            WaitingForCancelAck
        );
        assert_eq!(run(WaitingForCancelAck, &[RECALLING, PENDING]), Recalling);
        assert_eq!(
            run(WaitingForCancelAck, &[PREEMPTING, ACTIVE, RECALLING]),
            Preempting
        );
        // a server may begin to work on a goal that it recalls
        assert_eq!(run(Recalling, &[PREEMPTING]), Preempting);
        for end in [PREEMPTED, SUCCEEDED, ABORTED, REJECTED, RECALLED, LOST] {
            for phase in [WaitingForGoalAck, Pending, Active, Recalling, Preempting] {
                assert_eq!(run(phase, &[end, ACTIVE]), WaitingForResult);
            }
        }
    }
}
