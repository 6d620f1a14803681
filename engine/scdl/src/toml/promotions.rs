//! Writes the bindings of promotions.

use crate::codes::x014::MovedAddress;
use asmotion_diagnostics::Finding;
use toml_edit::{Table, Value, value as item};

use super::{TomlWriter, broker_name};
use crate::model::{ScdlBinding, ScdlComposite, ScdlContract, ScdlTransport};
use crate::{gateway, tca, value};

impl TomlWriter<'_> {
    /// Writes the bindings of a promotion.
    pub(super) fn bind(&mut self, promotion: &ScdlContract, table: &mut Table) {
        let mut words: Vec<&str> = Vec::new();
        for bound in &promotion.bindings {
            let word = word(bound.over).unwrap_or("local");
            if !words.contains(&word) {
                words.push(word);
            }
        }
        match words.as_slice() {
            [] | ["local"] => {}
            [only] => {
                table.insert("binding", item(*only));
            }
            several => {
                let several = several.iter().map(|word| Value::from(*word));
                table.insert("binding", item(value::list(several)));
            }
        }
        for word in words {
            self.over_broker(word, table);
        }
    }

    /// Names the broker of an `amqp` binding, which is needed if there are several.
    pub(super) fn over_broker(&mut self, word: &str, table: &mut Table) {
        if word != "amqp" {
            return;
        }
        if self.brokers.is_empty() {
            self.brokers.push(tca::BROKER.to_owned());
        }
        if self.brokers.len() > 1 {
            table.insert("broker", item(broker_name(0)));
        }
    }

    /// Names the gateway of an `http` binding if there are several, and reports a different address.
    pub(super) fn gateway(&mut self, promotion: &ScdlContract, name: &str, table: &mut Table) {
        let Some(called) = called(promotion) else {
            return;
        };
        let listen = gateway::listen_for(called);
        let here = gateway::uri(&listen, name);
        if let Some(uri) = &called.uri
            && !gateway::is_same(uri, &here)
        {
            let (of, at) = (name.to_owned(), uri.span);
            let moved = MovedAddress { of, here, at };
            self.report.push(moved.diagnostic());
        }
        let known = self.gateways.iter().position(|known| *known == listen);
        if let Some(index) = known.filter(|_| self.gateways.len() > 1) {
            table.insert("gateway", item(broker_name(index)));
        }
    }
}

/// The HTTP binding of a service, if it has one.
fn called(promotion: &ScdlContract) -> Option<&ScdlBinding> {
    let mut bindings = promotion.bindings.iter();
    bindings.find(|bound| bound.over == ScdlTransport::Http)
}

/// Addresses of all gateways that the composite's services need.
pub(super) fn listening(composite: &ScdlComposite) -> Vec<String> {
    let mut gateways = Vec::new();
    for called in composite.services.iter().filter_map(called) {
        let listen = gateway::listen_for(called);
        if !gateways.contains(&listen) {
            gateways.push(listen);
        }
    }
    gateways
}

/// The transport's word in composite files; `None` for the local one, which needs none.
pub(super) fn word(binding: ScdlTransport) -> Option<&'static str> {
    match binding {
        ScdlTransport::Sca => None,
        ScdlTransport::Http => Some("http"),
        // calls between Java components use the broker here, like messages
        ScdlTransport::Jms | ScdlTransport::Rmi => Some("amqp"),
    }
}
