//! Safe fixes of what people and generators write: applied until none is left, they give a
//! specification without errors.

use asmotion_lang::diagnostics::apply;
use asmotion_lang::{MemoryFiles, Report, Sources, Style, render_all};

const PATH: &str = "example.asm";

/// Applies the safe fixes of a specification in rounds; returns its text and the remaining errors.
fn fixed(text: &str) -> (String, String) {
    let mut text = text.to_owned();
    for _ in 0..10 {
        let (report, sources) = findings(&text);
        let file = sources.find(PATH).unwrap();
        let next = apply(&text, file, &report.diagnostics);
        if next.applied.is_empty() {
            let errors = report
                .has_errors()
                .then(|| render_all(&report, &sources, Style::Plain));
            return (text, errors.unwrap_or_default());
        }
        text = next.text;
    }
    panic!("fixes never end: {text}");
}

fn findings(text: &str) -> (Report, Sources) {
    let mut files = MemoryFiles::new();
    files.add(PATH, text);
    match asmotion_lang::open(PATH, &files) {
        Ok(opened) => (opened.report, opened.sources),
        Err(failure) => (failure.report, failure.sources),
    }
}

/// Checks the fixes of a main rule.
#[track_caller]
fn rule(before: &str, after: &str) {
    let file = |rule: &str| {
        format!(
            "asm example\nimport StandardLibrary\nsignature:\n  controlled n: Integer\n  controlled r: Real\n  \
             controlled b: Boolean\n  controlled s: Powerset(Integer)\n  controlled q: Seq(Integer)\n  controlled path: Seq(Real)\n  \
             controlled place: Prod(Real, Seq(Prod(Real, Powerset(Real))), Integer)\n  static half: Real -> Real\n\
             definitions:\n  function half($x in Real) = $x / 2.0\n  main rule r_Main =\n{rule}\n"
        )
    };
    let (text, errors) = fixed(&file(before));
    assert_eq!((text.as_str(), errors.as_str()), (file(after).as_str(), ""));
}

#[test]
fn rules_without_an_end_keyword_lose_it() {
    rule(
        "    choose $x in {1 : 3} with $x > 1 do\n      n := $x\n    endchoose",
        "    choose $x in {1 : 3} with $x > 1 do\n      n := $x",
    );
    rule(
        "    par forall $x in {1 : 3} do skip endforall n := 1 endpar",
        "    par forall $x in {1 : 3} do skip n := 1 endpar",
    );
    rule(
        "    par\n      forall $x in {1 : 3} do skip // each\n      endforall n := 1\n    endpar",
        "    par\n      forall $x in {1 : 3} do skip // each\n       n := 1\n    endpar",
    );
}

#[test]
fn bindings_get_brackets() {
    rule(
        "    let $x = 1 in n := $x endlet",
        "    let ($x = 1) in n := $x endlet",
    );
    rule(
        "    let $x = 1, $y = (let ($z = 2) in $z endlet) in n := $x + $y endlet",
        "    let ($x = 1, $y = (let ($z = 2) in $z endlet)) in n := $x + $y endlet",
    );
    rule(
        "    n := let $x = 1 in $x endlet",
        "    n := let ($x = 1) in $x endlet",
    );
}

#[test]
fn comprehensions_get_the_term_of_their_only_variable() {
    rule(
        "    s := {$x in {1 : 3} | $x > 1}",
        "    s := {$x in {1 : 3} | $x > 1 : $x}",
    );
    rule(
        "    s := { $x in {1 : 3} }",
        "    s := { $x in {1 : 3} : $x }",
    );
    rule(
        "    q := [$x in [1 : 3] | $x > 1]",
        "    q := [$x in [1 : 3] | $x > 1 : $x]",
    );
}

#[test]
fn comparisons_of_numbers_are_negated_as_a_whole() {
    rule(
        "    if not n = 0 and b then skip endif",
        "    if not (n = 0) and b then skip endif",
    );
    rule(
        "    if (not n > 0) then skip endif",
        "    if (not (n > 0)) then skip endif",
    );
}

#[test]
fn integers_become_real_numbers() {
    rule("    r := -3", "    r := -3.0");
    rule("    r := half(3)", "    r := half(3.0)");
    rule(
        "    r := if b then 1 else 2.5 endif",
        "    r := if b then 1.0 else 2.5 endif",
    );
    rule(
        "    if r > 1 then r := r + 2 endif",
        "    if r > 1.0 then r := r + 2.0 endif",
    );
    rule(
        "    r := if b then -1 else if not b then 2 else 0.5 endif endif",
        "    r := if b then -1.0 else if not b then 2.0 else 0.5 endif endif",
    );
    rule(
        "    r := if b then 1 else 0 endif",
        "    r := if b then 1.0 else 0.0 endif",
    );
    rule("    path := [1, 2]", "    path := [1.0, 2.0]");
    rule(
        "    place := (1, [(2, {3})], 4)",
        "    place := (1.0, [(2.0, {3.0})], 4)",
    );
}

#[test]
fn what_may_have_lost_its_end_is_not_moved() {
    let text = "asm example\nimport StandardLibrary\nsignature:\n  controlled n: Integer\n  domain D subsetof Integer * Integer\n\
                definitions:\n  main rule r_Main = n := 1\n";
    let (fixed, errors) = fixed(text);
    assert_eq!(fixed, text);
    assert!(errors.contains("L058"), "{errors}");
    let text = text.replace(" * Integer", "");
    let (fixed, _) = self::fixed(&text);
    assert!(
        fixed.contains("signature:\n  domain D subsetof Integer\n  controlled n"),
        "{fixed}"
    );
}

#[test]
fn functions_of_other_languages_get_their_name_here() {
    let text = "asm example\nimport StandardLibrary\nsignature:\n  controlled q: Seq(Integer)\ndefinitions:\n  \
                main rule r_Main = q := rest(q)\n";
    let (report, sources) = findings(text);
    let shown = render_all(&report, &sources, Style::Plain);
    assert!(shown.contains("did you mean `tail`?"), "{shown}");
}

#[test]
fn a_missing_library_is_imported() {
    let rest = "signature:\n  controlled n: Integer\ndefinitions:\n  main rule r_Main = if isDef(n) and n > 0 then n := n + 1 endif\n";
    let (text, errors) = fixed(&format!("asm example\n\n{rest}"));
    assert_eq!(
        text,
        format!("asm example\nimport StandardLibrary\n\n{rest}")
    );
    assert_eq!(errors, "");
}
