//! Replacement for the dashboard in a build without the feature `dashboard`.

use asmotion_assembly::reconfigure::Version;
use asmotion_bus::LocalBus;
use asmotion_component::Time;
use asmotion_plan::{Part, Plan};
use asmotion_remote::CommandRecord;
use asmotion_runtime::System;

use super::MissionDashboard;
use crate::feature::{Dashboard, LeftOut};
use crate::mission::MissionError;
use crate::mission::connected_broker::ConnectedBroker;

/// An open dashboard: this build has none.
pub(in crate::mission) enum OpenDashboard {}

impl OpenDashboard {
    /// Returns no dashboard, or fails if one is requested.
    pub(in crate::mission) fn open(
        request: &MissionDashboard,
        _: &mut System,
        _: (&Plan, &Part),
        _: String,
        _: (&LocalBus, &str),
        _: &[ConnectedBroker],
    ) -> Result<Option<Self>, MissionError> {
        match request {
            MissionDashboard::Closed => Ok(None),
            MissionDashboard::Open { .. } => Err(MissionError::Launch(format!(
                "`--dashboard`: {}",
                LeftOut::new::<Dashboard>()
            ))),
        }
    }

    /// Never called: there is no dashboard.
    pub(in crate::mission) fn process(&mut self) {
        match *self {}
    }

    /// Never called: there is no dashboard.
    pub(in crate::mission) fn take_commands(&self) -> Vec<(Time, CommandRecord)> {
        match *self {}
    }

    /// Never called: there is no dashboard.
    pub(in crate::mission) fn show_commands(&self, _: &[(Time, CommandRecord)]) {
        match *self {}
    }

    /// Never called: there is no dashboard.
    pub(in crate::mission) fn follow(&mut self, _: &Version) {
        match *self {}
    }

    /// Never called: there is no dashboard.
    pub(in crate::mission) fn end(&mut self, _: &str) {
        match *self {}
    }
}
