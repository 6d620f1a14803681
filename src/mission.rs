//! Assembles a composite and runs it until an end condition holds.

mod client;
mod connected_broker;
mod dashboard;
mod director;
mod end_condition;
mod error;
mod gateway;
#[cfg(any(feature = "dashboard", feature = "mcap"))]
mod message_types;
mod outcome;
mod outside;
mod process;
mod proof;
mod recording;
mod robots;
mod stall;
mod version_switch;

#[cfg(all(feature = "dashboard", feature = "mcap"))]
pub(crate) use self::dashboard::dashboard_settings;
pub use self::dashboard::{DashboardCallback, MissionDashboard};
pub use self::director::{Director, Undirected};
pub use self::gateway::{ListenCallback, ListeningGateway, MissionGateways};
pub use error::MissionError;
pub use outcome::MissionOutcome;
pub use outside::OutsideSystem;
pub use process::{MissionBrokers, NamedBrokers};
pub use recording::{RecordingRequest, RecordingResult};
pub use stall::StalledCoordinator;
pub use version_switch::{CompositeVersion, reconfigure_address};

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use asmotion_assembly::{Assembled, CoordinatorOptions, Standard, StartError};
use asmotion_bus::LocalBus;
use asmotion_component::Time;
use asmotion_composite::Programs;
use asmotion_coordinator::{BRIEF_STEP_REPORT, RECORDED_CYCLE_REPORT, STEP_REPORT};
use asmotion_datum::Datum;
use asmotion_diagnostics::similar;
use asmotion_lang::{Loader, Report, Sources};
use asmotion_plan::{Implementation, Opened, Plan};
use asmotion_remote::{CLOCK_REMEDY, ProcessContact};
use asmotion_runtime::{Event, Observer, Pace, ReportInterest, Run};

use crate::bridges::Bridges;
use crate::build::Build;
use crate::files::DiskLoader;
use crate::programs::{ProcessChoice, ProgramsHere};

use crate::terminal::print_warning;
use asmotion_story::{SharedStory, Story, Summary};
use dashboard::OpenDashboard;
use end_condition::{EndCondition, SLICE, awaited_updates};
use recording::{MissionRecorder, RecordedMission};
use robots::RobotsOnBrokers;
use stall::FinalStatuses;
use version_switch::VersionSwitch;

/// A composite and the options of its run.
#[derive(Clone, Debug)]
pub struct Mission {
    /// The components that the composite uses.
    pub build: Build,
    /// Path of the composite.
    pub composite: String,
    /// Selected profile.
    pub profile: Option<String>,
    /// Properties of the composite set on the command line: name and text.
    pub settings: Vec<(String, String)>,
    /// Properties of components set on the command line: component, property, value.
    pub properties: Vec<(String, String, Datum)>,
    /// Seed for the choices of specifications.
    pub seed: u64,
    /// `true` if the seed also sets the composite's property `seed`, if there is one.
    pub seeds_composite: bool,
    /// Clock of the run.
    pub clock: MissionClock,
    /// Brokers for topics and wires.
    pub brokers: MissionBrokers,
    /// Time for which the mission waits for a broker that is not there yet.
    pub broker_patience: Duration,
    /// HTTP gateways.
    pub gateways: MissionGateways,
    /// The dashboard.
    pub dashboard: MissionDashboard,
    /// Process to run, if the composite is deployed to several; `None` runs all of it.
    pub process: Option<String>,
    /// The run succeeds when a location has one of these values, as pairs of location and value. `None` means
    /// `mode = ARRIVED`, if a specification has this location and value; otherwise the run succeeds when its time is up.
    pub until: Option<Vec<(String, String)>>,
    /// The run fails when a location has one of these values. `None` means `mode = FAILED`.
    pub unless: Option<Vec<(String, String)>>,
    /// Upper bound on the duration of the run in its own time; `None` is unlimited.
    pub limit: Option<Duration>,
    /// Components whose failure does not end the run.
    pub may_fail: Vec<String>,
    /// Recording of the run.
    pub recording: RecordingRequest,
    /// Whether the receiver of events uses the story, and all steps as text (default: `true`). If not, and nobody else does, most steps come as
    /// their numbers ([`BRIEF_STEP_REPORT`]), which takes less time.
    pub tells_steps: bool,
    /// Receives what the verification before the start finds, if the composite starts all the same; by default, it is printed as
    /// a warning on standard error.
    pub notice: fn(&str),
    /// The composite as [`open_early`](Self::open_early) has opened it.
    opened: Option<Arc<Opened>>,
}

/// Clock of a mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MissionClock {
    /// One thread and a virtual clock that advances this many seconds per second of real time; 0 is as fast as
    /// possible.
    Virtual(f64),
    /// The wall clock, with a thread for each component.
    Wall,
}

impl MissionClock {
    /// Returns the clock in words.
    fn describe(self) -> String {
        match self {
            Self::Wall => "wall clock".to_owned(),
            Self::Virtual(speed) if speed > 0.0 => format!("virtual clock, {speed}×"),
            Self::Virtual(_) => "virtual clock, as fast as possible".to_owned(),
        }
    }
}

/// Result of a mission.
#[derive(Clone, Debug, PartialEq)]
pub struct MissionEnd {
    /// The end condition that was met, or another reason for the end.
    pub outcome: MissionOutcome,
    /// Summary of its events.
    pub summary: Summary,
    /// Components that failed and were not running at the end.
    pub failed: Vec<String>,
    /// Inputs, as `component.port`, with the number of messages lost on the way to them; those without losses are omitted.
    pub lost: Vec<(String, u64)>,
    /// Services, as `component.service`, with the number of requests refused because their queues were full; those without are
    /// omitted.
    pub refused: Vec<(String, u64)>,
    /// Lines of the last changes that the story has only counted.
    pub last_changes: Vec<String>,
    /// Components with the number of messages and requests that did not fit them; those without are omitted.
    pub unsuitable: Vec<(String, u64)>,
    /// The coordinators and what they wait for, if the time was up.
    pub stalled: Vec<StalledCoordinator>,
    /// Recording of the run; `None` if it was not recorded as MCAP.
    pub recording: Option<RecordingResult>,
    /// Duration in its own time.
    pub time: Duration,
    /// Duration in real time.
    pub wall: Duration,
}

/// Time for the robot to come to rest after the end.
const REST: Duration = Duration::from_secs(1);

impl Mission {
    /// Returns a mission of the standard components in virtual time, as fast as possible, that ends with `mode` ARRIVED or FAILED, or after ten
    /// minutes.
    pub fn new(composite: impl Into<String>) -> Self {
        Self::with_build(&Build::standard(), composite)
    }

    /// Returns a mission as [`new`](Self::new) does, of the components of this build.
    pub fn with_build(build: &Build, composite: impl Into<String>) -> Self {
        Self {
            build: build.clone(),
            composite: composite.into(),
            profile: None,
            settings: Vec::new(),
            properties: Vec::new(),
            seed: 1,
            seeds_composite: false,
            clock: MissionClock::Virtual(0.0),
            brokers: MissionBrokers::Nothing,
            broker_patience: Duration::ZERO,
            gateways: MissionGateways::Closed,
            dashboard: MissionDashboard::Closed,
            process: None,
            until: None,
            unless: None,
            limit: Some(Duration::from_secs(600)),
            may_fail: Vec::new(),
            recording: RecordingRequest::default(),
            tells_steps: true,
            notice: print_warning,
            opened: None,
        }
    }

    /// Opens the composite once for its [brokers](Self::named_brokers), its [gateways](Self::named_gateways) and the run. The run opens it
    /// again if it has errors, or components of other robots, which are asked over the brokers. Call this after setting the profile, the
    /// process and the properties.
    pub(crate) fn open_early(&mut self) {
        let opened = self.open(&self.composite, &DiskLoader, self.build.programs());
        self.opened = Some(Arc::new(opened));
    }

    /// Returns `true` if a composite that was opened without the brokers of the mission is the same with them.
    fn holds_with_brokers(&self, opened: &Opened) -> bool {
        let asks_robots = self.brokers.is_connected() && opened.has_robot_components();
        !opened.report.has_errors() && !asks_robots
    }

    /// Runs the mission. `on_open` receives the findings about the composite, if it has no errors, before anything starts.
    /// `on_event` receives every event, with its line of the story if it has one; setting `stop` ends the run early.
    ///
    /// # Errors
    /// Fails if the composite has errors or cannot be assembled in this binary.
    pub fn run(
        &self,
        on_open: impl FnOnce(&Report, &Sources),
        on_event: impl FnMut(Time, &Event<'_>, Option<&str>) + Send + 'static,
        stop: &AtomicBool,
    ) -> Result<MissionEnd, MissionError> {
        self.run_directed(&mut Undirected, on_open, on_event, stop)
    }

    /// Runs the mission as [`run`](Self::run) does, while a director acts on it.
    ///
    /// # Errors
    /// As [`run`](Self::run), and if the director refuses the plan.
    pub fn run_directed(
        &self,
        director: &mut dyn Director,
        on_open: impl FnOnce(&Report, &Sources),
        mut on_event: impl FnMut(Time, &Event<'_>, Option<&str>) + Send + 'static,
        stop: &AtomicBool,
    ) -> Result<MissionEnd, MissionError> {
        let programs = self.build.programs();
        let robots = RobotsOnBrokers::new(programs, self.brokers.settings(), self.notice, stop);
        let opened = match &self.opened {
            Some(opened) if self.holds_with_brokers(opened) => Arc::clone(opened),
            _ => Arc::new(self.open(&self.composite, &DiskLoader, &robots)),
        };
        let mut report = opened.report.clone();
        if let Some(plan) = opened.plan(self.profile.as_deref()) {
            proof::without_verified(&mut report, plan);
        }
        if report.has_errors() {
            return Err(MissionError::Composite {
                sources: opened.sources.clone(),
                report,
                outside: opened.outside,
            });
        }
        on_open(&report, &opened.sources);
        let Some(plan) = opened.plan(self.profile.as_deref()) else {
            let (wanted, known) = (self.profile.clone(), opened.profiles.clone());
            return Err(MissionError::Profile {
                requested: wanted,
                available: known,
            });
        };
        director.prepare(plan).map_err(MissionError::Director)?;
        let part = self.part(plan)?;
        self.verify_before_start(plan, &part, &DiskLoader)?;
        self.check_outside(plan)?;
        let watch = EndCondition::new(
            plan,
            &part,
            awaited_updates(plan, self.until.as_deref(), "ARRIVED")?,
            awaited_updates(plan, self.unless.as_deref(), "FAILED")?,
        )
        .tolerating(&self.may_fail);
        let mut bridges = Bridges::on(&self.brokers.settings(), &plan.name);
        let catalogue = self.build.catalogue();
        let mut builtins = |component: &_, plan: &_| {
            let robot = robots.make(component, plan);
            robot.or_else(|| bridges.make(catalogue, component, plan))
        };
        let workshop = Standard::new(catalogue, &DiskLoader, self.coordinator_options(plan));
        let mut workshop = workshop.with_builtins(&mut builtins);
        let assembled = asmotion_assembly::start_part(plan, &part, &mut workshop);
        let Assembled {
            mut system,
            mut network,
        } = assembled.map_err(|error| {
            let reason = error.to_string();
            if let StartError::Missing { variables } = error {
                MissionError::UnsetVariables(variables)
            } else if let StartError::NotMade { component, .. } = error
                && self.lacks(plan, &component)
            {
                let composite = self.composite.clone();
                MissionError::NotInBuild { reason, composite }
            } else {
                MissionError::Launch(reason)
            }
        })?;
        for (component, property, value) in &self.properties {
            if plan.component(component).is_none() {
                let known = plan.components.iter().map(|known| &known.name);
                return Err(MissionError::Component {
                    name: component.clone(),
                    similar: similar(component, known).cloned(),
                });
            }
            // a component of another process is set in that process
            let Some(id) = system.id(component) else {
                continue;
            };
            let set = system.set_property(id, property, value);
            set.map_err(|error| MissionError::Launch(error.to_string()))?;
        }
        let story = Story::of(plan, &part);
        let story = if self.tells_steps {
            story
        } else {
            story.silent()
        };
        let story = SharedStory::new(story);
        let reports = self.used_reports(&watch);
        let watch = Arc::new(Mutex::new(watch));
        let (listener, watcher) = (story.clone(), watch.clone());
        let observer = move |at: Time, event: &Event<'_>| {
            let line = listener.report(at, event);
            on_event(at, event, line.as_deref());
            if end_condition::concerns(event) {
                lock(&watcher).observe(at, event);
            }
        };
        system.observe(observer.using(reports));
        bridges.observe(&mut system, plan);
        let connected = self.connect(plan, stop)?;
        // before the process is announced: it can be reconfigured from then on, and its files may change
        let mut successor = self.version_switch(&opened.path, plan, &part, &connected)?;
        let mut contacts =
            self.connect_contacts(&mut system, &mut network, &connected, plan, &part)?;
        let (gateway_bus, dashboard_bus) = (LocalBus::new(), LocalBus::new());
        let gateways = self.open_gateways(
            &mut system,
            &mut network,
            &opened,
            plan,
            &part,
            &gateway_bus,
        )?;
        if !gateways.is_empty() {
            contacts.push(self.inside_contact(&mut system, &gateway_bus, plan, &part)?);
        }
        let mut dashboard = OpenDashboard::open(
            &self.dashboard,
            &mut system,
            (plan, &part),
            self.clock.describe(),
            (&dashboard_bus, self.process_name(plan)),
            // without a broker, the process has a bus for itself
            if self.brokers.is_connected() {
                &connected
            } else {
                &[]
            },
        )?;
        if dashboard.is_some() {
            let contact = self.inside_contact(&mut system, &dashboard_bus, plan, &part)?;
            // the dashboard knows more about who asks
            contacts.push(contact.without_commands());
        }
        let client = self.connect_clients(&mut system, &mut network, plan, &part)?;
        successor.set_network(network.running(), client.clients());
        drop(network);
        let recorder = MissionRecorder::start(&self.recorded(), &opened, plan, &mut system);
        let mut recorder = recorder.map_err(MissionError::Launch)?;
        let began = Instant::now();
        let mut run: Box<dyn Run> = match self.clock {
            MissionClock::Wall => Box::new(system.live()),
            MissionClock::Virtual(speed) => {
                let mut simulation = system.simulate();
                simulation.set_pace(if speed > 0.0 {
                    Pace::Factor(speed)
                } else {
                    Pace::Unlimited
                });
                Box::new(simulation)
            }
        };
        let outcome = self.drive(
            &mut *run,
            director,
            (&watch, &story),
            stop,
            (&mut contacts, &mut bridges, &mut dashboard, &mut recorder),
            &mut successor,
        );
        director.finish(run.now());
        pass_commands(&mut contacts, dashboard.as_ref(), &mut recorder);
        if let Some(dashboard) = &mut dashboard {
            dashboard.end(outcome.name());
        }
        let time = run.now().since(Time::ZERO);
        let failed = lock(&watch).dead(&*run).cloned().collect();
        let mut summary = story.summary();
        // a control state that a step has set is known, and its coordinator does not wait since the start
        let is_wanted = |component: &str| {
            outcome == MissionOutcome::TimeUp || !summary.control_states.contains_key(component)
        };
        let statuses = FinalStatuses::of(&successor.running().plan, &mut *run, is_wanted);
        for (component, state) in statuses.control_states() {
            summary.add_final_control_state(component, &state);
        }
        let stalled = match outcome {
            MissionOutcome::TimeUp => statuses.stalled(),
            // without a goal, a coordinator may wait at the end; one that has never done anything is worth a word
            MissionOutcome::Completed => statuses.stalled_since_start(),
            MissionOutcome::Reached
            | MissionOutcome::Failed
            | MissionOutcome::Fault
            | MissionOutcome::Stopped => Vec::new(),
        };
        if outcome == MissionOutcome::Reached || outcome == MissionOutcome::Failed {
            run.run_for(REST);
        }
        for contact in &mut contacts {
            contact.describe_end(&mut *run);
        }
        // pending calls are answered before their providers stop
        drop(gateways);
        run.stop();
        let (lost, unsuitable) = (lost_messages(&*run), unsuitable_messages(&*run));
        let refused = refused_requests(&*run);
        // the last messages of the components are sent before the bus closes
        contacts.iter_mut().for_each(ProcessContact::leave);
        drop((run, contacts, successor, dashboard));
        drop((connected, client));
        let recording = recorder.finish();
        Ok(MissionEnd {
            outcome,
            summary,
            failed,
            lost,
            refused,
            last_changes: story.last_changes(),
            unsuitable,
            stalled,
            recording,
            time,
            wall: began.elapsed(),
        })
    }

    /// Returns whether a component's implementation is in Rust and not in this build.
    fn lacks(&self, plan: &Plan, component: &str) -> bool {
        let component = plan.component(component);
        component.is_some_and(|it| match &it.implementation {
            Implementation::Rust(name) => self.build.catalogue().factory(name).is_none(),
            Implementation::Asm { .. }
            | Implementation::Builtin { .. }
            | Implementation::Process { .. }
            | Implementation::Ros { .. }
            | Implementation::Orocos { .. } => false,
        })
    }

    /// Opens a version of the composite with the properties set on the command line.
    fn open(&self, composite: &str, files: &dyn Loader, programs: &dyn Programs) -> Opened {
        let programs = &ProgramsHere {
            programs,
            choice: ProcessChoice::named(self.process.as_deref()),
        };
        let opened = self
            .build
            .open_with(composite, &self.settings, files, programs);
        let properties = opened.composite.iter().flat_map(|it| &it.properties);
        let has_seed = properties
            .map(|it| &*it.name.value)
            .any(|name| name == "seed");
        if !(self.seeds_composite && has_seed) {
            return opened;
        }
        let mut settings = self.settings.clone();
        settings.push(("seed".to_owned(), self.seed.to_string()));
        self.build.open_with(composite, &settings, files, programs)
    }

    fn drive(
        &self,
        run: &mut dyn Run,
        director: &mut dyn Director,
        (watch, story): (&Mutex<EndCondition>, &SharedStory),
        stop: &AtomicBool,
        (contacts, bridges, dashboard, recorder): (
            &mut [ProcessContact<'_>],
            &mut Bridges,
            &mut Option<OpenDashboard>,
            &mut MissionRecorder,
        ),
        successor: &mut VersionSwitch<'_>,
    ) -> MissionOutcome {
        let limit = self.limit.map(|limit| Time::ZERO + limit);
        loop {
            if let Some(outcome) = lock(watch).outcome(run) {
                return outcome;
            }
            if stop.load(Ordering::Relaxed) {
                return MissionOutcome::Stopped;
            }
            if let Some(outcome) = director.act(run) {
                return outcome;
            }
            for contact in &mut *contacts {
                contact.process_orders(run);
                for clock in contact.take_wrong_clocks() {
                    let remedy = CLOCK_REMEDY.replace('\n', " ");
                    (self.notice)(&format!("{clock}: {remedy}"));
                }
                for problem in contact.take_robot_problems() {
                    (self.notice)(&problem);
                }
            }
            if let Some(dashboard) = dashboard {
                dashboard.process();
            }
            pass_commands(contacts, dashboard.as_ref(), recorder);
            recorder.queues(run);
            bridges.process(run);
            if successor.process_requests(run) {
                bridges.follow();
                let version = successor.running();
                self.watch_robots(contacts, successor);
                for contact in &mut *contacts {
                    contact.follow(&version.plan, &version.part);
                    contact.process_orders(run);
                }
                lock(watch).follow(&version.plan, &version.part);
                story.follow(&version.plan);
                if let Some(dashboard) = dashboard {
                    dashboard.follow(version);
                }
                if let Some(opened) = successor.opened() {
                    recorder.follow(run.now(), opened, &version.plan);
                }
            }
            let mut until = run.now() + SLICE;
            if let Some(limit) = limit {
                if run.now() >= limit {
                    let failed = lock(watch).dead(run).next().is_some();
                    let has_goal = lock(watch).has_goal() || director.has_goal();
                    return match (failed, has_goal) {
                        (true, _) => MissionOutcome::Fault,
                        (false, true) => MissionOutcome::TimeUp,
                        (false, false) => MissionOutcome::Completed,
                    };
                }
                until = until.min(limit);
            }
            if let Some(next) = director.next() {
                until = until.min(next);
            }
            // as fast as possible, no time passes outside between two steps
            let as_fast_as_possible =
                matches!(self.clock, MissionClock::Virtual(speed) if speed <= 0.0);
            let stops_at_steps = !as_fast_as_possible || lock(watch).depends_on_steps();
            run.run_until_event_among(until, ReportInterest::NONE, &mut |at, event| {
                let stops = || stops_at_steps || limit.is_some_and(|limit| at >= limit);
                is_notable(event, stops) || director.is_due(at)
            });
        }
    }

    /// The reports that the story and the end conditions use.
    fn used_reports(&self, watch: &EndCondition) -> ReportInterest {
        if self.tells_steps || watch.needs_all_steps() {
            ReportInterest::All
        } else {
            ReportInterest::Except(&[STEP_REPORT])
        }
    }

    /// Compares services of other robots that a new version calls with their announcements.
    fn watch_robots(&self, contacts: &mut [ProcessContact<'_>], successor: &VersionSwitch<'_>) {
        // the contacts of gateways and of the dashboard follow those of the brokers
        for (contact, services) in contacts.iter_mut().zip(successor.new_robot_services()) {
            if let Err(error) = contact.watch_robots(services) {
                (self.notice)(&format!(
                    "services of other robots are not compared with what they announce: {error}"
                ));
            }
        }
    }

    /// Returns the options of the coordinators of a plan.
    fn coordinator_options(&self, plan: &Plan) -> CoordinatorOptions {
        CoordinatorOptions {
            seed: self.seed,
            records_cycles: self.recording.records_cycles(plan),
        }
    }

    /// The mission, as far as its recording depends on it.
    fn recorded(&self) -> RecordedMission<'_> {
        let settings = self.settings.iter();
        let settings = settings.map(|(name, value)| format!("{name}={value}"));
        let properties = self.properties.iter();
        let properties = properties.map(|(of, name, value)| format!("{of}.{name}={value}"));
        RecordedMission {
            request: &self.recording,
            is_virtual: matches!(self.clock, MissionClock::Virtual(_)),
            seed: self.seed,
            profile: self.profile.as_deref(),
            process: self.process.as_deref(),
            settings: settings.chain(properties).collect(),
            notice: self.notice,
        }
    }
}

/// Returns whether an event can end the run. The record of a cycle cannot: a run takes the same course whether it is recorded or
/// not. Nor does it depend on what a report says, which may be brief. `stops_at_steps` says whether a step can end it.
fn is_notable(event: &Event<'_>, stops_at_steps: impl FnOnce() -> bool) -> bool {
    match event {
        Event::Report { kind, .. } => match *kind {
            RECORDED_CYCLE_REPORT => false,
            STEP_REPORT | BRIEF_STEP_REPORT => stops_at_steps(),
            _ => true,
        },
        Event::Fault { .. } => true,
        Event::Cycle { .. }
        | Event::Published { .. }
        | Event::Injected { .. }
        | Event::Called { .. }
        | Event::Answered { .. }
        | Event::Replied { .. }
        | Event::LifeCycle { .. }
        | Event::Overrun { .. }
        | Event::Late { .. }
        | Event::Denied { .. }
        | Event::Dropped { .. }
        | Event::Property { .. }
        | Event::Lost { .. } => false,
    }
}

/// Records what others have asked of the system since the last call. The dashboard shows also what did not come from its tabs.
fn pass_commands(
    contacts: &mut [ProcessContact<'_>],
    dashboard: Option<&OpenDashboard>,
    recorder: &mut MissionRecorder,
) {
    let commands = contacts
        .iter_mut()
        .flat_map(ProcessContact::take_commands)
        .collect::<Vec<_>>();
    recorder.commands(&commands);
    if let Some(dashboard) = dashboard {
        dashboard.show_commands(&commands);
        recorder.commands(&dashboard.take_commands());
    }
}

/// Locks the mutex; its content is consistent even if a listener panicked while it held the lock.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The inputs with lost messages, and the numbers of these.
fn lost_messages(run: &dyn Run) -> Vec<(String, u64)> {
    let mut all = Vec::new();
    for component in run.components() {
        let counts = run.lost(&component);
        if counts.iter().all(|it| *it == 0) {
            continue;
        }
        let inputs = run.declaration(&component).unwrap_or_default().inputs;
        let lost = inputs.into_iter().zip(counts).filter(|it| it.1 > 0);
        all.extend(lost.map(|(port, count)| (format!("{component}.{}", port.name), count)));
    }
    all
}

/// The services with requests refused because their queues were full, and the numbers of these.
fn refused_requests(run: &dyn Run) -> Vec<(String, u64)> {
    let mut all = Vec::new();
    for component in run.components() {
        let counts = run.refused_requests(&component);
        if counts.iter().all(|it| *it == 0) {
            continue;
        }
        let services = run.declaration(&component).unwrap_or_default().services;
        let refused = services.into_iter().zip(counts).filter(|it| it.1 > 0);
        all.extend(
            refused.map(|(service, count)| (format!("{component}.{}", service.name), count)),
        );
    }
    all
}

/// The components that refused messages, and the numbers of these.
fn unsuitable_messages(run: &dyn Run) -> Vec<(String, u64)> {
    let components = run.components().into_iter();
    let counts = components.map(|it| (it.clone(), run.losses(&it).misfits));
    counts.filter(|(_, count)| *count > 0).collect()
}
