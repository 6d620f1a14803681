//! Freezing and thawing of a service.

use std::sync::Arc;

use asmotion_component::RequestId;
use asmotion_port::Time;
use serde::{Deserialize, Serialize};

use super::{Admission, OpenRequest, ProvidedService};
use crate::frozen::{
    FrozenSample, SampleNames, SystemFreezeError, SystemThawError, no_data, system_mismatch,
    trace_of, trace_text,
};
use crate::service::message::{
    CallKey, ComponentReply, ProviderMessage, ReplyQueue, ReplyTo, ServiceRequest,
};

/// Context for thawing requests.
pub(crate) struct ThawContext {
    pub names: SampleNames,
    /// Reply queue of each component, by its position.
    pub reply_queues: Vec<Arc<ReplyQueue>>,
}

/// State of a service port.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FrozenService {
    admission: Admission,
    queue: Vec<FrozenMessage>,
    waiting: Vec<(RequestId, FrozenRequest)>,
    open: Vec<FrozenOpen>,
    cancelled: Vec<RequestId>,
    /// Operations and causes of refused one-way requests that have been reported.
    reported: Vec<(usize, String)>,
    next: u64,
    /// Number of requests refused because the queue was full.
    #[serde(default)]
    refused: u64,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum FrozenMessage {
    Request(FrozenRequest),
    Cancel(FrozenKey),
}

/// Position of the calling component and number of the call.
type FrozenKey = (usize, u64);

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenRequest {
    key: FrozenKey,
    operation: usize,
    argument: FrozenSample,
    caller: String,
    deadline: Option<Time>,
    trace: Option<String>,
    /// Whether the caller expects a reply.
    replies: bool,
}

/// A request that the component has taken.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenOpen {
    id: RequestId,
    key: FrozenKey,
    operation: usize,
    caller: String,
    deadline: Option<Time>,
}

/// Returns whether the caller expects a reply; reports callers outside the system.
fn replies(to: Option<&ReplyTo>, service: &str) -> Result<bool, SystemFreezeError> {
    match to {
        None => Ok(false),
        Some(ReplyTo::Component(_)) => Ok(true),
        Some(ReplyTo::Remote(_) | ReplyTo::External(_)) => Err(SystemFreezeError::External(
            format!("a caller waits for an answer of `{service}`"),
        )),
    }
}

impl FrozenRequest {
    fn of(request: &ServiceRequest, service: &str) -> Result<Self, SystemFreezeError> {
        let argument = FrozenSample::of(&*request.argument);
        Ok(Self {
            key: (request.key.caller, request.key.number),
            operation: request.operation,
            argument: argument.map_err(no_data(service))?,
            caller: request.caller.to_string(),
            deadline: request.deadline,
            trace: trace_text(request.trace),
            replies: replies(request.reply_to.as_ref(), service)?,
        })
    }

    fn thaw(&self, context: &ThawContext) -> Result<ServiceRequest, SystemThawError> {
        Ok(ServiceRequest {
            key: context.key(self.key),
            operation: self.operation,
            argument: self.argument.thaw(&context.names)?,
            caller: Arc::from(self.caller.as_str()),
            deadline: self.deadline,
            trace: trace_of(&self.trace)?,
            // the provider is there
            awaits_provider: true,
            reply_to: if self.replies {
                Some(context.reply_to(self.key)?)
            } else {
                None
            },
        })
    }
}

impl FrozenMessage {
    fn of(message: &ProviderMessage, service: &str) -> Result<Self, SystemFreezeError> {
        Ok(match message {
            ProviderMessage::Request(request) => {
                Self::Request(FrozenRequest::of(request, service)?)
            }
            ProviderMessage::Cancel(key) => Self::Cancel((key.caller, key.number)),
        })
    }

    fn thaw(&self, context: &ThawContext) -> Result<ProviderMessage, SystemThawError> {
        Ok(match self {
            Self::Request(request) => ProviderMessage::Request(request.thaw(context)?),
            Self::Cancel(key) => ProviderMessage::Cancel(context.key(*key)),
        })
    }
}

impl ThawContext {
    fn key(&self, (caller, number): FrozenKey) -> CallKey {
        CallKey { caller, number }
    }

    fn reply_to(&self, (caller, _): FrozenKey) -> Result<ReplyTo, SystemThawError> {
        let queue = self.reply_queues.get(caller);
        let queue = queue.ok_or_else(|| system_mismatch("a component calls that is not in it"))?;
        Ok(ReplyTo::Component(ComponentReply(Arc::clone(queue))))
    }
}

impl ProvidedService {
    pub(crate) fn snapshot(&self) -> Result<FrozenService, SystemFreezeError> {
        let name = &*self.declaration.name;
        let queue = &self.queue.queue;
        let mut messages = Vec::new();
        // rotates the queue once; nothing else accesses it while the simulation is idle
        for _ in 0..queue.len() {
            let Some(message) = queue.pop() else { break };
            messages.push(FrozenMessage::of(&message, name));
            queue.force_push(message);
        }
        let waiting = self.waiting.iter();
        let waiting = waiting.map(|(id, request)| Ok((*id, FrozenRequest::of(request, name)?)));
        let open = self.open.iter().map(|open| {
            replies(Some(&open.reply_to), name)?;
            Ok(FrozenOpen {
                id: open.id,
                key: (open.key.caller, open.key.number),
                operation: open.operation,
                caller: open.caller.to_string(),
                deadline: open.deadline,
            })
        });
        Ok(FrozenService {
            admission: self.queue.admission(),
            queue: messages.into_iter().collect::<Result<_, _>>()?,
            waiting: waiting.collect::<Result<_, SystemFreezeError>>()?,
            open: open.collect::<Result<_, SystemFreezeError>>()?,
            cancelled: self.cancelled.clone(),
            reported: self.reported.clone(),
            next: self.next_id,
            refused: self.queue.refused(),
        })
    }

    /// Restores the state of the same service of another system.
    pub(crate) fn restore(
        &mut self,
        service: &FrozenService,
        context: &ThawContext,
    ) -> Result<(), SystemThawError> {
        let waiting = service.waiting.iter();
        let waiting = waiting.map(|(id, request)| Ok((*id, request.thaw(context)?)));
        self.waiting = waiting.collect::<Result<_, SystemThawError>>()?;
        let open = service.open.iter().map(|open| {
            Ok(OpenRequest {
                id: open.id,
                key: context.key(open.key),
                operation: open.operation,
                caller: Arc::from(open.caller.as_str()),
                deadline: open.deadline,
                reply_to: context.reply_to(open.key)?,
            })
        });
        self.open = open.collect::<Result<_, SystemThawError>>()?;
        self.cancelled.clone_from(&service.cancelled);
        self.reported.clone_from(&service.reported);
        self.one_way.clear();
        self.next_id = service.next;
        while self.queue.queue.pop().is_some() {}
        for message in &service.queue {
            self.queue.queue.force_push(message.thaw(context)?);
        }
        self.queue.set_admission(service.admission);
        self.queue.set_refused(service.refused);
        Ok(())
    }
}
