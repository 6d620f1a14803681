//! The listener: accepts, limits the number of connections, and shuts down.

use std::convert::Infallible;
use std::net::SocketAddr;
use std::pin::pin;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Builder;
use tokio::sync::{oneshot, watch};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use crate::connections::{ConnectionPlace, OpenConnections};

/// Time that calls under way have to end when the listener closes.
const DRAIN: Duration = Duration::from_secs(2);
/// Limit on connections that wait for the response that the server is busy.
const MAX_REJECTIONS: usize = 256;
/// Limit on the time in which such a connection must send its request.
const REJECTION_TIMEOUT: Duration = Duration::from_secs(1);
/// Pause before listening again after an error of `accept`, for example for want of file descriptors.
const REST: Duration = Duration::from_millis(50);

/// An HTTP request whose body has not been read yet.
pub type HttpRequest = hyper::Request<Incoming>;

/// A response whose body is in memory.
pub type HttpResponse = hyper::Response<Full<Bytes>>;

/// Handles the requests of all connections of a [`Listener`], in its thread.
pub trait HttpHandler: Send + Sync + 'static {
    /// Responds to a request. Dropping the future, because the client has closed the connection, cancels what it does.
    fn respond(
        &self,
        request: HttpRequest,
        from: SocketAddr,
        place: &Arc<ConnectionPlace>,
    ) -> impl Future<Output = HttpResponse> + Send;

    /// The response to a request for which there is no place.
    fn busy(&self) -> HttpResponse;

    /// Ends what responses have begun, such as the connections of WebSockets. The default has nothing to end.
    fn close(&self) -> impl Future<Output = ()> + Send {
        std::future::ready(())
    }
}

/// Address and limits of a listener.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ListenerSettings {
    /// Address to listen at; port 0 selects a free one.
    pub address: SocketAddr,
    /// Limit on simultaneous connections. A further one replaces the connection that has been idle for the longest time; if
    /// calls are under way on all of them, it is rejected.
    pub max_connections: usize,
    /// Limit on the time in which a request's header must arrive, and on the idle time of a connection.
    pub request_timeout: Duration,
    /// Name of the thread.
    pub thread: &'static str,
}

/// An error when a listener opens.
#[derive(Debug, thiserror::Error)]
pub enum ListenError {
    /// The address cannot be listened at.
    #[error("cannot listen at {address}: {reason}")]
    Listen {
        /// Address and port, as requested.
        address: SocketAddr,
        /// The operating system's reason.
        reason: std::io::Error,
    },
    /// No thread can be started.
    #[error("cannot start the listening thread: {0}")]
    Thread(std::io::Error),
}

/// An open listener. Dropping this closes it: new connections are refused, and calls under way have two seconds to end.
#[derive(Debug)]
pub struct Listener {
    address: SocketAddr,
    shutdown: watch::Sender<bool>,
    thread: Option<JoinHandle<()>>,
}

impl Listener {
    /// Listens at an address.
    ///
    /// # Errors
    /// An error if it cannot listen at the address, or if no thread can be started.
    pub fn open(
        settings: ListenerSettings,
        handler: Arc<impl HttpHandler>,
    ) -> Result<Self, ListenError> {
        let at = settings.address;
        let listen = |reason| ListenError::Listen {
            address: at,
            reason,
        };
        let listener = std::net::TcpListener::bind(at).map_err(listen)?;
        listener.set_nonblocking(true).map_err(listen)?;
        let address = listener.local_addr().map_err(listen)?;
        let runtime = Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(ListenError::Thread)?;
        let listener = {
            let _inside = runtime.enter();
            TcpListener::from_std(listener).map_err(listen)?
        };
        let (end, ended) = watch::channel(false);
        let thread = std::thread::Builder::new()
            .name(settings.thread.to_owned())
            .spawn(move || runtime.block_on(listen_until(ended, listener, handler, settings)))
            .map_err(ListenError::Thread)?;
        Ok(Self {
            address,
            shutdown: end,
            thread: Some(thread),
        })
    }

    /// The address it listens at, with the selected port.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.shutdown.send_replace(true);
        if let Some(thread) = self.thread.take() {
            // ends without panicking: it runs only our own code
            let _ = thread.join();
        }
    }
}

/// Accepts connections until `shutdown` is set, then lets them finish their requests.
async fn listen_until(
    mut shutdown: watch::Receiver<bool>,
    listener: TcpListener,
    handler: Arc<impl HttpHandler>,
    settings: ListenerSettings,
) {
    let table = OpenConnections::new(settings.max_connections);
    let rejections = OpenConnections::new(MAX_REJECTIONS);
    let patience = settings.request_timeout;
    let mut callers = JoinSet::new();
    loop {
        tokio::select! {
            () = shutdown_requested(&mut shutdown) => break,
            Some(_) = callers.join_next() => {}
            caller = listener.accept() => {
                let Ok((stream, from)) = caller else {
                    sleep(REST).await;
                    continue;
                };
                // not essential: without it responses arrive a little later
                let _ = stream.set_nodelay(true);
                let handler = Arc::clone(&handler);
                if let Some((place, evicted)) = table.enter() {
                    let served = serve((stream, from), place, handler, patience, shutdown.clone());
                    callers.spawn(until_evicted(served, evicted));
                } else if let Some((place, evicted)) = rejections.enter() {
                    callers.spawn(until_evicted(reject(stream, place, handler), evicted));
                }
            }
        }
    }
    drop(listener);
    // remaining connections are closed
    let _ = timeout(DRAIN, async {
        handler.close().await;
        while callers.join_next().await.is_some() {}
    })
    .await;
}

/// Serves a connection until its place is needed for another one.
async fn until_evicted(served: impl Future<Output = ()>, evicted: oneshot::Receiver<()>) {
    tokio::select! {
        () = served => {}
        _ = evicted => {}
    }
}

/// Serves a connection until the client closes it. This drops the future of a request under way, which cancels its
/// call.
async fn serve(
    (stream, from): (TcpStream, SocketAddr),
    place: ConnectionPlace,
    handler: Arc<impl HttpHandler>,
    patience: Duration,
    mut shutdown: watch::Receiver<bool>,
) {
    let place = Arc::new(place);
    let service = service_fn(|asked| {
        let (handler, place) = (Arc::clone(&handler), Arc::clone(&place));
        async move { Ok::<_, Infallible>(handler.respond(asked, from, &place).await) }
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(patience)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    let mut connection = pin!(connection);
    tokio::select! {
        // connection errors concern the client only
        _ = connection.as_mut() => return,
        () = shutdown_requested(&mut shutdown) => connection.as_mut().graceful_shutdown(),
    }
    let _ = connection.await;
}

/// Responds to one request that calls are under way on all connections.
async fn reject(stream: TcpStream, _place: ConnectionPlace, handler: Arc<impl HttpHandler>) {
    let service = service_fn(|_| {
        let response = handler.busy();
        async move { Ok::<_, Infallible>(response) }
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(REJECTION_TIMEOUT)
        .keep_alive(false)
        .serve_connection(TokioIo::new(stream), service);
    // connection errors concern the client only
    let _ = timeout(REJECTION_TIMEOUT, connection).await;
}

/// Waits for `shutdown`; a dropped sender counts as the end.
async fn shutdown_requested(ended: &mut watch::Receiver<bool>) {
    let _ = ended.wait_for(|ended| *ended).await;
}
