//! Opens the dashboard of a system that is about to run.

use std::net::SocketAddr;
use std::sync::Arc;

use asmotion_assembly::reconfigure::Version;
use asmotion_bus::{Bus, BusError, LocalBus, Notifier, Pattern, QueuePolicy, Subscription};
use asmotion_component::Time;
use asmotion_monitor::{
    BusLink, Dashboard, DashboardSettings, Feed, MonitorSource, OrderBus, SystemDescription,
};
use asmotion_plan::{Part, Plan};
use asmotion_remote::{CommandRecord, RobotPresence, presence_topic};
use asmotion_runtime::System;

use super::MissionDashboard;
use crate::files::DiskLoader;
use crate::mission::MissionError;
use crate::mission::connected_broker::ConnectedBroker;
use crate::mission::message_types::port_types;

/// Address of a dashboard, unless it is given or in use.
const USUAL: SocketAddr =
    SocketAddr::new(std::net::IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), 7070);

/// Settings of a dashboard at an address; by default at the usual one, or at a free port if that is in use.
pub(crate) fn dashboard_settings(listen: Option<SocketAddr>) -> DashboardSettings {
    DashboardSettings {
        or_free_port: listen.is_none(),
        ..DashboardSettings::at(listen.unwrap_or(USUAL))
    }
}

/// An open dashboard.
pub(in crate::mission) struct OpenDashboard {
    feed: Feed,
    /// Clock of the run in words.
    clock: String,
    presences: Subscription,
    /// Closes when dropped.
    _server: Dashboard,
}

impl OpenDashboard {
    /// Opens the dashboard for a system that is about to run, if one is requested. It learns of the components from what the
    /// process with this name describes on this bus, and sends its orders there. It shows the state of the connections to the
    /// brokers.
    pub(in crate::mission) fn open(
        request: &MissionDashboard,
        system: &mut System,
        (plan, part): (&Plan, &Part),
        clock: String,
        (bus, process): (&LocalBus, &str),
        brokers: &[ConnectedBroker],
    ) -> Result<Option<Self>, MissionError> {
        let MissionDashboard::Open {
            listen,
            control,
            allowed_origins,
            on_open,
        } = request
        else {
            return Ok(None);
        };
        let presences = presences(bus).map_err(|error| MissionError::Launch(error.to_string()))?;
        let description = SystemDescription::of(plan, part, clock.clone(), &DiskLoader);
        let orders = OrderBus {
            bus: Arc::new(bus.clone()),
            process: process.to_owned(),
        };
        let links = brokers.iter().map(|it| BusLink {
            name: it.location.clone(),
            warning: it.warning.clone(),
            bus: Arc::clone(&it.bus),
        });
        let source = MonitorSource::new(description, Some(orders), links.collect());
        let feed = source.feed();
        feed.learn(port_types(plan));
        let mut settings = dashboard_settings(*listen);
        settings.allowed_origins.clone_from(allowed_origins);
        let launch =
            |error: &dyn std::fmt::Display| MissionError::Launch(format!("`--dashboard`: {error}"));
        let token = control.then(DashboardSettings::new_token).transpose();
        let token = token.map_err(|error| launch(&error))?;
        settings.control = token.as_deref().map(asmotion_monitor::BearerToken::new);
        let server = Dashboard::open(settings, source).map_err(|error| launch(&error))?;
        system.observe(feed.clone());
        let address = server.address();
        // a browser does not send the part behind `#` to any server
        on_open.0(&match token {
            Some(token) => format!("http://{address}/#token={token}"),
            None => format!("http://{address}/"),
        });
        Ok(Some(Self {
            feed,
            clock,
            presences,
            _server: server,
        }))
    }

    /// Passes on what the process has described.
    pub(in crate::mission) fn process(&mut self) {
        while let Some(envelope) = self.presences.try_next() {
            if let Some(RobotPresence { presence, .. }) = RobotPresence::of(&envelope) {
                self.feed.describe(presence);
            }
        }
    }

    /// Takes what tabs have asked for, and what became of it.
    pub(in crate::mission) fn take_commands(&self) -> Vec<(Time, CommandRecord)> {
        self.feed.take_commands()
    }

    /// Shows what others than tabs have asked for.
    pub(in crate::mission) fn show_commands(&self, commands: &[(Time, CommandRecord)]) {
        for (at, command) in commands {
            self.feed.show_command(*at, command);
        }
    }

    /// Follows the system to another version of the composite. Its files may have come from another machine.
    pub(in crate::mission) fn follow(&mut self, version: &Version) {
        let Version { plan, part, .. } = version;
        self.feed.learn(port_types(plan));
        let clock = self.clock.clone();
        let description = SystemDescription::of(plan, part, clock, version.loader());
        self.feed.follow(description);
    }

    /// Shows how the run has ended.
    pub(in crate::mission) fn end(&mut self, outcome: &str) {
        self.process();
        self.feed.end(outcome);
    }
}

fn presences(bus: &LocalBus) -> Result<Subscription, BusError> {
    let topics = Pattern::new(presence_topic("*"));
    let notifier = Arc::new(Notifier::new());
    bus.subscribe("dashboard", &topics, QueuePolicy::Latest, notifier)
}
