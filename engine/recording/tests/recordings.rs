//! Reads recordings as they were written, and refuses tables that are none.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use asmotion_component::Time;
use asmotion_datum::{Datum, OutlineKey, Schema, Shape};
use asmotion_recording::{PortRecording, read_samples};
use asmotion_runtime::Event;

const SECOND: i64 = 1_000_000_000;

/// Writes samples of ports as a recording.
fn written(samples: &[(i64, &str, Datum)]) -> String {
    let mut recording = PortRecording::of(&[]);
    for (sequence, (nanos, port, sample)) in (1..).zip(samples) {
        let (component, port) = port.split_once('.').unwrap();
        let published = Event::Published {
            component,
            port,
            topic: None,
            sequence,
            sample,
        };
        recording.note(Time::from_nanos(*nanos), &published);
    }
    let mut text = Vec::new();
    recording.write(&mut text).unwrap();
    String::from_utf8(text).unwrap()
}

fn record(fields: &[(&'static str, Schema)]) -> Schema {
    let key = |(name, schema): &(&'static str, Schema)| OutlineKey::new(*name, "", schema.clone());
    Schema::plain(Shape::Record(fields.iter().map(key).collect()))
}

fn joint() -> Schema {
    record(&[
        ("count", Schema::plain(Shape::U16)),
        (
            "torque",
            Schema::plain(Shape::Option(Box::new(Schema::plain(Shape::F64)))),
        ),
    ])
}

fn arm() -> Schema {
    record(&[
        ("name", Schema::plain(Shape::Text)),
        ("ready", Schema::plain(Shape::Bool)),
        ("offset", Schema::plain(Shape::F64)),
        ("joints", Schema::many(joint(), None)),
        ("gains", Schema::many(Schema::plain(Shape::F32), Some(2))),
        ("total", record(&[("count", Schema::plain(Shape::I64))])),
    ])
}

fn sample(name: &str, offset: f64, torques: &[Option<f64>]) -> Datum {
    let joint = |torque: &Option<f64>| {
        let torque = torque.map_or(Datum::Null, Datum::Float);
        Datum::record([("count", Datum::Int(7)), ("torque", torque)])
    };
    Datum::record([
        ("name", Datum::text(name)),
        ("ready", Datum::Bool(true)),
        ("offset", Datum::Float(offset)),
        ("joints", Datum::List(torques.iter().map(joint).collect())),
        (
            "gains",
            Datum::List(vec![Datum::Float(1.0), Datum::Float(f64::INFINITY)]),
        ),
        ("total", Datum::record([("count", Datum::Int(i64::MIN))])),
    ])
}

#[test]
fn samples_are_read_as_they_were_written() {
    let twelve: Vec<Option<f64>> = (0..12).map(|it| Some(f64::from(it) / 3.0)).collect();
    let samples = [
        (0, sample("12", -0.0, &[])),
        (SECOND / 2, sample("a, \"b\"\nc", 1e308, &[None, Some(0.1)])),
        // two at one instant
        (SECOND / 2, sample("true", 3.0, &twelve)),
        (7 * SECOND + 1, sample("null", -1.5e-300, &[Some(-0.0)])),
    ];
    let mut all = Vec::new();
    for (at, sample) in &samples {
        all.push((*at, "Arm.state", sample.clone()));
        all.push((*at, "Arm.state2", Datum::Int(*at)));
    }
    let text = written(&all);
    let read = read_samples(text.as_bytes(), "Arm.state", &arm()).unwrap();
    let expected = samples.map(|(at, sample)| (Time::from_nanos(at), sample));
    // as text, because of the sign of zero
    assert_eq!(format!("{read:?}"), format!("{expected:?}"));
    let numbers = read_samples(text.as_bytes(), "Arm.state2", &Schema::plain(Shape::I64));
    let numbers: Vec<Datum> = numbers.unwrap().into_iter().map(|(_, it)| it).collect();
    assert_eq!(numbers, expected.map(|(at, _)| Datum::Int(at.nanos())));
}

#[test]
fn data_of_an_unknown_type_is_guessed() {
    let joint = Datum::record([
        ("angle", Datum::Float(-2.5)),
        ("name", Datum::text("wrist")),
    ]);
    let sample = Datum::record([
        ("joints", Datum::List(vec![joint])),
        ("moving", Datum::Bool(false)),
    ]);
    let text = written(&[(0, "Arm.state", sample.clone())]);
    let read = read_samples(text.as_bytes(), "Arm.state", &Schema::plain(Shape::Any)).unwrap();
    assert_eq!(read, [(Time::ZERO, sample)]);
}

#[test]
fn what_cannot_be_read_is_named() {
    let many = Datum::List(vec![Datum::Float(1.0); 65]);
    let scan = |ranges: Datum| Datum::record([("ranges", ranges)]);
    let recording = written(&[
        (0, "Laser.scan", scan(many)),
        (0, "Laser.short", scan(Datum::List(vec![Datum::Int(1)]))),
        (
            SECOND,
            "Laser.short",
            scan(Datum::List(vec![Datum::text("far")])),
        ),
    ]);
    let ranges = record(&[("ranges", Schema::many(Schema::plain(Shape::F64), None))]);
    let any = Schema::plain(Shape::Any);
    let said = |text: &str, port: &str, schema: &Schema| {
        read_samples(text.as_bytes(), port, schema)
            .unwrap_err()
            .to_string()
    };
    insta::assert_snapshot!(
        [
            said(&recording, "Laser.scan", &ranges),
            said(&recording, "Laser.scan", &any),
            said(&recording, "Laser.shor", &any),
            said(&recording, "Laser.short", &ranges),
            said(&recording, "Laser.short", &record(&[])),
            said("t,Laser.short\n0,1\n", "Laser.short", &any),
            said("time_s,Laser.short\n-1.5,1\n", "Laser.short", &any),
            said("time_s,Laser.short\n99999999999999,1\n", "Laser.short", &any),
            said("time_s,Laser.short\n0,1,2\n", "Laser.short", &any),
            said("", "Laser.short", &any),
            said("\u{0}\u{1}", "Laser.short", &any),
        ]
        .join("\n"),
        @"
of long lists such as `Laser.scan.ranges`, only the length is recorded
of long lists such as `Laser.scan.ranges`, only the length is recorded
the recording has no port `Laser.shor`; its columns are `Laser.scan.ranges.count`, `Laser.short.ranges.0`
line 3 has a sample of `Laser.short` that does not fit: `ranges.0`: expected `float64`, found a string
line 2 has a sample of `Laser.short` that does not fit: unknown field `ranges` of `{}`; its fields: 
this is no recording of `asmotion run --record`: its first column is not `time_s`
this is no recording of `asmotion run --record`: `-1.5` is no time in seconds
this is no recording of `asmotion run --record`: `99999999999999` is no time in seconds
this is no recording of `asmotion run --record`: CSV error: record 1 (line: 2, byte: 19): found record with 3 fields, but the previous record has 2 fields
this is no recording of `asmotion run --record`: its first column is not `time_s`
this is no recording of `asmotion run --record`: its first column is not `time_s`
"
    );
}
