//! Messages through every representation.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs, reason = "tests")]

use asmotion_datum::{
    Codec, Datum, FieldName, Message, Numbers, OutlineKey, Schema, Shape, cbor, json,
};

asmotion_datum::message! {
    /// A vector.
    #[derive(Copy)]
    pub struct Vector3 = "geometry_msgs/Vector3" {
        /// metres
        pub x: f64,
        pub y: f64,
        pub z: f64 = 1.0,
    }

    /// A scan.
    pub struct Scan = "test/Scan" {
        /// where the sensor was
        pub at: Vector3,
        /// metres; +Infinity where nothing is (REP-117)
        pub ranges: Vec<f32>,
        pub cells: Vec<i8>,
        pub raw: Vec<u8>,
        pub covariance: [f64; 36],
        pub frame: String,
        pub trail: Vec<Vector3>,
        pub maybe: Option<Vector3>,
        pub count: u32,
        pub big: i64,
        pub ok: bool,
    }

    /// A message without fields.
    #[derive(Eq)]
    pub struct Empty = "std_msgs/Empty" {}
}

fn scan() -> Scan {
    Scan {
        at: Vector3 {
            x: 0.1,
            y: -2.5e-300,
            z: 7.0,
        },
        ranges: vec![1.5, f32::INFINITY, f32::NEG_INFINITY, 0.1],
        cells: vec![-1, 0, 100, -128],
        raw: vec![0, 255],
        covariance: std::array::from_fn(|index| index as f64 / 7.0),
        frame: "laser".into(),
        trail: vec![Vector3::default(); 2],
        maybe: Some(Vector3::default()),
        count: u32::MAX,
        big: i64::MIN,
        ok: true,
    }
}

#[test]
fn a_message_survives_every_codec() {
    for message in [scan(), Scan::default()] {
        let datum = Datum::of(&message).unwrap();
        assert_eq!(datum.to::<Scan>().unwrap(), message);
        assert_eq!(
            cbor::decode::<Scan>(&cbor::encode(&message).unwrap()).unwrap(),
            message
        );
        assert_eq!(
            json::decode::<Scan>(&json::encode(&message).unwrap()).unwrap(),
            message
        );
        assert_eq!(
            cbor::decode::<Datum>(&cbor::encode(&datum).unwrap()).unwrap(),
            datum
        );
        assert_eq!(datum.to::<Datum>().unwrap(), datum);
        for codec in Codec::ALL {
            let bytes = codec.encode(&datum, Scan::schema()).unwrap();
            let read = codec.decode(&bytes, Scan::schema()).unwrap();
            assert_eq!(read.to::<Scan>().unwrap(), message);
            assert_eq!(Codec::of_content_type(codec.content_type()), Some(codec));
        }
    }
}

#[test]
fn nan_survives_every_codec() {
    let mut message = scan();
    message.ranges = vec![f32::NAN];
    message.at.x = f64::NAN;
    let by_cbor = cbor::decode::<Scan>(&cbor::encode(&message).unwrap()).unwrap();
    let by_json = json::decode::<Scan>(&json::encode(&message).unwrap()).unwrap();
    for back in [by_cbor, by_json] {
        assert!(back.ranges[0].is_nan() && back.at.x.is_nan());
    }
}

#[test]
fn an_empty_message_survives() {
    assert_eq!(
        cbor::decode::<Empty>(&cbor::encode(&Empty {}).unwrap()).unwrap(),
        Empty {}
    );
    assert_eq!(json::encode(&Empty {}).unwrap(), "{}");
}

#[test]
fn numeric_arrays_are_one_byte_string() {
    let datum = Datum::of(&scan()).unwrap();
    assert!(
        matches!(&*datum.get("cells").unwrap(), Datum::Numbers(Numbers::I8(cells)) if cells[0] == -1)
    );
    assert!(matches!(
        &*datum.get("covariance").unwrap(),
        Datum::Numbers(Numbers::F64(_))
    ));
    assert!(matches!(&*datum.get("raw").unwrap(), Datum::Bytes(_)));

    let grid = Scan {
        cells: vec![3; 160_000],
        ..Scan::default()
    };
    let overhead = cbor::encode(&grid).unwrap().len() - 160_000;
    assert!(overhead < 500, "{overhead} bytes beside the cells");
}

#[test]
fn a_path_finds_what_is_inside() {
    let datum = Datum::of(&scan()).unwrap();
    assert_eq!(datum.get("at.x").as_deref(), Some(&Datum::Float(0.1)));
    assert_eq!(datum.get("trail.1.z").as_deref(), Some(&Datum::Float(1.0)));
    assert_eq!(datum.get("ranges.0").as_deref(), Some(&Datum::Float(1.5)));
    assert_eq!(datum.get("cells.0").as_deref(), Some(&Datum::Int(-1)));
    assert_eq!(datum.get("").as_deref(), Some(&datum));
    for nowhere in [
        "at.w",
        "trail.2",
        "cells.4",
        "cells.0.x",
        "frame.x",
        "trail.x",
    ] {
        assert_eq!(datum.get(nowhere), None, "{nowhere}");
    }
}

#[test]
fn omitted_fields_have_their_initial_value_and_unknown_ones_are_refused() {
    assert_eq!(
        json::decode::<Vector3>(r#"{"x": 3}"#).unwrap(),
        Vector3 {
            x: 3.0,
            y: 0.0,
            z: 1.0
        }
    );
    let error = json::decode::<Scan>(r#"{"at": {"w": 3}}"#).unwrap_err();
    assert!(
        error.to_string().starts_with("`at`: unknown field `w`"),
        "{error}"
    );
}

#[test]
fn a_repeated_name_is_an_error_in_every_codec() {
    let json = r#"{"trail": [{}, {"x": 1.0, "x": 2.0}]}"#;
    let error = json::decode::<Datum>(json).unwrap_err();
    assert_eq!(error.to_string(), "`trail.1`: the field `x` occurs twice");
    for count in [1, 40] {
        let names = (0..count).map(|n| format!("n{n}")).chain(["n0".to_owned()]);
        let many = Datum::record(names.map(|name| (name, Datum::Null)));
        let record = Datum::record([("at", many)]);
        let cbor = cbor::encode(&record).unwrap();
        for error in [
            cbor::decode::<Datum>(&cbor).unwrap_err(),
            json::decode::<Datum>(&json::encode(&record).unwrap()).unwrap_err(),
        ] {
            let expected = "`at`: the field `n0` occurs twice";
            assert_eq!(error.to_string(), expected, "{count}");
        }
    }
    let twice = || Datum::record([("x", Datum::Int(1)), ("x", Datum::Int(2))]);
    let error = Scan::of_datum(&Datum::record([("at", twice())])).unwrap_err();
    assert!(
        error.to_string().starts_with("`at`: duplicate field `x`"),
        "{error}"
    );
}

#[test]
fn a_float_as_a_text_is_not_complete() {
    let list = || Schema::plain(Shape::List(Box::new(Schema::plain(Shape::F64))));
    let schema = Schema::record("test/Floats", vec![OutlineKey::new("all", "", list())]);
    let floats = |all: Vec<Datum>| Datum::record([("all", Datum::List(all))]);
    let written = floats(vec![Datum::Float(1.0), Datum::text("-Infinity")]);
    assert!(schema.accepts(&written).is_ok() && !schema.is_complete(&written));
    let complete = schema.complete(written).unwrap();
    let expected = vec![Datum::Float(1.0), Datum::Float(f64::NEG_INFINITY)];
    assert_eq!(complete, floats(expected));
    assert!(schema.is_complete(&complete));
}

#[test]
fn an_error_names_the_place() {
    let error = |text: &str| {
        let error = Scan::of_datum(&json::decode(text).unwrap()).unwrap_err();
        let decoded = json::decode::<Scan>(text).unwrap_err();
        assert_eq!(decoded.to_string(), error.to_string());
        error
    };
    let far = error(r#"{"trail": [{}, {"x": "far"}]}"#);
    assert_eq!(far.path, "trail.1.x");
    assert_eq!(error(r#"{"cells": [1, 200]}"#).path, "cells.1");
    assert_eq!(
        error(r#"{"covariance": [1.0]}"#).to_string(),
        "`covariance`: expected 36 elements, found 1"
    );
    for (text, problem) in [
        (
            r#"{"at": [1, 2, 3]}"#,
            "`at`: invalid type: sequence, expected struct Vector3",
        ),
        (
            r#"{"at": null}"#,
            "`at`: invalid type: Option value, expected struct Vector3",
        ),
        (
            r#"{"trail": {}}"#,
            "`trail`: invalid type: map, expected a list of geometry_msgs/Vector3",
        ),
    ] {
        assert!(
            error(text).to_string().starts_with(problem),
            "{}",
            error(text)
        );
    }
}

#[test]
fn a_schema_says_what_the_struct_is() {
    let schema = Scan::schema();
    assert_eq!(schema.name, "test/Scan");
    assert_eq!(
        schema.shape.to_string(),
        "{at: geometry_msgs/Vector3, ranges: float32[], cells: int8[], raw: uint8[], covariance: float64[36], \
         frame: string, trail: geometry_msgs/Vector3[], maybe: geometry_msgs/Vector3?, count: uint32, big: int64, ok: bool}"
    );
    let Shape::Record(fields) = &schema.shape else {
        panic!("a record")
    };
    assert_eq!(
        fields[1].doc,
        "metres; +Infinity where nothing is (REP-117)"
    );
    assert_eq!(
        json::decode::<asmotion_datum::Schema>(&json::encode(schema).unwrap()).unwrap(),
        *schema
    );
}

mod other {
    asmotion_datum::message! {
        pub struct Vector3 = "geometry_msgs/Vector3" { pub x: f64, pub y: f32, pub z: f64 }
        pub struct Scan = "test/Scan" { pub at: Vector3 }
    }
}

#[test]
fn a_comparison_names_the_first_difference() {
    assert_eq!(Scan::schema().compare(Scan::schema()), Ok(()));
    assert_eq!(Scan::schema().compare(Datum::schema()), Ok(()));
    let difference = Scan::schema().compare(other::Scan::schema()).unwrap_err();
    assert_eq!(
        difference.to_string(),
        "`at.y`: float64 here, float32 there"
    );
    let difference = Empty::schema().compare(Scan::schema()).unwrap_err();
    assert_eq!(
        difference.to_string(),
        "std_msgs/Empty here, test/Scan there"
    );
}

#[test]
fn what_a_message_says_fits_its_schema_however_it_came() {
    for message in [scan(), Scan::default()] {
        let datum = Datum::of(&message).unwrap();
        for codec in Codec::ALL {
            let bytes = codec.encode(&datum, Scan::schema()).unwrap();
            let read = codec.decode(&bytes, Scan::schema()).unwrap();
            Scan::schema().accepts(&read).unwrap();
        }
    }
}

#[test]
fn what_does_not_fit_a_schema_says_where() {
    for (text, words) in [
        (
            r#"{"at": {"x": "1"}}"#,
            "`at.x`: expected `float64`, found a string",
        ),
        (
            r#"{"at": {"w": 1}}"#,
            "`at`: unknown field `w` of `geometry_msgs/Vector3`; its fields: `x`, `y`, `z`",
        ),
        (
            r#"{"ranges": [1, null]}"#,
            "`ranges.1`: expected `float32`, found nothing",
        ),
        (
            r#"{"cells": [0, 128]}"#,
            "`cells.1`: 128 is not between -128 and 127",
        ),
        (
            r#"{"covariance": [0, 1]}"#,
            "`covariance`: expected `float64[36]`, found 2 elements",
        ),
        (
            r#"{"maybe": 1}"#,
            "`maybe`: expected `geometry_msgs/Vector3`, found an integer",
        ),
        (r#"{"ok": null}"#, "`ok`: expected `bool`, found nothing"),
        ("7", "expected `test/Scan`, found an integer"),
    ] {
        let datum: Datum = json::decode(text).unwrap();
        let error = Scan::schema().accepts(&datum).unwrap_err().to_string();
        assert!(error.contains(words), "{text}: {error}");
    }
    for text in [
        "{}",
        r#"{"ok": true, "count": 1, "maybe": null, "ranges": ["NaN", 1]}"#,
    ] {
        let datum: Datum = json::decode(text).unwrap();
        Scan::schema().accepts(&datum).unwrap();
    }
}

asmotion_datum::message! {
    /// A share that must be between 0 and 1.
    pub struct Share = "test/Share", check = check_share {
        pub share: f64,
    }

    /// Messages in fields of all kinds.
    pub struct Shares = "test/Shares" {
        pub one: Share,
        pub many: Vec<Share>,
        pub pair: [Share; 2],
        pub maybe: Option<Share>,
        pub number: f64,
    }
}

fn check_share(share: &Share) -> Result<(), asmotion_datum::DatumError> {
    if (0.0..=1.0).contains(&share.share) {
        return Ok(());
    }
    let problem = asmotion_datum::DatumProblem::Implausible("not between 0 and 1");
    Err(asmotion_datum::DatumError::new(problem).within("share"))
}

#[test]
fn a_check_covers_the_messages_in_all_fields_and_names_the_place() {
    let bad = || Share { share: f64::NAN };
    let good = Shares {
        number: f64::NAN,
        maybe: Some(Share::default()),
        ..Shares::default()
    };
    assert_eq!(good.check(), Ok(()));
    let change = |change: fn(&mut Shares, Share)| {
        let mut shares = good.clone();
        change(&mut shares, bad());
        shares.check().unwrap_err().to_string()
    };
    let end = "share`: not between 0 and 1";
    assert_eq!(change(|it, bad| it.one = bad), format!("`one.{end}"));
    assert_eq!(
        change(|it, bad| it.many = vec![Share::default(), bad]),
        format!("`many.1.{end}")
    );
    assert_eq!(change(|it, bad| it.pair[0] = bad), format!("`pair.0.{end}"));
    assert_eq!(
        change(|it, bad| it.maybe = Some(bad)),
        format!("`maybe.{end}")
    );
    assert!(std::sync::Arc::new(bad()).check().is_err());
}

#[test]
fn a_path_leads_to_the_same_part_of_data_and_of_their_schema() {
    let number = || Schema::plain(Shape::F64);
    let point = Schema::record("example/Point", vec![OutlineKey::new("x", "m", number())]);
    let maybe = Schema::plain(Shape::Option(Box::new(point.clone())));
    let fields = vec![
        OutlineKey::new("goal", "", maybe.clone()),
        OutlineKey::new("path", "", Schema::many(maybe, None)),
        OutlineKey::new("corners", "", Schema::many(point.clone(), Some(2))),
        OutlineKey::new("other", "", Schema::plain(Shape::Any)),
    ];
    let schema = Schema::record("example/Plan", fields);
    let at = || Datum::record([("x", Datum::Float(0.5))]);
    let plan = Datum::record([
        ("goal", at()),
        ("path", Datum::List(vec![at()])),
        ("corners", Datum::List(vec![at(), at()])),
        ("other", Datum::record([("y", at())])),
    ]);
    schema.accepts(&plan).unwrap();
    for path in ["goal.x", "path.0.x", "corners.1.x"] {
        assert_eq!(schema.part_at(path), Some(&number()), "{path}");
        assert_eq!(
            plan.get(path).as_deref(),
            Some(&Datum::Float(0.5)),
            "{path}"
        );
    }
    assert_eq!(
        schema.part_at("path.0").map(|it| it.fields().len()),
        Some(1)
    );
    assert_eq!(schema.part_at("corners.1"), Some(&point));
    assert_eq!(schema.part_at(""), Some(&schema));
    for path in ["goal.goal", "goal.x.x", "corners.2", "path.x", "gaol"] {
        assert_eq!(
            (schema.part_at(path), plan.get(path)),
            (None, None),
            "{path}"
        );
    }
    assert_eq!(
        schema.part_at("other.y.x").map(|it| &it.shape),
        Some(&Shape::Any)
    );
    assert_eq!(schema.parts().count(), 4);
    let mut changed = schema.clone();
    for part in changed.parts_mut() {
        *part = number();
    }
    assert!(changed.parts().all(|part| *part == number()));
}

/// Returns whether `shared_name` shares this name.
fn is_shared(name: &str) -> bool {
    match asmotion_datum::shared_name(name) {
        FieldName::Borrowed(shared) => {
            assert_eq!(shared, name);
            true
        }
        FieldName::Owned(own) => {
            assert_eq!(own, name);
            false
        }
    }
}

/// A stranger whose definitions have ever new names, or very long ones, does not fill the memory.
#[test]
fn names_of_fields_are_shared_up_to_a_number_and_a_length() {
    let (longest, longer) = ("n".repeat(128), "n".repeat(129));
    assert!(is_shared("linear") && is_shared(&longest) && !is_shared(&longer));
    let before = asmotion_datum::shared_name("linear");
    let many = (0..1 << 16).filter(|number| is_shared(&format!("name{number}")));
    assert_eq!(many.count(), (1 << 16) - 2);
    assert!(!is_shared("angular") && !is_shared(&longer) && is_shared("linear"));
    assert!(std::ptr::eq(
        &*before,
        &*asmotion_datum::shared_name("linear")
    ));
}
