//! The events of a run, as observers see them.

mod display;
mod owned;

pub(crate) use owned::OwnedEvent;

use std::time::Duration;

use asmotion_component::{CallError, CallId, Denied, Fault, State};
use asmotion_datum::{Datum, DatumError, Sample};
use asmotion_port::Time;

/// Receives every event of a run, in order, and cannot influence the run.
///
/// In simulated time it is called at the point of the event. In a live run, events reach it through a bounded queue, so
/// that it never slows a cycle; events that exceed the queue's capacity are counted in [`Event::Lost`].
pub trait Observer: Send {
    /// Handles one event that happened at `at`.
    fn observe(&mut self, at: Time, event: &Event<'_>);

    /// The reports of components that the observer uses (default: all). Components spare the cost of reports that no observer
    /// uses; it receives the others as well. Asked once, when the observer is added.
    fn reports(&self) -> ReportInterest {
        ReportInterest::All
    }

    /// The observer with another interest in reports, for closures.
    fn using(self, reports: ReportInterest) -> InterestedObserver<Self>
    where
        Self: Sized,
    {
        InterestedObserver {
            observer: self,
            reports,
        }
    }
}

/// An observer with an interest in reports of its own; see [`Observer::using`].
#[derive(Debug, Clone)]
pub struct InterestedObserver<O> {
    observer: O,
    reports: ReportInterest,
}

impl<O: Observer> Observer for InterestedObserver<O> {
    fn observe(&mut self, at: Time, event: &Event<'_>) {
        self.observer.observe(at, event);
    }

    fn reports(&self) -> ReportInterest {
        self.reports
    }
}

/// The kinds of reports ([`Event::Report`]) that an observer uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ReportInterest {
    /// All kinds.
    #[default]
    All,
    /// These kinds.
    Only(&'static [&'static str]),
    /// All kinds but these.
    Except(&'static [&'static str]),
}

impl ReportInterest {
    /// No reports.
    pub const NONE: Self = Self::Only(&[]);

    /// Returns whether reports of this kind are used.
    pub fn includes(self, kind: &str) -> bool {
        match self {
            Self::All => true,
            Self::Only(kinds) => kinds.contains(&kind),
            Self::Except(kinds) => !kinds.contains(&kind),
        }
    }
}

impl<F: FnMut(Time, &Event<'_>) + Send> Observer for F {
    fn observe(&mut self, at: Time, event: &Event<'_>) {
        self(at, event);
    }
}

/// An event of a run. `component` is the name of the component concerned.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// A cycle began.
    Cycle {
        /// Name of the component.
        component: &'a str,
        /// Number of the cycle, from 1.
        number: u64,
    },
    /// A sample left an output port.
    Published {
        /// Name of the writing component.
        component: &'a str,
        /// Name of its output port.
        port: &'a str,
        /// The topic the port publishes to, if any.
        topic: Option<&'a str>,
        /// The sample's number at this port, from 1, without gaps.
        sequence: u64,
        /// The sample as written.
        sample: &'a dyn Sample,
    },
    /// A sample was injected from outside: by an operator, a test or the bus.
    Injected {
        /// The port or topic it was injected into.
        target: &'a str,
        /// Name of the sender, if it came by a bus.
        source: Option<&'a str>,
        /// The sample as injected.
        sample: &'a dyn Sample,
    },
    /// A call left its component.
    Called {
        /// Name of the calling component.
        component: &'a str,
        /// Name of the reference it called through.
        reference: &'a str,
        /// Name of the operation.
        operation: &'a str,
        /// Number of the call at this component.
        call: CallId,
        /// Number of the attempt, from 1; more than 1 after a retry.
        attempt: u32,
        /// The request.
        argument: &'a dyn Sample,
    },
    /// A provider's reply left its component.
    Answered {
        /// Name of the providing component.
        component: &'a str,
        /// Name of its service.
        service: &'a str,
        /// Name of the operation.
        operation: &'a str,
        /// Name of the calling component.
        caller: &'a str,
        /// The response or the error.
        result: Result<&'a dyn Sample, &'a CallError>,
    },
    /// A call ended at the caller: by a reply, a timeout or a cancellation.
    Replied {
        /// Name of the calling component.
        component: &'a str,
        /// Name of the reference it called through.
        reference: &'a str,
        /// Name of the operation.
        operation: &'a str,
        /// Number of the call at this component.
        call: CallId,
        /// The response or the error.
        result: Result<&'a dyn Sample, &'a CallError>,
    },
    /// A component changed its state.
    LifeCycle {
        /// Name of the component.
        component: &'a str,
        /// State before the transition.
        from: State,
        /// State after the transition.
        to: State,
    },
    /// A component failed.
    Fault {
        /// Name of the component.
        component: &'a str,
        /// The fault.
        fault: &'a Fault,
    },
    /// A cycle took longer than its period.
    Overrun {
        /// Name of the component.
        component: &'a str,
        /// Periods missed by this cycle.
        missed: u64,
    },
    /// A cycle took longer than its deadline.
    Late {
        /// Name of the component.
        component: &'a str,
        /// Duration of the cycle.
        took: Duration,
        /// Deadline of the activity.
        deadline: Duration,
    },
    /// The operating system refused a scheduling setting of the component's activity; the component runs without it.
    Denied {
        /// Name of the component.
        component: &'a str,
        /// The refused setting, the reason and a remedy.
        denied: &'a Denied,
    },
    /// A connection dropped a sample because it was full or could not carry the sample, or a service refused a request because
    /// its queue was full.
    Dropped {
        /// Name of the writing component; empty if the writer is outside the system.
        component: &'a str,
        /// Name of the output port, or of the reference.
        port: &'a str,
        /// The connection's reading end, or the service.
        to: &'a str,
        /// Number of samples that this connection has dropped so far, or of requests that the service has refused.
        total: u64,
        /// Reason that the reader cannot read the sample; `None` if the connection was full.
        reason: Option<&'a DatumError>,
    },
    /// A property changed.
    Property {
        /// Name of the component.
        component: &'a str,
        /// Name of the property.
        property: &'a str,
        /// The new value.
        value: &'a Datum,
    },
    /// A component reported something of its own to the observers.
    Report {
        /// Name of the component.
        component: &'a str,
        /// Kind of the report, chosen by the component.
        kind: &'a str,
        /// Content of the report.
        data: &'a Datum,
    },
    /// The observers' queue overflowed, and events were dropped.
    Lost {
        /// Number of events dropped since the last such event.
        count: u64,
    },
}
