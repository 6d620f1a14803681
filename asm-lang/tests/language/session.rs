//! Evaluation of terms and rules in a running specification.

use asmotion_lang::{
    Environment, FirstChoice, MemoryFiles, NoInputs, Report, Session, Style, Value, ir, render_all,
};

const GEAR: &str = "module Gear
import StandardLibrary
export gear
signature:
  controlled gear: Integer
  static hidden: Integer
definitions:
  function hidden = 7
";

const CAR: &str = "asm car
import StandardLibrary
import Gear
signature:
  domain Speed subsetof Integer
  monitored pedal: Integer
  controlled speed: Speed
  controlled seen: Integer -> Integer
  derived fast: Boolean
definitions:
  domain Speed = {0 : 9}
  function fast = speed > 5
  rule r_set($to in Integer) = speed := $to
  invariant over speed: speed < 9
  main rule r_Main = par speed := pedal seen(pedal) := 1 endpar
default init s0:
  function speed = 1
  function seen($i in Integer) = $i * 10
";

/// An environment whose answers count upwards.
struct Counter(i64);

impl Environment for Counter {
    fn read(&mut self, _: ir::FunctionId, _: &[Value]) -> Result<Option<Value>, String> {
        self.0 += 1;
        Ok(Some(Value::Int(self.0)))
    }
}

fn session() -> Session {
    let mut files = MemoryFiles::new();
    files.add("car.asm", CAR);
    files.add("Gear.asm", GEAR);
    let specification =
        asmotion_lang::open("car.asm", &files).unwrap_or_else(|failure| panic!("{failure}"));
    Session::new(specification).unwrap_or_else(|failure| panic!("{failure}"))
}

fn evaluate(session: &mut Session, text: &str) -> String {
    let answer = session.evaluate(text, &mut NoInputs, 0);
    match answer {
        Ok(value) => value.show(&session.machine.naming()).to_string(),
        Err(report) => said(session, &report),
    }
}

fn said(session: &Session, report: &Report) -> String {
    render_all(report, &session.specification.sources, Style::Plain)
}

#[test]
fn it_evaluates_terms_in_the_current_state() {
    let mut session = session();
    assert_eq!(evaluate(&mut session, "speed + 1"), "2");
    assert_eq!(evaluate(&mut session, "fast"), "false");
    assert_eq!(evaluate(&mut session, "seen(4)"), "40");
    session
        .machine
        .step(&mut Counter(6), &mut FirstChoice, 0)
        .unwrap();
    assert_eq!(
        evaluate(&mut session, "(speed, fast, seen(7), seen(4))"),
        "(7, true, 1, 40)"
    );
}

#[test]
fn it_sees_what_imported_modules_keep_for_themselves() {
    let mut session = session();
    assert_eq!(evaluate(&mut session, "(gear, hidden)"), "(undef, 7)");
}

#[test]
fn a_watched_term_keeps_its_meaning_while_others_come_and_go() {
    let mut session = session();
    let watched = session.watch("speed").unwrap();
    assert_eq!(evaluate(&mut session, "seen(1)"), "10");
    session
        .machine
        .step(&mut Counter(3), &mut FirstChoice, 0)
        .unwrap();
    assert_eq!(
        session.value(watched, &mut NoInputs, 0).unwrap(),
        Value::Int(4)
    );
}

#[test]
fn a_question_before_the_first_step_reads_the_inputs_of_the_initial_state() {
    let text = "asm start
import StandardLibrary
signature:
  monitored given: Integer
  controlled first: Integer
definitions:
  main rule r_Main = first := first + 1
default init s0:
  function first = 10 * given
";
    let mut session = Session::new(crate::support::opened("start", text)).unwrap();
    let terms = ["first", "given", "first"].map(|term| session.watch(term).unwrap());
    for (given, expected) in [(1, 20), (4, 50)] {
        let value = session.value(terms[0], &mut Counter(given), 0).unwrap();
        assert_eq!(value, Value::Int(expected));
        // the environment is asked once for an input that several terms need
        let mut values = Vec::new();
        let mut inputs = Counter(given);
        let machine = &mut session.machine;
        machine
            .evaluate_each(&terms, &mut inputs, 0, &mut values)
            .unwrap();
        let asked = [expected, given + 2, expected].map(Value::Int);
        assert_eq!(values, asked);
        assert_eq!(inputs.0, given + 2);
    }
    // the questions have not completed the initial state
    let step = session
        .machine
        .step(&mut Counter(7), &mut FirstChoice, 0)
        .unwrap();
    assert_eq!(step.updates()[0].value, Value::Int(81));
}

#[test]
fn a_program_with_other_locations_does_not_replace_that_of_a_machine() {
    let program = |signature: &str| {
        let text = format!(
            "asm other\nimport StandardLibrary\nsignature:\n  controlled n: Integer\n  {signature}\ndefinitions:\n  main rule r_Main = n := 1\n"
        );
        crate::support::opened("other", &text)
    };
    let own = program("static k: Integer");
    let mut machine = own.machine().unwrap();
    machine.replace_program(own.program.clone()).unwrap();
    for signature in [
        "controlled k: Integer",
        "enum domain K = {A | B}",
        "abstract domain K",
        "static k: Boolean -> Integer\n  abstract domain K\n static l: K",
    ] {
        let other = program(signature).program;
        assert!(machine.replace_program(other).is_err(), "{signature}");
    }
    let step = machine.step(&mut NoInputs, &mut FirstChoice, 0).unwrap();
    assert_eq!(step.updates().len(), 1);
}

#[test]
fn a_question_asks_the_environment_and_leaves_the_last_step_as_it_was() {
    let mut session = session();
    session
        .machine
        .step(&mut Counter(1), &mut FirstChoice, 0)
        .unwrap();
    let value = session.evaluate("pedal", &mut Counter(7), 0).unwrap();
    assert_eq!(value, Value::Int(8));
    let step = session.machine.last_step();
    assert_eq!((step.inputs().len(), step.updates().len()), (1, 2));
}

#[test]
fn a_rule_fires_without_being_a_step() {
    let mut session = session();
    session
        .fire(
            "seq r_set[3] speed := speed + 1 endseq",
            &mut NoInputs,
            &mut FirstChoice,
            0,
        )
        .unwrap();
    assert_eq!(evaluate(&mut session, "speed"), "4");
    assert_eq!(session.machine.steps(), 0);
    let clash = session.fire(
        "par r_set[3] r_set[2] endpar",
        &mut NoInputs,
        &mut FirstChoice,
        0,
    );
    assert_eq!(clash.unwrap_err().diagnostics[0].code, "R001");
    assert_eq!(evaluate(&mut session, "speed"), "4");
}

#[test]
fn a_location_is_set_from_outside_within_its_codomain() {
    let mut session = session();
    let (function, arguments, value) = session
        .assignment("seen(2 + 3) := speed", &mut NoInputs, 0)
        .unwrap();
    assert_eq!(arguments, [Value::Int(5)]);
    session.machine.set(function, &arguments, value).unwrap();
    assert_eq!(evaluate(&mut session, "seen(5)"), "1");
    let (speed, arguments, value) = session.assignment("speed := 12", &mut NoInputs, 0).unwrap();
    assert!(session.machine.set(speed, &arguments, value).is_err());
    assert_eq!(evaluate(&mut session, "speed"), "1");
}

#[test]
fn a_machine_is_kept_and_taken_up_again() {
    let mut session = session();
    let kept = session.machine.clone();
    session
        .machine
        .step(&mut Counter(4), &mut FirstChoice, 0)
        .unwrap();
    assert_eq!(evaluate(&mut session, "speed"), "5");
    session.machine = kept;
    assert_eq!(evaluate(&mut session, "speed"), "1");
    assert_eq!(session.machine.steps(), 0);
}

#[test]
fn a_question_that_makes_no_sense_is_answered_like_a_specification() {
    let mut session = session();
    let mut all = String::new();
    for text in ["sped", "speed +", "speed = true", "1 div 0"] {
        all.push_str(&evaluate(&mut session, text));
    }
    for text in ["fast := true", "speed", "speed := true"] {
        let report = session.assignment(text, &mut NoInputs, 0).unwrap_err();
        all.push_str(&said(&session, &report));
    }
    insta::assert_snapshot!(all);
}
