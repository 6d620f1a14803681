//! Components of other robots: asked for their interfaces over the broker before a system is opened, and connected to it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use asmotion_assembly::Make;
use asmotion_component::{Component, Interface};
use asmotion_composite::model::Process;
use asmotion_composite::{ProgramAnswer, Programs, split_robot_component};
use asmotion_plan::Plan;
use asmotion_program::{ProgramCommand, ProgramDeclaration, ProgramError};
use asmotion_remote::{Remote, RobotComponent, StandIn};

use crate::broker::BrokerSettings;

/// Time within which another robot announces a component that a composite names.
const PATIENCE: Duration = Duration::from_secs(30);
/// Time after which a wait for a robot is reported.
const QUIET: Duration = Duration::from_secs(2);

/// Asks programs as others do, and other robots over the brokers of a mission.
pub(super) struct RobotsOnBrokers<'m> {
    programs: &'m dyn Programs,
    /// Settings of the brokers by name; without a name if one carries everything.
    brokers: BTreeMap<Option<&'m str>, &'m BrokerSettings>,
    /// Reports to the user.
    notice: fn(&str),
    /// Ends the wait for a robot.
    stop: &'m AtomicBool,
    /// Connections by name of the broker; empty for the only one.
    remotes: Mutex<BTreeMap<String, Result<Remote, String>>>,
    answers: Mutex<BTreeMap<String, ProgramAnswer>>,
}

impl<'m> RobotsOnBrokers<'m> {
    pub(super) fn new(
        programs: &'m dyn Programs,
        brokers: BTreeMap<Option<&'m str>, &'m BrokerSettings>,
        notice: fn(&str),
        stop: &'m AtomicBool,
    ) -> Self {
        Self {
            programs,
            brokers,
            notice,
            stop,
            remotes: Mutex::default(),
            answers: Mutex::default(),
        }
    }

    /// Returns the constructor of a component that stands for one of another robot; `None` for other components.
    pub(super) fn make(&self, component: &asmotion_plan::Component, plan: &Plan) -> Option<Make> {
        let address = component.implementation.robot_component()?;
        let (robot, name) = split_robot_component(address).ok()?;
        let remote = self.remote(component.pace.broker.as_deref()).ok()?;
        let robot_component = RobotComponent {
            robot: robot.to_owned(),
            component: name.to_owned(),
            declaration: component.program.clone()?.declaration,
            used: used(component, plan),
        };
        Some(Box::new(move |interface: &mut Interface| {
            let stand_in = StandIn::new(remote, robot_component, interface);
            Ok(Box::new(stand_in) as Box<dyn Component>)
        }))
    }

    /// The connection to a broker, which is made once.
    fn remote(&self, broker: Option<&str>) -> Result<Remote, String> {
        let only = || match self.brokers.len() {
            1 => self.brokers.values().next(),
            _ => None,
        };
        let of_all = self.brokers.get(&None);
        let settings = of_all.or_else(|| broker.map_or_else(only, |_| self.brokers.get(&broker)));
        let Some(settings) = settings else {
            return Err("it names no broker of the composite (`task.broker`)".to_owned());
        };
        let mut remotes = self.remotes.lock().unwrap_or_else(PoisonError::into_inner);
        let name = broker.unwrap_or_default().to_owned();
        let remote = remotes.entry(name).or_insert_with(|| settings.watch().1);
        remote.clone()
    }

    fn announced(&self, address: &str, broker: Option<&str>) -> ProgramAnswer {
        let fault = |text: String| ProgramError::Fault {
            code: String::new(),
            text,
        };
        let (robot, component) =
            split_robot_component(address).map_err(|reason| fault(format!("it {reason}")))?;
        let remote = self.remote(broker).map_err(fault)?;
        let began = Instant::now();
        let mut reported = String::new();
        let waits = |reason: &str| {
            if began.elapsed() >= QUIET && *reported != *reason {
                (self.notice)(&format!("waiting for `{address}`: {reason}"));
                reason.clone_into(&mut reported);
            }
            !self.stop.load(Ordering::Relaxed)
        };
        let declaration = remote.announced_component(robot, component, PATIENCE, waits);
        let declaration = RobotComponent::interface(declaration.map_err(fault)?);
        Ok(ProgramDeclaration::new(
            format!("component of robot `{robot}`"),
            declaration,
        ))
    }
}

impl Programs for RobotsOnBrokers<'_> {
    fn ask(&self, command: &ProgramCommand, component: &str) -> Option<ProgramAnswer> {
        self.programs.ask(command, component)
    }

    fn ask_robot(&self, address: &str, broker: Option<&str>) -> Option<ProgramAnswer> {
        if self.brokers.is_empty() {
            return None;
        }
        let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        let answer = answers
            .entry(address.to_owned())
            .or_insert_with(|| self.announced(address, broker));
        Some(answer.clone())
    }

    fn runs(&self, process: &Process) -> bool {
        self.programs.runs(process)
    }
}

/// The ports and services of a component that a plan uses.
fn used(component: &asmotion_plan::Component, plan: &Plan) -> BTreeSet<String> {
    let routes = plan.connection_routes();
    let ends = routes.iter().flat_map(|route| route.ends());
    let used = ends.filter(|end| end.component == component.name);
    used.map(|end| end.name.clone()).collect()
}
