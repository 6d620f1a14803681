//! Derived declarations equal those written by hand.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::common::{Double, Number, Spell, behaviour};
use asmotion_component::declaration::PropertyDeclaration;
use asmotion_component::{
    Activity, In, Interface, Out, Ports, Properties, PropertySet, Provided, Required, Span, Word,
};
use asmotion_datum::Datum;
use asmotion_runtime::{Run, System};

/// Rounding mode of a limiter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Word)]
enum Rounding {
    #[default]
    Down,
    TowardsZero,
}

#[derive(Clone, Debug, PartialEq, Properties)]
struct Limits {
    /// Forward speed limit,
    /// on a straight line.
    ///
    /// Second paragraph.
    #[property(unit = "m/s", range = 0.01..=20.0, default = 0.5)]
    max_speed: f64,
    /// Beams of a sweep.
    #[property(range = 1..=1 << 10, default = 721)]
    beams: u32,
}

#[derive(Clone, Debug, PartialEq, Properties)]
struct Settings {
    #[property(flatten)]
    limits: Limits,
    /// Age from which a command no longer counts.
    #[property(range = "0s"..="1min", default = "150ms")]
    timeout_s: Duration,
    /// Rest between two attempts.
    #[property(unit = "ms", range = "1ms"..="2s", default = "20ms")]
    rest_ms: Duration,
    /// Planner.
    #[property(default = "astar", choices = ["astar", "lattice"])]
    algorithm: String,
    /// Rounding.
    #[property(words, default = Rounding::TowardsZero)]
    rounding: Rounding,
    /// Pose of the sensor: x m, y m, yaw rad.
    mount: [f64; 3],
    /// Goals.
    goals: Vec<f64>,
    /// Whether it works.
    #[property(default = true)]
    r#match: bool,
}

fn declared(name: &str) -> PropertyDeclaration {
    let mut interface = Interface::new();
    let _: PropertySet<Settings> = interface.properties();
    assert_eq!(interface.problems(), []);
    interface.declaration().property(name).unwrap().clone()
}

#[test]
fn a_field_carries_name_description_unit_range_and_default() {
    let speed = declared("max_speed");
    assert_eq!(
        speed.doc,
        "Forward speed limit, on a straight line.\nSecond paragraph."
    );
    assert_eq!(speed.unit, "m/s");
    assert_eq!(speed.default, 0.5.into());
    assert_eq!(speed.range, Some((0.01.into(), 20.0.into())));
    assert_eq!(declared("beams").range, Some((1.into(), 1024.into())));
    assert_eq!(declared("match").default, true.into());
    assert_eq!(
        declared("goals").default,
        Datum::of(&Vec::<f64>::new()).unwrap()
    );
}

#[test]
fn properties_are_declared_in_the_order_of_the_fields_those_of_a_flattened_struct_in_place() {
    let mut interface = Interface::new();
    let _: PropertySet<Settings> = interface.properties();
    let properties = interface.declaration().properties.iter();
    let names: Vec<_> = properties.map(|property| &*property.name).collect();
    assert_eq!(
        names,
        [
            "max_speed",
            "beams",
            "timeout_s",
            "rest_ms",
            "algorithm",
            "rounding",
            "mount",
            "goals",
            "match"
        ]
    );
}

#[test]
fn composites_write_a_duration_as_a_number_of_its_unit() {
    let timeout = declared("timeout_s");
    assert_eq!((timeout.unit.as_str(), timeout.default), ("s", 0.15.into()));
    assert_eq!(timeout.range, Some((0.0.into(), 60.0.into())));
    assert_eq!(timeout.schema.to_string(), "float64");
    let rest = declared("rest_ms");
    assert_eq!((rest.unit.as_str(), rest.default), ("ms", 20.0.into()));
    assert_eq!(rest.range, Some((1.0.into(), 2000.0.into())));
}

#[test]
fn words_are_the_choices_of_their_property() {
    let rounding = declared("rounding");
    assert_eq!(rounding.default, "towards_zero".into());
    assert_eq!(rounding.choices, ["down".into(), "towards_zero".into()]);
    let lawful: Vec<Datum> = vec!["astar".into(), "lattice".into()];
    assert_eq!(declared("algorithm").choices, lawful);
    assert_eq!(Rounding::of_word("down"), Some(Rounding::Down));
    assert_eq!(Rounding::of_word("up"), None);
}

#[test]
fn the_default_of_the_struct_is_the_default_of_the_declaration() {
    let settings = Settings::default();
    assert_eq!(
        settings.limits,
        Limits {
            max_speed: 0.5,
            beams: 721
        }
    );
    assert_eq!(settings.timeout_s, 150.ms());
    assert_eq!(settings.algorithm, "astar");
    assert_eq!(settings.rounding, Rounding::TowardsZero);
    assert!(settings.r#match && settings.goals.is_empty());
}

/// The snapshots that a component reads in successive cycles.
fn running(set: impl Fn(&mut System)) -> (System, Arc<Mutex<Vec<Settings>>>) {
    let seen: Arc<Mutex<Vec<Settings>>> = Arc::default();
    let mut system = System::new();
    let log = Arc::clone(&seen);
    system
        .add(
            "A",
            Activity::periodic(10.ms()),
            behaviour(move |interface| {
                let mut properties: PropertySet<Settings> = interface.properties();
                move |cycle| {
                    let snapshot = properties.refresh(cycle).clone();
                    log.lock().unwrap().push(snapshot);
                    Ok(())
                }
            }),
        )
        .unwrap();
    set(&mut system);
    (system, seen)
}

#[test]
fn a_snapshot_has_what_was_set_before_the_start_and_what_changes_while_it_runs() {
    let (system, seen) = running(|system| {
        let a = system.id("A").unwrap();
        system.set_property(a, "timeout_s", &0.25.into()).unwrap();
        system.set_property(a, "rounding", &"down".into()).unwrap();
    });
    let mut run = system.simulate();
    run.run_for(10.ms());
    let changes = [("rest_ms", 1.5.into()), ("max_speed", 2.0.into())];
    let changes = changes.map(|(name, value): (_, Datum)| (name.to_owned(), value));
    run.set_properties("A", &changes).unwrap();
    run.run_for(10.ms());
    let seen = seen.lock().unwrap();
    let (first, last) = (seen.first().unwrap(), seen.last().unwrap());
    assert_eq!((first.timeout_s, first.rest_ms), (250.ms(), 20.ms()));
    assert_eq!(first.rounding, Rounding::Down);
    assert_eq!((last.rest_ms, last.limits.max_speed), (1500.us(), 2.0));
    assert_eq!(last.timeout_s, 250.ms());
}

#[test]
fn what_is_no_duration_and_no_word_is_refused() {
    let (mut system, _) = running(|_| {});
    let a = system.id("A").unwrap();
    for (name, value) in [
        ("timeout_s", Datum::from(-1.0)),
        ("timeout_s", f64::NAN.into()),
        ("timeout_s", 60.1.into()),
        ("rounding", "up".into()),
        ("algorithm", "dijkstra".into()),
    ] {
        assert!(
            system.set_property(a, name, &value).is_err(),
            "{name} = {value}"
        );
    }
}

#[derive(Ports)]
struct ArithmeticPorts {
    /// Numbers to double.
    numbers: In<Number>,
    /// Doubled numbers.
    #[port(name = "doubledNumbers")]
    doubled: Out<Number>,
    /// Doubles and spells.
    #[port(name = "arithmetic")]
    double: Provided<Double>,
    /// Doubles and spells.
    #[port(name = "arithmetic")]
    spell: Provided<Spell>,
    /// Another speller.
    #[port(optional)]
    speller: Required<Spell>,
    /// Another doubler.
    doubler: Required<Double>,
}

impl ArithmeticPorts {
    fn handles(&self) -> [String; 6] {
        [
            format!("{:?}", self.numbers),
            format!("{:?}", self.doubled),
            format!("{:?}", self.double),
            format!("{:?}", self.spell),
            format!("{:?}", self.speller),
            format!("{:?}", self.doubler),
        ]
    }
}

#[test]
fn ports_are_declared_as_by_hand() {
    let mut derived = Interface::new();
    let ports: ArithmeticPorts = derived.ports();
    let mut written = Interface::new();
    let by_hand = {
        let speller = written.require::<Spell>("speller", "Another speller.");
        ArithmeticPorts {
            numbers: written.input("numbers", "Numbers to double."),
            doubled: written.output("doubledNumbers", "Doubled numbers."),
            double: written.serve("arithmetic", "Doubles and spells."),
            spell: written.serve("arithmetic", "Doubles and spells."),
            speller: written.optional(speller),
            doubler: written.require("doubler", "Another doubler."),
        }
    };
    assert_eq!(derived.declaration(), written.declaration());
    assert_eq!(ports.handles(), by_hand.handles());
    assert_eq!(derived.problems(), []);
}

#[test]
fn the_tables_of_a_declaration_show_its_ends_and_properties() {
    let mut interface = Interface::new();
    let _: PropertySet<Settings> = interface.properties();
    interface.input::<Number>("n", "Numbers | even ones");
    interface.output::<Number>("twice", "Doubled,\nin order");
    interface.serve::<Double>("sums", "Doubles");
    interface.serve::<Spell>("sums", "Doubles");
    let spell = interface.require::<Spell>("speech", "Spells");
    interface.optional(spell);
    interface.require::<Double>("helper", "Doubles, too");
    assert_eq!(interface.problems(), []);
    let expected = r#"
| port | type | |
|---|---|---|
| in `n` | `test/Number` | Numbers \| even ones |
| out `twice` | `test/Number` | Doubled,<br>in order |
| service `sums` | `test/Arithmetic`: `double`, `spell` | Doubles |
| reference `speech` (optional) | `test/Arithmetic`: `spell` | Spells |
| reference `helper` | `test/Arithmetic`: `double` | Doubles, too |

| property | default | range | |
|---|---|---|---|
| `max_speed` | 0.5 m/s | 0.01 … 20.0 | Forward speed limit, on a straight line.<br>Second paragraph. |
| `beams` | 721 | 1 … 1024 | Beams of a sweep. |
| `timeout_s` | 0.15 s | 0.0 … 60.0 | Age from which a command no longer counts. |
| `rest_ms` | 20.0 ms | 1.0 … 2000.0 | Rest between two attempts. |
| `algorithm` | `astar` | astar, lattice | Planner. |
| `rounding` | `towards_zero` | down, towards_zero | Rounding. |
| `mount` | [0.0, 0.0, 0.0] |  | Pose of the sensor: x m, y m, yaw rad. |
| `goals` | [] |  | Goals. |
| `match` | true |  | Whether it works. |
"#;
    assert_eq!(format!("\n{}", interface.declaration().tables()), expected);
    let without = Interface::new().declaration().tables();
    assert_eq!(without, "| port | type | |\n|---|---|---|\n");
}
