//! A message without its static type.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use crate::error::DatumError;
use crate::value::Datum;

/// Any [`Message`](crate::Message) behind a pointer, for code that handles messages of all types: queues, recorders,
/// monitors.
pub trait Sample: Any + Debug + Send + Sync {
    /// The type's name, for example `geometry_msgs/Twist`; empty for a [`Datum`].
    fn type_name(&self) -> &'static str;

    /// Converts the message to a datum.
    ///
    /// # Errors
    /// The content has no form as a datum: an integer beyond 64 bits, or a map whose keys are not text.
    fn to_datum(&self) -> Result<Datum, DatumError>;

    /// Clones the message into a shared pointer.
    fn to_shared(&self) -> Arc<dyn Sample>;

    /// The message that this one points to; `None` unless it is a pointer.
    fn pointee(&self) -> Option<Arc<dyn Sample>>;
}
