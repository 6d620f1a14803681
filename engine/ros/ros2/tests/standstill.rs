//! A subscription that stands still: what is kept for it, and what it hears when it goes on.

use std::process::Command;
use std::time::{Duration, Instant};

use asmotion_ros2::{Notice, Publisher, Qos};

use crate::peer::{LONG, Peer, domain, named, node, python, text, topic_settings, wait};

/// Set in the process whose memory is measured: other tests do not run in it.
const ALONE: &str = "ASMOTION_STANDSTILL_ALONE";
const LENGTH: usize = 1_000_000;
/// Messages during the standstill: 30 MB.
const COUNT: usize = 30;

/// The number at the beginning of a string that a peer prints in hexadecimal digits.
fn number(line: &str) -> usize {
    // the encapsulation and the length come first
    let digits = line.as_bytes()[16..].chunks(2);
    let number = digits.map_while(|it| {
        let byte = u8::from_str_radix(std::str::from_utf8(it).unwrap(), 16).unwrap();
        char::from(byte).to_digit(10)
    });
    number.fold(0, |all, digit| 10 * all + digit as usize)
}

fn send(publisher: &Publisher, number: usize) {
    let long = "x".repeat(LENGTH);
    publisher.send(&text(&format!("{number} {long}"))).unwrap();
}

/// Memory of this process in MB.
fn memory() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|it| it.starts_with("VmRSS:")).unwrap();
    let kilobytes: usize = line.split_whitespace().nth(1).unwrap().parse().unwrap();
    kilobytes / 1024
}

/// Runs a test of this file alone in a process, which gives large pieces of memory back at once. Returns `false` in that process.
fn is_run_alone(test: &str) -> bool {
    if std::env::var_os(ALONE).is_some() {
        return false;
    }
    let status = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", &format!("standstill::{test}"), "--nocapture"])
        .env(ALONE, "1")
        .env("MALLOC_MMAP_THRESHOLD_", "65536")
        .status();
    assert!(status.unwrap().success());
    true
}

/// Best-effort readers acknowledge nothing, and nothing is kept for them.
#[test]
fn a_best_effort_subscription_costs_little() {
    if is_run_alone("a_best_effort_subscription_costs_little") {
        return;
    }
    let Some(python) = python() else { return };
    let domain = domain();
    let string = named("std_msgs/msg/String");
    let mut settings = topic_settings(domain, "/chatter", &string);
    settings["reliable"] = false.into();
    let peer = Peer::start(&python, "subscribe", &settings);
    peer.expect("ready");
    let node = node("talker", domain);
    let publisher = node.publisher("/chatter", &string, Qos::default()).unwrap();
    assert!(publisher.wait_for_matches(1, LONG));
    let before = memory();
    for sent in 1..=COUNT {
        send(&publisher, sent);
        peer.lines_for(Duration::from_millis(20));
    }
    wait("little memory", || {
        peer.lines_for(Duration::from_millis(20));
        (memory() < before + 15).then_some(())
    });
    assert_eq!(publisher.counts().released, 0);
    assert!(node.take_notices().is_empty());
}

/// The others hear everything; it hears the newest when it goes on. What DDS keeps for it is bounded, before its lease ends.
#[test]
fn a_subscription_that_stands_still_costs_little_and_hears_the_newest_again() {
    if is_run_alone("a_subscription_that_stands_still_costs_little_and_hears_the_newest_again") {
        return;
    }
    let Some(python) = python() else { return };
    let domain = domain();
    let string = named("std_msgs/msg/String");
    let settings = topic_settings(domain, "/chatter", &string);
    let [fast, slow] = [(); 2].map(|()| Peer::start(&python, "subscribe", &settings));
    fast.expect("ready");
    slow.expect("ready");
    let node = node("talker", domain);
    let publisher = node.publisher("/chatter", &string, Qos::default()).unwrap();
    assert!(publisher.wait_for_matches(2, LONG));
    // a peer may match later than this side: both have heard one before it begins
    for peer in [&fast, &slow] {
        wait("the first message", || {
            send(&publisher, 0);
            let heard = peer.lines_for(Duration::from_millis(300));
            (!heard.is_empty()).then_some(())
        });
    }
    while !fast.lines_for(Duration::from_millis(300)).is_empty() {}
    let before = memory();
    slow.signal("STOP");
    let stopped = Instant::now();
    for sent in 1..=COUNT {
        send(&publisher, sent);
        assert_eq!(number(&fast.line()), sent);
    }
    let notice = wait("a notice", || {
        let is_that = |it: &Notice| matches!(it, Notice::Unacknowledged { topic, .. } if topic == "rt/chatter");
        node.take_notices().into_iter().find(is_that)
    });
    let Notice::Unacknowledged { readers, .. } = notice else {
        panic!("{notice:?}");
    };
    assert_eq!(readers.len(), 2);
    assert!(publisher.counts().released > 10, "{:?}", publisher.counts());
    // rustdds gives memory back every six seconds; after ten the lease has ended, and with it all that is kept for the reader
    let is_in_time = stopped.elapsed() < Duration::from_secs(3);
    let mut low = memory();
    while low >= before + 15 && stopped.elapsed() < Duration::from_millis(9500) {
        std::thread::sleep(Duration::from_millis(20));
        low = memory();
    }
    assert!(low < before + 15 || !is_in_time, "{before} MB, {low} MB");
    let is_matched = publisher.matches() == 2;
    slow.signal("CONT");
    let (begun, mut sent) = (Instant::now(), COUNT);
    if !is_matched {
        return;
    }
    loop {
        sent += 1;
        send(&publisher, sent);
        let heard = slow.lines_for(Duration::from_millis(500));
        if heard.last().is_some_and(|it| number(it) == sent) {
            break;
        }
        assert!(begun.elapsed() < LONG, "{:?}", publisher.counts());
    }
}

/// It announces what it has announced before, which RustDDS takes for repeated.
#[test]
fn a_participant_that_returns_after_its_lease_is_noticed() {
    let Some(python) = python() else { return };
    let domain = domain();
    let string = named("std_msgs/msg/String");
    let settings = topic_settings(domain, "/chatter", &string);
    let peer = Peer::start(&python, "subscribe", &settings);
    peer.expect("ready");
    let first = node("talker", domain);
    let publisher = first.publisher("/chatter", &string, Qos::default());
    let publisher = publisher.unwrap();
    assert!(publisher.wait_for_matches(1, LONG));
    let awaited = |what: &str, is_that: fn(&Notice) -> bool| {
        wait(what, || first.take_notices().into_iter().find(is_that))
    };
    peer.signal("STOP");
    awaited("a loss", |it| matches!(it, Notice::Lost { .. }));
    peer.signal("CONT");
    awaited("a return", |it| matches!(it, Notice::Returned { .. }));
    // a node that starts now reaches it
    let second = node("talker_again", domain);
    let publisher = second.publisher("/chatter", &string, Qos::default());
    assert!(publisher.unwrap().wait_for_matches(1, LONG));
}
