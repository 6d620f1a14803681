//! Values that a chooser picks for the variables of a `choose`: a value in the range is taken, any other is a fault.

use crate::support::opened;
use asmotion_lang::ir::Origin;
use asmotion_lang::value::{Atom, Real, RuleId};
use asmotion_lang::{Chooser, FaultKind, Machine, NoInputs, Value};
use std::cell::RefCell;
use std::sync::Arc;

/// Picks the values of ranges, in the order in which the step first asks for them.
#[derive(Default)]
struct Picks {
    values: Vec<Option<Value>>,
    asked: RefCell<Vec<Origin>>,
    /// Numbers of candidates among which the chooser selected.
    counts: Vec<usize>,
    /// Index of the selected candidate.
    index: usize,
}

impl Picks {
    fn of(values: impl IntoIterator<Item = Option<Value>>) -> Self {
        Self {
            values: values.into_iter().collect(),
            ..Self::default()
        }
    }
}

impl Chooser for Picks {
    fn choose(&mut self, count: usize) -> usize {
        self.counts.push(count);
        self.index
    }

    fn picked(&self, range: Origin) -> Option<Value> {
        let mut asked = self.asked.borrow_mut();
        let known = asked.iter().position(|it| *it == range);
        let index = known.unwrap_or_else(|| {
            asked.push(range);
            asked.len() - 1
        });
        self.values.get(index).cloned().flatten()
    }
}

/// A machine that chooses a value of a domain.
fn machine(domain: &str) -> Machine {
    let text = format!(
        "asm picks
import StandardLibrary
signature:
  enum domain Before = {{BEFORE}}
  enum domain Side = {{LEFT | RIGHT}}
  enum domain Behind = {{BEHIND}}
  abstract domain Item
  domain Small subsetof Integer
  domain Odd subsetof Integer
  static one: Item
  controlled x: {domain}
definitions:
  domain Small = {{1 : 3}}
  domain Odd = {{$n in {{0 : 9}} | $n mod 2 = 1 : $n}}
  main rule r_Main = choose $v in {domain} with true do x := $v
"
    );
    opened("picks", &text).machine().unwrap()
}

/// Makes a step in which the chooser picks this value. Returns the value of the update.
fn taken(domain: &str, value: &Value) -> Result<Value, FaultKind> {
    let mut machine = machine(domain);
    let mut picks = Picks::of([Some(value.clone())]);
    match machine.step(&mut NoInputs, &mut picks, 0) {
        Ok(step) => Ok(step.updates()[0].value.clone()),
        Err(fault) => Err(fault.kind),
    }
}

fn ints(numbers: &[i64]) -> Vec<Value> {
    numbers.iter().map(|number| Value::Int(*number)).collect()
}

/// Domains, values in them, and values that are not.
fn cases() -> Vec<(&'static str, Vec<Value>, Vec<Value>)> {
    let int = Value::Int;
    let atom = |number| Value::Atom(Atom(number));
    let (truth, text) = (Value::Bool(true), Value::text("a"));
    let (seq, set, bag) = (
        |numbers: &[i64]| Value::seq(ints(numbers)),
        |numbers: &[i64]| Value::set(ints(numbers)),
        |numbers: &[i64]| Value::bag(ints(numbers)),
    );
    let map = |key: Value, value: Value| Value::map([(key, value)]);
    let pair = |left: Value, right: Value| Value::tuple([left, right]);
    let complex = Value::Complex(Arc::new((Real::new(0.0), Real::new(1.0))));
    vec![
        (
            "Boolean",
            vec![Value::Bool(false), truth.clone()],
            vec![int(1)],
        ),
        ("Small", ints(&[1, 3]), vec![int(0), int(4), text.clone()]),
        (
            "Integer",
            ints(&[0, -7, 1 << 40]),
            vec![Value::real(1.0), text.clone()],
        ),
        ("Natural", ints(&[0, 7]), vec![int(-1), Value::real(1.0)]),
        (
            "Real",
            vec![Value::real(-0.5), Value::real(7.0)],
            vec![int(1), text.clone()],
        ),
        (
            "Side",
            vec![atom(1), atom(2)],
            vec![atom(0), atom(3), int(1)],
        ),
        ("Odd", ints(&[1, 9]), ints(&[2, 11])),
        ("Item", vec![atom(4)], vec![atom(1), int(4)]),
        (
            "Prod(Boolean, Small)",
            vec![pair(truth.clone(), int(1))],
            vec![
                pair(int(1), int(1)),
                pair(truth.clone(), int(4)),
                Value::tuple([truth.clone()]),
                Value::tuple([truth.clone(), int(1), int(1)]),
                int(1),
            ],
        ),
        (
            "Powerset(Small)",
            vec![set(&[]), set(&[1, 3])],
            vec![set(&[1, 4]), seq(&[1])],
        ),
        (
            "Seq(Odd)",
            vec![seq(&[]), seq(&[3, 3])],
            vec![seq(&[3, 4]), set(&[3])],
        ),
        (
            "Bag(Odd)",
            vec![bag(&[]), bag(&[3, 3, 5])],
            vec![bag(&[3, 4]), seq(&[3])],
        ),
        (
            "Map(Small, Odd)",
            vec![map(int(2), int(5))],
            vec![map(int(4), int(5)), map(int(2), int(4)), int(2)],
        ),
        (
            "Seq(Boolean)",
            vec![Value::seq([truth.clone()])],
            vec![seq(&[1])],
        ),
        (
            "Seq(Integer)",
            vec![seq(&[-1])],
            vec![Value::seq([text.clone()])],
        ),
        (
            "Seq(Natural)",
            vec![seq(&[0])],
            vec![seq(&[-1]), Value::seq([text.clone()])],
        ),
        (
            "Seq(Real)",
            vec![Value::seq([Value::real(0.5)])],
            vec![seq(&[1])],
        ),
        (
            "Seq(Char)",
            vec![Value::seq([Value::Char('a')])],
            vec![Value::seq([text.clone()])],
        ),
        (
            "Seq(String)",
            vec![Value::seq([text.clone()])],
            vec![Value::seq([Value::Char('a')])],
        ),
        (
            "Seq(Complex)",
            vec![Value::seq([complex])],
            vec![Value::seq([Value::real(0.5)])],
        ),
        (
            "Seq(Rule)",
            vec![Value::seq([Value::Rule(RuleId(0))])],
            vec![seq(&[0])],
        ),
        ("Seq(Any)", vec![Value::seq([int(1), text])], vec![int(1)]),
        (
            "Seq(Prod(Odd, Powerset(Small)))",
            vec![Value::seq([pair(int(1), set(&[1]))])],
            vec![
                Value::seq([pair(int(1), set(&[4]))]),
                Value::seq([pair(int(2), set(&[1]))]),
            ],
        ),
    ]
}

#[test]
fn are_taken_if_they_are_in_the_range() {
    for (domain, within, outside) in cases() {
        for value in within {
            assert_eq!(taken(domain, &value), Ok(value), "{domain}");
        }
        for value in outside {
            let picked = vec![value.clone()];
            let fault = FaultKind::NoCandidate(picked);
            assert_eq!(taken(domain, &value), Err(fault), "{domain}");
        }
    }
}

#[test]
fn of_some_variables_leave_the_others_to_the_chooser() {
    let pairs = opened(
        "pairs",
        "asm pairs
import StandardLibrary
signature:
  domain Small subsetof Integer
  controlled x: Integer
  controlled y: Integer
definitions:
  domain Small = {1 : 4}
  main rule r_Main =
    choose $a in Small, $b in Small with $a < $b do par x := $a y := $b endpar
    ifnone x := 0
",
    );
    let made = |picks: &[Option<i64>], index: usize| {
        let mut machine = pairs.machine().unwrap();
        let mut picks = Picks::of(picks.iter().map(|it| it.map(Value::Int)));
        picks.index = index;
        let step = machine.step(&mut NoInputs, &mut picks, 0);
        let made = step.map(|step| {
            let values = step.updates().iter().map(|update| update.value.clone());
            values.collect::<Vec<_>>()
        });
        (made.map_err(|fault| fault.kind), picks.counts)
    };
    // 1 < 2, 3, 4
    assert_eq!(made(&[Some(1), None], 1), (Ok(ints(&[1, 3])), vec![3]));
    // 1, 2 < 3
    assert_eq!(made(&[None, Some(3)], 0), (Ok(ints(&[1, 3])), vec![2]));
    assert_eq!(made(&[None, Some(3)], 9), (Ok(ints(&[2, 3])), vec![2]));
    assert_eq!(made(&[Some(2), Some(3)], 0), (Ok(ints(&[2, 3])), vec![1]));
    // without a pick: all six pairs
    assert_eq!(made(&[], 3), (Ok(ints(&[2, 3])), vec![6]));
    // candidates are required by the guard and the ranges
    for (picks, values) in [
        ([Some(4), None], vec![4]),
        ([Some(3), Some(2)], vec![3, 2]),
        ([Some(5), None], vec![5]),
    ] {
        let fault = FaultKind::NoCandidate(ints(&values));
        assert_eq!(made(&picks, 0), (Err(fault), Vec::new()), "{picks:?}");
    }
}

#[test]
fn are_repeated_when_a_fault_is_explained() {
    let machine = opened(
        "clash",
        "asm clash
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = choose $a in {1 : 4} with true do par x := $a x := 3 endpar
",
    );
    let mut machine = machine.machine().unwrap();
    let mut picks = Picks::of([Some(Value::Int(2))]);
    let fault = machine.step(&mut NoInputs, &mut picks, 0).map(|_| ());
    let witness = machine.witness(&fault.unwrap_err()).unwrap();
    let reads = witness.path.iter().flat_map(|entry| entry.reads.values());
    assert!(!witness.first.is_empty() || reads.count() > 0);
}
