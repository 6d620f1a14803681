//! Helpers shared by the tests.

use std::num::NonZeroUsize;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, Once};
use std::time::{Duration, Instant};

use asmotion_amqp::{AmqpBus, AmqpSettings, BusNotice};
use asmotion_bus::{
    Bus, LinkState, Notifier, Overflow, Pattern, Payload, PublishOptions, Publisher, QueuePolicy,
    SenderId, Subscription,
};
use asmotion_datum::{Datum, Schema};

/// Timeout of every wait, long enough for a loaded machine.
pub const LONG: Duration = Duration::from_secs(30);

/// Returns `true` in a process that runs only this test, and starts that process first: a test of what its process uses would otherwise
/// count the other tests.
///
/// # Panics
/// Panics if the test fails there.
pub fn is_own_process(test: &str) -> bool {
    const ALONE: &str = "ASMOTION_TEST_ALONE";
    if std::env::var_os(ALONE).is_some() {
        return true;
    }
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args([test, "--exact", "--nocapture", "--test-threads=1"]);
    let output = command.env(ALONE, "1").output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    println!("{text}{}", String::from_utf8_lossy(&output.stderr));
    // none if the name is that of no test
    assert!(
        output.status.success() && text.contains("running 1 test"),
        "{test} fails alone"
    );
    false
}

pub fn settings(url: &str) -> AmqpSettings {
    AmqpSettings::parse(url).unwrap()
}

pub fn connect(settings: AmqpSettings) -> AmqpBus {
    AmqpBus::connect(settings, LONG).unwrap()
}

/// Settings with which a silent broker is given up after 3 s.
pub fn quick(url: &str) -> AmqpSettings {
    let mut settings = settings(url);
    settings.timing.dead_timeout = Duration::from_secs(3);
    settings
}

pub fn is_down(bus: &AmqpBus) -> bool {
    matches!(bus.health().link, LinkState::Down { .. })
}

/// Settings that collect the bus's notices.
pub fn noted(url: &str) -> (AmqpSettings, Arc<Mutex<Vec<BusNotice>>>) {
    let notices = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&notices);
    let mut settings = settings(url);
    settings.notices = Arc::new(move |notice| kept.lock().unwrap().push(notice.clone()));
    (settings, notices)
}

pub fn all(size: usize) -> QueuePolicy {
    QueuePolicy::All {
        size,
        overflow: Overflow::DropNewest,
    }
}

pub fn events() -> PublishOptions {
    PublishOptions::events(NonZeroUsize::new(100_000).unwrap())
}

pub fn subscribe(bus: &dyn Bus, pattern: &str, queue: QueuePolicy) -> Subscription {
    bus.subscribe(
        "Tester",
        &Pattern::new(pattern),
        queue,
        Arc::new(Notifier::new()),
    )
    .unwrap()
}

pub fn publisher(bus: &dyn Bus, topic: &str, sending: PublishOptions) -> Box<dyn Publisher> {
    bus.publisher(
        topic,
        &SenderId::new("Tester", 1),
        &Schema::opaque("test/Number"),
        sending,
    )
    .unwrap()
}

pub fn number(n: i64) -> Payload {
    Payload::of(Datum::Int(n))
}

/// Counts the panics in the tasks of the AMQP client that serve channels, from the first call on.
pub fn client_panics() -> usize {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    static COUNTED: Once = Once::new();
    COUNTED.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            let file = panic.location().map(std::panic::Location::file);
            if file.is_some_and(|file| file.ends_with("channel/dispatcher.rs")) {
                COUNT.fetch_add(1, Ordering::SeqCst);
            }
            before(panic);
        }));
    });
    COUNT.load(Ordering::SeqCst)
}

/// All numbers received until there has been none for `silence`.
pub fn numbers(subscription: &Subscription, silence: Duration) -> Vec<i64> {
    let next = || subscription.next_within(silence);
    std::iter::from_fn(next)
        .map(|envelope| envelope.payload.to_datum().unwrap().as_int().unwrap())
        .collect()
}

/// Waits until a condition holds.
#[track_caller]
pub fn eventually(what: &str, mut so: impl FnMut() -> bool) {
    let until = Instant::now() + LONG;
    while !so() {
        assert!(Instant::now() < until, "{what}: not within {LONG:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}
