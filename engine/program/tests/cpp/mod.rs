//! Components in C and C++, with the headers of `cpp/`.

use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::process::{Command, Stdio};

use asmotion_datum::Codec;
use asmotion_skip::compile;

use super::*;

mod memory;

const GRIPPER: &str = "examples/gripper-cpp/gripper.cpp";

/// The command of a program of this folder or of an example; `None` without a compiler.
fn compiled(source: &str, arguments: &[&str]) -> Option<ProgramCommand> {
    let program = compile(source)?.display().to_string();
    let words = [program.as_str()].into_iter();
    let words = words.chain(arguments.iter().copied());
    Some(ProgramCommand {
        words: words.map(str::to_owned).collect(),
        timeout: Duration::from_secs(5),
        ..command(&[])
    })
}

fn probe(arguments: &[&str]) -> Option<ProgramCommand> {
    compiled("engine/program/tests/cpp/probe.cpp", arguments)
}

fn counter(arguments: &[&str]) -> Option<ProgramCommand> {
    compiled("engine/program/tests/cpp/counter.c", arguments)
}

#[test]
fn a_component_in_cpp_behaves_as_one_in_python() {
    let Some(cpp) = compiled(GRIPPER, &[]) else {
        return;
    };
    for refuses in [false, true] {
        let time = Duration::from_millis(1900);
        let expected = trace(gripper(refuses), time);
        assert_eq!(trace(operated(&cpp, refuses), time), expected);
        assert_eq!(trace(operated(&cpp, refuses), time), expected);
    }
}

#[test]
fn a_component_in_cpp_continues_in_another_process() {
    let Some(cpp) = compiled(GRIPPER, &[]) else {
        return;
    };
    let log = Log::new();
    let mut first = operated(&cpp, false);
    first.observe(log.clone());
    let mut first = first.simulate();
    // a call is under way, and a reply is due
    first.run_for(Duration::from_millis(550));
    let frozen = first.freeze().expect("a frozen state");
    let before = log.lines().len();
    first.run_for(Duration::from_millis(900));
    let other = Log::new();
    let mut second = operated(&cpp, false);
    second.observe(other.clone());
    let mut second = second.simulate();
    second.thaw(&frozen).expect("a thawed system");
    let thawed = other.lines().len();
    second.run_for(Duration::from_millis(900));
    assert_eq!(log.lines()[before..], other.lines()[thawed..]);
    assert_eq!(second.freeze().unwrap(), first.freeze().unwrap());
}

/// Gives one sample in its first cycle.
struct Giver {
    to: Out<Datum>,
    sample: Datum,
}

impl Component for Giver {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if cycle.number() == 1 {
            cycle.write(self.to, self.sample.clone());
        }
        Ok(())
    }
}

/// Keeps the newest sample.
struct Taker {
    from: In<Datum>,
    taken: std::sync::Arc<std::sync::Mutex<Datum>>,
}

impl Component for Taker {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Some(sample) = cycle.all(self.from).last() {
            *self.taken.lock().unwrap() = sample.clone();
        }
        Ok(())
    }
}

/// Passes a sample through a program.
pub fn passed(through: &ProgramCommand, port: (&str, &str), sample: Datum) -> Datum {
    let declared = declaration(through).expect("a declaration");
    let schema = declared.types().values().next().unwrap().to_owned().clone();
    let schema = schema.name.into_owned();
    let mut system = System::new();
    let taken = std::sync::Arc::<std::sync::Mutex<Datum>>::default();
    let kept = std::sync::Arc::clone(&taken);
    add(&mut system, "Echo", through, every(100));
    let of = schema.clone();
    let giver = move |interface: &mut Interface| {
        let to = interface.output_of("to", Schema::opaque(of), "");
        Box::new(Giver { to, sample }) as Box<dyn Component>
    };
    let taker = move |interface: &mut Interface| {
        let from = interface.input_of("from", Schema::opaque(schema), "");
        Box::new(Taker { from, taken: kept }) as Box<dyn Component>
    };
    system.add("Giver", every(100), giver).unwrap();
    system.add("Taker", every(100), taker).unwrap();
    let input = format!("Echo.{}", port.0);
    let output = format!("Echo.{}", port.1);
    let data = Policy::data();
    system.connect("Giver.to", &input, data.clone()).unwrap();
    system.connect(&output, "Taker.from", data).unwrap();
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.simulate();
    run.run_for(Duration::from_millis(350));
    assert_eq!(log.lines_with("fault"), Vec::<String>::new());
    let taken = taken.lock().unwrap();
    taken.clone()
}

#[test]
fn data_of_all_types_pass_through_cpp_unchanged() {
    let Some(echo) = probe(&["echo"]) else {
        return;
    };
    let declared = declaration(&echo).unwrap();
    let everything = declared.types()["acme/Everything"].clone();
    let initial = everything.complete(Datum::record::<&str>([])).unwrap();
    insta::assert_snapshot!(initial, @r#"{yes: true, u8: 0, i32: 0, i64: -9223372036854775808, u64: 0, f32: 0.0, f64: 1.5, text: "", maybe: null, bytes: [], floats: [], longs: [], flags: [], words: [], three: [1.0, 2.0, 3.0], inner: {count: 7, name: null}, inners: [], any: null}"#);
    let passed_initial = passed(&echo, ("in", "out"), initial.clone());
    // an empty list of `u8` comes back as bytes
    let expected = initial.to_string().replace("bytes: []", "bytes: 0 bytes");
    assert_eq!(passed_initial.to_string(), expected);
    let list = |parts: &[i64]| Datum::List(parts.iter().copied().map(Datum::Int).collect());
    let texts = ["", "grüß dich", "\u{10ffff}"].map(Datum::text);
    let inner = Datum::record([("count", Datum::Int(-32768)), ("name", Datum::text("one"))]);
    let any = Datum::record([
        ("nothing", Datum::Null),
        (
            "parts",
            Datum::List(vec![Datum::Bool(true), Datum::Float(0.5), Datum::text("a")]),
        ),
        ("bytes", Datum::Bytes([1, 2, 255].as_slice().into())),
    ]);
    let sample = Datum::record([
        ("yes", Datum::Bool(false)),
        ("u8", Datum::Int(255)),
        ("i32", Datum::Int(i64::from(i32::MIN))),
        ("i64", Datum::Int(i64::MAX)),
        ("u64", Datum::Int(i64::MAX)),
        ("f32", Datum::Float(0.25)),
        ("f64", Datum::Float(f64::INFINITY)),
        ("text", Datum::text("the \"fingers\"\n")),
        ("maybe", Datum::Float(-0.0)),
        (
            "bytes",
            Datum::Bytes((0..100_000).map(|it| it as u8).collect()),
        ),
        (
            "floats",
            Datum::Numbers(asmotion_datum::Numbers::F32(
                (0..5000).map(|it| it as f32).collect(),
            )),
        ),
        ("longs", list(&[0, 1, i64::MAX])),
        (
            "flags",
            Datum::List(vec![Datum::Bool(true), Datum::Bool(false)]),
        ),
        ("words", Datum::List(texts.to_vec())),
        (
            "three",
            Datum::Numbers(asmotion_datum::Numbers::F64([1.0, -2.0, 1e300].into())),
        ),
        ("inner", inner.clone()),
        ("inners", Datum::List(vec![inner; 100])),
        ("any", any),
    ]);
    assert_eq!(passed(&echo, ("in", "out"), sample.clone()), sample);
}

#[test]
fn inputs_for_commands_are_marked_in_the_declaration_of_a_program_in_cpp() {
    let Some(echo) = probe(&["echo"]) else {
        return;
    };
    let inputs = declaration(&echo)
        .expect("a declaration")
        .declaration
        .inputs;
    let marked = inputs.iter().map(|it| (it.name.as_str(), it.command));
    assert_eq!(
        marked.collect::<Vec<_>>(),
        [("in", false), ("target", true)]
    );
}

/// The lines of a program that runs beside itself: its reference is wired to the service of another one.
fn effects(activity: Activity) -> Option<String> {
    let program = probe(&["effects"])?;
    let mut system = System::new();
    let activity = activity
        .on_exception(OnException::Reset)
        .max_resets(Some(1));
    add(&mut system, "Probe", &program, activity);
    add(&mut system, "Peer", &program, Activity::event());
    let wire = Wire::default();
    system.wire("Probe.peer", "Peer.service", wire).unwrap();
    system.wire("Peer.peer", "Probe.service", wire).unwrap();
    Some(trace(system, Duration::from_millis(700)))
}

#[test]
fn a_component_in_cpp_has_all_effects_of_a_cycle() {
    let Some(lines) = effects(every(100)) else {
        return;
    };
    insta::assert_snapshot!("cpp_effects", lines);
}

/// The lines of a failing program.
fn failing(program: &ProgramCommand) -> String {
    let mut system = System::new();
    add(&mut system, "Bad", program, every(100));
    let mut lines = trace(system, Duration::from_millis(450));
    lines = lines.replace(&program.words[0], "[program]");
    lines
}

#[test]
fn failures_in_c_and_cpp_are_faults() {
    let mut text = String::new();
    for (how, program) in [
        ("faults", probe(&["faults"])),
        ("throws", probe(&["throws"])),
        ("ends", probe(&["ends"])),
        ("type", counter(&["type"])),
        ("port", counter(&["port"])),
        ("fault", counter(&["fault"])),
    ] {
        let Some(program) = program else {
            return;
        };
        text += &format!("{how}\n{}\n\n", failing(&program));
    }
    insta::assert_snapshot!("cpp_failures", text);
}

#[test]
fn a_component_in_c_counts_and_continues() {
    let Some(program) = counter(&[]) else {
        return;
    };
    let system = || {
        let mut system = System::new();
        add(&mut system, "Counter", &program, every(100));
        system
    };
    let time = Duration::from_millis(550);
    let lines = trace(system(), time);
    assert!(lines.contains("Counter.count #6 = {n: 6}"), "{lines}");
    assert_eq!(lines, trace(system(), time));
    let mut first = system().simulate();
    first.run_for(time);
    let mut second = system();
    let log = Log::new();
    second.observe(log.clone());
    let mut second = second.simulate();
    second.thaw(&first.freeze().unwrap()).unwrap();
    second.run_for(Duration::from_millis(100));
    assert_eq!(log.lines_with("{n: 7}").len(), 1, "{:?}", log.lines());
}

#[test]
fn a_component_in_cpp_requests_cycles_from_a_thread() {
    let Some(program) = probe(&["wakes"]) else {
        return;
    };
    let mut system = System::new();
    add(&mut system, "Device", &program, Activity::event());
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.live();
    run.run_for(Duration::from_millis(900));
    let cycles = log.lines_with("awake").len();
    assert!((5..=30).contains(&cycles), "{cycles} cycles");
}

#[test]
fn a_component_in_cpp_requests_a_cycle_at_a_time() {
    let Some(program) = probe(&["ticks"]) else {
        return;
    };
    let (system, log) = timed(&program);
    system.simulate().run_for(Duration::from_millis(300));
    assert_eq!(reported(&log, "now"), [0, 70, 140, 210, 280]);
}

/// Items of RFC 8949, appendix A, and others that matter here: whether C reads them.
const ITEMS: &str = include_str!("items.txt");

/// The tag of a reference to shared memory, encoded.
const SHARED: &str = "da0061736d";

#[test]
fn cbor_in_c_is_that_of_the_standard() {
    let Some(program) = compile("engine/program/tests/cpp/cbor.c") else {
        return;
    };
    let items = ITEMS.lines().filter(|line| !line.starts_with('#'));
    let (hex, wanted): (Vec<&str>, Vec<&str>) = items.filter_map(|it| it.split_once(' ')).unzip();
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    input.write_all((hex.join("\n") + "\n").as_bytes()).unwrap();
    drop(input);
    let output = child.wait_with_output().unwrap();
    // a sanitizer ends a program with a report
    assert!(output.status.success(), "{output:?}");
    let bytes = |hex: &str| -> Vec<u8> {
        let digits = (0..hex.len()).step_by(2);
        digits
            .map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap())
            .collect()
    };
    let decode = |hex: &str| Codec::Cbor.decode(&bytes(hex), &Schema::plain(Shape::Any));
    let written = String::from_utf8(output.stdout).unwrap();
    assert_eq!(written.lines().count(), hex.len());
    for ((hex, wanted), written) in hex.iter().zip(wanted).zip(written.lines()) {
        if wanted == "refused" {
            assert_eq!(written, wanted, "{hex}");
        } else {
            assert_ne!(written, "refused", "{hex}: {wanted}");
            let again = decode(written).unwrap();
            assert_eq!(again.to_string(), wanted, "{hex} → {written}");
            // the engine reads references to shared memory only where it has given some
            if !hex.contains(SHARED) {
                let original = decode(hex).unwrap();
                assert_eq!(format!("{original:?}"), format!("{again:?}"), "{hex}");
            }
        }
    }
}

/// Sends frames to a program as an engine would, and returns its replies and what it printed.
fn talk(program: &ProgramCommand, frames: &[&[u8]]) -> (Vec<u8>, String) {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("socket");
    let listener = UnixListener::bind(&socket).unwrap();
    let mut child = Command::new(&program.words[0])
        .args(&program.words[1..])
        .env("ASMOTION_SOCKET", &socket)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut stream, _): (UnixStream, _) = listener.accept().unwrap();
    for frame in frames {
        // a program that has ended reads no more
        let _ = stream.write_all(frame);
    }
    let _ = stream.shutdown(std::net::Shutdown::Write);
    let mut replies = Vec::new();
    let _ = stream.read_to_end(&mut replies);
    let mut said = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    child.wait().unwrap();
    (replies, said)
}

/// A frame with this message.
fn frame(message: &Datum) -> Vec<u8> {
    let content = Codec::Cbor
        .encode(message, &Schema::plain(Shape::Any))
        .unwrap();
    [&(content.len() as u32).to_le_bytes()[..], &content].concat()
}

#[test]
fn a_program_in_cpp_survives_garbage_from_the_engine() {
    let Some(program) = compiled(GRIPPER, &[]) else {
        return;
    };
    let message = |entries: &[(&'static str, Datum)]| frame(&Datum::record(entries.to_vec()));
    let hello = message(&[
        ("type", "hello".into()),
        ("protocol", 1.into()),
        ("shared_memory", (1 << 40).into()),
    ]);
    let configure = message(&[
        ("type", "configure".into()),
        (
            "properties",
            Datum::record([("speed", Datum::text("fast"))]),
        ),
    ]);
    let cycle = message(&[("type", "cycle".into()), ("now", Datum::Null)]);
    let samples = Datum::record([("samples", Datum::List(vec![Datum::Int(3)]))]);
    let inputs = Datum::record([("command", samples)]);
    let misfit = message(&[
        ("type", "cycle".into()),
        ("now", 0.into()),
        ("number", 1.into()),
        ("inputs", inputs),
    ]);
    let request = Datum::record([
        ("id", Datum::Int(1)),
        ("caller", "".into()),
        ("service", "grip".into()),
        ("operation", "open".into()),
    ]);
    let requests = Datum::List(vec![request]);
    let unknown = message(&[
        ("type", "serve".into()),
        ("now", 0.into()),
        ("number", 1.into()),
        ("requests", requests),
    ]);
    let thaw = message(&[
        ("type", "thaw".into()),
        ("state", Datum::Bytes([0x9f, 0x01].as_slice().into())),
    ]);
    let strange = message(&[("type", "dance".into())]);
    let all = [hello, configure, cycle, misfit, unknown, thaw, strange];
    let all: Vec<&[u8]> = all.iter().map(Vec::as_slice).collect();
    let (mut replies, said) = talk(&program, &all);
    assert_eq!(said, "");
    let mut texts = Vec::new();
    while let Some((head, rest)) = replies.split_first_chunk::<4>() {
        let (one, more) = rest.split_at(u32::from_le_bytes(*head) as usize);
        let reply = Codec::Cbor.decode(one, &Schema::plain(Shape::Any)).unwrap();
        texts.push(
            reply
                .get("text")
                .map(|it| it.to_string())
                .unwrap_or_default(),
        );
        replies = more.to_vec();
    }
    insta::assert_snapshot!("cpp_garbage", texts.join("\n"));
    for garbage in [
        &b"HTTP/1.1 400 Bad Request\r\n\r\n"[..],
        &[3, 0, 0, 0, 0xff, 0xff, 0xff],
        &[0, 0, 0, 0],
        &[9, 0, 0, 0, 0xa0],
    ] {
        let (replies, said) = talk(&program, &[garbage]);
        assert!(replies.is_empty());
        assert!(!said.contains("Sanitizer"), "{said}");
    }
}
