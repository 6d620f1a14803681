//! Values of `--compat`.

use clap::ValueEnum;

/// Tools that observably differ from the textbook.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tool {
    /// AsmetaS and AsmetaV, the reference tools
    Asmeta,
}
