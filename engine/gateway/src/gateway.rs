//! The gateway: listens, limits the number of connections, and shuts down.

use std::convert::Infallible;
use std::net::SocketAddr;
use std::pin::pin;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use asmotion_bus::Bus;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Builder;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use crate::handler::RequestHandler;
use crate::service::GatewayService;
use crate::settings::GatewaySettings;

/// Time that calls under way have to end when the gateway closes.
const DRAIN: Duration = Duration::from_secs(2);
/// Pause before listening again after an error of `accept`, for example for want of file descriptors.
const REST: Duration = Duration::from_millis(50);

/// An error when a gateway opens.
#[derive(Debug, thiserror::Error)]
pub enum GatewayCheckError {
    /// The address cannot be listened at.
    #[error("cannot listen at {address}: {reason}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The operating system's reason.
        reason: std::io::Error,
    },
    /// No thread can be started.
    #[error("cannot start the listening thread: {0}")]
    Thread(std::io::Error),
}

/// An open gateway. Dropping this closes it: new connections are refused, and calls under way have two seconds to end.
#[derive(Debug)]
pub struct Gateway {
    address: SocketAddr,
    shutdown: watch::Sender<bool>,
    thread: Option<JoinHandle<()>>,
}

impl Gateway {
    /// Opens a gateway to services on a bus, each operation of which has the address `SERVICE.OPERATION`.
    ///
    /// # Errors
    /// An error if the gateway cannot listen at the address, or if no thread can be started.
    pub fn open(
        settings: GatewaySettings,
        services: Vec<GatewayService>,
        bus: Arc<dyn Bus>,
    ) -> Result<Self, GatewayCheckError> {
        let at = settings.listen;
        let listen = |reason| GatewayCheckError::Listen {
            address: at,
            reason,
        };
        let listener = std::net::TcpListener::bind(at).map_err(listen)?;
        listener.set_nonblocking(true).map_err(listen)?;
        let address = listener.local_addr().map_err(listen)?;
        let runtime = Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(GatewayCheckError::Thread)?;
        let listener = {
            let _inside = runtime.enter();
            TcpListener::from_std(listener).map_err(listen)?
        };
        let reception = Arc::new(RequestHandler {
            services,
            bus,
            settings,
        });
        let (end, ended) = watch::channel(false);
        let thread = std::thread::Builder::new()
            .name("http".to_owned())
            .spawn(move || runtime.block_on(listen_until(ended, listener, reception)))
            .map_err(GatewayCheckError::Thread)?;
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

impl Drop for Gateway {
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
    handler: Arc<RequestHandler>,
) {
    let connection_permits = Arc::new(Semaphore::new(handler.settings.max_connections.max(1)));
    let mut callers = JoinSet::new();
    loop {
        tokio::select! {
            () = shutdown_requested(&mut shutdown) => break,
            Some(_) = callers.join_next() => {}
            caller = accept(&listener, &connection_permits) => {
                let Some(caller) = caller else {
                    sleep(REST).await;
                    continue;
                };
                callers.spawn(serve(caller, Arc::clone(&handler), shutdown.clone()));
            }
        }
    }
    drop(listener);
    // remaining connections are closed
    let _ = timeout(DRAIN, async {
        while callers.join_next().await.is_some() {}
    })
    .await;
}

/// A connection that counts towards the limit.
struct HttpConnection {
    stream: TcpStream,
    from: SocketAddr,
    _permit: OwnedSemaphorePermit,
}

async fn accept(
    listener: &TcpListener,
    connection_permits: &Arc<Semaphore>,
) -> Option<HttpConnection> {
    let permit = Arc::clone(connection_permits).acquire_owned().await.ok()?;
    let (stream, from) = listener.accept().await.ok()?;
    Some(HttpConnection {
        stream,
        from,
        _permit: permit,
    })
}

/// Serves a connection until the client closes it. This drops the future of a request under way, which cancels its
/// call.
async fn serve(
    connection: HttpConnection,
    handler: Arc<RequestHandler>,
    mut shutdown: watch::Receiver<bool>,
) {
    let (from, patience) = (connection.from, handler.settings.request_timeout);
    let service = service_fn(|asked| {
        let reception = Arc::clone(&handler);
        async move { Ok::<_, Infallible>(reception.respond(asked, from).await) }
    });
    // not essential: without it responses arrive a little later
    let _ = connection.stream.set_nodelay(true);
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(patience)
        .serve_connection(TokioIo::new(connection.stream), service);
    let mut connection = pin!(connection);
    tokio::select! {
        // connection errors concern the client only
        _ = connection.as_mut() => return,
        () = shutdown_requested(&mut shutdown) => connection.as_mut().graceful_shutdown(),
    }
    let _ = connection.await;
}

/// Waits for `shutdown`; a dropped sender counts as the end.
async fn shutdown_requested(ended: &mut watch::Receiver<bool>) {
    let _ = ended.wait_for(|ended| *ended).await;
}
