//! Property files (O12): saving, loading, comparing and checking.
#![allow(missing_docs, clippy::expect_used, reason = "tests")]

#[path = "../../plan/tests/support/render.rs"]
mod render;

use asmotion_component::Interface;
use asmotion_component::declaration::Declaration;
use asmotion_composite::property_file;
use asmotion_datum::Datum;

/// A component with array and list properties.
fn declaration() -> Declaration {
    let mut interface = Interface::new();
    for (name, doc) in [("kp", "for the error"), ("ki", "for its sum")] {
        let gain = interface.setting(name, 1.0, doc);
        gain.range(0.0..=10.0).unit("1/s").declare();
    }
    interface.property("limits", vec![-1.0, 1.0], "of what is put out");
    interface.declaration().clone()
}

#[test]
fn o12_what_is_saved_is_loaded_again_and_does_not_differ() {
    let declared = declaration();
    let values = vec![
        ("kp".to_owned(), Datum::Float(2.0)),
        ("ki".to_owned(), Datum::Float(0.25)),
        ("limits".to_owned(), Datum::of(&[-2.0, 2.5]).expect("data")),
    ];
    let text = property_file::write(&declared, &values);
    insta::assert_snapshot!(text);
    let read = property_file::read("pid.toml", &text, "Pid", &declared);
    assert!(!read.report.has_errors() && read.missing.is_empty());
    assert!(property_file::difference(&read.properties, &values).is_empty());
    let other = property_file::read("pid.toml", "kp = 2\nki = 0.5\n", "Pid", &declared);
    assert_eq!(
        property_file::difference(&other.properties, &values),
        [("ki", &Datum::Float(0.5), &Datum::Float(0.25))]
    );
    assert_eq!(other.missing, ["limits"]);
}

#[test]
fn o12_a_file_of_properties_is_checked_before_anything_is_set() {
    let text = "kp = 2.0\nkj = 0.5\nki = -1\nlimits = [0.0, \"a\"]\n";
    let read = property_file::read("pid.toml", text, "Pid", &declaration());
    insta::assert_snapshot!(render::report(&read.sources, &read.report));
}
