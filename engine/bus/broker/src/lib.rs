//! A real RabbitMQ for tests: our own process on loopback, broken on demand, gone when the test run is.
//!
//! One [`TestBroker`] serves a test run, one [`Vhost`] a test. Ordinary tests share the broker through [`calm`]; a
//! test that breaks it takes it exclusively through [`alone`], and it is restored afterwards. It is Debian's package,
//! started by its inner script with its own epmd: no service of the machine is used or touched.

mod broker;
mod control;
mod files;
mod process;
mod shared;
mod vhost;

pub use broker::{BrokerError, TestBroker};
pub use shared::{ExclusiveBroker, SharedBroker, alone, calm};
pub use vhost::Vhost;
