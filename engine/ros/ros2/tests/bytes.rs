//! The encoding of all messages, next to that of Cyclone DDS.

use std::io::Write as _;
use std::process::{Command, Stdio};

use asmotion_datum::{Codec, Datum, Schema, Shape};
use asmotion_ros_interface::InterfaceKind;

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

#[test]
fn cyclone_reads_and_writes_the_same_bytes() {
    let Some(python) = python() else { return };
    let jazzy = catalogue();
    let mut numbers = Numbers(2);
    let (mut input, mut expected) = (String::new(), Vec::new());
    for (name, _) in jazzy.interfaces() {
        if name.kind() != InterfaceKind::Message {
            continue;
        }
        let schema = jazzy.schema(name).unwrap();
        if Codec::Cdr.carries(&schema).is_err() {
            continue;
        }
        let encoded: Vec<String> = (0..MESSAGES)
            .map(|_| hex(&Codec::Cdr.encode(&numbers.datum(&schema), &schema).unwrap()))
            .collect();
        let entry = serde_json::json!({
            "type": format!("{}::msg::dds_::{}_", name.package(), name.name()),
            "schema": json(&schema),
            "messages": encoded,
        });
        input.push_str(&format!("{entry}\n"));
        expected.extend(encoded.into_iter().map(|bytes| (name.clone(), bytes)));
    }
    assert!(expected.len() > 150 * MESSAGES, "{}", expected.len());
    let mut peer = Command::new(python)
        .args([crate::peer::peer_script(), "bytes", "{}"])
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
    let lines: Vec<&str> = output.lines().collect();
    assert_eq!(lines.len(), expected.len());
    for (line, (name, bytes)) in lines.into_iter().zip(&expected) {
        assert_eq!(line, bytes, "{name}");
    }
}
