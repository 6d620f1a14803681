//! Conformance of components to their protocols: whether what a component was observed to do is what its protocol allows.
//!
//! [`ProtocolAcceptor`] follows one component, cycle by cycle; [`ProtocolObserver`] observes a run and follows all components of
//! a composite that have a protocol.

mod acceptor;
mod choices;
mod events;
mod observed;
mod observer;

pub use acceptor::ProtocolAcceptor;
pub use events::{EventSuccession, PossibleEvents, PrecedingEvent, SentEvent};
pub use observed::{MessageEnd, ObservedCycle, ObservedMessage, ProtocolDeviation};
pub use observer::{ComponentConformance, ProtocolObserver};
