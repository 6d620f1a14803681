//! How other threads wake a bridge.

use std::sync::Arc;

/// Requests a cycle of the bridge, from any thread.
pub type Wake = Arc<dyn Fn() + Send + Sync>;
