//! Replacement for gateways in a build without the feature `http`: composites with gateways cannot be run.

use asmotion_bus::LocalBus;
use asmotion_network::Network;
use asmotion_plan::{Opened, Part, Plan};
use asmotion_runtime::System;

use super::MissionGateways;
use crate::feature::{Http, LeftOut};
use crate::mission::{Mission, MissionError};

/// An open gateway: this build has none.
pub(in crate::mission) enum Gateway {}

impl Mission {
    /// Returns no gateways, or fails if the composite has one.
    pub(in crate::mission) fn open_gateways(
        &self,
        _: &mut System,
        _: &mut Network,
        _: &Opened,
        plan: &Plan,
        part: &Part,
        _: &LocalBus,
    ) -> Result<Vec<Gateway>, MissionError> {
        let first = plan.gateways_of(part).into_iter().next();
        match (&self.gateways, first) {
            (MissionGateways::Open { .. }, Some((gateway, _))) => {
                Err(MissionError::WithoutGateway {
                    name: gateway.name.clone(),
                    reason: LeftOut::new::<Http>(),
                })
            }
            (MissionGateways::Open { .. }, None) | (MissionGateways::Closed, _) => Ok(Vec::new()),
        }
    }
}
