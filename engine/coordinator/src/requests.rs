//! Requests as inputs: a monitored function may be bound to an operation that the component serves.
//!
//! A request is answered when the step has heard it; or, where a call is made for it, as that call is answered.

use crate::binding::{Binding, Interfaces, Source};
use crate::coordinator::{BindError, calls};
use asmotion_component::{Cycle, Dynamic, Interface, Provided, RequestId, ServiceFault};
use asmotion_datum::Datum;

/// The operations that monitored functions are bound to.
#[derive(Default)]
pub(crate) struct Requests {
    pub served: Vec<RequestInput>,
}

pub(crate) struct RequestInput {
    service: String,
    operation: String,
    pub handle: Provided<Dynamic>,
    /// Whether a call answers for it.
    forwards: bool,
    /// What was asked in this cycle.
    came: Vec<Datum>,
    /// What was asked last.
    pub last: Option<Datum>,
    /// Who waits for an answer.
    pub open: Vec<RequestId>,
}

/// A caller that waits for the end of the call that is made for it.
#[derive(Clone, Copy)]
pub(crate) struct WaitingCaller {
    pub handle: Provided<Dynamic>,
    /// Position of the operation among the served ones.
    pub served: usize,
    pub request: RequestId,
}

impl Requests {
    /// Declares the operations.
    pub fn declare(
        binding: &Binding,
        interfaces: &Interfaces,
        interface: &mut Interface,
    ) -> Result<Self, BindError> {
        let mut requests = Self::default();
        for monitored in &binding.monitored {
            let Source::Request { service, operation } = &monitored.from else {
                continue;
            };
            if requests.position(service, operation).is_some() {
                continue;
            }
            let mut services = interfaces.services.iter();
            let known = services.find(|(name, _)| name == service);
            let (_, kind) = known.ok_or_else(|| BindError::UnknownOperation {
                reference: service.clone(),
                operation: operation.clone(),
            })?;
            let doc = "heard by the specification";
            requests.served.push(RequestInput {
                service: service.clone(),
                operation: operation.clone(),
                handle: interface.serve_of(service, kind, operation, doc),
                forwards: calls(binding).any(|call| call.reply.as_ref() == Some(service)),
                came: Vec::new(),
                last: None,
                open: Vec::new(),
            });
        }
        Ok(requests)
    }

    /// The place of an operation.
    pub fn position(&self, service: &str, operation: &str) -> Option<usize> {
        let is = |served: &RequestInput| served.service == service && served.operation == operation;
        self.served.iter().position(is)
    }

    /// What was asked of an operation in this cycle.
    pub fn came(&self, position: usize) -> &[Datum] {
        self.served.get(position).map_or(&[], |served| &served.came)
    }

    /// What was asked of a service last.
    pub fn last(&self, service: &str) -> Option<&Datum> {
        let mut served = self.served.iter();
        served
            .find(|served| served.service == service)?
            .last
            .as_ref()
    }

    /// Takes in the requests of the cycle.
    pub fn receive(&mut self, cycle: &mut Cycle<'_>) {
        for served in &mut self.served {
            served.came.clear();
            for request in cycle.requests(served.handle) {
                served.last = Some(request.argument.clone());
                served.came.push(request.argument);
                if request.deadline.is_some() {
                    served.open.push(request.id);
                }
            }
        }
    }

    /// Who asked a service in this cycle, and is now answered for by a call. A step makes one call for all, with what
    /// was asked last: of several only the last one is meant.
    pub fn claim(&mut self, service: &str, cycle: &mut Cycle<'_>) -> Option<WaitingCaller> {
        let mut served = self.served.iter_mut().enumerate();
        let (position, served) = served.find(|(_, served)| served.service == service)?;
        let last = served.open.pop()?;
        for request in served.open.drain(..) {
            cycle.reply(served.handle, request, Err(superseded()));
        }
        Some(WaitingCaller {
            handle: served.handle,
            served: position,
            request: last,
        })
    }

    /// Answers everybody whom no call answers for: the step has heard them, or has not listened.
    pub fn settle(&mut self, cycle: &mut Cycle<'_>) {
        for served in &mut self.served {
            for request in served.open.drain(..) {
                let answer = match served.forwards {
                    false => Ok(Datum::Record(Vec::new())),
                    true => Err(ServiceFault::new(
                        "NOT_NOW",
                        "the specification does not take it in its present state",
                    )),
                };
                cycle.reply(served.handle, request, answer);
            }
        }
    }
}

/// What a caller hears whose question another one has replaced.
pub(crate) fn superseded() -> ServiceFault {
    ServiceFault::new(
        "SUPERSEDED",
        "another request came before this one was done",
    )
}
