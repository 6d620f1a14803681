//! The terminal monitor: what is known of a running system, how a person looks at it, and how it is drawn.
//!
//! It hears messages and the present time, and asks for neither, but for `screen`: so a test can hold both.

mod board;
mod draw;
mod joints;
mod screen;
#[cfg(test)]
mod tests;
mod view;

pub use board::{Board, Component, Silence, Topic};
pub use draw::draw;
pub(crate) use joints::brief;
pub use screen::show;
pub use view::{Key, View};
