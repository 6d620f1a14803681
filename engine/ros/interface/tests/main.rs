//! Definitions against independent implementations.

mod definitions;
mod genpy;
mod hashes;
mod writing;
