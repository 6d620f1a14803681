//! The language in the whole program: all codes, both back ends, the reference's traces, and the specifications shipped. The
//! tests of single programs are those of `asm-lang`.

#[cfg(feature = "native")]
mod back_ends;
mod codes;
mod conformance;
mod specifications;
mod support;

use support::{open, opened, programs, said};
