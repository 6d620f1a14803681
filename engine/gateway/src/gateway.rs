//! The gateway: who listens, how many are let in, and how it ends.

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

/// How long calls under way may take to end when the gateway closes.
const DRAIN: Duration = Duration::from_secs(2);
/// How long to wait before listening again, where the system had nothing left to listen with.
const REST: Duration = Duration::from_millis(50);

/// Where a gateway listens, and what it bears.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GatewaySettings {
    /// Where; port 0 is a free one.
    pub listen: SocketAddr,
    /// How many may be connected at once; more wait until one leaves.
    pub max_connections: usize,
    /// The longest argument, in bytes.
    pub max_body: usize,
    /// How long a caller may take to say what it wants, and stay without wanting anything.
    pub patience: Duration,
}

impl GatewaySettings {
    /// The usual ones: 64 callers, arguments of a megabyte, ten seconds.
    pub fn at(listen: SocketAddr) -> Self {
        Self {
            listen,
            max_connections: 64,
            max_body: 1 << 20,
            patience: Duration::from_secs(10),
        }
    }
}

/// Why a gateway cannot open.
#[derive(Debug, thiserror::Error)]
pub enum GatewayCheckError {
    /// Nothing can listen there.
    #[error("nothing can listen at {at}: {reason}")]
    Listen {
        /// Where.
        at: SocketAddr,
        /// Why.
        reason: std::io::Error,
    },
    /// There are no threads left.
    #[error("no thread to listen with: {0}")]
    Thread(std::io::Error),
}

/// An open gateway. Dropping it closes it: nobody more is let in, and calls under way have two seconds.
#[derive(Debug)]
pub struct Gateway {
    address: SocketAddr,
    end: watch::Sender<bool>,
    thread: Option<JoinHandle<()>>,
}

impl Gateway {
    /// Opens a gateway to services that are on a bus, each operation at the address `SERVICE.OPERATION`.
    ///
    /// # Errors
    /// Nothing can listen there.
    pub fn open(
        settings: GatewaySettings,
        services: Vec<GatewayService>,
        bus: Arc<dyn Bus>,
    ) -> Result<Self, GatewayCheckError> {
        let at = settings.listen;
        let listen = |reason| GatewayCheckError::Listen { at, reason };
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
            end,
            thread: Some(thread),
        })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Gateway {
    fn drop(&mut self) {
        self.end.send_replace(true);
        if let Some(thread) = self.thread.take() {
            // It runs none but our own code.
            let _ = thread.join();
        }
    }
}

/// Lets callers in until the end, and lets those who are in end what they have begun.
async fn listen_until(
    mut ended: watch::Receiver<bool>,
    listener: TcpListener,
    reception: Arc<RequestHandler>,
) {
    let places = Arc::new(Semaphore::new(reception.settings.max_connections.max(1)));
    let mut callers = JoinSet::new();
    loop {
        tokio::select! {
            () = end(&mut ended) => break,
            Some(_) = callers.join_next() => {}
            caller = next(&listener, &places) => {
                let Some(caller) = caller else {
                    sleep(REST).await;
                    continue;
                };
                callers.spawn(serve(caller, Arc::clone(&reception), ended.clone()));
            }
        }
    }
    drop(listener);
    // Who has not ended by then is hung up on.
    let _ = timeout(DRAIN, async {
        while callers.join_next().await.is_some() {}
    })
    .await;
}

/// Who is connected, and has a place.
struct HttpConnection {
    stream: TcpStream,
    from: SocketAddr,
    _place: OwnedSemaphorePermit,
}

async fn next(listener: &TcpListener, places: &Arc<Semaphore>) -> Option<HttpConnection> {
    let place = Arc::clone(places).acquire_owned().await.ok()?;
    let (stream, from) = listener.accept().await.ok()?;
    Some(HttpConnection {
        stream,
        from,
        _place: place,
    })
}

/// Answers a caller until it leaves. One that leaves has taken its call back: the future of its answer is dropped.
async fn serve(
    caller: HttpConnection,
    reception: Arc<RequestHandler>,
    mut ended: watch::Receiver<bool>,
) {
    let (from, patience) = (caller.from, reception.settings.patience);
    let service = service_fn(|asked| {
        let reception = Arc::clone(&reception);
        async move { Ok::<_, Infallible>(reception.answer(asked, from).await) }
    });
    // It is late by a little, no less right.
    let _ = caller.stream.set_nodelay(true);
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(patience)
        .serve_connection(TokioIo::new(caller.stream), service);
    let mut connection = pin!(connection);
    tokio::select! {
        // What is wrong with a connection is known to its other end.
        _ = connection.as_mut() => return,
        () = end(&mut ended) => connection.as_mut().graceful_shutdown(),
    }
    let _ = connection.await;
}

/// Waits for the end; a gateway that is gone has ended.
async fn end(ended: &mut watch::Receiver<bool>) {
    let _ = ended.wait_for(|ended| *ended).await;
}
