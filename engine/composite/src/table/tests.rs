//! Tests of the derive macro: reading, diagnostics, defaults, writing and documentation.

use asmotion_derive::Table;
use asmotion_diagnostics::{FileId, Sources, Span};
use serde_json::json;

use super::keys::Reader;
use super::{NamedValue, Resolver, Table as _, WrittenTable};
use crate::at::At;
use crate::environment::EmptyEnvironment;
use crate::model::{Amount, Delivery};
use crate::scope::{PropertyScope, SubstitutionNotes};
use crate::tree;

/// A lamp.
#[derive(Clone, Debug, Table)]
#[table(of = "a lamp", example = "{ watt = 5 }", resolved = PlannedLamp)]
struct Lamp {
    /// Power.
    #[key(unit = "watts", range = 1..=60, example = "5")]
    watt: At<u64>,
    /// Time until it switches off.
    #[key(range = 0..=100, default = 9)]
    time: Option<At<Amount>>,
    /// Delivery mode.
    #[key(name = "when", default)]
    delivery: Option<At<Delivery>>,
    /// Other lamps.
    #[key(local)]
    near: Vec<At<String>>,
    /// Suspension.
    #[key(flatten)]
    from: Hook,
}

/// Suspension of a lamp.
#[derive(Clone, Debug, PartialEq, Table)]
#[table(of = "a lamp", reason = "it hangs once", resolved = PlannedHook)]
enum Hook {
    /// The wall.
    Wall(bool),
    /// The ceiling.
    Ceiling {
        /// The ceiling: how high.
        #[key(name = "ceiling", range = 0.0..=4.5)]
        height: f64,
        /// The room.
        #[key(local)]
        room: Option<String>,
    },
}

/// Looks of a lamp.
#[derive(Clone, Debug, Table)]
#[table(of = "looks", into = PaintedLamp)]
struct Looks {
    /// Colour.
    colour: At<String>,
    /// Delivery mode of its changes.
    #[key(or_default)]
    delivery: Option<At<Delivery>>,
    /// Materials of its parts.
    parts: Vec<NamedValue<At<String>>>,
    /// The same in words.
    #[key(written)]
    #[expect(dead_code, reason = "only read")]
    words: Option<String>,
}

/// A lamp of another crate.
#[derive(Debug, PartialEq)]
struct PaintedLamp {
    colour: Box<str>,
    delivery: Delivery,
    parts: Vec<(String, String)>,
}

impl super::Written for Box<str> {
    fn toml(&self) -> Option<toml_edit::Value> {
        Some((&**self).into())
    }
}

fn read(text: &str) -> (Option<Lamp>, Vec<String>) {
    let file = FileId::default();
    let (table, _) = tree::parse(file, text);
    let mut reader = Reader::new(text);
    let mut keys = reader.keys(&table, "a lamp", Span::new(file, 0, 0));
    let name = At::new("lamp".to_owned(), Span::new(file, 0, 0));
    let lamp = Lamp::read_keys(&mut keys, &name);
    drop(keys);
    let found = reader.report.diagnostics.iter();
    let found = found.map(|it| format!("{} {}", it.code, it.message));
    (lamp, found.collect())
}

#[test]
fn it_reads_what_is_there_and_says_what_is_wrong() {
    let (lamp, found) = read("watt = 5\nnear = \"b\"\nceiling = 2\nroom = \"hall\"");
    let lamp = lamp.unwrap();
    assert_eq!(found, [""; 0]);
    assert_eq!((lamp.watt.value, lamp.near.len()), (5, 1));
    let room = Some("hall".to_owned());
    assert_eq!(lamp.from, Hook::Ceiling { height: 2.0, room });
    let (lamp, found) =
        read("watt = 99\nwhen = \"cycl\"\nwall = true\nceiling = 1.0\nroom = \"a\"");
    assert!(lamp.is_none());
    assert_eq!(
        found,
        [
            "C007 `watt` must be between 1 and 60, not 99",
            "C006 invalid value `cycl` for `when`",
            "C010 `ceiling` cannot be combined with `wall`",
            "C003 unknown key `room` in a lamp",
        ]
    );
    let (_, found) = read("");
    assert_eq!(
        found,
        [
            "C004 missing key `watt` in a lamp",
            "C004 missing key `wall` in a lamp"
        ]
    );
}

#[test]
fn its_twin_has_the_defaults_and_is_written_again() {
    let (lamp, _) = read("watt = 5\nnear = [\"b\"]\nwall = true");
    let (sources, mut notes) = (Sources::new(), SubstitutionNotes::default());
    let scope = PropertyScope::new(&EmptyEnvironment, &sources);
    let mut to = Resolver::new(&scope, "house/", &mut notes);
    let lamp: PlannedLamp = to.of(&lamp.unwrap()).unwrap();
    assert_eq!((lamp.time, lamp.delivery), (9, Delivery::Event));
    assert_eq!(lamp.near, ["house/b"]);
    let written = lamp.keys("").inline().unwrap().to_string();
    assert_eq!(
        written.trim(),
        "{ watt = 5, time = 9, when = \"event\", near = [\"house/b\"], wall = true }"
    );
    let room = Some("hall".to_owned());
    let hook = to.of(&Hook::Ceiling { height: 2.5, room }).unwrap();
    assert_eq!(
        hook.keys("").inline().unwrap().to_string(),
        "{ ceiling = 2.5, room = \"house/hall\" }"
    );
}

#[test]
fn it_resolves_into_a_type_of_another_crate() {
    let text = "colour = \"red\"\nwords = \"red\"\nparts = { shade = \"paper\", foot = \"tin\" }";
    let (table, _) = tree::parse(FileId::default(), text);
    let mut reader = Reader::new(text);
    let mut keys = reader.keys(&table, "looks", Span::default());
    let name = At::new(String::new(), Span::default());
    let looks = Looks::read_keys(&mut keys, &name).unwrap();
    let (sources, mut notes) = (Sources::new(), SubstitutionNotes::default());
    let scope = PropertyScope::new(&EmptyEnvironment, &sources);
    let lamp = Resolver::new(&scope, "", &mut notes).of(&looks).unwrap();
    let part = |name: &str, material: &str| (name.to_owned(), material.to_owned());
    let painted = PaintedLamp {
        colour: "red".into(),
        delivery: Delivery::Event,
        parts: vec![part("shade", "paper"), part("foot", "tin")],
    };
    assert_eq!(lamp, painted);
    let written = lamp.keys("").inline().unwrap().to_string();
    assert_eq!(
        written,
        "{ colour = \"red\", delivery = \"event\", parts = { shade = \"paper\", foot = \"tin\" } }"
    );
}

#[test]
fn its_schema_has_documentation_units_ranges_and_defaults() {
    let schema = Lamp::outline().schema();
    assert_eq!(
        schema["properties"]["watt"],
        json!({ "type": "integer", "minimum": 1, "maximum": 60, "examples": [5], "description": "Power. In watts." })
    );
    assert_eq!(schema["properties"]["time"]["default"], json!(9));
    assert_eq!(schema["required"], json!(["watt"]));
    assert_eq!(
        schema["oneOf"],
        json!([{ "required": ["wall"] }, { "required": ["ceiling"] }])
    );
    assert_eq!(schema["dependencies"], json!({ "room": ["ceiling"] }));
}
