//! Calls services of other systems over HTTP.

mod connection;
mod exchange;
mod outcome;
mod target;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use asmotion_bus::{
    BusError, DeliveryReceipt, IncomingCall, Notifier, Payload, PendingCall, Request, ServiceClient,
};
use tokio::runtime::{Builder, Handle, Runtime};
use tokio::sync::Semaphore;
use tokio::time::sleep;

use self::connection::ConnectionPool;
use self::exchange::Exchange;
use self::outcome::{FailedExchange, unavailable};
use self::target::Target;
use asmotion_http::BearerToken;

/// Limit on the simultaneous calls of a service; further ones end as unavailable.
const MAX_CALLS: usize = 64;
/// Interval at which a call under way is checked for cancellation.
const TICK: Duration = Duration::from_millis(10);

/// An error when a client starts.
#[derive(Debug, thiserror::Error)]
pub enum HttpClientError {
    /// No thread can be started.
    #[error("cannot start the thread of the HTTP client: {0}")]
    Thread(std::io::Error),
    /// The certificate authorities cannot be used.
    #[error("certificate authorities: {0}")]
    Authorities(String),
}

/// Calls services over HTTP. One thread handles the calls of all services. Dropping this ends the calls under way as
/// unavailable.
#[derive(Debug)]
pub struct HttpClient {
    runtime: Option<Runtime>,
    pool: Arc<ConnectionPool>,
}

impl HttpClient {
    /// Starts a client. `authorities` is a PEM file with the certificate authorities for `https`, in place of the web's
    /// root certificates.
    ///
    /// # Errors
    /// An error if no thread can be started, or if the file cannot be read or contains no certificate.
    pub fn start(authorities: Option<&Path>) -> Result<Self, HttpClientError> {
        let pool = ConnectionPool::new(authorities).map_err(HttpClientError::Authorities)?;
        let runtime = Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("http client")
            .enable_all()
            .build()
            .map_err(HttpClientError::Thread)?;
        Ok(Self {
            runtime: Some(runtime),
            pool: Arc::new(pool),
        })
    }

    /// Returns the client of a service, which presents this token. The address of an operation is its URL. `authorities` is a
    /// PEM file with the certificate authorities of this service, in place of those of the client.
    ///
    /// # Errors
    /// The file cannot be read or contains no certificate.
    pub fn service(
        &self,
        token: Option<BearerToken>,
        authorities: Option<&Path>,
    ) -> Result<Arc<dyn ServiceClient>, HttpClientError> {
        let pool = match authorities {
            None => Arc::clone(&self.pool),
            // of its own, because a connection is trusted by those who have made it
            Some(_) => {
                let pool = ConnectionPool::new(authorities);
                Arc::new(pool.map_err(HttpClientError::Authorities)?)
            }
        };
        Ok(Arc::new(HttpService {
            handle: self.runtime.as_ref().map(|it| it.handle().clone()),
            pool,
            token,
            calls: Arc::new(Semaphore::new(MAX_CALLS)),
        }))
    }
}

impl Drop for HttpClient {
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            // does not wait for a name that is being resolved
            runtime.shutdown_background();
        }
    }
}

/// The client of one service.
struct HttpService {
    /// `None` is never seen: only dropping the client removes the runtime.
    handle: Option<Handle>,
    pool: Arc<ConnectionPool>,
    token: Option<BearerToken>,
    calls: Arc<Semaphore>,
}

impl ServiceClient for HttpService {
    fn call(
        &self,
        address: &str,
        request: Request,
        one_way: bool,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        let target = Target::of(address)?;
        let mut exchange = Exchange {
            target,
            token: self.token.clone(),
            argument: request.argument.clone(),
            deadline: asmotion_bus::deadline_after(request.timeout),
            trace: request.trace,
            one_way,
        };
        let (pending, outcome) = if one_way {
            let (pending, call, receipt) = PendingCall::one_way(request, notifier);
            exchange.deadline = call.deadline;
            (pending, AwaitedOutcome::Delivery(receipt))
        } else {
            let (pending, call) = PendingCall::new(request, notifier);
            exchange.deadline = call.deadline;
            (pending, AwaitedOutcome::Reply(call))
        };
        let permit = Arc::clone(&self.calls).try_acquire_owned();
        let (Some(handle), Ok(permit)) = (&self.handle, permit) else {
            let reason = format!("{MAX_CALLS} calls of the service are under way");
            outcome.complete(Err(unavailable(reason)));
            return Ok(pending);
        };
        let pool = Arc::clone(&self.pool);
        handle.spawn(async move {
            let _permit = permit;
            tokio::select! {
                result = exchange.run(&pool) => outcome.complete(result),
                // the connection is closed, by which the server learns of the cancellation
                () = outcome.abandoned() => {}
            }
        });
        Ok(pending)
    }
}

/// The outcome that a caller waits for.
enum AwaitedOutcome {
    /// The reply to a request.
    Reply(IncomingCall),
    /// The confirmation that the server has taken the request.
    Delivery(DeliveryReceipt),
}

impl AwaitedOutcome {
    fn complete(self, result: Result<Payload, FailedExchange>) {
        let result = result.map_err(|failed| {
            match (failed.reason, &self) {
                (Some(reason), Self::Reply(call)) => call.explain(reason),
                (Some(reason), Self::Delivery(receipt)) => receipt.explain(reason),
                (None, _) => {}
            }
            failed.failure
        });
        match self {
            Self::Reply(call) => call.complete(result),
            Self::Delivery(receipt) => receipt.complete(result.map(drop)),
        }
    }

    /// Ends when the caller no longer waits.
    async fn abandoned(&self) {
        loop {
            let is_awaited = match self {
                Self::Reply(call) => call.is_awaited(),
                Self::Delivery(receipt) => receipt.is_awaited(),
            };
            if !is_awaited {
                return;
            }
            sleep(TICK).await;
        }
    }
}
