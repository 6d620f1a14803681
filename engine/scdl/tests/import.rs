//! Imports SCDL: nothing is dropped silently, and the result passes the check.
#![allow(missing_docs, clippy::expect_used, reason = "tests")]

mod support;

use support::{import, open, rendered};

/// All resulting files, followed by the findings.
fn shown(imported: &asmotion_scdl::Imported) -> String {
    let files = imported.files.iter();
    let files = files.map(|(name, text)| format!("==== {name}\n{text}"));
    let files: Vec<String> = files.collect();
    let found = rendered(&imported.report, &imported.sources);
    format!("{}\n==== findings\n{found}", files.join("\n"))
}

#[test]
fn c14_nested_composites_are_imported_and_pass_the_check() {
    let imported = import(&[
        "outer.composite",
        "motor.composite",
        "inner.composite",
        "planner.composite",
    ]);
    insta::assert_snapshot!(shown(&imported));
    assert!(!imported.report.has_errors());
    let names: Vec<_> = imported
        .files
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    assert_eq!(
        names,
        [
            "OuterComposite.composite.toml",
            "InnerComposite.composite.toml",
            "MotorComposite.composite.toml",
        ]
    );
    let opened = open(&imported.files);
    let said = rendered(&opened.report, &opened.sources);
    assert!(!opened.report.has_errors(), "{said}");
    let plan = opened.plan(None).expect("a plan");
    let components: Vec<_> = plan.components.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(
        components,
        [
            "RoverComponent/DriveComponent",
            "RoverComponent/MotorComponent/Controller",
            "MapComponent",
        ]
    );
}

#[test]
fn what_is_joined_across_composites_has_one_interface_and_is_called_back() {
    let files = [
        "depot.composite",
        "orderdesk.composite",
        "shelfroom.composite",
    ];
    let imported = import(&files);
    insta::assert_snapshot!(shown(&imported));
    let opened = open(&imported.files);
    let said = rendered(&opened.report, &opened.sources);
    assert!(!opened.report.has_errors(), "{said}");
    let plan = opened.plan(None).expect("a plan");
    let wires = plan.wires.iter();
    let mut wires = wires.map(|it| (it.reference.to_string(), it.services[0].to_string()));
    let lifted = ("Orders/Lift.Lifting_callback", "Foreman.lifts_callback");
    assert!(wires.any(|(from, to)| (&*from, &*to) == lifted));
}

#[test]
fn it_says_what_is_wrong_and_what_has_no_counterpart() {
    insta::assert_snapshot!(shown(&import(&["mistakes.composite"])));
}

#[test]
fn it_refuses_what_is_no_scdl() {
    for text in [
        "",
        "no XML",
        "<composite name=\"a\"/>",
        "<composite xmlns=\"http://www.osoa.org/xmlns/sca/1.0\"",
        "<composite xmlns=\"http://www.osoa.org/xmlns/sca/1.0\" name=\"a\">",
        "<composite xmlns=\"http://www.osoa.org/xmlns/sca/1.0\" name=\"a\">&unknown;</composite>",
        &"<composite>".repeat(100_000),
    ] {
        let imported = asmotion_scdl::import(
            &[("a".to_owned(), text.to_owned())],
            &asmotion_composite::Tables::EMPTY,
        );
        assert!(imported.files.is_empty(), "{text:.60}");
        assert!(imported.report.has_errors(), "{text:.60}");
    }
}

const CPF: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE properties SYSTEM "cpf.dtd">
<properties>
  <description>of a controller</description>
  <simple name="kp" type="double"><description>gain</description><value>2.5</value></simple>
  <simple name="on" type="boolean"><value>1</value></simple>
  <simple name="count" type="long"><value>many</value></simple>
  <sequence name="limits" type="list">
    <simple type="double"><value>-1</value></simple>
    <simple type="double"><value>1</value></simple>
  </sequence>
  <struct name="frame" type="frame"><simple name="id" type="string"><value>map</value></simple></struct>
  <simpel name="ki" type="double"><value>1</value></simpel>
  <simple type="double"><value>3</value></simple>
</properties>
"#;

#[test]
fn o12_properties_of_rtt_are_read_with_their_places() {
    let read = asmotion_scdl::cpf("pid.cpf", CPF);
    let keys = read.properties.entries.iter();
    let keys: Vec<_> = keys
        .map(|entry| {
            let (key, value) = (&entry.key, read.sources.snippet(entry.node.span));
            format!("{}: {} {value}", key.value, entry.node.value.describe())
        })
        .collect();
    let found = rendered(&read.report, &read.sources);
    insta::assert_snapshot!(format!("{}\n==== findings\n{found}", keys.join("\n")));
}
