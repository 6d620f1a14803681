//! Tests the properties with mutated files and messages: a bounded, repeatable version of the fuzzers.

#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "helpers of tests")]

#[path = "../../../components/map/tests/fixture/mod.rs"]
#[allow(dead_code, reason = "shared with the contract of map formats")]
mod fixture;

use asmotion_datum::{Codec, Datum, Message, Schema, ros1};
use asmotion_messages::{
    JointStatus, LaserScan, OccupancyGrid, Odometry, Path, PoseStamped, Twist,
};
use asmotion_mqueue::QueueLayout;
use asmotion_robustness::{
    cbor, cdr, composite, cpf, json, osm, osm_pbf, property_file, queue, ros_bridge, scdl,
};
use asmotion_ros1::header::ConnectionHeader;
use asmotion_ros1::xmlrpc::{XmlRpcValue, write_call, write_response};
use asmotion_wire_robustness::{ros_definition, ros_header, ros_message, ros2_message, xml_rpc};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path;

/// Bytes with a special meaning for readers of numbers and lengths.
const EDGES: &[u8] = &[
    0x00, 0x01, 0x1b, 0x3b, 0x5b, 0x7f, 0x80, 0x9b, 0xbb, 0xd8, 0xf9, 0xfb, 0xfe, 0xff,
];

/// Words with a special meaning for readers of composites.
const WORDS: &[&str] = &[
    "\"\"",
    "true",
    "-1",
    "1e400",
    "nan",
    "9223372036854775807",
    "[]",
    "{}",
    "\"*\"",
    "\"${X}\"",
    "\"a.b\"",
    "[[",
    "'''",
    "\u{feff}",
    "&#0;",
    "<!DOCTYPE a [<!ENTITY b \"b\">]>",
    "<![CDATA[",
    "xmlns:a=\"b\"",
];

fn files(folder: &str, ending: &str) -> Vec<Vec<u8>> {
    let root = path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let entries = std::fs::read_dir(root.join(folder)).unwrap();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.to_string_lossy().ends_with(ending));
    paths.sort();
    assert!(!paths.is_empty(), "{folder} has no {ending}");
    paths
        .iter()
        .map(|path| std::fs::read(path).unwrap())
        .collect()
}

/// Makes one small change to bytes.
fn mutate_bytes(bytes: &mut Vec<u8>, random: &mut impl Rng) {
    let at = random.random_range(0..=bytes.len());
    let end = (at + random.random_range(0..16)).min(bytes.len());
    let part = bytes[at..end].to_vec();
    match random.random_range(0..6) {
        0 => drop(bytes.drain(at..end)),
        1 => bytes.truncate(at),
        2 => drop(bytes.splice(at..at, part.repeat(random.random_range(1..8)))),
        3 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
        4 if at < bytes.len() => bytes[at] = EDGES[random.random_range(0..EDGES.len())],
        _ => drop(bytes.splice(at..end, part.iter().map(|_| random.random::<u8>()))),
    }
}

/// Makes one small change to a text: in a byte, a word or a line.
fn mutate_text(bytes: &mut Vec<u8>, other: &[u8], random: &mut impl Rng) {
    let line = |bytes: &[u8], random: &mut dyn FnMut(usize) -> usize| {
        let starts: Vec<usize> = std::iter::once(0)
            .chain(
                (0..bytes.len())
                    .filter(|at| bytes[*at] == b'\n')
                    .map(|at| at + 1),
            )
            .collect();
        let index = random(starts.len());
        let end = starts.get(index + 1).copied().unwrap_or(bytes.len());
        starts[index]..end
    };
    let mut below = |limit: usize| random.random_range(0..limit);
    let here = line(bytes, &mut below);
    match below(5) {
        0 => drop(bytes.drain(here)),
        1 => {
            let there = line(other, &mut below);
            bytes.splice(here.start..here.start, other[there].iter().copied());
        }
        2 | 3 => {
            let words: Vec<usize> = here
                .clone()
                .filter(|at| !bytes[*at].is_ascii_alphanumeric())
                .collect();
            if words.is_empty() {
                return;
            }
            let start = words[below(words.len())] + 1;
            let end = (start..here.end)
                .find(|at| !bytes[*at].is_ascii_alphanumeric())
                .unwrap_or(here.end);
            let word = WORDS[below(WORDS.len())];
            bytes.splice(start.min(end)..end, word.bytes());
        }
        _ => mutate_bytes(bytes, random),
    }
}

/// Tests a property with the seeds and with `count` mutations of them.
fn holds(property: fn(&[u8]), seeds: &[Vec<u8>], is_text: bool, count: usize) {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for seed in seeds {
        property(seed);
    }
    for _ in 0..count {
        let mut bytes = seeds[random.random_range(0..seeds.len())].clone();
        for _ in 0..random.random_range(1..4) {
            let other = &seeds[random.random_range(0..seeds.len())];
            if is_text {
                mutate_text(&mut bytes, other, &mut random)
            } else {
                mutate_bytes(&mut bytes, &mut random)
            }
        }
        let shown = ShownOnPanic(&bytes);
        property(&bytes);
        drop(shown);
    }
}

/// Prints the input for which a property panicked.
struct ShownOnPanic<'bytes>(&'bytes [u8]);

impl Drop for ShownOnPanic<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!(
                "--- input:\n{}\n--- {:?}",
                String::from_utf8_lossy(self.0),
                self.0
            );
        }
    }
}

/// A message with its schema.
fn sample<T: Message>(message: &T) -> (Datum, &'static Schema) {
    (Datum::of(message).unwrap(), T::schema())
}

/// Messages of various shapes: flat, nested, with text, with lists of numbers and of records.
fn samples() -> Vec<(Datum, &'static Schema)> {
    let path = Path {
        poses: vec![PoseStamped::default(); 3],
        ..Path::default()
    };
    let scan = LaserScan {
        ranges: vec![1.5, f32::INFINITY, f32::NAN],
        ..LaserScan::default()
    };
    let grid = OccupancyGrid {
        data: vec![-1, 0, 100],
        ..OccupancyGrid::default()
    };
    vec![
        sample(&path),
        sample(&scan),
        sample(&grid),
        sample(&Twist::default()),
        sample(&Odometry::default()),
        sample(&JointStatus::default()),
    ]
}

fn encoded(codec: Codec) -> Vec<Vec<u8>> {
    let encode = |(datum, schema): (Datum, &Schema)| codec.encode(&datum, schema).unwrap();
    samples().into_iter().map(encode).collect()
}

fn map(format: &str) -> Vec<Vec<u8>> {
    let mut found = fixture::all().into_iter().filter(|it| it.0 == format);
    vec![found.next().unwrap().1.files.remove(0).1]
}

#[test]
fn composites_are_read() {
    holds(
        composite,
        &files("engine/plan/tests/composites", ".toml"),
        true,
        2_000,
    );
}

#[test]
fn files_of_properties_are_read() {
    let seed = b"max_speed = 0.5\nlookahead_s = 1.5\ncurve_radius_m = 0.9\nmin_curve_speed = 0.1\n"
        .to_vec();
    holds(property_file, &[seed], true, 2_000);
}

#[test]
fn scdl_is_read() {
    holds(
        scdl,
        &files("engine/scdl/tests/scdl", ".composite"),
        true,
        2_000,
    );
}

#[test]
fn cpf_is_read() {
    let seed = b"<?xml version=\"1.0\"?>\n<!DOCTYPE properties SYSTEM \"cpf.dtd\">\n<properties>\n<simple name=\"a\" type=\"double\"><value>1.5</value></simple>\n<struct name=\"b\" type=\"PropertyBag\">\n<sequence name=\"c\" type=\"s\"><simple type=\"long\"><value>3</value></simple></sequence>\n</struct>\n</properties>\n".to_vec();
    holds(cpf, &[seed], true, 4_000);
}

#[test]
fn cbor_is_read() {
    holds(cbor, &encoded(Codec::Cbor), false, 20_000);
}

#[test]
fn json_is_read() {
    holds(json, &encoded(Codec::Json), true, 10_000);
}

#[test]
fn cdr_is_read() {
    holds(cdr, &encoded(Codec::Cdr), false, 2_000);
}

#[test]
fn messages_of_ros_1_are_read() {
    let encode = |(datum, schema): (Datum, &Schema)| ros1::encode(&datum, schema).ok();
    let seeds: Vec<_> = samples().into_iter().filter_map(encode).collect();
    assert!(seeds.len() > 1);
    holds(ros_message, &seeds, false, 200);
}

#[test]
fn messages_of_ros_2_are_read() {
    holds(ros2_message, &encoded(Codec::Cdr), false, 200);
}

#[test]
fn messages_of_peers_cross_a_bridge() {
    let of_ros_1 = |(datum, schema): &(Datum, &Schema)| ros1::encode(datum, schema).ok();
    let mut seeds: Vec<_> = samples().iter().filter_map(of_ros_1).collect();
    seeds.extend(encoded(Codec::Cdr));
    assert!(seeds.len() > 2);
    holds(ros_bridge, &seeds, false, 20_000);
}

#[test]
fn definitions_of_ros_are_read() {
    let seeds = [
        "# a comment\nstd_msgs/Header header\nfloat64[36] covariance\nuint8 RED=1 # one\nstring NAME=a # b\n",
        "string<=10 name \"a # b\"\nint32[<=5] few [1, 2]\n---\nwstring[] all\n---\nbool done true\n",
    ];
    let seeds = seeds.map(|text| text.as_bytes().to_vec());
    holds(ros_definition, &seeds, true, 4_000);
}

#[test]
fn headers_of_ros_1_are_read() {
    let header = ConnectionHeader::new()
        .with("callerid", "/talker")
        .with("md5sum", "*")
        .with("message_definition", "string data\n");
    let seed = header.encode()[4..].to_vec();
    holds(ros_header, &[seed], false, 20_000);
}

#[test]
fn xml_rpc_is_read() {
    let value = |text| XmlRpcValue::text(text);
    let call = write_call(
        "publisherUpdate",
        &[
            value("/master"),
            XmlRpcValue::Array(vec![value("http://a:1/ <&>\r")]),
        ],
    );
    let member = ("x".to_owned(), XmlRpcValue::Double(0.5));
    let response = XmlRpcValue::Array(vec![
        XmlRpcValue::Int(1),
        XmlRpcValue::Bool(true),
        XmlRpcValue::Bytes(vec![1, 2, 3, 4]),
        XmlRpcValue::Time("20261124T18:00:00".to_owned()),
        XmlRpcValue::Struct(vec![member]),
    ]);
    let seeds = [
        call,
        write_response(Ok(&response)),
        write_response(Err("no")),
    ];
    holds(xml_rpc, &seeds.map(String::into_bytes), true, 10_000);
}

#[test]
fn messages_of_queues_are_read() {
    let encode = |(datum, schema): (Datum, &Schema)| {
        let layout = QueueLayout::of(schema).ok()?;
        let mut bytes = Vec::new();
        layout.encode(&datum, &mut bytes).ok()?;
        Some(bytes)
    };
    let seeds: Vec<_> = samples().into_iter().filter_map(encode).collect();
    assert!(seeds.len() > 1);
    holds(queue, &seeds, false, 2_000);
}

#[test]
fn extracts_in_xml_are_read() {
    holds(osm, &map("osm"), true, 1_000);
}

#[test]
fn extracts_in_pbf_are_read() {
    holds(osm_pbf, &map("osm.pbf"), false, 3_000);
}
