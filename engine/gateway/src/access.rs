//! Access to the gateway: the names by which it may be addressed, and the token of its clients.

use std::net::IpAddr;

use hyper::header::{AUTHORIZATION, HOST};
use hyper::http::uri::Authority;
use hyper::{HeaderMap, Uri};

use crate::problem::Problem;
use crate::settings::GatewaySettings;

/// Checks that a request may be handled: that it addresses this gateway and, if the gateway has a token, presents it.
pub(crate) fn check(
    settings: &GatewaySettings,
    uri: &Uri,
    headers: &HeaderMap,
) -> Result<(), Problem> {
    let host = host(uri, headers).unwrap_or_default();
    if !is_allowed(&host, &settings.allowed_hosts) {
        return Err(Problem::OtherHost { host });
    }
    let Some(token) = &settings.token else {
        return Ok(());
    };
    let credentials = headers.get(AUTHORIZATION);
    match credentials.and_then(|credentials| credentials.to_str().ok()) {
        Some(credentials) if token.is_in(credentials) => Ok(()),
        Some(_) | None => Err(Problem::Unauthorized),
    }
}

/// The host that a request addresses, without the port.
fn host(uri: &Uri, headers: &HeaderMap) -> Option<String> {
    if let Some(host) = uri.host() {
        return Some(host.to_owned());
    }
    let authority: Authority = headers.get(HOST)?.to_str().ok()?.parse().ok()?;
    Some(authority.host().to_owned())
}

/// Returns whether a gateway may be addressed by this name.
///
/// A web page can let a domain name of its own point to this machine (DNS rebinding); its requests then have no foreign
/// `Origin`, but they have that name. Addresses and `localhost` cannot be redirected in this way.
fn is_allowed(host: &str, allowed: &[String]) -> bool {
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
    fn only_addresses_localhost_and_allowed_names_address_the_gateway() {
        let allowed = ["rover1.local".to_owned()];
        for name in [
            "127.0.0.1",
            "[::1]",
            "10.0.0.7",
            "localhost",
            "LocalHost.",
            "ROVER1.local",
        ] {
            assert!(is_allowed(name, &allowed), "{name}");
        }
        for name in [
            "",
            "evil.example",
            "localhost.evil.example",
            "127.0.0.1.nip.io",
            "rover1",
        ] {
            assert!(!is_allowed(name, &allowed), "{name}");
        }
    }
}
