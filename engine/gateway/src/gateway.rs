//! The gateway: listens, limits the number of connections, and shuts down.

use std::convert::Infallible;
use std::net::SocketAddr;
use std::pin::pin;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use asmotion_bus::{Bus, BusError};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Builder;
use tokio::sync::{oneshot, watch};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use crate::components::ComponentListing;
use crate::connections::{ConnectionPlace, OpenConnections};
use crate::handler::RequestHandler;
use crate::problem::Problem;
use crate::service::GatewayService;
use crate::settings::GatewaySettings;

/// Time that calls under way have to end when the gateway closes.
const DRAIN: Duration = Duration::from_secs(2);
/// Limit on connections that wait for the response that the gateway is busy.
const MAX_REJECTIONS: usize = 256;
/// Limit on the time in which such a connection must send its request.
const REJECTION_TIMEOUT: Duration = Duration::from_secs(1);
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
    /// The bus refuses the subscription to the descriptions of components.
    #[error("cannot subscribe to the components: {0}")]
    Components(BusError),
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
    /// Opens a gateway to services on a bus, each operation of which has the address `SERVICE.OPERATION`. The components
    /// are those that the process describes on this bus.
    ///
    /// # Errors
    /// An error if the gateway cannot listen at the address, if the bus refuses it, or if no thread can be started.
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
        let components = ComponentListing::new(&*bus).map_err(GatewayCheckError::Components)?;
        let reception = Arc::new(RequestHandler {
            services,
            components,
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
    let table = OpenConnections::new(handler.settings.max_connections);
    let rejections = OpenConnections::new(MAX_REJECTIONS);
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
                if let Some((place, evicted)) = table.enter() {
                    let served = serve(stream, from, place, Arc::clone(&handler), shutdown.clone());
                    callers.spawn(until_evicted(served, evicted));
                } else if let Some((place, evicted)) = rejections.enter() {
                    callers.spawn(until_evicted(reject(stream, place), evicted));
                }
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
    stream: TcpStream,
    from: SocketAddr,
    place: ConnectionPlace,
    handler: Arc<RequestHandler>,
    mut shutdown: watch::Receiver<bool>,
) {
    let patience = handler.settings.request_timeout;
    let place = Arc::new(place);
    let service = service_fn(|asked| {
        let (handler, place) = (Arc::clone(&handler), Arc::clone(&place));
        async move { Ok::<_, Infallible>(handler.respond(asked, from, &place).await) }
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(patience)
        .serve_connection(TokioIo::new(stream), service);
    let mut connection = pin!(connection);
    tokio::select! {
        // connection errors concern the client only
        _ = connection.as_mut() => return,
        () = shutdown_requested(&mut shutdown) => connection.as_mut().graceful_shutdown(),
    }
    let _ = connection.await;
}

/// Responds to one request that calls are under way on all connections.
async fn reject(stream: TcpStream, _place: ConnectionPlace) {
    let service = service_fn(|_| async { Ok::<_, Infallible>(Problem::Busy.response()) });
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
