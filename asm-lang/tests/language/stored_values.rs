//! Values in packed form: every value of a function is restored, and different values have different states.

use crate::support::opened;
use asmotion_lang::machine::pack_value;
use asmotion_lang::value::{Atom, RuleId};
use asmotion_lang::{Machine, Specification, Value};
use std::sync::Arc;

/// A program with two atoms and a rule that may be a value.
const ELEMENTS: &str = "asm elements
import StandardLibrary
signature:
  enum domain Side = {LEFT | RIGHT}
  controlled act: Rule
definitions:
  main rule r_Main = act := <<r_Main>>
";

/// Returns the number of atoms and of rules of a machine.
fn elements(machine: &Machine) -> (u32, u32) {
    let program = machine.program();
    (
        program.atom_domains.len() as u32,
        program.rules.len() as u32,
    )
}

fn nested(depth: usize) -> Value {
    (0..depth).fold(Value::Int(1), |inner, _| Value::seq([inner]))
}

/// Values of all kinds, no two of which are equal.
fn values(atoms: u32, rules: u32) -> Vec<Value> {
    let (one, two) = (Value::Int(1), Value::Int(2));
    let mut values = vec![
        Value::Undef,
        Value::Bool(false),
        Value::Bool(true),
        Value::real(0.0),
        Value::real(-0.0),
        Value::real(1.0),
        Value::Char('a'),
        Value::Char('\u{1f916}'),
        Value::Atom(Atom(0)),
        Value::Atom(Atom(atoms - 1)),
        Value::Rule(RuleId(rules - 1)),
        Value::text(""),
        Value::text("a"),
        Value::text("ä"),
        Value::text("x".repeat(200)),
        Value::tuple([]),
        Value::tuple([one.clone(), two.clone()]),
        Value::tuple([two.clone(), one.clone()]),
        Value::seq([]),
        Value::seq([one.clone(), two.clone()]),
        Value::seq([Value::seq([one.clone()]), two.clone()]),
        Value::set([]),
        Value::set([one.clone(), two.clone()]),
        Value::Bag(Arc::new([(one.clone(), 1), (two.clone(), 1)].into())),
        Value::Bag(Arc::new([(one.clone(), 2)].into())),
        Value::map([]),
        Value::map([(one.clone(), two.clone())]),
        Value::map([(two.clone(), one.clone())]),
        nested(500),
    ];
    // around the borders of encodings
    let numbers = [
        i64::MIN,
        -1 << 20,
        -65,
        -64,
        -33,
        -32,
        -1,
        0,
        1,
        127,
        191,
        192,
        1 << 20,
        i64::MAX,
    ];
    values.extend(numbers.map(Value::Int));
    values
}

#[test]
fn are_decoded_as_they_were_encoded() {
    let machine = opened("elements", ELEMENTS).machine().unwrap();
    let (atoms, rules) = elements(&machine);
    let mut known: Vec<Vec<u8>> = Vec::new();
    for value in values(atoms, rules) {
        let bytes = pack_value(&value);
        assert_eq!(machine.unpack_value(&bytes), Ok(value.clone()));
        assert!(!known.contains(&bytes), "{value:?}");
        if let Value::Int(number) = value {
            assert_eq!(bytes.len() == 1, (-32..=191).contains(&number), "{number}");
        }
        let longer = [&bytes[..], &[0]].concat();
        for wrong in (0..bytes.len()).map(|end| &bytes[..end]).chain([&*longer]) {
            assert!(machine.unpack_value(wrong).is_err(), "{value:?}: {wrong:?}");
        }
        known.push(bytes);
    }
}

#[test]
fn that_do_not_exist_are_refused() {
    let machine = opened("elements", ELEMENTS).machine().unwrap();
    let (atoms, rules) = elements(&machine);
    for value in [
        Value::Atom(Atom(atoms)),
        Value::Atom(Atom(u32::MAX)),
        Value::Rule(RuleId(rules)),
        nested(700),
    ] {
        assert!(machine.unpack_value(&pack_value(&value)).is_err());
    }
    // an unknown kind, a number without end, a surrogate, a text that is not UTF-8
    let malformed: [&[u8]; 4] = [&[15], &[3, 0x80, 0x80], &[5, 0x80, 0xb0, 3], &[8, 1, 0xff]];
    for bytes in malformed {
        assert!(machine.unpack_value(bytes).is_err(), "{bytes:?}");
    }
    let endless = [&[3], &[0xff; 12][..]].concat();
    assert!(machine.unpack_value(&endless).is_err());
}

/// Domains, and terms for all or some of their values; the last one is outside where this is possible.
const CODOMAINS: [(&str, &str, &[&str]); 9] = [
    ("", "Boolean", &["false", "true"]),
    ("enum domain One = {A}", "One", &["A"]),
    ("enum domain Two = {A | B}", "Two", &["A", "B"]),
    (
        "enum domain Other = {X | Y | Z}\n enum domain Six = {A | B | C | D | E | F}",
        "Six",
        &["A", "B", "C", "D", "E", "F"],
    ),
    (
        "domain Small subsetof Integer",
        "Small",
        &["-3", "-2", "-1", "0", "1", "2", "3", "9", "-9"],
    ),
    (
        "domain Wide subsetof Integer",
        "Wide",
        &["0", "1", "2147483648", "4294967293", "4294967294"],
    ),
    (
        "domain Wider subsetof Integer",
        "Wider",
        &["0", "1", "4294967294", "4294967295", "4294967296"],
    ),
    ("", "Integer", &["0", "-1000000", "9223372036854775807"]),
    ("", "Seq(Integer)", &["[]", "[1]", "[1, 2]"]),
];

fn program(signature: &str, codomain: &str, values: [&str; 3]) -> Specification {
    let domains = [
        ("Small", "-3 : 3"),
        ("Wide", "0 : 4294967293"),
        ("Wider", "0 : 4294967295"),
    ];
    let domains = domains.into_iter().filter(|(name, _)| *name == codomain);
    let domains = domains.map(|(name, range)| format!("domain {name} = {{{range}}}\n"));
    let [first, second, third] = values;
    let text = format!(
        "asm layout
import StandardLibrary
signature:
 {signature}
 domain Place subsetof Integer
 controlled f: Place -> {codomain}
 controlled g: {codomain}
definitions:
 {}domain Place = {{0 : 1}}
 main rule r_Main = skip
default init s0:
 function f($p in Place) = if $p = 0 then {first} else {second} endif
 function g = {third}
",
        domains.collect::<String>()
    );
    opened("layout", &text)
}

#[test]
fn of_every_codomain_have_states_of_their_own() {
    for (signature, codomain, values) in CODOMAINS {
        let all: Vec<&str> = values.iter().copied().chain(["undef"]).collect();
        let mut states = Vec::new();
        let mut other = program(signature, codomain, [all[0]; 3]).machine().unwrap();
        for index in 0..all.len() {
            let chosen = [0, 1, 2].map(|next| all[(index + next) % all.len()]);
            let specification = program(signature, codomain, chosen);
            let machine = specification.machine().unwrap();
            let snapshot = machine.snapshot();
            other.restore(&snapshot).unwrap();
            assert_eq!(other.slots(), machine.slots(), "{codomain}: {chosen:?}");
            assert_eq!(other.snapshot(), snapshot, "{codomain}: {chosen:?}");
            let state = snapshot.into_state();
            assert!(!states.contains(&state), "{codomain}: {chosen:?}");
            states.push(state);
        }
    }
}

#[test]
fn of_a_range_take_as_many_bits_as_they_need() {
    let size = |places: u32| {
        let text = format!(
            "asm sizes
import StandardLibrary
signature:
 domain Small subsetof Integer
 domain Place subsetof Integer
 controlled f: Place -> Small
definitions:
 domain Small = {{-3 : 3}}
 domain Place = {{1 : {places}}}
 main rule r_Main = skip
default init s0:
 function f($p in Place) = 3
"
        );
        let machine = opened("sizes", &text).machine().unwrap();
        machine.snapshot().into_state().as_bytes().len()
    };
    // seven values, undef, and the mark of a value that is stored elsewhere: 4 bits each
    assert_eq!(size(1000) - size(200), 400);
}
