//! The URL of an operation.

use asmotion_bus::BusError;
use hyper::Uri;
use hyper::header::HeaderValue;

/// The server of an operation, and the path on it.
#[derive(Debug, Clone)]
pub(super) struct Target {
    pub server: Server,
    /// Value of the header `Host`.
    pub host: HeaderValue,
    pub path: String,
}

/// A server, by which connections are shared.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Server {
    pub encrypted: bool,
    /// Name or address, without brackets.
    pub host: String,
    pub port: u16,
}

impl Target {
    /// Reads a URL, `http://HOST:PORT/PATH` or `https://HOST:PORT/PATH`.
    pub(super) fn of(url: &str) -> Result<Self, BusError> {
        let invalid = |reason: &str| BusError::InvalidName {
            name: url.to_owned(),
            reason: reason.to_owned(),
        };
        let uri: Uri = url.parse().map_err(|_| invalid("no URL"))?;
        let encrypted = match uri.scheme_str() {
            Some("http") => false,
            Some("https") => true,
            Some(_) | None => return Err(invalid("neither `http` nor `https`")),
        };
        let authority = uri.authority().ok_or_else(|| invalid("no host"))?;
        if authority.as_str().contains('@') {
            return Err(invalid("a user name"));
        }
        let host = authority.host().trim_matches(['[', ']']).to_owned();
        let port = authority.port_u16();
        let server = Server {
            encrypted,
            host,
            port: port.unwrap_or(if encrypted { 443 } else { 80 }),
        };
        let host = HeaderValue::try_from(authority.as_str()).map_err(|_| invalid("no host"))?;
        Ok(Self {
            server,
            host,
            path: uri.path().to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_reads_the_server_and_the_path() {
        for (url, encrypted, host, port, path) in [
            ("http://maps.example/a/b", false, "maps.example", 80, "/a/b"),
            ("https://maps.example", true, "maps.example", 443, "/"),
            ("http://[::1]:8080/x", false, "::1", 8080, "/x"),
        ] {
            let target = Target::of(url).unwrap();
            let server = Server {
                encrypted,
                host: host.to_owned(),
                port,
            };
            assert_eq!((target.server, &*target.path), (server, path));
        }
        for wrong in [
            "",
            "maps",
            "ftp://a/b",
            "http://user:secret@a/b",
            "http:///b",
        ] {
            assert!(Target::of(wrong).is_err(), "{wrong}");
        }
    }
}
