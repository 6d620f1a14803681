//! The messages that have arrived for an input since the cycle before.

use crate::typed_input::TypedInput;
use asmotion_component::{BufferKind, Time};
use asmotion_datum::{Datum, DatumError};
use std::borrow::Cow;

/// The messages of a cycle for an input.
pub(super) struct ArrivedMessages<'a> {
    pub messages: &'a [Datum],
    /// The newest one, if there is a new one.
    pub newest: Option<&'a Datum>,
    pub expiries: &'a [Option<Time>],
    pub queue: BufferKind,
    /// The port at which they arrived; `None` for requests.
    pub typed: Option<&'a TypedInput>,
    pub now: Time,
}

impl<'a> ArrivedMessages<'a> {
    /// Iterates over the messages with their positions: in their order or, where only the newest one counts, from that one back,
    /// because it may not fit, and must not hide one that does.
    pub fn each(&self, only_newest: bool) -> impl Iterator<Item = (usize, &'a Datum)> + use<'a> {
        let last = self.messages.len().saturating_sub(1);
        let newest = self.newest.filter(|_| only_newest);
        let newest = newest.map(|newest| (last, newest));
        let (in_order, older) = match (only_newest, newest) {
            (false, _) => (self.messages, &[][..]),
            (true, Some(_)) => (&[][..], self.messages),
            (true, None) => (&[][..], &[][..]),
        };
        let older = older.iter().enumerate().rev().skip(1);
        newest
            .into_iter()
            .chain(older)
            .chain(in_order.iter().enumerate())
    }

    /// The message as typed readers see it; the port and the error if it does not have the type of the port.
    pub fn fitting<'m>(
        &self,
        message: &'m Datum,
    ) -> Result<Cow<'m, Datum>, (&'a TypedInput, DatumError)> {
        match self.typed {
            Some(typed) => typed.fitting(message).map_err(|error| (typed, error)),
            None => Ok(Cow::Borrowed(message)),
        }
    }
}
