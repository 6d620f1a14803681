//! Brokers, gateways and bridges of a plan, with their secrets.

use crate::codes::c019::SecretInFile;
use crate::codes::c064::InvalidAddress;
use crate::codes::c065::DuplicateAddress;
use std::collections::BTreeMap;
use std::net::SocketAddr;

use asmotion_diagnostics::Span;
use serde::{Serialize, Serializer};

use super::fill::{given, number};
use super::flatten::Flattener;
use crate::At;
use crate::finding::Findings;
use crate::model::{self, BridgeKind, Codec, Composite, Template, Tls};
use crate::scope::{Notes, Scope};
use crate::value::REDACTED;

/// An address with its secrets; shows itself without them.
#[derive(Clone, PartialEq, Eq)]
pub struct Endpoint {
    full: String,
    shown: String,
}

/// A message broker.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Broker {
    /// Its name.
    pub name: String,
    /// Where it is; absent where a variable is missing.
    pub url: Option<Endpoint>,
    /// The topic exchange.
    pub exchange: String,
    /// How payloads are encoded.
    pub codec: Codec,
    /// Whether the line is encrypted.
    pub tls: Tls,
    /// First wait before a lost connection is taken up again.
    pub reconnect_first_ms: u64,
    /// Longest wait.
    pub reconnect_max_ms: u64,
    /// Share of the wait that is random.
    pub reconnect_jitter: f64,
}

/// Where services are called over HTTP.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gateway {
    /// Its name.
    pub name: String,
    /// Where it listens; absent where a variable is missing, or where nothing can listen.
    pub listen: Option<SocketAddr>,
    /// How many may be connected at once.
    pub max_connections: u64,
    /// The longest argument, in thousands of bytes.
    pub max_body_kb: u64,
}

/// A way to another middleware.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bridge {
    /// Its name.
    pub name: String,
    /// Which middleware.
    pub kind: BridgeKind,
    /// Where roscore or the rosbridge server is.
    pub url: Option<Endpoint>,
    /// The domain of ROS 2.
    pub domain: Option<u64>,
    /// The name under which we appear there.
    pub node: Option<String>,
}

impl Endpoint {
    /// An address and how it is shown.
    pub fn new(full: impl Into<String>, shown: impl Into<String>) -> Self {
        let shown = mask(&shown.into());
        Self {
            full: full.into(),
            shown,
        }
    }

    /// The address with its secrets; not for logs.
    pub fn reveal(&self) -> &str {
        &self.full
    }

    /// The address without its secrets.
    pub fn shown(&self) -> &str {
        &self.shown
    }
}

/// Blots out the password of `scheme://user:password@host`.
pub(crate) fn mask(url: &str) -> String {
    match password(url) {
        Some(range) => format!("{}{REDACTED}{}", &url[..range.start], &url[range.end..]),
        None => url.to_owned(),
    }
}

/// Where the password of an address stands.
pub(crate) fn password(url: &str) -> Option<std::ops::Range<usize>> {
    let start = url.find("://")? + 3;
    // up to the last `@`, since a password may be written with a `/` that should be escaped
    let at = start + url[start..].rfind('@')?;
    let colon = start + url[start..at].find(':')?;
    Some(colon + 1..at)
}

impl std::fmt::Debug for Endpoint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.shown)
    }
}

impl Serialize for Endpoint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.shown)
    }
}

/// The exchange that all robots share, unless the composite names another one.
const EXCHANGE: &str = "robots";

impl Flattener<'_, '_> {
    /// Adds the brokers and bridges of a composite.
    pub(super) fn endpoints(&mut self, index: usize, composite: &Composite) {
        let Some(instance) = self.instances.get(index) else {
            return;
        };
        for broker in &composite.brokers {
            secret(&broker.url, self.notes);
            let reconnect = broker.reconnect.as_ref();
            self.plan.brokers.push(Broker {
                name: format!("{}{}", instance.prefix, broker.name.value),
                url: endpoint(&instance.scope, &broker.url, self.notes),
                exchange: broker
                    .exchange
                    .as_ref()
                    .map_or_else(|| EXCHANGE.to_owned(), |name| name.value.clone()),
                codec: given(&broker.codec),
                tls: given(&broker.tls),
                reconnect_first_ms: reconnect.and_then(|it| number(&it.first_ms)).unwrap_or(100),
                reconnect_max_ms: reconnect.and_then(|it| number(&it.max_ms)).unwrap_or(5000),
                reconnect_jitter: reconnect
                    .and_then(|it| it.jitter.as_ref())
                    .map_or(0.2, |jitter| jitter.value),
            });
        }
        for bridge in &composite.bridges {
            let url = bridge.master.as_ref().or(bridge.url.as_ref());
            self.plan.bridges.push(Bridge {
                name: format!("{}{}", instance.prefix, bridge.name.value),
                kind: bridge.kind.value,
                url: url.and_then(|url| endpoint(&instance.scope, url, self.notes)),
                domain: number(&bridge.domain),
                node: bridge.node.as_ref().map(|node| node.value.clone()),
            });
        }
    }

    /// Adds the gateways of the outermost composite: they lead to what is promoted there.
    pub(super) fn gateways(&mut self, composite: &Composite) {
        let Some(outermost) = self.instances.first() else {
            return;
        };
        let mut taken: BTreeMap<SocketAddr, Span> = BTreeMap::new();
        for gateway in &composite.gateways {
            let listen = listen(&outermost.scope, gateway, self.notes);
            // of port 0, each has its own
            let at = gateway.listen.span;
            if let Some(address) = listen.filter(|it| it.port() != 0)
                && let Some(first) = taken.insert(address, at)
            {
                self.notes.found(DuplicateAddress { address, at, first });
            }
            self.plan.gateways.push(Gateway {
                name: gateway.name.value.clone(),
                listen,
                max_connections: number(&gateway.max_connections).unwrap_or(64),
                max_body_kb: number(&gateway.max_body_kb).unwrap_or(1000),
            });
        }
    }
}

fn endpoint(scope: &Scope<'_>, url: &At<Template>, notes: &mut Notes) -> Option<Endpoint> {
    scope
        .fill(url, notes)
        .map(|filled| Endpoint::new(filled.text, filled.shown))
}

/// Where a gateway listens.
fn listen(scope: &Scope<'_>, gateway: &model::Gateway, notes: &mut Notes) -> Option<SocketAddr> {
    let filled = scope.fill(&gateway.listen, notes)?;
    let address = filled.text.parse().ok();
    if address.is_none() {
        notes.found(InvalidAddress {
            name: gateway.name.value.clone(),
            text: filled.shown,
            at: gateway.listen.span,
        });
    }
    address
}

/// A password that stands in the file is read by everybody who has the file.
fn secret(url: &At<Template>, notes: &mut Notes) {
    let pieces = url.pieces.iter().map(|piece| match piece {
        model::Piece::Text(text) => text.as_str(),
        model::Piece::Property { .. } | model::Piece::Variable { .. } => SUBSTITUTED,
    });
    let written: String = pieces.collect();
    let password = password(&written).and_then(|range| written.get(range));
    if let Some(password) = password
        && !password.is_empty()
        && !password.contains(SUBSTITUTED)
        && password != PUBLIC_PASSWORD
        && password != REDACTED
    {
        notes.found(SecretInFile { at: url.span });
    }
}

/// Stands for what is not written in the file.
const SUBSTITUTED: &str = "\u{1}";

/// RabbitMQ's password for everybody on the same machine.
const PUBLIC_PASSWORD: &str = "guest";

#[cfg(test)]
mod tests {
    use super::Endpoint;

    #[test]
    fn it_never_shows_a_password() {
        let endpoint = Endpoint::new(
            "amqp://guest:geheim@host:5672/%2f",
            "amqp://guest:geheim@host:5672/%2f",
        );
        assert_eq!(format!("{endpoint:?}"), "amqp://guest:***@host:5672/%2f");
        assert_eq!(endpoint.reveal(), "amqp://guest:geheim@host:5672/%2f");
    }

    #[test]
    fn it_shows_an_address_without_a_password_as_it_is() {
        assert_eq!(
            Endpoint::new("http://a:80/x", "http://a:80/x").shown(),
            "http://a:80/x"
        );
    }
}
