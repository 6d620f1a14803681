//! Services that other processes call: a request goes into the component's queue like those from inside.

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

use crate::ends::{OfferedService, address};
use crate::failure::call_failure;
use crate::identity::BusIdentity;

/// How many requests of an operation may wait between two deliveries.
const WAITING: usize = 128;

/// All operations that a system offers on a bus.
pub(crate) struct OfferedOperations {
    operations: Vec<OfferedOperation>,
    /// Number of the last request.
    last: u64,
}

/// An operation that other processes may call.
struct OfferedOperation {
    /// The provider's position in the system.
    provider: usize,
    queue: Arc<RequestQueue>,
    /// Position of the operation in the service.
    operation: usize,
    /// The type of its argument.
    argument: Schema,
    serving: ServedAddress,
}

impl OfferedOperations {
    pub(crate) fn new<'o>(
        system: &System,
        offered: impl Iterator<Item = &'o OfferedService>,
        identity: &BusIdentity,
    ) -> Result<Self, BusError> {
        let mut operations = Vec::new();
        let mut names = BTreeSet::new();
        // offered over several buses that are one here, it is offered once
        for OfferedService {
            service: end, name, ..
        } in offered.filter(|it| names.insert(&it.name))
        {
            let (declaration, queue) = system.service_at(end);
            for (operation, declared) in declaration.operations.iter().enumerate() {
                let address = address(name, &declared.name);
                let notifier = Arc::clone(&identity.notifier);
                operations.push(OfferedOperation {
                    provider: end.component(),
                    queue: Arc::clone(&queue),
                    operation,
                    argument: declared.request.clone(),
                    serving: identity.bus.serve(&address, WAITING, notifier)?,
                });
            }
        }
        Ok(Self {
            operations,
            last: 0,
        })
    }

    /// Hands over the requests that have come.
    pub(crate) fn deliver(&mut self, now: Time, effects: &mut dyn Effects) {
        for offer in &self.operations {
            while let Some(call) = offer.serving.try_next() {
                self.last += 1;
                offer.take(call, self.last, now, effects);
            }
        }
    }
}

impl OfferedOperation {
    fn take(&self, call: IncomingCall, number: u64, now: Time, effects: &mut dyn Effects) {
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
        let left = call.deadline.saturating_duration_since(Instant::now());
        let request = ServiceRequest {
            // Callers on a bus cancel their own calls; nothing cancels by this key.
            key: CallKey {
                caller: usize::MAX,
                number,
            },
            operation: self.operation,
            argument,
            caller: Arc::clone(&call.origin.source),
            trace: call.trace,
            deadline: answered.then_some(now + left),
            reply_to: answered.then(|| ReplyTo::Remote(Box::new(BusCaller(call)))),
        };
        // A caller whose request is not taken learns it when the request is dropped.
        if self.queue.ask(request, effects) == Ok(true) {
            effects.trigger(self.provider);
        }
    }
}

/// A caller on the bus.
struct BusCaller(IncomingCall);

impl RemoteCaller for BusCaller {
    fn is_awaited(&self) -> bool {
        self.0.is_awaited()
    }

    fn reply(self: Box<Self>, result: Result<Arc<dyn Sample>, CallError>) {
        self.0
            .end(result.map(Payload::Sample).map_err(call_failure));
    }
}
