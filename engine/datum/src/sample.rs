//! A message whose type is not known here.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use crate::error::DatumError;
use crate::message::Message;
use crate::value::Datum;

/// Any [`Message`] behind a pointer: queues, recorders and monitors handle it without knowing its type.
pub trait Sample: Any + Debug + Send + Sync {
    /// The type's name, `geometry_msgs/Twist`; empty for a [`Datum`].
    fn type_name(&self) -> &'static str;

    /// The same data without its type.
    fn to_datum(&self) -> Result<Datum, DatumError>;

    /// A shared copy of its own.
    fn to_shared(&self) -> Arc<dyn Sample>;

    /// The message that this one points to, if it is a pointer.
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
    /// The message itself, if it is of this type.
    pub fn downcast_ref<T: Message>(&self) -> Option<&T> {
        (self as &dyn Any).downcast_ref()
    }

    /// The message as a type: itself if it is one, else read from its data.
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
