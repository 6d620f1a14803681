//! Connections that others open: to the API, to topics and to services.

use std::sync::Arc;
use std::time::Duration;

use tokio::io::AsyncWriteExt;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};

use crate::context::Context;
use crate::frame::read_header;
use crate::header::ConnectionHeader;
use crate::notice::RosNotice;
use crate::slave::Slave;
use crate::tables::{Tables, entry};

/// Time after which accepting is tried again when the system has no sockets left.
const REST: Duration = Duration::from_millis(100);

/// Accepts calls of the API until the node ends.
pub(crate) async fn serve_api(listener: TcpListener, slave: Arc<Slave>) {
    let slots = Arc::new(Semaphore::new(slave.context.settings.limits.connections));
    loop {
        let Some((stream, peer)) = accept(&slave.context, &listener).await else {
            return;
        };
        let Ok(slot) = Arc::clone(&slots).try_acquire_owned() else {
            refuse(&slave.context, "calls", peer);
            continue;
        };
        let slave = Arc::clone(&slave);
        tokio::spawn(async move {
            slave.serve(stream, peer).await;
            drop(slot);
        });
    }
}

/// Accepts connections to topics and services until the node ends.
pub(crate) async fn serve_data(listener: TcpListener, context: Arc<Context>, tables: Arc<Tables>) {
    let slots = Arc::new(Semaphore::new(context.settings.limits.connections));
    loop {
        let Some((stream, peer)) = accept(&context, &listener).await else {
            return;
        };
        let Ok(slot) = Arc::clone(&slots).try_acquire_owned() else {
            refuse(&context, "topics and services", peer);
            continue;
        };
        let (context, tables) = (Arc::clone(&context), Arc::clone(&tables));
        tokio::spawn(async move {
            let serving = serve_peer(&context, &tables, stream, peer);
            tokio::select! {
                () = serving => {}
                () = context.until_end() => {}
            }
            drop(slot);
        });
    }
}

/// Reports a connection that is one too many, and is closed.
fn refuse(context: &Context, of: &str, peer: String) {
    let limit = context.settings.limits.connections;
    context.report(RosNotice::Disconnected {
        of: of.into(),
        peer,
        reason: format!("more than {limit} connections"),
    });
}

/// The next connection and the address of its other end; `None` when the node ends.
async fn accept(context: &Context, listener: &TcpListener) -> Option<(TcpStream, String)> {
    loop {
        tokio::select! {
            () = context.until_end() => return None,
            accepted = listener.accept() => match accepted {
                Ok((stream, peer)) => return Some((stream, peer.to_string())),
                Err(_) => sleep(REST).await,
            }
        }
    }
}

async fn serve_peer(context: &Context, tables: &Tables, mut stream: TcpStream, peer: String) {
    let limit = context.settings.timing.connect;
    let header = timeout(limit, read_header(&mut stream)).await;
    let header = match header.unwrap_or_else(|_| Err(format!("no header within {limit:?}"))) {
        Ok(header) => header,
        Err(reason) => {
            context.report(RosNotice::Unreadable {
                of: "the header of a connection".to_owned(),
                peer,
                reason,
            });
            return;
        }
    };
    let (topic, service) = (header.get("topic"), header.get("service"));
    let (of, ended) = if let Some(name) = topic
        && let Some(publication) = entry(&tables.publications, name)
    {
        (name, publication.serve(context, stream, &header).await)
    } else if let Some(name) = service
        && let Some(service) = entry(&tables.services, name)
    {
        (name, service.serve(context, stream, &header).await)
    } else {
        let name = topic.or(service).unwrap_or_default();
        let reason = format!("this node has no topic or service `{name}`");
        let error = ConnectionHeader::new().with("error", reason);
        let _ = timeout(limit, stream.write_all(&error.encode())).await;
        return;
    };
    if let Err(reason) = ended {
        let peer = match header.get("callerid") {
            Some(name) => format!("`{name}`"),
            None => peer,
        };
        context.report(RosNotice::Disconnected {
            of: of.into(),
            peer,
            reason,
        });
    }
}
