//! A composite put together, and its run until something ends it.

mod error;
mod gateway;
mod process;
mod successor;
mod watch;

pub use self::gateway::{Gateways, Told};
pub use error::MissionError;
pub use process::{Brokers, Named};
pub use successor::{Version, reconfigure_address};

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use asmotion_assembly::plan::Terminal;
use asmotion_assembly::{Opened, Plan, Standard};
use asmotion_component::{Event, Observer, Pace, Run, Time};
use asmotion_datum::Datum;
use asmotion_lang::Loader;
use asmotion_lang::diagnostics::similar;
use asmotion_remote::Contact;

use crate::build;
use crate::files::Disk;
use crate::story::{Story, Summary};
use successor::Successor;
use watch::{Watch, awaited};

/// What is run, and how.
#[derive(Clone, Debug)]
pub struct Mission {
    /// The file of the composite.
    pub composite: String,
    /// One of its profiles.
    pub profile: Option<String>,
    /// Its properties, set from outside.
    pub settings: Vec<(String, String)>,
    /// Properties of its components, set from outside: component, property, value.
    pub properties: Vec<(String, String, Datum)>,
    /// Decides what specifications leave to choice.
    pub seed: u64,
    /// Whether it is the composite's property `seed`, too, if it has one.
    pub seeds_composite: bool,
    /// Which time it runs in.
    pub clock: Clock,
    /// What topics and wires go over.
    pub brokers: Brokers,
    /// Whether what it serves is called over HTTP.
    pub gateways: Gateways,
    /// Of the processes that the composite is deployed to, the one that is run; all of it where absent.
    pub process: Option<String>,
    /// It ends well when a location gets one of these values: location, value. Where absent, with
    /// `mode = ARRIVED`, if there is such a location.
    pub until: Option<Vec<(String, String)>>,
    /// It ends badly when a location gets one of these values; where absent, with `mode = FAILED`.
    pub unless: Option<Vec<(String, String)>>,
    /// It ends, undecided, after this long; for ever where absent.
    pub limit: Option<Duration>,
}

/// Which time a mission runs in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clock {
    /// One thread, time as fast as wanted: so many seconds of the run in one of the wall; as many as
    /// possible where 0.
    Virtual(f64),
    /// A thread for each component, time as it passes.
    Wall,
}

/// How a mission ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// A location got a value that it was to run until.
    Reached,
    /// A location got a value that means failure.
    Failed,
    /// The time was up.
    TimeUp,
    /// A component failed and cannot go on.
    Fault,
    /// Somebody stopped it.
    Stopped,
}

/// What is left of a mission.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// How it ended.
    pub outcome: Outcome,
    /// What happened in it.
    pub summary: Summary,
    /// How long it took, in its own time.
    pub time: Duration,
    /// How long it took on the wall.
    pub wall: Duration,
}

/// How often the run looks up to see whether it shall stop, in its own time.
const SLICE: Duration = Duration::from_millis(100);

/// After its end the robot has this long to come to rest.
const REST: Duration = Duration::from_secs(1);

impl Mission {
    /// A mission in virtual time, as fast as possible, that ends with `mode` ARRIVED or FAILED, or
    /// after ten minutes.
    pub fn new(composite: impl Into<String>) -> Self {
        Self {
            composite: composite.into(),
            profile: None,
            settings: Vec::new(),
            properties: Vec::new(),
            seed: 1,
            seeds_composite: false,
            clock: Clock::Virtual(0.0),
            brokers: Brokers::Nothing,
            gateways: Gateways::Closed,
            process: None,
            until: None,
            unless: None,
            limit: Some(Duration::from_secs(600)),
        }
    }

    /// Runs it. `hear` is told every event, and the line of the story where it has one; `stop` ends
    /// the run early.
    ///
    /// # Errors
    /// The composite has errors, or cannot be put together in this build.
    pub fn run(
        &self,
        mut hear: impl FnMut(Time, &Event<'_>, Option<&str>) + Send + 'static,
        stop: &AtomicBool,
    ) -> Result<Ended, MissionError> {
        let opened = self.open(&self.composite, &Disk);
        if opened.report.has_errors() {
            return Err(MissionError::Composite {
                sources: opened.sources,
                report: opened.report,
                outside: opened.outside,
            });
        }
        let Some(plan) = opened.plan(self.profile.as_deref()) else {
            let (wanted, known) = (self.profile.clone(), opened.profiles);
            return Err(MissionError::Profile { wanted, known });
        };
        self.in_the_time_of_queues(plan)?;
        let watch = Watch {
            until: awaited(plan, self.until.as_deref(), "ARRIVED")?,
            unless: awaited(plan, self.unless.as_deref(), "FAILED")?,
            outcome: None,
        };
        let mut workshop = Standard {
            catalogue: &build::BUILD,
            loader: &Disk,
            seed: self.seed,
            builtins: &mut |_, _| None,
        };
        let part = self.part(plan)?;
        let mut system = asmotion_assembly::start_part(plan, &part, &mut workshop)
            .map_err(|error| MissionError::Launch(error.to_string()))?;
        for (component, property, value) in &self.properties {
            if plan.component(component).is_none() {
                let known = plan.components.iter().map(|known| &known.name);
                return Err(MissionError::Component {
                    name: component.clone(),
                    similar: similar(component, known).cloned(),
                });
            }
            // one of another process is set there
            let Some(id) = system.id(component) else {
                continue;
            };
            let set = system.set_property(id, property, value);
            set.map_err(|error| MissionError::Launch(error.to_string()))?;
        }
        let story = Arc::new(Mutex::new(Story::of(plan)));
        let watch = Arc::new(Mutex::new(watch));
        let (listener, watcher) = (story.clone(), watch.clone());
        system.observe(move |at: Time, event: &Event<'_>| {
            let line = lock(&listener).tell(at, event);
            hear(at, event, line.as_deref());
            lock(&watcher).observe(at, event);
        });
        let connected = self.connect(plan)?;
        let mut contacts = self.join(&mut system, &connected, plan, &part)?;
        let mut successor = self.successor(&opened, plan, &part, &connected)?;
        let gateways = self.open_gateways(&mut system, &opened, plan, &part)?;
        let began = Instant::now();
        let mut run: Box<dyn Run> = match self.clock {
            Clock::Wall => Box::new(system.live()),
            Clock::Virtual(speed) => {
                let mut simulation = system.simulate();
                simulation.set_pace(if speed > 0.0 {
                    Pace::Factor(speed)
                } else {
                    Pace::Unlimited
                });
                Box::new(simulation)
            }
        };
        let outcome = self.drive(&mut *run, &watch, stop, &mut contacts, &mut successor);
        let time = run.now().since(Time::ZERO);
        let summary = lock(&story).summary().clone();
        if outcome == Outcome::Reached || outcome == Outcome::Failed {
            run.run_for(REST);
        }
        // who still calls is answered before those stop who answer
        drop(gateways);
        run.stop();
        // what the components said last is sent before the bus closes
        contacts.iter_mut().for_each(Contact::leave);
        drop((run, contacts, successor));
        drop(connected);
        Ok(Ended {
            outcome,
            summary,
            time,
            wall: began.elapsed(),
        })
    }

    /// Whoever is beyond a message queue lives in the time of the wall.
    fn in_the_time_of_queues(&self, plan: &Plan) -> Result<(), MissionError> {
        let mut ends = plan.connections.iter().flat_map(|it| [&it.from, &it.to]);
        match (
            self.clock,
            ends.find(|it| matches!(it, Terminal::Mqueue(_))),
        ) {
            (Clock::Virtual(_), Some(queue)) => Err(MissionError::Launch(format!(
                "`{queue}` leads to another process, whose time is the wall's: say `--clock wall`"
            ))),
            (Clock::Virtual(_), None) | (Clock::Wall, _) => Ok(()),
        }
    }

    /// A version of the composite, with what was set from outside.
    fn open(&self, composite: &str, files: &dyn Loader) -> Opened {
        let opened = build::open(composite, &self.settings, files);
        let properties = opened.composite.iter().flat_map(|it| &it.properties);
        let has_seed = properties
            .map(|it| &*it.name.value)
            .any(|name| name == "seed");
        if !(self.seeds_composite && has_seed) {
            return opened;
        }
        let mut settings = self.settings.clone();
        settings.push(("seed".to_owned(), self.seed.to_string()));
        build::open(composite, &settings, files)
    }

    fn drive(
        &self,
        run: &mut dyn Run,
        watch: &Mutex<Watch>,
        stop: &AtomicBool,
        contacts: &mut [Contact<'_>],
        successor: &mut Successor<'_>,
    ) -> Outcome {
        let limit = self.limit.map(|limit| Time::ZERO + limit);
        loop {
            if let Some(outcome) = lock(watch).outcome {
                return outcome;
            }
            if stop.load(Ordering::Relaxed) {
                return Outcome::Stopped;
            }
            for contact in &mut *contacts {
                contact.attend(run);
            }
            successor.attend(run);
            let mut until = run.now() + SLICE;
            if let Some(limit) = limit {
                if run.now() >= limit {
                    return Outcome::TimeUp;
                }
                until = until.min(limit);
            }
            run.run_until_event(until, &mut |_, event| {
                matches!(event, Event::Report { .. } | Event::Fault { .. })
            });
        }
    }
}

/// What a panicking listener left behind is still a story.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
