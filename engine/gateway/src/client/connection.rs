//! Connections to servers, kept for a moment to be used again.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use http_body_util::Full;
use hyper::body::Bytes;
use hyper::client::conn::http1::{self, SendRequest};
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio::task::AbortHandle;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};

use super::outcome::{FailedExchange, refusal, unavailable};
use super::target::Server;

/// Time for which an idle connection is kept: less than that of common servers, so that a request hardly ever meets a
/// connection that its server is closing.
const IDLE: Duration = Duration::from_millis(1500);
/// Limit on the idle connections to one server.
const MAX_IDLE: usize = 8;

/// Idle connections, and the settings of new ones.
pub(super) struct ConnectionPool {
    idle: Mutex<BTreeMap<Server, Vec<(Instant, Connection)>>>,
    tls: TlsConnector,
}

/// A connection to a server. Dropping it closes it.
pub(super) struct Connection {
    pub sender: SendRequest<Full<Bytes>>,
    task: AbortHandle,
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl std::fmt::Debug for ConnectionPool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "connections to {} servers", self.idle().len())
    }
}

impl ConnectionPool {
    /// Creates a pool whose encrypted connections trust the authorities of this PEM file, or those of the web.
    pub(super) fn new(authorities: Option<&Path>) -> Result<Self, String> {
        Ok(Self {
            idle: Mutex::default(),
            tls: connector(authorities)?,
        })
    }

    fn idle(&self) -> MutexGuard<'_, BTreeMap<Server, Vec<(Instant, Connection)>>> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Removes and returns an idle connection.
    pub(super) fn take(&self, server: &Server) -> Option<Connection> {
        let mut idle = self.idle();
        let connections = idle.get_mut(server)?;
        connections.retain(|(since, it)| since.elapsed() < IDLE && it.sender.is_ready());
        connections.pop().map(|(_, connection)| connection)
    }

    /// Keeps a connection that is ready for another request.
    pub(super) fn put(&self, server: &Server, connection: Connection) {
        let mut idle = self.idle();
        for connections in idle.values_mut() {
            connections.retain(|(since, _)| since.elapsed() < IDLE);
        }
        idle.retain(|_, connections| !connections.is_empty());
        let connections = idle.entry(server.clone()).or_default();
        if connections.len() < MAX_IDLE {
            connections.push((Instant::now(), connection));
        }
    }

    /// Opens a connection. An error means that the server is unavailable.
    pub(super) async fn open(&self, server: &Server) -> Result<Connection, FailedExchange> {
        let stream = TcpStream::connect((&*server.host, server.port)).await;
        let stream = stream.map_err(|error| unavailable(format!("cannot connect: {error}")))?;
        // not essential: without it requests are sent a little later
        let _ = stream.set_nodelay(true);
        if !server.encrypted {
            return handshake(stream).await;
        }
        let name = ServerName::try_from(server.host.clone());
        let name = name.map_err(|error| refusal("NO_TLS", error.to_string()))?;
        let stream = self.tls.connect(name, stream).await;
        let stream = stream.map_err(|error| {
            // a server that cannot be trusted, or that does not encrypt; waiting does not help
            if error.kind() == ErrorKind::InvalidData {
                refusal("NO_TLS", explained(&error.to_string())).into()
            } else {
                unavailable(format!("cannot encrypt the connection: {error}"))
            }
        })?;
        handshake(stream).await
    }
}

/// The reason that a certificate is refused, with the way out where the reason names none.
fn explained(reason: &str) -> String {
    if reason.contains("CaUsedAsEndEntity") {
        "invalid peer certificate: it is the certificate of an authority, as `openssl req -x509` makes them, which is not that of \
         a server: add `-addext basicConstraints=critical,CA:FALSE`, or sign a certificate for the server with it"
            .to_owned()
    } else if reason.contains("UnknownIssuer") {
        format!(
            "{reason}: if it is to be trusted, name the file of its authority as `ca` of the wire"
        )
    } else {
        reason.to_owned()
    }
}

async fn handshake(
    stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
) -> Result<Connection, FailedExchange> {
    let opened = http1::handshake(TokioIo::new(stream)).await;
    let (sender, connection) =
        opened.map_err(|error| unavailable(format!("cannot use the connection: {error}")))?;
    // errors reach the request as well
    let task = tokio::spawn(async move { connection.await.unwrap_or_default() });
    Ok(Connection {
        sender,
        task: task.abort_handle(),
    })
}

fn connector(authorities: Option<&Path>) -> Result<TlsConnector, String> {
    let mut roots = RootCertStore::empty();
    match authorities {
        None => roots.extend(webpki_roots::TLS_SERVER_ROOTS.iter().cloned()),
        Some(file) => {
            let unread = |error| format!("`{}`: {error}", file.display());
            let all = CertificateDer::pem_file_iter(file).and_then(Iterator::collect);
            let all: Vec<CertificateDer<'_>> = all.map_err(unread)?;
            if roots.add_parsable_certificates(all).0 == 0 {
                return Err(format!("`{}`: no certificate", file.display()));
            }
        }
    }
    let provider = Arc::new(ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .map_err(|error| error.to_string())?
        .with_root_certificates(roots)
        .with_no_client_auth();
    Ok(TlsConnector::from(Arc::new(config)))
}
