//! The provider's side of services: a request waits for the provider's cycle and stays open until it replies.

mod freeze;

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

use asmotion_component::declaration::ServiceDeclaration;
use asmotion_component::{CallError, Handler, RequestId, ServiceFault, guarded};
use asmotion_datum::Sample;
use asmotion_port::{Notifier, Time};
use crossbeam_queue::ArrayQueue;
use serde::{Deserialize, Serialize};

pub(crate) use self::freeze::{FrozenService, ThawContext};
use super::message::{CallKey, ProviderMessage, ReplyTo, ServiceRequest};
use crate::effects::{ComponentEffects, Effects};
use crate::event::Event;

/// Capacity of a provider's request queue; calls beyond it end as unavailable.
const WAITING: usize = 128;

/// The requests that a provider takes, by its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Admission {
    /// None: the component is not configured.
    None,
    /// Those of operations that are answered while the component is stopped.
    WhileStopped,
    /// All: the component runs.
    All,
}

impl Admission {
    fn of(number: u8) -> Self {
        [Self::None, Self::WhileStopped, Self::All]
            .into_iter()
            .find(|it| *it as u8 == number)
            .unwrap_or(Self::None)
    }
}

/// Requests that wait for a provider. Callers on any thread push them; the provider's thread pops them.
pub struct RequestQueue {
    queue: ArrayQueue<ProviderMessage>,
    /// An [`Admission`]. Set by the provider's thread between two cycles (`Release`), read by callers (`Acquire`). A
    /// request that is pushed while this is being changed is refused when the provider empties the queue.
    admission: AtomicU8,
    /// Notified of every message if the provider is remote and an adapter empties the queue; `None` for a local
    /// provider.
    notifier: Option<Arc<Notifier>>,
    /// Handlers that run in the caller's thread, by position of the operation; `None` for operations served in the
    /// provider's cycles.
    handlers: Vec<Option<Handler>>,
    /// Whether the component answers the operation while it is stopped, by position of the operation.
    while_stopped: Vec<bool>,
    /// Number of requests refused because the queue was full. Incremented by callers on any thread; independent of the queue,
    /// so it is `Relaxed`.
    refused: AtomicU64,
}

impl RequestQueue {
    fn new(declaration: &ServiceDeclaration, handlers: Vec<Option<Handler>>) -> Arc<Self> {
        let operations = declaration.operations.iter();
        Arc::new(Self {
            queue: ArrayQueue::new(WAITING),
            admission: AtomicU8::new(Admission::None as u8),
            notifier: None,
            handlers,
            while_stopped: operations.map(|it| it.while_stopped).collect(),
            refused: AtomicU64::new(0),
        })
    }

    /// Creates the queue of a remote service: always open; the notifier wakes the adapter that empties it.
    pub fn remote(notifier: Arc<Notifier>) -> Arc<Self> {
        Arc::new(Self {
            queue: ArrayQueue::new(WAITING),
            admission: AtomicU8::new(Admission::All as u8),
            notifier: Some(notifier),
            handlers: Vec::new(),
            while_stopped: Vec::new(),
            refused: AtomicU64::new(0),
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
    /// [`CallError::Stopped`] if the provider does not run, [`CallError::Unavailable`] if its queue is full.
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

    /// The reason for which requests of an operation are refused at present, if they are.
    pub fn refuses(&self, operation: usize) -> Option<CallError> {
        let in_caller = self.handlers.get(operation).is_some_and(Option::is_some);
        let admits = in_caller
            || match self.admission() {
                Admission::None => false,
                Admission::WhileStopped => self.is_marked(operation),
                Admission::All => true,
            };
        (!admits).then_some(CallError::Stopped)
    }

    pub(crate) fn admission(&self) -> Admission {
        Admission::of(self.admission.load(Ordering::Acquire))
    }

    pub(crate) fn set_admission(&self, admission: Admission) {
        self.admission.store(admission as u8, Ordering::Release);
    }

    /// Whether the component answers the operation while it is stopped.
    fn is_marked(&self, operation: usize) -> bool {
        self.while_stopped.get(operation) == Some(&true)
    }

    /// The number of requests and cancellations that wait.
    pub fn waiting(&self) -> u64 {
        self.queue.len() as u64
    }

    /// The number of requests refused because a queue of the service was full.
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }

    /// Counts requests that were refused because a queue of the service was full: this one, or one on the way to it.
    pub fn add_refused(&self, count: u64) {
        self.refused.fetch_add(count, Ordering::Relaxed);
    }

    pub(crate) fn set_refused(&self, count: u64) {
        self.refused.store(count, Ordering::Relaxed);
    }

    /// Queues a message for the provider's next cycle.
    pub(crate) fn push(&self, message: ProviderMessage) -> Result<(), CallError> {
        let refused = match &message {
            ProviderMessage::Request(request) => self.refuses(request.operation),
            ProviderMessage::Cancel(_) => {
                (self.admission() == Admission::None).then_some(CallError::Stopped)
            }
        };
        if let Some(error) = refused {
            return Err(error);
        }
        if let Err(message) = self.queue.push(message) {
            if let ProviderMessage::Request(_) = message {
                self.add_refused(1);
            }
            return Err(CallError::Unavailable);
        }
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
    /// Requests without a caller who waits for a reply, taken in the current cycle, and their operations.
    one_way: Vec<(RequestId, usize)>,
    /// Operations and causes of refused one-way requests that have been reported.
    reported: Vec<(usize, String)>,
    next_id: u64,
}

/// A refusal that no caller receives, because the request was one-way.
pub(crate) struct UnheardRefusal {
    /// `service.operation`.
    pub operation: String,
    pub fault: ServiceFault,
    /// Whether it is to be reported: each cause is reported once, and only the first few of a service.
    pub is_new: bool,
}

/// Causes of refusals of one-way requests that a service reports; further ones are counted only.
const MAX_CAUSES: usize = 8;

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
            queue: RequestQueue::new(&declaration, handlers),
            declaration,
            waiting: Vec::new(),
            open: Vec::new(),
            cancelled: Vec::new(),
            one_way: Vec::new(),
            reported: Vec::new(),
            next_id: 0,
        }
    }

    /// Freezes the requests that have arrived since the last cycle; drops those that were cancelled before the
    /// component took them.
    pub(crate) fn freeze(&mut self, now: Time) {
        self.cancelled.clear();
        self.one_way.clear();
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

    /// Whether there are frozen requests that the component has not taken.
    pub(crate) fn is_asked(&self) -> bool {
        !self.waiting.is_empty()
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
        for (id, ask) in &mut taken {
            let Some(reply_to) = ask.reply_to.take() else {
                self.one_way.push((*id, ask.operation));
                continue;
            };
            self.open.push(OpenRequest {
                id: *id,
                key: ask.key,
                operation: ask.operation,
                caller: Arc::clone(&ask.caller),
                deadline: ask.deadline,
                reply_to,
            });
        }
        taken
    }

    /// The taken requests whose callers stopped waiting, as frozen for the current cycle.
    pub(crate) fn cancelled(&self) -> &[RequestId] {
        &self.cancelled
    }

    /// Sends a reply, or drops it if the caller no longer waits. Returns the refusal of a one-way request that was taken in this
    /// cycle.
    pub(crate) fn answer(
        &mut self,
        to: RequestId,
        result: Result<Arc<dyn Sample>, ServiceFault>,
        effects: &mut ComponentEffects<'_>,
    ) -> Option<UnheardRefusal> {
        if let Some(index) = self.open.iter().position(|open| open.id == to) {
            let open = self.open.remove(index);
            self.send(open, result.map_err(CallError::Fault), effects);
            return None;
        }
        let fault = result.err()?;
        let (_, operation) = *self.one_way.iter().find(|(id, _)| *id == to)?;
        let cause = (operation, fault.to_string());
        let is_new = self.reported.len() < MAX_CAUSES && !self.reported.contains(&cause);
        if is_new {
            self.reported.push(cause);
        }
        let named = self.declaration.operations.get(operation);
        let named = named.map_or("", |operation| &operation.name);
        Some(UnheardRefusal {
            operation: format!("{}.{named}", self.declaration.name),
            fault,
            is_new,
        })
    }

    fn send(
        &self,
        open: OpenRequest,
        result: Result<Arc<dyn Sample>, CallError>,
        effects: &mut ComponentEffects<'_>,
    ) {
        let operation = self.declaration.operations.get(open.operation);
        if let ReplyTo::External(caller) = &open.reply_to {
            // before the event, on which the caller's thread looks for its reply; fails if it has stopped waiting
            let _ = caller.send(result.clone());
        }
        effects.emit(&Event::Answered {
            component: effects.name,
            service: &self.declaration.name,
            operation: operation.map_or("", |operation| &operation.name),
            caller: &open.caller,
            result: result.as_deref(),
        });
        if !matches!(open.reply_to, ReplyTo::External(_)) {
            open.reply_to.send(open.key.number, result, effects.effects);
        }
    }

    /// Changes the requests accepted from now on; callers whose requests are not among them get
    /// [`CallError::Stopped`], as do those whose requests the component has taken.
    pub(crate) fn admit(&mut self, admission: Admission, effects: &mut ComponentEffects<'_>) {
        self.queue.set_admission(admission);
        if admission != Admission::All {
            self.refuse_waiting(admission, effects);
        }
    }

    fn refuse_waiting(&mut self, admission: Admission, effects: &mut ComponentEffects<'_>) {
        self.freeze(effects.now);
        for operation in 0..self.declaration.operations.len() {
            if admission == Admission::None || !self.queue.is_marked(operation) {
                drop(self.take(operation));
            }
        }
        for open in std::mem::take(&mut self.open) {
            self.send(open, Err(CallError::Stopped), effects);
        }
    }

    /// Refuses the frozen requests of operations that the component does not answer while it is stopped. Returns whether
    /// any request is left.
    pub(crate) fn refuse_unmarked(&mut self, effects: &mut ComponentEffects<'_>) -> bool {
        let before = self.open.len();
        for operation in 0..self.declaration.operations.len() {
            if !self.queue.is_marked(operation) {
                drop(self.take(operation));
            }
        }
        for open in self.open.split_off(before) {
            self.send(open, Err(CallError::Stopped), effects);
        }
        !(self.waiting.is_empty() && self.open.is_empty() && self.cancelled.is_empty())
    }
}
