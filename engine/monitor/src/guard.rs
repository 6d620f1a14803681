//! The guard: which requests are answered at all, and the headers of every response.
//!
//! Listening on a loopback interface is no protection against web pages: every browser on this machine reaches it, for any page
//! that is open in it. Two checks keep other pages out. The `Host` must be one that no page can redirect (DNS rebinding), and a
//! page that sends an `Origin`, as it does with every WebSocket, must come from this very server. Port and name of both must be
//! equal, so that neither another server on this machine qualifies, nor does a tunnel (`ssh -L`) with another port fail. Only the
//! protocol of Foxglove, which changes nothing, is also open to pages of other origins that the user allows.

use asmotion_http::{HttpResponse, host_of, is_host_allowed};
use http_body_util::Full;
use hyper::body::Bytes;
use hyper::header::{HOST, HeaderValue, ORIGIN};
use hyper::{HeaderMap, StatusCode, Uri, header};

/// What pages of this server may do: load from it alone, and appear in no other page. Styles are set by scripts on elements,
/// which needs no exception.
const POLICY: &str = "default-src 'self'; img-src 'self' data:; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; \
                      form-action 'none'; object-src 'none'";

/// The headers of every response.
const HEADERS: &[(&str, &str)] = &[
    ("content-security-policy", POLICY),
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cache-control", "no-store"),
];

/// Checks that a request addresses this server, and that it does not come from another page, except from one of an allowed
/// origin.
///
/// # Errors
/// Status and text of the refusal.
pub(crate) fn check(
    uri: &Uri,
    headers: &HeaderMap,
    allowed: &[String],
) -> Result<(), (StatusCode, String)> {
    let host = host_of(uri, headers).unwrap_or_default();
    if !is_host_allowed(&host, &[]) {
        let text =
            format!("`{host}` is not a name of this dashboard: use its IP address or `localhost`");
        return Err((StatusCode::MISDIRECTED_REQUEST, text));
    }
    let Some(origin) = headers.get(ORIGIN) else {
        return Ok(());
    };
    let own = headers
        .get(HOST)
        .and_then(|host| host.to_str().ok())
        .map(|host| format!("http://{host}"));
    let mut accepted = allowed.iter().map(String::as_str).chain(own.as_deref());
    if accepted.any(|it| origin.as_bytes().eq_ignore_ascii_case(it.as_bytes())) {
        return Ok(());
    }
    let text = "pages of other servers cannot use this dashboard: `--allow-origin` admits viewers such as Foxglove to \
                `/foxglove`"
        .to_owned();
    Err((StatusCode::FORBIDDEN, text))
}

/// A response with the headers of every response.
pub(crate) fn response(
    status: StatusCode,
    kind: &'static str,
    body: impl Into<Bytes>,
) -> HttpResponse {
    let mut response = HttpResponse::new(Full::new(body.into()));
    *response.status_mut() = status;
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
    for (name, value) in HEADERS {
        headers.insert(*name, HeaderValue::from_static(value));
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(host: &str, origin: Option<&str>) -> u16 {
        allowing(&[], host, origin)
    }

    fn allowing(allowed: &[String], host: &str, origin: Option<&str>) -> u16 {
        let mut headers = HeaderMap::new();
        headers.insert(HOST, HeaderValue::from_str(host).unwrap());
        if let Some(origin) = origin {
            headers.insert(ORIGIN, HeaderValue::from_str(origin).unwrap());
        }
        check(&Uri::from_static("/live"), &headers, allowed)
            .map_or_else(|(status, _)| status.as_u16(), |()| 200)
    }

    #[test]
    fn only_pages_of_this_server_under_an_own_name_are_answered() {
        assert_eq!(status("127.0.0.1:7070", None), 200);
        assert_eq!(status("localhost:8080", Some("http://localhost:8080")), 200);
        assert_eq!(status("[::1]:7070", Some("http://[::1]:7070")), 200);
        assert_eq!(status("evil.example", None), 421);
        assert_eq!(
            status(
                "127.0.0.1.evil.example:7070",
                Some("http://127.0.0.1.evil.example:7070")
            ),
            421
        );
        assert_eq!(status("127.0.0.1:7070", Some("http://evil.example")), 403);
        // another server on this machine
        assert_eq!(status("127.0.0.1:7070", Some("http://127.0.0.1:3000")), 403);
        assert_eq!(status("127.0.0.1:7070", Some("http://localhost:7070")), 403);
        assert_eq!(status("127.0.0.1:7070", Some("null")), 403);
    }

    #[test]
    fn a_page_of_an_allowed_origin_is_answered_under_an_own_name() {
        let allowed = ["https://app.foxglove.dev".to_owned(), "file://".to_owned()];
        for (host, origin, expected) in [
            ("localhost:7070", "https://app.foxglove.dev", 200),
            ("localhost:7070", "https://APP.foxglove.dev", 200),
            ("localhost:7070", "file://", 200),
            ("localhost:7070", "http://localhost:7070", 200),
            ("localhost:7070", "http://app.foxglove.dev", 403),
            ("localhost:7070", "https://app.foxglove.dev:444", 403),
            (
                "localhost:7070",
                "https://app.foxglove.dev.evil.example",
                403,
            ),
            ("localhost:7070", "null", 403),
            ("evil.example", "https://app.foxglove.dev", 421),
        ] {
            assert_eq!(allowing(&allowed, host, Some(origin)), expected, "{origin}");
        }
    }
}
