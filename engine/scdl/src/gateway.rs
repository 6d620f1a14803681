//! Where a service is called over HTTP: a `uri` there, a gateway and a name here.

use crate::model::ScdlBinding;

/// Where a gateway listens of which nobody says it.
const USUAL: &str = "127.0.0.1:8080";

/// Where a service of this name is called through a gateway that listens there.
pub(crate) fn uri(listen: &str, name: &str) -> String {
    format!("http://{listen}/services/{name}")
}

/// Where a gateway has to listen for what is called so.
pub(crate) fn listen_for(called: &ScdlBinding) -> String {
    let listen = called.uri.as_ref().and_then(|uri| listen(uri));
    listen.unwrap_or_else(|| USUAL.to_owned())
}

/// The same for an address, if the address says: `127.0.0.1:8085` for `http://localhost:8085/MoveService`.
fn listen(uri: &str) -> Option<String> {
    let (host, _) = uri.strip_prefix("http://")?.split_once('/')?;
    let host = match host.rsplit_once(':') {
        Some(("localhost", port)) => format!("127.0.0.1:{port}"),
        _ => host.to_owned(),
    };
    let is_address = host.parse::<std::net::SocketAddr>().is_ok();
    // one that is substituted is known where it runs
    (is_address || host.contains("${")).then_some(host)
}

/// Whether two addresses are the same.
pub(crate) fn is_same(one: &str, other: &str) -> bool {
    let plain = |uri: &str| uri.replacen("//localhost:", "//127.0.0.1:", 1);
    plain(one) == plain(other)
}
