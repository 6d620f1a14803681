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

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use asmotion_datum::{Datum, DatumError, Message};
use asmotion_mqueue::{
    FullQueuePolicy, QueueCapacity, QueueCheckError, QueueEvent, QueueLayout, QueueName,
    QueueReader, QueueWriter,
};
use asmotion_runtime::{PushOutcome, Sink, SinkUpkeep};

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
        asmotion_skip::PYTHON.skip();
    }
    peer.ok()
}

/// A peer that obeys commands. Killed on drop, as a process may be.
struct Obedient {
    child: Child,
    answers: std::io::Lines<BufReader<std::process::ChildStdout>>,
}

impl Obedient {
    fn start(name: &QueueName) -> Option<Self> {
        let mut child = peer(&["serve", name.as_str()])?;
        let answers = BufReader::new(child.stdout.take().unwrap()).lines();
        Some(Self { child, answers })
    }

    fn ask(&mut self, command: &str) -> String {
        writeln!(self.child.stdin.as_mut().unwrap(), "{command}").unwrap();
        self.answers.next().unwrap().unwrap()
    }

    fn does(&mut self, command: &str) {
        assert_eq!(self.ask(command), "done", "{command}");
    }
}

impl Drop for Obedient {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The next event within five seconds.
fn event(reader: &mut QueueReader) -> Option<QueueEvent> {
    let until = Instant::now() + Duration::from_secs(5);
    while Instant::now() < until {
        let event = reader.next(Duration::from_millis(100));
        if event.is_some() {
            return event;
        }
    }
    None
}

/// The next message within five seconds, or the reason why it was discarded.
fn next(reader: &mut QueueReader) -> Option<Result<Datum, DatumError>> {
    match event(reader)? {
        QueueEvent::Message(datum) => Some(Ok(datum)),
        QueueEvent::Discarded { reason, .. } => Some(Err(reason)),
        QueueEvent::Waiting => None,
    }
}

/// The number of the next message.
fn number(reader: &mut QueueReader) -> Result<u16, String> {
    let message = next(reader).expect("a message");
    let message = message.map_err(|reason| reason.to_string())?;
    Ok(message.to::<Joints>().unwrap().errors[0])
}

/// Reads for this long without an event.
fn silence(reader: &mut QueueReader, time: Duration) {
    let until = Instant::now() + time;
    while Instant::now() < until {
        assert_eq!(reader.next(Duration::from_millis(50)), None);
    }
}

/// Does the upkeep for this long, as a live system does. Returns the reports.
fn tend(upkeep: &mut dyn SinkUpkeep, time: Duration) -> Vec<(u64, String)> {
    let until = Instant::now() + time;
    let mut reports = Vec::new();
    while Instant::now() < until {
        upkeep.tend(&mut |count, reason| reports.push((count, reason.to_string())));
        std::thread::sleep(Duration::from_millis(50));
    }
    reports
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
    let mut reader = QueueReader::new(name.clone(), layout());
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
fn a_reader_that_is_not_there_never_holds_the_writer() {
    use PushOutcome::{DroppedNewest, DroppedOldest, Stored};
    // the first message to be replaced is the one that shows the layout, which is no loss
    for (keep, outcomes, kept) in [
        (
            FullQueuePolicy::Oldest,
            [Stored, Stored, DroppedNewest, DroppedNewest, DroppedNewest],
            vec![1, 2],
        ),
        (
            FullQueuePolicy::Newest,
            [Stored, Stored, Stored, DroppedOldest, DroppedOldest],
            vec![3, 4, 5],
        ),
        (FullQueuePolicy::Last, [Stored; 5], vec![3, 4, 5]),
    ] {
        let name = name(&format!("{keep:?}"));
        let mut writer = writer(&name, 3, keep);
        let sent = (1..6).map(|number| writer.send(&joints(number)).unwrap());
        assert_eq!(sent.collect::<Vec<_>>(), outcomes, "{keep:?}");
        let mut reader = QueueReader::new(name, layout());
        let left = kept.iter().map(|_| number(&mut reader).unwrap());
        assert_eq!(left.collect::<Vec<_>>(), kept, "{keep:?}");
    }
}

#[test]
fn no_zeros_are_sent_into_a_queue_that_a_peer_has_open() {
    let name = name("held");
    let Some(mut peer) = Obedient::start(&name) else {
        return;
    };
    peer.does("make");
    let mut writer = writer(&name, 4, FullQueuePolicy::Newest);
    assert_eq!(peer.ask("read 0.3"), "nothing");
    writer.send(&joints(1)).unwrap();
    assert_eq!(peer.ask("read 5"), "1");
}

#[test]
fn a_peer_that_stays_reads_what_the_next_writer_sends() {
    let name = name("stays");
    let mut first = writer(&name, 4, FullQueuePolicy::Oldest);
    let Some(mut peer) = Obedient::start(&name) else {
        return;
    };
    peer.does("open");
    assert_eq!(peer.ask("read 5"), "0");
    first.send(&joints(1)).unwrap();
    assert_eq!(peer.ask("read 5"), "1");
    drop(first);
    let mut second = writer(&name, 4, FullQueuePolicy::Oldest);
    assert_eq!(peer.ask("read 0.3"), "nothing");
    second.send(&joints(2)).unwrap();
    assert_eq!(peer.ask("read 5"), "2");
    peer.does("unlink");
}

#[test]
fn a_queue_that_nobody_has_used_is_removed() {
    let name = name("unused");
    drop(writer(&name, 4, FullQueuePolicy::Oldest));
    let Some(mut peer) = Obedient::start(&name) else {
        return;
    };
    assert_eq!(peer.ask("open"), "No such file or directory");
}

#[test]
fn a_queue_of_one_message_holds_the_newest() {
    let name = name("one");
    let mut writer = writer(&name, 1, FullQueuePolicy::Last);
    for number in 1..=5 {
        assert_eq!(writer.send(&joints(number)), Ok(PushOutcome::Stored));
    }
    let Some(mut peer) = Obedient::start(&name) else {
        return;
    };
    peer.does("open");
    assert_eq!(peer.ask("read 5"), "5");
    assert_eq!(peer.ask("read 0.2"), "nothing");
}

#[test]
fn messages_older_than_the_limit_are_discarded_and_reported() {
    let name = name("old");
    let limit = Duration::from_millis(300);
    let mut writer = writer(&name, 10, FullQueuePolicy::Oldest).max_age(Some(limit));
    let mut upkeep = writer.upkeep().unwrap();
    let Some(mut peer) = Obedient::start(&name) else {
        return;
    };
    writer.send(&joints(1)).unwrap();
    writer.send(&joints(2)).unwrap();
    // at the next message
    std::thread::sleep(2 * limit);
    writer.send(&joints(3)).unwrap();
    peer.does("open");
    assert_eq!(peer.ask("read 5"), "3");
    // without one
    writer.send(&joints(4)).unwrap();
    let reports = tend(&mut *upkeep, 2 * limit);
    assert_eq!(peer.ask("read 0.2"), "nothing");
    let count: u64 = reports.iter().map(|(count, _)| count).sum();
    assert_eq!(count, 3, "{reports:?}");
    assert!(
        reports[0].1.contains("not read within 300ms"),
        "{reports:?}"
    );
    writer.send(&joints(5)).unwrap();
    assert_eq!(peer.ask("read 5"), "5");
}

#[test]
fn a_peer_that_starts_again_is_shown_the_last_message_of_a_quiet_writer() {
    let name = name("quiet");
    let mut writer = writer(&name, 10, FullQueuePolicy::Oldest);
    let mut upkeep = writer.upkeep().unwrap();
    let Some(mut peer) = Obedient::start(&name) else {
        return;
    };
    peer.does("open");
    assert_eq!(peer.ask("read 5"), "0");
    writer.send(&joints(3)).unwrap();
    assert_eq!(peer.ask("read 5"), "3");
    tend(&mut *upkeep, Duration::from_millis(2500));
    assert_eq!(peer.ask("read 0.1"), "nothing");
    drop(peer);
    let mut peer = Obedient::start(&name).unwrap();
    peer.does("open");
    tend(&mut *upkeep, Duration::from_millis(500));
    assert_eq!(peer.ask("read 5"), "3");
    writer.send(&joints(4)).unwrap();
    assert_eq!(peer.ask("read 5"), "4");
    tend(&mut *upkeep, Duration::from_millis(1500));
    assert_eq!(peer.ask("read 0.1"), "nothing");
}

#[test]
fn a_reader_that_starts_again_gets_the_next_message_of_a_peer_that_stays() {
    let name = name("again");
    let mut reader = QueueReader::new(name.clone(), layout());
    let Some(mut peer) = Obedient::start(&name) else {
        return;
    };
    assert_eq!(reader.next(Duration::ZERO), None);
    peer.does("offer");
    peer.does("write 1");
    assert_eq!(number(&mut reader), Ok(1));
    drop(reader);
    let mut reader = QueueReader::new(name.clone(), layout());
    silence(&mut reader, Duration::from_millis(700));
    peer.does("write 2");
    assert_eq!(number(&mut reader), Ok(2));
    drop(reader);
    // a message that comes at once may be one that shows the layout
    let mut reader = QueueReader::new(name, layout());
    peer.does("write 3");
    peer.does("write 4");
    let discarded = number(&mut reader).unwrap_err();
    assert!(
        discarded.contains("may only show the layout"),
        "{discarded}"
    );
    assert_eq!(number(&mut reader), Ok(4));
    peer.does("unlink");
}

#[test]
fn the_first_message_of_a_peer_that_starts_again_is_no_data() {
    let name = name("killed");
    let mut reader = QueueReader::new(name.clone(), layout());
    let Some(mut peer) = Obedient::start(&name) else {
        return;
    };
    assert_eq!(reader.next(Duration::ZERO), None);
    peer.does("offer");
    peer.does("write 1");
    assert_eq!(number(&mut reader), Ok(1));
    silence(&mut reader, Duration::from_millis(300));
    peer.does("write 2");
    drop(peer);
    // what the writer has left is data
    assert_eq!(number(&mut reader), Ok(2));
    silence(&mut reader, Duration::from_millis(300));
    let mut peer = Obedient::start(&name).unwrap();
    peer.does("offer");
    peer.does("write 3");
    let discarded = number(&mut reader).unwrap_err();
    assert!(
        discarded.contains("first message of a new writer"),
        "{discarded}"
    );
    assert_eq!(number(&mut reader), Ok(3));
    peer.does("unlink");
}

#[test]
fn our_own_writer_may_start_again_without_a_loss() {
    let name = name("own");
    let mut first = writer(&name, 10, FullQueuePolicy::Oldest);
    let mut reader = QueueReader::new(name.clone(), layout());
    first.send(&joints(1)).unwrap();
    assert_eq!(number(&mut reader), Ok(1));
    drop(first);
    silence(&mut reader, Duration::from_millis(200));
    let mut second = writer(&name, 10, FullQueuePolicy::Oldest);
    second.send(&joints(2)).unwrap();
    assert_eq!(number(&mut reader), Ok(2));
}

#[test]
fn with_an_age_limit_nothing_is_read_that_waited_for_the_reader() {
    let name = name("waited");
    let mut writer = writer(&name, 10, FullQueuePolicy::Oldest);
    writer.send(&joints(1)).unwrap();
    writer.send(&joints(2)).unwrap();
    let mut reader = QueueReader::new(name, layout()).max_age(Some(Duration::from_secs(1)));
    let Some(QueueEvent::Discarded { count, reason }) = event(&mut reader) else {
        panic!("nothing was discarded");
    };
    assert_eq!(count, 2);
    assert!(reason.to_string().contains("of unknown age"), "{reason}");
    writer.send(&joints(3)).unwrap();
    assert_eq!(number(&mut reader), Ok(3));
}

/// Messages that waited while the reader was stopped are of unknown age; rare messages that arrive while it looks are new.
#[test]
fn with_an_age_limit_nothing_is_read_that_waited_during_a_standstill_of_the_reader() {
    let name = name("standstill");
    let limit = Duration::from_millis(800);
    let mut reader = QueueReader::new(name.clone(), layout()).max_age(Some(limit));
    let Some(mut peer) = Obedient::start(&name) else {
        return;
    };
    silence(&mut reader, Duration::from_millis(100));
    peer.does("offer");
    peer.does("write 1");
    assert_eq!(number(&mut reader), Ok(1));
    silence(&mut reader, 2 * limit);
    peer.does("write 2");
    assert_eq!(number(&mut reader), Ok(2));
    // two messages before the standstill, of which one has been read, and one during it
    peer.does("write 3");
    peer.does("write 4");
    assert_eq!(number(&mut reader), Ok(3));
    peer.does("write 5");
    std::thread::sleep(2 * limit);
    for _ in [4, 5] {
        let discarded = number(&mut reader).unwrap_err();
        assert!(discarded.contains("the limit is 800ms"), "{discarded}");
    }
    peer.does("write 6");
    assert_eq!(number(&mut reader), Ok(6));
    // the queue is replaced during another standstill
    peer.does("unlink");
    drop(peer);
    let mut peer = Obedient::start(&name).unwrap();
    peer.does("offer");
    peer.does("write 7");
    std::thread::sleep(2 * limit);
    let discarded = number(&mut reader).unwrap_err();
    assert!(discarded.contains("the limit is 800ms"), "{discarded}");
    peer.does("write 8");
    assert_eq!(number(&mut reader), Ok(8));
    peer.does("unlink");
}

#[test]
fn a_queue_that_does_not_appear_is_reported_once() {
    let mut reader = QueueReader::new(name("never"), layout());
    let begun = Instant::now();
    let mut waiting = 0;
    while begun.elapsed() < Duration::from_millis(5600) {
        let event = reader.next(Duration::from_millis(50));
        assert!(event.is_none() || event == Some(QueueEvent::Waiting));
        waiting += usize::from(event.is_some());
    }
    assert_eq!(waiting, 1);
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
    let mut reader = QueueReader::new(name.clone(), layout());
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

/// Names the queue that this program, started again by a test, opens at both ends.
const HELD: &str = "ASMOTION_TEST_HELD_QUEUE";

/// The other process of [`a_second_process_gets_neither_end_of_a_queue`]; without a queue in the environment it does nothing.
#[test]
fn another_process_holds_a_queue() {
    let Ok(held) = std::env::var(HELD) else {
        return;
    };
    let held = QueueName::new(&held).unwrap();
    let _writer = writer(&held, 3, FullQueuePolicy::Oldest);
    let _reader = QueueReader::new(held, layout()).claimed().unwrap();
    eprintln!("holds");
    // until it is killed
    std::thread::sleep(Duration::from_secs(60));
}

#[test]
fn a_second_process_gets_neither_end_of_a_queue() {
    let name = name("held");
    let mut other = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "another_process_holds_a_queue", "--nocapture"])
        .env(HELD, name.as_str())
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(other.stderr.take().unwrap()).lines();
    assert!(said.any(|line| line.unwrap() == "holds"));
    let room = QueueCapacity {
        messages: 3,
        size: SIZE,
    };
    let write = || QueueWriter::open(name.clone(), layout(), room, FullQueuePolicy::Oldest);
    let read = || QueueReader::new(name.clone(), layout()).claimed();
    for (refused, does) in [
        (write().err(), "another process writes to mqueue:/asmotion-"),
        (read().err(), "another process reads from mqueue:/asmotion-"),
    ] {
        let refused = refused.expect("the other process has it").to_string();
        assert!(refused.starts_with(does), "{refused}");
    }
    // kill -9 leaves no claim behind
    other.kill().unwrap();
    other.wait().unwrap();
    let (first, reader) = (write().unwrap(), read().unwrap());
    // a new version of a system opens a queue before the old one closes it
    let second = write().unwrap();
    drop((first, second, reader, read().unwrap()));
}
