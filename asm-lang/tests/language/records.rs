//! The record of a step contains what happened in that step, and nothing of the steps before it.

use asmotion_lang::ir::FunctionId;
use asmotion_lang::simulate::Seeded;
use asmotion_lang::{Chooser, Environment, Machine, Value};

/// Rules that each leave something in the record of a step.
const ACTIONS: [&str; 5] = [
    "if asked > 0 then noted := asked endif",
    "printed := print(\"now\")",
    "r_wsend[a, \"tell\", 1]",
    "r_wreceive[a, \"tell\", got]",
    "choose $i in {1 : 3} with true do drawn := $i",
];

/// Answers every input with 1.
struct One;

impl Environment for One {
    fn read(&mut self, _: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        Ok(arguments.is_empty().then_some(Value::Int(1)))
    }
}

/// A specification that does some of the actions in its first and third step, and is ready for them after the others.
fn specification(actions: &[&str]) -> String {
    format!(
        "asm records
import StandardLibrary
import CommonBehavior
signature:
  domain Peer subsetof Agent
  static a: Peer
  monitored asked: Integer
  controlled round: Integer
  controlled noted: Integer
  controlled printed: Integer
  controlled got: Integer
  controlled drawn: Integer
definitions:
  main rule r_Main = par
    round := round + 1
    if round = 0 or round = 2 then par
      {}
    endpar else
      status(self) := READY
    endif
  endpar
default init s0:
  function round = 0
",
        actions.join("\n      ")
    )
}

/// Returns the numbers of inputs, texts, messages, choices, candidates and updates of the last step.
fn sizes(machine: &Machine) -> [usize; 6] {
    let step = machine.last_step();
    [
        step.inputs().len(),
        step.printed().len(),
        step.sent().len(),
        step.choices().len(),
        step.candidates().len(),
        step.updates().len(),
    ]
}

#[test]
fn has_nothing_of_the_steps_before() {
    for chosen in 1..1_usize << ACTIONS.len() {
        let is_chosen = |action: usize| chosen >> action & 1 == 1;
        let actions = (0..ACTIONS.len()).filter(|it| is_chosen(*it));
        let actions: Vec<&str> = actions.map(|it| ACTIONS[it]).collect();
        let opened = super::opened("records", &specification(&actions));
        let mut machine = opened.machine().unwrap();
        machine.keep_candidates();
        let mut choices = Seeded::new(1);
        let mut found = Vec::new();
        for now in 0..4 {
            machine.step(&mut One, &mut choices, now).unwrap();
            found.push(sizes(&machine));
        }
        assert_eq!(found[1], [0, 0, 0, 0, 0, 2], "after {actions:?}");
        assert_eq!(found[3], [0, 0, 0, 0, 0, 2], "after {actions:?}");
        let has = |action| usize::from(is_chosen(action));
        let recorded = [has(0), has(1), has(2), has(4), has(4)];
        assert_eq!(found[0][..5], recorded, "{actions:?}");
        assert_eq!(found[2][..5], recorded, "{actions:?}");
    }
}

#[test]
fn of_a_copy_of_a_machine_has_what_that_of_the_machine_has() {
    let opened = super::opened("records", &specification(&ACTIONS));
    let mut machine = opened.machine().unwrap();
    machine.keep_candidates();
    let mut copy = machine.clone();
    for machine in [&mut machine, &mut copy] {
        machine.step(&mut One, &mut Seeded::new(1), 0).unwrap();
    }
    assert_eq!(sizes(&copy), sizes(&machine));
    // a copy begins without the record of the machine's last step
    assert_eq!(sizes(&machine.clone()), [0; 6]);
    let (one, other) = (machine.last_step(), copy.last_step());
    assert_eq!(one.candidates().len(), 1);
    assert_eq!(one.candidates(), other.candidates());
}

/// Takes the candidate with this index in every choice.
struct Index(usize);

impl Chooser for Index {
    fn choose(&mut self, _count: usize) -> usize {
        self.0
    }
}

#[test]
fn is_sufficient_to_repeat_a_failed_step() {
    let opened = super::opened(
        "failing",
        "asm failing
import StandardLibrary
signature:
  monitored asked: Integer
  controlled x: Integer
definitions:
  main rule r_Main =
    choose $i in {1 : 3} with $i <= asked + 2 do par
      x := $i
      if $i > 1 then x := 1 endif
    endpar
",
    );
    for (index, is_failing) in [(0, false), (1, true), (2, true)] {
        let before = opened.machine().unwrap();
        let mut machine = before.clone();
        let step = machine.step(&mut One, &mut Index(index), 0);
        let fault = step.map(|_| ()).err();
        assert_eq!(fault.is_some(), is_failing, "{index}");
        if let Some(fault) = fault {
            let witness = machine.witness(&fault).unwrap();
            let reads = witness.path.iter().flat_map(|entry| entry.reads.values());
            let chosen = Value::Int(index as i64 + 1);
            assert!(reads.into_iter().any(|read| *read == chosen), "{index}");
            assert!(!witness.first.is_empty());
        } else {
            let account = machine.account(&before).unwrap();
            let (update, path) = &account.updates[0];
            assert_eq!(machine.last_step().updates(), std::slice::from_ref(update));
            assert!(!path.is_empty());
        }
    }
}

#[test]
fn of_a_restored_state_is_empty() {
    let opened = super::opened("records", &specification(&ACTIONS));
    let mut machine = opened.machine().unwrap();
    machine.keep_candidates();
    let snapshot = machine.snapshot();
    machine.step(&mut One, &mut Seeded::new(1), 0).unwrap();
    assert_ne!(sizes(&machine), [0; 6]);
    machine.restore(&snapshot).unwrap();
    assert_eq!(sizes(&machine), [0; 6]);
}
