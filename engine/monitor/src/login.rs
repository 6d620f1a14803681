//! The login of a browser: it presents the token once, and has a cookie from then on.
//!
//! Scripts of the page cannot read the cookie (`HttpOnly`), other sites cannot have it sent (`SameSite=Strict`), and it is sent to
//! `/live` only. A browser sends it to every server of the same host name, whatever the port: a cookie therefore counts only together
//! with an `Origin`, which the [guard](crate::guard) compares with name and port of this server. Its name has the port, so that the
//! cookies of several dashboards do not displace each other. It is valid as long as the token: until the run ends.

use hyper::HeaderMap;
use hyper::header::{AUTHORIZATION, COOKIE, HOST, HeaderValue, ORIGIN};

use crate::desk::Desk;

/// The path to which the cookie is sent.
pub(crate) const COOKIE_PATH: &str = "/live";

/// Name of the cookie of the server that a request addresses: its host name can have servers at other ports.
fn cookie_name(headers: &HeaderMap) -> String {
    let host = headers.get(HOST).and_then(|host| host.to_str().ok());
    let port = host.and_then(|host| host.rsplit_once(':'));
    let port = port.map(|(_, port)| port).filter(|port| is_number(port));
    format!("asmotion-control-{}", port.unwrap_or("80"))
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|it| it.is_ascii_digit())
}

/// Returns whether a request comes from a browser that has logged in, on a page of this server. The request must have passed the guard.
pub(crate) fn has_logged_in(headers: &HeaderMap, desk: &Desk) -> bool {
    // a program that sends no origin presents the token itself
    if !headers.contains_key(ORIGIN) {
        return false;
    }
    let name = cookie_name(headers);
    let lines = headers.get_all(COOKIE).iter();
    let lines = lines.filter_map(|line| line.to_str().ok());
    let mut cookies = lines.flat_map(|line| line.split(';'));
    cookies.any(|cookie| {
        let Some((known, value)) = cookie.trim().split_once('=') else {
            return false;
        };
        known == name && desk.knows(value)
    })
}

/// The cookie of a browser that presents the token in the header `Authorization`, as a value of `Set-Cookie`.
///
/// # Errors
/// The request comes from no page, or its token is missing or wrong.
pub(crate) fn log_in(headers: &HeaderMap, desk: &Desk) -> Result<HeaderValue, &'static str> {
    if !headers.contains_key(ORIGIN) {
        return Err("only a page of this dashboard can log in: programs send the token with `arm`");
    }
    let credentials = headers.get(AUTHORIZATION).and_then(|it| it.to_str().ok());
    let token = credentials.and_then(|it| it.strip_prefix("Bearer "));
    let Some(token) = token.filter(|token| desk.knows(token)) else {
        return Err("missing or wrong token: open the address that was printed when the run began");
    };
    let name = cookie_name(headers);
    let cookie = format!("{name}={token}; Path={COOKIE_PATH}; HttpOnly; SameSite=Strict");
    let mut cookie = HeaderValue::try_from(cookie).map_err(|_| "this token is no cookie")?;
    cookie.set_sensitive(true);
    Ok(cookie)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::desk::OrderBus;
    use asmotion_bus::LocalBus;
    use asmotion_http::BearerToken;
    use std::sync::Arc;
    use std::time::Duration;

    fn desk() -> Desk {
        let orders = OrderBus {
            bus: Arc::new(LocalBus::new()),
            process: "rover".to_owned(),
        };
        Desk::new(
            Some(orders),
            Some(BearerToken::new("c0ffee")),
            Duration::from_secs(60),
        )
    }

    fn headers(pairs: &[(&'static str, &str)]) -> HeaderMap {
        let mut headers = HeaderMap::new();
        for (name, value) in pairs {
            headers.append(*name, HeaderValue::from_str(value).unwrap());
        }
        headers
    }

    #[test]
    fn a_cookie_counts_under_the_name_of_its_port_and_only_on_a_page() {
        let own = ("origin", "http://127.0.0.1:7070");
        let host = ("host", "127.0.0.1:7070");
        let counts = |pairs: &[(&'static str, &str)]| has_logged_in(&headers(pairs), &desk());
        let cookie = ("cookie", "theme=dark; asmotion-control-7070=c0ffee");
        assert!(counts(&[host, own, cookie]));
        // as another program sends it, or a browser without a page
        assert!(!counts(&[host, cookie]));
        assert!(!counts(&[("host", "127.0.0.1:7071"), own, cookie]));
        for wrong in [
            "asmotion-control-7070=c0ffe",
            "asmotion-control-7070=",
            "asmotion-control-7070",
            "xasmotion-control-7070=c0ffee",
            "asmotion-control=c0ffee",
        ] {
            assert!(!counts(&[host, own, ("cookie", wrong)]), "{wrong}");
        }
        // a stale cookie of an earlier run beside it, in a header of its own
        assert!(counts(&[
            host,
            own,
            ("cookie", "asmotion-control-7070=old"),
            ("cookie", "asmotion-control-7070=c0ffee")
        ]));
    }

    #[test]
    fn the_token_gives_a_cookie_that_scripts_and_other_sites_do_not_get() {
        let host = ("host", "localhost:7070");
        let own = ("origin", "http://localhost:7070");
        let token = ("authorization", "Bearer c0ffee");
        let cookie = log_in(&headers(&[host, own, token]), &desk()).unwrap();
        assert_eq!(
            cookie.to_str().unwrap(),
            "asmotion-control-7070=c0ffee; Path=/live; HttpOnly; SameSite=Strict"
        );
        assert!(cookie.is_sensitive());
        assert!(log_in(&headers(&[host, token]), &desk()).is_err());
        assert!(log_in(&headers(&[host, own]), &desk()).is_err());
        let wrong = ("authorization", "Bearer c0ffe");
        assert!(log_in(&headers(&[host, own, wrong]), &desk()).is_err());
        // without `--control`, there is nothing to log in for
        let closed = Desk::new(None, None, Duration::from_secs(60));
        assert!(log_in(&headers(&[host, own, token]), &closed).is_err());
    }
}
