//! Terminal monitor: model of a running system, state of the view, and drawing.
//!
//! Messages and the current time are passed in, except in `screen`, so that tests control both.

mod board;
mod draw;
mod fold;
mod list_table;
mod screen;
#[cfg(test)]
mod tests;
mod view;

pub use board::{Board, BoardComponent, BoardTopic, Silence};
pub use draw::draw;
pub use screen::show;
pub use view::{Key, View};
