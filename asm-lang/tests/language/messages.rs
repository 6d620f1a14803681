//! Diagnostics: a file for each code, with the code beside the line, and a snapshot of the rendered message. Read a
//! snapshot before you accept it: does it explain what is wrong, where, and what to do?
//!
//! A program without errors is run without inputs until it fails.

use std::collections::BTreeSet;

#[test]
fn says_what_is_wrong() {
    let mut wrong = String::new();
    for (name, text) in super::programs(&super::folder().join("messages")) {
        let (found, rendered) = super::said(&name, &text);
        insta::with_settings!({
            snapshot_path => "../../../tests/language/messages",
            prepend_module_to_snapshot => false,
            omit_expression => true,
        }, { insta::assert_snapshot!(name.clone(), rendered); });
        if found != expected(&text) {
            wrong.push_str(&format!(
                "{name}.asm\n  expected {:?}\n  found    {found:?}\n",
                expected(&text)
            ));
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// Every code of the analysis and of the run has a file that produces it.
#[test]
fn has_an_example_of_every_code() {
    let codes: BTreeSet<&str> = asmotion_lang::codes::all()
        .map(|code| code.name)
        .filter(|name| name.starts_with(['A', 'W', 'R']))
        .collect();
    let programs = super::programs(&super::folder().join("messages"));
    let mut examples: BTreeSet<&str> = programs
        .iter()
        .flat_map(|(_, text)| expected(text))
        .map(|(_, code)| code)
        .collect();
    // not possible in a file alone: see `limits`, and `codes` for picked, set and drawn values
    examples.extend(["A012", "A013", "R020", "R022", "R024"]);
    assert_eq!(
        codes.difference(&examples).collect::<Vec<_>>(),
        Vec::<&&str>::new(),
        "without example"
    );
}

/// The codes that a text expects, with their lines in their files.
fn expected(text: &str) -> Vec<(usize, &str)> {
    let mut expected = Vec::new();
    let mut line = 0;
    for text in text.lines() {
        line = if text.starts_with("//--- ") {
            0
        } else {
            line + 1
        };
        if let Some((_, codes)) = text.split_once("//~") {
            expected.extend(codes.split_whitespace().map(|code| (line, code)));
        }
    }
    expected
}
