//! Definitions against independent implementations.
#![allow(clippy::unwrap_used, missing_docs, reason = "tests")]

mod definitions;
mod genpy;
mod hashes;
mod writing;
