//! An operation that is a port.

use std::collections::VecDeque;

use asmotion_component::{
    Cycle, Dynamic, Flow, In, Interface, Provided, RequestId, ServiceFault, Time,
};
use asmotion_datum::Datum;
use serde::{Deserialize, Serialize};

use super::{Mapped, ReplyMode};
use crate::Conversion;

/// What a caller hears whose command another one has replaced.
pub(super) const TAKEN_BACK: &str = "another command came before the motion had ended";

/// More samples than this are not kept for a reader of all of them: the oldest goes.
const MAX_KEPT: usize = 1024;

/// An operation, with those who wait for its reply.
pub(super) struct ProxiedOperation {
    pub port: String,
    pub conversion: Conversion,
    handle: Provided<Dynamic>,
    mode: ReplyMode,
    /// The samples since the last call, for [`ReplyMode::All`].
    pub kept: VecDeque<Datum>,
    pub waiting: Vec<Waiting>,
}

/// Somebody who waits for more than that a sample was written.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Waiting {
    request: RequestId,
    /// When the sample had certainly left: the time of the cycle after the one that wrote it.
    left: Option<Time>,
}

impl ProxiedOperation {
    pub(super) fn declare(mapped: &Mapped, interface: &mut Interface) -> Self {
        let doc = match mapped.mode {
            ReplyMode::OneWay => "writes a port of the target",
            ReplyMode::Taken => "writes a port of the target; replies when it was read",
            ReplyMode::Done => "writes a port of the target; replies when the motion has ended",
            ReplyMode::Last => "reads the last sample of a port of the target",
            ReplyMode::All => "reads the samples of a port of the target since the last call",
        };
        let handle = interface.serve_of(&mapped.service, &mapped.interface, &mapped.operation, doc);
        Self {
            port: mapped.port.clone(),
            conversion: mapped.conversion.clone(),
            handle,
            mode: mapped.mode,
            kept: VecDeque::new(),
            waiting: Vec::new(),
        }
    }

    pub(super) fn handle(&self) -> Provided<Dynamic> {
        self.handle
    }

    /// Whether it reads a port; it writes one otherwise.
    pub(super) fn reads(&self) -> bool {
        match self.mode {
            ReplyMode::Last | ReplyMode::All => true,
            ReplyMode::OneWay | ReplyMode::Taken | ReplyMode::Done => false,
        }
    }

    /// Nobody waits any longer who gave up; what the last cycle wrote has left.
    pub(super) fn settle(&mut self, cycle: &Cycle<'_>) {
        let gone = cycle.cancelled(self.handle);
        self.waiting
            .retain(|waiting| !gone.contains(&waiting.request));
        for waiting in &mut self.waiting {
            waiting.left.get_or_insert(cycle.now());
        }
    }

    /// A command was written: who asked for it hears so now, or later.
    pub(super) fn accepted(&mut self, request: RequestId, cycle: &mut Cycle<'_>) {
        match self.mode {
            ReplyMode::Taken | ReplyMode::Done => self.waiting.push(Waiting {
                request,
                left: None,
            }),
            ReplyMode::OneWay | ReplyMode::Last | ReplyMode::All => self.reply(request, cycle),
        }
    }

    /// The target has written a sample in a cycle that began then: what had left before, it has taken.
    pub(super) fn taken(&mut self, began: Time, cycle: &mut Cycle<'_>) {
        if self.mode != ReplyMode::Taken {
            return;
        }
        let is_taken = |waiting: &mut Waiting| waiting.left.is_some_and(|left| left <= began);
        let taken: Vec<Waiting> = self.waiting.extract_if(.., is_taken).collect();
        for waiting in taken {
            self.reply(waiting.request, cycle);
        }
    }

    /// The motion has ended.
    pub(super) fn done(&mut self, cycle: &mut Cycle<'_>) {
        if self.mode != ReplyMode::Done {
            return;
        }
        for waiting in std::mem::take(&mut self.waiting) {
            self.reply(waiting.request, cycle);
        }
    }

    /// The motion will not end.
    pub(super) fn refuse_waiting(&mut self, code: &str, detail: &str, cycle: &mut Cycle<'_>) {
        if self.mode != ReplyMode::Done {
            return;
        }
        for waiting in self.waiting.drain(..) {
            cycle.reply(self.handle, waiting.request, Err(refusal(code, detail)));
        }
    }

    /// Keeps a sample for whoever reads all of them.
    pub(super) fn keep(&mut self, port: &str, sample: &Datum) {
        if self.mode != ReplyMode::All || self.port != port {
            return;
        }
        if self.kept.len() == MAX_KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back(sample.clone());
    }

    /// The result of reading.
    pub(super) fn read(
        &mut self,
        port: In<Datum>,
        cycle: &Cycle<'_>,
    ) -> Result<Datum, ServiceFault> {
        if self.mode == ReplyMode::All {
            let kept = Datum::List(self.kept.drain(..).collect());
            return Ok(self.conversion.apply(&kept));
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

/// A fault that the caller is answered with.
pub(super) fn refusal(code: &str, detail: &str) -> ServiceFault {
    ServiceFault::new(code, detail)
}
