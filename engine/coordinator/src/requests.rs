//! Requests as inputs: a monitored function may be bound to an operation that the component provides.
//!
//! A request gets its reply after the step that reads it or, if a call is made on its behalf, when that call ends.

use crate::bind_error::BindError;
use crate::binding::{Binding, BoundOperation, Interfaces, Source};
use asmotion_component::{Cycle, Dynamic, Interface, Provided, RequestId, ServiceFault};
use asmotion_datum::Datum;

/// The operations that monitored functions are bound to.
#[derive(Default)]
pub(crate) struct Requests {
    pub served: Vec<RequestInput>,
}

pub(crate) struct RequestInput {
    pub operation: BoundOperation,
    pub handle: Provided<Dynamic>,
    /// A call made on the request's behalf supplies the reply.
    is_forwarded: bool,
    /// Requests of this cycle.
    received: Vec<Datum>,
    /// The newest request so far.
    pub last: Option<Datum>,
    /// Requests without a reply.
    pub open: Vec<RequestId>,
}

/// A caller waiting for the outcome of the call made on its behalf.
#[derive(Clone, Copy)]
pub(crate) struct WaitingCaller {
    pub handle: Provided<Dynamic>,
    /// Position of the operation among the provided ones.
    pub served: usize,
    pub request: RequestId,
}

impl Requests {
    /// Declares the operations that monitored functions are bound to.
    pub fn declare(
        binding: &Binding,
        interfaces: &Interfaces,
        interface: &mut Interface,
    ) -> Result<Self, BindError> {
        let mut requests = Self::default();
        for monitored in &binding.monitored {
            let Source::Request(bound) = &monitored.from else {
                continue;
            };
            if requests.position(bound).is_some() {
                continue;
            }
            let BoundOperation { service, operation } = bound;
            let mut services = interfaces.services.iter();
            let known = services.find(|(name, _)| name == service);
            let (_, kind) = known.ok_or_else(|| BindError::UnknownOperation(bound.clone()))?;
            let doc = "read by the specification";
            requests.served.push(RequestInput {
                operation: bound.clone(),
                handle: interface.serve_of(service, kind, operation, doc),
                is_forwarded: binding
                    .calls()
                    .any(|call| call.reply.as_ref() == Some(service)),
                received: Vec::new(),
                last: None,
                open: Vec::new(),
            });
        }
        Ok(requests)
    }

    /// Position of an operation.
    pub fn position(&self, operation: &BoundOperation) -> Option<usize> {
        let mut served = self.served.iter();
        served.position(|served| served.operation == *operation)
    }

    /// The requests of this cycle for an operation.
    pub fn received(&self, position: usize) -> &[Datum] {
        self.served
            .get(position)
            .map_or(&[], |served| &served.received)
    }

    /// The operations with requests in this cycle.
    pub fn with_requests(&self) -> impl Iterator<Item = &BoundOperation> {
        let served = self.served.iter();
        served
            .filter(|served| !served.received.is_empty())
            .map(|served| &served.operation)
    }

    /// The newest request of a service.
    pub fn last(&self, service: &str) -> Option<&Datum> {
        let mut served = self.served.iter();
        served
            .find(|served| served.operation.service == service)?
            .last
            .as_ref()
    }

    /// Receives the requests of the cycle.
    pub fn receive(&mut self, cycle: &mut Cycle<'_>) {
        for served in &mut self.served {
            served.received.clear();
            for request in cycle.requests(served.handle) {
                served.last = Some(request.argument.clone());
                served.received.push(request.argument);
                if request.deadline.is_some() {
                    served.open.push(request.id);
                }
            }
        }
    }

    /// Takes the newest open request of a service, to reply to it when a call ends. The other open requests are
    /// superseded: a step makes one call, with the newest request's content.
    pub fn take_newest(&mut self, service: &str, cycle: &mut Cycle<'_>) -> Option<WaitingCaller> {
        let mut served = self.served.iter_mut().enumerate();
        let (position, served) = served.find(|(_, served)| served.operation.service == service)?;
        let last = served.open.pop()?;
        for request in served.open.drain(..) {
            cycle.reply(served.handle, request, Err(superseded_fault()));
        }
        Some(WaitingCaller {
            handle: served.handle,
            served: position,
            request: last,
        })
    }

    /// Replies to all requests that no call is made for. If a call was expected, the reply is a fault.
    pub fn reply_to_open(&mut self, cycle: &mut Cycle<'_>) {
        for served in &mut self.served {
            for request in served.open.drain(..) {
                let answer = if served.is_forwarded {
                    Err(ServiceFault::new(
                        "NOT_NOW",
                        "the specification does not take it in its present state",
                    ))
                } else {
                    Ok(Datum::Record(Vec::new()))
                };
                cycle.reply(served.handle, request, answer);
            }
        }
    }
}

/// The fault for a request whose call the specification cancelled.
pub(crate) fn cancelled_fault() -> ServiceFault {
    ServiceFault::new(
        "CANCELLED",
        "the specification cancelled the call made for this request",
    )
}

/// The fault for a request that was replaced by another one.
pub(crate) fn superseded_fault() -> ServiceFault {
    ServiceFault::new(
        "SUPERSEDED",
        "another request came before this one was done",
    )
}
