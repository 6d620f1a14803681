//! Calls of operations from outside a system: sent first, collected when they have ended.

use std::sync::Arc;
use std::time::Duration;

use asmotion_bus::{CallFailure, Notifier, Payload, PendingCall};
use asmotion_component::{CallError, SendStatus, ServiceFault};
use asmotion_datum::Datum;
use asmotion_network::call_error;

use crate::error::RemoteError;
use crate::remote::{Remote, request};

/// A call under way (RTT `SendHandle`). Dropping it cancels the call.
pub struct SendHandle {
    remote: Remote,
    operation: String,
    pending: PendingCall,
    collected: bool,
}

impl Remote {
    /// Calls an operation such as `navigation.MapServer.maps.getMap` and waits for the response.
    ///
    /// # Errors
    /// An error if the operation has no provider, the provider replies with a fault, or the time is up.
    pub fn call(
        &self,
        operation: &str,
        argument: Datum,
        timeout: Duration,
    ) -> Result<Datum, RemoteError> {
        self.send(operation, argument, timeout)?.collect()
    }

    /// Calls an operation without waiting. The response is collected, or passed to a listener.
    ///
    /// # Errors
    /// An error of the bus.
    pub fn send(
        &self,
        operation: &str,
        argument: Datum,
        timeout: Duration,
    ) -> Result<SendHandle, RemoteError> {
        let request = request(argument, timeout);
        let pending = self
            .bus()
            .call(operation, request, Arc::new(Notifier::new()))?;
        Ok(SendHandle::new(self.clone(), operation, pending))
    }
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

    /// The current status of the call, with its result once it has ended.
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

    /// Waits for the response, at most as long as the timeout given with the call.
    ///
    /// # Errors
    /// An error if the operation has no provider, the provider replies with a fault, or the time is up.
    pub fn collect(self) -> Result<Datum, RemoteError> {
        let answer = if self.collected {
            Err(CallError::Cancelled)
        } else {
            read(self.pending.wait())
        };
        answer.map_err(|error| match error {
            CallError::Unavailable => RemoteError::Nobody {
                nearest: self.remote.similar_operation(&self.operation),
                operation: self.operation,
            },
            CallError::Stopped => RemoteError::Stopped {
                component: self.remote.provider(&self.operation),
                operation: self.operation,
            },
            CallError::Timeout | CallError::Fault(_) | CallError::Cancelled => error.into(),
        })
    }

    /// Passes the result to a listener when it arrives, on a new thread and without polling.
    ///
    /// # Errors
    /// An error if the operating system cannot start a thread.
    pub fn on_completion(
        self,
        listener: impl FnOnce(Result<Datum, RemoteError>) + Send + 'static,
    ) -> std::io::Result<()> {
        let thread = std::thread::Builder::new().name(format!("awaits {}", self.operation));
        thread.spawn(move || listener(self.collect())).map(drop)
    }

    /// Cancels the call. A provider that has not started on the request never does.
    pub fn cancel(&self) {
        self.pending.cancel();
    }
}

fn read(result: Result<Payload, CallFailure>) -> Result<Datum, CallError> {
    let unreadable = |error: asmotion_datum::DatumError| {
        ServiceFault::new("BAD_REPLY", error.to_string()).into()
    };
    result.map_err(call_error)?.to_datum().map_err(unreadable)
}
