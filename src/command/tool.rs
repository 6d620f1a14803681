//! Whom `--compat` follows.

use clap::ValueEnum;

/// Tools that observably differ from the textbook.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tool {
    /// The reference: AsmetaS and AsmetaV.
    Asmeta,
}
