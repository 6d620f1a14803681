//! Resolves brokers, gateways and bridges, including secrets.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv6Addr, SocketAddr};

use asmotion_bus::RobotAddress;
use asmotion_diagnostics::Span;

use super::Flattener;
use crate::codes::c019::SecretInFile;
use crate::codes::c065::DuplicateAddress;
use crate::codes::c067::OpenGateway;
use crate::codes::c068::InvalidServiceUrl;
use crate::codes::c069::OwnRobot;
use crate::codes::c152::TokenInClear;
use crate::codes::c191::AuthorityWithoutTls;
use crate::plan::{Bridge, Endpoint, Wire};
use crate::route::robot_address;
use asmotion_composite::At;
use asmotion_composite::address::password;
use asmotion_composite::finding::Findings;
use asmotion_composite::model::{self, Composite, Template, Transport};
use asmotion_composite::scope::SubstitutionNotes;
use asmotion_composite::table::Resolver;
use asmotion_composite::value::REDACTED;

impl Flattener<'_, '_> {
    /// Adds the brokers and bridges of a composite instance.
    pub(super) fn endpoints(&mut self, index: usize, composite: &Composite) {
        let Some(instance) = self.instances.get(index) else {
            return;
        };
        for broker in &composite.brokers {
            secret(&broker.url, self.notes);
        }
        let mut to = Resolver::new(&instance.scope, &instance.prefix, self.notes);
        let brokers = composite.brokers.iter();
        self.plan.brokers.extend(brokers.filter_map(|it| to.of(it)));
        let bridges = composite.bridges.iter();
        let bridges = bridges.filter_map(|it| to.of(it));
        let folder = |written: &String| instance.member.path(written).map(str::to_owned);
        self.plan.bridges.extend(bridges.map(|bridge| Bridge {
            definitions: bridge.definitions.iter().filter_map(folder).collect(),
            ..bridge
        }));
    }

    /// Adds the gateways of the outermost composite, which give access to its promotions.
    pub(super) fn gateways(&mut self, composite: &Composite) {
        let Some(outermost) = self.instances.first() else {
            return;
        };
        let mut taken: BTreeMap<SocketAddr, Span> = BTreeMap::new();
        let mut to = Resolver::new(&outermost.scope, &outermost.prefix, self.notes);
        for written in &composite.gateways {
            to.owner.clone_from(&written.name.value);
            let Some(gateway) = to.of(written) else {
                continue;
            };
            let at = written.listen.span;
            match &written.token {
                Some(token) => self::token(token, "GATEWAY_TOKEN_FILE", to.notes),
                None => {
                    let open = gateway.listen.filter(|address| !address.ip().is_loopback());
                    if let Some(address) = open {
                        to.notes.found(OpenGateway { address, at });
                    }
                }
            }
            // port 0 selects a distinct free port for each gateway
            if let Some(address) = gateway.listen.filter(|it| it.port() != 0)
                && let Some(first) = taken.insert(address, at)
            {
                let same = DuplicateAddress { address, at, first };
                to.notes.found(same);
            }
            self.plan.gateways.push(gateway);
        }
    }
}

/// Warns about a token written in the file, where every reader of the file can see it.
pub(super) fn token(token: &At<Template>, variable: &'static str, notes: &mut SubstitutionNotes) {
    if is_literal(token) {
        notes.found(SecretInFile {
            what: "token",
            variable,
            at: token.span,
        });
    }
}

/// Reports the URL of a service that cannot be called.
pub(super) fn service_url(wire: &Wire, url: &Endpoint, at: Span, notes: &mut SubstitutionNotes) {
    let (reason, example) = match wire.binding {
        Transport::Http => {
            let example = "http://127.0.0.1:8080/services/maps";
            (problem(url.reveal()), example)
        }
        Transport::Amqp if wire.services.is_empty() => {
            let address = RobotAddress::parse(url.reveal());
            (address.err(), "robot://depot/MapServer.maps")
        }
        // has no URL, which is reported already
        Transport::Amqp | Transport::Local | Transport::Ros => return,
    };
    if let Some(reason) = reason {
        notes.found(InvalidServiceUrl {
            text: url.shown().to_owned(),
            reason,
            example,
            at,
        });
    }
}

/// Warns about a token that is sent to another machine without encryption.
pub(super) fn token_in_clear(
    wire: &Wire,
    token: &At<Template>,
    url: Span,
    notes: &mut SubstitutionNotes,
) {
    let address = wire.url.as_ref().map_or("", Endpoint::reveal);
    let Some(rest) = address.strip_prefix("http://") else {
        return;
    };
    let (authority, _) = rest.split_once('/').unwrap_or((rest, ""));
    let host = host_and_port(authority).0;
    let ip = host.trim_start_matches('[').trim_end_matches(']').parse();
    let is_here = host == "localhost" || ip.is_ok_and(|ip: IpAddr| ip.is_loopback());
    if wire.binding == Transport::Http && problem(address).is_none() && !is_here {
        notes.found(TokenInClear {
            reference: wire.reference.to_string(),
            host: host.to_owned(),
            at: token.span,
            url,
        });
    }
}

/// Reports certificate authorities of a wire whose calls are not encrypted. The locations are those of the keys `ca` and `url`.
pub(super) fn authority_without_tls(
    wire: &Wire,
    (at, url): (Span, Span),
    notes: &mut SubstitutionNotes,
) {
    let address = wire.url.as_ref().map_or("", Endpoint::reveal);
    if wire.binding == Transport::Http && address.starts_with("http://") {
        notes.found(AuthorityWithoutTls {
            reference: wire.reference.to_string(),
            at,
            url,
        });
    }
}

/// Splits the host from the port. An IPv6 address is in brackets.
fn host_and_port(authority: &str) -> (&str, Option<&str>) {
    match authority.rsplit_once(':') {
        Some((host, port)) if !port.contains(']') => (host, Some(port)),
        Some(_) | None => (authority, None),
    }
}

/// Warns about a wire to the robot itself.
pub(super) fn own_robot(wire: &Wire, robot: &str, at: Span, notes: &mut SubstitutionNotes) {
    if let Some(address) = robot_address(wire).filter(|it| it.robot() == robot) {
        notes.found(OwnRobot {
            reference: wire.reference.to_string(),
            robot: robot.to_owned(),
            service: address.name().to_owned(),
            at,
        });
    }
}

/// Returns the reason that a text is not the URL of a service.
fn problem(url: &str) -> Option<&'static str> {
    let rest = url
        .strip_prefix("http://")
        .or_else(|| url.strip_prefix("https://"));
    let Some(rest) = rest else {
        return Some("does not begin with `http://` or `https://`");
    };
    let (authority, _) = rest.split_once('/').unwrap_or((rest, ""));
    let (host, port) = host_and_port(authority);
    let is_port = |port: &str| port.parse::<u16>().is_ok_and(|port| port > 0);
    let bracketed = host.strip_prefix('[').and_then(|it| it.strip_suffix(']'));
    if authority.contains('@') {
        Some("contains a user name: give the secret as `token`")
    } else if host.is_empty() {
        Some("has no host")
    } else if bracketed.is_none() && authority.parse::<Ipv6Addr>().is_ok() {
        Some("has an IPv6 address, which is written in brackets: `http://[::1]/`")
    } else if bracketed.is_some_and(|it| it.parse::<Ipv6Addr>().is_err())
        || bracketed.is_none() && host.contains(['[', ']', ':'])
    {
        Some("has no valid host")
    } else if !port.is_none_or(is_port) {
        Some("has no valid port")
    } else if url.contains(['?', '#']) {
        Some("has a query: its end becomes the name of the operation")
    } else if !url.chars().all(|letter| letter.is_ascii_graphic()) {
        Some("contains a character that must be percent-encoded")
    } else {
        None
    }
}

/// Returns whether a template contains its whole text.
fn is_literal(template: &Template) -> bool {
    let mut pieces = template.pieces.iter();
    pieces.all(|piece| matches!(piece, model::Piece::Text(_)))
}

/// Warns about a password written in the file, where every reader of the file can see it.
fn secret(url: &At<Template>, notes: &mut SubstitutionNotes) {
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
        notes.found(SecretInFile {
            what: "password",
            variable: "AMQP_PASSWORD_FILE",
            at: url.span,
        });
    }
}

/// Placeholder for substituted parts of a URL.
const SUBSTITUTED: &str = "\u{1}";

/// Default password of RabbitMQ, accepted from localhost only; not reported.
const PUBLIC_PASSWORD: &str = "guest";
