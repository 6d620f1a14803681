//! What is exactly at a limit of a step is executed, and what is just beyond it is a fault.

use asmotion_lang::{BackEnd, FirstChoice, NoInputs};

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

const LIMITS: [Bounded; 8] = [
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
                    limit.definition,
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
