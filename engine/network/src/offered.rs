//! Services that other processes call: their requests go into the component's queue like local ones.

use std::sync::Arc;
use std::time::Instant;

use asmotion_bus::{BusError, IncomingCall, Payload, Refusal, ServedAddress};
use asmotion_component::CallError;
use asmotion_datum::{Sample, Schema};
use asmotion_port::Time;
use asmotion_runtime::{
    CallKey, Effects, Event, OuterService, RemoteCaller, ReplyTo, RequestQueue, ServiceRequest,
};

use crate::failure::call_failure;
use crate::identity::BusIdentity;
use crate::remote_ends::address;

/// Capacity of an operation's request queue on the bus.
const WAITING: usize = 128;

/// All operations that a system offers on a bus.
#[derive(Default)]
pub(crate) struct OfferedOperations {
    operations: Vec<OfferedOperation>,
    /// Number of the newest request.
    last_call: u64,
}

/// An operation that other processes may call.
pub(crate) struct OfferedOperation {
    /// Number of its service at the attachment.
    offer: u64,
    /// Name of its service outside.
    service: String,
    /// Position of the provider in the system.
    provider: usize,
    queue: Arc<RequestQueue>,
    /// Position of the operation in the service.
    operation: usize,
    /// Schema of the request.
    argument: Schema,
    name: String,
    address: ServedAddress,
    /// Refusals of the address that have been counted.
    counted: u64,
}

/// Serves the operations of a service under a name. `offer` is the number of the service at the attachment.
pub(crate) fn open(
    offer: u64,
    name: &str,
    service: &OuterService<'_>,
    identity: &BusIdentity,
) -> Result<Vec<OfferedOperation>, BusError> {
    let operations = service.declaration.operations.iter().enumerate();
    let operations = operations.map(|(operation, declared)| {
        let address = address(name, &declared.name);
        let notifier = Arc::clone(&identity.notifier);
        Ok(OfferedOperation {
            offer,
            service: name.to_owned(),
            provider: service.provider,
            queue: Arc::clone(&service.queue),
            operation,
            argument: declared.request.clone(),
            address: identity.bus.serve(&address, WAITING, notifier)?,
            name: address,
            counted: 0,
        })
    });
    operations.collect()
}

impl OfferedOperations {
    /// Returns whether a service is offered under a name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.operations.iter().any(|it| it.service == name)
    }

    /// Adds the operations of a service.
    pub(crate) fn add(&mut self, operations: Vec<OfferedOperation>) {
        self.operations.extend(operations);
    }

    /// Removes and returns the operations of the service with this number.
    pub(crate) fn remove(&mut self, offer: u64) -> Vec<OfferedOperation> {
        let removed = self.operations.extract_if(.., |it| it.offer == offer);
        removed.collect()
    }

    /// Moves arrived requests into the providers' queues, and counts those refused because a queue was full.
    pub(crate) fn deliver(&mut self, now: Time, effects: &mut dyn Effects) {
        for offer in &mut self.operations {
            offer.count_refused(now, effects);
            while let Some(call) = offer.address.try_next() {
                self.last_call += 1;
                offer.accept(call, self.last_call, now, effects);
            }
        }
    }
}

impl OfferedOperation {
    /// Counts the requests that the queue of the address has refused since the last time.
    fn count_refused(&mut self, now: Time, effects: &mut dyn Effects) {
        let refused = self.address.refused();
        if refused > self.counted {
            self.queue.add_refused(refused - self.counted);
            self.counted = refused;
            self.report_refused(now, effects);
        }
    }

    fn report_refused(&self, now: Time, effects: &mut dyn Effects) {
        effects.emit(
            now,
            &Event::Dropped {
                component: "",
                port: "",
                to: &self.name,
                total: self.queue.refused(),
                reason: None,
            },
        );
    }

    fn accept(&self, call: IncomingCall, number: u64, now: Time, effects: &mut dyn Effects) {
        let argument = match call.argument.to_complete_sample(&self.argument) {
            Ok(argument) => argument,
            Err(error) => {
                return call.reply(Err(Refusal {
                    code: "BAD_REQUEST".to_owned(),
                    detail: error.to_string(),
                }));
            }
        };
        let answered = !call.is_one_way();
        let remaining = call.deadline.saturating_duration_since(Instant::now());
        let refused = self.queue.refuses(self.operation);
        if let (true, Some(error)) = (answered, refused) {
            return call.complete(Err(call_failure(error)));
        }
        let request = ServiceRequest {
            // unused: callers on a bus cancel through the bus
            key: CallKey {
                caller: usize::MAX,
                number,
            },
            operation: self.operation,
            argument,
            caller: Arc::clone(&call.origin.source),
            trace: call.trace,
            awaits_provider: true,
            deadline: answered.then_some(now + remaining),
            reply_to: answered.then(|| ReplyTo::Remote(Box::new(BusCaller(call)))),
        };
        match self.queue.send(request, effects) {
            Ok(true) => effects.trigger(self.provider),
            // the queue is full: dropping the request tells the caller
            Err(CallError::Unavailable) => self.report_refused(now, effects),
            Ok(false) | Err(_) => {}
        }
    }
}

/// A caller that is reached over the bus.
struct BusCaller(IncomingCall);

impl RemoteCaller for BusCaller {
    fn is_awaited(&self) -> bool {
        self.0.is_awaited()
    }

    fn reply(self: Box<Self>, result: Result<Arc<dyn Sample>, CallError>) {
        self.0
            .complete(result.map(Payload::Sample).map_err(call_failure));
    }
}
