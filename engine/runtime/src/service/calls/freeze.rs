//! Freezing and thawing of the calls of a component.

use std::sync::Arc;

use asmotion_component::{CallError, OperationSlot};
use asmotion_datum::Sample;
use asmotion_port::Time;
use serde::{Deserialize, Serialize};

use super::{EndedCall, OutgoingCalls, OutstandingCall};
use crate::frozen::{
    FrozenResult, FrozenSample, SampleNames, SystemFreezeError, SystemThawError, no_data, trace_of,
    trace_text,
};
use crate::service::message::{CallAnswer, ReplyQueue};

/// All outstanding and ended calls of a component.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FrozenCalls {
    /// Outcomes not yet read by the caller, by call number.
    answers: Vec<(u64, FrozenResult)>,
    outstanding: Vec<FrozenOutstanding>,
    ended: Vec<FrozenEnd>,
    /// Calls that ended and whose outcome the last cycle has read.
    frozen: Vec<FrozenEnd>,
    last: u64,
    lost: u64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenOutstanding {
    number: u64,
    slot: (usize, usize),
    attempt: u32,
    alternative: u32,
    attempt_end: Time,
    deadline: Time,
    resting: bool,
    argument: FrozenSample,
    cause: Option<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenEnd {
    number: u64,
    slot: (usize, usize),
    cause: Option<String>,
    result: FrozenResult,
}

fn result(of: &Result<Arc<dyn Sample>, CallError>) -> Result<FrozenResult, SystemFreezeError> {
    Ok(match of {
        Ok(response) => Ok(FrozenSample::of(&**response).map_err(no_data("a reply"))?),
        Err(error) => Err(error.clone()),
    })
}

fn thawed(
    of: &FrozenResult,
    names: &SampleNames,
) -> Result<Result<Arc<dyn Sample>, CallError>, SystemThawError> {
    Ok(match of {
        Ok(response) => Ok(response.thaw(names)?),
        Err(error) => Err(error.clone()),
    })
}

impl FrozenOutstanding {
    fn of(call: &OutstandingCall) -> Result<Self, SystemFreezeError> {
        let argument = FrozenSample::of(&*call.argument);
        Ok(Self {
            number: call.number,
            slot: (call.slot.port, call.slot.operation),
            attempt: call.attempt,
            alternative: call.alternative,
            attempt_end: call.attempt_end,
            deadline: call.deadline,
            resting: call.waits_for_retry,
            argument: argument.map_err(no_data("the argument of a call"))?,
            cause: trace_text(call.cause),
        })
    }

    fn thaw(&self, names: &SampleNames) -> Result<OutstandingCall, SystemThawError> {
        Ok(OutstandingCall {
            number: self.number,
            slot: slot(self.slot),
            attempt: self.attempt,
            alternative: self.alternative,
            attempt_end: self.attempt_end,
            deadline: self.deadline,
            waits_for_retry: self.resting,
            argument: self.argument.thaw(names)?,
            cause: trace_of(&self.cause)?,
        })
    }
}

impl FrozenEnd {
    fn of(ended: &EndedCall) -> Result<Self, SystemFreezeError> {
        Ok(Self {
            number: ended.number,
            slot: (ended.slot.port, ended.slot.operation),
            cause: trace_text(ended.cause),
            result: result(&ended.result)?,
        })
    }

    fn thaw(&self, names: &SampleNames) -> Result<EndedCall, SystemThawError> {
        Ok(EndedCall {
            number: self.number,
            slot: slot(self.slot),
            cause: trace_of(&self.cause)?,
            result: thawed(&self.result, names)?,
        })
    }
}

fn slot((port, operation): (usize, usize)) -> OperationSlot {
    OperationSlot { port, operation }
}

impl OutgoingCalls {
    /// Returns the queue that receives the replies to these calls.
    pub(crate) fn reply_queue(&self) -> Arc<ReplyQueue> {
        Arc::clone(&self.reply_queue)
    }

    pub(crate) fn snapshot(&self) -> Result<FrozenCalls, SystemFreezeError> {
        let queue = self.reply_queue.queue();
        let mut answers = Vec::new();
        // rotates the queue once; nothing else accesses it while the simulation is idle
        for _ in 0..queue.len() {
            let Some(answer) = queue.pop() else { break };
            answers.push(result(&answer.result).map(|result| (answer.number, result)));
            queue.force_push(answer);
        }
        let ends = |of: &[EndedCall]| of.iter().map(FrozenEnd::of).collect::<Result<Vec<_>, _>>();
        let outstanding = self.outstanding.iter().map(FrozenOutstanding::of);
        Ok(FrozenCalls {
            answers: answers.into_iter().collect::<Result<_, _>>()?,
            outstanding: outstanding.collect::<Result<_, _>>()?,
            ended: ends(&self.ended)?,
            frozen: ends(&self.frozen)?,
            last: self.last_number,
            lost: self.lost_calls,
        })
    }

    /// Restores the calls of the same component.
    pub(crate) fn restore(
        &mut self,
        calls: &FrozenCalls,
        names: &SampleNames,
    ) -> Result<(), SystemThawError> {
        let ends = |of: &[FrozenEnd]| {
            let ends = of.iter().map(|end| end.thaw(names));
            ends.collect::<Result<Vec<_>, _>>()
        };
        let outstanding = calls.outstanding.iter().map(|call| call.thaw(names));
        self.outstanding = outstanding.collect::<Result<_, _>>()?;
        self.ended = ends(&calls.ended)?;
        self.frozen = ends(&calls.frozen)?;
        self.last_number = calls.last;
        self.lost_calls = calls.lost;
        let queue = self.reply_queue.queue();
        while queue.pop().is_some() {}
        for (number, result) in &calls.answers {
            queue.force_push(CallAnswer {
                number: *number,
                result: thawed(result, names)?,
            });
        }
        Ok(())
    }
}
