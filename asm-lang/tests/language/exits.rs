//! Exits of control states: without one, no step leaves the state.

use asmotion_lang::value::{Atom, Value};

const HEAD: &str = "asm lamp
import StandardLibrary
signature:
  enum domain Mode = {OFF | ON | BROKEN}
  monitored press: Boolean
  controlled mode: Mode
  controlled n: Integer
definitions:
";

/// The literals of `mode` that a rule may leave.
fn left(rules: &str) -> Vec<String> {
    let text = format!("{HEAD}{rules}\ndefault init s0:\n  function mode = OFF\n");
    let specification = super::opened("lamp", &text);
    let model = &specification.model;
    let mut functions = model.own_functions();
    let (mode, _) = functions.find(|(_, it)| &*it.name == "mode").unwrap();
    let atoms = (0..).map(Atom).zip(&model.atoms);
    let literals = atoms.filter(|(_, atom)| ["OFF", "ON", "BROKEN"].contains(&&*atom.name));
    literals
        .filter(|(atom, _)| model.has_exit(mode, &Value::Atom(*atom)))
        .map(|(_, atom)| atom.name.to_string())
        .collect()
}

#[test]
fn a_state_is_left_by_an_update_under_a_condition_that_allows_it() {
    assert_eq!(
        left("main rule r_Main = if mode = OFF then mode := ON endif"),
        ["OFF"]
    );
    assert_eq!(
        left("main rule r_Main = if mode != OFF and press then mode := OFF endif"),
        ["ON", "BROKEN"]
    );
    let negated = "main rule r_Main = if not (mode = ON or mode = BROKEN) then mode := ON endif";
    assert_eq!(left(negated), ["OFF"]);
    let other = "main rule r_Main = if press then mode := BROKEN else n := 1 endif";
    assert_eq!(left(other), ["OFF", "ON"]);
    assert_eq!(left("main rule r_Main = n := n + 1"), [""; 0]);
}

#[test]
fn cases_calls_and_sequences_are_followed() {
    let switch = "main rule r_Main =
  switch mode
    case OFF: mode := ON
    case ON: if press then mode := ON endif
    otherwise n := 2
  endswitch";
    assert_eq!(left(switch), ["OFF"]);
    let called = "macro rule r_enter($m in Mode) = mode := $m
  rule r_on = r_enter[OFF]
  main rule r_Main = seq if mode = ON then r_on[] endif n := 1 endseq";
    assert_eq!(left(called), ["ON"]);
    let chosen = "main rule r_Main = choose $m in Mode with $m != mode do if mode = BROKEN then mode := $m endif";
    assert_eq!(left(chosen), ["BROKEN"]);
}
