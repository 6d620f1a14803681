//! Replacement for the client in a build without the feature `http`: composites with wires to other systems cannot be run.

use std::sync::Arc;

use asmotion_assembly::reconfigure::Clients;
use asmotion_network::Network;
use asmotion_plan::{Part, Plan};
use asmotion_runtime::System;

use crate::feature::{Http, LeftOut};
use crate::mission::{Mission, MissionError};

/// The clients of other systems, of which there are none.
pub(in crate::mission) struct OtherSystems;

impl OtherSystems {
    /// Returns the reason instead of a client.
    pub(in crate::mission) fn clients(&self) -> Clients {
        Arc::new(|_, _| Err(LeftOut::new::<Http>().to_string()))
    }
}

impl Mission {
    /// Does nothing, or fails if a wire leads to another system.
    pub(in crate::mission) fn connect_clients(
        &self,
        _: &mut System,
        _: &mut Network,
        plan: &Plan,
        part: &Part,
    ) -> Result<OtherSystems, MissionError> {
        match plan.wires_over_http(part).next() {
            None => Ok(OtherSystems),
            Some((wire, _)) => {
                let reason = LeftOut::new::<Http>();
                let reference = &wire.reference;
                let reason = format!("wire of `{reference}`: {reason}");
                Err(MissionError::Launch(reason))
            }
        }
    }
}
