//! One mistake, one message: what the parser skips or loses because of an error is not reported as further errors.

use crate::support::open;
use asmotion_lang::Severity;

/// Rules with a place for another rule.
const OUTER: &[(&str, &str)] = &[
    (
        "first case",
        "switch s\n case A:\n RULE\n case B: n := 2\n endswitch",
    ),
    (
        "last case",
        "switch s\n case B: n := 2\n case A:\n RULE\n endswitch",
    ),
    (
        "otherwise",
        "switch s\n case B: n := 2\n otherwise\n RULE\n endswitch",
    ),
    ("par", "par\n n := 1\n RULE\n m := 2\n endpar"),
    ("end of par", "par\n n := 1\n RULE\n endpar"),
    ("seq", "seq\n n := 1\n RULE\n m := 2\n endseq"),
    ("iterate", "iterate\n RULE\n enditerate"),
    ("forall", "forall $i in {1 : 3} do\n RULE"),
    ("choose", "choose $i in {1 : 3} do\n RULE\n ifnone m := 3"),
    ("while", "while n < 3 do\n RULE"),
    ("then", "if n = 1 then\n RULE\n else\n m := 3\n endif"),
    ("else", "if n = 1 then\n m := 3\n else\n RULE\n endif"),
    ("let", "let ($z = 1) in\n RULE\n endlet"),
    (
        "switch in par",
        "par\n switch s\n case A:\n RULE\n case B: n := 2\n endswitch\n m := 4\n endpar",
    ),
];

/// Rules with one mistake.
const MISTAKES: &[(&str, &str)] = &[
    (
        "let without brackets and $",
        "let x = n + 1 in\n m := x\n endlet",
    ),
    (
        "let without brackets",
        "let $x = n + 1 in\n m := $x\n endlet",
    ),
    ("let in a line", "let $x = n + 1 in m := $x endlet"),
    (
        "let with par",
        "let $x = n + 1 in\n par m := $x n := $x endpar\n endlet",
    ),
    (
        "let with if",
        "let $x = n + 1 in\n if $x = 1 then m := $x endif\n endlet",
    ),
    (
        "let of two",
        "let $x = n + 1, $y = 2 in\n m := $x + $y\n endlet",
    ),
    ("let without value", "let ($x) in m := 1 endlet"),
    ("let without in", "let ($x = n)\n m := $x\n endlet"),
    ("let in a term", "m := let $x = 1 in $x endlet"),
    ("no endif", "if n = 1 then\n m := 1"),
    ("no endlet", "let ($x = n) in\n m := $x"),
    ("no endpar", "par\n m := 1\n n := 1"),
    ("no endseq", "seq\n m := 1\n n := 1"),
    ("no endswitch", "switch n\n case 1: m := 1"),
    ("no endif in a term", "m := if n = 1 then 2 else 3"),
    ("no then", "if n = 1\n m := 1\n endif"),
    (
        "no then, with else",
        "if n = 1\n m := 1\n else m := 2 endif",
    ),
    ("no do", "forall $i in {1 : 3} with $i > 1\n m := $i"),
    ("no colon of a case", "switch n\n case 1 m := 1\n endswitch"),
    ("no value", "m :="),
    ("no operand", "m := n +"),
    ("stray )", "m := (n + 1))"),
    ("stray ) in a guard", "if (n = 1)) then\n m := 1\n endif"),
    ("stray ]", "r_x[]]"),
    ("no )", "m := (n + 1"),
    ("no }", "q := {1, 2"),
    (
        "quantifier without brackets",
        "if exist $i in {1 : 3} with $i = n then m := 1 endif",
    ),
];

/// The codes of the errors in a specification whose main rule is this one.
fn errors(rule: &str) -> Vec<String> {
    let text = format!(
        "asm recovery
import StandardLibrary
signature:
  enum domain State = {{A | B}}
  controlled s: State
  controlled n: Integer
  controlled m: Integer
  controlled q: Powerset(Integer)
definitions:
  rule r_x = n := 3
  main rule r_Main =
  {rule}
default init s0:
  function s = A
  function n = 0
  function m = 0
  function q = {{}}
"
    );
    let report = match open("recovery", &text) {
        Ok(specification) => specification.report,
        Err(failure) => failure.report,
    };
    let errors = report.diagnostics.iter();
    let errors = errors.filter(|it| it.severity == Severity::Error);
    errors.map(|it| it.code.to_string()).collect()
}

#[test]
fn a_mistake_gives_one_message_wherever_it_is() {
    let mut wrong = Vec::new();
    for (place, outer) in OUTER {
        assert_eq!(errors(&outer.replace("RULE", "skip")), [""; 0], "{place}");
        for (mistake, rule) in MISTAKES {
            let found = errors(&outer.replace("RULE", rule));
            if found.len() != 1 {
                wrong.push(format!("{mistake}, in {place}: {found:?}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn two_mistakes_in_two_rules_are_two_messages() {
    let text = "par\n let $x = 1 in m := $x endlet\n n := (2 +\n endpar";
    assert_eq!(errors(text).first().map(String::as_str), Some("L065"));
    // an unknown variable is one of its own in a rule without other errors
    assert_eq!(errors("par\n m := $y\n endpar"), ["A002"]);
    assert_eq!(errors("par\n n\n endpar"), ["A028"]);
}
