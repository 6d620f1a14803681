//! HTTP addresses of services: SCDL has a `uri`, a composite file has a gateway and a name.

use crate::model::ScdlBinding;

/// The address of a gateway whose `uri` does not specify one.
const USUAL: &str = "127.0.0.1:8080";

/// URI of a service with this name, provided by a gateway at this address.
pub(crate) fn uri(listen: &str, name: &str) -> String {
    format!("http://{listen}/services/{name}")
}

/// Address at which a gateway must listen to serve this binding.
pub(crate) fn listen_for(called: &ScdlBinding) -> String {
    let listen = called.uri.as_ref().and_then(|uri| listen(uri));
    listen.unwrap_or_else(|| USUAL.to_owned())
}

/// The address in a URI, if there is one: `127.0.0.1:8085` for `http://localhost:8085/MoveService`.
fn listen(uri: &str) -> Option<String> {
    let (host, _) = uri.strip_prefix("http://")?.split_once('/')?;
    let host = match host.rsplit_once(':') {
        Some(("localhost", port)) => format!("127.0.0.1:{port}"),
        _ => host.to_owned(),
    };
    let is_address = host.parse::<std::net::SocketAddr>().is_ok();
    // an address with a variable is known only at run time
    (is_address || host.contains("${")).then_some(host)
}

/// Returns whether two URIs are equal, with `localhost` and `127.0.0.1` as synonyms.
pub(crate) fn is_same(one: &str, other: &str) -> bool {
    let plain = |uri: &str| uri.replacen("//localhost:", "//127.0.0.1:", 1);
    plain(one) == plain(other)
}
