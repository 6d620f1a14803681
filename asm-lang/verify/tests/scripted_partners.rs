//! Partners that a script plays.

use crate::{machine, verdict_of, verified_system};
use asmotion_lang::diagnostics::FileId;
use asmotion_lang::simulate::{Causes, Script, Simulation};
use asmotion_verify::{
    EnvironmentModel, MessageModel, Options, SystemSpecification, VerifiedMachine,
};

/// Asks for a number, again and again; counts replies and faults.
const CLIENT: &str = "asm client
import StandardLibrary
import CommonBehavior
signature:
  domain Oracle subsetof Agent
  domain Count subsetof Integer
  static oracle: Oracle
  out number: Prod(Oracle, Boolean) -> Integer
  controlled got: Integer
  controlled replies: Count
  controlled faults: Count
definitions:
  domain Count = {0:20}
  main rule r_Main =
    par
      r_wcall[oracle, \"number\", true, 500, got]
      if isDef(got) then par replies := replies + 1 got := undef endpar endif
      if isDef(callFault(self, \"number\")) then
        par faults := faults + 1 r_wcancel[oracle, \"number\"] endpar
      endif
    endpar
default init s0:
  function replies = 0
  function faults = 0
";

fn script(client: &VerifiedMachine, answer: &str, steps: usize) -> Script {
    let text = format!(
        "[partner.oracle]\nnumber = {answer}\n\n{}",
        "[[step]]\n".repeat(steps)
    );
    let read = Script::read(FileId::default(), &text, &client.specification.program);
    read.unwrap_or_else(|report| panic!("{text}: {report:?}"))
}

fn verified(
    script: Script,
    messages: MessageModel,
    options: Options,
) -> asmotion_verify::Verification {
    let system = SystemSpecification {
        machines: vec![machine("client", CLIENT)],
        environment: EnvironmentModel::Script(script),
        ..SystemSpecification::default()
    };
    let options = Options {
        messages,
        ..options
    };
    verified_system(system, &options)
}

/// Texts of the states of a simulation with the script, as conditions.
fn simulated(script: Script, steps: usize) -> Vec<String> {
    let client = machine("client", CLIENT);
    let specification = client.specification;
    let function = |name: &str| specification.function(name, 0).unwrap();
    let functions = ["replies", "faults", "got"].map(|name| (name, function(name)));
    let started = specification.machine().unwrap_or_else(|_| panic!("starts"));
    let mut simulation = Simulation::new(started, Causes::Script(script), 0);
    let state = |simulation: &Simulation| {
        let naming = simulation.machine().naming();
        let values = functions.map(|(name, function)| {
            let value = simulation.machine().value_at(function, &[]);
            match value.show(&naming).to_string() {
                text if text == "undef" => format!("not isDef({name})"),
                text => format!("{name} = {text}"),
            }
        });
        values.join(" and ")
    };
    let mut states = vec![state(&simulation)];
    for _ in 0..steps {
        simulation.step().unwrap_or_else(|_| panic!("steps"));
        states.push(state(&simulation));
    }
    states
}

const ANSWERS: [&str; 5] = [
    "{ reply = 7 }",
    "{ reply = 7, after = 3 }",
    "{ fault = \"CALL_FAILED\" }",
    "{ fault = \"CALL_TIMEOUT\", after = 2 }",
    "{ reply = 7, after = 50 }",
];

#[test]
fn a_verified_script_is_the_simulated_run() {
    for answer in ANSWERS {
        let client = machine("client", CLIENT);
        let states = simulated(script(&client, answer, 9), 9);
        let mut distinct = states.clone();
        distinct.sort();
        distinct.dedup();
        // an answer of the next fifty steps changes something
        assert_eq!(
            distinct.len() > 1,
            !answer.contains("50"),
            "{answer}: {distinct:?}"
        );
        let all: Vec<String> = distinct.iter().map(|it| format!("({it})")).collect();
        let all = all.join(" or ");
        let options = Options {
            properties: vec![all.clone()],
            possible: distinct.clone(),
            ..Options::default()
        };
        let verification = verified(script(&client, answer, 9), MessageModel::default(), options);
        // one run: a state after each step
        assert_eq!(verification.states, 10, "{answer}");
        assert_eq!(verdict_of(&verification, &all), "holds", "{answer}");
        for state in distinct {
            assert_eq!(
                verdict_of(&verification, &state),
                "holds",
                "{answer}: {state}"
            );
        }
    }
}

#[test]
fn scripted_replies_are_lost_and_late_like_others() {
    let within = |steps, answer: &str, is_lossy: bool, is_delayed: bool, state: &str| {
        let client = machine("client", CLIENT);
        let messages = MessageModel {
            is_lossy,
            is_delayed,
            ..MessageModel::default()
        };
        let options = Options {
            possible: vec![state.to_owned()],
            ..Options::default()
        };
        let verification = verified(script(&client, answer, steps), messages, options);
        assert_eq!(verdict_of(&verification, "no step fails"), "holds");
        verdict_of(&verification, state)
    };
    let possible = |answer: &str, is_lossy, is_delayed, state: &str| {
        within(6, answer, is_lossy, is_delayed, state)
    };
    let prompt = "{ reply = 7 }";
    // the script says when a call ends, unless the request is lost: then its deadline ends it
    assert_eq!(possible(prompt, false, false, "faults > 0"), "violated");
    assert_eq!(possible(prompt, true, false, "faults > 0"), "holds");
    assert_eq!(possible(prompt, false, true, "faults > 0"), "violated");
    // three rounds of two steps at most; a late reply has the effect of fewer rounds, not more
    assert_eq!(
        possible(prompt, false, false, "replies > 1"),
        possible(prompt, false, true, "replies > 1")
    );
    let late = "{ reply = 7, after = 2 }";
    assert_eq!(possible(late, false, false, "replies > 2"), "violated");
    assert_eq!(possible(late, true, true, "replies > 2"), "violated");
    // a round and its fault take several steps
    let twice = "replies = 0 and faults = 2";
    assert_eq!(within(12, late, false, false, twice), "violated");
    assert_eq!(within(12, late, true, true, twice), "holds");
}

#[test]
fn the_late_dispatcher_of_the_courier_is_played() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../specs/courier");
    let read = |name: &str| std::fs::read_to_string(format!("{folder}/{name}")).unwrap();
    let mut files = asmotion_lang::MemoryFiles::new();
    for name in ["courier.asm", "Dispatch.asm"] {
        files.add(name, read(name));
    }
    let courier = asmotion_lang::open("courier.asm", &files).unwrap_or_else(|it| panic!("{it}"));
    let text = read("courier.late.env.toml");
    let script = Script::read(FileId::default(), &text, &courier.program).unwrap();
    let system =
        SystemSpecification::of(courier).with_environment(EnvironmentModel::Script(script));
    let options = Options {
        properties: vec!["jobs <= 1".to_owned(), "jobs < 1".to_owned()],
        ..Options::default()
    };
    let verification = verified_system(system, &options);
    assert_eq!(verification.incomplete, None);
    assert_eq!(verification.states, 10);
    assert_eq!(verdict_of(&verification, "jobs <= 1"), "holds");
    assert_eq!(verdict_of(&verification, "jobs < 1"), "violated");
}
