//! Calls over HTTP, with limits on time and size.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::client::conn::http1;
use hyper::header::{CONNECTION, CONTENT_TYPE, HOST};
use hyper::{Method, Request, StatusCode};
use hyper_util::rt::TokioIo;
use tokio::net::TcpStream;
use tokio::time::timeout;

use crate::xmlrpc::{XmlRpcValue, read_response, write_call};

/// Address of a master or node: `http://HOST:PORT/`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RosUri {
    host: Box<str>,
    port: u16,
}

/// A text is not the address of a master or node.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not the address of a master or node, such as `http://localhost:11311`")]
pub struct RosUriError(String);

impl RosUri {
    /// An address from its parts.
    pub fn new(host: &str, port: u16) -> Self {
        let host = host.into();
        Self { host, port }
    }

    /// The host: a name or an IP address, without brackets.
    pub fn host(&self) -> &str {
        &self.host
    }

    /// The port.
    pub fn port(&self) -> u16 {
        self.port
    }
}

impl FromStr for RosUri {
    type Err = RosUriError;

    fn from_str(text: &str) -> Result<Self, RosUriError> {
        let wrong = || RosUriError(text.chars().take(200).collect());
        let rest = text.strip_prefix("http://").ok_or_else(wrong)?;
        let authority = rest.split('/').next().unwrap_or_default();
        let (host, port) = authority.rsplit_once(':').ok_or_else(wrong)?;
        let bare = host.strip_prefix('[').and_then(|it| it.strip_suffix(']'));
        let host = bare.unwrap_or(host);
        let is_host = |sign: char| sign.is_ascii_alphanumeric() || "-._:%".contains(sign);
        if host.is_empty() || !host.chars().all(is_host) {
            return Err(wrong());
        }
        let port = port.parse().map_err(|_| wrong())?;
        Ok(Self::new(host, port))
    }
}

impl fmt::Display for RosUri {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.host.contains(':') {
            write!(f, "http://[{}]:{}/", self.host, self.port)
        } else {
            write!(f, "http://{}:{}/", self.host, self.port)
        }
    }
}

/// Calls a method of a master or node, and returns its result, or why there is none.
pub(crate) async fn call(
    uri: &RosUri,
    method: &str,
    parameters: &[XmlRpcValue],
    limit: usize,
    within: Duration,
) -> Result<XmlRpcValue, String> {
    let exchange = exchange(uri, write_call(method, parameters), limit);
    let answer = timeout(within, exchange).await;
    let answer = answer.unwrap_or_else(|_| Err(format!("no answer within {within:?}")))?;
    let response = read_response(&answer).map_err(|error| error.to_string())?;
    response.map_err(|fault| fault.to_string())
}

async fn exchange(uri: &RosUri, body: String, limit: usize) -> Result<Bytes, String> {
    let stream = TcpStream::connect((uri.host(), uri.port())).await;
    let stream = stream.map_err(|error| error.to_string())?;
    // without it, the small segments of a call wait for each other
    let _ = stream.set_nodelay(true);
    let connected = http1::handshake(TokioIo::new(stream)).await;
    let (mut sender, connection) = connected.map_err(|error| error.to_string())?;
    let request = Request::builder()
        .method(Method::POST)
        .uri("/RPC2")
        .header(HOST, format!("{}:{}", uri.host(), uri.port()))
        .header(CONTENT_TYPE, "text/xml")
        .header(CONNECTION, "close")
        .body(Full::new(Bytes::from(body)))
        .map_err(|error| error.to_string())?;
    let answer = async {
        let response = sender.send_request(request).await;
        let response = response.map_err(|error| error.to_string())?;
        if response.status() != StatusCode::OK {
            return Err(format!("HTTP status {}", response.status()));
        }
        read_body(response.into_body(), limit).await
    };
    tokio::pin!(answer);
    tokio::pin!(connection);
    let mut is_open = true;
    loop {
        tokio::select! {
            answer = &mut answer => return answer,
            _ = &mut connection, if is_open => is_open = false,
        }
    }
}

/// The whole body, of at most `limit` bytes.
pub(crate) async fn read_body(body: Incoming, limit: usize) -> Result<Bytes, String> {
    let collected = Limited::new(body, limit).collect().await;
    let collected = collected.map_err(|error| format!("{error}; the limit is {limit} bytes"))?;
    Ok(collected.to_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_and_printed() {
        for text in ["http://localhost:11311/", "http://[::1]:80/"] {
            assert_eq!(text.parse::<RosUri>().unwrap().to_string(), text);
        }
        let uri: RosUri = "http://robot-1.local:11311".parse().unwrap();
        assert_eq!((uri.host(), uri.port()), ("robot-1.local", 11311));
        for text in [
            "",
            "localhost:1",
            "http://a",
            "http://:1/",
            "http://a b:1/",
            "http://a:99999/",
        ] {
            assert!(text.parse::<RosUri>().is_err(), "{text}");
        }
    }
}
