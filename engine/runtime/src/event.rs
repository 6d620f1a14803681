//! What happens in a run, as observers see it.

mod display;
mod owned;

pub(crate) use owned::OwnedEvent;

use std::time::Duration;

use asmotion_component::{CallError, CallId, Denied, Fault, State};
use asmotion_datum::{Datum, DatumError, Sample};
use asmotion_port::Time;

/// Sees everything that happens, in order; changes nothing.
///
/// In simulated time it is called where the event happens. Live, events reach it through a bounded queue, so that
/// it never slows a cycle; what the queue could not hold is counted in [`Event::Lost`].
pub trait Observer: Send {
    /// One event.
    fn observe(&mut self, at: Time, event: &Event<'_>);
}

impl<F: FnMut(Time, &Event<'_>) + Send> Observer for F {
    fn observe(&mut self, at: Time, event: &Event<'_>) {
        self(at, event);
    }
}

/// Something that happened. `component` is the name of the one it happened to.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// A cycle began.
    Cycle {
        /// Whose.
        component: &'a str,
        /// Its number, from 1.
        number: u64,
    },
    /// A sample left an output port.
    Published {
        /// The writer.
        component: &'a str,
        /// Its port.
        port: &'a str,
        /// The topic the port publishes to, if any.
        topic: Option<&'a str>,
        /// The sample's number at this port, from 1, without gaps.
        sequence: u64,
        /// The sample.
        sample: &'a dyn Sample,
    },
    /// A sample came in from outside: an operator, a test, the bus.
    Injected {
        /// The port or topic it was given to.
        place: &'a str,
        /// The sample.
        sample: &'a dyn Sample,
    },
    /// A call left its component.
    Called {
        /// The caller.
        component: &'a str,
        /// Its reference.
        reference: &'a str,
        /// The operation.
        operation: &'a str,
        /// The call.
        call: CallId,
        /// From 1; more after a retry.
        attempt: u32,
        /// What was asked.
        argument: &'a dyn Sample,
    },
    /// A provider's answer left its component.
    Answered {
        /// The provider.
        component: &'a str,
        /// Its service.
        service: &'a str,
        /// The operation.
        operation: &'a str,
        /// The caller.
        caller: &'a str,
        /// The answer.
        result: Result<&'a dyn Sample, &'a CallError>,
    },
    /// A call came to its end at the caller: an answer, a timeout, a cancellation.
    Replied {
        /// The caller.
        component: &'a str,
        /// Its reference.
        reference: &'a str,
        /// The operation.
        operation: &'a str,
        /// The call.
        call: CallId,
        /// How it ended.
        result: Result<&'a dyn Sample, &'a CallError>,
    },
    /// A component changed its state.
    LifeCycle {
        /// Which.
        component: &'a str,
        /// Before.
        from: State,
        /// After.
        to: State,
    },
    /// A component failed.
    Fault {
        /// Which.
        component: &'a str,
        /// Why.
        fault: &'a Fault,
    },
    /// A cycle took longer than its period.
    Overrun {
        /// Whose.
        component: &'a str,
        /// Periods missed by this cycle.
        missed: u64,
    },
    /// A cycle took longer than its deadline.
    Late {
        /// Whose.
        component: &'a str,
        /// How long it took.
        took: Duration,
        /// How long it may take.
        deadline: Duration,
    },
    /// The system does not permit what the component's activity wants; it runs without.
    Denied {
        /// Whose activity.
        component: &'a str,
        /// What, why, and what to do about it.
        denied: &'a Denied,
    },
    /// A connection was full, or could not carry the sample.
    Dropped {
        /// The writer; empty for one outside.
        component: &'a str,
        /// Its port.
        port: &'a str,
        /// The connection's other end.
        to: &'a str,
        /// All that this connection has dropped so far.
        total: u64,
        /// Why the reader cannot read the sample; absent if the connection was full.
        reason: Option<&'a DatumError>,
    },
    /// Properties changed, all at once.
    Property {
        /// Whose.
        component: &'a str,
        /// Which.
        property: &'a str,
        /// To what.
        value: &'a Datum,
    },
    /// A component tells its observers something.
    Report {
        /// Who.
        component: &'a str,
        /// What kind of report it is.
        kind: &'a str,
        /// What it says.
        what: &'a Datum,
    },
    /// Events that the observers' queue could not hold.
    Lost {
        /// How many since the last such event.
        count: u64,
    },
}
