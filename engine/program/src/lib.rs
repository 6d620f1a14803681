//! Components in other programs, in any language.
//!
//! A [`ProgramComponent`] starts a program and drives its life cycle and cycles over a Unix domain socket, with one request
//! and one reply at a time; `docs/program-protocol.md` specifies the messages. The program computes. Ports, connections,
//! services, deadlines, time and life cycle stay in this process, so the rest of a system sees a component like any other.
//!
//! [`ask`] starts a program for the checks of a composite, reads its declaration and ends it.

mod component;
mod connection;
mod declaration;
mod error;
mod frame;
mod log;
mod memory;
mod parent_death;
mod process;
mod reply;
mod request;
mod waiting;
mod watcher;

pub use component::ProgramComponent;
pub use declaration::{ProgramDeclaration, ask};
pub use error::ProgramError;
pub use process::ProgramCommand;
