//! Parsing of scenarios, and the messages about errors in them.
//!
//! A file in `tests/scenarios` marks each line with a finding by `//~ CODE`.

#![allow(clippy::disallowed_methods, reason = "the texts are on the disk")]

use asmotion_diagnostics::{FileId, Sources};
use asmotion_syntax::ast::{ScenarioCommand, ScenarioCommandKind};
use asmotion_syntax::parse_scenario;
use std::fs;
use std::path::Path;

#[test]
fn they_have_a_name_a_specification_and_commands() {
    let text = r#"// a comment
scenario lift
load "sub dir/Lift.asm"
invariant safe: speed < 3;
set f(1, "a;b") := 2; // not the end: ;
check set(1) = { ';' };
step
step until ready;
exec par a := 1 b := 2 endpar;
pick $x in r_go(Natural, Prod(Integer, Boolean)) := 3;
begin outer
  begin inner step end
end
execblock other:inner;
execblock other.inner;
execblock inner;
"#;
    let (scenario, report) = parse_scenario(FileId(0), text);
    assert!(report.diagnostics.is_empty(), "{report:#?}");
    assert_eq!(&*scenario.name.as_ref().unwrap().text, "lift");
    assert_eq!(&*scenario.load.as_ref().unwrap().text, "sub dir/Lift.asm");
    assert_eq!(scenario.invariants.len(), 1);
    let shown: Vec<&str> = scenario
        .commands
        .iter()
        .map(|it| &text[it.span.range()])
        .collect();
    insta::assert_snapshot!(shown.join("\n---\n"));
    let kinds: Vec<&str> = scenario.commands.iter().map(kind).collect();
    assert_eq!(
        kinds,
        [
            "set",
            "check",
            "step",
            "until",
            "exec",
            "pick",
            "block",
            "execblock",
            "execblock",
            "execblock"
        ]
    );
    assert!(scenario.block("inner").is_some());
    let ScenarioCommandKind::Pick(pick) = &scenario.commands[5].kind else {
        unreachable!()
    };
    let domains = pick.rule.as_ref().unwrap().parameters.as_ref().unwrap();
    let domains: Vec<&str> = domains.iter().map(|name| &*name.text).collect();
    assert_eq!(domains, ["Natural", "Prod(Integer, Boolean)"]);
}

#[test]
fn names_are_any_printable_characters() {
    let text = "scenario a-b.c\nload lift.asm\ninvariant i-1.safe: speed < 3;\n\
                begin 2nd_part(x)// not the name\n  step\nend\n\
                execblock 2nd_part(x);\nexecblock RATE-1.2:part-3 ;\nexecblock RATE-1.2.part;\n\
                begin one.two end execblock one.two;";
    let (scenario, report) = parse_scenario(FileId(0), text);
    assert!(report.diagnostics.is_empty(), "{report:#?}");
    assert_eq!(&*scenario.name.as_ref().unwrap().text, "a-b.c");
    assert_eq!(&*scenario.invariants[0].name.text, "i-1.safe");
    assert!(scenario.block("2nd_part(x)").is_some());
    let executed: Vec<(Option<&str>, &str)> = scenario
        .commands
        .iter()
        .filter_map(|command| {
            let ScenarioCommandKind::ExecBlock { scenario, block } = &command.kind else {
                return None;
            };
            assert_eq!(&text[block.span.range()], &*block.text);
            let scenario = scenario.as_ref().map(|name| &text[name.span.range()]);
            Some((scenario, &text[block.span.range()]))
        })
        .collect();
    assert_eq!(
        executed,
        [
            (None, "2nd_part(x)"),
            (Some("RATE-1.2"), "part-3"),
            // the old notation
            (Some("RATE-1.2"), "part"),
            // a block of this scenario
            (None, "one.two"),
        ]
    );
}

fn kind(command: &ScenarioCommand) -> &'static str {
    match &command.kind {
        ScenarioCommandKind::Set(..) => "set",
        ScenarioCommandKind::Check(_) => "check",
        ScenarioCommandKind::Step => "step",
        ScenarioCommandKind::StepUntil(_) => "until",
        ScenarioCommandKind::Exec(_) => "exec",
        ScenarioCommandKind::Pick(_) => "pick",
        ScenarioCommandKind::Block(_) => "block",
        ScenarioCommandKind::ExecBlock { .. } => "execblock",
    }
}

#[test]
fn mistakes_are_told_where_they_are() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenarios");
    let mut files: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path())
        .collect();
    files.sort();
    for file in files {
        let name = file.file_stem().unwrap().to_str().unwrap().to_owned();
        let text = fs::read_to_string(&file).unwrap();
        let mut sources = Sources::new();
        let id = sources.add(&name, text.as_str());
        let report = parse_scenario(id, &text).1;
        let mut found = Vec::new();
        let mut said = String::new();
        for finding in &report.diagnostics {
            let at = finding.primary.as_ref().unwrap();
            let (line, column) = sources.position(id, at.span.start);
            found.push((line, finding.code.name));
            said.push_str(&format!(
                "{} at {line}:{column} `{}`: {}; {}\n",
                finding.code,
                sources.snippet(at.span),
                finding.message,
                at.text
            ));
            let ways = finding.helps.iter().cloned();
            let fix = finding.fix.iter().map(|fix| fix.title.clone());
            ways.chain(fix)
                .for_each(|way| said.push_str(&format!("  {way}\n")));
        }
        insta::assert_snapshot!(name.clone(), said);
        let expected: Vec<(usize, &str)> = text
            .lines()
            .enumerate()
            .filter_map(|(line, text)| Some((line + 1, text.split_once("//~")?.1)))
            .flat_map(|(line, codes)| codes.split_whitespace().map(move |code| (line, code)))
            .collect();
        assert_eq!(found, expected, "in {name}");
    }
}

#[test]
fn any_text_is_read_to_its_end() {
    let text = "scenario é load \"x\ninvariant i: step check; set x := \"; pick $ in r_a(((,) := 'é; \
                begin begin a end execblock a.; ☃ ;;; exec par /* step until";
    for end in (0..=text.len()).filter(|&end| text.is_char_boundary(end)) {
        parse_scenario(FileId(0), &text[..end]);
    }
    let deep = "begin a ".repeat(10_000);
    parse_scenario(FileId(0), &deep);
}
