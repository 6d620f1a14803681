//! Components in programs, which are written in Python with its standard library alone.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests"
)]

mod cpp;

use std::path::Path;
use std::time::Duration;

use asmotion_component::declaration::OperationDeclaration;
use asmotion_component::{
    Activity, Component, Cycle, Dynamic, Fault, Freeze, In, Interface, OnException, Out, Policy,
    Provided, Required, ServiceFault, State, Wire, freeze_by_fields,
};
use asmotion_datum::{Datum, OutlineKey, Schema, Shape};
use asmotion_program::{ProgramCommand, ProgramComponent, ProgramDeclaration, ProgramError, ask};
use asmotion_runtime::{Log, Run, System};

/// The command of a test program.
fn command(words: &[&str]) -> ProgramCommand {
    let is_example = words
        .first()
        .is_some_and(|word| word.contains("gripper.py"));
    let directory = if is_example {
        "../../examples/gripper"
    } else {
        "tests/programs"
    };
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join(directory);
    let words = ["python3"].iter().chain(words);
    ProgramCommand {
        words: words.map(|word| (*word).to_owned()).collect(),
        directory,
        start_timeout: Duration::from_secs(10),
        timeout: Duration::from_millis(1500),
    }
}

fn declaration(command: &ProgramCommand) -> Result<ProgramDeclaration, ProgramError> {
    ask(command, "Gripper")?.complete(&|_| None)
}

/// Adds a program to a system.
fn add(system: &mut System, name: &str, command: &ProgramCommand, activity: Activity) {
    let declaration = declaration(command).expect("a declaration");
    let make = |interface: &mut Interface| {
        let component = ProgramComponent::new(command.clone(), declaration, interface);
        Box::new(component) as Box<dyn Component>
    };
    system.add(name, activity, make).expect("a component");
}

fn float(name: &'static str, fields: &[&'static str]) -> Schema {
    let field = |name: &&'static str| OutlineKey::new(*name, "", Schema::plain(Shape::F64));
    Schema::record(name, fields.iter().map(field).collect())
}

/// Commands an opening in its first cycle, and closes the gripper in its fifth.
#[derive(Freeze)]
#[freeze(component = "test::Operator", version = 1)]
struct Operator {
    #[freeze(skip)]
    command: Out<Datum>,
    #[freeze(skip)]
    grip: Required<Dynamic>,
    #[freeze(skip)]
    state: In<Datum>,
    closed: Vec<String>,
}

impl Operator {
    fn new(interface: &mut Interface) -> Self {
        let close = OperationDeclaration {
            name: "close".to_owned(),
            request: float("acme/Close", &["force"]),
            response: float("acme/Closed", &["width"]),
            while_stopped: false,
        };
        let command = float("acme/GripperCommand", &["opening"]);
        Self {
            command: interface.output_of("command", command, ""),
            grip: interface.require_declared("grip", "acme/Grip", close, ""),
            state: interface.input_of("state", Schema::opaque("acme/GripperState"), ""),
            closed: Vec::new(),
        }
    }
}

impl Component for Operator {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        match cycle.number() {
            1 => cycle.write(self.command, Datum::record([("opening", Datum::Int(1))])),
            5 => {
                cycle.call(self.grip, Datum::record([("force", Datum::Float(2.5))]));
            }
            _ => {}
        }
        for reply in cycle.replies(self.grip) {
            let text = reply
                .result
                .map_or_else(|error| error.to_string(), |it| it.to_string());
            cycle.report("closed", Datum::text(&text));
            self.closed.push(text);
        }
        let _ = cycle.read(self.state);
        Ok(())
    }
}

/// Grants permission.
#[derive(Freeze)]
#[freeze(component = "test::Guard", version = 1)]
struct Guard {
    #[freeze(skip)]
    ask: Provided<Dynamic>,
    refuses: bool,
}

impl Component for Guard {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for request in cycle.requests(self.ask) {
            let result = if self.refuses {
                Err(ServiceFault::new("BUSY", "later"))
            } else {
                Ok(Datum::record([("granted", Datum::Bool(true))]))
            };
            cycle.reply(self.ask, request.id, result);
        }
        Ok(())
    }
}

fn guard(refuses: bool) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    move |interface| {
        let granted = OutlineKey::new("granted", "", Schema::plain(Shape::Bool));
        let operation = OperationDeclaration {
            name: "ask".to_owned(),
            request: float("acme/Close", &["force"]),
            response: Schema::record("acme/Permission", vec![granted]),
            while_stopped: false,
        };
        let ask = interface.serve_declared("ask", "acme/Guard", operation, "");
        Box::new(Guard { ask, refuses })
    }
}

fn every(milliseconds: u64) -> Activity {
    Activity::periodic(Duration::from_millis(milliseconds))
}

/// A gripper that an operator commands, and that asks a guard.
fn gripper(refuses: bool) -> System {
    operated(&command(&["gripper.py"]), refuses)
}

/// The command of a program that uses the package `asmotion`.
fn with_package(arguments: &[&str]) -> ProgramCommand {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../python");
    let package = format!("PYTHONPATH={}", package.display());
    let words = ["env", &package, "PYTHONDONTWRITEBYTECODE=1", "python3"];
    let words = words.iter().chain(arguments);
    ProgramCommand {
        words: words.map(|word| (*word).to_owned()).collect(),
        timeout: Duration::from_secs(5),
        ..command(&[])
    }
}

/// The gripper in Python with the package `asmotion`.
fn packaged(arguments: &[&str], refuses: bool) -> System {
    let arguments = [&["packaged.py"], arguments].concat();
    operated(&with_package(&arguments), refuses)
}

fn operated(gripper: &ProgramCommand, refuses: bool) -> System {
    let mut system = System::new();
    add(&mut system, "Gripper", gripper, every(100));
    let operator =
        |interface: &mut Interface| Box::new(Operator::new(interface)) as Box<dyn Component>;
    system.add("Operator", every(100), operator).unwrap();
    system
        .add("Guard", Activity::event(), guard(refuses))
        .unwrap();
    let data = Policy::data();
    system
        .connect("Operator.command", "Gripper.command", data.clone())
        .unwrap();
    system
        .connect("Gripper.state", "Operator.state", data)
        .unwrap();
    system
        .wire("Operator.grip", "Gripper.grip", Wire::default())
        .unwrap();
    system
        .wire("Gripper.guard", "Guard.ask", Wire::default())
        .unwrap();
    system
}

/// The events of a run in virtual time.
fn trace(mut system: System, time: Duration) -> String {
    let log = Log::new();
    system.observe(log.clone());
    let mut simulation = system.simulate();
    simulation.run_for(time);
    simulation.stop();
    drop(simulation);
    log.lines().join("\n")
}

#[test]
fn a_program_is_a_component_like_any_other() {
    insta::assert_snapshot!(trace(gripper(false), Duration::from_millis(900)));
}

#[test]
fn two_runs_in_virtual_time_are_equal() {
    let run = || trace(gripper(false), Duration::from_secs(2));
    let first = run();
    assert!(first.lines().count() > 60);
    assert_eq!(first, run());
}

#[test]
fn the_python_package_behaves_as_a_program_written_from_the_page() {
    for refuses in [false, true] {
        let time = Duration::from_millis(1900);
        let expected = trace(gripper(refuses), time);
        assert_eq!(trace(packaged(&[], refuses), time), expected);
        assert_eq!(trace(packaged(&["waiting"], refuses), time), expected);
    }
}

#[test]
fn a_component_of_the_python_package_continues_in_another_process() {
    let log = Log::new();
    let mut first = packaged(&[], false);
    first.observe(log.clone());
    let mut first = first.simulate();
    // a call is under way, and a reply is due
    first.run_for(Duration::from_millis(550));
    let frozen = first.freeze().expect("a frozen state");
    let before = log.lines().len();
    first.run_for(Duration::from_millis(900));
    let other = Log::new();
    let mut second = packaged(&[], false);
    second.observe(other.clone());
    let mut second = second.simulate();
    second.thaw(&frozen).expect("a thawed system");
    let thawed = other.lines().len();
    second.run_for(Duration::from_millis(900));
    assert_eq!(log.lines()[before..], other.lines()[thawed..]);
    let mut coroutine = packaged(&["waiting"], false).simulate();
    coroutine.run_for(Duration::from_millis(550));
    let refused = coroutine
        .freeze()
        .expect_err("a coroutine is under way")
        .to_string();
    assert!(refused.contains("a coroutine is under way"), "{refused}");
}

#[test]
fn a_fault_of_a_service_that_it_calls_reaches_the_program() {
    let trace = trace(gripper(true), Duration::from_millis(900));
    let ends: Vec<&str> = trace
        .lines()
        .filter(|line| line.contains("NO_GUARD"))
        .collect();
    assert_eq!(ends.len(), 3, "{trace}");
}

#[test]
fn it_is_inspected_stopped_and_serves_while_stopped() {
    let mut run = gripper(false).simulate();
    run.run_for(Duration::from_millis(500));
    let described = run.inspect("Gripper").unwrap();
    assert_eq!(described[1], ("target".to_owned(), Datum::Float(1.0)));
    let values = [("speed".to_owned(), Datum::Float(0.9))];
    let refused = run
        .set_properties("Gripper", &values)
        .unwrap_err()
        .to_string();
    insta::assert_snapshot!(refused, @"property `speed` of `Gripper` must be between 0.01 and 0.5 m/s, not 0.9");
    let values = [("mode".to_owned(), Datum::text("wild"))];
    let refused = run
        .set_properties("Gripper", &values)
        .unwrap_err()
        .to_string();
    insta::assert_snapshot!(refused, @r#"property `mode` of `Gripper` must be one of "soft", "hard", not "wild""#);
    let values = [("speed".to_owned(), Datum::Float(0.5))];
    run.set_properties("Gripper", &values).unwrap();
    run.run_for(Duration::from_millis(300));
    let described = run.inspect("Gripper").unwrap();
    // with the former speed, it would not be closed yet
    insta::assert_snapshot!(described[0].1, @"0.0");
}

#[test]
fn a_frozen_program_continues_in_another_process() {
    let log = Log::new();
    let mut first = gripper(false);
    first.observe(log.clone());
    let mut first = first.simulate();
    first.run_for(Duration::from_millis(450));
    let frozen = first.freeze().expect("a frozen state");
    let before = log.lines().len();
    first.run_for(Duration::from_millis(500));
    let other = Log::new();
    let mut second = gripper(false);
    second.observe(other.clone());
    let mut second = second.simulate();
    second.thaw(&frozen).expect("a thawed system");
    let thawed = other.lines().len();
    second.run_for(Duration::from_millis(500));
    assert_eq!(log.lines()[before..], other.lines()[thawed..]);
}

/// Asks a bad program for its declaration.
fn refusal(how: &str) -> String {
    let mut command = command(&["bad.py", how]);
    command.start_timeout = Duration::from_millis(2500);
    let error = declaration(&command).expect_err("no declaration");
    error.to_string()
}

#[test]
fn a_program_that_cannot_be_asked_says_why() {
    let mut text = String::new();
    for how in [
        "exits",
        "never-connects",
        "never-speaks",
        "garbage",
        "not-cbor",
        "version",
        "shape",
        "duplicate",
        "array",
        "default",
    ] {
        text += &format!("{how}: {}\n", refusal(how));
    }
    for words in [&["no-such-program"][..], &["./bad.py"], &[]] {
        let command = ProgramCommand {
            words: words.iter().map(|word| (*word).to_owned()).collect(),
            ..command(&[])
        };
        let error = declaration(&command).expect_err("no declaration");
        text += &format!("{words:?}: {error}\n");
    }
    insta::assert_snapshot!(text);
}

/// Runs a bad program beside another one, which is reset once if it fails.
fn failure(how: &str) -> String {
    let mut system = System::new();
    let activity = every(100)
        .on_exception(OnException::Reset)
        .max_resets(Some(1));
    add(&mut system, "Bad", &command(&["bad.py", how]), activity);
    add(&mut system, "Good", &command(&["gripper.py"]), every(100));
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.simulate();
    run.run_for(Duration::from_millis(650));
    assert_eq!(run.state("Good"), Some(State::Running), "{how}");
    let lines = log.lines().into_iter();
    let lines = lines.filter(|line| line.contains("Bad") && !line.contains("Bad: cycle"));
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_failing_program_is_reported_isolated_and_reset() {
    let all = [
        "dies", "killed", "late", "hangs", "huge", "type", "port", "field", "reply", "faults",
    ];
    let failures = std::thread::scope(|scope| {
        let failures = all.map(|how| scope.spawn(move || format!("{how}\n{}\n", failure(how))));
        failures.map(|it| it.join().unwrap())
    });
    let text = failures.join("\n");
    insta::assert_snapshot!(text);
}

#[test]
fn endless_output_is_cut() {
    let mut system = System::new();
    let mut command = command(&["bad.py", "prints"]);
    // on a loaded machine
    command.timeout = Duration::from_secs(30);
    add(&mut system, "Bad", &command, every(100));
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.simulate();
    run.run_for(Duration::from_millis(450));
    assert_eq!(run.state("Bad"), Some(State::Running));
    let lines = log.lines_with("log");
    assert_eq!(lines.len(), 101);
    insta::assert_snapshot!(lines[100], @r#"0.2 s Bad: log: "… 99900 more lines""#);
}

#[test]
fn a_program_that_declares_something_else_at_the_start_is_not_started() {
    let command = command(&["fickle.py"]);
    let declaration = declaration(&command).expect("a declaration");
    let mut system = System::new();
    let make = |interface: &mut Interface| {
        let component = ProgramComponent::new(command.clone(), declaration, interface);
        Box::new(component) as Box<dyn Component>
    };
    system.add("Gripper", every(100), make).unwrap();
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.simulate();
    run.run_for(Duration::from_millis(100));
    assert_eq!(run.state("Gripper"), Some(State::PreOperational));
    insta::assert_snapshot!(log.lines_with("PROTOCOL").join("\n"));
}

/// A system with one program in real time.
fn live(words: &[&str], activity: Activity) -> (impl Run, Log) {
    let mut system = System::new();
    add(&mut system, "Device", &command(words), activity);
    let log = Log::new();
    system.observe(log.clone());
    (system.live(), log)
}

#[test]
fn a_program_requests_cycles_by_itself() {
    let (mut run, log) = live(&["waking.py"], Activity::event());
    run.run_for(Duration::from_millis(900));
    let cycles = log.lines_with("Device: cycle").len();
    assert!((5..=30).contains(&cycles), "{cycles} cycles");
    assert!(!log.lines_with("woken by").is_empty());
}

#[test]
fn a_program_that_ends_between_two_cycles_fails_at_once() {
    let (mut run, log) = live(&["waking.py", "dies"], Activity::event());
    run.run_for(Duration::from_millis(1500));
    assert_eq!(run.state("Device"), Some(State::Exception));
    let faults = log.lines_with("PROGRAM_ENDED");
    assert!(
        faults[0].ends_with("(exit status: 3); its last output: the device is gone"),
        "{faults:?}"
    );
}

#[test]
fn a_program_that_stays_after_exit_is_ended() {
    let (mut run, log) = live(&["bad.py", "stays"], every(50));
    run.run_for(Duration::from_millis(300));
    run.stop();
    drop(run);
    assert!(log.lines_with("fault").is_empty(), "{:?}", log.lines());
}

/// A system with one event-driven program, and its log.
fn timed(command: &ProgramCommand) -> (System, Log) {
    let mut system = System::new();
    add(&mut system, "Device", command, Activity::event());
    let log = Log::new();
    system.observe(log.clone());
    (system, log)
}

/// The times of the reports of this kind (ms).
fn reported(log: &Log, kind: &str) -> Vec<u64> {
    let lines = log.lines_with(&format!(": {kind}: ")).into_iter();
    let nanos = lines.map(|line| line.rsplit(' ').next().unwrap_or_default().to_owned());
    nanos
        .map(|it| it.parse::<u64>().unwrap() / 1_000_000)
        .collect()
}

#[test]
fn a_program_requests_a_cycle_at_a_time() {
    let (system, log) = timed(&command(&["timed.py", "ticks"]));
    system.simulate().run_for(Duration::from_millis(500));
    let times: Vec<u64> = (0..8).map(|tick| tick * 70).collect();
    assert_eq!(reported(&log, "now"), times);
}

#[test]
fn hostile_times_of_cycles_harm_only_the_program() {
    let mut ends = String::new();
    for how in ["far", "before", "beyond", "text", "fraction"] {
        let (mut system, log) = timed(&command(&["timed.py", how]));
        let counter = |_: &mut Interface| Box::new(Idle) as Box<dyn Component>;
        system.add("Other", every(100), counter).unwrap();
        let mut run = system.simulate();
        run.run_for(Duration::from_secs(2));
        let cycles = run.cycles("Device");
        let state = run.state("Device").unwrap();
        assert_eq!(run.cycles("Other"), 21, "{how}");
        let faults = log.lines_with("fault");
        ends += &format!("{how}: {cycles} cycles, {state:?} {faults:?}\n");
    }
    insta::assert_snapshot!(ends);
}

#[test]
fn hostile_times_of_cycles_delay_no_component_in_real_time() {
    for (how, is_busy) in [("far", false), ("before", true)] {
        let (mut system, _) = timed(&command(&["timed.py", how]));
        let idle = |_: &mut Interface| Box::new(Idle) as Box<dyn Component>;
        system.add("Other", every(50), idle).unwrap();
        let mut run = system.live();
        run.run_for(Duration::from_millis(600));
        assert_eq!(run.state("Device"), Some(State::Running), "{how}");
        let cycles = run.cycles("Device");
        assert_eq!(cycles > 20, is_busy, "{how}: {cycles} cycles");
        let others = run.cycles("Other");
        assert!(others >= 6, "{how}: {others} cycles");
        run.stop();
    }
}

struct Idle;

impl Component for Idle {
    fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
        Ok(())
    }
}

#[test]
fn a_coroutine_wakes_at_the_time_of_its_sleep() {
    let command = with_package(&["sleeping.py"]);
    let (system, log) = timed(&command);
    system.simulate().run_for(Duration::from_secs(1));
    assert_eq!(reported(&log, "awake"), [200, 230, 400]);
    let (system, log) = timed(&command);
    let mut run = system.live();
    run.run_for(Duration::from_millis(800));
    run.stop();
    let times = reported(&log, "awake");
    let [first, second, third] = times[..] else {
        panic!("{times:?}: {:?}", log.lines());
    };
    let begun = log.lines_with("Device: cycle 1")[0]
        .split(' ')
        .next()
        .and_then(|it| it.parse::<f64>().ok())
        .unwrap();
    let begun = (begun * 1000.0) as u64;
    // the machine may be busy; without the request there is no other cycle
    assert!((200..300).contains(&(first - begun)), "{times:?}");
    assert!((30..130).contains(&(second - first)), "{times:?}");
    assert!((170..270).contains(&(third - second)), "{times:?}");
}
