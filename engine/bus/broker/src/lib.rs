//! A real RabbitMQ broker for tests: a process on the loopback interface that can be made to fail, and ends with the
//! test run.
//!
//! A [`Vhost`] of a [`TestBroker`] serves a test. Ordinary tests share one broker through [`calm`]; a test that breaks its broker
//! takes another one exclusively through [`alone`], and it is restored afterwards. They are Debian's package,
//! started by its inner script with its own epmd; services of the machine are not affected.

mod broker;
mod certificates;
mod control;
mod files;
mod line;
mod ports;
mod process;
mod shared;
mod vhost;

pub use broker::{BrokerError, TestBroker};
pub use certificates::write_certificates;
pub use line::Line;
pub use shared::{ExclusiveBroker, SharedBroker, alone, calm};
pub use vhost::Vhost;
