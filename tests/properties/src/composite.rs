//! Composite files and property files.

use asmotion_component::{Declaration, Interface};
use asmotion_composite::{AsmFiles, Context, EmptyEnvironment, Tables, property_file as file};
use asmotion_diagnostics::{Report, Sources, Style, render_all};
use asmotion_lang::MemoryFiles;
use asmotion_plan::{Opened, expand};

const BUILD: Tables = Tables {
    components: asmotion_components::COMPONENTS,
    messages: asmotion_components::MESSAGES,
    interfaces: asmotion_components::INTERFACES,
    builtins: &[],
    ros: None,
};

/// A composite opens, or is refused with a report that can be rendered. An opened composite can be expanded; the result
/// opens, and expands to itself.
pub fn composite(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let opened = open(&text);
    shown(&opened.report, &opened.sources);
    // a value with an unset variable is checked without it, and cannot be written
    if opened
        .report
        .diagnostics
        .iter()
        .any(|it| it.code.name == "C014")
    {
        return;
    }
    for profile in profiles(&opened) {
        let Some(plan) = opened.plan(profile) else {
            continue;
        };
        let expanded = expand(&opened, plan);
        let again = open(&expanded);
        let Some(plan) = again.plan(None) else {
            panic!(
                "what was expanded does not open:\n{expanded}\n{:?}",
                again.report
            );
        };
        assert_eq!(
            expanded,
            expand(&again, plan),
            "it does not expand to itself"
        );
    }
}

fn profiles(opened: &Opened) -> Vec<Option<&str>> {
    match opened.profiles.as_slice() {
        [] => vec![None],
        names => names.iter().map(|name| Some(name.as_str())).collect(),
    }
}

fn open(text: &str) -> Opened {
    let mut files = MemoryFiles::new();
    files.add("fuzz.toml", text);
    files.add(
        "machine.asm",
        "asm machine\nsignature:\ndefinitions:\nmain rule r_Main = skip\n",
    );
    let context = Context {
        loader: &files,
        environment: &EmptyEnvironment,
        catalogue: &BUILD,
        specifications: &AsmFiles::new(&files),
        programs: &asmotion_composite::NoPrograms,
        settings: &[],
    };
    asmotion_plan::open("fuzz.toml", &context)
}

/// A report can be rendered, so its places are within the texts.
pub(crate) fn shown(report: &Report, sources: &Sources) {
    render_all(report, sources, Style::Plain);
}

/// A property file is read with a report that can be rendered. The accepted properties can be written, and are
/// unchanged when read again.
pub fn property_file(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let declared = declaration();
    let read = file::read("fuzz.toml", &text, "follower", &declared);
    shown(&read.report, &read.sources);
    let written = file::write(&declared, &read.properties);
    let again = file::read("again.toml", &written, "follower", &declared);
    assert!(!again.report.has_errors(), "{written}\n{:?}", again.report);
    assert_eq!(
        format!("{:?}", again.properties),
        format!("{:?}", read.properties)
    );
}

fn declaration() -> Declaration {
    let mut interface = Interface::new();
    if let Some(make) = asmotion_components::component("nav::TrajectoryFollower") {
        make(&mut interface);
    }
    interface.declaration().clone()
}
