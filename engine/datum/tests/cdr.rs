//! CDR against bytes derived by hand from the rules of OMG and ROS 2, bytes of another implementation, and arbitrary
//! bytes.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs, reason = "tests")]

use asmotion_datum::{
    Codec, Datum, DatumProblem, Described, Message, OutlineKey, Schema, Shape, cdr,
};
use byteorder::LittleEndian;
use proptest::prelude::*;
use serde::Serialize;

asmotion_datum::message! {
    /// A time (builtin_interfaces/Time).
    #[derive(Copy)]
    pub struct Time = "builtin_interfaces/Time" {
        pub sec: i32,
        pub nanosec: u32,
    }

    /// A header (std_msgs/Header).
    pub struct Header = "std_msgs/Header" {
        pub stamp: Time,
        pub frame_id: String,
    }

    /// Fields at positions that need alignment.
    pub struct Odd = "test/Odd" {
        pub header: Header,
        pub small: u8,
        pub wide: f64,
        pub flags: Vec<bool>,
        pub none: Vec<f64>,
        pub last: i16,
        pub empty: Empty,
        pub maybe: Option<u16>,
    }

    /// A message without fields.
    #[derive(Eq)]
    pub struct Empty = "std_msgs/Empty" {}

    /// All scalars, and lists and arrays of them.
    pub struct Each = "test/Each" {
        pub b: bool, pub bs: Vec<bool>, pub b3: [bool; 3],
        pub i8_: i8, pub i8s: Vec<i8>, pub i83: [i8; 3],
        pub i16_: i16, pub i16s: Vec<i16>, pub i163: [i16; 3],
        pub i32_: i32, pub i32s: Vec<i32>, pub i323: [i32; 3],
        pub i64_: i64, pub i64s: Vec<i64>, pub i643: [i64; 3],
        pub u8_: u8, pub u8s: Vec<u8>, pub u83: [u8; 3],
        pub u16_: u16, pub u16s: Vec<u16>, pub u163: [u16; 3],
        pub u32_: u32, pub u32s: Vec<u32>, pub u323: [u32; 3],
        pub u64_: u64, pub u64s: Vec<u64>, pub u643: [u64; 3],
        pub f32_: f32, pub f32s: Vec<f32>, pub f323: [f32; 3],
        pub f64_: f64, pub f64s: Vec<f64>, pub f643: [f64; 3],
        pub text: String, pub texts: Vec<String>, pub text3: [String; 3],
        pub record: Time, pub records: Vec<Header>, pub record3: [Header; 3],
        pub maybe: Option<f64>, pub maybes: Vec<Option<Time>>,
    }
}

fn odd() -> Odd {
    Odd {
        header: Header {
            stamp: Time { sec: 1, nanosec: 2 },
            frame_id: "map".to_owned(),
        },
        small: 7,
        wide: 1.5,
        flags: vec![true, false, true],
        none: Vec::new(),
        last: -2,
        empty: Empty {},
        maybe: Some(0x0102),
    }
}

/// Offsets count from the end of the header. CycloneDDS' CDR (pycdr2 1.0.0) produces the same bytes.
const ODD: &[&[u8]] = &[
    &[0, 1, 0, 0],                   // CDR, little-endian, no options
    &[1, 0, 0, 0],                   //  0 sec
    &[2, 0, 0, 0],                   //  4 nanosec
    &[4, 0, 0, 0],                   //  8 length of the text, with its zero
    b"map\0",                        // 12
    &[7],                            // 16 small
    &[0; 7],                         // 17 up to a multiple of eight
    &[0, 0, 0, 0, 0, 0, 0xf8, 0x3f], // 24 wide
    &[3, 0, 0, 0],                   // 32 how many flags
    &[1, 0, 1],                      // 36
    &[0],                            // 39 up to a multiple of four
    &[0, 0, 0, 0],                   // 40 how many of none; they themselves take no place
    &[0xfe, 0xff],                   // 44 last
    &[0],                            // 46 the byte of a message without fields
    &[0],                            // 47 up to a multiple of four
    &[1, 0, 0, 0],                   // 48 one of at most one
    &[2, 1],                         // 52
];

#[test]
fn its_bytes_are_those_of_the_rules() {
    let golden = ODD.concat();
    assert_eq!(cdr::encode(&odd()).unwrap(), golden);
    assert_eq!(cdr::decode::<Odd>(&golden).unwrap(), odd());
    let padded = [&golden[..], &[0, 0]].concat();
    assert_eq!(cdr::decode::<Odd>(&padded).unwrap(), odd());
}

#[test]
fn the_big_end_may_come_first() {
    let bytes = [
        &[0, 0, 0, 0][..], // CDR, big-endian
        &[0, 0, 0, 1, 0, 0, 0, 2],
        &[0, 0, 0, 4, b'm', b'a', b'p', 0],
    ];
    assert_eq!(
        cdr::decode::<Header>(&bytes.concat()).unwrap(),
        odd().header
    );
    let two = [&[0, 0, 0, 0][..], &[0, 0, 0, 2, 0, 1, 0, 2]].concat();
    let schema = Schema::many(u16::describe(), None);
    let read = Codec::Cdr.decode(&two, &schema).unwrap();
    assert_eq!(read.to::<Vec<u16>>().unwrap(), [1, 2]);
}

/// The same fields for the other implementation, which uses serde.
#[derive(Serialize)]
struct Theirs<'a> {
    flag: bool,
    wide: f64,
    text: &'a str,
    bytes: &'a [u8],
    shorts: &'a [i16],
    longs: &'a [u64],
    singles: &'a [f32],
    fixed: (f64, f64, f64),
    texts: &'a [String],
    last: i8,
}

asmotion_datum::message! {
    /// The same fields as `Theirs`.
    pub struct Ours = "test/Ours" {
        pub flag: bool,
        pub wide: f64,
        pub text: String,
        pub bytes: Vec<u8>,
        pub shorts: Vec<i16>,
        pub longs: Vec<u64>,
        pub singles: Vec<f32>,
        pub fixed: [f64; 3],
        pub texts: Vec<String>,
        pub last: i8,
    }
}

/// Arbitrary values, drawn by proptest for each field.
fn each() -> impl Strategy<Value = Each> {
    macro_rules! runs {
        ($($type:ty),+) => { ($((any::<$type>(), any::<Vec<$type>>(), any::<[$type; 3]>()),)+) };
    }
    let big = 0..=i64::MAX.unsigned_abs();
    let u64s = (
        big.clone(),
        prop::collection::vec(big.clone(), 0..8),
        [big.clone(), big.clone(), big],
    );
    let floats = (
        any::<f32>(),
        any::<Vec<f32>>(),
        any::<[f32; 3]>(),
        any::<f64>(),
        any::<Vec<f64>>(),
        any::<[f64; 3]>(),
    );
    let time = || any::<(i32, u32)>().prop_map(|(sec, nanosec)| Time { sec, nanosec });
    let header = move || (time(), ".*").prop_map(|(stamp, frame_id)| Header { stamp, frame_id });
    let records = (
        time(),
        prop::collection::vec(header(), 0..4),
        [header(), header(), header()],
        any::<Option<f64>>(),
        prop::collection::vec(prop::option::of(time()), 0..4),
    );
    let texts = (".*", prop::collection::vec(".*", 0..4), [".*", ".*", ".*"]);
    let integers = runs!(bool, i8, i16, i32, i64, u8, u16, u32);
    (integers, u64s, floats, texts, records).prop_map(|(ints, u64s, floats, texts, records)| {
        let (b, i8s, i16s, i32s, i64s, u8s, u16s, u32s) = ints;
        Each {
            b: b.0,
            bs: b.1,
            b3: b.2,
            i8_: i8s.0,
            i8s: i8s.1,
            i83: i8s.2,
            i16_: i16s.0,
            i16s: i16s.1,
            i163: i16s.2,
            i32_: i32s.0,
            i32s: i32s.1,
            i323: i32s.2,
            i64_: i64s.0,
            i64s: i64s.1,
            i643: i64s.2,
            u8_: u8s.0,
            u8s: u8s.1,
            u83: u8s.2,
            u16_: u16s.0,
            u16s: u16s.1,
            u163: u16s.2,
            u32_: u32s.0,
            u32s: u32s.1,
            u323: u32s.2,
            u64_: u64s.0,
            u64s: u64s.1,
            u643: u64s.2,
            f32_: floats.0,
            f32s: floats.1,
            f323: floats.2,
            f64_: floats.3,
            f64s: floats.4,
            f643: floats.5,
            text: texts.0,
            texts: texts.1,
            text3: texts.2,
            record: records.0,
            records: records.1,
            record3: records.2,
            maybe: records.3,
            maybes: records.4,
        }
    })
}

proptest! {
    #[test]
    fn j19_every_scalar_and_array_returns_from_every_codec(message in each()) {
        let datum = Datum::of(&message).unwrap();
        for codec in Codec::ALL {
            let bytes = codec.encode(&datum, Each::schema()).unwrap();
            let read = codec.decode(&bytes, Each::schema()).unwrap();
            prop_assert_eq!(read.to::<Each>().unwrap(), message.clone());
        }
        prop_assert_eq!(cdr::decode::<Each>(&cdr::encode(&message).unwrap()).unwrap(), message);
    }

    #[test]
    fn another_implementation_writes_the_same(
        flag in any::<bool>(),
        wide in any::<f64>(),
        text in ".*",
        bytes in any::<Vec<u8>>(),
        shorts in any::<Vec<i16>>(),
        longs in prop::collection::vec(0..=i64::MAX.unsigned_abs(), 0..5),
        singles in any::<Vec<f32>>(),
        fixed in any::<[f64; 3]>(),
        texts in prop::collection::vec(".*", 0..4),
        last in any::<i8>(),
    ) {
        let theirs = Theirs {
            flag, wide, text: &text, bytes: &bytes, shorts: &shorts, longs: &longs, singles: &singles,
            fixed: fixed.into(), texts: &texts, last,
        };
        let theirs = cdr_encoding::to_vec::<_, LittleEndian>(&theirs).unwrap();
        let ours = Ours { flag, wide, text, bytes, shorts, longs, singles, fixed, texts, last };
        let written = cdr::encode(&ours).unwrap();
        prop_assert_eq!(&written[4..], &theirs[..]);
        prop_assert_eq!(cdr::decode::<Ours>(&written).unwrap(), ours);
    }

    #[test]
    fn no_bytes_make_it_panic(mut bytes in any::<Vec<u8>>(), little in any::<bool>()) {
        let _ = cdr::decode::<Each>(&bytes);
        bytes.splice(0..0, [0, u8::from(little), 0, 0]);
        let _ = cdr::decode::<Each>(&bytes);
    }

    #[test]
    fn damaged_messages_are_refused_or_read_never_worse(message in each(), at in any::<usize>(), by in 1u8..) {
        let mut bytes = cdr::encode(&message).unwrap();
        let at = at % bytes.len();
        bytes[at] ^= by;
        let _ = cdr::decode::<Each>(&bytes);
        bytes.truncate(at);
        prop_assert!(cdr::decode::<Each>(&bytes).is_err());
    }
}

#[test]
fn lengths_that_lie_are_refused_without_taking_memory() {
    let many = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff];
    let runs = [
        f64::describe(),
        u8::describe(),
        bool::describe(),
        String::describe(),
        Header::describe(),
        Empty::describe(),
        <[f64; 3]>::describe(),
        <Option<Time>>::describe(),
        <Vec<Vec<f32>>>::describe(),
    ];
    for element in runs {
        let schema = Schema::many(element, None);
        let end = Codec::Cdr.decode(&many, &schema);
        assert!(
            matches!(end.unwrap_err().problem, DatumProblem::Malformed { .. }),
            "{schema}"
        );
    }
    let text = Codec::Cdr.decode(&many, &String::describe());
    assert!(matches!(
        text.unwrap_err().problem,
        DatumProblem::Malformed { .. }
    ));
}

#[test]
fn what_it_cannot_carry_is_said_with_its_place() {
    let said = |schema: &Schema| Codec::Cdr.carries(schema).unwrap_err().to_string();
    let field = |name: &'static str, schema| OutlineKey::new(name, "", schema);
    let inner = Schema::record("test/Inner", vec![field("what", Datum::describe())]);
    let outer = Schema::record("test/Outer", vec![field("all", Schema::many(inner, None))]);
    assert_eq!(
        said(&outer),
        "`all.*.what`: CDR cannot carry a type known only at run time"
    );
    assert_eq!(
        said(&Schema::opaque("x/Y")),
        "CDR cannot carry `x/Y`, whose fields are unknown"
    );
    let none = Schema::many(u8::describe(), Some(0));
    assert_eq!(said(&none), "CDR cannot carry `uint8[0]`");
    // encoding such data anyway gives the same error
    let datum = Datum::record([(
        "all",
        Datum::List(vec![Datum::record([("what", Datum::Null)])]),
    )]);
    let written = Codec::Cdr.encode(&datum, &outer).unwrap_err();
    assert_eq!(
        written.to_string(),
        "`all.0.what`: CDR cannot carry a type known only at run time"
    );
    for schema in [Each::schema(), Odd::schema()] {
        Codec::Cdr.carries(schema).unwrap();
    }
}

#[test]
fn what_does_not_fit_its_schema_is_said_with_its_place() {
    let schema = Header::schema();
    let written = |datum: &Datum| Codec::Cdr.encode(datum, schema).unwrap_err().to_string();
    let header = |stamp, frame: Datum| Datum::record([("stamp", stamp), ("frame_id", frame)]);
    let time = |sec: Datum| Datum::record([("sec", sec), ("nanosec", Datum::Int(0))]);
    assert_eq!(
        written(&header(time(Datum::Int(1 << 40)), "map".into())),
        "`stamp.sec`: 1099511627776 does not fit `int32`"
    );
    assert_eq!(
        written(&header(time(Datum::Int(0)), Datum::Int(1))),
        "`frame_id`: expected `string`, found an integer"
    );
    assert_eq!(
        written(&Datum::record([("stomp", Datum::Null)])),
        "unknown field `stomp`"
    );
}

asmotion_datum::message! {
    /// A message with a field whose initial value is not zero.
    pub struct Turn = "test/Turn" {
        pub x: f64,
        pub w: f64 = 1.0,
    }

    /// Nested messages, and fields with initial values.
    pub struct Turned = "test/Turned" {
        pub name: String = "home".to_owned(),
        pub turn: Turn,
        pub two: [Turn; 2],
        pub matrix: [f64; 36] = [0.5; 36],
        pub more: Vec<u8>,
        pub maybe: Option<bool>,
        pub ok: bool,
        pub at: i16,
    }
}

#[test]
fn what_is_left_out_has_its_initial_value() {
    let none = Datum::Record(Vec::new());
    let bytes = Codec::Cdr.encode(&none, Turned::schema()).unwrap();
    assert_eq!(cdr::decode::<Turned>(&bytes).unwrap(), Turned::default());
}

#[test]
fn another_representation_is_refused() {
    // 3: a parameter list; 7: plain CDR of XCDR 2
    for kind in [3, 7] {
        let error = cdr::decode::<Time>(&[0, kind, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        assert!(error.unwrap_err().to_string().contains("is not plain CDR"));
    }
    assert!(matches!(
        Codec::Cdr
            .decode(&[], &Schema::plain(Shape::Bool))
            .unwrap_err()
            .problem,
        DatumProblem::Malformed { .. }
    ));
}
