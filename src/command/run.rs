//! `asmotion run`: a composite.

mod told;
mod watched;

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use asmotion_assembly::{Value, plan};
use asmotion_bus::Local;
use asmotion_component::{Event, Time};
use asmotion_datum::Datum;
use clap::{Args, ValueEnum};
use serde_json::json;

use crate::books::{Books, Wanted};
use crate::broker::{self, Access};
use crate::exit::Exit;
use crate::gateway;
use crate::mission::{Brokers, Clock, Mission, MissionError, Named, Outcome, Told};
use crate::terminal::Terminal;
use told::{event_json, summarise, summary_json};

/// Runs a composite.
#[derive(Args)]
pub struct Run {
    /// The composite.
    composite: String,

    /// Which of its profiles.
    #[arg(long)]
    profile: Option<String>,

    /// In virtual time (one thread, the same way each time) or as time passes on the wall; over a
    /// broker or a gateway it is the wall's.
    #[arg(long, value_enum)]
    clock: Option<ClockKind>,

    /// Virtual seconds in one second of the wall; 0, as without it, is as fast as possible.
    #[arg(long)]
    speed: Option<f64>,

    /// Over which bus topics and services go: `local`, within this process, or a broker's address,
    /// `amqp://user@host:port/vhost`; without it, over the broker that the composite names, if it names
    /// one. The password comes from ASMOTION_PASSWORD, or `--credentials`.
    #[arg(long, value_name = "URL")]
    bus: Option<String>,

    #[command(flatten)]
    access: Access,

    /// Whose topics these are on the broker: keys are `ROBOT.TOPIC`; the composite's name without it.
    #[arg(long)]
    robot: Option<String>,

    /// Where the gateway listens through which services are called over HTTP, `127.0.0.1:8080` or, of
    /// several, `NAME=127.0.0.1:8080` (port 0 is a free one), or `off`; without it, where the composite
    /// says.
    #[arg(long, value_name = "ADDRESS")]
    http: Vec<String>,

    /// Runs one of the processes that the composite is deployed to; the others run elsewhere.
    #[arg(long, value_name = "NAME")]
    process: Option<String>,

    #[command(flatten)]
    common: Common,

    /// Ends well when a location gets a value; without it, with `mode=ARRIVED`.
    #[arg(long, value_name = "LOCATION=VALUE")]
    until: Vec<String>,

    /// Ends badly when a location gets a value; without it, with `mode=FAILED`.
    #[arg(long, value_name = "LOCATION=VALUE")]
    unless: Vec<String>,
}

/// In which time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ClockKind {
    Virtual,
    Wall,
}

/// What `run` and `demo` have in common.
#[derive(Args, Clone)]
pub struct Common {
    /// Decides what is left to chance: noise, slip, `choose`.
    #[arg(long)]
    pub seed: Option<u64>,

    /// Sends the rover here instead of where the composite says; metres on the map.
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub goal: Option<String>,

    /// Ends after so many seconds of its own time; without it after 600, or never where it is one
    /// process of several.
    #[arg(long = "for", value_name = "SECONDS")]
    pub limit: Option<f64>,

    /// Sets a property of the composite (`place=lab`) or of a component (`World.slip=0.01`).
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,

    #[command(flatten)]
    books: Wanted,

    /// Steps, calls, faults and the summary as JSON, one object a line, on standard output.
    #[arg(long)]
    pub json: bool,

    /// The summary alone.
    #[arg(long, short)]
    pub quiet: bool,

    /// Shows the system on the terminal while it runs, as `asmotion top` does; `q` ends both.
    #[arg(long, conflicts_with = "json")]
    pub top: bool,
}

impl Run {
    /// Runs it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        if self.composite.ends_with(".asm") {
            terminal.error(format_args!(
                "`{0}` is a specification: `asmotion sim {0}` runs it alone",
                self.composite
            ));
            return Exit::Usage;
        }
        match self.mission() {
            Ok(mission) => self.common.run_applied(&self.composite, &mission, terminal),
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }

    fn mission(&self) -> Result<Mission, String> {
        let mut mission = Mission::new(&self.composite);
        mission.profile = self.profile.clone();
        mission.process = self.process.clone();
        self.common.apply(&mut mission)?;
        mission.brokers = self.brokers(&mission)?;
        self.common.open_to_spectators(&mut mission);
        for settings in mission.brokers.settings_mut() {
            settings.robot = self.robot.clone();
            if self.common.top {
                continue;
            }
            settings.notices = Arc::new(|notice| {
                let _ = writeln!(anstream::stderr(), "         Bus {notice}");
            });
        }
        mission.gateways = gateway::open(&self.http, &mission.named_gateways(), self.told())?;
        let over = match (mission.brokers.are_there(), mission.gateways.are_there()) {
            (true, _) => Some(("a broker", "")),
            (false, true) => Some(("a gateway", ", or say `--http off`")),
            (false, false) => None,
        };
        mission.clock = match (self.clock, self.speed, over) {
            (Some(ClockKind::Virtual), _, Some((what, or))) | (None, Some(_), Some((what, or))) => {
                return Err(format!(
                    "over {what}, time is the wall's: leave out `--clock` and `--speed`{or}"
                ));
            }
            (None, None, Some(_)) => Clock::Wall,
            (None | Some(ClockKind::Virtual), speed, None) => virtual_clock(speed.unwrap_or(0.0))?,
            (Some(ClockKind::Wall), None, _) => Clock::Wall,
            (Some(ClockKind::Wall), Some(_), _) => {
                return Err(
                    "`--speed` is of the virtual clock; on the wall, time has its own speed"
                        .to_owned(),
                );
            }
        };
        mission.until = ends(&self.until)?;
        mission.unless = ends(&self.unless)?;
        Ok(mission)
    }

    /// Says where gateways listen.
    fn told(&self) -> Told {
        let (quiet, as_json) = (self.common.quiet, self.common.json);
        Told::new(move |name, at| {
            let url = format!("http://{at}/services");
            if as_json {
                let object = json!({ "type": "gateway", "v": 1, "name": name, "url": url });
                let _ = writeln!(anstream::stdout(), "{object}");
            }
            if !quiet {
                let _ = writeln!(anstream::stderr(), "   Listening {url} (gateway `{name}`)");
            }
        })
    }

    /// The brokers, if the bus is not that within the process.
    fn brokers(&self, mission: &Mission) -> Result<Brokers, String> {
        let named = |broker: &_| broker::named(broker, &self.access);
        Ok(match self.bus.as_deref() {
            Some("local") => Brokers::Nothing,
            Some(address) => Brokers::One(Box::new(broker::settings(address, &self.access)?)),
            None => match mission.named_brokers()? {
                None => Brokers::Nothing,
                Some(Named::One(broker)) => Brokers::One(Box::new(named(&broker)?)),
                Some(Named::Each(brokers)) => {
                    let settings = |it: &plan::Broker| Ok((it.name.clone(), named(it)?));
                    let each: Result<_, String> = brokers.iter().map(settings).collect();
                    Brokers::Each(each?)
                }
            },
        })
    }
}

/// Virtual time at this speed.
pub fn virtual_clock(speed: f64) -> Result<Clock, String> {
    match speed.is_finite() && speed >= 0.0 {
        true => Ok(Clock::Virtual(speed)),
        false => Err(format!("`--speed {speed}`: a number from 0 is wanted")),
    }
}

/// A property's value as it was written: TOML, and what is none is text.
pub fn property_value(written: &str) -> Datum {
    Value::from_toml(written).map_or_else(|| Datum::text(written), |value| value.datum())
}

/// `location=value`, split; nothing where nothing was written.
fn ends(written: &[String]) -> Result<Option<Vec<(String, String)>>, String> {
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

impl Common {
    /// Applies the options and runs a mission that goes by this title.
    pub fn run(&self, title: &str, mut mission: Mission, terminal: &mut Terminal) -> Exit {
        if let Err(problem) = self.apply(&mut mission) {
            terminal.error(problem);
            return Exit::Usage;
        }
        self.open_to_spectators(&mut mission);
        self.run_applied(title, &mission, terminal)
    }

    /// Runs a mission that has the options already.
    fn run_applied(&self, title: &str, mission: &Mission, terminal: &mut Terminal) -> Exit {
        let clock = match mission.clock {
            Clock::Wall => "wall clock".to_owned(),
            Clock::Virtual(speed) if speed > 0.0 => format!("virtual clock at {speed}×"),
            Clock::Virtual(_) => "virtual clock, as fast as possible".to_owned(),
        };
        if !self.quiet {
            terminal.status(
                "Running",
                format_args!("{title}, {clock}, seed {}", mission.seed),
            );
        }
        let stop = Arc::new(AtomicBool::new(false));
        on_interrupt(&stop);
        let books = Arc::new(Mutex::new(self.books.open()));
        let listener = self.listener(books.clone());
        let ended = match watched::spectator(self.top, mission) {
            Ok(None) => mission.run(listener, &stop),
            Ok(Some(spectator)) => spectator.beside(&stop, || mission.run(listener, &stop)),
            Err(problem) => Err(MissionError::Launch(problem)),
        };
        let ended = match ended {
            Ok(ended) => ended,
            Err(MissionError::Composite {
                sources,
                report,
                outside,
            }) => {
                terminal.report(&report, &sources);
                terminal.error(crate::terminal::count(&report).unwrap_or_default());
                return match outside {
                    true => Exit::Usage,
                    false => Exit::refused(&mission.composite),
                };
            }
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        match lock(&books).close() {
            Ok(silent) => {
                for pattern in silent {
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
            terminal.result(summary_json(&ended));
        } else {
            summarise(&ended, terminal);
        }
        match ended.outcome {
            Outcome::Reached => Exit::Ok,
            // one process of several runs until it is told to end
            Outcome::Stopped if mission.process.is_some() => Exit::Ok,
            Outcome::Failed | Outcome::TimeUp | Outcome::Stopped => Exit::Findings,
            Outcome::Fault => Exit::Fault,
        }
    }

    /// Whoever looks on needs a bus, where there is no broker.
    fn open_to_spectators(&self, mission: &mut Mission) {
        if let (true, Brokers::Nothing) = (self.top, &mission.brokers) {
            mission.brokers = Brokers::Inside(Local::new());
        }
    }

    fn apply(&self, mission: &mut Mission) -> Result<(), String> {
        if let Some(seed) = self.seed {
            mission.seed = seed;
            mission.seeds_composite = true;
        }
        match self.limit {
            None if mission.process.is_some() => mission.limit = None,
            None => {}
            Some(limit) if limit.is_nan() || limit <= 0.0 => {
                return Err(format!("`--for {limit}`: a time above zero is wanted"));
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
                    "`--goal {goal}`: two numbers are wanted, as in `--goal 26.4,4.2`"
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

    /// Who hears the events: the person at the terminal, or a program.
    fn listener(
        &self,
        books: Arc<Mutex<Books>>,
    ) -> impl FnMut(Time, &Event<'_>, Option<&str>) + Send + 'static {
        let (tell, as_json) = (!self.quiet && !self.json && !self.top, self.json);
        move |at, event, line| {
            lock(&books).note(at, event);
            if let (true, Some(line)) = (tell, line) {
                let _ = writeln!(anstream::stderr(), "{line}");
            }
            if let (true, Some(object)) = (as_json, event_json(at, event)) {
                let _ = writeln!(anstream::stdout(), "{object}");
            }
        }
    }
}

/// What a panicking listener left behind is still in the books.
fn lock(books: &Mutex<Books>) -> MutexGuard<'_, Books> {
    books.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The first Ctrl-C ends the run in order, the second at once.
fn on_interrupt(stop: &Arc<AtomicBool>) {
    let stop = stop.clone();
    // without the handler, Ctrl-C ends the process at once, as everywhere
    let _ = ctrlc::set_handler(move || {
        if stop.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        let _ = writeln!(anstream::stderr(), "\n    Stopping (Ctrl-C again to abort)");
    });
}
