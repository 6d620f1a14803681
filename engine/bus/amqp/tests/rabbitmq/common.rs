//! What the tests share.

use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_amqp::{AmqpBus, Notice, Settings};
use asmotion_bus::{
    Bus, Link, Notifier, Origin, Overflow, Pattern, Payload, Publisher, Queue, Sending,
    Subscription,
};
use asmotion_datum::{Datum, Schema};

/// Long enough for anything on a loaded machine.
pub const LONG: Duration = Duration::from_secs(30);

pub fn settings(url: &str) -> Settings {
    Settings::parse(url).unwrap()
}

pub fn connect(settings: Settings) -> AmqpBus {
    AmqpBus::connect(settings, LONG).unwrap()
}

/// Settings that give a silent broker up soon.
pub fn quick(url: &str) -> Settings {
    let mut settings = settings(url);
    settings.timing.dead = Duration::from_secs(3);
    settings
}

pub fn is_down(bus: &AmqpBus) -> bool {
    matches!(bus.health().link, Link::Down { .. })
}

/// Settings whose notices are kept.
pub fn noted(url: &str) -> (Settings, Arc<Mutex<Vec<Notice>>>) {
    let notices = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&notices);
    let mut settings = settings(url);
    settings.notices = Arc::new(move |notice| kept.lock().unwrap().push(notice.clone()));
    (settings, notices)
}

pub fn all(size: usize) -> Queue {
    Queue::All {
        size,
        overflow: Overflow::DropNewest,
    }
}

pub fn events() -> Sending {
    Sending::events(NonZeroUsize::new(100_000).unwrap())
}

pub fn subscribe(bus: &dyn Bus, pattern: &str, queue: Queue) -> Subscription {
    bus.subscribe(
        "Tester",
        &Pattern::new(pattern),
        queue,
        Arc::new(Notifier::new()),
    )
    .unwrap()
}

pub fn publisher(bus: &dyn Bus, topic: &str, sending: Sending) -> Box<dyn Publisher> {
    bus.publisher(
        topic,
        &Origin::new("Tester", 1),
        &Schema::opaque("test/Number"),
        sending,
    )
    .unwrap()
}

pub fn number(n: i64) -> Payload {
    Payload::of(Datum::Int(n))
}

/// The numbers that come until nothing has come for a while.
pub fn numbers(subscription: &Subscription, silence: Duration) -> Vec<i64> {
    let next = || subscription.next_within(silence);
    std::iter::from_fn(next)
        .map(|envelope| envelope.payload.to_datum().unwrap().as_int().unwrap())
        .collect()
}

/// Waits until something is so.
#[track_caller]
pub fn eventually(what: &str, mut so: impl FnMut() -> bool) {
    let until = Instant::now() + LONG;
    while !so() {
        assert!(Instant::now() < until, "{what}: not within {LONG:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}
