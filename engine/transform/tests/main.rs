//! Transforms and transformed messages.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs, reason = "tests")]

mod buffer;
mod message;
mod tf2;
