//! A specification may have several initial states; the default one is used unless another is
//! requested.

use asmotion_lang::ir::FunctionId;
use asmotion_lang::{Environment, FirstChoice, Machine, MemoryFiles, ReadOptions, Value};

const TEXT: &str = "asm several
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = x := x + 1
init low:
  function x = 1
default init middle:
  function x = 5
init high:
  function x = 9
";

fn begins_with(initial: Option<&str>) -> Result<String, String> {
    let mut files = MemoryFiles::new();
    files.add("several.asm", TEXT);
    let options = ReadOptions {
        compatible: false,
        initial: initial.map(str::to_owned),
    };
    let specification = asmotion_lang::open_with("several.asm", &files, &options)
        .map_err(|failure| failure.report.diagnostics[0].message.clone())?;
    let machine = specification
        .machine()
        .map_err(|fault| format!("{fault:?}"))?;
    let x = specification.function("x", 0).ok_or("no x")?;
    let slot = machine
        .state()
        .slot(machine.program(), x, &[])
        .ok_or("no slot")?;
    let value = machine.state().get(slot);
    Ok(value.show(&machine.naming()).to_string())
}

#[test]
fn the_default_one_counts() {
    assert_eq!(begins_with(None), Ok("5".to_owned()));
}

#[test]
fn another_one_counts_where_it_is_asked_for() {
    assert_eq!(begins_with(Some("low")), Ok("1".to_owned()));
    assert_eq!(begins_with(Some("high")), Ok("9".to_owned()));
}

#[test]
fn one_that_is_not_there_is_missed() {
    let missed = "no initial state is called `lower`";
    assert_eq!(begins_with(Some("lower")), Err(missed.to_owned()));
}

/// Returns the initial values outside their domains, before the first step and after it.
fn misfits(text: &str, m: i64) -> [Vec<(Vec<Value>, Value)>; 2] {
    let mut machine = super::opened("misfits", text).machine().unwrap();
    let found = |machine: &Machine| {
        let found = machine.initial_misfits().into_iter();
        let found = found.map(|it| (it.arguments, it.misfit.part));
        found.collect::<Vec<_>>()
    };
    let before = found(&machine);
    let step = machine.step(&mut Given(m), &mut FirstChoice, 0);
    step.unwrap();
    [before, found(&machine)]
}

/// Gives every input this value.
struct Given(i64);

impl Environment for Given {
    fn read(&mut self, _: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        // only `m`, without arguments, is an input
        assert_eq!(arguments, []);
        Ok(Some(Value::Int(self.0)))
    }
}

/// A program with a domain of the numbers 0 to 3, and one of those up to an input.
fn with_small(signature: &str, rule: &str, initial: &str) -> String {
    format!(
        "asm misfits
import StandardLibrary
signature:
  domain Small subsetof Integer
  domain Upto subsetof Integer
  monitored m: Integer
  controlled n: Integer
  {signature}
definitions:
  domain Small = {{0 : 3}}
  domain Upto = {{0 : m}}
  main rule r_Main = {rule}
default init s0:
  function n = 0
  {initial}
"
    )
}

#[test]
fn a_value_outside_its_domain_is_found_once_it_is_known() {
    let int = Value::Int;
    let at = |argument: i64, part: i64| vec![(vec![int(argument)], int(part))];
    let part = |part: i64| vec![(Vec::new(), int(part))];
    // signature, rule, initial values; misfits before and after a step with the input 5
    type Found = Vec<(Vec<Value>, Value)>;
    let cases: [(&str, &str, &str, Found, Found); 11] = [
        (
            "controlled x: Small",
            "skip",
            "function x = 3",
            vec![],
            vec![],
        ),
        (
            "controlled x: Small",
            "skip",
            "function x = 4",
            part(4),
            part(4),
        ),
        ("controlled x: Small", "skip", "", vec![], vec![]),
        // a later value is no initial value
        (
            "controlled x: Small",
            "x := 1",
            "function x = 4",
            part(4),
            part(4),
        ),
        // of a function, the first location
        (
            "controlled f: Small -> Small",
            "skip",
            "function f($s in Small) = $s + 2",
            at(2, 4),
            at(2, 4),
        ),
        (
            "controlled x: Bag(Small)",
            "skip",
            "function x = <1, 7, 7>",
            part(7),
            part(7),
        ),
        (
            "controlled x: Map(Small, Prod(Integer, Small))",
            "skip",
            "function x = {1 -> (9, 8)}",
            part(8),
            part(8),
        ),
        // before the first step, the input is not known
        (
            "controlled x: Small",
            "skip",
            "function x = m",
            vec![],
            part(5),
        ),
        (
            "controlled x: Upto",
            "skip",
            "function x = 5",
            vec![],
            vec![],
        ),
        (
            "controlled x: Upto",
            "skip",
            "function x = 6",
            vec![],
            part(6),
        ),
        // a location that is first accessed in the step
        (
            "controlled g: Integer -> Small",
            "n := g(7)",
            "function g($i in Integer) = $i",
            vec![],
            at(7, 7),
        ),
    ];
    for (signature, rule, initial, before, after) in cases {
        let found = misfits(&with_small(signature, rule, initial), 5);
        assert_eq!(found, [before, after], "{signature} {rule} {initial}");
    }
}

#[test]
fn the_inputs_of_the_first_step_belong_to_it_for_good() {
    // `copy` is first accessed when `kept` has changed
    let text = "asm provided
import StandardLibrary
signature:
  domain Few subsetof Integer
  monitored m: Integer
  shared kept: Integer -> Integer
  shared few: Few -> Integer
  controlled copy: Integer -> Integer
  controlled fewCopy: Few -> Integer
  controlled n: Integer
  controlled x: Integer
  controlled y: Integer
  controlled z: Integer
definitions:
  domain Few = {1 : 2}
  main rule r_Main = par
    n := n + 1
    if n = 0 then x := kept(1) + kept(2) + kept(3) + few(1) endif
    if n = 1 then par kept(1) := 100 few(1) := 100 endpar endif
    if n = 2 then par x := copy(1) y := fewCopy(1) z := copy(3) endpar endif
  endpar
default init s0:
  function n = 0
  function kept($i in Integer) = if $i = 2 then 5 else 0 endif
  function copy($i in Integer) = kept($i)
  function fewCopy($i in Few) = few($i)
";
    let specification = super::opened("provided", text);
    /// Answers in the first step only.
    struct First(bool);
    impl Environment for First {
        fn read(&mut self, _: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
            let two = arguments.first() == Some(&Value::Int(2));
            Ok(self.0.then_some(Value::Int(if two { 5 } else { 3 })))
        }
    }
    let step = |machine: &mut Machine| {
        let is_first = machine.value_at(specification.function("n", 0).unwrap(), &[]);
        let mut inputs = First(is_first == Value::Int(0));
        machine
            .step(&mut inputs, &mut FirstChoice, 0)
            .unwrap_or_else(|fault| panic!("{fault:?}"));
        asmotion_lang::simulate::state(machine)
    };
    // restored from a snapshot, from a packed state, or not at all
    for (restored_after, is_packed) in [(1, false), (1, true), (2, false), (2, true), (3, false)] {
        let mut machine = specification.machine().unwrap();
        let mut state = Vec::new();
        for number in 1..=3 {
            if number > restored_after {
                let snapshot = machine.snapshot();
                machine = specification.machine().unwrap();
                if is_packed {
                    machine.restore_state(snapshot.state().as_bytes()).unwrap();
                } else {
                    machine.restore(&snapshot).unwrap();
                }
            }
            state = step(&mut machine);
        }
        let value = |name: &str| {
            let found = state.iter().find(|(location, _)| location == name);
            found.map(|(_, value)| value.as_str())
        };
        let found = ["x", "y", "z"].map(value);
        assert_eq!(
            found,
            [Some("3"); 3],
            "restored after {restored_after}: {state:?}"
        );
    }
}

#[test]
fn an_input_that_equals_the_initial_value_makes_no_difference() {
    let text = "asm provided
import StandardLibrary
signature:
  monitored m: Boolean
  shared kept: Integer -> Integer
  controlled x: Integer
definitions:
  main rule r_Main = if m then x := kept(2) else x := 5 endif
default init s0:
  function kept($i in Integer) = 5
";
    let specification = super::opened("provided", text);
    struct Asked(bool);
    impl Environment for Asked {
        fn read(&mut self, _: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
            let answer = match arguments {
                [] => Value::Bool(self.0),
                _ => Value::Int(5),
            };
            Ok(Some(answer))
        }
    }
    let [asked, unasked] = [true, false].map(|is_asked| {
        let mut machine = specification.machine().unwrap();
        let step = machine.step(&mut Asked(is_asked), &mut FirstChoice, 0);
        step.unwrap();
        machine.snapshot().into_state()
    });
    assert_eq!(asked, unasked);
}
