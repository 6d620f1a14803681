//! Requests to an address: each gets one reply, or ends at its deadline.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use crossbeam_queue::ArrayQueue;

use crate::deadline::deadline_after;
use crate::envelope::Payload;
use crate::sender_id::SenderId;
use crate::trace_context::TraceContext;
use asmotion_connection::Notifier;

/// A request to a provider.
#[derive(Debug, Clone)]
pub struct Request {
    /// Identity of the caller.
    pub origin: SenderId,
    /// The request's data.
    pub argument: Payload,
    /// Time after which the caller stops waiting. The provider does not start on the request after that.
    pub timeout: Duration,
    /// Address at which the caller receives later results (SCA `@Callback`); `None` without callbacks.
    pub callback: Option<Arc<str>>,
    /// Trace of the request; `None` if its sender keeps no traces.
    pub trace: Option<TraceContext>,
    /// Wait for a provider that is not there yet, for most of the timeout, before the call ends with
    /// [`CallFailure::Unavailable`]. Not transmitted; a bus within a process does not wait.
    pub awaits_provider: bool,
}

impl Request {
    /// Creates a request without callback or trace.
    pub fn new(origin: SenderId, argument: Payload, timeout: Duration) -> Self {
        Self {
            origin,
            argument,
            timeout,
            callback: None,
            trace: None,
            awaits_provider: false,
        }
    }

    /// Sets whether the call waits for a provider that is not there yet.
    #[must_use]
    pub fn with_awaited_provider(mut self, awaits_provider: bool) -> Self {
        self.awaits_provider = awaits_provider;
        self
    }

    /// Sets the trace that the request belongs to.
    #[must_use]
    pub fn with_trace(mut self, trace: TraceContext) -> Self {
        self.trace = Some(trace);
        self
    }

    /// Sets the address at which the caller can be called back.
    #[must_use]
    pub fn with_callback(mut self, address: impl Into<Arc<str>>) -> Self {
        self.callback = Some(address.into());
        self
    }
}

/// Reason why a call has no response.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CallFailure {
    /// No reply arrived before the deadline.
    #[error("no answer before the deadline")]
    Timeout,
    /// No provider is registered, it has left, or its queue is full.
    #[error("no server is available")]
    Unavailable,
    /// The provider is registered, and the component behind it does not run.
    #[error("the component that provides it does not run")]
    Stopped,
    /// The provider replied with a fault.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The caller cancelled the call.
    #[error("cancelled by the caller")]
    Cancelled,
}

/// A fault as a provider's reply.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{code}: {detail}")]
pub struct Refusal {
    /// One of the operation's fault codes.
    pub code: String,
    /// Explanation for a human reader.
    pub detail: String,
}

type CallResult = Result<Payload, CallFailure>;

/// Receives the reply to one call.
struct ReplySlot {
    reply: Mutex<Option<CallResult>>,
    /// See [`PendingCall::reason`].
    reason: OnceLock<String>,
    is_replied: AtomicBool,
    notifier: Arc<Notifier>,
}

impl ReplySlot {
    fn new(notifier: Arc<Notifier>) -> Arc<Self> {
        Arc::new(Self {
            reply: Mutex::new(None),
            reason: OnceLock::new(),
            is_replied: AtomicBool::new(false),
            notifier,
        })
    }

    /// Stores a reply, unless there is one already.
    fn set(&self, reply: CallResult) {
        if self.is_replied.swap(true, Ordering::AcqRel) {
            return;
        }
        *self.reply.lock().unwrap_or_else(PoisonError::into_inner) = Some(reply);
        self.notifier.notify();
    }
}

/// A call in progress. Dropping it abandons the call.
pub struct PendingCall {
    slot: Arc<ReplySlot>,
    deadline: Instant,
}

impl PendingCall {
    /// Creates a call and the provider's end of it, for back ends.
    pub fn new(request: Request, notifier: Arc<Notifier>) -> (Self, IncomingCall) {
        let slot = ReplySlot::new(notifier);
        let call = IncomingCall::new(request, Arc::clone(&slot), false);
        let deadline = call.deadline;
        (Self { slot, deadline }, call)
    }

    /// Creates a one-way call, the provider's end of it, and the receipt that ends it.
    pub fn one_way(
        request: Request,
        notifier: Arc<Notifier>,
    ) -> (Self, IncomingCall, DeliveryReceipt) {
        let call = IncomingCall::new(request, ReplySlot::new(Arc::new(Notifier::new())), true);
        let slot = ReplySlot::new(notifier);
        let deadline = call.deadline;
        let delivered = DeliveryReceipt(Arc::clone(&slot));
        (Self { slot, deadline }, call, delivered)
    }

    /// Cancels the call: it ends with [`CallFailure::Cancelled`] unless it has already ended. A provider that has not
    /// started on the request never does.
    pub fn cancel(&self) {
        self.slot.set(Err(CallFailure::Cancelled));
    }

    /// Returns the instant at which the call ends without a reply.
    pub fn deadline(&self) -> Instant {
        self.deadline
    }

    /// Returns whether the deadline has passed.
    pub fn is_expired(&self) -> bool {
        Instant::now() >= self.deadline
    }

    /// Takes the result, if the call has ended. Returns it once.
    pub fn try_take(&self) -> Option<CallResult> {
        if self.is_expired() {
            self.slot.set(Err(CallFailure::Timeout));
        }
        let mut answer = self
            .slot
            .reply
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        answer.take()
    }

    /// Returns why the call has ended as [`CallFailure::Unavailable`], if its back end has said so.
    pub fn reason(&self) -> Option<&str> {
        self.slot.reason.get().map(String::as_str)
    }

    /// Waits for the result, at most until the deadline.
    ///
    /// # Errors
    /// [`CallFailure::Timeout`] at the deadline, [`CallFailure::Unavailable`] without a provider,
    /// [`CallFailure::Refused`] with the error of the operation, [`CallFailure::Cancelled`] after
    /// [`cancel`](Self::cancel).
    pub fn wait(self) -> CallResult {
        loop {
            if let Some(answer) = self.try_take() {
                return answer;
            }
            self.slot
                .notifier
                .wait(self.deadline.saturating_duration_since(Instant::now()));
        }
    }
}

/// A request at its provider. Dropping it without a reply ends the call with [`CallFailure::Unavailable`].
pub struct IncomingCall {
    /// Identity of the caller.
    pub origin: SenderId,
    /// The request's data.
    pub argument: Payload,
    /// Instant at which the caller stops waiting.
    pub deadline: Instant,
    /// Address at which the caller receives later results, if any.
    pub callback: Option<Arc<str>>,
    /// Trace of the request; `None` if its sender keeps no traces.
    pub trace: Option<TraceContext>,
    slot: Arc<ReplySlot>,
    one_way: bool,
}

/// Ends a one-way call at the sender.
pub struct DeliveryReceipt(Arc<ReplySlot>);

impl DeliveryReceipt {
    /// Reports whether the provider's queue has the request.
    pub fn complete(self, result: Result<(), CallFailure>) {
        self.0
            .set(result.map(|()| Payload::of(asmotion_datum::Datum::Null)));
    }

    /// Says why the call is about to end as [`CallFailure::Unavailable`].
    pub fn explain(&self, reason: String) {
        // the first reason remains
        let _ = self.0.reason.set(reason);
    }

    /// Returns whether the sender still waits for the receipt.
    pub fn is_awaited(&self) -> bool {
        Arc::strong_count(&self.0) > 1 && !self.0.is_replied.load(Ordering::Acquire)
    }
}

impl IncomingCall {
    fn new(request: Request, slot: Arc<ReplySlot>, one_way: bool) -> Self {
        Self {
            origin: request.origin,
            argument: request.argument,
            deadline: deadline_after(request.timeout),
            callback: request.callback,
            trace: request.trace,
            slot,
            one_way,
        }
    }

    /// Returns whether the caller expects no reply.
    pub fn is_one_way(&self) -> bool {
        self.one_way
    }

    /// Replies to the request. A reply that is no longer awaited is discarded.
    pub fn reply(self, result: Result<Payload, Refusal>) {
        self.complete(result.map_err(CallFailure::Refused));
    }

    /// Ends the call, for back ends.
    pub fn complete(self, result: Result<Payload, CallFailure>) {
        self.slot.set(result);
    }

    /// Says why the call is about to end as [`CallFailure::Unavailable`], for back ends.
    pub fn explain(&self, reason: String) {
        // the first reason remains
        let _ = self.slot.reason.set(reason);
    }

    /// Returns whether the caller still waits for a reply.
    pub fn is_awaited(&self) -> bool {
        let has_waiting_caller = self.one_way
            || Arc::strong_count(&self.slot) > 1 && !self.slot.is_replied.load(Ordering::Acquire);
        has_waiting_caller && Instant::now() < self.deadline
    }
}

/// Queue of requests for one provider, filled by back ends.
pub struct AddressQueue {
    waiting: ArrayQueue<IncomingCall>,
    open: AtomicBool,
    notifier: Arc<Notifier>,
    /// Number of requests refused because the queue was full; read by the provider.
    refused: AtomicU64,
}

impl AddressQueue {
    /// Creates a queue for at most `size` requests. The notifier is notified of each.
    pub fn new(size: usize, notifier: Arc<Notifier>) -> Arc<Self> {
        Arc::new(Self {
            waiting: ArrayQueue::new(size.max(1)),
            open: AtomicBool::new(true),
            notifier,
            refused: AtomicU64::new(0),
        })
    }

    /// Appends a request.
    ///
    /// # Errors
    /// [`CallFailure::Unavailable`] if the queue is full or its provider has left. The call ends with the same failure.
    pub fn push(&self, call: IncomingCall) -> Result<(), CallFailure> {
        if !self.open.load(Ordering::Acquire) {
            call.complete(Err(CallFailure::Unavailable));
            return Err(CallFailure::Unavailable);
        }
        let pushed = self.waiting.push(call).map_err(|call| {
            self.refused.fetch_add(1, Ordering::Relaxed);
            call.complete(Err(CallFailure::Unavailable));
            CallFailure::Unavailable
        });
        if pushed.is_ok() {
            self.notifier.notify();
        }
        if !self.open.load(Ordering::Acquire) {
            self.refuse_all();
        }
        pushed
    }

    fn refuse_all(&self) {
        while let Some(call) = self.waiting.pop() {
            call.complete(Err(CallFailure::Unavailable));
        }
    }
}

/// The provider's end of an address. Dropping it ends the service and fails the waiting calls.
pub struct ServedAddress {
    queue: Arc<AddressQueue>,
    on_drop: Option<Box<dyn FnOnce() + Send>>,
}

impl ServedAddress {
    /// Creates the provider's end of a queue. `on_drop` is called on drop, after the waiting calls have failed.
    pub fn new(queue: Arc<AddressQueue>, on_drop: impl FnOnce() + Send + 'static) -> Self {
        Self {
            queue,
            on_drop: Some(Box::new(on_drop)),
        }
    }

    /// The number of requests refused so far because the queue was full.
    pub fn refused(&self) -> u64 {
        self.queue.refused.load(Ordering::Relaxed)
    }

    /// Removes and returns the next request that is still awaited.
    pub fn try_next(&self) -> Option<IncomingCall> {
        std::iter::from_fn(|| self.queue.waiting.pop()).find(IncomingCall::is_awaited)
    }

    /// Removes and returns the next request that is still awaited, waiting at most for `timeout`.
    pub fn next_within(&self, timeout: Duration) -> Option<IncomingCall> {
        let until = deadline_after(timeout);
        loop {
            if let Some(call) = self.try_next() {
                return Some(call);
            }
            let remaining = until.saturating_duration_since(Instant::now());
            if remaining.is_zero() {
                return None;
            }
            self.queue.notifier.wait(remaining);
        }
    }
}

impl Drop for ServedAddress {
    fn drop(&mut self) {
        self.queue.open.store(false, Ordering::Release);
        self.queue.refuse_all();
        if let Some(leave) = self.on_drop.take() {
            leave();
        }
    }
}

/// Ends the call if there was no reply.
impl Drop for IncomingCall {
    fn drop(&mut self) {
        self.slot.set(Err(if Instant::now() < self.deadline {
            CallFailure::Unavailable
        } else {
            CallFailure::Timeout
        }));
    }
}

impl fmt::Debug for PendingCall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Pending")
    }
}

impl fmt::Debug for IncomingCall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Call from {}: {:?}", self.origin.source, self.argument)
    }
}

impl fmt::Debug for ServedAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Serving, {} waiting", self.queue.waiting.len())
    }
}
