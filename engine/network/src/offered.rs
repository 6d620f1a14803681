//! Services that other processes call: their requests go into the component's queue like local ones.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

use asmotion_bus::{BusError, IncomingCall, Payload, Refusal, ServedAddress};
use asmotion_component::CallError;
use asmotion_datum::{Sample, Schema};
use asmotion_port::Time;
use asmotion_runtime::{
    CallKey, Effects, RemoteCaller, ReplyTo, RequestQueue, ServiceRequest, System,
};

use crate::failure::call_failure;
use crate::identity::BusIdentity;
use crate::remote_ends::{OfferedService, address};

/// Capacity of an operation's request queue on the bus.
const WAITING: usize = 128;

/// All operations that a system offers on a bus.
pub(crate) struct OfferedOperations {
    operations: Vec<OfferedOperation>,
    /// Number of the newest request.
    last_call: u64,
}

/// An operation that other processes may call.
struct OfferedOperation {
    /// Position of the provider in the system.
    provider: usize,
    queue: Arc<RequestQueue>,
    /// Position of the operation in the service.
    operation: usize,
    /// Schema of the request.
    argument: Schema,
    address: ServedAddress,
}

impl OfferedOperations {
    pub(crate) fn new<'o>(
        system: &System,
        offered: impl Iterator<Item = &'o OfferedService>,
        identity: &BusIdentity,
    ) -> Result<Self, BusError> {
        let mut operations = Vec::new();
        let mut names = BTreeSet::new();
        // a service offered over several buses may be listed twice for the same bus
        for OfferedService {
            service: end, name, ..
        } in offered.filter(|it| names.insert(&it.name))
        {
            let (declaration, queue) = system.provided_service(end);
            for (operation, declared) in declaration.operations.iter().enumerate() {
                let address = address(name, &declared.name);
                let notifier = Arc::clone(&identity.notifier);
                operations.push(OfferedOperation {
                    provider: end.component(),
                    queue: Arc::clone(&queue),
                    operation,
                    argument: declared.request.clone(),
                    address: identity.bus.serve(&address, WAITING, notifier)?,
                });
            }
        }
        Ok(Self {
            operations,
            last_call: 0,
        })
    }

    /// Moves arrived requests into the providers' queues.
    pub(crate) fn deliver(&mut self, now: Time, effects: &mut dyn Effects) {
        for offer in &self.operations {
            while let Some(call) = offer.address.try_next() {
                self.last_call += 1;
                offer.accept(call, self.last_call, now, effects);
            }
        }
    }
}

impl OfferedOperation {
    fn accept(&self, call: IncomingCall, number: u64, now: Time, effects: &mut dyn Effects) {
        let argument = match call.argument.to_sample(&self.argument) {
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
        // if the queue is full, dropping the request tells the caller
        if self.queue.send(request, effects) == Ok(true) {
            effects.trigger(self.provider);
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
