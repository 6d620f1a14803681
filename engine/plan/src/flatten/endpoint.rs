//! Resolves brokers, gateways and bridges, including secrets.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use asmotion_diagnostics::Span;

use super::Flattener;
use crate::codes::c019::SecretInFile;
use crate::codes::c065::DuplicateAddress;
use crate::codes::c067::OpenGateway;
use asmotion_composite::At;
use asmotion_composite::address::password;
use asmotion_composite::finding::Findings;
use asmotion_composite::model::{self, Composite, Template};
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
        self.plan.bridges.extend(bridges.filter_map(|it| to.of(it)));
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
                Some(token) if is_literal(token) => to.notes.found(SecretInFile {
                    what: "token",
                    variable: "GATEWAY_TOKEN_FILE",
                    at: token.span,
                }),
                Some(_) => {}
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
