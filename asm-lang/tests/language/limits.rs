//! For any text: a report, no panic, no stack overflow, bounded time.

use asmotion_lang::diagnostics::{FileId, LoadError};
use asmotion_lang::value::Value;
use asmotion_lang::{
    BackEnd, FirstChoice, Loader, MemoryFiles, NoInputs, OpenFailure, Style, render_all,
};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time limit for any text here, in an unoptimised build on a busy machine. What explodes would take hours.
const PATIENCE: Duration = Duration::from_secs(120);

/// The codes of the findings in a text, determined within the time limit.
fn codes(text: &str) -> Vec<&'static str> {
    let begin = Instant::now();
    let report = match super::open("limits", text) {
        Ok(specification) => specification.report,
        Err(failure) => failure.report,
    };
    assert!(begin.elapsed() < PATIENCE, "took {:?}", begin.elapsed());
    report
        .diagnostics
        .iter()
        .map(|finding| finding.code.name)
        .collect()
}

fn main_rule(signature: &str, rule: &str) -> String {
    format!(
        "asm limits\nimport StandardLibrary\nsignature:\n{signature}\ndefinitions:\n main rule r_Main = {rule}\n"
    )
}

/// An endless sequence of pseudo-random numbers, always the same.
fn numbers() -> impl FnMut(usize) -> usize {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    move |below| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        usize::try_from(state >> 33).unwrap() % below
    }
}

#[test]
fn says_that_an_empty_file_is_empty() {
    for text in ["", " \n\n", "// nothing", "\u{feff}"] {
        assert_eq!(codes(text).len(), 1, "{text:?}");
    }
}

#[test]
fn survives_noise() {
    let mut below = numbers();
    let noise: String = (0..10_000_000)
        .map(|_| char::from(u8::try_from(below(255)).unwrap()))
        .collect();
    assert!(!codes(&noise).is_empty());
    assert!(!codes(&main_rule("", &noise)).is_empty());
}

#[test]
fn survives_deep_nests() {
    let nest = |open: &str, inner: &str, close: &str, depth: usize| {
        format!("{}{inner}{}", open.repeat(depth), close.repeat(depth))
    };
    let cases = [
        nest("x := (", "1", ")", 1) + &nest("(", "", "", 10_000),
        format!("x := {}", nest("(", "1", ")", 10_000)),
        format!("b := {}", nest("not ", "b", "", 100_000)),
        format!("x := {}", nest("- ", "1", "", 100_000)),
        format!("b := {}", nest("b and (", "b", ")", 5_000)),
        format!("x := {}", nest("if b then ", "1", " endif", 10_000)),
        nest("if b then ", "skip", " endif", 10_000),
        nest("seq skip ", "skip", " endseq", 10_000),
        nest("forall $i in {1} do ", "skip", "", 10_000),
    ];
    for rule in cases {
        let text = main_rule(" controlled x: Integer\n controlled b: Boolean", &rule);
        assert!(codes(&text).contains(&"L039"), "{}", &rule[..30]);
    }
}

/// All stages can process any nesting that the parser accepts, also on a small stack.
#[test]
fn runs_nests_as_deep_as_they_may_be() {
    let nest = |open: &str, inner: &str, close: &str, depth: usize| {
        format!("{}{inner}{}", open.repeat(depth), close.repeat(depth))
    };
    let cases = [
        format!("x := {}", nest("(1 + ", "1", ")", 190)),
        format!("b := {}", nest("not ", "b", "", 380)),
        format!("b := {}", nest("(b and b and ", "b", ")", 190)),
        format!("x := {}", nest("if b then ", "1", " endif", 380)),
        format!("b := {}", nest("(exists $i in {1} with ", "b", ")", 190)),
        nest("if b then ", "skip", " else x := 1 endif", 380),
        nest("seq x := 1 ", "skip", " endseq", 380),
        nest("choose $i in {1} do ", "x := 1", "", 380),
    ];
    for rule in cases {
        let text = main_rule(" controlled x: Integer\n controlled b: Boolean", &rule)
            + "default init s0:\n function b = true\n";
        let run = move || {
            let mut machine = super::opened("limits", &text).machine().unwrap();
            machine.step(&mut NoInputs, &mut FirstChoice, 0).unwrap();
        };
        std::thread::Builder::new()
            .stack_size(1 << 20)
            .spawn(run)
            .unwrap()
            .join()
            .unwrap();
    }
}

/// A chain of operators may have any length, in all stages and both back ends, also on a small stack.
#[test]
fn runs_chains_of_any_length() {
    const LENGTH: usize = 10_000;
    let chains = [
        ("x := 1", " + 1", "10001"),
        ("x := -20000", " - 1 + 2", "-10000"),
        ("x := y", " * 1 + y", "10001"),
        ("b := b", " and b", "true"),
        ("b := not b", " or b", "true"),
        ("b := b", " implies b", "true"),
        ("b := b", " = b", "true"),
        ("t := t", " + t", ""),
    ];
    for (first, link, expected) in chains {
        let rule = format!("{first}{}", link.repeat(LENGTH));
        let signature = " controlled x: Integer\n controlled y: Integer\n controlled b: Boolean\n controlled t: String";
        let text = main_rule(signature, &rule)
            + "default init s0:\n function b = true\n function y = 1\n function t = \"\"\n";
        let run = move || {
            let formatted = asmotion_lang::syntax::format(FileId::default(), &text).unwrap();
            for text in [&text, &formatted] {
                let mut machine = super::opened("limits", text).machine().unwrap();
                for back_end in [BackEnd::Closures, BackEnd::Native] {
                    let _ = machine.set_back_end(back_end);
                    let step = machine.step(&mut NoInputs, &mut FirstChoice, 0).unwrap();
                    let value = step.updates()[0].value.clone();
                    let shown = value.show(&machine.naming()).to_string();
                    assert_eq!(shown.trim_matches('"'), expected, "{first}{link}");
                }
            }
        };
        std::thread::Builder::new()
            .stack_size(1 << 20)
            .spawn(run)
            .unwrap()
            .join()
            .unwrap();
    }
}

#[test]
fn survives_long_blocks() {
    let text = main_rule(
        " controlled x: Integer",
        &format!("par {} endpar", "x := 1 ".repeat(50_000)),
    );
    assert_eq!(codes(&text), Vec::<&str>::new());
}

/// A text of a hundred thousand parts is processed, or refused with the name of the limit.
#[test]
fn answers_large_texts() {
    let numbers = (0..100_000).map(|number| number.to_string());
    let list = numbers.collect::<Vec<_>>().join(", ");
    let literals = (0..100_000).map(|number| format!("LITERAL_{number}"));
    let literals = literals.collect::<Vec<_>>().join(" | ");
    let runs = [
        ("", format!("x := size({{{list}}})")),
        ("", format!("x := length([{list}])")),
        ("", "x := size({0 : 99999})".to_owned()),
        ("", "x := size({$i in {0 : 99999} : $i * 2})".to_owned()),
        (
            "",
            "x := size({$i in {0 : 999}, $j in {0 : 99} : ($i, $j)})".to_owned(),
        ),
        (
            &*format!(" enum domain Many = {{{literals}}}\n"),
            "x := size(Many)".to_owned(),
        ),
    ];
    for (signature, rule) in runs {
        let text = main_rule(&format!("{signature} controlled x: Integer"), &rule);
        let begin = Instant::now();
        let specification = super::opened("limits", &text);
        let mut machine = specification.machine().unwrap();
        let step = machine.step(&mut NoInputs, &mut FirstChoice, 0).unwrap();
        let value = &step.updates()[0].value;
        assert_eq!(value, &Value::Int(100_000), "{}", &rule[..20]);
        assert!(begin.elapsed() < PATIENCE, "took {:?}", begin.elapsed());
    }
}

#[test]
fn refuses_what_is_larger_than_it_can_carry() {
    let digits = "9".repeat(100_000);
    let name = "n".repeat(1_000_000);
    let refused = [
        (format!("x := {digits}"), "L006"),
        (format!("{name} := 1"), "A001"),
        (format!("x := {}1", "1 * (".repeat(5_000)), "L039"),
    ];
    for (rule, code) in refused {
        let text = main_rule(" controlled x: Integer\n controlled b: Boolean", &rule);
        assert!(codes(&text).contains(&code), "{}", &rule[..20]);
    }
    let real = format!("r := {digits}.5");
    assert_eq!(codes(&main_rule(" controlled r: Real", &real)), [""; 0]);
}

/// A run that is too deep, too long or too large stops with a fault.
#[test]
fn stops_runs_without_end() {
    let endless = [
        (
            "static f: Integer -> Integer",
            "function f($n in Integer) = f($n + 1) + 1",
            "x := f(0)",
            "R010",
        ),
        (
            "derived f: Integer -> Integer",
            "function f($n in Integer) = if x > 0 then 0 else f($n) endif",
            "x := f(0)",
            "R010",
        ),
        (
            "",
            "rule r_f($n in Integer) = r_f[$n + 1]",
            "r_f[0]",
            "R010",
        ),
        (
            "",
            "turbo rule r_f($n in Integer) in Integer = seq x <- r_f($n + 1)  result := x endseq",
            "x <- r_f(0)",
            "R010",
        ),
        (
            "",
            "rule r_f($n in Integer) = seq x := $n  r_f[x] endseq",
            "r_f[0]",
            "R010",
        ),
        (
            "static f: Integer -> Integer",
            "function f($n in Integer) = if $n = 0 then 1 else f($n - 1) + f($n - 1) endif",
            "x := f(100)",
            "R021",
        ),
        ("", "", "while true do while true do x := x + 1", "R011"),
        ("", "", "x := size({1 : 100000000000})", "R012"),
        (
            "controlled s: Powerset(Integer)",
            "",
            "s := {$a in {1 : 2000}, $b in {1 : 2000} : $a * 2000 + $b}",
            "R012",
        ),
        (
            "domain Digit subsetof Integer\n controlled s: Powerset(Powerset(Integer))",
            "domain Digit = {0 : 63}",
            "s := {$d in Powerset(Digit) : $d}",
            "R012",
        ),
        (
            "controlled s: Seq(Integer)",
            "",
            "seq s := [1]  while true do s := union(s, s) endseq",
            "R004",
        ),
        ("controlled y: Any", "", "while true do y := [y]", "R016"),
        ("controlled y: Any", "", "while true do y := (y, y)", "R016"),
        ("", "rule r_f($a in Any) = r_f[[$a]]", "r_f[1]", "R016"),
        (
            "static f: Integer -> Any",
            "function f($n in Integer) = if $n = 0 then [] else [f($n - 1)] endif",
            "x := if isDef(f(10000)) then 1 else 0 endif",
            "R016",
        ),
        (
            "static f: Prod(Integer, Any) -> Any",
            "function f($n in Integer, $a in Any) = if $n = 0 then $a else f($n - 1, [$a]) endif",
            "x := if isDef(f(10000, 1)) then 1 else 0 endif",
            "R016",
        ),
    ];
    for (signature, definition, rule, code) in endless {
        let text = format!(
            "asm limits\nimport StandardLibrary\nsignature:\n {signature}\n controlled x: Integer\ndefinitions:\n {definition}\n main rule r_Main = {rule}\ndefault init s0:\n function x = 0\n"
        );
        let specification = super::opened("limits", &text);
        let mut machine = specification.machine().unwrap();
        let fault = machine
            .step(&mut NoInputs, &mut FirstChoice, 0)
            .map(|_| ())
            .unwrap_err();
        assert_eq!(
            specification.explain_in(&fault, &machine).code,
            code,
            "{rule}"
        );
    }
}

#[test]
fn refuses_a_long_chain_of_imports() {
    let mut files = MemoryFiles::new();
    for index in 0..200 {
        let next = format!("import m{}\n", index + 1);
        files.add(
            &format!("m{index}.asm"),
            format!("module m{index}\n{next}export *\nsignature:\ndefinitions:\n"),
        );
    }
    let failure = asmotion_lang::open("m0.asm", &files).unwrap_err();
    insta::assert_snapshot!(first(&failure), @"
    error[A012]: imports nested deeper than 64 files
     --> m63.asm:2:8
      |
    2 | import m64
      |        ^^^ limit exceeded here
      |
    help: import the needed module directly
    ");
}

/// A file that exists but cannot be read.
struct Locked;

impl Loader for Locked {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        match path {
            "robot.asm" => Ok(Arc::from(
                "asm robot\nimport secret\nsignature:\ndefinitions:\n main rule r_Main = skip\n",
            )),
            path => Err(LoadError {
                path: path.to_owned(),
                reason: "permission denied".to_owned(),
            }),
        }
    }

    fn resolve(&self, _from: &str, import: &str) -> Option<String> {
        Some(format!("{}.asm", import.trim_end_matches(".asm")))
    }
}

#[test]
fn says_which_file_cannot_be_read() {
    let failure = asmotion_lang::open("robot.asm", &Locked).unwrap_err();
    insta::assert_snapshot!(first(&failure), @"
    error[A013]: cannot read `secret.asm`: permission denied
     --> robot.asm:2:8
      |
    2 | import secret
      |        ^^^^^^ imported here
      |
    help: check the path
    ");
    let failure = asmotion_lang::open("secret.asm", &Locked).unwrap_err();
    assert_eq!(failure.report.diagnostics[0].code, "A013");
}

fn first(failure: &OpenFailure) -> String {
    let mut report = failure.report.clone();
    report.diagnostics.truncate(1);
    render_all(&report, &failure.sources, Style::Plain)
}

/// Terms passed by name from macro to macro keep a size that can be built and run.
#[test]
fn bounds_what_is_passed_by_name() {
    let macros = |count: usize, term: &str| {
        let rule = |index: usize| {
            format!(
                "rule r_{index}($t in Integer) = seq y := $t  r_{}[{term}] endseq\n",
                index + 1
            )
        };
        let rules: String = (0..count).map(rule).collect();
        let text = format!(
            "asm limits\nimport StandardLibrary\nsignature:\n controlled x: Integer\n controlled y: Integer\ndefinitions:\n{rules} rule r_{count}($t in Integer) = seq x := 1  y := $t endseq\n main rule r_Main = r_0[x]\ndefault init s0:\n function x = 1\n"
        );
        let begin = Instant::now();
        let opened = super::open("limits", &text);
        assert!(begin.elapsed() < PATIENCE, "took {:?}", begin.elapsed());
        opened
    };
    let deep = "(".repeat(300) + "$t" + &" + 1)".repeat(300);
    assert!(macros(40, "$t").is_ok());
    for term in ["$t + $t", &deep] {
        let report = macros(40, term).unwrap_err().report;
        let mut found = report.diagnostics.iter();
        assert!(found.any(|finding| finding.code == "A031"), "{report:?}");
    }
    let specification = macros(3, &deep).unwrap();
    let run = move || {
        specification
            .machine()
            .unwrap()
            .step(&mut NoInputs, &mut FirstChoice, 0)
            .map(|_| ())
            .unwrap()
    };
    std::thread::Builder::new()
        .stack_size(1 << 20)
        .spawn(run)
        .unwrap()
        .join()
        .unwrap();
}

/// Domains may be nested to any depth.
#[test]
fn survives_domains_of_domains() {
    let chain = |name: char, of: &str| {
        let first = format!(" domain {name}x0 subsetof Integer\n");
        let next = |index: usize| {
            let inner = format!("{name}x{index}");
            format!(
                " domain {name}x{} subsetof {}\n",
                index + 1,
                of.replace("It", &inner)
            )
        };
        first + &(0..1_000).map(next).collect::<String>()
    };
    let text = main_rule(
        &format!(
            "{}{} controlled a: Ax1000\n controlled b: Bx1000",
            chain('A', "Seq(It)"),
            chain('B', "Seq(It)")
        ),
        "a := b",
    );
    assert!(codes(&text).iter().all(|code| code.starts_with('W')));
    let text = main_rule(
        &format!("{} controlled a: Ax1000", chain('A', "Prod(It, It)")),
        "a := undef",
    );
    assert!(codes(&text).iter().all(|code| code.starts_with('W')));
}
