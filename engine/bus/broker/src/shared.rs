//! One broker for a test run: shared by tests that leave it intact, held exclusively by tests that break it.

use std::io::Write;
use std::ops::Deref;
use std::sync::{Once, OnceLock, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use crate::broker::TestBroker;

static BROKER: OnceLock<Option<RwLock<TestBroker>>> = OnceLock::new();
static NOTICE: Once = Once::new();

/// The run's broker, shared and well.
pub struct SharedBroker(RwLockReadGuard<'static, TestBroker>);

/// The run's broker, alone: to be broken. It is mended when this ends.
pub struct ExclusiveBroker(RwLockWriteGuard<'static, TestBroker>);

/// The broker, for a test that does not break it; none where RabbitMQ cannot be had, which is said aloud.
///
/// # Panics
/// If the broker does not start; and, where `CI` is set, if the package is missing.
pub fn calm() -> Option<SharedBroker> {
    let broker = shared()?.read().unwrap_or_else(PoisonError::into_inner);
    Some(SharedBroker(broker))
}

/// The broker, for a test that breaks it; none where RabbitMQ cannot be had, which is said aloud.
///
/// # Panics
/// As [`calm`].
pub fn alone() -> Option<ExclusiveBroker> {
    let broker = shared()?.write().unwrap_or_else(PoisonError::into_inner);
    Some(ExclusiveBroker(broker))
}

#[allow(clippy::panic, reason = "a test without its broker has failed")]
fn shared() -> Option<&'static RwLock<TestBroker>> {
    let start = || {
        if !TestBroker::is_installed() && std::env::var_os("CI").is_none() {
            return None;
        }
        match TestBroker::start() {
            Ok(broker) => Some(RwLock::new(broker)),
            Err(error) => panic!("{error}"),
        }
    };
    let broker = BROKER.get_or_init(start).as_ref();
    if broker.is_none() {
        NOTICE.call_once(notice);
    }
    broker
}

/// Past the test harness, which keeps what passing tests print.
fn notice() {
    let words = "\n*** SKIPPED: the tests on a real broker. Install the package `rabbitmq-server`, or run `./test`.\n\n";
    let _ = std::io::stderr().write_all(words.as_bytes());
}

impl Deref for SharedBroker {
    type Target = TestBroker;

    fn deref(&self) -> &TestBroker {
        &self.0
    }
}

impl Deref for ExclusiveBroker {
    type Target = TestBroker;

    fn deref(&self) -> &TestBroker {
        &self.0
    }
}

#[allow(clippy::panic, reason = "a run without its broker has failed")]
impl Drop for ExclusiveBroker {
    fn drop(&mut self) {
        if let Err(error) = self.0.mend()
            && !std::thread::panicking()
        {
            panic!("the broker could not be mended: {error}");
        }
    }
}
