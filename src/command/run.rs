//! `asmotion run`: runs a composite.

pub(super) mod dashboard;
mod report;
#[cfg(feature = "tui")]
mod top;
#[cfg(not(feature = "tui"))]
mod unwatched;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use asmotion_bus::LocalBus;
use asmotion_component::Time;
use asmotion_composite::SettingValue;
use asmotion_datum::Datum;
use asmotion_lang::{Report, Sources};
use asmotion_runtime::Event;
use clap::{Args, ValueEnum};
use serde_json::json;

use crate::broker::BrokerSettings;
use crate::build::Build;
use crate::exit::Exit;
use crate::gateway;
use crate::mission::{
    ListenCallback, ListeningGateway, Mission, MissionBrokers, MissionClock, MissionDashboard,
    MissionError, MissionOutcome, NamedBrokers,
};
use crate::output_files::{OutputArguments, OutputFiles};
use crate::paths::composite_file;
use crate::supervisor::end_with;
use crate::terminal::{TerminalOutput, never_wait, print_progress, print_result};
use crate::transport::BrokerAccess;
use dashboard::DashboardArguments;
use report::{event_json, headline, print_last_changes, print_summary, summary_json};
#[cfg(feature = "tui")]
use top::spectator;
#[cfg(not(feature = "tui"))]
use unwatched::spectator;

/// Runs a composite.
#[derive(Args)]
pub struct Run {
    /// Composite file
    composite: String,

    /// Profile of the composite
    #[arg(long)]
    profile: Option<String>,

    /// Clock: `virtual` (one thread, deterministic) or `wall` [default: `wall` over a broker or gateway, else `virtual`]
    #[arg(long, value_enum)]
    clock: Option<ClockKind>,

    /// Virtual seconds per second of real time; 0 is as fast as possible [default: 0]
    #[arg(long)]
    speed: Option<f64>,

    /// Bus for topics and services: `local` (within this process) or the address of a broker,
    /// `amqp://user@host:port/vhost` [default: the broker named by the composite, else `local`]. The password is
    /// read from ASMOTION_PASSWORD or `--credentials`.
    #[arg(long, value_name = "URL")]
    bus: Option<String>,

    #[command(flatten)]
    access: BrokerAccess,

    /// Robot name, used as the routing-key prefix [default: the composite's name]
    #[arg(long)]
    robot: Option<String>,

    /// Listening address of the HTTP gateway: `127.0.0.1:8080`, `NAME=127.0.0.1:8080` if there are several (port 0
    /// chooses a free port), or `off` [default: the address in the composite]
    #[arg(long, value_name = "ADDRESS")]
    http: Vec<String>,

    /// Runs only this process of the composite's deployment
    #[arg(long, value_name = "NAME")]
    process: Option<String>,

    /// Process id of the `asmotion up` that started this process, which ends with it
    #[arg(long, hide = true)]
    supervisor: Option<i32>,

    #[command(flatten)]
    common: MissionArguments,

    /// Ends the run successfully when a location has a value [default: mode=ARRIVED; a composite without this value succeeds
    /// when its time is up]
    #[arg(long, value_name = "LOCATION=VALUE")]
    until: Vec<String>,

    /// Ends the run as failed when a location has a value, of several components with one specification once each has succeeded or
    /// failed [default: mode=FAILED]
    #[arg(long, value_name = "LOCATION=VALUE")]
    unless: Vec<String>,
}

/// Kind of clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ClockKind {
    Virtual,
    Wall,
}

/// Options common to `run` and `demo`.
#[derive(Args, Clone)]
pub struct MissionArguments {
    /// Seed for noise, slip and `choose`
    #[arg(long)]
    pub seed: Option<u64>,

    /// Goal of the rover in metres on the map, instead of the goal in the composite
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub goal: Option<String>,

    /// Ends the run after this many seconds of its own clock [default: 600, or unlimited for one process of several]
    #[arg(long = "for", value_name = "SECONDS")]
    pub limit: Option<f64>,

    /// Sets a property of the composite (`place=lab`) or of a component (`World.slip=0.01`)
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,

    #[command(flatten)]
    books: OutputArguments,

    /// Prints steps, calls, faults and the summary as JSON, one object per line, on standard output
    #[arg(long)]
    pub json: bool,

    /// Prints only the summary
    #[arg(long, short)]
    pub quiet: bool,

    #[command(flatten)]
    pub dashboard: DashboardArguments,

    /// Shows the system on the terminal while it runs, as `asmotion top` does; `q` ends both
    #[arg(long, conflicts_with = "json")]
    pub top: bool,
}

/// Time for which a supervised process waits for its broker, which may be started with the machine, too.
const BROKER_PATIENCE: Duration = Duration::from_secs(300);

impl Run {
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        if self.composite.ends_with(".asm") {
            terminal.error(format_args!(
                "`{0}` is a specification: `asmotion sim {0}` runs it alone",
                self.composite
            ));
            return Exit::Usage;
        }
        if let Err(problem) = composite_file(&self.composite) {
            terminal.error(problem);
            return Exit::Usage;
        }
        match self.mission(build) {
            Ok(mission) => self
                .common
                .run_mission(&self.composite, &mission, true, terminal),
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }

    fn mission(&self, build: &Build) -> Result<Mission, String> {
        if let Some(supervisor) = self.supervisor {
            end_with(supervisor)?;
        }
        let mut mission = Mission::with_build(build, &self.composite);
        if self.supervisor.is_some() {
            mission.broker_patience = BROKER_PATIENCE;
        }
        mission.profile = self.profile.clone();
        mission.process = self.process.clone();
        self.common.apply(&mut mission)?;
        mission.dashboard = self.common.dashboard(self.process.as_deref(), false)?;
        mission.recording = self.common.books.recording(true);
        mission.open_early();
        mission.brokers = self.brokers(&mission)?;
        self.common.enable_spectators(&mut mission);
        for settings in mission.brokers.settings_mut() {
            settings.prepare(self.robot.clone(), self.common.top);
        }
        mission.gateways = gateway::open(&self.http, &mission.named_gateways(), self.on_listen())?;
        let over = match (mission.brokers.is_connected(), mission.gateways.is_open()) {
            (true, _) => Some(("a broker", "")),
            (false, true) => Some(("a gateway", ", or add `--http off`")),
            (false, false) => None,
        };
        mission.clock = match (self.clock, self.speed, over) {
            (Some(ClockKind::Virtual), _, Some((what, or))) | (None, Some(_), Some((what, or))) => {
                return Err(format!(
                    "a run over {what} uses the wall clock: remove `--clock` and `--speed`{or}"
                ));
            }
            (None, None, Some(_)) => MissionClock::Wall,
            // a run that is watched does not end before anything can be seen
            (None | Some(ClockKind::Virtual), None, None) if mission.dashboard.is_open() => {
                MissionClock::Virtual(1.0)
            }
            (None | Some(ClockKind::Virtual), speed, None) => virtual_clock(speed.unwrap_or(0.0))?,
            (Some(ClockKind::Wall), None, _) => MissionClock::Wall,
            (Some(ClockKind::Wall), Some(_), _) => {
                return Err(
                    "`--speed` needs the virtual clock: the wall clock has its own speed"
                        .to_owned(),
                );
            }
        };
        mission.until = end_conditions(&self.until)?;
        mission.unless = end_conditions(&self.unless)?;
        Ok(mission)
    }

    /// Returns the printer of gateway addresses.
    fn on_listen(&self) -> ListenCallback {
        let (quiet, as_json) = (self.common.quiet, self.common.json);
        // an address in the composite has been checked with it
        let is_unchecked = !self.http.is_empty();
        ListenCallback::new(move |gateway| {
            let ListeningGateway {
                name,
                address,
                needs_token,
            } = gateway;
            let url = format!("http://{address}/services");
            if as_json {
                let object = json!({ "type": "gateway", "v": 1, "name": name, "url": url });
                print_result(object);
            }
            if !quiet {
                print_progress(format_args!("   Listening {url} (gateway `{name}`)"));
            }
            if is_unchecked && !needs_token && !address.ip().is_loopback() {
                print_progress(format_args!(
                    "warning[C067]: the gateway at {address} is open to every program on the network; \
                     give `gateways.{name}` a `token`, or listen at 127.0.0.1"
                ));
            }
        })
    }

    /// The brokers of the run, or none for the local bus.
    fn brokers(&self, mission: &Mission) -> Result<MissionBrokers, String> {
        let named = |broker: &_| BrokerSettings::named(&mission.build, broker, &self.access);
        Ok(match self.bus.as_deref() {
            Some("local") => MissionBrokers::Nothing,
            Some(address) => MissionBrokers::One(BrokerSettings::of_address(
                &mission.build,
                address,
                &self.access,
            )?),
            None => match mission.named_brokers()? {
                None => MissionBrokers::Nothing,
                Some(NamedBrokers::One(broker)) => MissionBrokers::One(named(&broker)?),
                Some(NamedBrokers::Each(brokers)) => {
                    let settings = |it: &asmotion_plan::Broker| Ok((it.name.clone(), named(it)?));
                    let each: Result<_, String> = brokers.iter().map(settings).collect();
                    MissionBrokers::Each(each?)
                }
            },
        })
    }
}

/// The virtual clock at this speed.
pub fn virtual_clock(speed: f64) -> Result<MissionClock, String> {
    if speed.is_finite() && speed >= 0.0 {
        Ok(MissionClock::Virtual(speed))
    } else {
        Err(format!(
            "`--speed {speed}`: expected a number of at least 0"
        ))
    }
}

/// Parses the value of a property as TOML; any other text is a string.
pub fn property_value(written: &str) -> Datum {
    SettingValue::from_toml(written).map_or_else(|| Datum::text(written), |value| value.datum())
}

/// Splits `location=value` options; `None` if there are none.
fn end_conditions(written: &[String]) -> Result<Option<Vec<(String, String)>>, String> {
    if written.is_empty() {
        return Ok(None);
    }
    let split = |text: &String| match text.split_once('=') {
        Some((location, value)) => Ok((location.trim().to_owned(), value.trim().to_owned())),
        None => Err(format!(
            "`{text}` is not of the form LOCATION=VALUE, as in mode=ARRIVED"
        )),
    };
    written
        .iter()
        .map(split)
        .collect::<Result<_, _>>()
        .map(Some)
}

impl MissionArguments {
    /// Applies the options and runs a mission with this title.
    pub fn run(&self, title: &str, mut mission: Mission, terminal: &mut TerminalOutput) -> Exit {
        if let Err(problem) = self.apply(&mut mission) {
            terminal.error(problem);
            return Exit::Usage;
        }
        mission.recording = self.books.recording(false);
        self.enable_spectators(&mut mission);
        self.run_mission(title, &mission, false, terminal)
    }

    /// Runs a mission to which the options have been applied. `warns` prints the warnings about its composite; those of a
    /// composite in the program are no news to its user.
    fn run_mission(
        &self,
        title: &str,
        mission: &Mission,
        warns: bool,
        terminal: &mut TerminalOutput,
    ) -> Exit {
        let clock = match mission.clock {
            MissionClock::Wall => {
                never_wait();
                "wall clock".to_owned()
            }
            MissionClock::Virtual(speed) if speed > 0.0 => format!("virtual clock at {speed}×"),
            MissionClock::Virtual(_) => "virtual clock, as fast as possible".to_owned(),
        };
        let running = format!("{title}, {clock}, seed {}", mission.seed);
        let stop = Arc::new(AtomicBool::new(false));
        on_interrupt(&stop);
        let output_files = match self.books.open() {
            Ok(files) => Arc::new(Mutex::new(files)),
            Err(problem) => {
                terminal.error(problem);
                return Exit::Usage;
            }
        };
        let listener = self.listener(output_files.clone());
        let result = match spectator(self.top, mission) {
            Ok(None) => {
                let open = |report: &Report, sources: &Sources| {
                    if !self.quiet {
                        terminal.status("Running", running);
                    }
                    if warns {
                        terminal.report(report, sources);
                    }
                };
                mission.run(open, listener, &stop)
            }
            Ok(Some(spectator)) => {
                // the screen belongs to the table while the mission runs
                let mut warnings = None;
                let open = |report: &Report, sources: &Sources| {
                    warnings = Some((report.clone(), sources.clone()));
                };
                let result =
                    spectator.run_beside(&stop, || mission.run(open, listener, &stop), headline);
                if let Some((report, sources)) = warnings.filter(|_| warns) {
                    terminal.report(&report, &sources);
                }
                result
            }
            Err(problem) => Err(MissionError::Launch(problem)),
        };
        let result = match result {
            Ok(mission_end) => mission_end,
            Err(MissionError::Composite {
                sources,
                report,
                outside,
            }) => {
                terminal.report(&report, &sources);
                terminal.error(crate::terminal::count(&report).unwrap_or_default());
                return if outside {
                    Exit::Usage
                } else {
                    Exit::refused(&mission.composite)
                };
            }
            Err(error @ MissionError::NotVerified(_)) => {
                terminal.error(error);
                return Exit::Findings;
            }
            Err(error) => {
                let may_improve = error.may_improve() && !mission.broker_patience.is_zero();
                terminal.error(error);
                // a supervisor starts the process again
                return if may_improve {
                    Exit::Findings
                } else {
                    Exit::Usage
                };
            }
        };
        match lock(&output_files).close() {
            Ok(silent) => {
                let unmatched = result.recording.iter().flat_map(|it| &it.unmatched);
                for pattern in silent.into_iter().chain(unmatched.map(String::as_str)) {
                    terminal.warn(format_args!(
                        "`{pattern}`: no port of this name published anything"
                    ));
                }
            }
            Err(problem) => {
                terminal.error(problem);
                return Exit::Usage;
            }
        }
        if self.json {
            terminal.result(summary_json(&result));
        } else {
            if self.prints_story() {
                print_last_changes(&result, terminal);
            }
            print_summary(&result, terminal);
        }
        match result.outcome {
            // a goal that is reached by pushing something aside is not a success
            MissionOutcome::Reached | MissionOutcome::Completed
                if result.summary.collisions > 0 =>
            {
                Exit::Findings
            }
            MissionOutcome::Reached | MissionOutcome::Completed => Exit::Ok,
            // one process of several runs until it is stopped
            MissionOutcome::Stopped if mission.process.is_some() => Exit::Ok,
            MissionOutcome::Failed | MissionOutcome::TimeUp | MissionOutcome::Stopped => {
                Exit::Findings
            }
            MissionOutcome::Fault => Exit::Fault,
        }
    }

    /// Gives the mission a local bus for `--top` if there is no broker.
    fn enable_spectators(&self, mission: &mut Mission) {
        if let (true, MissionBrokers::Nothing) = (self.top, &mission.brokers) {
            mission.brokers = MissionBrokers::Inside(LocalBus::new());
        }
    }

    /// The dashboard of the run, as the process with this name if it is one of several. `opens_browser` opens it in a browser.
    pub fn dashboard(
        &self,
        process: Option<&str>,
        opens_browser: bool,
    ) -> Result<MissionDashboard, String> {
        let output = (self.quiet, self.json);
        self.dashboard.dashboard(process, output, opens_browser)
    }

    fn apply(&self, mission: &mut Mission) -> Result<(), String> {
        self.books.check()?;
        mission.tells_steps = self.prints_story() || self.json || self.books.traces_steps();
        if let Some(seed) = self.seed {
            mission.seed = seed;
            mission.seeds_composite = true;
        }
        match self.limit {
            None if mission.process.is_some() => mission.limit = None,
            None => {}
            Some(limit) if limit.is_nan() || limit <= 0.0 => {
                return Err(format!("`--for {limit}`: expected a time above zero"));
            }
            Some(limit) => {
                let limit =
                    Duration::try_from_secs_f64(limit).map_err(|error| error.to_string())?;
                mission.limit = Some(limit);
            }
        }
        if let Some(goal) = &self.goal {
            let numbers: Vec<f64> = goal
                .split(',')
                .filter_map(|part| {
                    part.trim()
                        .parse()
                        .ok()
                        .filter(|number: &f64| number.is_finite())
                })
                .collect();
            let [x, y] = numbers.as_slice() else {
                return Err(format!(
                    "`--goal {goal}`: expected two numbers, as in `--goal 26.4,4.2`"
                ));
            };
            let script = Datum::List(vec![Datum::text(format!("1.0 goal {x} {y}"))]);
            mission
                .properties
                .push(("Operator".to_owned(), "script".to_owned(), script));
        }
        for setting in &self.set {
            let Some((name, value)) = setting.split_once('=') else {
                return Err(format!("`--set {setting}` is not of the form NAME=VALUE"));
            };
            match name.split_once('.') {
                None => mission.settings.push((name.to_owned(), value.to_owned())),
                Some((component, property)) => {
                    let value = property_value(value);
                    mission
                        .properties
                        .push((component.to_owned(), property.to_owned(), value));
                }
            }
        }
        Ok(())
    }

    /// Whether events are printed as lines while the mission runs.
    fn prints_story(&self) -> bool {
        !self.quiet && !self.json && !self.top
    }

    /// The listener for events: prints text or, for programs, JSON.
    fn listener(
        &self,
        output_files: Arc<Mutex<OutputFiles>>,
    ) -> impl FnMut(Time, &Event<'_>, Option<&str>) + Send + 'static {
        let (tell, as_json) = (self.prints_story(), self.json);
        let writes_files = lock(&output_files).is_any();
        move |at, event, line| {
            if writes_files {
                lock(&output_files).note(at, event);
            }
            if let (true, Some(line)) = (tell, line) {
                print_progress(line);
            }
            if as_json && let Some(object) = event_json(at, event) {
                print_result(object);
            }
        }
    }
}

/// Locks the books; they are consistent even if a listener panicked while it held the lock.
fn lock(output_files: &Mutex<OutputFiles>) -> MutexGuard<'_, OutputFiles> {
    output_files.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Time after the first signal in which others are the same one: a terminal that is closed sends SIGHUP several times, and so does its
/// shell.
const SAME_SIGNAL: Duration = Duration::from_secs(1);

/// Installs a handler: the first Ctrl-C stops the run in order, a later one at once.
fn on_interrupt(stop: &Arc<AtomicBool>) {
    let stop = stop.clone();
    let first = OnceLock::new();
    // without the handler, Ctrl-C ends the process at once
    let _ = ctrlc::set_handler(move || {
        stop.store(true, Ordering::Relaxed);
        match first.get() {
            None => {
                // set once, here
                let _ = first.set(Instant::now());
                print_progress("\n    Stopping (Ctrl-C again to abort)");
            }
            Some(first) if first.elapsed() < SAME_SIGNAL => {}
            Some(_) => std::process::exit(130),
        }
    });
}
