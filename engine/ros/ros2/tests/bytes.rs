//! The encoding of all messages, requests, responses, goals, results and feedback, next to that of Cyclone DDS.

use std::io::Write as _;
use std::process::{Command, Stdio};

use asmotion_datum::{Codec, Datum, Schema, Shape};
use asmotion_ros_interface::{InterfaceKind, InterfaceName};

use crate::peer::{catalogue, hex, json, python};

/// Messages of each type.
const MESSAGES: usize = 6;

/// Arbitrary numbers, equal in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        // Steele, Lea and Flood: SplitMix
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn integer(&mut self, bits: u32, signed: bool) -> Datum {
        // 64-bit unsigned integers beyond the signed ones are not data
        let bits = if signed { bits } else { bits.min(63) };
        let value = self.next() >> (64 - bits);
        let lowest = if signed { 1_i64 << (bits - 1) } else { 0 };
        Datum::Int((value as i64).wrapping_sub(lowest))
    }

    fn datum(&mut self, schema: &Schema) -> Datum {
        match &schema.shape {
            Shape::Any | Shape::Option(_) => unreachable!("no message has it"),
            Shape::Bool => Datum::Bool(self.next() % 2 == 1),
            Shape::I8 => self.integer(8, true),
            Shape::I16 => self.integer(16, true),
            Shape::I32 => self.integer(32, true),
            Shape::I64 => self.integer(64, true),
            Shape::U8 => self.integer(8, false),
            Shape::U16 => self.integer(16, false),
            Shape::U32 => self.integer(32, false),
            Shape::U64 => self.integer(64, false),
            Shape::F32 => Datum::Float(f64::from((self.next() % (1 << 24)) as f32 / 7.0)),
            Shape::F64 => Datum::Float(self.next() as f64 / 7.0),
            Shape::Text => {
                let words = ["", "map", "base_link", "Größe", "日本"];
                Datum::text(words[(self.next() % 5) as usize])
            }
            Shape::List(element) => {
                let count = self.next() % 4;
                Datum::List((0..count).map(|_| self.datum(element)).collect())
            }
            Shape::Array(element, count) => {
                Datum::List((0..*count).map(|_| self.datum(element)).collect())
            }
            Shape::Record(fields) => {
                let entries = fields.iter();
                let entries = entries.map(|it| (it.name.clone(), self.datum(&it.schema)));
                Datum::Record(entries.collect())
            }
        }
    }
}

/// The types of an interface as DDS has them, with their schemas.
fn types(name: &InterfaceName) -> Vec<(String, Schema)> {
    let (package, short) = (name.package(), name.name());
    let (folder, suffixes): (_, &[&str]) = match name.kind() {
        InterfaceKind::Message => ("msg", &[""]),
        InterfaceKind::Service => ("srv", &["_Request", "_Response"]),
        InterfaceKind::Action => ("action", &["_Goal", "_Result", "_Feedback"]),
    };
    let schemas = catalogue().schemas(name).unwrap();
    assert_eq!(schemas.len(), suffixes.len(), "{name}");
    let name_of = |suffix: &&str| format!("{package}::{folder}::dds_::{short}{suffix}_");
    suffixes.iter().map(name_of).zip(schemas).collect()
}

/// Gives lines to the peer in this role, and returns its lines.
fn converse(role: &str, input: String) -> Vec<String> {
    let Some(python) = python() else {
        return Vec::new();
    };
    let mut peer = Command::new(python)
        .args([crate::peer::peer_script(), role, "{}"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = peer.stdin.take().unwrap();
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()).unwrap());
    let output = peer.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(output.status.success(), "Cyclone DDS refuses a message");
    let output = String::from_utf8(output.stdout).unwrap();
    output.lines().map(str::to_owned).collect()
}

/// All types of the definitions, and the number of interfaces.
fn all_types() -> (Vec<(String, Schema)>, usize) {
    let jazzy = catalogue();
    let names: Vec<_> = jazzy.interfaces().map(|(name, _)| name.clone()).collect();
    let all: Vec<_> = names.iter().flat_map(types).collect();
    for (name, schema) in &all {
        let carried = Codec::Cdr.carries(schema);
        assert!(carried.is_ok(), "{name}: {carried:?}");
    }
    (all, names.len())
}

#[test]
fn cyclone_reads_and_writes_the_same_bytes() {
    if python().is_none() {
        return;
    }
    let (all, interfaces) = all_types();
    assert!(interfaces > 200 && all.len() > interfaces, "{interfaces}");
    let mut numbers = Numbers(2);
    let (mut input, mut expected) = (String::new(), Vec::new());
    for (name, schema) in &all {
        let encoded: Vec<String> = (0..MESSAGES)
            .map(|_| hex(&Codec::Cdr.encode(&numbers.datum(schema), schema).unwrap()))
            .collect();
        let entry =
            serde_json::json!({ "type": name, "schema": json(schema), "messages": encoded });
        input.push_str(&format!("{entry}\n"));
        expected.extend(encoded.into_iter().map(|bytes| (name, bytes)));
    }
    let lines = converse("bytes", input);
    assert_eq!(lines.len(), expected.len());
    for (line, (name, bytes)) in lines.iter().zip(&expected) {
        assert_eq!(line, bytes, "{name}");
    }
}

/// The other way round: values that the peer makes up.
#[test]
fn what_cyclone_writes_is_read_and_written_with_the_same_bytes() {
    if python().is_none() {
        return;
    }
    let (all, _) = all_types();
    let entry = |(name, schema): &(String, Schema)| {
        let entry = serde_json::json!({ "type": name, "schema": json(schema), "count": MESSAGES });
        format!("{entry}\n")
    };
    let lines = converse("generate", all.iter().map(entry).collect());
    assert_eq!(lines.len(), all.len() * MESSAGES);
    let types = all.iter().flat_map(|of| std::iter::repeat_n(of, MESSAGES));
    for (line, (name, schema)) in lines.iter().zip(types) {
        let pairs = line.as_bytes().chunks(2);
        let pairs = pairs.map(|pair| std::str::from_utf8(pair).unwrap());
        let bytes: Vec<u8> = pairs
            .map(|digits| u8::from_str_radix(digits, 16).unwrap())
            .collect();
        let message = Codec::Cdr.decode(&bytes, schema);
        let message = message.unwrap_or_else(|error| panic!("{name}: {error}: {line}"));
        let again = Codec::Cdr.encode(&message, schema).unwrap();
        assert_eq!(hex(&again), *line, "{name}");
    }
}
