//! The encoding of ROS 1, against bytes derived by hand from its rules. Those of every included message are compared with
//! genpy in `engine/ros/interface`.
#![allow(clippy::unwrap_used, missing_docs, reason = "tests")]

use asmotion_datum::{Datum, DatumProblem, OutlineKey, Schema, Shape, ros1};

fn plain(shape: Shape) -> Schema {
    Schema::plain(shape)
}

fn record(fields: Vec<(&'static str, Schema)>) -> Schema {
    let keys = fields.into_iter();
    let keys = keys.map(|(name, schema)| OutlineKey::new(name, "", schema));
    Schema::record("test/Record", keys.collect())
}

/// The bytes of a datum, which are read back as the same datum.
fn bytes(datum: &Datum, schema: &Schema) -> Vec<u8> {
    let bytes = ros1::encode(datum, schema).unwrap();
    assert_eq!(ros1::decode(&bytes, schema).unwrap(), *datum);
    bytes
}

#[test]
fn nothing_is_aligned_and_texts_are_not_terminated() {
    let schema = record(vec![
        ("flag", plain(Shape::Bool)),
        ("count", plain(Shape::U32)),
        ("text", plain(Shape::Text)),
        ("x", plain(Shape::F64)),
    ]);
    let datum = Datum::record([
        ("flag", Datum::Bool(true)),
        ("count", Datum::Int(0x0403_0201)),
        ("text", Datum::text("é")),
        ("x", Datum::Float(1.0)),
    ]);
    let expected = [
        1, 1, 2, 3, 4, 2, 0, 0, 0, 0xc3, 0xa9, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f,
    ];
    assert_eq!(bytes(&datum, &schema), expected);
}

#[test]
fn sequences_have_a_length_and_arrays_have_none() {
    let schema = record(vec![
        ("any", Schema::many(plain(Shape::Text), None)),
        ("two", Schema::many(plain(Shape::Text), Some(2))),
    ]);
    let texts = |texts: &[&str]| Datum::List(texts.iter().map(|it| Datum::text(*it)).collect());
    let datum = Datum::record([("any", texts(&["a"])), ("two", texts(&["", "b"]))]);
    let expected = [1, 0, 0, 0, 1, 0, 0, 0, b'a', 0, 0, 0, 0, 1, 0, 0, 0, b'b'];
    assert_eq!(bytes(&datum, &schema), expected);
}

#[test]
fn a_message_without_fields_has_no_bytes() {
    let empty = record(vec![]);
    let none = Datum::Record(vec![]);
    assert!(bytes(&none, &empty).is_empty());
    let list = Schema::many(empty, None);
    let three = Datum::List(vec![none.clone(), none.clone(), none]);
    assert_eq!(bytes(&three, &list), [3, 0, 0, 0]);
    // no length of the message bounds their number
    assert!(ros1::decode(&[255, 255, 255, 255], &list).is_err());
}

#[test]
fn malformed_bytes_are_refused() {
    let text = plain(Shape::Text);
    let numbers = Schema::many(plain(Shape::F64), None);
    let table: [(&Schema, &[u8], &str); 5] = [
        (&text, &[], "unexpected end"),
        (&text, &[255, 255, 255, 255, b'a'], "unexpected end"),
        (&text, &[1, 0, 0, 0, 0xff], "invalid utf-8"),
        (&text, &[1, 0, 0, 0, b'a', 0], "1 bytes follow the message"),
        (&numbers, &[255, 255, 255, 127, 0], "unexpected end"),
    ];
    for (schema, bytes, cause) in table {
        let error = ros1::decode(bytes, schema).unwrap_err();
        let DatumProblem::Malformed { codec, reason } = &error.problem else {
            unreachable!("{error}");
        };
        assert_eq!(*codec, "the encoding of ROS 1");
        assert!(reason.contains(cause), "{reason}");
    }
}
