//! Services of other processes and systems: requests of a component are called by a client, and replies are put into
//! the component's queue.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use asmotion_bus::{
    Bus, BusError, CallFailure, Notifier, Payload, PendingCall, Refusal, Request, SenderId,
    ServiceClient, SpanGenerator,
};
use asmotion_component::{CallError, NOTICE_REPORT, ServiceFault};
use asmotion_datum::{Datum, DatumError, DatumProblem, Message, Sample, Schema, Shape};
use asmotion_port::Time;
use asmotion_runtime::{
    CallKey, Effects, Event, ProviderMessage, ReplyTo, RequestQueue, ServiceRequest,
};

use crate::robot_service::{Admission, RobotService};

/// The route from a reference to a remote service.
pub(crate) struct RemoteRoute {
    /// The component's requests for this service.
    pub queue: Arc<RequestQueue>,
    /// Addresses, by position of the operation in the reference.
    pub addresses: Vec<String>,
    /// The calling component.
    pub caller: String,
    /// The reference and what it leads to, without secrets.
    pub shown: String,
    /// Timeout of one-way calls.
    pub timeout: Duration,
    /// The service of another robot, which is compared with its announcement.
    pub robot_service: Option<Arc<RobotService>>,
    /// Types of the responses, by position of the operation in the reference; the last ones may be missing.
    pub responses: Vec<Schema>,
    /// The provider belongs to another system: a reply that does not have the type of the response is a fault.
    pub is_external: bool,
}

impl RemoteRoute {
    /// Reads the reply to a call of an operation, whose provider may be a stranger.
    fn read(&self, operation: usize, reply: Payload) -> Result<Payload, CallFailure> {
        let read = match (&self.robot_service, self.responses.get(operation)) {
            (Some(service), _) => service.read(operation, &reply),
            (None, Some(response)) if self.is_external => read_response(response, &reply),
            // the caller refuses what it cannot read
            (None, Some(response)) => Ok(reply
                .to_complete_sample(response)
                .map_or(reply, Payload::Sample)),
            (None, None) => Ok(reply),
        };
        read.map_err(|fault| CallFailure::Refused(refusal(fault)))
    }

    /// Decides about a call of an operation.
    fn admit(&self, operation: usize) -> Admission {
        let service = self.robot_service.as_ref();
        service.map_or(Admission::Sent, |service| service.admit(operation))
    }
}

/// The calling side of a system.
#[derive(Clone)]
pub(crate) struct CallerIdentity {
    pub client: Arc<dyn ServiceClient>,
    /// Number of this process' incarnation, unique among all processes.
    pub incarnation: u64,
    /// The system's notifier, which wakes the thread that delivers.
    pub notifier: Arc<Notifier>,
}

/// Calls services over a bus.
pub(crate) struct BusClient(pub Arc<dyn Bus>);

impl ServiceClient for BusClient {
    fn call(
        &self,
        address: &str,
        request: Request,
        one_way: bool,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        if one_way {
            self.0.call_one_way(address, request, notifier)
        } else {
            self.0.call(address, request, notifier)
        }
    }
}

/// A remote service and the calls of it under way.
pub(crate) struct RemoteService {
    route: RemoteRoute,
    identity: CallerIdentity,
    pending: Vec<RemoteCall>,
    /// Requests that wait for the announcement of another robot's service.
    held: VecDeque<ServiceRequest>,
    /// A provider has handled a request of this process. Until then it may be starting, and calls wait for it.
    is_known: bool,
    /// Number of one-way calls without a provider.
    lost: u64,
    /// The reason for which the provider is unavailable, if it has been reported.
    reported: Option<String>,
}

/// A call under way.
struct RemoteCall {
    key: CallKey,
    /// Position of the operation in the reference.
    operation: usize,
    origin: CallOrigin,
    pending: PendingCall,
}

/// The destination of a call's outcome.
enum CallOrigin {
    /// The component, as a reply.
    Waiting(ReplyTo),
    /// The observers, if a one-way call found no provider.
    OneWay {
        component: Arc<str>,
        address: String,
    },
}

impl CallOrigin {
    fn of(reply_to: Option<ReplyTo>, component: Arc<str>, address: String) -> Self {
        match reply_to {
            Some(reply_to) => Self::Waiting(reply_to),
            None => Self::OneWay { component, address },
        }
    }
}

impl RemoteService {
    pub(crate) fn new(route: RemoteRoute, identity: CallerIdentity) -> Self {
        Self {
            route,
            identity,
            pending: Vec::new(),
            held: VecDeque::new(),
            is_known: false,
            lost: 0,
            reported: None,
        }
    }

    /// Sends the posted requests, and passes on the outcomes of calls. Returns whether more can follow: the reference is
    /// still wired to the service, or a call is under way.
    pub(crate) fn deliver(&mut self, now: Time, effects: &mut dyn Effects) -> bool {
        // read first: nobody can post a request afterwards
        let is_wired = Arc::strong_count(&self.route.queue) > 1;
        while let Some(message) = self.route.queue.next() {
            match message {
                ProviderMessage::Request(request) => self.held.push_back(request),
                ProviderMessage::Cancel(key) => self.cancel(key),
            }
        }
        self.send_admitted(now, effects);
        self.end_misfits(now, effects);
        let mut index = 0;
        while let Some(open) = self.pending.get(index) {
            match open.pending.try_take() {
                None => index += 1,
                Some(end) => {
                    let is_early = !open.pending.is_expired();
                    let reason = open.pending.reason().map(str::to_owned);
                    let RemoteCall {
                        key,
                        operation,
                        origin,
                        ..
                    } = self.pending.remove(index);
                    let end = match origin {
                        CallOrigin::Waiting(_) => {
                            end.and_then(|reply| self.route.read(operation, reply))
                        }
                        CallOrigin::OneWay { .. } => end,
                    };
                    self.report(end.is_ok(), reason, now, effects);
                    match (origin, end) {
                        // a server whose own call has timed out; at the deadline, the caller ends the call itself
                        (CallOrigin::Waiting(reply_to), Err(CallFailure::Timeout)) if is_early => {
                            reply_to.send(key.number, Err(CallError::Timeout), effects);
                        }
                        (origin, end) => self.complete(key, origin, end, now, effects),
                    }
                }
            }
        }
        is_wired || !self.pending.is_empty() || !self.held.is_empty()
    }

    /// Reports why the provider is unavailable, once until a call succeeds or the reason is another one.
    fn report(
        &mut self,
        is_reply: bool,
        reason: Option<String>,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        if is_reply {
            self.reported = None;
        }
        let Some(reason) = reason.filter(|it| self.reported.as_ref() != Some(it)) else {
            return;
        };
        let data = Datum::Text(format!("{} is unavailable: {reason}", self.route.shown));
        let event = Event::Report {
            component: &self.route.caller,
            kind: NOTICE_REPORT,
            data: &data,
        };
        effects.emit(now, &event);
        self.reported = Some(reason);
    }

    /// Sends the requests that need not wait, and ends those that do not fit what the provider has announced.
    fn send_admitted(&mut self, now: Time, effects: &mut dyn Effects) {
        for request in std::mem::take(&mut self.held) {
            match self.route.admit(request.operation) {
                Admission::Held => self.held.push_back(request),
                Admission::Sent => self.send(request, now, effects),
                Admission::Refused(fault) => {
                    let address = self.address(request.operation);
                    let key = request.key;
                    let origin = CallOrigin::of(request.reply_to, request.caller, address);
                    let refused = Err(CallFailure::Refused(refusal(fault)));
                    self.end(key, origin, refused, now, effects);
                }
            }
        }
    }

    fn address(&self, operation: usize) -> String {
        let address = self.route.addresses.get(operation).cloned();
        address.unwrap_or_default()
    }

    /// Ends the calls that do not fit what the provider has announced since they were sent.
    fn end_misfits(&mut self, now: Time, effects: &mut dyn Effects) {
        if self.route.robot_service.is_none() {
            return;
        }
        for open in std::mem::take(&mut self.pending) {
            match self.route.admit(open.operation) {
                Admission::Sent | Admission::Held => self.pending.push(open),
                Admission::Refused(fault) => {
                    open.pending.cancel();
                    let refused = Err(CallFailure::Refused(refusal(fault)));
                    self.end(open.key, open.origin, refused, now, effects);
                }
            }
        }
    }

    fn send(&mut self, request: ServiceRequest, now: Time, effects: &mut dyn Effects) {
        let address = self.address(request.operation);
        let key = request.key;
        let remaining = request.deadline.map(|deadline| deadline.since(now));
        let message = Request::new(
            SenderId::new(Arc::clone(&request.caller), self.identity.incarnation),
            Payload::Sample(request.argument),
            remaining.unwrap_or(self.route.timeout),
        );
        let spans = SpanGenerator::new(&request.caller, self.identity.incarnation, &address);
        let message = message
            .with_trace(spans.of(request.key.number, request.trace))
            .with_awaited_provider(request.awaits_provider && !self.is_known);
        let notifier = Arc::clone(&self.identity.notifier);
        let one_way = request.reply_to.is_none();
        let client = &self.identity.client;
        let sent = client.call(&address, message, one_way, notifier);
        let origin = CallOrigin::of(request.reply_to, request.caller, address);
        match sent {
            Ok(pending) => self.pending.push(RemoteCall {
                key,
                operation: request.operation,
                origin,
                pending,
            }),
            Err(_) => self.complete(key, origin, Err(CallFailure::Unavailable), now, effects),
        }
    }

    fn cancel(&mut self, key: CallKey) {
        let is_cancelled = |it: &ServiceRequest| it.key == key && it.reply_to.is_some();
        self.held.retain(|it| !is_cancelled(it));
        let cancelled = self.pending.extract_if(.., |open| {
            open.key == key && matches!(open.origin, CallOrigin::Waiting(_))
        });
        for open in cancelled {
            open.pending.cancel();
        }
    }

    fn complete(
        &mut self,
        key: CallKey,
        origin: CallOrigin,
        result: Result<Payload, CallFailure>,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        self.is_known |= matches!(
            result,
            Ok(_) | Err(CallFailure::Refused(_) | CallFailure::Stopped)
        );
        self.end(key, origin, result, now, effects);
    }

    /// Passes on the outcome of a call.
    fn end(
        &mut self,
        key: CallKey,
        origin: CallOrigin,
        result: Result<Payload, CallFailure>,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        match (origin, result) {
            // the caller's own deadline ends the call or starts a retry
            (CallOrigin::Waiting(_), Err(CallFailure::Timeout | CallFailure::Cancelled)) => {}
            (CallOrigin::Waiting(reply_to), Err(CallFailure::Unavailable)) => {
                reply_to.send(key.number, Err(CallError::Unavailable), effects);
            }
            (CallOrigin::Waiting(reply_to), Err(CallFailure::Stopped)) => {
                reply_to.send(key.number, Err(CallError::Stopped), effects);
            }
            (CallOrigin::Waiting(reply_to), Err(CallFailure::Refused(refusal))) => {
                let fault = ServiceFault::new(refusal.code, refusal.detail);
                reply_to.send(key.number, Err(CallError::Fault(fault)), effects);
            }
            (CallOrigin::Waiting(reply_to), Ok(payload)) => {
                reply_to.send(key.number, read(&payload), effects);
            }
            (CallOrigin::OneWay { .. }, Ok(_)) => {}
            (CallOrigin::OneWay { component, address }, Err(failure)) => {
                self.lost += 1;
                let reason = DatumError::new(DatumProblem::Mismatch(failure.to_string()));
                effects.emit(
                    now,
                    &Event::Dropped {
                        component: &component,
                        port: "",
                        to: &address,
                        total: self.lost,
                        reason: Some(&reason),
                    },
                );
            }
        }
    }
}

/// Reads the reply of another system. Nothing is a reply where there is nothing to say.
fn read_response(response: &Schema, reply: &Payload) -> Result<Payload, ServiceFault> {
    let is_empty = matches!(&response.shape, Shape::Record(fields) if fields.is_empty());
    let datum = reply.to_datum().and_then(|datum| {
        let datum = if is_empty && datum.is_null() {
            Datum::Record(Vec::new())
        } else {
            datum
        };
        response.complete(datum)
    });
    let datum = datum.map(Payload::of);
    datum.map_err(|error| ServiceFault::new("BAD_REPLY", error.to_string()))
}

fn refusal(fault: ServiceFault) -> Refusal {
    Refusal {
        code: fault.code,
        detail: fault.detail,
    }
}

fn read(payload: &Payload) -> Result<Arc<dyn Sample>, CallError> {
    payload
        .to_sample(Datum::schema())
        .map_err(|error| CallError::Fault(ServiceFault::new("BAD_REPLY", error.to_string())))
}
