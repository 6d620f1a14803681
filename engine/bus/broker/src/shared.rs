//! One broker for a test run: shared by tests that leave it intact, held exclusively by tests that break it.

use std::ops::Deref;
use std::sync::{OnceLock, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use crate::broker::TestBroker;

static BROKER: OnceLock<Option<RwLock<TestBroker>>> = OnceLock::new();

/// Shared access to the test run's broker, which is intact.
pub struct SharedBroker(RwLockReadGuard<'static, TestBroker>);

/// Exclusive access to the test run's broker, which may be made to fail. Repairs it on drop.
pub struct ExclusiveBroker(RwLockWriteGuard<'static, TestBroker>);

/// Returns the broker for a test that leaves it intact. Returns `None` and prints a notice if RabbitMQ is not
/// installed.
///
/// # Panics
/// Panics if the broker does not start or, with `CI` set, if the package is missing.
pub fn calm() -> Option<SharedBroker> {
    let broker = shared()?.read().unwrap_or_else(PoisonError::into_inner);
    Some(SharedBroker(broker))
}

/// Returns the broker for a test that makes it fail. Returns `None` and prints a notice if RabbitMQ is not installed.
///
/// # Panics
/// See [`calm`].
pub fn alone() -> Option<ExclusiveBroker> {
    let broker = shared()?.write().unwrap_or_else(PoisonError::into_inner);
    Some(ExclusiveBroker(broker))
}

#[expect(clippy::panic, reason = "a test without its broker has failed")]
fn shared() -> Option<&'static RwLock<TestBroker>> {
    let start = || {
        if !TestBroker::is_installed() {
            asmotion_skip::BROKER.skip();
            return None;
        }
        match TestBroker::start() {
            Ok(broker) => Some(RwLock::new(broker)),
            Err(error) => panic!("{error}"),
        }
    };
    BROKER.get_or_init(start).as_ref()
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
