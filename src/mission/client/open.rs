//! Connects the wires to other systems to an HTTP client.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use asmotion_gateway::{BearerToken, HttpClient};
use asmotion_network::Network;
use asmotion_plan::{Part, Plan};
use asmotion_runtime::System;

use crate::mission::process::incarnation;
use crate::mission::{Mission, MissionError};

/// Variable with the PEM file of the certificate authorities for `https`, as for OpenSSL and curl.
const AUTHORITIES: &str = "SSL_CERT_FILE";

impl Mission {
    /// Connects the wires to other systems. Returns their client, which the system needs until it stops; `None` if it has
    /// no such wire.
    pub(in crate::mission) fn connect_clients(
        &self,
        system: &mut System,
        network: &mut Network,
        plan: &Plan,
        part: &Part,
    ) -> Result<Option<HttpClient>, MissionError> {
        if plan.wires_over_http(part).next().is_none() {
            return Ok(None);
        }
        let launch = |reason: String| MissionError::Launch(reason);
        let authorities = std::env::var_os(AUTHORITIES).map(PathBuf::from);
        let client = HttpClient::start(authorities.as_deref());
        let client = client.map_err(|error| launch(format!("{error} (`{AUTHORITIES}`)")))?;
        let mut services = BTreeMap::new();
        for (wire, url) in plan.wires_over_http(part) {
            let token = wire.token.as_ref().map(|it| BearerToken::new(it.reveal()));
            let service = client.service(token, wire.ca.as_deref().map(Path::new));
            let service = service
                .map_err(|error| launch(format!("wire of `{}`: {error}", wire.reference)))?;
            let key = (wire.reference.to_string(), url.reveal().to_owned());
            services.entry(key).or_insert(service);
        }
        let connected = network.connect_clients(
            system,
            |reference, url| {
                let key = (reference.to_owned(), url.to_owned());
                services.get(&key).cloned()
            },
            incarnation(),
        );
        connected.map_err(|error| launch(error.to_string()))?;
        Ok(Some(client))
    }
}
