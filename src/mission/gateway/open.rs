//! Opens the gateways of a system at the addresses in the composite or on the command line.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use asmotion_bus::LocalBus;
use asmotion_gateway::{BearerToken, Gateway, GatewayOperation, GatewayService, GatewaySettings};
use asmotion_network::{Network, NetworkError};
use asmotion_plan::{Opened, Part, Plan};
use asmotion_runtime::System;

use super::{ListeningGateway, MissionGateways};
use crate::describe::{self, ServedOperation};
use crate::mission::{Mission, MissionError};

impl Mission {
    /// Opens the gateways for a system that is about to run, with their services on this bus.
    pub(in crate::mission) fn open_gateways(
        &self,
        system: &mut System,
        network: &mut Network,
        opened: &Opened,
        plan: &Plan,
        part: &Part,
        bus: &LocalBus,
    ) -> Result<Vec<Gateway>, MissionError> {
        let MissionGateways::Open {
            address_overrides: elsewhere,
            on_listen,
        } = &self.gateways
        else {
            return Ok(Vec::new());
        };
        let gateways = plan.gateways_of(part);
        let served = gateways.iter().flat_map(|(_, promoted)| promoted);
        let served: Vec<(&str, &str)> = served.map(|it| (&*it.inside, &*it.name)).collect();
        let bus: Arc<LocalBus> = Arc::new(bus.clone());
        let launch = |error: NetworkError| MissionError::Launch(error.to_string());
        let serving = network.serve_on(system, bus.clone(), &served);
        serving.map_err(launch)?;
        let operations = describe::describe(&self.build, opened, plan).operations;
        let open =
            |(gateway, promoted): &(&asmotion_plan::Gateway, Vec<&asmotion_plan::Promoted>)| {
                let address = elsewhere.iter().find(|(name, _)| *name == gateway.name);
                let listen = address.map(|(_, address)| *address).or(gateway.listen);
                // a missing variable has already been reported
                let listen = listen.unwrap_or_else(|| SocketAddr::from(([127, 0, 0, 1], 0)));
                let services = promoted.iter().map(|it| service(it, &operations));
                let open =
                    Gateway::open(settings(gateway, listen), services.collect(), bus.clone());
                let open = open.map_err(|reason| MissionError::Gateway {
                    name: gateway.name.clone(),
                    reason: reason.to_string(),
                })?;
                (on_listen.0)(ListeningGateway {
                    name: &gateway.name,
                    address: open.address(),
                    needs_token: gateway.token.is_some(),
                });
                Ok(open)
            };
        gateways.iter().map(open).collect()
    }
}

fn settings(gateway: &asmotion_plan::Gateway, listen: SocketAddr) -> GatewaySettings {
    let count = |number: u64| usize::try_from(number).unwrap_or(usize::MAX);
    GatewaySettings {
        allowed_hosts: gateway.allowed_hosts.clone(),
        token: gateway
            .token
            .as_ref()
            .map(|token| BearerToken::new(token.reveal())),
        max_connections: count(gateway.max_connections),
        max_body: count(gateway.max_body_kb.saturating_mul(1000)),
        ..GatewaySettings::at(listen)
    }
}

/// The interface of a promoted service for HTTP clients.
fn service(promoted: &asmotion_plan::Promoted, operations: &[ServedOperation]) -> GatewayService {
    let own_operations = operations.iter();
    let own: Vec<&ServedOperation> = own_operations
        .filter(|it| it.service.to_string() == promoted.inside)
        .collect();
    let interface = own.first().map_or("", |served| &*served.interface);
    let operations = own.iter().map(|served| GatewayOperation {
        name: served.operation.name.clone(),
        request: served.operation.request.clone(),
        response: served.operation.response.clone(),
        one_way: served.one_way,
    });
    let timeout_ms = promoted
        .timeout_ms
        .unwrap_or(asmotion_composite::model::DEFAULT_TIMEOUT_MS);
    GatewayService {
        name: promoted.name.clone(),
        interface: interface.to_owned(),
        timeout: Duration::from_millis(timeout_ms),
        operations: operations.collect(),
    }
}
