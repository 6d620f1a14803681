//! A program that returns each sample of its input, written from the page of the protocol.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;

use asmotion_component::Declaration;
use asmotion_component::declaration::PortDeclaration;
use asmotion_datum::{Codec, Datum, OutlineKey, Schema, Shape};

/// The sample: a pose with a number, 56 bytes.
pub(crate) fn sample_schema() -> Schema {
    let number = OutlineKey::new("number", "", Schema::plain(Shape::I64));
    let pose = ["x", "y", "z", "roll", "pitch", "yaw"];
    let pose = pose.map(|name| OutlineKey::new(name, "", Schema::plain(Shape::F64)));
    let fields = [number].into_iter().chain(pose);
    Schema::record("bench/Sample", fields.collect())
}

/// A sample with this number.
pub(crate) fn sample(number: i64) -> Datum {
    let pose = ["x", "y", "z", "roll", "pitch", "yaw"].map(|name| (name, Datum::Float(0.1)));
    let number = [("number", Datum::Int(number))];
    Datum::record(number.into_iter().chain(pose))
}

/// Serves one component until the engine ends it.
pub(crate) fn serve() {
    let socket = std::env::var("ASMOTION_SOCKET").unwrap();
    let mut stream = UnixStream::connect(socket).unwrap();
    let any = Schema::plain(Shape::Any);
    let mut bytes = Vec::new();
    loop {
        let mut length = [0; 4];
        if stream.read_exact(&mut length).is_err() {
            return;
        }
        bytes.resize(u32::from_le_bytes(length) as usize, 0);
        stream.read_exact(&mut bytes).unwrap();
        let request = Codec::Cbor.decode(&bytes, &any).unwrap();
        let reply = match entry(&request, "type").and_then(Datum::as_text).unwrap() {
            "hello" => declaration(),
            "cycle" => done(&request),
            "stop" => Datum::record([("type", Datum::text("done"))]),
            "exit" => return,
            _ => Datum::record([("type", Datum::text("ok"))]),
        };
        let reply = Codec::Cbor.encode(&reply, &any).unwrap();
        let length = u32::try_from(reply.len()).unwrap().to_le_bytes();
        stream.write_all(&[&length[..], &reply].concat()).unwrap();
    }
}

fn declaration() -> Datum {
    let port = |name: &str| PortDeclaration {
        name: name.to_owned(),
        schema: sample_schema(),
        doc: String::new(),
        safe: None,
        command: false,
        optional: false,
    };
    let declaration = Declaration {
        inputs: vec![port("in")],
        outputs: vec![port("out")],
        ..Declaration::default()
    };
    let Datum::Record(mut entries) = Datum::of(&declaration).unwrap() else {
        panic!("a declaration is a record");
    };
    entries.push(("type".into(), Datum::text("declare")));
    entries.push(("protocol".into(), Datum::Int(1)));
    Datum::Record(entries)
}

fn done(request: &Datum) -> Datum {
    let samples = entry(request, "inputs")
        .and_then(|it| entry(it, "in"))
        .and_then(|it| entry(it, "samples"));
    let mut entries = vec![("type", Datum::text("done"))];
    if let Some(Datum::List(samples)) = samples
        && let Some(newest) = samples.last()
    {
        let output = Datum::List(vec![Datum::text("out"), newest.clone()]);
        entries.push(("outputs", Datum::List(vec![output])));
    }
    Datum::record(entries)
}

fn entry<'d>(record: &'d Datum, key: &str) -> Option<&'d Datum> {
    let Datum::Record(entries) = record else {
        return None;
    };
    entries
        .iter()
        .find(|(name, _)| name == key)
        .map(|(_, value)| value)
}
