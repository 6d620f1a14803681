//! The command line of asmotion: one file for each command, and their shared parts.
//!
//! This is the only crate that prints. [`mission`] assembles and runs a composite; [`asmotion_story`] tells its events, [`trace`]
//! writes them to a file.

mod app;
mod bridges;
mod broker;
mod build;
#[cfg(feature = "ros")]
mod bus_places;
pub mod codes;
mod command;
pub mod contract;
mod describe;
mod diff;
mod exit;
#[allow(dead_code, reason = "a feature that this build has needs no stand-in")]
mod feature;
mod files;
mod gateway;
#[cfg(any(feature = "amqp", feature = "tui"))]
mod inspection;
pub mod mission;
mod numbers;
mod output_files;
mod output_queue;
mod own_program;
mod paths;
mod programs;
mod prompt;
#[cfg(feature = "ros")]
mod ros_desk;
#[cfg(feature = "ros2")]
mod ros_domain;
#[cfg(feature = "ros")]
mod ros_host;
mod show;
mod supervisor;
mod table;
mod terminal;
#[cfg(feature = "tui")]
pub mod top;
pub mod trace;
mod transport;
mod verification;
mod xml;

pub use app::{App, AppCommand};
pub use broker::{AddedBroker, BrokerSettings};
pub use build::Build;
/// The library that parses command lines, for [`AppCommand`]s.
pub use clap;
pub use command::BLOCKED_CORRIDOR;
pub use exit::Exit;
pub use files::DiskLoader;
pub use transport::{BrokerAccess, BrokerAddress, ConnectTransport};
