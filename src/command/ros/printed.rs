//! The messages that `asmotion ros echo` prints.

use clap::Args;

/// The messages that are printed.
#[derive(Args)]
pub(super) struct Printed {
    /// Ends after this many messages
    #[arg(long)]
    pub count: Option<u64>,

    /// Ends after this many seconds
    #[arg(long = "for", value_name = "SECONDS", default_value_t = 60)]
    pub limit: u64,

    /// Prints each message as a JSON object on a line
    #[arg(long)]
    pub json: bool,
}
