//! The names by which a server may be addressed.

use std::net::IpAddr;

use hyper::header::HOST;
use hyper::http::uri::Authority;
use hyper::{HeaderMap, Uri};

/// The host that a request addresses, without the port; `None` if it names none.
pub fn host_of(uri: &Uri, headers: &HeaderMap) -> Option<String> {
    if let Some(host) = uri.host() {
        return Some(host.to_owned());
    }
    let authority: Authority = headers.get(HOST)?.to_str().ok()?.parse().ok()?;
    Some(authority.host().to_owned())
}

/// Returns whether a server may be addressed by this name: by an address, as `localhost`, or by one of the allowed names.
///
/// A web page can let a domain name of its own point to this machine (DNS rebinding); its requests then have no foreign
/// `Origin`, but they have that name. Addresses and `localhost` cannot be redirected in this way.
pub fn is_host_allowed(host: &str, allowed: &[String]) -> bool {
    let host = host.strip_suffix('.').unwrap_or(host);
    let address = host.trim_start_matches('[').trim_end_matches(']');
    address.parse::<IpAddr>().is_ok()
        || host.eq_ignore_ascii_case("localhost")
        || allowed.iter().any(|name| name.eq_ignore_ascii_case(host))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_addresses_localhost_and_allowed_names_address_the_server() {
        let allowed = ["rover1.local".to_owned()];
        for name in [
            "127.0.0.1",
            "[::1]",
            "10.0.0.7",
            "localhost",
            "LocalHost.",
            "ROVER1.local",
        ] {
            assert!(is_host_allowed(name, &allowed), "{name}");
        }
        for name in [
            "",
            "evil.example",
            "localhost.evil.example",
            "127.0.0.1.nip.io",
            "rover1",
        ] {
            assert!(!is_host_allowed(name, &allowed), "{name}");
        }
    }
}
