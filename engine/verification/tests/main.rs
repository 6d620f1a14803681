//! Specifications of composites with their environments.

mod composites;
mod support;
