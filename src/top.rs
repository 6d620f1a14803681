//! Terminal monitor: model of a running system, state of the view, and drawing.
//!
//! Messages and the current time are passed in, except in `screen`, so that tests control both.

mod board;
mod draw;
mod joints;
mod screen;
#[cfg(test)]
mod tests;
mod view;

pub use board::{Board, Component, Silence, Topic};
pub use draw::draw;
pub use screen::show;
pub use view::{Key, View};
