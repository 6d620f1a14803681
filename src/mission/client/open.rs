//! Connects the wires to other systems to an HTTP client.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use asmotion_assembly::reconfigure::Clients;
use asmotion_bus::ServiceClient;
use asmotion_gateway::{BearerToken, HttpClient};
use asmotion_network::Network;
use asmotion_plan::{Endpoint, Part, Plan};
use asmotion_runtime::System;

use crate::mission::process::incarnation;
use crate::mission::{Mission, MissionError};

/// Variable with the PEM file of the certificate authorities for `https`, as for OpenSSL and curl.
const AUTHORITIES: &str = "SSL_CERT_FILE";

/// The clients of other systems, which start with the first of them. The system needs this until it stops.
#[derive(Clone, Default)]
pub(in crate::mission) struct OtherSystems(Arc<Mutex<Option<HttpClient>>>);

impl OtherSystems {
    /// Returns the client of a service.
    fn client(
        &self,
        token: Option<&Endpoint>,
        authorities: Option<&str>,
    ) -> Result<Arc<dyn ServiceClient>, String> {
        let mut started = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let client = match &mut *started {
            Some(client) => client,
            none => {
                let authorities = std::env::var_os(AUTHORITIES).map(PathBuf::from);
                let client = HttpClient::start(authorities.as_deref());
                none.insert(client.map_err(|error| format!("{error} (`{AUTHORITIES}`)"))?)
            }
        };
        let token = token.map(|it| BearerToken::new(it.reveal()));
        let service = client.service(token, authorities.map(Path::new));
        service.map_err(|error| error.to_string())
    }

    /// Returns the clients for wires of later versions.
    pub(in crate::mission) fn clients(&self) -> Clients {
        let systems = self.clone();
        Arc::new(move |token, authorities| systems.client(token, authorities))
    }
}

impl Mission {
    /// Connects the wires to other systems. Returns their clients.
    pub(in crate::mission) fn connect_clients(
        &self,
        system: &mut System,
        network: &mut Network,
        plan: &Plan,
        part: &Part,
    ) -> Result<OtherSystems, MissionError> {
        let systems = OtherSystems::default();
        let mut services = BTreeMap::new();
        for (wire, url) in plan.wires_over_http(part) {
            let client = systems.client(wire.token.as_ref(), wire.ca.as_deref());
            let client = client.map_err(|reason| {
                MissionError::Launch(format!("wire of `{}`: {reason}", wire.reference))
            })?;
            let key = (wire.reference.to_string(), url.reveal().to_owned());
            services.entry(key).or_insert(client);
        }
        let connected = network.connect_clients(
            system,
            |reference, url| {
                let key = (reference.to_owned(), url.to_owned());
                services.get(&key).cloned()
            },
            incarnation(),
        );
        connected.map_err(|error| MissionError::Launch(error.to_string()))?;
        Ok(systems)
    }
}
