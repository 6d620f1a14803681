//! Services: each request to an address gets at most one reply, before its deadline.
//!
//! A request goes through the direct exchange to the queue of its address and is mandatory: the broker returns it
//! immediately if no provider is registered. The reply uses RabbitMQ's direct reply-to. While a call is open, the
//! caller periodically asks the provider whether it still knows the call; if the provider is gone or has forgotten it,
//! the call ends before its deadline. After a broken link, open calls are sent again with their ids, and providers
//! execute an id once.

mod caller;
mod ended;
mod lateness;
mod message;
mod provider;

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use asmotion_bus::{
    AddressQueue, BusError, CallFailure, Notifier, PendingCall, Request, ServedAddress,
};
use asmotion_datum::{Codec, Datum, Message};
use tokio::runtime::Handle;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};
use tokio::sync::oneshot;

use crate::channel::{ChannelError, LOCKED};
use crate::first_declaration::FirstDeclaration;
use crate::link::Link;
use crate::names::{RoutingNames, check_length};
use caller::{AwaitedReply, OpenCall};

/// Time that a leaving provider waits for the broker to free its address.
const FAREWELL: Duration = Duration::from_secs(2);

/// The services' side of a bus.
pub(crate) struct Services {
    link: Arc<Link>,
    names: RoutingNames,
    lifetime_id: String,
    number: AtomicU64,
    tasks: Handle,
    calls: UnboundedSender<OpenCall>,
    served: Arc<Mutex<BTreeSet<String>>>,
}

impl Services {
    pub(crate) fn new(
        link: Arc<Link>,
        names: RoutingNames,
        lifetime_id: String,
        tasks: Handle,
    ) -> Self {
        let (calls, opened) = unbounded_channel();
        link.spawn(
            &tasks,
            caller::CallerTask::new(Arc::clone(&link), opened).run(),
        );
        Self {
            link,
            names,
            lifetime_id,
            number: AtomicU64::new(1),
            tasks,
            calls,
            served: Arc::default(),
        }
    }

    pub(crate) fn serve(
        &self,
        address: &str,
        size: usize,
        notifier: Arc<Notifier>,
    ) -> Result<ServedAddress, BusError> {
        let served = || BusError::Served {
            address: address.to_owned(),
        };
        let key = self.names.key(address)?;
        let queue = format!("{}.{key}", self.link.settings.services());
        check_length(address, &queue)?;
        if !lock(&self.served).insert(key.clone()) {
            return Err(served());
        }
        let requests = AddressQueue::new(size, notifier);
        let (stop_sender, stop) = oneshot::channel();
        let (ended_sender, ended) = sync_channel(1);
        let (ready, declared) = FirstDeclaration::new();
        let task = provider::ProviderTask::new(provider::ProviderSetup {
            link: Arc::clone(&self.link),
            key: key.clone(),
            queue,
            size,
            requests: Arc::clone(&requests),
            ready,
        });
        let is_open = self.link.is_open();
        self.link.spawn(&self.tasks, async move {
            task.run(stop).await;
            // fails if the thread no longer waits
            let _ = ended_sender.try_send(());
        });
        if is_open
            && let Ok(Err(ChannelError::Closed { code, reason })) =
                declared.recv_timeout(self.link.settings.timing.connect)
        {
            lock(&self.served).remove(&key);
            return Err(if code == LOCKED {
                served()
            } else {
                BusError::Refused { reason }
            });
        }
        let all = Arc::clone(&self.served);
        Ok(ServedAddress::new(requests, move || {
            if stop_sender.send(()).is_ok() {
                // the address is free then; a broker that does not respond frees it later
                let _ = ended.recv_timeout(FAREWELL);
            }
            lock(&all).remove(&key);
        }))
    }

    pub(crate) fn call(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        let message = self.message(address, &request)?;
        let (pending, call) = PendingCall::new(request, notifier);
        self.open(message, AwaitedReply::Answer(call));
        Ok(pending)
    }

    pub(crate) fn call_one_way(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        let message = self.message(address, &request)?;
        let (pending, _call, delivered) = PendingCall::one_way(request, notifier);
        self.open(message, AwaitedReply::Delivery(delivered));
        Ok(pending)
    }

    fn message(
        &self,
        address: &str,
        request: &Request,
    ) -> Result<message::OutgoingRequest, BusError> {
        let key = self.names.called_key(address)?;
        let codec = Codec::Cbor;
        let bytes = request.argument.encode(codec, Datum::schema());
        let number = self.number.fetch_add(1, Ordering::Relaxed);
        Ok(message::OutgoingRequest {
            id: format!("{}.{number}", self.lifetime_id),
            key,
            codec,
            bytes: bytes.map_err(|error| BusError::Refused {
                reason: error.to_string(),
            })?,
            source: Arc::clone(&request.origin.source),
            incarnation: request.origin.incarnation,
            timeout: request.timeout,
            begun: Instant::now(),
            callback: request.callback.clone(),
            trace: request.trace,
            user: self.link.settings.credentials.user().to_owned(),
            awaits_provider: request.awaits_provider,
        })
    }

    /// Starts a call. Without a link it fails immediately.
    fn open(&self, message: message::OutgoingRequest, awaited: AwaitedReply) {
        if !self.link.is_connected() {
            return awaited.complete(Err(CallFailure::Unavailable));
        }
        if let Err(unsent) = self.calls.send(OpenCall::new(message, awaited)) {
            unsent.0.complete(Err(CallFailure::Unavailable));
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
