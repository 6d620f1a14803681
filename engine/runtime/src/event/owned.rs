//! Events that own their contents, to cross from a component's thread to the observers' queue.

use std::sync::Arc;
use std::time::Duration;

use asmotion_component::{CallError, CallId, Denied, Fault, State};
use asmotion_datum::{Datum, DatumError, Sample};

use super::Event;

/// An [`Event`] that owns what the original borrows.
pub(crate) enum OwnedEvent {
    Cycle {
        component: String,
        number: u64,
    },
    Published {
        component: String,
        port: String,
        topic: Option<String>,
        sequence: u64,
        sample: Arc<dyn Sample>,
    },
    Injected {
        target: String,
        source: Option<String>,
        sample: Arc<dyn Sample>,
    },
    Called {
        component: String,
        reference: String,
        operation: String,
        call: CallId,
        attempt: u32,
        argument: Arc<dyn Sample>,
    },
    Answered {
        component: String,
        service: String,
        operation: String,
        caller: String,
        result: Result<Arc<dyn Sample>, CallError>,
    },
    Replied {
        component: String,
        reference: String,
        operation: String,
        call: CallId,
        result: Result<Arc<dyn Sample>, CallError>,
    },
    LifeCycle {
        component: String,
        from: State,
        to: State,
    },
    Fault {
        component: String,
        fault: Fault,
    },
    Overrun {
        component: String,
        missed: u64,
    },
    Late {
        component: String,
        took: Duration,
        deadline: Duration,
    },
    Denied {
        component: String,
        denied: Denied,
    },
    Dropped {
        component: String,
        port: String,
        to: String,
        total: u64,
        reason: Option<DatumError>,
    },
    Property {
        component: String,
        property: String,
        value: Datum,
    },
    Report {
        component: String,
        kind: String,
        data: Datum,
    },
    Lost {
        count: u64,
    },
}

impl OwnedEvent {
    pub(crate) fn of(event: &Event<'_>) -> Self {
        match *event {
            Event::Cycle { component, number } => Self::Cycle {
                component: component.into(),
                number,
            },
            Event::Published {
                component,
                port,
                topic,
                sequence,
                sample,
            } => Self::Published {
                component: component.into(),
                port: port.into(),
                topic: topic.map(Into::into),
                sequence,
                sample: sample.to_shared(),
            },
            Event::Injected {
                target: place,
                source,
                sample,
            } => Self::Injected {
                target: place.into(),
                source: source.map(Into::into),
                sample: sample.to_shared(),
            },
            Event::Called {
                component,
                reference,
                operation,
                call,
                attempt,
                argument,
            } => Self::Called {
                component: component.into(),
                reference: reference.into(),
                operation: operation.into(),
                call,
                attempt,
                argument: argument.to_shared(),
            },
            Event::Answered {
                component,
                service,
                operation,
                caller,
                result,
            } => Self::Answered {
                component: component.into(),
                service: service.into(),
                operation: operation.into(),
                caller: caller.into(),
                result: owned_result(result),
            },
            Event::Replied {
                component,
                reference,
                operation,
                call,
                result,
            } => Self::Replied {
                component: component.into(),
                reference: reference.into(),
                operation: operation.into(),
                call,
                result: owned_result(result),
            },
            Event::LifeCycle {
                component,
                from,
                to,
            } => Self::LifeCycle {
                component: component.into(),
                from,
                to,
            },
            Event::Fault { component, fault } => Self::Fault {
                component: component.into(),
                fault: fault.clone(),
            },
            Event::Overrun { component, missed } => Self::Overrun {
                component: component.into(),
                missed,
            },
            Event::Late {
                component,
                took,
                deadline,
            } => Self::Late {
                component: component.to_owned(),
                took,
                deadline,
            },
            Event::Denied { component, denied } => Self::Denied {
                component: component.into(),
                denied: denied.clone(),
            },
            Event::Dropped {
                component,
                port,
                to,
                total,
                reason,
            } => Self::Dropped {
                component: component.into(),
                port: port.into(),
                to: to.into(),
                total,
                reason: reason.cloned(),
            },
            Event::Property {
                component,
                property,
                value,
            } => Self::Property {
                component: component.into(),
                property: property.into(),
                value: value.clone(),
            },
            Event::Report {
                component,
                kind,
                data: what,
            } => Self::Report {
                component: component.into(),
                kind: kind.into(),
                data: what.clone(),
            },
            Event::Lost { count } => Self::Lost { count },
        }
    }

    /// The event as observers receive it.
    pub(crate) fn borrow(&self) -> Event<'_> {
        match self {
            Self::Cycle { component, number } => Event::Cycle {
                component,
                number: *number,
            },
            Self::Published {
                component,
                port,
                topic,
                sequence,
                sample,
            } => Event::Published {
                component,
                port,
                topic: topic.as_deref(),
                sequence: *sequence,
                sample: &**sample,
            },
            Self::Injected {
                target: place,
                source,
                sample,
            } => Event::Injected {
                target: place,
                source: source.as_deref(),
                sample: &**sample,
            },
            Self::Called {
                component,
                reference,
                operation,
                call,
                attempt,
                argument,
            } => Event::Called {
                component,
                reference,
                operation,
                call: *call,
                attempt: *attempt,
                argument: &**argument,
            },
            Self::Answered {
                component,
                service,
                operation,
                caller,
                result,
            } => Event::Answered {
                component,
                service,
                operation,
                caller,
                result: result.as_deref(),
            },
            Self::Replied {
                component,
                reference,
                operation,
                call,
                result,
            } => Event::Replied {
                component,
                reference,
                operation,
                call: *call,
                result: result.as_deref(),
            },
            Self::LifeCycle {
                component,
                from,
                to,
            } => Event::LifeCycle {
                component,
                from: *from,
                to: *to,
            },
            Self::Fault { component, fault } => Event::Fault { component, fault },
            Self::Overrun { component, missed } => Event::Overrun {
                component,
                missed: *missed,
            },
            Self::Late {
                component,
                took,
                deadline,
            } => Event::Late {
                component,
                took: *took,
                deadline: *deadline,
            },
            Self::Denied { component, denied } => Event::Denied { component, denied },
            Self::Dropped {
                component,
                port,
                to,
                total,
                reason,
            } => Event::Dropped {
                component,
                port,
                to,
                total: *total,
                reason: reason.as_ref(),
            },
            Self::Property {
                component,
                property,
                value,
            } => Event::Property {
                component,
                property,
                value,
            },
            Self::Report {
                component,
                kind,
                data: what,
            } => Event::Report {
                component,
                kind,
                data: what,
            },
            Self::Lost { count } => Event::Lost { count: *count },
        }
    }
}

fn owned_result(result: Result<&dyn Sample, &CallError>) -> Result<Arc<dyn Sample>, CallError> {
    result
        .map(|sample| sample.to_shared())
        .map_err(Clone::clone)
}
