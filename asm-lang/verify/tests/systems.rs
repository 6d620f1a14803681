//! Systems of several machines: what they read from each other, and messages.

use crate::{machine, verdict_of, verified_system};
use asmotion_verify::{MachineSchedule, MessageModel, Options, SystemSpecification, Verdict};

/// A machine that passes a token on: it has it if the other one has the other parity.
fn passer(own: &str, other: &str, condition: &str) -> String {
    format!(
        "asm {own}
import StandardLibrary
import CTLLibrary
signature:
  monitored {other}: Boolean
  controlled {own}: Boolean
definitions:
  CTLSPEC again{own}: ag(af({own}))
  main rule r_Main = if {condition} then {own} := not {own} endif
default init s0:
  function {own} = false
"
    )
}

fn ring() -> SystemSpecification {
    SystemSpecification {
        machines: vec![
            machine("first", &passer("one", "two", "one = two")),
            machine("second", &passer("two", "one", "one != two")),
        ],
        ..SystemSpecification::default()
    }
}

#[test]
fn machines_read_each_other() {
    let verification = verified_system(ring(), &Options::default());
    assert_eq!(verification.states, 4);
    assert_eq!(verdict_of(&verification, "no state is stuck"), "holds");
    // each machine makes a step again and again
    assert_eq!(verdict_of(&verification, "againone"), "holds");
    assert_eq!(verdict_of(&verification, "againtwo"), "holds");
    let synchronous = SystemSpecification {
        schedule: MachineSchedule::Synchronous,
        ..ring()
    };
    let verification = verified_system(synchronous, &Options::default());
    assert_eq!(verification.states, 4);
}

#[test]
fn synchronous_machines_read_the_state_before_the_step() {
    let swap = |own: &str, other: &str, value: &str| {
        format!(
            "asm {own}
import StandardLibrary
signature:
  monitored {other}: Boolean
  controlled {own}: Boolean
definitions:
  main rule r_Main = {own} := {other}
default init s0:
  function {own} = {value}
"
        )
    };
    let system = |schedule| SystemSpecification {
        machines: vec![
            machine("left", &swap("a", "b", "true")),
            machine("right", &swap("b", "a", "false")),
        ],
        schedule,
        ..SystemSpecification::default()
    };
    let options = Options {
        possible: vec!["left.a".to_owned(), "a".to_owned(), "right.b".to_owned()],
        ..Options::default()
    };
    let swapped = verified_system(system(MachineSchedule::Synchronous), &options);
    assert_eq!(swapped.states, 2);
    // one after the other, they agree after the first step
    let agreed = verified_system(system(MachineSchedule::Interleaved), &options);
    assert_eq!(agreed.states, 3);
    assert_eq!(verdict_of(&agreed, "no state is stuck"), "violated");
}

const CLIENT: &str = "asm client
import StandardLibrary
import CommonBehavior
import CTLLibrary
signature:
  enum domain Mode = {ASKING | DONE}
  domain Number subsetof Integer
  domain Server subsetof Agent
  static server: Server
  out increment: Prod(Server, Number) -> Number
  controlled mode: Mode
  controlled number: Number
  controlled reply: Number
definitions:
  domain Number = {0:3}
  CTLSPEC answered: ag(mode = ASKING implies af(mode = DONE))
  CTLSPEC canAnswer: ag(mode = ASKING implies ef(mode = DONE))
  main rule r_Main =
    if mode = ASKING then par
      r_wcall[server, \"increment\", number, DEADLINE, reply]
      if isDef(reply) then par mode := DONE number := reply reply := undef endpar endif
      if isDef(callFault(self, \"increment\")) then r_wcancel[server, \"increment\"] endif
    endpar else mode := ASKING endif
default init s0:
  function mode = ASKING
  function number = 0
";

const SERVER: &str = "asm server
import StandardLibrary
import CommonBehavior
signature:
  domain Number subsetof Integer
  domain Server subsetof Agent
  out increment: Prod(Server, Number) -> Number
  //@Backref
  shared client: Agent -> Agent
  controlled asked: Number
definitions:
  domain Number = {0:3}
  main rule r_Main =
    if nextRequest(self) = \"increment\" then seq
      r_wreceive[client(self), \"increment\", asked]
      r_wreply[client(self), \"increment\", (asked + 1) mod 4]
    endseq endif
";

fn service(deadline: u32) -> SystemSpecification {
    let client = CLIENT.replace("DEADLINE", &deadline.to_string());
    SystemSpecification {
        machines: vec![machine("client", &client), machine("server", SERVER)],
        ..SystemSpecification::default()
    }
}

fn messages(is_lossy: bool, is_delayed: bool) -> Options {
    Options {
        messages: MessageModel {
            is_lossy,
            is_delayed,
            mailbox: 2,
        },
        possible: vec!["number = 3".to_owned()],
        ..Options::default()
    }
}

#[test]
fn calls_are_answered_unless_messages_are_lost() {
    let reliable = verified_system(service(0), &messages(false, false));
    assert_eq!(verdict_of(&reliable, "answered"), "holds");
    assert_eq!(verdict_of(&reliable, "no step fails"), "holds");
    assert_eq!(verdict_of(&reliable, "no state is stuck"), "holds");
    assert_eq!(verdict_of(&reliable, "number = 3"), "holds");
    let delayed = verified_system(service(0), &messages(false, true));
    assert_eq!(verdict_of(&delayed, "no state is stuck"), "holds");
    // every message arrives at some time
    assert_eq!(verdict_of(&delayed, "answered"), "holds");
    // without a deadline, the client waits for ever for a lost message
    let lossy = verified_system(service(0), &messages(true, false));
    assert_eq!(verdict_of(&lossy, "answered"), "violated");
    assert_eq!(verdict_of(&lossy, "canAnswer"), "violated");
    assert_eq!(verdict_of(&lossy, "no state is stuck"), "violated");
    // with one, it asks again
    let patient = verified_system(service(500), &messages(true, false));
    assert_eq!(verdict_of(&patient, "canAnswer"), "holds");
    assert_eq!(verdict_of(&patient, "no state is stuck"), "holds");
}

#[test]
fn a_full_mailbox_is_a_fault() {
    let sender = "asm sender
import StandardLibrary
import CommonBehavior
signature:
  domain Log subsetof Agent
  static log: Log
  out entry: Prod(Log, Boolean) -> Rule
definitions:
  main rule r_Main = r_wsend[log, \"entry\", true]
";
    let log = "asm log
import StandardLibrary
import CommonBehavior
signature:
  domain Log subsetof Agent
  out entry: Prod(Log, Boolean) -> Rule
  //@Backref
  shared client: Agent -> Agent
  controlled count: Integer
definitions:
  main rule r_Main = par r_wreceive[client(self), \"entry\"] count := 0 endpar
";
    let system = SystemSpecification {
        machines: vec![machine("sender", sender), machine("log", log)],
        ..SystemSpecification::default()
    };
    let verification = verified_system(system, &messages_without_possible(2));
    let faults = verification.properties.iter();
    let faults = faults.filter(|it| it.text == "no step fails");
    let faults: Vec<_> = faults.collect();
    let Verdict::Violated(Some(run)) = &faults[0].verdict else {
        panic!("{:?}", faults[0].verdict);
    };
    assert_eq!(run.steps.len(), 3);
    let fault = run.steps[2].fault.as_ref().unwrap();
    assert_eq!(
        fault.message,
        "the mailbox of `log` is full: `entry` of `sender` does not fit"
    );
}

fn messages_without_possible(mailbox: usize) -> Options {
    Options {
        messages: MessageModel {
            mailbox,
            ..MessageModel::default()
        },
        ..Options::default()
    }
}

#[test]
fn partners_outside_the_system_reply_fail_or_let_the_call_time_out() {
    let client = SystemSpecification {
        machines: vec![machine("client", &CLIENT.replace("DEADLINE", "500"))],
        ..SystemSpecification::default()
    };
    let verification = verified_system(client, &messages(false, false));
    assert_eq!(verdict_of(&verification, "number = 3"), "holds");
    assert_eq!(verdict_of(&verification, "answered"), "violated");
    assert_eq!(verdict_of(&verification, "canAnswer"), "holds");
    // the server alone gets requests from outside
    let server = SystemSpecification {
        machines: vec![machine("server", SERVER)],
        ..SystemSpecification::default()
    };
    let options = Options {
        possible: vec!["asked = 2".to_owned()],
        ..messages_without_possible(1)
    };
    let verification = verified_system(server, &options);
    assert_eq!(verdict_of(&verification, "asked = 2"), "holds");
    assert_eq!(verdict_of(&verification, "no step fails"), "holds");
}

/// Opens a specification of the repository.
fn file(folder: &str, name: &str, as_name: &str) -> asmotion_verify::VerifiedMachine {
    changed(folder, name, as_name, ("", ""))
}

/// A specification of the repository in which all occurrences of a text are replaced.
pub fn changed(
    folder: &str,
    name: &str,
    as_name: &str,
    (from, to): (&str, &str),
) -> asmotion_verify::VerifiedMachine {
    let root = format!("{}/../../specs/{folder}", env!("CARGO_MANIFEST_DIR"));
    let mut files = asmotion_lang::MemoryFiles::new();
    for entry in std::fs::read_dir(&root).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|it| it == "asm") {
            let mut text = std::fs::read_to_string(&path).unwrap();
            let file = path.file_name().unwrap().to_str().unwrap();
            if file == format!("{name}.asm") && !from.is_empty() {
                assert!(text.contains(from), "`{from}` in {file}");
                text = text.replace(from, to);
            }
            files.add(file, text);
        }
    }
    let opened = asmotion_lang::open(&format!("{name}.asm"), &files);
    asmotion_verify::VerifiedMachine {
        name: as_name.to_owned(),
        specification: opened.unwrap_or_else(|failure| panic!("{failure}")),
    }
}

#[test]
fn the_courier_and_its_dispatcher_are_explored_together() {
    let system = SystemSpecification {
        machines: vec![
            file("courier", "courier", "courier"),
            file("courier", "dispatcher", "dispatcher"),
        ],
        ..SystemSpecification::default()
    };
    let options = Options {
        limits: asmotion_verify::Limits {
            states: Some(3000),
            ..asmotion_verify::Limits::default()
        },
        possible: vec![
            "courier.jobs = 1".to_owned(),
            "dispatcher.finished = 1".to_owned(),
        ],
        ..Options::default()
    };
    let verification = verified_system(system, &options);
    // the counters grow for ever
    assert_eq!(
        verification.incomplete,
        Some(asmotion_verify::Incomplete::States)
    );
    assert_eq!(verdict_of(&verification, "courier.jobs = 1"), "holds");
    assert_eq!(
        verdict_of(&verification, "dispatcher.finished = 1"),
        "holds"
    );
    // a dispatcher that makes no step for long is asked again and again
    let faults = verification.properties.iter();
    let mut faults = faults.filter(|it| it.text == "no step fails");
    let run = faults.next().unwrap().verdict.run().unwrap();
    let last = run.steps.last().unwrap();
    assert_eq!(
        last.fault.as_ref().unwrap().message,
        "the mailbox of `dispatcher` is full: `job` of `courier` does not fit"
    );
    let messages = run.steps.iter().flat_map(|it| it.messages.iter());
    assert!(
        messages
            .clone()
            .any(|it| it == "courier: the call `job` times out")
    );
}

#[test]
fn the_allocation_and_its_robots_are_explored_together() {
    let system = SystemSpecification {
        machines: vec![
            file("allocation", "allocation", "allocation"),
            file("allocation", "robot", "ROB1"),
            file("allocation", "robot", "ROB2"),
        ],
        ..SystemSpecification::default()
    };
    let options = Options {
        limits: asmotion_verify::Limits {
            states: Some(2000),
            ..asmotion_verify::Limits::default()
        },
        possible: vec![
            "tstate(TASK1) = RUNNING".to_owned(),
            "ROB2.order = TASK2".to_owned(),
            "lowBattery(ROB1)".to_owned(),
        ],
        ..Options::default()
    };
    let verification = verified_system(system, &options);
    assert_eq!(
        verdict_of(&verification, "tstate(TASK1) = RUNNING"),
        "holds"
    );
    assert_eq!(verdict_of(&verification, "ROB2.order = TASK2"), "holds");
}

#[test]
fn recovery_ends_if_the_service_replies_or_lets_calls_time_out() {
    let ends = "af(mode = SUCCESS or mode = GIVE_UP)";
    let options = Options {
        properties: vec![ends.to_owned()],
        ..Options::default()
    };
    let free = SystemSpecification::of(file("recovery", "recovery", "recovery").specification);
    assert_eq!(
        verdict_of(&verified_system(free, &options), ends),
        "violated"
    );
    let service = file("recovery", "service", "service").specification;
    let system = SystemSpecification::of(file("recovery", "recovery", "recovery").specification)
        .with_environment(asmotion_verify::EnvironmentModel::Specification(Box::new(
            service,
        )));
    let verification = verified_system(system, &options);
    assert_eq!(verdict_of(&verification, ends), "holds");
    let violated = verification
        .properties
        .iter()
        .filter(|it| it.verdict.is_violated());
    let violated: Vec<&str> = violated.map(|it| it.text.as_str()).collect();
    assert!(violated.is_empty(), "{violated:?}");
    assert!(verification.assumptions.is_empty());
}

#[test]
fn the_trace_of_each_machine_repeats_its_part_of_the_run() {
    use asmotion_lang::simulate::{Causes, Recording, Simulation};
    let verification = verified_system(service(500), &messages(true, true));
    let possible = verification.properties.iter();
    let mut possible = possible.filter(|it| it.text == "number = 3");
    let run = possible.next().unwrap().verdict.run().unwrap();
    assert_eq!(run.traces.len(), 2);
    let texts = [CLIENT.replace("DEADLINE", "500"), SERVER.to_owned()];
    for (index, (text, trace)) in texts.iter().zip(&run.traces).enumerate() {
        let steps: Vec<_> = run.steps.iter().filter(|it| it.machine == index).collect();
        let recording = Recording::read(trace);
        assert_eq!(recording.steps().len(), steps.len());
        let machine = crate::open(text).machine().unwrap();
        let mut simulation = Simulation::new(machine, Causes::Recording(recording), 1);
        for step in steps {
            simulation.step().unwrap();
            let machine = simulation.machine();
            let taken = machine.last_step();
            let changed = taken.updates().iter().zip(taken.before());
            let changed = changed.filter(|(update, before)| update.value != **before);
            assert_eq!(changed.count(), step.updates.len(), "{trace}");
        }
    }
}

#[test]
fn a_fault_and_an_unused_rule_are_found_in_every_machine() {
    let writer = "asm writer
import StandardLibrary
signature:
  domain Number subsetof Integer
  out number: Number
definitions:
  domain Number = {0:5}
  main rule r_Main = choose $n in Number with true do number := $n
default init s0:
  function number = 0
";
    let reader = "asm reader
import StandardLibrary
signature:
  domain Number subsetof Integer
  domain Small subsetof Integer
  monitored number: Number
  controlled last: Small
definitions:
  domain Number = {0:5}
  domain Small = {0:3}
  rule r_never = last := 0
  main rule r_Main = if number > 5 then r_never[] else last := number endif
default init s0:
  function last = 0
";
    let system = SystemSpecification {
        machines: vec![machine("writer", writer), machine("reader", reader)],
        ..SystemSpecification::default()
    };
    let verification = verified_system(system, &Options::default());
    let property = |text: &str| {
        let mut properties = verification.properties.iter();
        properties.find(|it| it.text == text).unwrap()
    };
    let run = property("no step fails").verdict.run().unwrap();
    let machines: Vec<usize> = run.steps.iter().map(|it| it.machine).collect();
    assert_eq!(machines, [0, 1]);
    assert!(run.steps[0].fault.is_none() && run.steps[1].fault.is_some());
    let rules = property("every rule runs");
    assert!(rules.verdict.is_violated());
    let asmotion_verify::Note::Also(never) = &rules.notes[0] else {
        panic!("{:?}", rules.notes);
    };
    assert_eq!(never.len(), 1);
    assert!(never[0].starts_with("r_never"), "{never:?}");
}

#[test]
fn a_message_of_a_synchronous_machine_arrives_in_the_next_transition() {
    let sender = "asm sender
import StandardLibrary
import CommonBehavior
signature:
  domain Number subsetof Integer
  domain Receiver subsetof Agent
  static receiver: Receiver
  out go: Prod(Receiver, Boolean) -> Rule
  controlled steps: Number
definitions:
  domain Number = {0:3}
  main rule r_Main = if steps < 3 then par
    steps := steps + 1
    if steps = 0 then r_wsend[receiver, \"go\", true] endif
  endpar endif
default init s0:
  function steps = 0
";
    let receiver = "asm receiver
import StandardLibrary
import CommonBehavior
signature:
  domain Number subsetof Integer
  domain Receiver subsetof Agent
  out go: Prod(Receiver, Boolean) -> Rule
  //@Backref
  shared client: Agent -> Agent
  monitored steps: Number
  controlled at: Number
definitions:
  domain Number = {0:3}
  main rule r_Main = if nextRequest(self) = \"go\" then par
    r_wreceive[client(self), \"go\"]
    at := steps
  endpar endif
";
    let possible: Vec<String> = (0..4).map(|at| format!("receiver.at = {at}")).collect();
    let options = Options {
        possible: possible.clone(),
        only: possible.clone(),
        ..Options::default()
    };
    let found = |schedule| {
        let system = SystemSpecification {
            machines: vec![machine("sender", sender), machine("receiver", receiver)],
            schedule,
            ..SystemSpecification::default()
        };
        let verification = verified_system(system, &options);
        let holds = possible
            .iter()
            .map(|it| verdict_of(&verification, it) == "holds");
        holds.collect::<Vec<bool>>()
    };
    // in the second transition, where both read what the sender had after the first
    assert_eq!(
        found(MachineSchedule::Synchronous),
        [false, true, false, false]
    );
    // the receiver makes its step at any time after the message
    assert_eq!(
        found(MachineSchedule::Interleaved),
        [false, true, true, true]
    );
}
