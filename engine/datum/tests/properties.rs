//! Codecs against arbitrary data.
#![allow(clippy::unwrap_used, reason = "tests")]

use asmotion_datum::{Codec, Datum, DatumError, DatumProblem, Message, Numbers, cbor, json};
use proptest::prelude::*;

/// Floats with all bit patterns except NaN, which is not equal to itself.
fn float() -> impl Strategy<Value = f64> {
    any::<u64>()
        .prop_map(f64::from_bits)
        .prop_filter("NaN is not equal to itself", |value| !value.is_nan())
}

/// Data that JSON can distinguish: no bytes, no packed numbers, no text that stands for a float.
fn plain() -> impl Strategy<Value = Datum> {
    let leaf = prop_oneof![
        Just(Datum::Null),
        any::<bool>().prop_map(Datum::Bool),
        any::<i64>().prop_map(Datum::Int),
        float()
            .prop_filter("JSON writes it as text", |value| value.is_finite())
            .prop_map(Datum::Float),
        ".*".prop_map(Datum::Text),
    ];
    nested(leaf)
}

/// Data of all kinds.
fn any_datum() -> impl Strategy<Value = Datum> {
    let leaf = prop_oneof![
        plain(),
        float().prop_map(Datum::Float),
        any::<Vec<u8>>().prop_map(|bytes| Datum::Bytes(bytes.into())),
        any::<Vec<i8>>().prop_map(|all| Datum::Numbers(Numbers::I8(all.into()))),
        any::<Vec<u16>>().prop_map(|all| Datum::Numbers(Numbers::U16(all.into()))),
        prop::collection::vec(float(), 0..20)
            .prop_map(|all| Datum::Numbers(Numbers::F64(all.into()))),
    ];
    nested(leaf)
}

fn nested(leaf: impl Strategy<Value = Datum> + 'static) -> impl Strategy<Value = Datum> {
    leaf.prop_recursive(4, 64, 8, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..8).prop_map(Datum::List),
            prop::collection::vec(("[a-z]{1,8}", inner), 0..8).prop_map(Datum::record),
        ]
    })
}

proptest! {
    #[test]
    fn cbor_returns_what_it_was_given(datum in any_datum()) {
        let bytes = cbor::encode(&datum).unwrap();
        prop_assert_eq!(cbor::decode::<Datum>(&bytes).unwrap(), datum);
    }

    #[test]
    fn json_returns_what_it_was_given(datum in plain()) {
        let text = json::encode(&datum).unwrap();
        prop_assert_eq!(json::decode::<Datum>(&text).unwrap(), datum);
    }

    #[test]
    fn floats_are_exact_in_both(value in float()) {
        prop_assert_eq!(json::decode::<f64>(&json::encode(&value).unwrap()).unwrap().to_bits(), value.to_bits());
        prop_assert_eq!(cbor::decode::<f64>(&cbor::encode(&value).unwrap()).unwrap().to_bits(), value.to_bits());
    }

    #[test]
    fn no_bytes_make_a_decoder_panic(bytes in any::<Vec<u8>>()) {
        for codec in Codec::ALL {
            let _ = codec.decode(&bytes, Datum::schema());
        }
    }

    #[test]
    fn damaged_messages_are_refused_or_read_never_worse(datum in any_datum(), at in any::<usize>(), by in 1u8..) {
        let mut bytes = cbor::encode(&datum).unwrap();
        let at = at % bytes.len();
        bytes[at] ^= by;
        let _ = cbor::decode::<Datum>(&bytes);
        bytes.truncate(at);
        prop_assert!(cbor::decode::<Datum>(&bytes).is_err());
    }
}

#[test]
fn what_nests_too_deep_is_refused() {
    let deep = vec![0x81; 100_000];
    let error = cbor::decode::<Datum>(&deep).unwrap_err();
    assert_eq!(error, DatumError::new(DatumProblem::TooDeep(64)));
    let text = "[".repeat(100_000);
    assert!(json::decode::<Datum>(&text).is_err());
}

#[test]
fn lengths_that_lie_are_refused_without_taking_memory() {
    // a list, a record, a text and a byte string that announce 2^60 elements and contain none
    for first in [0x9b, 0xbb, 0x7b, 0x5b] {
        let mut bytes = vec![first];
        bytes.extend((1_u64 << 60).to_be_bytes());
        assert!(cbor::decode::<Datum>(&bytes).is_err(), "{first:#x}");
    }
}

#[test]
fn enums_and_maps_travel_as_serde_writes_them() {
    use std::collections::BTreeMap;

    #[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
    enum Shape {
        Point,
        Circle(f64),
        Line(i8, u16),
        Box { width: f32 },
    }
    let shapes = BTreeMap::from([
        ("a".to_owned(), Shape::Point),
        ("b".to_owned(), Shape::Circle(0.1)),
        ("c".to_owned(), Shape::Line(-1, 2)),
        ("d".to_owned(), Shape::Box { width: 0.5 }),
    ]);
    assert_eq!(
        json::encode(&shapes).unwrap(),
        r#"{"a":"Point","b":{"Circle":0.1},"c":{"Line":[-1,2]},"d":{"Box":{"width":0.5}}}"#
    );
    let datum = Datum::of(&shapes).unwrap();
    assert_eq!(datum.to::<BTreeMap<String, Shape>>().unwrap(), shapes);
    assert_eq!(
        cbor::decode::<BTreeMap<String, Shape>>(&cbor::encode(&shapes).unwrap()).unwrap(),
        shapes
    );
    assert_eq!(
        datum.get("d.Box.width").as_deref(),
        Some(&Datum::Float(0.5))
    );
}

#[test]
fn what_a_datum_cannot_hold_is_an_error_with_its_place() {
    let error = Datum::of(&[("big", u64::MAX)]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`0.1`: the integer 18446744073709551615 does not fit into 64 signed bits"
    );
    let keys = std::collections::BTreeMap::from([(1, 2)]);
    assert_eq!(
        Datum::of(&keys).unwrap_err().problem,
        DatumProblem::KeyNotText
    );
}

#[test]
fn a_datum_is_shown_on_one_line_and_long_runs_short() {
    let datum = Datum::record([
        ("ok", Datum::Bool(true)),
        ("name", "a \"b\"".into()),
        ("list", Datum::List(vec![Datum::Int(1), Datum::Null])),
        ("few", Datum::Numbers(Numbers::F32([0.5, 1.0].into()))),
        ("many", Datum::Numbers(Numbers::I8([0; 400].into()))),
        ("bytes", Datum::Bytes([0; 3].into())),
    ]);
    assert_eq!(
        datum.to_string(),
        r#"{ok: true, name: "a \"b\"", list: [1, null], few: [0.5, 1.0], many: 400 × i8, bytes: 3 bytes}"#
    );
}
