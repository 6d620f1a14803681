//! Inputs without a finite domain that are only compared: a few values stand for all.

use crate::{open, refused, verdicts, verified};
use asmotion_lang::Value;
use asmotion_lang::ir::FunctionId;
use asmotion_verify::{Options, Verification, verify};
use std::fmt::Write;

/// The inputs with their values, as `distance: 4 (all below 5), 5, 6 (all above 5)`.
fn represented(verification: &Verification) -> Vec<String> {
    let inputs = verification.represented.iter();
    let described = inputs.map(|input| {
        let values = input.values.iter().map(|it| match &it.stands_for {
            Some(others) => format!("{} ({others})", it.value),
            None => it.value.clone(),
        });
        format!(
            "{}: {}",
            input.function,
            values.collect::<Vec<String>>().join(", ")
        )
    });
    described.collect()
}

const APPROACH: &str = "asm approach
import StandardLibrary
import CTLLibrary
signature:
  domain Level subsetof Integer
  monitored distance: Integer
  monitored battery: Real
  monitored word: String
  monitored faster: Boolean
  controlled limit: Integer
  controlled level: Level
  controlled isNear: Boolean
  controlled goes: Boolean
  derived isClose: Integer -> Boolean
definitions:
  domain Level = {0:2}
  function isClose($d in Integer) = $d <= limit
  macro rule r_Measure($d in Integer) =
    let ($seen = $d) in isNear := if $seen > 40 then false else isClose($seen) endif endlet
  CTLSPEC near: ag(distance = 7 implies ax(isNear))
  CTLSPEC far: ag(distance > limit implies ax(not isNear))
  CTLSPEC low: ag(battery < 0.25 implies ax(not goes))
  main rule r_Main = par
    r_Measure[distance]
    if faster and level < 2 then level := level + 1 endif
    if faster then limit := 10 else limit := 5 endif
    switch word
      case \"go\": goes := battery >= 0.25
      case \"stop\": goes := false
    endswitch
  endpar
default init s0:
  function limit = 5
  function level = 0
  function isNear = false
  function goes = false
";

#[test]
fn an_input_that_is_only_compared_has_a_value_for_each_region() {
    let verification = verified(APPROACH, &Options::default());
    assert_eq!(
        represented(&verification),
        [
            "distance: 4 (all below 5), 5, 6, 7, 8 (all between 7 and 10), 10, 11 (all between 10 and 40), 40, 41 (all above 40)",
            "battery: -0.75 (all below 0.25), 0.25, 1.25 (all above 0.25)",
            "word: \"go\", \"stop\", \"other\" (all others)",
        ]
    );
    let verdicts = verdicts(&verification);
    let of = |name: &str| verdicts.iter().find(|it| it.0 == name).unwrap().1;
    // 7 is near only with the greater limit
    assert_eq!(of("near"), "violated");
    assert_eq!(of("far"), "holds");
    assert_eq!(of("low"), "violated");
    let small = APPROACH
        .replace("distance: Integer", "distance: Distance")
        .replace(
            "  domain Level subsetof",
            "  domain Distance subsetof Integer\n  domain Level subsetof",
        )
        .replace(
            "  domain Level =",
            "  domain Distance = {3 : 50}\n  domain Level =",
        );
    let verification = verified(&small, &Options::default());
    assert_eq!(crate::verdicts(&verification), verdicts);
    assert_eq!(verification.represented.len(), 2);
}

#[test]
fn a_large_domain_is_represented_like_an_infinite_one() {
    let text = |domain: &str, codomain: &str| {
        format!(
            "asm large
import StandardLibrary
signature:
  {domain}
  monitored reading: {codomain}
  controlled isHigh: Boolean
definitions:
  {}
  invariant never over isHigh: not isHigh
  main rule r_Main = isHigh := reading > 1000000
default init s0:
  function isHigh = false
",
            domain.replace("subsetof Integer", "= {0 : 1099511627776}"),
        )
    };
    let bounded = verified(
        &text("domain Reading subsetof Integer", "Reading"),
        &Options::default(),
    );
    let endless = verified(&text("", "Natural"), &Options::default());
    let expected = "reading: 999999 (all below 1000000), 1000000, 1000001 (all above 1000000)";
    assert_eq!(
        represented(&bounded)[0].replace("n", ""),
        expected.replace("n", "")
    );
    assert_eq!(represented(&endless).len(), 1);
    for verification in [bounded, endless] {
        assert_eq!(verdicts(&verification)[0], ("never".to_owned(), "violated"));
    }
}

/// A specification whose input is used in one way.
fn used(usage: &str) -> String {
    format!(
        "asm used
import StandardLibrary
signature:
  monitored x: Integer
  monitored y: Natural
  controlled last: Integer
  controlled count: Integer
  controlled table: Integer -> Boolean
  controlled flag: Boolean
definitions:
  main rule r_Main = {usage}
default init s0:
  function count = 0
  function flag = false
"
    )
}

#[test]
fn an_input_whose_value_matters_is_refused_with_the_place() {
    let usages = [
        ("stored", "last := x"),
        ("computed", "flag := x + 1 > 5"),
        ("argument", "flag := isDef(table(x))"),
        ("updated_index", "table(x) := true"),
        ("two_inputs", "flag := x < y"),
        ("growing", "par flag := x < count count := count + 1 endpar"),
        ("collected", "flag := contains({1, 2}, x)"),
        (
            "stored_by_way_of_a_let",
            "let ($v = x) in if $v > 3 then last := $v endif endlet",
        ),
    ];
    let mut all = String::new();
    for (name, usage) in usages {
        let refusal = verify(open(&used(usage)), &Options::default(), &mut |_| true).unwrap_err();
        let codes: Vec<&str> = refusal
            .report
            .diagnostics
            .iter()
            .map(|it| it.code.name)
            .collect();
        assert_eq!(codes, ["M001"], "{name}");
        writeln!(all, "--- {name}\n{}", refused(&refusal)).unwrap();
    }
    insta::assert_snapshot!("needed_inputs", all);
}

#[test]
fn code_that_nothing_executes_makes_no_demands() {
    let text =
        used("flag := x > 3").replace("  main rule", "  rule r_Store = last := x\n  main rule");
    let verification = verified(&text, &Options::default());
    assert_eq!(
        represented(&verification),
        ["x: 2 (all below 3), 3, 4 (all above 3)"]
    );
    let unread = used("flag := not flag");
    assert!(
        verified(&unread, &Options::default())
            .represented
            .is_empty()
    );
}

#[test]
fn values_that_are_given_take_precedence() {
    let specification = open(&used("last := x"));
    let functions = &specification.model.functions;
    let x = functions.iter().position(|it| &*it.name == "x").unwrap();
    let options = Options {
        inputs: vec![asmotion_verify::InputValues {
            machine: 0,
            function: FunctionId(x as u32),
            values: vec![Value::Int(1), Value::Int(2)],
        }],
        ..Options::default()
    };
    let verification = verified(&used("last := x"), &options);
    assert!(verification.represented.is_empty());
    assert_eq!(verification.states, 3);
}

/// A sequence of pseudo-random numbers (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ mixed >> 31) % bound
    }

    fn one_of<'t>(&mut self, all: &[&'t str]) -> &'t str {
        all[self.below(all.len() as u64) as usize]
    }

    /// A number near 0, so that it and its neighbours are in the domain {-9 : 9}.
    fn constant(&mut self) -> i64 {
        self.below(9) as i64 - 4
    }

    fn other_side(&mut self) -> String {
        match self.below(5) {
            0 => "limit".to_owned(),
            1 => "limit + 1".to_owned(),
            2 => "level".to_owned(),
            3 => format!("(if flag then {} else limit endif)", self.constant()),
            _ => self.constant().to_string(),
        }
    }

    fn comparison(&mut self) -> String {
        let input = self.one_of(&["a", "a", "b"]);
        let sign = self.one_of(&["<", "<=", ">", ">=", "=", "!="]);
        let other = self.other_side();
        if self.below(2) == 0 {
            format!("{input} {sign} {other}")
        } else {
            format!("{other} {sign} {input}")
        }
    }

    fn condition(&mut self) -> String {
        let first = match self.below(4) {
            0 => format!(
                "(exists $k in {{{} : {}}} with $k = a)",
                self.constant() - 3,
                self.constant()
            ),
            1 => format!("within(b, {})", self.constant()),
            _ => self.comparison(),
        };
        match self.below(3) {
            0 => first,
            1 => format!("({first} and {})", self.comparison()),
            _ => format!("({first} or not ({}))", self.comparison()),
        }
    }

    fn rule(&mut self, depth: u64) -> String {
        match self.below(if depth == 0 { 3 } else { 6 }) {
            0 => format!("limit := {}", self.constant()),
            1 => "if level < 2 then level := level + 1 else level := 0 endif".to_owned(),
            2 => format!("flag := {}", self.condition()),
            3 => format!(
                "switch a case {}: {} case limit: {} otherwise skip endswitch",
                self.constant(),
                self.rule(depth - 1),
                self.rule(depth - 1),
            ),
            _ => format!(
                "if {} then {} else {} endif",
                self.condition(),
                self.rule(depth - 1),
                self.rule(depth - 1)
            ),
        }
    }

    fn property(&mut self) -> String {
        let (p, q) = (self.condition(), self.condition());
        match self.below(5) {
            0 => format!("ag({p} implies ax({q}))"),
            1 => format!("ag({p} implies ax(flag))"),
            2 => "ag(ef(level = 1))".to_owned(),
            3 => format!("af(flag or {p})"),
            _ => format!("eu(not flag, {q})"),
        }
    }

    fn specification(&mut self) -> String {
        let mut text = String::from(
            "asm random
import StandardLibrary
import CTLLibrary
signature:
  domain Level subsetof Integer
  domain Bounded subsetof Integer
  monitored a: INPUT
  monitored b: INPUT
  controlled limit: Integer
  controlled level: Level
  controlled flag: Boolean
  derived within: Prod(Integer, Integer) -> Boolean
definitions:
  domain Level = {0:2}
  domain Bounded = {-9:9}
  function within($v in Integer, $m in Integer) = $v >= $m and $v <= level
",
        );
        for index in 0..3 {
            writeln!(text, "  CTLSPEC p{index}: {}", self.property()).unwrap();
        }
        writeln!(text, "  main rule r_Main = par").unwrap();
        writeln!(text, "    {}\n    {}\n  endpar", self.rule(2), self.rule(2)).unwrap();
        text.push_str("default init s0:\n  function limit = 0\n  function level = 0\n  function flag = false\n");
        text
    }
}

#[test]
fn random_specifications_have_the_verdicts_of_an_explicit_domain() {
    let mut numbers = Numbers(2026);
    let (mut violated, mut held) = (0, 0);
    for round in 0..40 {
        let text = numbers.specification();
        let endless = verified(&text.replace("INPUT", "Integer"), &Options::default());
        let bounded = verified(&text.replace("INPUT", "Bounded"), &Options::default());
        assert!(bounded.represented.is_empty());
        assert_eq!(
            verdicts(&endless),
            verdicts(&bounded),
            "round {round}\n{text}"
        );
        assert_eq!(endless.states, bounded.states, "round {round}\n{text}");
        for property in &endless.properties {
            violated += usize::from(property.verdict.is_violated());
            held += usize::from(property.verdict.holds());
        }
    }
    assert!(violated > 20 && held > 20, "{violated} {held}");
}

/// Readings that are compared with each other and with a limit.
fn readings(
    codomain: &str,
    domain: &str,
    definition: &str,
    value: &dyn Fn(i64) -> String,
) -> String {
    let (five, seven) = (value(5), value(7));
    format!(
        "asm readings
import StandardLibrary
import CTLLibrary
signature:
  {domain}
  enum domain Which = {{NONE | FIRST | SECOND}}
  domain Side subsetof Integer
  monitored first: {codomain}
  monitored second: {codomain}
  monitored beside: Side -> {codomain}
  controlled greatest: Which
  controlled isSteep: Boolean
  derived above: Prod({codomain}, {codomain}) -> Boolean
definitions:
  {definition}
  domain Side = {{1:2}}
  function above($a in {codomain}, $b in {codomain}) = $a > $b
  CTLSPEC once: ag(greatest = FIRST implies ax(greatest != FIRST))
  CTLSPEC right: ag(first > second implies ax(greatest = FIRST))
  CTLSPEC wrong: ag(first > {five} implies ax(greatest = FIRST))
  CTLSPEC equal: ag(first = second implies ax(greatest = NONE))
  CTLSPEC within: ag((first > {five} and second > first and second < {seven}) implies ax(greatest != SECOND))
  CTLSPEC steep: ag(not isSteep)
  CTLSPEC flat: ag(beside(1) = beside(2) implies ax(not isSteep))
  CTLSPEC apart: ag(isSteep implies ag(isSteep))
  main rule r_Main = par
    if above(first, second) then greatest := FIRST
    else if above(second, first) then greatest := SECOND
    else greatest := NONE endif endif
    isSteep := (exist $s in Side, $t in Side with beside($s) > beside($t))
  endpar
default init s0:
  function greatest = NONE
  function isSteep = false
"
    )
}

/// Of all numbers, as many as there are inputs suffice in each region: these are the verdicts of a domain that has more.
#[test]
fn inputs_that_are_compared_with_each_other_have_values_in_every_order() {
    let whole = |number: i64| number.to_string();
    let small = readings(
        "Small",
        "domain Small subsetof Integer",
        "domain Small = {4 : 8}",
        &whole,
    );
    let expected = verdicts(&verified(&small, &Options::default()));
    let count = |verdict: &str| expected.iter().filter(|it| it.1 == verdict).count();
    assert!(
        count("holds") >= 3 && count("violated") >= 4,
        "{expected:?}"
    );
    let integers = verified(&readings("Integer", "", "", &whole), &Options::default());
    assert_eq!(verdicts(&integers), expected);
    let naturals = verified(
        &readings("Natural", "", "", &|it| format!("{it}n")),
        &Options::default(),
    );
    assert_eq!(verdicts(&naturals), expected);
    let real = |number: i64| format!("{number}.0");
    let reals = verified(&readings("Real", "", "", &real), &Options::default());
    // between 5 and 7 there is more than one
    let of = |verification: &Verification, name: &str| {
        let verdicts = verdicts(verification).into_iter();
        verdicts
            .filter(|it| it.0 == name)
            .map(|it| it.1)
            .collect::<Vec<_>>()
    };
    assert_eq!(of(&integers, "within"), ["holds"]);
    assert_eq!(of(&reals, "within"), ["violated"]);
    for (name, verdict) in expected.iter().filter(|it| it.0 != "within") {
        assert_eq!(of(&reals, name), [*verdict], "{name}");
    }
}

/// A held value would have to stay apart from all values that others get.
#[test]
fn inputs_that_are_held_are_not_compared_with_each_other() {
    let text = readings("Integer", "", "", &|it| it.to_string());
    let specification = open(&text);
    let system = asmotion_verify::SystemSpecification::of(specification)
        .with_environment(asmotion_verify::EnvironmentModel::Hold { changes: 1 });
    let refusal = asmotion_verify::verify_system(system, &Options::default(), &mut |_| true);
    let refusal = refusal.err().map(|it| refused(&it)).unwrap_or_default();
    assert!(refusal.contains("M001"), "{refusal}");
    assert!(refusal.contains("compared here with"), "{refusal}");
}

/// Equal elements of a set are one element: the inputs in a set have values in every order, also if no rule compares them.
#[test]
fn inputs_in_a_set_are_compared_with_each_other() {
    let text = |rule: &str| {
        format!(
            "asm sets
import StandardLibrary
signature:
  dynamic abstract domain Thing
  domain Side subsetof Integer
  monitored left: Integer
  monitored right: Integer
  monitored beside: Side -> Integer
  controlled n: Integer
  controlled started: Boolean
definitions:
  domain Side = {{1:2}}
  invariant few over started: not (exist $a in Thing, $b in Thing with $a != $b)
  invariant none over n: n != 3
  main rule r_Main = {rule}
default init s0:
  function n = 1
  function started = false
"
        )
    };
    let cases = [
        // two instances choose differently
        (
            "forall $x in {left, right} with $x > 5 do choose $y in {1, 2} with true do n := $y",
            "no step fails",
        ),
        (
            "if not started then par started := true forall $x in {left, right} with $x > 5 do extend Thing with $d do skip endpar endif",
            "few",
        ),
        (
            "if not (exist unique $x in {left, right} with $x > 5) and left > 5 and right > 5 then n := 3 endif",
            "none",
        ),
        (
            "if not (exist unique $x in {$s in Side : beside($s)} with $x > 5) and beside(1) > 5 and beside(2) > 5 then n := 3 endif",
            "none",
        ),
        (
            "if not (exist unique $x in {7, left} with $x > 5) and left > 5 then n := 3 endif",
            "none",
        ),
    ];
    for (rule, violated) in cases {
        let verification = verified(&text(rule), &Options::default());
        assert_eq!(
            crate::verdict_of(&verification, violated),
            "violated",
            "{rule}"
        );
    }
    // positions of a sequence are distinct in any case
    let sequence = "forall $x in [left, right] with $x > 5 do n := 2";
    let verification = verified(&text(sequence), &Options::default());
    assert_eq!(verification.represented[0].values.len(), 3);
}
