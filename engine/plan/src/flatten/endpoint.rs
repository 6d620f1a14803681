//! Brokers, gateways and bridges of a plan, with their secrets.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use asmotion_diagnostics::Span;

use super::Flattener;
use crate::codes::c019::SecretInFile;
use crate::codes::c065::DuplicateAddress;
use asmotion_composite::At;
use asmotion_composite::address::password;
use asmotion_composite::finding::Findings;
use asmotion_composite::model::{self, Composite, Template};
use asmotion_composite::scope::SubstitutionNotes;
use asmotion_composite::table::Resolver;
use asmotion_composite::value::REDACTED;

impl Flattener<'_, '_> {
    /// Adds the brokers and bridges of a composite.
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

    /// Adds the gateways of the outermost composite: they lead to what is promoted there.
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
            // of port 0, each has its own
            let at = written.listen.span;
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

/// A password that stands in the file is read by everybody who has the file.
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
        notes.found(SecretInFile { at: url.span });
    }
}

/// Stands for what is not written in the file.
const SUBSTITUTED: &str = "\u{1}";

/// RabbitMQ's password for everybody on the same machine.
const PUBLIC_PASSWORD: &str = "guest";
