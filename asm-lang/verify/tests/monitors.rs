//! Monitors of a running machine.

use crate::open;
use asmotion_lang::machine::Machine;
use asmotion_lang::value::Value;
use asmotion_lang::{Environment, FirstChoice, Specification};
use asmotion_verify::{GivenProperty, Monitors, MonitorsState, PropertyViolation};

const SECOND: i64 = 1_000_000_000;

/// A rover that can be told to move although the e-stop is pressed.
const ROVER: &str = "asm rover
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
  monitored estop: Boolean
  monitored drive: Boolean
  controlled moving: Boolean
  controlled waiting: Boolean
definitions:
  CTLSPEC ag(estop implies ax(not moving))
  LTLSPEC g(moving implies o(drive))
  CTLSPEC ag(ef(moving))
  //@Within 2 s
  CTLSPEC ag(waiting implies af(not waiting))
  CTLSPEC ag(waiting implies af(moving))
  rule r_stop = par moving := false waiting := drive endpar
  main rule r_Main = par moving := drive waiting := drive endpar
default init s0:
  function moving = false
  function waiting = false
";

/// The inputs `estop` and `drive` of a step.
struct Inputs<'a>(&'a Specification, [bool; 2]);

impl Environment for Inputs<'_> {
    fn read(
        &mut self,
        function: asmotion_lang::ir::FunctionId,
        _: &[Value],
    ) -> Result<Option<Value>, String> {
        let estop = self.0.function("estop", 0) == Some(function);
        Ok(Some(Value::Bool(self.1[usize::from(!estop)])))
    }
}

struct Watched {
    specification: Specification,
    machine: Machine,
    monitors: Monitors,
}

impl Watched {
    fn new(text: &str, given: &[GivenProperty]) -> Self {
        let mut specification = open(text);
        let monitors = Monitors::of(&mut specification, given).unwrap();
        let machine = specification.machine().unwrap();
        Self {
            specification,
            machine,
            monitors,
        }
    }

    /// The texts of the properties that a step violates, marked with `!` if that is new.
    fn step(&mut self, now_ns: i64, inputs: [bool; 2]) -> Vec<String> {
        let mut environment = Inputs(&self.specification, inputs);
        let (machine, monitors) = (&mut self.machine, &mut self.monitors);
        let mut found = monitors.before_step(machine, &mut environment, now_ns, &|_| true);
        machine
            .step(&mut environment, &mut FirstChoice, now_ns)
            .unwrap();
        found.extend(monitors.after_step(machine, now_ns));
        monitors.end_step();
        let text = |it: &PropertyViolation| {
            let text = &self.monitors.watched()[it.property].text;
            format!("{}{text}", if it.is_new { "!" } else { "" })
        };
        found.iter().map(text).collect()
    }
}

const STOPS: &str = "ag(estop implies ax(not moving))";

#[test]
fn a_violation_is_found_in_the_step_that_causes_it() {
    let mut rover = Watched::new(ROVER, &[]);
    assert_eq!(rover.step(0, [false, true]), [""; 0]);
    assert_eq!(rover.step(1, [true, false]), [""; 0]);
    assert_eq!(rover.step(2, [true, true]), [format!("!{STOPS}")]);
    // it moves on: violated again, which is nothing new
    assert_eq!(rover.step(3, [true, true]), [STOPS]);
    assert_eq!(rover.step(4, [false, true]), [""; 0]);
    assert_eq!(rover.step(5, [true, true]), [format!("!{STOPS}")]);
    assert_eq!(rover.monitors.violated_steps(0), 3);
}

#[test]
fn the_conditions_of_a_violation_have_their_values() {
    let mut rover = Watched::new(ROVER, &[]);
    let mut environment = Inputs(&rover.specification, [true, true]);
    let (machine, monitors) = (&mut rover.machine, &mut rover.monitors);
    assert!(
        monitors
            .before_step(machine, &mut environment, 0, &|_| true)
            .is_empty()
    );
    machine.step(&mut environment, &mut FirstChoice, 0).unwrap();
    let found = monitors.after_step(machine, 0);
    let conditions = found[0].conditions.iter();
    let conditions: Vec<_> = conditions
        .map(|it| (it.text.as_str(), it.before, it.after))
        .collect();
    assert_eq!(
        conditions,
        [
            ("estop", Some(true), None),
            ("not moving", Some(true), Some(false)),
        ]
    );
}

#[test]
fn a_step_that_is_undone_leaves_no_trace() {
    let mut rover = Watched::new(ROVER, &[]);
    let rule = {
        let parsed = asmotion_lang::syntax::parse_rule(
            rover.specification.sources.add("<safe>", "r_stop[]"),
            "r_stop[]",
        );
        let rule = rover
            .specification
            .model
            .add_rule(&parsed.unwrap())
            .unwrap();
        rover.specification.lower().unwrap();
        rover
            .machine
            .replace_program(rover.specification.program.clone())
            .unwrap();
        rule
    };
    for step in 0..3 {
        let mut environment = Inputs(&rover.specification, [true, true]);
        let (machine, monitors) = (&mut rover.machine, &mut rover.monitors);
        let before = monitors.before_step(machine, &mut environment, step, &|_| true);
        assert_eq!(before, []);
        assert!(machine.can_revert());
        machine
            .step(&mut environment, &mut FirstChoice, step)
            .unwrap();
        assert_eq!(monitors.after_step(machine, step).len(), 1, "{step}");
        monitors.undo_step(machine);
        machine.revert();
        machine
            .step_with(rule, &mut environment, &mut FirstChoice, step)
            .unwrap();
        assert_eq!(monitors.after_step(machine, step), []);
        monitors.end_step();
        assert_eq!(machine.steps(), step as u64 + 1);
    }
}

#[test]
fn a_response_is_late_when_its_time_has_passed() {
    let mut rover = Watched::new(ROVER, &[]);
    let late = "!ag(waiting implies af(not waiting))";
    assert_eq!(rover.step(0, [false, true]), [""; 0]);
    assert_eq!(rover.monitors.deadline_ns(), Some(2 * SECOND));
    assert_eq!(rover.step(SECOND, [false, false]), [""; 0]);
    assert_eq!(rover.monitors.deadline_ns(), None);
    assert_eq!(rover.step(3 * SECOND, [false, true]), [""; 0]);
    assert_eq!(rover.step(4 * SECOND, [false, true]), [""; 0]);
    assert_eq!(rover.step(5 * SECOND, [false, true]), [late]);
    // the next one is due after the same time again
    assert_eq!(rover.step(6 * SECOND, [false, true]), [""; 0]);
    assert_eq!(rover.step(7 * SECOND, [false, true]), [late]);
}

#[test]
fn properties_that_no_run_violates_are_named_with_the_reason() {
    let rover = Watched::new(ROVER, &[]);
    let unwatched = rover.monitors.unwatched().iter();
    let unwatched: Vec<_> = unwatched
        .map(|it| format!("{} {}: {}", it.place, it.text, it.reason))
        .collect();
    assert_eq!(
        unwatched,
        [
            "model.asm:13 ag(ef(moving)): something has to be possible, which one run cannot refute",
            "model.asm:16 ag(waiting implies af(moving)): something has to happen, but at no definite time, so that no finite run \
             violates it",
        ]
    );
}

#[test]
fn a_comment_without_effect_is_named() {
    let text = ROVER
        .replace("//@Within 2 s", "//@Within soon")
        .replace("main rule", "//@Within 3 s\n  main rule");
    let rover = Watched::new(&text, &[]);
    let unwatched = rover.monitors.unwatched().iter();
    let comments: Vec<_> = unwatched
        .filter(|it| it.text.starts_with("//"))
        .map(|it| format!("{} {}: {}", it.place, it.text, it.reason))
        .collect();
    assert_eq!(
        comments,
        [
            "model.asm:14 //@Within soon: its time is no positive number with the unit ms, s or min",
            "model.asm:18 //@Within 3 s: no property follows the comment",
        ]
    );
    let text = ROVER.replace("  CTLSPEC ag(estop", "  //@Within 1 s\n  CTLSPEC ag(estop");
    let rover = Watched::new(&text, &[]);
    let first = &rover.monitors.unwatched()[0];
    assert!(
        first
            .reason
            .starts_with("a time limits what follows a cause")
    );
}

#[test]
fn a_property_from_outside_is_watched() {
    let given = GivenProperty {
        text: "g(not waiting)".to_owned(),
        within_ns: None,
    };
    let mut rover = Watched::new(ROVER, &[given]);
    assert_eq!(rover.step(0, [false, true]), ["!g(not waiting)"]);
    let unknown = GivenProperty {
        text: "ag(nowhere)".to_owned(),
        within_ns: None,
    };
    assert!(Monitors::of(&mut open(ROVER), &[unknown]).is_err());
}

#[test]
fn a_state_continues_where_it_was_taken() {
    let mut rover = Watched::new(ROVER, &[]);
    rover.step(0, [false, true]);
    let state = rover.monitors.state();
    let mut other = Watched::new(ROVER, &[]);
    other.machine = rover.machine.clone();
    assert!(other.monitors.restore(&state));
    assert_eq!(other.monitors.state(), state);
    assert_eq!(
        rover.step(2 * SECOND, [true, true]),
        other.step(2 * SECOND, [true, true])
    );
    assert_eq!(rover.monitors.state(), other.monitors.state());
    assert!(!other.monitors.restore(&MonitorsState::default()));
}

#[test]
fn what_nothing_changes_is_not_evaluated_again() {
    // the same verdicts as if everything had changed, with a closure that says what has
    let mut all = Watched::new(ROVER, &[]);
    let mut few = Watched::new(ROVER, &[]);
    let mut last = None;
    for step in 0..200_i64 {
        let inputs = [step / 7 % 3 == 0, step / 5 % 2 == 0];
        let expected = all.step(step * SECOND / 4, inputs);
        let mut environment = Inputs(&few.specification, inputs);
        let is_same = last == Some(inputs);
        let (machine, monitors) = (&mut few.machine, &mut few.monitors);
        let now_ns = step * SECOND / 4;
        let mut found = monitors.before_step(machine, &mut environment, now_ns, &|_| !is_same);
        machine
            .step(&mut environment, &mut FirstChoice, now_ns)
            .unwrap();
        found.extend(monitors.after_step(machine, now_ns));
        monitors.end_step();
        assert_eq!(found.len(), expected.len(), "{step}");
        assert_eq!(all.monitors.state(), few.monitors.state(), "{step}");
        last = Some(inputs);
    }
    assert!(all.monitors.violated_steps(0) > 10);
}
