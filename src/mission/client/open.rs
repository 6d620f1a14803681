//! Connects the wires to other systems to an HTTP client.

use std::path::PathBuf;

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
        let token = |reference: &str, url: &str| {
            let mut wires = plan.wires_over_http(part);
            let (wire, _) = wires
                .find(|(wire, to)| to.reveal() == url && wire.reference.to_string() == reference)?;
            let token = wire.token.as_ref()?;
            Some(BearerToken::new(token.reveal()))
        };
        let connected = network.connect_clients(
            system,
            |reference, url| client.service(token(reference, url)),
            incarnation(),
        );
        connected.map_err(|error| launch(error.to_string()))?;
        Ok(Some(client))
    }
}
