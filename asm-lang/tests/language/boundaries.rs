//! What is exactly at a limit of a step is executed, and what is just beyond it is a fault.

use asmotion_lang::ir::ValueShape;
use asmotion_lang::{BackEnd, FirstChoice, Machine, NoInputs, Value};
use std::collections::BTreeSet;

/// A program with a place `N` for a number.
struct Bounded {
    signature: &'static str,
    definition: &'static str,
    rule: &'static str,
    /// The greatest number for which the step succeeds.
    greatest: u64,
    /// The code of the fault for the next number.
    code: &'static str,
}

const LIMITS: [Bounded; 11] = [
    // the main rule, the function and its recursive calls: 20,000 nested calls
    Bounded {
        signature: "static f: Integer -> Integer",
        definition: "function f($n in Integer) = if $n = 0 then 1 else f($n - 1) endif",
        rule: "x := f(N)",
        greatest: 19_998,
        code: "R010",
    },
    Bounded {
        signature: "",
        definition: "rule r_f($n in Integer) = if $n = 0 then x := 1 else r_f[$n - 1] endif",
        rule: "r_f[N]",
        greatest: 19_998,
        code: "R010",
    },
    // 1,048,576 elements
    Bounded {
        signature: "",
        definition: "",
        rule: "x := size({1 : N})",
        greatest: 1 << 20,
        code: "R012",
    },
    Bounded {
        signature: "",
        definition: "",
        rule: "x := size({1.0 : N.0})",
        greatest: 1 << 20,
        code: "R012",
    },
    // the elements of a comprehension are counted as they are collected
    Bounded {
        signature: "",
        definition: "",
        rule: "x := size({$a in {1 : 1024}, $b in {1 : N} : $a * 2000 + $b})",
        greatest: 1024,
        code: "R012",
    },
    Bounded {
        signature: "domain A subsetof Integer\n domain B subsetof Integer",
        definition: "domain A = {1 : 1024}\n domain B = {1 : N}",
        rule: "x := size({$p in Prod(A, B) | first($p) = 1 : second($p)})",
        greatest: 1024,
        code: "R012",
    },
    // 1,048,576 sets
    Bounded {
        signature: "domain A subsetof Integer",
        definition: "domain A = {1 : N}",
        rule: "x := size({$s in Powerset(A) | size($s) = 1 : $s})",
        greatest: 20,
        code: "R012",
    },
    Bounded {
        signature: "domain A subsetof Integer",
        definition: "domain A = {1 : N}",
        rule: "choose $s in Powerset(A) with size($s) = N do x := size($s)",
        greatest: 20,
        code: "R012",
    },
    // 500 values within each other
    Bounded {
        signature: "controlled y: Any\n static f: Prod(Integer, Any) -> Any",
        definition: "function f($n in Integer, $a in Any) = if $n = 0 then $a else f($n - 1, [$a]) endif",
        rule: "y := f(N, 1)",
        greatest: 500,
        code: "R016",
    },
    Bounded {
        signature: "controlled y: Any",
        definition: "",
        rule: "seq y := 1 x := 0 while x < N do par x := x + 1 y := (y, x) endpar endseq",
        greatest: 500,
        code: "R016",
    },
    Bounded {
        signature: "controlled y: Any",
        definition: "",
        rule: "seq y := 1 x := 0 while x < N do par x := x + 1 y := {x -> y} endpar endseq",
        greatest: 500,
        code: "R016",
    },
];

/// Domains of which the elements can be listed, with their number.
const LISTED: [(&str, usize); 9] = [
    ("Boolean", 2),
    ("Few", 5),
    ("Odd", 3),
    ("Side", 2),
    ("Item", 2),
    ("Prod(Few, Odd)", 15),
    ("Prod(Side, Odd, Boolean)", 12),
    ("Powerset(Few)", 32),
    ("Prod(Powerset(Odd), Side)", 16),
];

/// Returns a machine with a function of this codomain, and the shape of the codomain.
fn with_codomain(codomain: &str) -> (Machine, ValueShape) {
    let text = format!(
        "asm listed
import StandardLibrary
signature:
 enum domain Side = {{LEFT | RIGHT}}
 abstract domain Item
 domain Few subsetof Integer
 domain Odd subsetof Integer
 dynamic domain Unknown subsetof Integer
 static one: Item
 static two: Item
 controlled listed: {codomain}
definitions:
 domain Few = {{-2 : 2}}
 domain Odd = {{$n in {{0 : 5}} | $n mod 2 = 1 : $n}}
 main rule r_Main = skip
"
    );
    let specification = super::opened("listed", &text);
    let function = specification.function("listed", 0).unwrap();
    let machine = specification.machine().unwrap();
    let shape = machine.program().functions[function.0 as usize]
        .codomain
        .clone();
    (machine, shape)
}

#[test]
fn of_listed_elements_are_exact() {
    for (codomain, count) in LISTED {
        let (machine, shape) = with_codomain(codomain);
        let elements = machine.elements(&shape, count).unwrap();
        assert_eq!(elements.len(), count, "{codomain}");
        let sorted: BTreeSet<&Value> = elements.iter().collect();
        assert!(elements.iter().eq(sorted), "{codomain}: {elements:?}");
        if codomain != "Boolean" {
            assert_eq!(machine.elements(&shape, count - 1), None, "{codomain}");
        }
    }
    // no number of elements suffices
    for codomain in [
        "Integer",
        "Any",
        "Seq(Odd)",
        "Bag(Odd)",
        "Map(Odd, Odd)",
        "Prod(Odd, String)",
        "Powerset(Real)",
        "Unknown",
    ] {
        let (machine, shape) = with_codomain(codomain);
        assert_eq!(machine.elements(&shape, 1 << 20), None, "{codomain}");
    }
}

#[test]
fn of_a_step_are_exact() {
    for limit in &LIMITS {
        for back_end in [BackEnd::Closures, BackEnd::Native] {
            for (number, code) in [
                (limit.greatest, None),
                (limit.greatest + 1, Some(limit.code)),
            ] {
                let text = format!(
                    "asm boundaries\nimport StandardLibrary\nsignature:\n {}\n controlled x: Integer\ndefinitions:\n {}\n main rule r_Main = {}\ndefault init s0:\n function x = 0\n",
                    limit.signature,
                    limit.definition.replace('N', &number.to_string()),
                    limit.rule.replace('N', &number.to_string())
                );
                let specification = super::opened("boundaries", &text);
                let mut machine = specification.machine().unwrap();
                // without native code, closures run twice
                let _ = machine.set_back_end(back_end);
                let step = machine.step(&mut NoInputs, &mut FirstChoice, 0);
                let fault = step.map(|_| ()).err();
                let found = fault.map(|it| specification.explain_in(&it, &machine).code.name);
                assert_eq!(found, code, "{} for {number}, {back_end:?}", limit.rule);
            }
        }
    }
}
