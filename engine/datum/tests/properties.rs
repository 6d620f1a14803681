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
            // names in any order, each once
            prop::collection::hash_map("[a-z]{1,8}", inner, 0..8).prop_map(Datum::record),
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

fn bytes_of(hex: &str) -> Vec<u8> {
    let pairs = (0..hex.len()).step_by(2);
    pairs
        .map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap())
        .collect()
}

#[test]
fn floats_of_every_width_are_read() {
    // RFC 8949, appendix A; infinite values and NaN as cbor2 writes them by default
    let vectors = [
        ("f90000", 0.0),
        ("f98000", -0.0),
        ("f93c00", 1.0),
        ("f93e00", 1.5),
        ("f97bff", 65504.0),
        ("f90001", 5.960_464_477_539_063e-8),
        ("f90400", 0.000_061_035_156_25),
        ("f9c400", -4.0),
        ("f97c00", f64::INFINITY),
        ("f9fc00", f64::NEG_INFINITY),
        ("f97e00", f64::NAN),
        ("fa47c35000", 100_000.0),
        ("fb3ff199999999999a", 1.1),
    ];
    for (hex, expected) in vectors {
        let read = cbor::decode::<f64>(&bytes_of(hex)).unwrap();
        let same = read.to_bits() == expected.to_bits() || read.is_nan() && expected.is_nan();
        assert!(same, "{hex} is {read}, not {expected}");
    }
}

/// A typed array of RFC 8746.
fn typed_array(tag: u8, content: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0xd8, tag, 0x58, u8::try_from(content.len()).unwrap()];
    bytes.extend(content);
    bytes
}

#[test]
fn typed_arrays_of_every_width_and_byte_order_have_the_same_elements() {
    // tag, element 1, element 2
    let vectors: [(u8, &str, &[f64]); 24] = [
        (64, "01ff", &[1.0, 255.0]),
        (65, "000100ff", &[1.0, 255.0]),
        (66, "00000001000000ff", &[1.0, 255.0]),
        (67, "000000000000000100000000000000ff", &[1.0, 255.0]),
        (68, "01ff", &[1.0, 255.0]),
        (69, "0100ff00", &[1.0, 255.0]),
        (70, "01000000ff000000", &[1.0, 255.0]),
        (71, "0100000000000000ff00000000000000", &[1.0, 255.0]),
        (72, "01ff", &[1.0, -1.0]),
        (73, "0001ffff", &[1.0, -1.0]),
        (74, "00000001ffffffff", &[1.0, -1.0]),
        (75, "0000000000000001ffffffffffffffff", &[1.0, -1.0]),
        (77, "0100ffff", &[1.0, -1.0]),
        (78, "01000000ffffffff", &[1.0, -1.0]),
        (79, "0100000000000000ffffffffffffffff", &[1.0, -1.0]),
        (80, "3c00c400", &[1.0, -4.0]),
        (81, "3f800000c0800000", &[1.0, -4.0]),
        (82, "3ff0000000000000c010000000000000", &[1.0, -4.0]),
        (84, "003c00c4", &[1.0, -4.0]),
        (85, "0000803f000080c0", &[1.0, -4.0]),
        (86, "000000000000f03f00000000000010c0", &[1.0, -4.0]),
        (64, "", &[]),
        (75, "", &[]),
        (84, "", &[]),
    ];
    for (tag, content, expected) in vectors {
        let bytes = typed_array(tag, &bytes_of(content));
        let read = cbor::decode::<Datum>(&bytes).unwrap();
        let elements: Vec<f64> = (0..read.count().unwrap())
            .map(|index| read.element(index).unwrap().as_float().unwrap())
            .collect();
        assert_eq!(elements, expected, "tag {tag}");
    }
}

#[test]
fn typed_arrays_that_cannot_be_represented_are_refused_with_their_tag() {
    let refused = [
        typed_array(76, &[1, 2]),
        typed_array(83, &[0; 16]),
        typed_array(87, &[0; 16]),
        typed_array(82, &[0; 9]),
        bytes_of("d8528101"),
    ];
    for bytes in refused {
        let error = cbor::decode::<Datum>(&bytes).unwrap_err().to_string();
        assert!(error.contains(&format!("tag {}", bytes[1])), "{error}");
    }
    // an array of two dimensions, as cbor2 writes one of numpy
    let error = cbor::decode::<Datum>(&bytes_of("d82882820201420102")).unwrap_err();
    assert!(error.to_string().contains("tag 40"), "{error}");
}

#[test]
fn cells_of_a_grid_are_read_by_their_tag() {
    asmotion_datum::message! {
        pub struct Grid = "test/Grid" { pub data: Vec<i8> }
    }
    let grid = |tag, content: &[u8]| {
        let mut bytes = bytes_of("a16464617461");
        bytes.extend(typed_array(tag, content));
        cbor::decode::<Grid>(&bytes)
    };
    for (tag, content) in [(72, &[1, 100][..]), (64, &[1, 100]), (73, &[0, 1, 0, 100])] {
        assert_eq!(grid(tag, content).unwrap().data, [1, 100], "tag {tag}");
    }
    assert!(grid(65, &[0, 200]).is_err());
    assert!(grid(64, &[200]).is_err());
}

#[test]
fn an_integer_beyond_64_bits_with_sign_is_named_with_its_field() {
    // cbor2.dumps({"stamp": 2**63}) and further ones
    let refused = [
        (
            "a1657374616d701b8000000000000000",
            "`stamp`: the integer 9223372036854775808 ",
        ),
        (
            "813b8000000000000000",
            "`0`: the integer -9223372036854775809 ",
        ),
        ("81c2491000000000000000ff", "`0`: the integer of 9 bytes "),
        (
            "d847480000000000000080",
            "`0`: the integer 9223372036854775808 ",
        ),
    ];
    for (hex, expected) in refused {
        let error = cbor::decode::<Datum>(&bytes_of(hex))
            .unwrap_err()
            .to_string();
        assert!(error.starts_with(expected), "{error}");
        assert!(
            error.ends_with("does not fit into 64 signed bits"),
            "{error}"
        );
    }
    let lowest = cbor::decode::<i64>(&bytes_of("3b7fffffffffffffff")).unwrap();
    assert_eq!(lowest, i64::MIN);
    assert_eq!(cbor::decode::<i64>(&bytes_of("c24201f4")).unwrap(), 500);
    assert_eq!(cbor::decode::<i64>(&bytes_of("c34201f4")).unwrap(), -501);
}

proptest! {
    #[test]
    fn big_endian_arrays_read_as_our_own(numbers in packed_numbers()) {
        let width = numbers.to_bytes().len() / numbers.len().max(1);
        let swapped: Vec<u8> = numbers
            .to_bytes()
            .chunks(width.max(1))
            .flat_map(|one| one.iter().rev().copied())
            .collect();
        let tag = u8::try_from(numbers.tag()).unwrap() & if width == 1 { 0xff } else { !4 };
        let read = cbor::decode::<Datum>(&typed_array(tag, &swapped)).unwrap();
        prop_assert_eq!(read, Datum::Numbers(numbers));
    }
}

fn packed_numbers() -> impl Strategy<Value = Numbers> {
    prop_oneof![
        prop::collection::vec(any::<i8>(), 1..20).prop_map(|all| Numbers::I8(all.into())),
        prop::collection::vec(any::<i16>(), 1..20).prop_map(|all| Numbers::I16(all.into())),
        prop::collection::vec(any::<u16>(), 1..20).prop_map(|all| Numbers::U16(all.into())),
        prop::collection::vec(any::<i32>(), 1..20).prop_map(|all| Numbers::I32(all.into())),
        prop::collection::vec(any::<u32>(), 1..20).prop_map(|all| Numbers::U32(all.into())),
        prop::collection::vec(any::<i64>(), 1..20).prop_map(|all| Numbers::I64(all.into())),
        prop::collection::vec(float(), 1..20).prop_map(|all| Numbers::F64(all.into())),
    ]
}
