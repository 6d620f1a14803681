//! Machines, environments and properties that do not fit together, as a user sees the findings.

use crate::{refused, verified_system};
use asmotion_lang::diagnostics::Diagnostic;
use asmotion_lang::{MemoryFiles, Report, Specification, Style, render_all};
use asmotion_verify::{
    EnvironmentModel, MessageModel, Options, SystemSpecification, Verdict, VerifiedMachine,
    verify_system,
};

/// Opens a specification from a file called as it is, so that findings show which one they are in.
fn opened(text: &str) -> Specification {
    let name = text.split_whitespace().nth(1).unwrap();
    let file = format!("{name}.asm");
    let mut files = MemoryFiles::new();
    files.add(&file, text);
    asmotion_lang::open(&file, &files).unwrap_or_else(|failure| panic!("{failure}"))
}

fn machine(name: &str, text: &str) -> VerifiedMachine {
    VerifiedMachine {
        name: name.to_owned(),
        specification: opened(text),
    }
}

/// Renders the findings that refuse a system.
fn refusal(system: SystemSpecification, options: &Options) -> String {
    let refusal = verify_system(system, options, &mut |_| true).unwrap_err();
    refused(&refusal)
}

fn system(machines: Vec<VerifiedMachine>) -> SystemSpecification {
    SystemSpecification {
        machines,
        ..SystemSpecification::default()
    }
}

/// A door with an input, and a function that it provides.
const DOOR: &str = "asm door
import StandardLibrary
signature:
  monitored request: Boolean
  out moving: Boolean
definitions:
  main rule r_Main = moving := request
default init s0:
  function moving = false
";

/// Renders the findings about an environment of the door.
fn of_environment(signature: &str, rule: &str) -> String {
    let environment = format!(
        "asm visitor
import StandardLibrary
signature:
  {signature}
definitions:
  main rule r_Main = {rule}
"
    );
    let environment = EnvironmentModel::Specification(Box::new(opened(&environment)));
    let system = SystemSpecification::of(opened(DOOR)).with_environment(environment);
    refusal(system, &Options::default())
}

const WATCH: &str = "asm watch
import StandardLibrary
signature:
  monitored moving: Boolean
  controlled hasMoved: Boolean
definitions:
  main rule r_Main = if moving then hasMoved := true endif
";

#[test]
fn an_input_that_several_machines_provide() {
    let doors = system(vec![
        machine("LEFT", DOOR),
        machine("RIGHT", DOOR),
        machine("watch", WATCH),
    ]);
    let rendered = refusal(doors, &Options::default());
    insta::assert_snapshot!("M007", rendered);
    // no parameter is free for the name of the machine
    let with_parameter = |text: &str| {
        let declared = text.replace("moving: Boolean", "moving: Boolean -> Boolean");
        let used = declared.replace("moving :=", "moving(true) :=");
        used.replace("if moving", "if moving(true)")
            .replace("function moving =", "function moving($side in Boolean) =")
    };
    let (door, watch) = (with_parameter(DOOR), with_parameter(WATCH));
    let doors = system(vec![
        machine("LEFT", &door),
        machine("RIGHT", &door),
        machine("watch", &watch),
    ]);
    let rendered = refusal(doors, &Options::default());
    insta::assert_snapshot!("M007_with_parameters", rendered);
    // the way out: a parameter whose values are the names of the machines
    let watch = WATCH
        .replace("moving: Boolean", "moving: Door -> Boolean")
        .replace("if moving", "if moving(LEFT)")
        .replace(
            "  monitored",
            "  enum domain Door = {LEFT | RIGHT}\n  monitored",
        );
    let doors = system(vec![
        machine("LEFT", DOOR),
        machine("RIGHT", DOOR),
        machine("watch", &watch),
    ]);
    verified_system(doors, &Options::default());
}

#[test]
fn an_environment_that_provides_other_values() {
    let rendered = of_environment("out request: Integer", "request := 1");
    insta::assert_snapshot!("M008", rendered);
    // literals correspond by name
    let light = "asm light
import StandardLibrary
signature:
  enum domain Colour = {RED | GREEN}
  monitored colour: Colour
  controlled stands: Boolean
definitions:
  main rule r_Main = stands := colour = RED
";
    let signal = "asm signal
import StandardLibrary
signature:
  enum domain Shown = {RED | YELLOW}
  out colour: Shown
definitions:
  main rule r_Main = colour := YELLOW
";
    let machines = system(vec![machine("light", light), machine("signal", signal)]);
    let rendered = refusal(machines, &Options::default());
    insta::assert_snapshot!("M008_literals", rendered);
}

#[test]
fn an_environment_that_provides_what_nothing_reads() {
    let rendered = of_environment("out requests: Boolean", "requests := true");
    insta::assert_snapshot!("M009", rendered);
    let rendered = of_environment("out weather: Boolean", "weather := true");
    insta::assert_snapshot!("M009_without_similar_input", rendered);
    // the right name with another number of parameters
    let rendered = of_environment("out request: Boolean -> Boolean", "request(true) := true");
    insta::assert_snapshot!("M009_with_other_parameters", rendered);
}

#[test]
fn an_environment_that_reads_what_nothing_provides() {
    let signature = "monitored isMoving: Boolean\n  out request: Boolean";
    let rendered = of_environment(signature, "request := not isMoving");
    insta::assert_snapshot!("M010", rendered);
    let signature = "monitored hour: Integer\n  out request: Boolean";
    let rendered = of_environment(signature, "request := hour = 3");
    insta::assert_snapshot!("M010_without_similar_function", rendered);
    // the right name with another number of parameters
    let signature = "monitored moving: Boolean -> Boolean\n  out request: Boolean";
    let rendered = of_environment(signature, "request := not moving(true)");
    insta::assert_snapshot!("M010_with_other_parameters", rendered);
}

#[test]
fn a_property_about_several_machines() {
    let derived = "  derived rests: Boolean\ndefinitions:\n  function rests = not moving";
    let door = DOOR.replace("definitions:", derived);
    let machines = system(vec![machine("door", &door), machine("watch", WATCH)]);
    let options = Options {
        properties: vec!["watch.hasMoved implies door.rests".to_owned()],
        ..Options::default()
    };
    let rendered = refusal(machines, &options);
    insta::assert_snapshot!("M012", rendered);
}

#[test]
fn names_of_machines_that_are_missing_or_misspelt() {
    let rendered = |property: &str| {
        let machines = system(vec![machine("door", DOOR), machine("watch", WATCH)]);
        let options = Options {
            properties: vec![property.to_owned()],
            ..Options::default()
        };
        refusal(machines, &options)
    };
    insta::assert_snapshot!(
        "machine_misspelt",
        rendered("wach.hasMoved implies door.moving")
    );
    insta::assert_snapshot!("machine_unknown", rendered("lock.isClosed"));
    insta::assert_snapshot!("machine_missing", rendered("hasMoved implies request"));
}

#[test]
fn a_message_that_does_not_fit_into_a_mailbox() {
    let sensor = "asm sensor
import StandardLibrary
import CommonBehavior
signature:
  domain Logger subsetof Agent
  static logger: Logger
  out entry: Prod(Logger, Boolean) -> Rule
definitions:
  main rule r_Main = r_wsend[logger, \"entry\", true]
";
    let logger = "asm logger
import StandardLibrary
import CommonBehavior
signature:
  domain Logger subsetof Agent
  out entry: Prod(Logger, Boolean) -> Rule
  //@Backref
  shared client: Agent -> Agent
definitions:
  main rule r_Main = r_wreceive[client(self), \"entry\"]
";
    let options = Options {
        messages: MessageModel {
            mailbox: 1,
            ..MessageModel::default()
        },
        ..Options::default()
    };
    let machines = system(vec![machine("sensor", sensor), machine("logger", logger)]);
    let verification = verified_system(machines, &options);
    let mut properties = verification.properties.iter();
    let property = properties.find(|it| it.text == "no step fails").unwrap();
    let Verdict::Violated(Some(run)) = &property.verdict else {
        panic!("{:?}", property.verdict);
    };
    let last = run.steps.last().unwrap();
    let fault: &Diagnostic = last.fault.as_ref().unwrap();
    let mut report = Report::new();
    report.push(fault.clone());
    let sources = &verification.machines[last.machine].specification.sources;
    let rendered = render_all(&report.finish(), sources, Style::Plain);
    insta::assert_snapshot!("M011", rendered);
}
