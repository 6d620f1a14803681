//! Calls of services that other nodes provide.

use std::sync::Arc;
use std::time::Instant;

use asmotion_bus::{CallFailure, IncomingCall, Notifier, Payload, PendingCall, Refusal, Request};
use asmotion_datum::ros1;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::runtime::Handle;
use tokio::sync::{Semaphore, mpsc};
use tokio::time::{sleep, timeout_at};

use crate::context::{Context, MasterAnswer};
use crate::frame::{FrameError, framed, read_frame, read_header};
use crate::header::ConnectionHeader;
use crate::interface::{ANY, ServiceType};
use crate::names::RosName;
use crate::notice::{RosNotice, StatedType, TypeMismatch};
use crate::publication::stated;
use crate::settings::Retry;
use crate::xmlrpc::XmlRpcValue;

/// Code of a [`Refusal`]: the provider failed, in its words.
pub const FAILED: &str = "failed";
/// Code of a [`Refusal`]: the provider has another type.
pub const MISMATCH: &str = "mismatch";
/// Code of a [`Refusal`]: the connection ended before the response, so the provider may have carried out the request.
pub const DIED: &str = "died";
/// Code of a [`Refusal`]: the request or the response does not follow the type.
pub const UNREADABLE: &str = "unreadable";

/// Calls a service. Dropping it ends its connection.
pub struct RosServiceClient {
    service: Arc<CalledService>,
    tasks: Handle,
    /// Calls in progress.
    slots: Arc<Semaphore>,
    /// The task with the connection of a persistent client.
    line: Option<mpsc::Sender<Call>>,
}

struct CalledService {
    context: Arc<Context>,
    name: RosName,
    of: ServiceType,
    is_persistent: bool,
}

struct Call {
    incoming: IncomingCall,
    awaits_provider: bool,
}

impl RosServiceClient {
    pub(crate) fn new(
        context: Arc<Context>,
        tasks: Handle,
        name: RosName,
        of: ServiceType,
        is_persistent: bool,
    ) -> Self {
        let limit = context.settings.limits.calls.max(1);
        let service = Arc::new(CalledService {
            context,
            name,
            of,
            is_persistent,
        });
        let line = is_persistent.then(|| {
            let (line, calls) = mpsc::channel(limit);
            tasks.spawn(keep_line(Arc::clone(&service), calls));
            line
        });
        Self {
            service,
            tasks,
            slots: Arc::new(Semaphore::new(limit)),
            line,
        }
    }

    /// Calls the service. Never blocks; the call ends with a response, with a typed failure, or at the deadline.
    ///
    /// Without a provider it ends with [`CallFailure::Unavailable`], unless the request
    /// [awaits one](Request::awaits_provider). A [`Refusal`] has one of the codes [`FAILED`], [`MISMATCH`], [`DIED`] and [`UNREADABLE`].
    /// Calls of a persistent client are executed one after the other.
    pub fn call(&self, request: Request, notifier: Arc<Notifier>) -> PendingCall {
        let awaits_provider = request.awaits_provider;
        let (pending, incoming) = PendingCall::new(request, notifier);
        let call = Call {
            incoming,
            awaits_provider,
        };
        match &self.line {
            // a call that is dropped ends as unavailable
            Some(line) => drop(line.try_send(call)),
            None => {
                if let Ok(slot) = Arc::clone(&self.slots).try_acquire_owned() {
                    let service = Arc::clone(&self.service);
                    self.tasks.spawn(async move {
                        service.execute(call, &mut None).await;
                        drop(slot);
                    });
                }
            }
        }
        pending
    }

    /// Calls the service with a datum, and waits for the response. Not for cycles, which do not wait.
    ///
    /// # Errors
    /// As [`call`](Self::call).
    pub fn call_and_wait(&self, request: Request) -> Result<Payload, CallFailure> {
        self.call(request, Arc::new(Notifier::new())).wait()
    }
}

impl std::fmt::Debug for RosServiceClient {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "client of `{}`", self.service.name)
    }
}

/// Executes the calls of a persistent client.
async fn keep_line(service: Arc<CalledService>, mut calls: mpsc::Receiver<Call>) {
    let mut stream = None;
    while let Some(call) = calls.recv().await {
        service.execute(call, &mut stream).await;
    }
}

impl CalledService {
    /// Executes a call. The connection is kept in `kept` if it is persistent and can be used again.
    async fn execute(&self, call: Call, kept: &mut Option<TcpStream>) {
        let Call {
            incoming,
            awaits_provider,
        } = call;
        if !incoming.is_awaited() {
            return;
        }
        let deadline = incoming.deadline;
        let exchange = self.exchange(&incoming.argument, awaits_provider, deadline, kept);
        match timeout_at(deadline.into(), exchange).await {
            Ok(result) => incoming.complete(result),
            Err(_) => {
                // its response may still come, and belongs to no later call
                *kept = None;
                incoming.complete(Err(CallFailure::Timeout));
            }
        }
    }

    async fn exchange(
        &self,
        argument: &Payload,
        awaits_provider: bool,
        deadline: Instant,
        kept: &mut Option<TcpStream>,
    ) -> Result<Payload, CallFailure> {
        let datum = argument.to_datum_of(&self.of.request);
        let request = datum.and_then(|datum| ros1::encode(&datum, &self.of.request));
        let request = request.map_err(|error| refusal(UNREADABLE, &error))?;
        let request = framed(&request);
        // a provider may have closed a kept connection; a request that was not sent can be sent again
        if let Some(mut stream) = kept.take()
            && is_open(&stream)
            && stream.write_all(&request).await.is_ok()
        {
            return self.response(stream, kept).await;
        }
        let mut retry = Retry::new(&self.context.settings.timing);
        let mut stream = loop {
            match self.connect().await {
                Ok(stream) => break stream,
                Err(CallFailure::Unavailable) if awaits_provider && Instant::now() < deadline => {
                    sleep(retry.next_delay()).await;
                }
                Err(failure) => return Err(failure),
            }
        };
        let written = stream.write_all(&request).await;
        written.map_err(|error| self.unavailable(error.to_string()))?;
        self.response(stream, kept).await
    }

    fn unavailable(&self, reason: String) -> CallFailure {
        self.context.report(RosNotice::Disconnected {
            of: self.name.shared(),
            peer: "the provider".to_owned(),
            reason,
        });
        CallFailure::Unavailable
    }

    async fn connect(&self) -> Result<TcpStream, CallFailure> {
        let name = XmlRpcValue::text(self.name.as_str());
        let found = match self.context.master("lookupService", &[name]).await {
            Ok(found) => found,
            Err(MasterAnswer::Refused(_)) => return Err(CallFailure::Unavailable),
            Err(MasterAnswer::None(reason)) => return Err(self.unavailable(reason)),
        };
        let address = found.as_text().and_then(|it| it.strip_prefix("rosrpc://"));
        let address = address.and_then(|it| format!("http://{it}").parse().ok());
        let Some(address): Option<crate::http::RosUri> = address else {
            let reason = "the address of the provider is not `rosrpc://HOST:PORT`";
            return Err(self.unavailable(reason.to_owned()));
        };
        let unavailable = |error: std::io::Error| self.unavailable(error.to_string());
        let stream = TcpStream::connect((address.host(), address.port())).await;
        let mut stream = stream.map_err(unavailable)?;
        let _ = stream.set_nodelay(true);
        let mut header = ConnectionHeader::new()
            .with("callerid", self.context.name.shared())
            .with("service", self.name.shared())
            .with("type", Arc::clone(&self.of.name))
            .with("md5sum", Arc::clone(&self.of.md5));
        if self.is_persistent {
            header = header.with("persistent", "1");
        }
        stream
            .write_all(&header.encode())
            .await
            .map_err(unavailable)?;
        let answer = read_header(&mut stream).await;
        let answer = answer.map_err(|reason| self.unavailable(reason))?;
        let stated_md5 = answer.get("md5sum").unwrap_or(ANY);
        if stated_md5 != ANY && stated_md5 != &*self.of.md5 {
            let node: Arc<str> = answer.get("callerid").unwrap_or("(unnamed)").into();
            let mismatch = TypeMismatch {
                of: self.name.shared(),
                here: StatedType {
                    node: self.context.name.shared(),
                    name: Arc::clone(&self.of.name),
                    md5: Arc::clone(&self.of.md5),
                    definition: Arc::clone(&self.of.definition),
                },
                there: stated(&node, &answer),
            };
            let failure = refusal(MISMATCH, &mismatch);
            self.context.report(RosNotice::Mismatch(Box::new(mismatch)));
            return Err(failure);
        }
        match answer.get("error") {
            // providers refuse a header because of its type, or because the service has just ended
            Some(error) if error.contains("md5") || error.contains("type") => {
                Err(refusal(MISMATCH, &error))
            }
            Some(error) => Err(self.unavailable(error.to_owned())),
            None => Ok(stream),
        }
    }

    async fn response(
        &self,
        mut stream: TcpStream,
        kept: &mut Option<TcpStream>,
    ) -> Result<Payload, CallFailure> {
        let limit = self.context.settings.limits.message;
        let is_success = stream.read_u8().await;
        let is_success = is_success.map_err(|error| refusal(DIED, &error))? == 1;
        let bytes = read_frame(&mut stream, limit).await;
        let bytes = bytes.map_err(|error| match &error {
            FrameError::Connection(_) | FrameError::Truncated { .. } => refusal(DIED, &error),
            FrameError::TooLarge { .. } => refusal(UNREADABLE, &error),
        })?;
        // a failure of the service is none of the connection
        if self.is_persistent {
            *kept = Some(stream);
        }
        if !is_success {
            let detail = String::from_utf8_lossy(&bytes);
            return Err(refusal(FAILED, &detail));
        }
        let datum = ros1::decode(&bytes, &self.of.response);
        let datum = datum.map_err(|error| refusal(UNREADABLE, &error))?;
        Ok(Payload::Sample(Arc::new(datum)))
    }
}

/// Whether a connection on which nothing is expected is still open.
fn is_open(stream: &TcpStream) -> bool {
    let read = stream.try_read(&mut [0]);
    read.is_err_and(|error| error.kind() == std::io::ErrorKind::WouldBlock)
}

fn refusal(code: &str, detail: &dyn std::fmt::Display) -> CallFailure {
    CallFailure::Refused(Refusal {
        code: code.to_owned(),
        detail: detail.to_string(),
    })
}
