//! A service that the node provides.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use asmotion_bus::{AddressQueue, CallFailure, Notifier, Payload, PendingCall, Request, SenderId};
use asmotion_datum::ros1;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;
use tokio::sync::Notify;
use tokio::time::{sleep_until, timeout};

use crate::context::Context;
use crate::frame::{FrameError, framed, read_frame};
use crate::header::ConnectionHeader;
use crate::interface::{ANY, ServiceType};
use crate::names::RosName;
use crate::notice::{RosNotice, StatedType, TypeMismatch};
use crate::publication::stated;

/// A service that the node provides.
pub(crate) struct ProvidedService {
    pub(crate) name: RosName,
    pub(crate) of: ServiceType,
    pub(crate) queue: Arc<AddressQueue>,
    pub(crate) unreadable: AtomicU64,
}

impl ProvidedService {
    /// Serves a caller, whose header has been read, until it leaves.
    pub(crate) async fn serve(
        &self,
        context: &Context,
        mut stream: TcpStream,
        header: &ConnectionHeader,
    ) -> Result<(), String> {
        let node: Arc<str> = header.get("callerid").unwrap_or("(unnamed)").into();
        let md5 = header.get("md5sum").unwrap_or_default();
        let _ = stream.set_nodelay(true);
        if md5 != ANY && md5 != &*self.of.md5 {
            let mismatch = TypeMismatch {
                of: self.name.shared(),
                here: StatedType {
                    node: context.name.shared(),
                    name: Arc::clone(&self.of.name),
                    md5: Arc::clone(&self.of.md5),
                    definition: Arc::clone(&self.of.definition),
                },
                there: stated(&node, header),
            };
            let text = mismatch.to_string();
            context.report(RosNotice::Mismatch(Box::new(mismatch)));
            let error = ConnectionHeader::new().with("error", text);
            return self.write(context, &mut stream, &error.encode()).await;
        }
        let accepted = ConnectionHeader::new()
            .with("callerid", context.name.shared())
            .with("type", Arc::clone(&self.of.name))
            .with("md5sum", Arc::clone(&self.of.md5))
            .with("request_type", format!("{}Request", self.of.name))
            .with("response_type", format!("{}Response", self.of.name));
        self.write(context, &mut stream, &accepted.encode()).await?;
        if header.is_set("probe") {
            return Ok(());
        }
        loop {
            let request = match read_frame(&mut stream, context.settings.limits.message).await {
                Ok(request) => request,
                // the caller has left between two requests
                Err(FrameError::Connection(_)) => return Ok(()),
                Err(error @ (FrameError::TooLarge { .. } | FrameError::Truncated { .. })) => {
                    self.unreadable.fetch_add(1, Ordering::Relaxed);
                    return Err(error.to_string());
                }
            };
            let Some(answer) = self.answer(context, &node, &stream, &request).await else {
                return Ok(());
            };
            let mut response = vec![u8::from(answer.is_ok())];
            response.extend(match answer {
                Ok(bytes) => framed(&bytes),
                Err(reason) => framed(reason.as_bytes()),
            });
            self.write(context, &mut stream, &response).await?;
            if !header.is_set("persistent") {
                return Ok(());
            }
        }
    }

    async fn write(
        &self,
        context: &Context,
        stream: &mut TcpStream,
        bytes: &[u8],
    ) -> Result<(), String> {
        let written = timeout(context.settings.timing.stall, stream.write_all(bytes)).await;
        let written = written.map_err(|_| "the caller does not read the response")?;
        written.map_err(|error| error.to_string())
    }

    /// The response to a request, or why there is none; `None` if the caller has left.
    async fn answer(
        &self,
        context: &Context,
        node: &Arc<str>,
        stream: &TcpStream,
        request: &[u8],
    ) -> Option<Result<Vec<u8>, String>> {
        let argument = match ros1::decode(request, &self.of.request) {
            Ok(datum) => Payload::Sample(Arc::new(datum)),
            Err(error) => {
                self.unreadable.fetch_add(1, Ordering::Relaxed);
                context.report(RosNotice::Unreadable {
                    of: format!("a request to `{}`", self.name),
                    peer: node.to_string(),
                    reason: error.to_string(),
                });
                return Some(Err(format!("the request cannot be read: {error}")));
            }
        };
        let origin = SenderId::new(Arc::clone(node), 0);
        let request = Request::new(origin, argument, context.settings.timing.service);
        let ended = Arc::new(Notify::new());
        let notifier = Notifier::calling({
            let ended = Arc::clone(&ended);
            move || ended.notify_one()
        });
        let (pending, incoming) = PendingCall::new(request, Arc::new(notifier));
        // a full queue ends the call
        let _ = self.queue.push(incoming);
        let result = loop {
            if let Some(result) = pending.try_take() {
                break result;
            }
            tokio::select! {
                () = ended.notified() => {}
                () = sleep_until(pending.deadline().into()) => {}
                () = left(stream) => {
                    pending.cancel();
                    return None;
                }
            }
        };
        Some(match result {
            Ok(payload) => self.encode(&payload),
            Err(CallFailure::Refused(refusal)) if refusal.code.is_empty() => Err(refusal.detail),
            Err(failure) => Err(failure.to_string()),
        })
    }

    fn encode(&self, payload: &Payload) -> Result<Vec<u8>, String> {
        let datum = payload.to_datum_of(&self.of.response);
        let encoded = datum.and_then(|datum| ros1::encode(&datum, &self.of.response));
        encoded.map_err(|error| format!("the response cannot be written: {error}"))
    }
}

/// Returns when the other end has closed the connection; never, if it sends.
async fn left(stream: &TcpStream) {
    match stream.peek(&mut [0]).await {
        Ok(0) | Err(_) => {}
        Ok(_) => std::future::pending().await,
    }
}
