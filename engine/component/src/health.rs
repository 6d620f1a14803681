//! The health of the bus as a topic, for those inside who must act when it is gone.

use std::sync::Arc;

use asmotion_bus::{Health, Link};
use asmotion_datum::Sample;

use crate::Time;
use crate::door::{Doors, Place};
use crate::outside::Outside;
use crate::system::Topic;

/// The topic on which every system tells its own components how its bus is: a [`BusHealth`] at the start, and one at
/// every change. It stays inside.
pub const HEALTH_TOPIC: &str = "bus";

asmotion_datum::message! {
    /// How the bus of a system is.
    pub struct BusHealth = "bus/Health" {
        /// `UP`; `BLOCKED`: the broker takes nothing; `DOWN`: nothing goes out or comes in
        pub state: String = BusHealth::UP.to_owned(),
        /// why it is not up
        pub reason: String,
        /// since when, in nanoseconds of the run
        pub since: i64,
    }
}

impl BusHealth {
    /// Messages go through.
    pub const UP: &'static str = "UP";
    /// The broker takes nothing.
    pub const BLOCKED: &'static str = "BLOCKED";
    /// Nothing goes out or comes in.
    pub const DOWN: &'static str = "DOWN";

    fn of(link: &Link, since: Time) -> Self {
        let (state, reason) = match link {
            Link::Up => (Self::UP, ""),
            Link::Blocked { reason } => (Self::BLOCKED, &**reason),
            Link::Down { reason } => (Self::DOWN, &**reason),
        };
        Self {
            state: state.to_owned(),
            reason: reason.to_owned(),
            since: since.nanos(),
        }
    }
}

/// Tells a system how its bus is.
pub(crate) struct HealthTeller {
    /// Where those who want to know are, if any.
    place: Option<Place>,
    told: Option<Health>,
}

impl HealthTeller {
    pub(crate) fn new(topics: &[Topic]) -> Self {
        let is_heard = |topic: &Topic| topic.name == HEALTH_TOPIC && !topic.subscribers.is_empty();
        let place = topics.iter().position(is_heard);
        Self {
            place: place.map(Place::Topic),
            told: None,
        }
    }

    /// Tells what has changed.
    pub(crate) fn tell(
        &mut self,
        health: impl FnOnce() -> Health,
        doors: &mut Doors,
        now: Time,
        outside: &mut dyn Outside,
    ) {
        let Some(place) = self.place else {
            return;
        };
        let health = health();
        if self.told.as_ref() == Some(&health) {
            return;
        }
        let sample: Arc<dyn Sample> = Arc::new(BusHealth::of(&health.link, now));
        doors.give(place, &sample, now, outside);
        self.told = Some(health);
    }
}

/// Tells a system that has no bus, and so cannot lose it.
pub(crate) fn tell_alone(
    topics: &[Topic],
    doors: &mut Doors,
    now: Time,
    outside: &mut dyn Outside,
) {
    HealthTeller::new(topics).tell(|| Health::now(Link::Up), doors, now, outside);
}
