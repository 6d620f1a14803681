//! Messages of ROS 1, read and written by genpy, the implementation of ROS for Python.

use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};

use asmotion_datum::{Datum, Schema, Shape, ros1};
use asmotion_ros_interface::{Catalogue, Distribution, InterfaceKind};
use asmotion_skip::GENPY;

/// Python of the system, for which Debian installs genpy.
const PYTHON: &str = "/usr/bin/python3";
/// Messages of each type.
const MESSAGES: usize = 8;

fn has_genpy() -> bool {
    let mut command = Command::new(PYTHON);
    let status = command.args(["-c", "import genpy"]).stderr(Stdio::null());
    status.status().is_ok_and(|it| it.success())
}

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

    fn below(&mut self, bound: u64) -> u64 {
        self.next() % bound
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
            Shape::Bool => Datum::Bool(self.below(2) == 1),
            Shape::I8 => self.integer(8, true),
            Shape::I16 => self.integer(16, true),
            Shape::I32 => self.integer(32, true),
            Shape::I64 => self.integer(64, true),
            Shape::U8 => self.integer(8, false),
            Shape::U16 => self.integer(16, false),
            Shape::U32 => self.integer(32, false),
            Shape::U64 => self.integer(64, false),
            Shape::F32 => Datum::Float(f64::from(self.below(1 << 24) as f32 / 7.0)),
            Shape::F64 => Datum::Float(self.next() as f64 / 7.0),
            Shape::Text => {
                let words = ["", "map", "base_link", "Größe", "日本"];
                Datum::text(words[self.below(5) as usize])
            }
            Shape::List(element) => {
                let count = self.below(4);
                Datum::List((0..count).map(|_| self.datum(element)).collect())
            }
            Shape::Array(element, count) => {
                Datum::List((0..*count).map(|_| self.datum(element)).collect())
            }
            Shape::Record(fields) => {
                let entries = fields.iter();
                let entries = entries.map(|it| {
                    // genpy carries a second or more of nanoseconds into the seconds
                    let datum = match &*it.name {
                        "nanosec" => Datum::Int(self.below(1_000_000_000) as i64),
                        _ => self.datum(&it.schema),
                    };
                    (it.name.clone(), datum)
                });
                Datum::Record(entries.collect())
            }
        }
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

/// A text as JSON. Definitions have no control characters except for the ends of lines.
fn json(text: &str) -> String {
    let escaped = text.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{}\"", escaped.replace('\n', "\\n"))
}

#[test]
fn genpy_reads_and_writes_the_same_bytes() {
    if !has_genpy() {
        return GENPY.skip();
    }
    let noetic = Catalogue::included(Distribution::Ros1);
    let mut numbers = Numbers(1);
    let (mut input, mut expected) = (String::new(), Vec::new());
    for (name, _) in noetic.interfaces() {
        if name.kind() != InterfaceKind::Message {
            continue;
        }
        let schema = noetic.schema(name).unwrap();
        let mut messages = Vec::new();
        for _ in 0..MESSAGES {
            let bytes = ros1::encode(&numbers.datum(&schema), &schema).unwrap();
            let read = ros1::decode(&bytes, &schema).unwrap();
            assert_eq!(ros1::encode(&read, &schema).unwrap(), bytes, "{name}");
            messages.push(format!("\"{}\"", hex(&bytes)));
            expected.push((name.clone(), hex(&bytes)));
        }
        let (text, sum) = (noetic.full_text(name).unwrap(), noetic.md5(name).unwrap());
        writeln!(
            input,
            "{{\"name\": \"{}\", \"text\": {}, \"md5\": \"{sum}\", \"messages\": [{}]}}",
            name.short(),
            json(&text),
            messages.join(", ")
        )
        .unwrap();
    }
    let mut peer = Command::new(PYTHON)
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = peer.stdin.take().unwrap();
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()).unwrap());
    let output = peer.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(output.status.success(), "genpy refuses a message");
    let output = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = output.lines().collect();
    assert_eq!(lines.len(), expected.len());
    for (line, (name, bytes)) in lines.into_iter().zip(&expected) {
        assert_eq!(line, bytes, "{name}");
    }
}
