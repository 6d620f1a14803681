//! Access to the gateway: the names by which it may be addressed, and the token of its clients.

use asmotion_http::{host_of, is_host_allowed};
use hyper::header::AUTHORIZATION;
use hyper::{HeaderMap, Uri};

use crate::problem::Problem;
use crate::settings::GatewaySettings;

/// Checks that a request may be handled: that it addresses this gateway and, if the gateway has a token, presents it.
pub(crate) fn check(
    settings: &GatewaySettings,
    uri: &Uri,
    headers: &HeaderMap,
) -> Result<(), Problem> {
    let host = host_of(uri, headers).unwrap_or_default();
    if !is_host_allowed(&host, &settings.allowed_hosts) {
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
