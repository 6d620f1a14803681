//! Exchanges messages with a peer in Python, written from the description of the format alone, and tests the system's
//! limits.
#![cfg(target_os = "linux")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "helpers of tests"
)]

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use asmotion_datum::{Datum, DatumError, Message};
use asmotion_mqueue::{
    FirstMessage, FullQueuePolicy, QueueCapacity, QueueCheckError, QueueLayout, QueueName,
    QueueReader, QueueWriter,
};
use asmotion_runtime::PushOutcome;

asmotion_datum::message! {
    /// The message type that both sides use.
    pub struct Joints = "test/Joints" {
        /// a truth value
        pub flag: bool,
        /// numbers of 16 bits
        pub errors: [u16; 3],
        /// a list of doubles
        pub position: Vec<f64>,
    }
}

const SIZE: usize = 128;

/// A queue name that only this process uses.
fn name(what: &str) -> QueueName {
    QueueName::new(&format!("/asmotion-{}-{what}", std::process::id())).unwrap()
}

fn layout() -> QueueLayout {
    QueueLayout::of(Joints::schema()).unwrap()
}

fn writer(name: &QueueName, messages: usize, keep: FullQueuePolicy) -> QueueWriter {
    let room = QueueCapacity {
        messages,
        size: SIZE,
    };
    QueueWriter::open(name.clone(), layout(), room, keep).unwrap()
}

fn joints(number: u16) -> Joints {
    Joints {
        flag: true,
        errors: [number, 2, 3],
        position: vec![f64::from(number) / 2.0; usize::from(number)],
    }
}

/// Starts the peer. Returns `None` and prints a notice if Python is not installed.
fn peer(arguments: &[&str]) -> Option<Child> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py");
    let peer = Command::new("python3")
        .arg(script)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn();
    if peer.is_err() {
        eprintln!("skipped: there is no python3");
    }
    peer.ok()
}

/// The next message within five seconds.
fn next(reader: &mut QueueReader) -> Option<Result<Datum, DatumError>> {
    let until = Instant::now() + Duration::from_secs(5);
    while Instant::now() < until {
        let message = reader.next(Duration::from_millis(100));
        if message.is_some() {
            return message;
        }
    }
    None
}

#[test]
fn o17_a_peer_reads_what_ours_writes_the_first_message_at_once() {
    let name = name("out");
    let mut writer = writer(&name, 10, FullQueuePolicy::Oldest);
    let Some(mut peer) = peer(&["read", name.as_str(), "3"]) else {
        return;
    };
    let mut lines = BufReader::new(peer.stdout.take().unwrap()).lines();
    let mut line = || lines.next().unwrap().unwrap();
    assert_eq!(
        line(),
        r#"initial {"flag": false, "errors": [0, 0, 0], "position": []}"#
    );
    for number in 0..3 {
        assert_eq!(writer.send(&joints(number)), Ok(PushOutcome::Stored));
    }
    assert_eq!(
        line(),
        r#"{"flag": true, "errors": [0, 2, 3], "position": []}"#
    );
    assert_eq!(
        line(),
        r#"{"flag": true, "errors": [1, 2, 3], "position": [0.5]}"#
    );
    assert_eq!(
        line(),
        r#"{"flag": true, "errors": [2, 2, 3], "position": [1.0, 1.0]}"#
    );
    assert!(peer.wait().unwrap().success());
}

#[test]
fn o17_ours_reads_what_a_peer_writes_and_its_first_message_is_no_data() {
    let name = name("in");
    // the reader waits for the queue, which the writer creates
    let mut reader = QueueReader::new(name.clone(), layout(), FirstMessage::Shape);
    let Some(mut peer) = peer(&["write", name.as_str(), "3"]) else {
        return;
    };
    for number in 0..3 {
        let message = next(&mut reader).unwrap().unwrap();
        assert_eq!(message.to::<Joints>().unwrap(), joints(number));
    }
    let problem = next(&mut reader).unwrap().unwrap_err().to_string();
    assert!(problem.starts_with("`errors`: malformed"), "{problem}");
    // the peer is replaced by another one, and so is the queue
    drop(peer.stdin.take());
    assert!(peer.wait().unwrap().success());
    let mut peer = self::peer(&["write", name.as_str(), "1"]).unwrap();
    let message = next(&mut reader).unwrap().unwrap();
    assert_eq!(message.to::<Joints>().unwrap(), joints(0));
    drop(peer.stdin.take());
    assert!(peer.wait().unwrap().success());
}

#[test]
fn the_first_message_is_data_where_that_is_wanted() {
    let name = name("first");
    let _writer = writer(&name, 10, FullQueuePolicy::Oldest);
    let mut reader = QueueReader::new(name, layout(), FirstMessage::Data);
    let message = next(&mut reader).unwrap().unwrap();
    assert_eq!(message.to::<Joints>().unwrap(), Joints::default());
}

#[test]
fn a_reader_that_is_not_there_never_holds_the_writer() {
    for (keep, full, kept) in [
        (FullQueuePolicy::Oldest, PushOutcome::DroppedNewest, [1, 2]),
        (FullQueuePolicy::Newest, PushOutcome::DroppedOldest, [4, 5]),
        (FullQueuePolicy::Last, PushOutcome::Stored, [4, 5]),
    ] {
        let name = name(&format!("{keep:?}"));
        let mut writer = writer(&name, 3, keep);
        let sent: Vec<_> = (1..6)
            .map(|number| writer.send(&joints(number)).unwrap())
            .collect();
        assert_eq!(sent[..2], [PushOutcome::Stored; 2], "{keep:?}");
        assert_eq!(sent[2..], [full; 3], "{keep:?}");
        let mut reader = QueueReader::new(name, layout(), FirstMessage::Shape);
        // the first message shows the layout, whatever its content
        let left: Vec<_> = (0..2)
            .map(|_| next(&mut reader).unwrap().unwrap())
            .collect();
        let left = left.iter().map(|message| message.to::<Joints>().unwrap());
        assert_eq!(left.collect::<Vec<_>>(), kept.map(joints), "{keep:?}");
    }
}

#[test]
fn a_message_that_is_too_large_is_told() {
    let mut writer = writer(&name("large"), 3, FullQueuePolicy::Last);
    let problem = writer.send(&joints(100)).unwrap_err().to_string();
    assert!(
        problem.contains("has messages of 128 bytes, but these have 815"),
        "{problem}"
    );
    assert_eq!(writer.send(&joints(1)), Ok(PushOutcome::Stored));
}

#[test]
fn what_a_writer_before_has_left_is_no_data() {
    let name = name("left");
    let first = writer(&name, 3, FullQueuePolicy::Oldest);
    let mut second = writer(&name, 3, FullQueuePolicy::Oldest);
    second.send(&joints(7)).unwrap();
    let mut reader = QueueReader::new(name.clone(), layout(), FirstMessage::Shape);
    let message = next(&mut reader).unwrap().unwrap();
    assert_eq!(message.to::<Joints>().unwrap(), joints(7));
    let small = QueueCapacity {
        messages: 3,
        size: 2 * SIZE,
    };
    let refused = QueueWriter::open(name.clone(), layout(), small, FullQueuePolicy::Last)
        .err()
        .unwrap();
    assert_eq!(
        refused,
        QueueCheckError::Smaller {
            queue: name.to_string(),
            required: SIZE,
            size: 2 * SIZE
        }
    );
    drop((first, second));
}

#[test]
fn limits_are_named_with_the_way_to_raise_them() {
    let open = |messages, size| {
        let room = QueueCapacity { messages, size };
        let refused =
            QueueWriter::open(name("limits"), layout(), room, FullQueuePolicy::Last).err();
        refused
            .map(|refused| refused.to_string())
            .unwrap_or_default()
    };
    let refused = open(100_000, 8);
    assert!(
        refused.contains("`sysctl fs.mqueue.msg_max=100000`"),
        "{refused}"
    );
    let refused = open(1, 100_000_000);
    assert!(
        refused.contains("`sysctl fs.mqueue.msgsize_max=100000000`"),
        "{refused}"
    );
    let refused = open(1, 0);
    assert!(refused.contains("`data_size = BYTES`"), "{refused}");
}
