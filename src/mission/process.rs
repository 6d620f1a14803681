//! The part of a composite that a mission runs, and its connections to brokers.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use asmotion_bus::{Bus, BusError, LocalBus};
use asmotion_composite::split_robot_component;
use asmotion_network::Network;
use asmotion_plan::{Broker, Part, Plan, Terminal};
use asmotion_remote::{LastSamples, ProcessContact};
use asmotion_runtime::System;

use super::connected_broker::ConnectedBroker;
use super::error::MissionError;
use super::outside::OutsideSystem;
use super::version_switch::VersionSwitch;
use super::{Mission, MissionClock};
use crate::broker::BrokerSettings;
use crate::files::DiskLoader;

/// Time limit for the connection to a broker that should be there.
const CONNECT: Duration = Duration::from_secs(10);
/// Time limit for one of several attempts.
const ATTEMPT: Duration = Duration::from_secs(2);
/// Time after which a wait for a broker is reported again.
const REPEATED: Duration = Duration::from_secs(30);

/// Brokers of a mission.
#[derive(Clone, Debug, Default)]
pub enum MissionBrokers {
    /// No broker: all connections are direct.
    #[default]
    Nothing,
    /// No broker, but a bus inside the process for `--top`.
    Inside(LocalBus),
    /// One broker for all topics and wires, in place of those of the composite.
    One(BrokerSettings),
    /// The brokers named by the composite, by name; each carries what the composite assigns to it.
    Each(BTreeMap<String, BrokerSettings>),
}

/// Brokers named in a composite.
pub enum NamedBrokers {
    /// A single broker, which carries everything.
    One(Broker),
    /// Several brokers, each for the components that name it.
    Each(Vec<Broker>),
}

impl MissionBrokers {
    /// Returns `true` if there is a broker.
    pub fn is_connected(&self) -> bool {
        match self {
            Self::Nothing | Self::Inside(_) => false,
            Self::One(_) | Self::Each(_) => true,
        }
    }

    /// Returns the names of the robot on its brokers; empty without a broker. `composite` is the default.
    pub(super) fn robots<'r>(&'r self, composite: &'r str) -> Vec<&'r str> {
        let robot = |settings: &'r BrokerSettings| settings.robot().unwrap_or(composite);
        match self {
            Self::Nothing | Self::Inside(_) => Vec::new(),
            Self::One(settings) => vec![robot(settings)],
            Self::Each(brokers) => brokers.values().map(robot).collect(),
        }
    }

    /// Settings of the brokers by name; without a name if one carries everything.
    pub(super) fn settings(&self) -> BTreeMap<Option<&str>, &BrokerSettings> {
        match self {
            Self::Nothing | Self::Inside(_) => BTreeMap::new(),
            Self::One(settings) => BTreeMap::from([(None, settings)]),
            Self::Each(brokers) => {
                let brokers = brokers.iter();
                brokers
                    .map(|(name, it)| (Some(name.as_str()), it))
                    .collect()
            }
        }
    }

    /// Mutable settings of all brokers.
    pub fn settings_mut(&mut self) -> Vec<&mut BrokerSettings> {
        match self {
            Self::Nothing | Self::Inside(_) => Vec::new(),
            Self::One(settings) => vec![settings],
            Self::Each(brokers) => brokers.values_mut().collect(),
        }
    }
}

impl Mission {
    /// Returns the part of the plan that runs in this process.
    pub(super) fn part(&self, plan: &Plan) -> Result<Part, MissionError> {
        let Some(requested) = &self.process else {
            return Ok(match self.brokers {
                MissionBrokers::Nothing | MissionBrokers::Inside(_) => Part::Whole,
                MissionBrokers::One(_) => Part::WholeOverBus,
                MissionBrokers::Each(_) => Part::with_brokers(plan),
            });
        };
        let process = plan.processes.iter().find(|known| known.name == *requested);
        match (process, self.brokers.is_connected()) {
            (None, _) => Err(MissionError::Process {
                requested: requested.clone(),
                available: plan.processes.iter().map(|it| it.name.clone()).collect(),
            }),
            (Some(_), false) if plan.processes.len() > 1 => Err(MissionError::NeedsBroker {
                process: requested.clone(),
                has_variable: std::env::var_os("ASMOTION_BUS").is_some(),
                is_supervised: false,
            }),
            (Some(_), false) => Ok(Part::Whole),
            (Some(process), true) => Ok(Part::of(process)),
        }
    }

    /// Returns the brokers named by the composite; `None` if it names none or has errors, which the run reports.
    ///
    /// # Errors
    /// Fails if there are several brokers and no component is assigned to one.
    pub fn named_brokers(&self) -> Result<Option<NamedBrokers>, String> {
        let named = self.with_plan(|plan| {
            if plan.names_brokers() {
                let requested = self.process.as_ref();
                let process = plan.processes.iter().find(|it| Some(&it.name) == requested);
                let part = process.map_or_else(|| Part::with_brokers(plan), Part::of);
                let brokers = plan.brokers_of(&part).into_iter().cloned();
                return Ok(Some(NamedBrokers::Each(brokers.collect())));
            }
            match &*plan.brokers {
                [] => Ok(None),
                [only] => Ok(Some(NamedBrokers::One(only.clone()))),
                several => {
                    let names: Vec<&str> = several.iter().map(|it| &*it.name).collect();
                    let names = names.join(", ");
                    Err(format!(
                        "several brokers ({names}), but no component names one with `task.broker`: name one there, or with `--bus`"
                    ))
                }
            }
        });
        named.unwrap_or(Ok(None))
    }

    /// Applies a function to the plan, if the composite can be started.
    pub(super) fn with_plan<T>(&self, f: impl FnOnce(&Plan) -> T) -> Option<T> {
        let opened = self.opened.clone().unwrap_or_else(|| {
            Arc::new(self.open(&self.composite, &DiskLoader, self.build.programs()))
        });
        if opened.report.has_errors() {
            return None;
        }
        let plan = opened.plan(self.profile.as_deref());
        let plan = plan.filter(|plan| plan.missing.is_empty());
        plan.map(|plan| f(plan))
    }

    /// Rejects systems outside that the clock and the brokers of the mission do not reach.
    pub(crate) fn check_outside(&self, plan: &Plan) -> Result<(), MissionError> {
        let part = self.part(plan)?;
        self.check_clock(plan, &part)?;
        self.check_robots(plan, &part)
    }

    /// Rejects virtual time if a message queue or a wire leads to a system outside, which uses the wall clock.
    fn check_clock(&self, plan: &Plan, part: &Part) -> Result<(), MissionError> {
        let mut ends = plan.connections.iter().flat_map(|it| [&it.from, &it.to]);
        let queue = ends.find(|it| matches!(it, Terminal::Mqueue(_)));
        let queue = queue.map(ToString::to_string);
        let urls = plan.wires_over_http(part).map(|(_, url)| url.shown());
        let outside = queue.or_else(|| urls.map(str::to_owned).next());
        match (self.clock, outside) {
            (MissionClock::Virtual(_), Some(outside)) => {
                Err(MissionError::Outside(OutsideSystem::WallClock(outside)))
            }
            (MissionClock::Virtual(_), None) | (MissionClock::Wall, _) => Ok(()),
        }
    }

    /// Rejects components and services of other robots without a broker, and those of the robot itself.
    fn check_robots(&self, plan: &Plan, part: &Part) -> Result<(), MissionError> {
        let robots = self.brokers.robots(&plan.name);
        let here = plan.components.iter().filter(|it| part.has(&it.name));
        for address in here.filter_map(|it| it.implementation.robot_component()) {
            if robots.is_empty() {
                let outside = OutsideSystem::RobotComponent(address.to_owned());
                return Err(MissionError::Outside(outside));
            }
            let (robot, component) = split_robot_component(address).unwrap_or_default();
            if robots.contains(&robot) {
                return Err(MissionError::Launch(format!(
                    "`{address}` is a component of this robot, which is called `{robot}`: name `{component}` itself, or start \
                     the robot under another name with `--robot`"
                )));
            }
        }
        for address in plan.robot_addresses(part) {
            if robots.is_empty() {
                let outside = OutsideSystem::RobotService(address.to_string());
                return Err(MissionError::Outside(outside));
            }
            if robots.contains(&address.robot()) {
                let (robot, service) = (address.robot(), address.name());
                return Err(MissionError::Launch(format!(
                    "`{address}` is a service of this robot, which is called `{robot}`: write `service = \"{service}\"`, \
                     or start the robot under another name with `--robot`"
                )));
            }
        }
        Ok(())
    }

    /// Connects to the brokers.
    pub(super) fn connect(
        &self,
        plan: &Plan,
        stop: &AtomicBool,
    ) -> Result<Vec<ConnectedBroker>, MissionError> {
        let named = |(name, settings): (&String, _)| (Some(name.clone()), settings);
        let brokers: Vec<(Option<String>, &BrokerSettings)> = match &self.brokers {
            MissionBrokers::Nothing => Vec::new(),
            MissionBrokers::Inside(bus) => {
                let (location, bus) = ("this process".to_owned(), Arc::new(bus.clone()));
                let name = None;
                return Ok(vec![ConnectedBroker {
                    name,
                    location,
                    warning: None,
                    bus,
                }]);
            }
            MissionBrokers::One(settings) => vec![(None, settings)],
            MissionBrokers::Each(brokers) => brokers.iter().map(named).collect(),
        };
        let connect = |(name, settings): (Option<String>, &BrokerSettings)| {
            let warning = settings.login_warning();
            if let Some(warning) = &warning {
                (self.notice)(warning);
            }
            let (location, bus) = self.connect_to(settings, plan, stop);
            let bus = bus.map_err(|reason| broker_error(&location, reason))?;
            Ok(ConnectedBroker {
                name,
                location,
                warning,
                bus,
            })
        };
        brokers.into_iter().map(connect).collect()
    }

    /// Connects to a broker, and waits for one that is not there yet if the mission is patient.
    fn connect_to(
        &self,
        settings: &BrokerSettings,
        plan: &Plan,
        stop: &AtomicBool,
    ) -> (String, Result<Arc<dyn Bus>, BusError>) {
        let (began, mut reported) = (Instant::now(), None);
        let limit = if self.broker_patience.is_zero() {
            CONNECT
        } else {
            ATTEMPT
        };
        loop {
            let (location, bus) = settings.connect(&plan.name, self.process.as_deref(), limit);
            let left = self.broker_patience.saturating_sub(began.elapsed());
            let is_over = left.is_zero() || stop.load(Ordering::Relaxed);
            let Err(BusError::Disconnected { reason }) = &bus else {
                return (location, bus);
            };
            if is_over {
                return (location, bus);
            }
            if reported.is_none_or(|at: Instant| at.elapsed() >= REPEATED) {
                let left = left.as_secs();
                (self.notice)(&format!(
                    "waiting for the broker at {location}, at most {left} s more: {reason}"
                ));
                reported = Some(Instant::now());
            }
        }
    }

    /// Connects a system to the buses and announces it there.
    pub(super) fn connect_contacts<'p>(
        &self,
        system: &mut System,
        network: &mut Network,
        connected: &'p [ConnectedBroker],
        plan: &'p Plan,
        part: &Part,
    ) -> Result<Vec<ProcessContact<'p>>, MissionError> {
        let incarnation = incarnation();
        let locations: Vec<&str> = connected.iter().map(|it| &*it.location).collect();
        let of_all = |reason| broker_error(&locations.join(", "), reason);
        match (&self.brokers, connected) {
            (MissionBrokers::Nothing, _) => {}
            (MissionBrokers::Inside(_) | MissionBrokers::One(_), connected) => {
                for it in connected {
                    let attached = network.attach(system, it.bus.clone(), incarnation);
                    attached.map_err(of_all)?;
                }
            }
            (MissionBrokers::Each(_), connected) => {
                let named = connected.iter().filter_map(|it| {
                    let bus: Arc<dyn Bus> = it.bus.clone();
                    Some((it.name.clone()?, bus))
                });
                let attached = network.attach_each(system, named.collect(), incarnation);
                attached.map_err(of_all)?;
            }
        }
        let contact = |it: &'p ConnectedBroker| {
            let of_broker = |reason| broker_error(&it.location, reason);
            let contact = self.contact(system, &*it.bus, plan, part, incarnation);
            let mut contact = contact.map_err(of_broker)?;
            let services = network.robot_services(it.name.as_deref());
            contact.watch_robots(services).map_err(of_broker)?;
            Ok(contact)
        };
        connected.iter().map(contact).collect()
    }

    /// Announces a system on a bus within this process: that of its gateways, which thereby show its components, or that of its
    /// dashboard.
    pub(super) fn inside_contact<'p>(
        &self,
        system: &mut System,
        bus: &'p LocalBus,
        plan: &'p Plan,
        part: &Part,
    ) -> Result<ProcessContact<'p>, MissionError> {
        let contact = self.contact(system, bus, plan, part, incarnation());
        contact.map_err(|reason| broker_error("this process", reason))
    }

    /// The name of the process on its buses.
    pub(super) fn process_name<'n>(&'n self, plan: &'n Plan) -> &'n str {
        self.process.as_deref().unwrap_or(&plan.name)
    }

    fn contact<'p>(
        &self,
        system: &mut System,
        bus: &'p dyn Bus,
        plan: &'p Plan,
        part: &Part,
        incarnation: u64,
    ) -> Result<ProcessContact<'p>, BusError> {
        let name = self.process_name(plan);
        let newest = LastSamples::default();
        system.observe(newest.clone());
        ProcessContact::new(plan, part.clone(), name, bus, incarnation, newest)
    }

    /// Returns the receiver of new versions of the composite from the buses.
    pub(super) fn version_switch<'m>(
        &'m self,
        path: &'m str,
        plan: &Arc<Plan>,
        part: &Part,
        connected: &'m [ConnectedBroker],
    ) -> Result<VersionSwitch<'m>, MissionError> {
        let locations: Vec<&str> = connected.iter().map(|it| &*it.location).collect();
        let successor = VersionSwitch::new(self, path, plan, part, connected);
        successor.map_err(|reason| broker_error(&locations.join(", "), reason))
    }
}

fn broker_error(location: &str, reason: BusError) -> MissionError {
    MissionError::Broker {
        location: location.to_owned(),
        reason,
    }
}

/// Incarnation of this process: increases with every start and is unique among processes.
pub(super) fn incarnation() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    u64::try_from(now.unwrap_or_default().as_nanos()).unwrap_or(u64::MAX)
}
