//! One broker for a test run: shared by those who leave it alone, held alone by those who break it.

use std::io::Write;
use std::ops::Deref;
use std::sync::{Once, OnceLock, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use crate::Broker;

static BROKER: OnceLock<Option<RwLock<Broker>>> = OnceLock::new();
static NOTICE: Once = Once::new();

/// The run's broker, shared and well.
pub struct Calm(RwLockReadGuard<'static, Broker>);

/// The run's broker, alone: to be broken. It is mended when this ends.
pub struct Alone(RwLockWriteGuard<'static, Broker>);

/// The broker, for a test that does not break it; none where RabbitMQ cannot be had, which is said aloud.
///
/// # Panics
/// If the broker does not start; and, where `CI` is set, if the package is missing.
pub fn calm() -> Option<Calm> {
    let broker = shared()?.read().unwrap_or_else(PoisonError::into_inner);
    Some(Calm(broker))
}

/// The broker, for a test that breaks it; none where RabbitMQ cannot be had, which is said aloud.
///
/// # Panics
/// As [`calm`] does.
pub fn alone() -> Option<Alone> {
    let broker = shared()?.write().unwrap_or_else(PoisonError::into_inner);
    Some(Alone(broker))
}

#[allow(clippy::panic, reason = "a test without its broker has failed")]
fn shared() -> Option<&'static RwLock<Broker>> {
    let start = || {
        if !Broker::is_installed() && std::env::var_os("CI").is_none() {
            return None;
        }
        match Broker::start() {
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

impl Deref for Calm {
    type Target = Broker;

    fn deref(&self) -> &Broker {
        &self.0
    }
}

impl Deref for Alone {
    type Target = Broker;

    fn deref(&self) -> &Broker {
        &self.0
    }
}

#[allow(clippy::panic, reason = "a run without its broker has failed")]
impl Drop for Alone {
    fn drop(&mut self) {
        if let Err(error) = self.0.mend()
            && !std::thread::panicking()
        {
            panic!("the broker could not be mended: {error}");
        }
    }
}
