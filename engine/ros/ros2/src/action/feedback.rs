//! Feedback and status, routed to the goals that they are about.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use asmotion_datum::{Codec, Datum, Schema};

use super::{GoalEvent, GoalId, GoalStatus};
use crate::notice::Waker;
use crate::queue::Queue;
use crate::reactor::{Incoming, Sink};

/// The goals of a client.
#[derive(Default)]
pub(super) struct Router {
    goals: Mutex<BTreeMap<GoalId, Route>>,
    malformed: AtomicU64,
    waker: OnceLock<Waker>,
}

struct Route {
    events: Arc<Queue<GoalEvent>>,
    status: Option<GoalStatus>,
}

impl Router {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<GoalId, Route>> {
        self.goals.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn add(&self, id: GoalId, events: &Arc<Queue<GoalEvent>>) {
        let route = Route {
            events: Arc::clone(events),
            status: None,
        };
        self.lock().insert(id, route);
        if let Some(waker) = self.waker.get() {
            events.set_waker(Arc::clone(waker));
        }
    }

    /// Sets what is called after an event of a goal has been put into its queue; for goals that are added afterwards.
    pub(super) fn set_waker(&self, waker: Waker) {
        self.waker.get_or_init(|| waker);
    }

    pub(super) fn remove(&self, id: GoalId) {
        self.lock().remove(&id);
    }

    pub(super) fn malformed(&self) -> u64 {
        self.malformed.load(Ordering::Relaxed)
    }

    fn decode(&self, incoming: &Incoming, schema: &Schema) -> Option<Datum> {
        let decoded = Codec::Cdr.decode(&incoming.payload.0, schema);
        if decoded.is_err() {
            self.malformed.fetch_add(1, Ordering::Relaxed);
        }
        decoded.ok()
    }
}

/// Reads the id of a goal.
pub(super) fn id(datum: &Datum, path: &str) -> Option<GoalId> {
    let found = datum.get(path)?;
    let Datum::Bytes(bytes) = &*found else {
        return None;
    };
    Some(GoalId(bytes.as_ref().try_into().ok()?))
}

/// Receives feedback.
pub(super) struct Feedback {
    pub schema: Schema,
    pub router: Arc<Router>,
}

impl Sink for Feedback {
    fn message(&mut self, incoming: Incoming) {
        let Some(message) = self.router.decode(&incoming, &self.schema) else {
            return;
        };
        // the topic carries the feedback of all clients
        let goals = self.router.lock();
        let route = id(&message, "goal_id.uuid").and_then(|id| goals.get(&id));
        if let (Some(route), Some(feedback)) = (route, message.get("feedback")) {
            route
                .events
                .push(GoalEvent::Feedback(feedback.into_owned()));
        }
    }

    fn unreadable(&mut self) {
        self.router.malformed.fetch_add(1, Ordering::Relaxed);
    }
}

/// Receives the status of all goals of a server.
pub(super) struct Statuses {
    pub schema: Schema,
    pub router: Arc<Router>,
}

impl Sink for Statuses {
    fn message(&mut self, incoming: Incoming) {
        let Some(message) = self.router.decode(&incoming, &self.schema) else {
            return;
        };
        let Some(list) = message.get("status_list") else {
            return;
        };
        let Datum::List(statuses) = &*list else {
            return;
        };
        let mut goals = self.router.lock();
        for entry in statuses {
            let number = entry.get("status").and_then(|status| status.as_int());
            let id = id(entry, "goal_info.goal_id.uuid");
            let route = id.and_then(|id| goals.get_mut(&id));
            if let (Some(route), Some(number)) = (route, number) {
                let status = GoalStatus::of_number(number);
                if route.status != Some(status) {
                    route.status = Some(status);
                    route.events.push(GoalEvent::Status(status));
                }
            }
        }
    }

    fn unreadable(&mut self) {
        self.router.malformed.fetch_add(1, Ordering::Relaxed);
    }
}
