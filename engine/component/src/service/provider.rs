//! The provider's side: requests wait for its cycle, and stay open until it answers.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use asmotion_bus::Bell;
use asmotion_datum::Sample;
use crossbeam_queue::ArrayQueue;

use super::{AnswerTo, Ask, CallError, CallKey, Post, RequestId, ServiceFault};
use crate::declaration::ServiceDeclaration;
use crate::fault::guarded;
use crate::outside::{Leaving, Outside};
use crate::{Event, Time};

/// How many requests may wait for a provider; more find it unavailable.
const WAITING: usize = 128;

/// Serves an operation in its caller's thread (RTT `ClientThread`).
pub(crate) type Handler =
    Arc<dyn Fn(Arc<dyn Sample>) -> Result<Arc<dyn Sample>, ServiceFault> + Send + Sync>;

/// The way into a service, shared with its callers.
pub(crate) struct Inbox {
    queue: ArrayQueue<Post>,
    /// Whether the provider is running.
    open: AtomicBool,
    /// Rung for what comes, if the provider is beyond the bus.
    bell: Option<Arc<Bell>>,
    /// Of the operations that callers serve themselves with, by position.
    handlers: Vec<Option<Handler>>,
}

impl Inbox {
    fn new(handlers: Vec<Option<Handler>>) -> Arc<Self> {
        Arc::new(Self {
            queue: ArrayQueue::new(WAITING),
            open: AtomicBool::new(false),
            bell: None,
            handlers,
        })
    }

    /// The way to a service beyond the bus: always open, and the bell is rung for what comes.
    pub(crate) fn beyond(bell: Arc<Bell>) -> Arc<Self> {
        Arc::new(Self {
            queue: ArrayQueue::new(WAITING),
            open: AtomicBool::new(true),
            bell: Some(bell),
            handlers: Vec::new(),
        })
    }

    /// What came first.
    pub(crate) fn next(&self) -> Option<Post> {
        self.queue.pop()
    }

    /// Asks: at once, if the operation is served in the caller's thread, whatever the provider is doing; or leaves the
    /// question for the provider's next cycle. Says whether it did that.
    pub(crate) fn ask(&self, ask: Ask, outside: &mut dyn Outside) -> Result<bool, CallError> {
        let Some(Some(handler)) = self.handlers.get(ask.operation) else {
            return self.post(Post::Ask(ask)).map(|()| true);
        };
        let result = guarded(|| Ok(handler(ask.argument)))
            .unwrap_or_else(|fault| Err(ServiceFault::new("PANIC", fault.to_string())));
        if let Some(answer_to) = ask.answer_to {
            answer_to.send(ask.key.number, result.map_err(CallError::Fault), outside);
        }
        Ok(false)
    }

    /// Leaves something for the provider's next cycle.
    pub(crate) fn post(&self, post: Post) -> Result<(), CallError> {
        if !self.open.load(Ordering::Acquire) {
            return Err(CallError::Unavailable);
        }
        self.queue.push(post).map_err(|_| CallError::Unavailable)?;
        if let Some(bell) = &self.bell {
            bell.ring();
        }
        Ok(())
    }
}

/// A service port at run time.
pub(crate) struct Service {
    pub declaration: ServiceDeclaration,
    pub inbox: Arc<Inbox>,
    /// Frozen, not yet taken by the component.
    waiting: Vec<(RequestId, Ask)>,
    /// Taken, not yet answered.
    open: Vec<Open>,
    /// Taken, and no longer waited for; of this cycle.
    cancelled: Vec<RequestId>,
    next: u64,
}

/// A request that the component has taken.
struct Open {
    id: RequestId,
    key: CallKey,
    operation: usize,
    caller: Arc<str>,
    deadline: Option<Time>,
    answer_to: AnswerTo,
}

impl Service {
    pub(crate) fn new(declaration: ServiceDeclaration, handlers: Vec<Option<Handler>>) -> Self {
        Self {
            declaration,
            inbox: Inbox::new(handlers),
            waiting: Vec::new(),
            open: Vec::new(),
            cancelled: Vec::new(),
            next: 0,
        }
    }

    /// Takes in what came since the last cycle; forgets what nobody waits for any more.
    pub(crate) fn freeze(&mut self, now: Time) {
        self.cancelled.clear();
        for _ in 0..self.inbox.queue.len() {
            match self.inbox.queue.pop() {
                None => break,
                Some(Post::Cancel(key)) => self.cancel(key),
                Some(Post::Ask(ask)) => {
                    self.next += 1;
                    self.waiting.push((RequestId(self.next), ask));
                }
            }
        }
        let alive = |deadline: Option<Time>| deadline.is_none_or(|deadline| now < deadline);
        let awaited = |ask: &Ask| ask.answer_to.as_ref().is_none_or(AnswerTo::is_awaited);
        (self.waiting).retain(|(_, ask)| alive(ask.deadline) && awaited(ask));
        let cancelled = &mut self.cancelled;
        self.open.retain(|open| {
            let keep = alive(open.deadline) && open.answer_to.is_awaited();
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

    /// Hands over the waiting requests of an operation; those that expect an answer stay open.
    pub(crate) fn take(&mut self, operation: usize) -> Vec<(RequestId, Ask)> {
        if self.waiting.is_empty() {
            return Vec::new();
        }
        let mut taken: Vec<_> = self
            .waiting
            .extract_if(.., |(_, ask)| ask.operation == operation)
            .collect();
        self.open.extend(taken.iter_mut().filter_map(|(id, ask)| {
            Some(Open {
                id: *id,
                key: ask.key,
                operation: ask.operation,
                caller: Arc::clone(&ask.caller),
                deadline: ask.deadline,
                answer_to: ask.answer_to.take()?,
            })
        }));
        taken
    }

    /// The taken requests that nobody waits for any more, as of this cycle.
    pub(crate) fn cancelled(&self) -> &[RequestId] {
        &self.cancelled
    }

    /// Sends an answer. One that nobody waits for any more goes nowhere.
    pub(crate) fn answer(
        &mut self,
        to: RequestId,
        result: Result<Arc<dyn Sample>, ServiceFault>,
        leaving: &mut Leaving<'_>,
    ) {
        let Some(index) = self.open.iter().position(|open| open.id == to) else {
            return;
        };
        let open = self.open.remove(index);
        self.send(open, result.map_err(CallError::Fault), leaving);
    }

    fn send(
        &self,
        open: Open,
        result: Result<Arc<dyn Sample>, CallError>,
        leaving: &mut Leaving<'_>,
    ) {
        let operation = self.declaration.operations.get(open.operation);
        leaving.emit(&Event::Answered {
            component: leaving.name,
            service: &self.declaration.name,
            operation: operation.map_or("", |operation| &operation.name),
            caller: &open.caller,
            result: result.as_deref(),
        });
        let number = open.key.number;
        open.answer_to.send(number, result, leaving.outside);
    }

    /// The component begins to run.
    pub(crate) fn open(&self) {
        self.inbox.open.store(true, Ordering::Release);
    }

    /// The component ends running: whoever waits for it learns that nobody is there.
    pub(crate) fn close(&mut self, leaving: &mut Leaving<'_>) {
        self.inbox.open.store(false, Ordering::Release);
        self.refuse(leaving);
    }

    /// Answers everything with [`CallError::Unavailable`].
    pub(crate) fn refuse(&mut self, leaving: &mut Leaving<'_>) {
        self.freeze(leaving.now);
        for operation in 0..self.declaration.operations.len() {
            drop(self.take(operation));
        }
        for open in std::mem::take(&mut self.open) {
            self.send(open, Err(CallError::Unavailable), leaving);
        }
    }
}
