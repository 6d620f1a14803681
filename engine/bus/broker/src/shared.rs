//! Two brokers for a test run, started when they are needed: one that is shared by the tests that leave it intact, and one for the
//! tests that break it, one after another. A test that breaks its broker takes a minute, in which the others go on.

use std::ops::Deref;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use crate::broker::TestBroker;

/// The test run's broker that is intact.
pub struct SharedBroker(&'static TestBroker);

/// The test run's broker that may be made to fail. Repairs it on drop.
pub struct ExclusiveBroker(MutexGuard<'static, TestBroker>);

/// Returns the broker for a test that leaves it intact. Returns `None` and prints a notice if RabbitMQ is not
/// installed.
///
/// # Panics
/// Panics if the broker does not start or, with `CI` set, if the package is missing.
pub fn calm() -> Option<SharedBroker> {
    static BROKER: OnceLock<Option<TestBroker>> = OnceLock::new();
    BROKER.get_or_init(start).as_ref().map(SharedBroker)
}

/// Returns the broker for a test that makes it fail. Returns `None` and prints a notice if RabbitMQ is not installed.
///
/// # Panics
/// See [`calm`].
pub fn alone() -> Option<ExclusiveBroker> {
    static BROKER: OnceLock<Option<Mutex<TestBroker>>> = OnceLock::new();
    let broker = BROKER.get_or_init(|| start().map(Mutex::new)).as_ref()?;
    let broker = broker.lock().unwrap_or_else(PoisonError::into_inner);
    Some(ExclusiveBroker(broker))
}

#[expect(clippy::panic, reason = "a test without its broker has failed")]
fn start() -> Option<TestBroker> {
    if !TestBroker::is_installed() {
        asmotion_skip::BROKER.skip();
        return None;
    }
    match TestBroker::start() {
        Ok(broker) => Some(broker),
        Err(error) => panic!("{error}"),
    }
}

impl Deref for SharedBroker {
    type Target = TestBroker;

    fn deref(&self) -> &TestBroker {
        self.0
    }
}

impl Deref for ExclusiveBroker {
    type Target = TestBroker;

    fn deref(&self) -> &TestBroker {
        &self.0
    }
}

#[expect(clippy::panic, reason = "a run without its broker has failed")]
impl Drop for ExclusiveBroker {
    fn drop(&mut self) {
        if let Err(error) = self.0.restore()
            && !std::thread::panicking()
        {
            panic!("the broker could not be restored: {error}");
        }
    }
}
