//! The provider's side of services: a request waits for the provider's cycle and stays open until it replies.

mod freeze;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use asmotion_component::declaration::ServiceDeclaration;
use asmotion_component::{CallError, Handler, RequestId, ServiceFault, guarded};
use asmotion_datum::Sample;
use asmotion_port::{Notifier, Time};
use crossbeam_queue::ArrayQueue;

pub(crate) use self::freeze::{FrozenService, ThawContext};
use super::message::{CallKey, ProviderMessage, ReplyTo, ServiceRequest};
use crate::effects::{ComponentEffects, Effects};
use crate::event::Event;

/// Capacity of a provider's request queue; calls beyond it end as unavailable.
const WAITING: usize = 128;

/// Requests that wait for a provider. Callers on any thread push them; the provider's thread pops them.
pub struct RequestQueue {
    queue: ArrayQueue<ProviderMessage>,
    /// Whether the provider runs. Set and cleared by the provider's thread between two cycles (`Release`), read by
    /// callers (`Acquire`). A request that is pushed while this is being cleared is refused when the provider empties
    /// the queue.
    open: AtomicBool,
    /// Notified of every message if the provider is remote and an adapter empties the queue; `None` for a local
    /// provider.
    notifier: Option<Arc<Notifier>>,
    /// Handlers that run in the caller's thread, by position of the operation; `None` for operations served in the
    /// provider's cycles.
    handlers: Vec<Option<Handler>>,
}

impl RequestQueue {
    fn new(handlers: Vec<Option<Handler>>) -> Arc<Self> {
        Arc::new(Self {
            queue: ArrayQueue::new(WAITING),
            open: AtomicBool::new(false),
            notifier: None,
            handlers,
        })
    }

    /// Creates the queue of a remote service: always open; the notifier wakes the adapter that empties it.
    pub fn remote(notifier: Arc<Notifier>) -> Arc<Self> {
        Arc::new(Self {
            queue: ArrayQueue::new(WAITING),
            open: AtomicBool::new(true),
            notifier: Some(notifier),
            handlers: Vec::new(),
        })
    }

    /// Removes and returns the oldest message.
    pub fn next(&self) -> Option<ProviderMessage> {
        self.queue.pop()
    }

    /// Serves a request at once if its operation runs in the caller's thread; otherwise queues it for the provider's
    /// next cycle. Returns whether it was queued, in which case the provider must be triggered.
    ///
    /// # Errors
    /// [`CallError::Unavailable`] if the provider does not run or its queue is full.
    pub fn send(
        &self,
        request: ServiceRequest,
        effects: &mut dyn Effects,
    ) -> Result<bool, CallError> {
        let Some(Some(handler)) = self.handlers.get(request.operation) else {
            return self.push(ProviderMessage::Request(request)).map(|()| true);
        };
        let result = guarded(|| Ok(handler(request.argument)))
            .unwrap_or_else(|fault| Err(ServiceFault::new("PANIC", fault.to_string())));
        if let Some(reply_to) = request.reply_to {
            reply_to.send(
                request.key.number,
                result.map_err(CallError::Fault),
                effects,
            );
        }
        Ok(false)
    }

    /// Queues a message for the provider's next cycle.
    pub(crate) fn push(&self, message: ProviderMessage) -> Result<(), CallError> {
        if !self.open.load(Ordering::Acquire) {
            return Err(CallError::Unavailable);
        }
        self.queue
            .push(message)
            .map_err(|_| CallError::Unavailable)?;
        if let Some(notifier) = &self.notifier {
            notifier.notify();
        }
        Ok(())
    }
}

/// A provided service at run time.
pub(crate) struct ProvidedService {
    pub declaration: ServiceDeclaration,
    pub queue: Arc<RequestQueue>,
    /// Frozen requests that the component has not taken yet.
    waiting: Vec<(RequestId, ServiceRequest)>,
    /// Requests that the component has taken and not answered yet.
    open: Vec<OpenRequest>,
    /// Taken requests whose cancellation became visible in the current cycle.
    cancelled: Vec<RequestId>,
    next_id: u64,
}

/// A request that the component has taken.
struct OpenRequest {
    id: RequestId,
    key: CallKey,
    operation: usize,
    caller: Arc<str>,
    deadline: Option<Time>,
    reply_to: ReplyTo,
}

impl ProvidedService {
    pub(crate) fn new(declaration: ServiceDeclaration, handlers: Vec<Option<Handler>>) -> Self {
        Self {
            declaration,
            queue: RequestQueue::new(handlers),
            waiting: Vec::new(),
            open: Vec::new(),
            cancelled: Vec::new(),
            next_id: 0,
        }
    }

    /// Freezes the requests that have arrived since the last cycle; drops those that were cancelled before the
    /// component took them.
    pub(crate) fn freeze(&mut self, now: Time) {
        self.cancelled.clear();
        for _ in 0..self.queue.queue.len() {
            match self.queue.queue.pop() {
                None => break,
                Some(ProviderMessage::Cancel(key)) => self.cancel(key),
                Some(ProviderMessage::Request(request)) => {
                    self.next_id += 1;
                    self.waiting.push((RequestId(self.next_id), request));
                }
            }
        }
        let alive = |deadline: Option<Time>| deadline.is_none_or(|deadline| now < deadline);
        let awaited = |ask: &ServiceRequest| ask.reply_to.as_ref().is_none_or(ReplyTo::is_awaited);
        self.waiting
            .retain(|(_, ask)| alive(ask.deadline) && awaited(ask));
        let cancelled = &mut self.cancelled;
        self.open.retain(|open| {
            let keep = alive(open.deadline) && open.reply_to.is_awaited();
            if !keep {
                cancelled.push(open.id);
            }
            keep
        });
    }

    fn cancel(&mut self, key: CallKey) {
        self.waiting.retain(|(_, ask)| ask.key != key);
        while let Some(index) = self.open.iter().position(|open| open.key == key) {
            self.cancelled.push(self.open.remove(index).id);
        }
    }

    /// Removes and returns the waiting requests of an operation. Those that expect a reply stay open.
    pub(crate) fn take(&mut self, operation: usize) -> Vec<(RequestId, ServiceRequest)> {
        if self.waiting.is_empty() {
            return Vec::new();
        }
        let mut taken: Vec<_> = self
            .waiting
            .extract_if(.., |(_, ask)| ask.operation == operation)
            .collect();
        self.open.extend(taken.iter_mut().filter_map(|(id, ask)| {
            Some(OpenRequest {
                id: *id,
                key: ask.key,
                operation: ask.operation,
                caller: Arc::clone(&ask.caller),
                deadline: ask.deadline,
                reply_to: ask.reply_to.take()?,
            })
        }));
        taken
    }

    /// The taken requests whose callers stopped waiting, as frozen for the current cycle.
    pub(crate) fn cancelled(&self) -> &[RequestId] {
        &self.cancelled
    }

    /// Sends a reply, or drops it if the caller no longer waits.
    pub(crate) fn answer(
        &mut self,
        to: RequestId,
        result: Result<Arc<dyn Sample>, ServiceFault>,
        effects: &mut ComponentEffects<'_>,
    ) {
        let Some(index) = self.open.iter().position(|open| open.id == to) else {
            return;
        };
        let open = self.open.remove(index);
        self.send(open, result.map_err(CallError::Fault), effects);
    }

    fn send(
        &self,
        open: OpenRequest,
        result: Result<Arc<dyn Sample>, CallError>,
        effects: &mut ComponentEffects<'_>,
    ) {
        let operation = self.declaration.operations.get(open.operation);
        effects.emit(&Event::Answered {
            component: effects.name,
            service: &self.declaration.name,
            operation: operation.map_or("", |operation| &operation.name),
            caller: &open.caller,
            result: result.as_deref(),
        });
        let number = open.key.number;
        open.reply_to.send(number, result, effects.effects);
    }

    /// Accepts requests from now on.
    pub(crate) fn open(&self) {
        self.queue.open.store(true, Ordering::Release);
    }

    /// Refuses requests from now on; waiting callers get [`CallError::Unavailable`].
    pub(crate) fn close(&mut self, effects: &mut ComponentEffects<'_>) {
        self.queue.open.store(false, Ordering::Release);
        self.refuse_waiting(effects);
    }

    /// Replies [`CallError::Unavailable`] to all waiting and open requests.
    pub(crate) fn refuse_waiting(&mut self, effects: &mut ComponentEffects<'_>) {
        self.freeze(effects.now);
        for operation in 0..self.declaration.operations.len() {
            drop(self.take(operation));
        }
        for open in std::mem::take(&mut self.open) {
            self.send(open, Err(CallError::Unavailable), effects);
        }
    }
}
