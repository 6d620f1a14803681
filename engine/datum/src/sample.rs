//! A message without its static type.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use crate::error::DatumError;
use crate::message::Message;
use crate::value::Datum;

/// Any [`Message`] behind a pointer, for code that handles messages of all types: queues, recorders, monitors.
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
    fn behind(&self) -> Option<Arc<dyn Sample>>;
}

impl<T: Message> Sample for T {
    fn type_name(&self) -> &'static str {
        T::NAME
    }

    fn to_datum(&self) -> Result<Datum, DatumError> {
        Datum::of(self)
    }

    fn to_shared(&self) -> Arc<dyn Sample> {
        Arc::new(self.clone())
    }

    fn behind(&self) -> Option<Arc<dyn Sample>> {
        Message::behind(self)
    }
}

impl dyn Sample {
    /// The message itself, if it has this type.
    pub fn downcast_ref<T: Message>(&self) -> Option<&T> {
        (self as &dyn Any).downcast_ref()
    }

    /// Converts the message to type `T`: without copying if it has that type, otherwise through its datum.
    ///
    /// # Errors
    /// The sample has another type, and its data does not fit `T`; the error names the place.
    pub fn read<T: Message>(self: Arc<Self>) -> Result<T, DatumError> {
        let sample = Sample::behind(&*self).unwrap_or(self);
        if let Some(pointer) = T::pointing_to(&sample) {
            return Ok(pointer);
        }
        let any: Arc<dyn Any + Send + Sync> = sample.clone();
        match any.downcast::<T>() {
            Ok(same) => {
                drop(sample);
                Ok(Arc::unwrap_or_clone(same))
            }
            Err(_) => match sample.downcast_ref::<Datum>() {
                Some(datum) => datum.to(),
                None => sample.to_datum()?.to(),
            },
        }
    }
}
