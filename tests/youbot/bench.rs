//! A test bench: the driver's composite, a client that carries out a script of calls, and a log of all events.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use asmotion_assembly::{CoordinatorOptions, Standard};
use asmotion_component::{
    CannotFreeze, Component, Cycle, Fault, Flow, FrozenState, In, Interface, NOTICE_REPORT, Out,
    Property, Provided, Required, ThawError, Time,
};
use asmotion_composite::model::BuiltinComponent;
use asmotion_composite::{AsmFiles, Constructor, Context, EmptyEnvironment, Tables};
use asmotion_datum::{Datum, Sample};
use asmotion_lang::MemoryFiles;
use asmotion_messages::{
    Empty, GetJointsPositions, JointCommand, JointPositions, JointStatus, Notify, Period,
    SetJointsPositions, SetPeriod,
};
use asmotion_plan::Opened;
use asmotion_runtime::{Event, Live, Run, Simulation, System};

/// Makes the calls in its script: `"1.0 move 0.5 0.2"` (s, rad), `"2 period 0.05"`, `"3 read"`.
struct Client {
    script: Property<Vec<String>>,
    send: Required<SetJointsPositions>,
    period: Required<SetPeriod>,
    status: Required<GetJointsPositions>,
    notifying: Provided<Notify>,
    done: usize,
}

impl Client {
    fn new(interface: &mut Interface) -> Self {
        let send = interface.require("send", "moves");
        let period = interface.require("period", "sets the period");
        let status = interface.require("status", "reads");
        Self {
            script: interface.property("script", Vec::new(), "what to do, and when"),
            send: interface.optional(send),
            period: interface.optional(period),
            status: interface.optional(status),
            notifying: interface.serve("notifying", "hears"),
            done: 0,
        }
    }

    fn act(&self, deed: &str, numbers: Vec<f64>, cycle: &mut Cycle<'_>) {
        match deed {
            "move" => drop(cycle.call(self.send, JointPositions { position: numbers })),
            "period" => drop(cycle.call(self.period, Period { period: numbers[0] })),
            "read" => drop(cycle.call(self.status, Empty {})),
            other => panic!("nobody can {other}"),
        }
    }
}

impl Component for Client {
    fn freeze(&self) -> Result<FrozenState, CannotFreeze> {
        FrozenState::of("test::Client", 1, &self.done)
    }

    fn thaw(&mut self, state: &FrozenState) -> Result<(), ThawError> {
        self.done = state.read("test::Client", 1)?;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let script = cycle.property(self.script);
        while let Some(line) = script.get(self.done) {
            let mut words = line.split(' ');
            let at: f64 = words.next().unwrap().parse().unwrap();
            if cycle.now().seconds() < at {
                break;
            }
            let deed = words.next().unwrap();
            let numbers = words.map(|word| word.parse().unwrap()).collect();
            self.act(deed, numbers, cycle);
            self.done += 1;
        }
        cycle.requests(self.notifying);
        cycle.replies(self.send);
        cycle.replies(self.period);
        cycle.replies(self.status);
        Ok(())
    }
}

/// An arm of six joints that jumps to each setpoint; its ports have other names than those of the youBot's driver.
struct SixJoints {
    setpoint: In<JointCommand>,
    measured: Out<JointStatus>,
    position: Vec<f64>,
}

impl SixJoints {
    fn new(interface: &mut Interface) -> Self {
        Self {
            setpoint: interface.input("setpoint", "where to go"),
            measured: interface.output("measured", "where it is"),
            position: vec![0.0; 6],
        }
    }
}

impl Component for SixJoints {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Flow::NewData(command) = cycle.read(self.setpoint) {
            self.position = command.position.clone();
        }
        let stamp = asmotion_messages::Time::from_nanos(cycle.now().nanos());
        let position = self.position.clone();
        let count = position.len();
        let status = JointStatus {
            stamp,
            position,
            velocity: vec![0.0; count],
            current: vec![0.0; count],
            temperature: vec![20.0; count],
            error_flags: vec![0; count],
        };
        cycle.write(self.measured, status);
        Ok(())
    }
}

/// The built-in components and the client.
const COMPONENTS: &[(&str, Constructor)] = &[
    made("youbot::DummyDriver", |interface| {
        of_build("youbot::DummyDriver", interface)
    }),
    made("youbot::Kinematics", |interface| {
        of_build("youbot::Kinematics", interface)
    }),
    made("youbot::Operator", |interface| {
        of_build("youbot::Operator", interface)
    }),
    made("test::Client", |interface| Box::new(Client::new(interface))),
    made("test::SixJoints", |interface| {
        Box::new(SixJoints::new(interface))
    }),
];

const fn made(name: &'static str, make: Constructor) -> (&'static str, Constructor) {
    (name, make)
}

fn of_build(name: &str, interface: &mut Interface) -> Box<dyn Component> {
    asmotion_components::component(name).unwrap()(interface)
}

const BUILD: Tables = Tables {
    components: COMPONENTS,
    messages: asmotion_components::MESSAGES,
    interfaces: asmotion_components::INTERFACES,
    builtins: &[BuiltinComponent::PortProxy],
    ros: None,
};

/// The client with the driver's composite nested in it. `driver` is appended to its properties, `wire` to the wire of
/// its commands.
/// The time limit of commands whose end is awaited.
pub const TIMEOUT: &str = ", timeout_ms = 20000";

const APPLICATION: &str = r#"
schema = "composite/1"
wires = [
  { reference = "Client.send", service = "Driver.sendingCommand"WIRE },
  { reference = "Client.period", service = "Driver.settingPeriod", timeout_ms = 1000 },
  { reference = "Client.status", service = "Driver.retrievingStatus", timeout_ms = 1000 },
  { reference = "Driver.notifying", service = "Client.notifying", oneway = true },
]
[composite]
name = "bench"
[components.Driver]
implementation = { composite = "driver.composite.toml" }
properties = { DRIVER }
[components.Client]
implementation = { rust = "test::Client" }
activity = { period_ms = 10 }
references = { send = "youbot/SendingCommands", period = "youbot/SettingPeriod", status = "youbot/RetrievingStatus" }
properties = { script = SCRIPT }
"#;

/// The configuration of the bench.
pub(super) struct Bench {
    /// Text of the composite around the driver's.
    pub application: String,
    /// Text of the driver's composite.
    pub driver: String,
    /// Text of the driver's composite if `driver` is another one around it.
    pub inner: Option<String>,
    /// Properties of the driver's composite, for example `joints = 6`.
    pub properties: &'static str,
    /// Settings of the wire for commands: [`TIMEOUT`], or `, oneway = true`.
    pub wire: &'static str,
    pub script: &'static [&'static str],
}

impl Default for Bench {
    fn default() -> Self {
        Self {
            application: APPLICATION.to_owned(),
            driver: include_str!("../../specs/youbot/youbot_driver.composite.toml").to_owned(),
            inner: None,
            properties: "",
            wire: TIMEOUT,
            script: &[],
        }
    }
}

/// The events of a run.
#[derive(Default)]
pub(super) struct Log {
    /// Every status published by the driver, with its time.
    pub statuses: Vec<(Time, JointStatus)>,
    /// Every notice sent by the proxy, with its time.
    pub notices: Vec<(Time, String)>,
    /// Every note of the locomotor, with its time.
    pub notes: Vec<(Time, String)>,
    /// The outcome of every call: operation, time, result.
    pub replies: Vec<(String, Time, Result<Datum, String>)>,
    /// Every notice for the person who runs the system: component and text.
    pub told: Vec<(String, String)>,
    /// The details of the proxy's `fault` notices.
    pub faults: Vec<String>,
    /// Number of each component's current cycle.
    cycles: BTreeMap<String, u64>,
    /// Cycles of the driver in which the client called, and in which the driver first read the command.
    pub called_in: Vec<u64>,
    pub turned_in: Vec<u64>,
}

impl Log {
    fn note(&mut self, at: Time, event: &Event<'_>) {
        match event {
            Event::Cycle { component, number } => {
                self.cycles.insert((*component).to_owned(), *number);
            }
            Event::Published {
                component: "Driver/youBotDriver",
                sample,
                ..
            } => {
                let status: JointStatus = datum_of(*sample).to().unwrap();
                let before = self.statuses.last().map(|(_, status)| &status.position);
                if before.is_some_and(|before| *before != status.position) {
                    self.turned_in.push(self.cycle_of_driver());
                }
                self.statuses.push((at, status));
            }
            Event::Published {
                component: "Locomotor",
                sample,
                ..
            } => {
                let note = datum_of(*sample);
                let note = note.get("data").unwrap();
                self.notes.push((at, note.as_text().unwrap().to_owned()));
            }
            Event::Called {
                component,
                operation,
                argument,
                ..
            } => match *operation {
                "notify" => {
                    let notice = datum_of(*argument);
                    let event = notice.get("event").unwrap();
                    let event = event.as_text().unwrap().to_owned();
                    if event == "fault" {
                        let detail = notice.get("detail").unwrap();
                        self.faults.push(detail.as_text().unwrap().to_owned());
                    }
                    self.notices.push((at, event));
                }
                _ if *component == "Client" => {
                    self.called_in.push(self.cycle_of_driver());
                }
                _ => {}
            },
            Event::Replied {
                operation, result, ..
            } => {
                let result = match result {
                    Ok(sample) => Ok(datum_of(*sample)),
                    Err(error) => Err(error.to_string()),
                };
                self.replies.push(((*operation).to_owned(), at, result));
            }
            Event::Report {
                component,
                kind,
                data,
            } if *kind == NOTICE_REPORT => {
                let text = data.as_text().unwrap_or_default().to_owned();
                self.told.push(((*component).to_owned(), text));
            }
            Event::Published { .. }
            | Event::Injected { .. }
            | Event::Answered { .. }
            | Event::LifeCycle { .. }
            | Event::Fault { .. }
            | Event::Overrun { .. }
            | Event::Late { .. }
            | Event::Denied { .. }
            | Event::Dropped { .. }
            | Event::Property { .. }
            | Event::Report { .. }
            | Event::Lost { .. } => {}
        }
    }

    /// Number of the driver's current cycle; 0 before the first.
    fn cycle_of_driver(&self) -> u64 {
        let known = self.cycles.get("Driver/youBotDriver");
        known.copied().unwrap_or_default()
    }

    /// Time of the first notice of an event.
    pub(super) fn first(&self, event: &str) -> Option<Time> {
        let mut notices = self.notices.iter();
        notices.find(|(_, told)| told == event).map(|(at, _)| *at)
    }

    /// The events in order, without `refresh`.
    pub(super) fn events(&self) -> Vec<&str> {
        let events = self.notices.iter().map(|(_, event)| event.as_str());
        events.filter(|event| *event != "refresh").collect()
    }
}

fn datum_of(sample: &dyn Sample) -> Datum {
    sample.to_datum().unwrap()
}

/// The protocol of the driver, to which its composite refers.
const DRIVER_PROTOCOL: (&str, &str) = (
    "driver_protocol.asm",
    include_str!("../../specs/youbot/driver_protocol.asm"),
);

/// The composite in `specs` with these goals, in virtual time.
pub(super) fn shipped(goals: &[[f64; 5]]) -> (Simulation, Arc<Mutex<Log>>) {
    let application = include_str!("../../specs/youbot/youbot.composite.toml");
    let begin = application.find("goals = ").unwrap();
    let end = begin + application[begin..].find(" }").unwrap();
    let mut files = MemoryFiles::new();
    let goals = format!(
        "{}goals = {goals:?}{}",
        &application[..begin],
        &application[end..]
    );
    files.add("bench.composite.toml", goals);
    files.add("youbot.asm", include_str!("../../specs/youbot/youbot.asm"));
    let driver = include_str!("../../specs/youbot/youbot_driver.composite.toml");
    files.add("youbot_driver.composite.toml", driver);
    files.add(DRIVER_PROTOCOL.0, DRIVER_PROTOCOL.1);
    simulate(&open(&files), &files)
}

fn open(files: &MemoryFiles) -> Opened {
    let context = Context {
        loader: files,
        environment: &EmptyEnvironment,
        catalogue: &BUILD,
        specifications: &AsmFiles::new(files),
        programs: &asmotion_composite::NoPrograms,
        settings: &[],
    };
    asmotion_plan::open("bench.composite.toml", &context)
}

fn simulate(opened: &Opened, files: &MemoryFiles) -> (Simulation, Arc<Mutex<Log>>) {
    let (system, log) = start(opened, files);
    (system.simulate(), log)
}

fn start(opened: &Opened, files: &MemoryFiles) -> (System, Arc<Mutex<Log>>) {
    let found = opened
        .report
        .diagnostics
        .iter()
        // the locomotor's reachability property is not watched
        .filter(|it| it.code.name != "C201")
        .map(|it| (it.code, &it.message));
    assert_eq!(found.collect::<Vec<_>>(), [], "nothing is found");
    let plan = opened.plan(None).unwrap();
    let mut workshop = Standard::new(&BUILD, files, CoordinatorOptions::seeded(1));
    let mut system = asmotion_assembly::start(plan, &mut workshop).unwrap();
    let log = Arc::new(Mutex::new(Log::default()));
    let listener = log.clone();
    system.observe(move |at: Time, event: &Event<'_>| listener.lock().unwrap().note(at, event));
    (system, log)
}

impl Bench {
    fn files(&self) -> MemoryFiles {
        let script = format!("{:?}", self.script);
        let application = self.application.replace("WIRE", self.wire);
        let application = application.replace("DRIVER", self.properties);
        let mut files = MemoryFiles::new();
        files.add(
            "bench.composite.toml",
            application.replace("SCRIPT", &script),
        );
        files.add("driver.composite.toml", self.driver.as_str());
        files.add(DRIVER_PROTOCOL.0, DRIVER_PROTOCOL.1);
        if let Some(inner) = &self.inner {
            files.add("inner.composite.toml", inner.as_str());
        }
        files
    }

    /// The codes found by the checker.
    pub(super) fn findings(&self) -> Vec<&'static str> {
        let opened = open(&self.files());
        opened
            .report
            .diagnostics
            .iter()
            .map(|it| it.code.name)
            .collect()
    }

    /// The composite with everything that it leaves to discovery.
    pub(super) fn expanded(&self) -> String {
        let opened = open(&self.files());
        asmotion_plan::expand(&opened, opened.plan(None).unwrap())
    }

    /// Starts everything in virtual time, with a log.
    pub(super) fn simulate(&self) -> (Simulation, Arc<Mutex<Log>>) {
        let files = self.files();
        simulate(&open(&files), &files)
    }

    /// Starts everything on the wall clock.
    pub(super) fn live(&self) -> Live {
        let files = self.files();
        start(&open(&files), &files).0.live()
    }

    /// The log of a run of that many seconds.
    pub(super) fn run(&self, seconds: u64) -> Log {
        let (mut simulation, log) = self.simulate();
        simulation.run_for(Duration::from_secs(seconds));
        drop(simulation);
        Arc::into_inner(log).unwrap().into_inner().unwrap()
    }
}
