//! An operation that writes or reads a port.

use std::collections::VecDeque;

use asmotion_component::{
    Cycle, Dynamic, Flow, In, Interface, Provided, RequestId, ServiceFault, Time,
};
use asmotion_datum::{Datum, Schema};
use serde::{Deserialize, Serialize};

use super::{Mapped, ReplyMode};
use crate::conversion::Conversion;

/// Explanation for a caller whose command was replaced by another.
pub(super) const TAKEN_BACK: &str = "another command came before the motion had ended";

/// Capacity of the buffer for [`ReplyMode::All`]; when full, the oldest sample is dropped.
const MAX_KEPT: usize = 1024;

/// An operation, and the requests that wait for its reply.
pub(super) struct ProxiedOperation {
    pub port: String,
    pub conversion: Conversion,
    /// Type of the argument.
    pub request: Schema,
    handle: Provided<Dynamic>,
    mode: ReplyMode,
    /// Samples since the last call, for [`ReplyMode::All`].
    pub samples: VecDeque<Datum>,
    pub waiting: Vec<Waiting>,
}

/// A request whose reply needs more than the sample being written.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Waiting {
    request: RequestId,
    /// Time by which the sample had left: that of the first cycle after the one that wrote it. `None` until then.
    left: Option<Time>,
}

impl ProxiedOperation {
    pub(super) fn declare(mapped: &Mapped, interface: &mut Interface) -> Self {
        let doc = match mapped.mode {
            ReplyMode::OneWay => "writes a port of the target",
            ReplyMode::Taken => {
                "writes a port of the target; replies once the sample has been read"
            }
            ReplyMode::Done => "writes a port of the target; replies once the motion has ended",
            ReplyMode::Last => "reads the last sample of a port of the target",
            ReplyMode::All => "reads the samples of a port of the target since the previous call",
        };
        let (service, of) = (&mapped.service, &mapped.interface);
        let handle = interface.serve_declared(service, of, mapped.operation.clone(), doc);
        Self {
            port: mapped.port.clone(),
            conversion: mapped.conversion.clone(),
            request: mapped.operation.request.clone(),
            handle,
            mode: mapped.mode,
            samples: VecDeque::new(),
            waiting: Vec::new(),
        }
    }

    pub(super) fn handle(&self) -> Provided<Dynamic> {
        self.handle
    }

    /// `true` if the operation reads a port, `false` if it writes one.
    pub(super) fn reads(&self) -> bool {
        match self.mode {
            ReplyMode::Last | ReplyMode::All => true,
            ReplyMode::OneWay | ReplyMode::Taken | ReplyMode::Done => false,
        }
    }

    /// Forgets cancelled requests, and marks the samples of the last cycle as having left.
    pub(super) fn set_sent_times(&mut self, cycle: &Cycle<'_>) {
        let gone = cycle.cancelled(self.handle);
        self.waiting
            .retain(|waiting| !gone.contains(&waiting.request));
        for waiting in &mut self.waiting {
            waiting.left.get_or_insert(cycle.now());
        }
    }

    /// Called when a command was written: replies at once, or queues the request until its condition holds.
    pub(super) fn accepted(&mut self, request: RequestId, cycle: &mut Cycle<'_>) {
        match self.mode {
            ReplyMode::Taken | ReplyMode::Done => self.waiting.push(Waiting {
                request,
                left: None,
            }),
            ReplyMode::OneWay | ReplyMode::Last | ReplyMode::All => self.reply(request, cycle),
        }
    }

    /// Called when the target has written a sample in a cycle that began at `cycle_start`: it has consumed all samples
    /// that had left before.
    pub(super) fn reply_to_sent(&mut self, cycle_start: Time, cycle: &mut Cycle<'_>) {
        if self.mode != ReplyMode::Taken {
            return;
        }
        let is_taken = |waiting: &mut Waiting| waiting.left.is_some_and(|left| left <= cycle_start);
        let taken: Vec<Waiting> = self.waiting.extract_if(.., is_taken).collect();
        for waiting in taken {
            self.reply(waiting.request, cycle);
        }
    }

    /// Called when the motion has ended: replies to the waiting requests.
    pub(super) fn reply_to_finished(&mut self, cycle: &mut Cycle<'_>) {
        if self.mode != ReplyMode::Done {
            return;
        }
        for waiting in std::mem::take(&mut self.waiting) {
            self.reply(waiting.request, cycle);
        }
    }

    /// Called when the motion will not reach its end: refuses the waiting requests.
    pub(super) fn refuse_waiting(&mut self, code: &str, detail: &str, cycle: &mut Cycle<'_>) {
        if self.mode != ReplyMode::Done {
            return;
        }
        for waiting in self.waiting.drain(..) {
            cycle.reply(self.handle, waiting.request, Err(refusal(code, detail)));
        }
    }

    /// Called when the target does not handle what was sent: refuses all requests that wait, whatever for.
    pub(super) fn refuse_all(&mut self, fault: &ServiceFault, cycle: &mut Cycle<'_>) {
        for waiting in self.waiting.drain(..) {
            cycle.reply(self.handle, waiting.request, Err(fault.clone()));
        }
    }

    /// Returns whether there are samples that no call has read, for [`ReplyMode::All`].
    pub(super) fn has_samples(&self) -> bool {
        !self.samples.is_empty()
    }

    /// Buffers a sample for [`ReplyMode::All`].
    pub(super) fn store_sample(&mut self, port: &str, sample: &Datum) {
        if self.mode != ReplyMode::All || self.port != port {
            return;
        }
        if self.samples.len() == MAX_KEPT {
            self.samples.pop_front();
        }
        self.samples.push_back(sample.clone());
    }

    /// The response of an operation that reads.
    pub(super) fn read(
        &mut self,
        port: In<Datum>,
        cycle: &Cycle<'_>,
    ) -> Result<Datum, ServiceFault> {
        if self.mode == ReplyMode::All {
            let samples = Datum::List(self.samples.drain(..).collect());
            return Ok(self.conversion.apply(&samples));
        }
        match cycle.read(port) {
            Flow::NewData(sample) | Flow::OldData(sample) => Ok(self.conversion.apply(sample)),
            Flow::NoData => Err(refusal("NO_DATA", "the target has written nothing yet")),
        }
    }

    fn reply(&self, request: RequestId, cycle: &mut Cycle<'_>) {
        cycle.reply(self.handle, request, Ok(Datum::Record(Vec::new())));
    }
}

/// A fault as the reply to a request.
pub(super) fn refusal(code: &str, detail: &str) -> ServiceFault {
    ServiceFault::new(code, detail)
}
