//! Operations called from outside: sent, and collected when they are done.

use asmotion_bus::{CallFailure, Payload, PendingCall};
use asmotion_component::{CallError, SendStatus, ServiceFault};
use asmotion_datum::Datum;
use asmotion_network::call_error;

use crate::error::RemoteError;
use crate::remote::Remote;

/// A call under way (RTT `SendHandle`). Dropping it gives the call up.
pub struct SendHandle {
    remote: Remote,
    operation: String,
    pending: PendingCall,
    collected: bool,
}

impl SendHandle {
    pub(crate) fn new(remote: Remote, operation: &str, pending: PendingCall) -> Self {
        Self {
            remote,
            operation: operation.to_owned(),
            pending,
            collected: false,
        }
    }

    /// What has become of the call, as of now.
    pub fn collect_if_done(&mut self) -> SendStatus<Datum> {
        if self.collected {
            return SendStatus::Unknown;
        }
        let Some(end) = self.pending.try_take() else {
            return SendStatus::NotReady;
        };
        self.collected = true;
        match read(end) {
            Ok(answer) => SendStatus::Success(answer),
            Err(error) => SendStatus::Failure(error),
        }
    }

    /// The answer, waiting for it: never longer than the patience that the call was sent with.
    ///
    /// # Errors
    /// Nobody serves the operation, the provider refuses, or the time is up.
    pub fn collect(self) -> Result<Datum, RemoteError> {
        let answer = match self.collected {
            true => Err(CallError::Cancelled),
            false => read(self.pending.wait()),
        };
        answer.map_err(|error| match error {
            CallError::Unavailable => RemoteError::Nobody {
                nearest: self.remote.operation_like(&self.operation),
                operation: self.operation,
            },
            CallError::Timeout | CallError::Fault(_) | CallError::Cancelled => error.into(),
        })
    }

    /// Tells a listener the answer as soon as it is there, from a thread of its own: nobody polls.
    ///
    /// # Errors
    /// There are no more threads.
    pub fn then(
        self,
        listener: impl FnOnce(Result<Datum, RemoteError>) + Send + 'static,
    ) -> std::io::Result<()> {
        let thread = std::thread::Builder::new().name(format!("awaits {}", self.operation));
        thread.spawn(move || listener(self.collect())).map(drop)
    }

    /// Takes the call back. A provider that has not begun does not begin any more.
    pub fn cancel(&self) {
        self.pending.cancel();
    }
}

fn read(end: Result<Payload, CallFailure>) -> Result<Datum, CallError> {
    let unreadable = |error: asmotion_datum::DatumError| {
        ServiceFault::new("BAD_REPLY", error.to_string()).into()
    };
    end.map_err(call_error)?.to_datum().map_err(unreadable)
}
