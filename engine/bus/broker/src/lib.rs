//! A real RabbitMQ broker for tests: a process on the loopback interface that can be made to fail, and ends with the
//! test run.
//!
//! One [`TestBroker`] serves a test run, one [`Vhost`] a test. Ordinary tests share the broker through [`calm`]; a test
//! that breaks it takes it exclusively through [`alone`], and it is restored afterwards. It is Debian's package,
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
