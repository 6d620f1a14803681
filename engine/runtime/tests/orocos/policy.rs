//! The connection policy: O7, O8.

use asmotion_component::{Activity, BufferKind, Fault, Lock, Policy, Sharing, Span, State};
use asmotion_runtime::{Run, System};

use super::support::{Bench, Seen, reader, taken};
use crate::common::burst;

#[test]
fn o8_the_defaults_are_those_of_the_book() {
    let policy = Policy::data();
    assert_eq!(policy, Policy::default());
    assert_eq!(
        policy,
        Policy {
            kind: BufferKind::Data,
            lock: Lock::LockFree,
            sharing: Sharing::PerConnection,
            queue: String::new(),
            init: false,
            pull: false,
            max_threads: None,
            max_age: None,
            on_stale: asmotion_component::OnStale::Hold,
            mandatory: false,
            trigger: true,
        }
    );
}

#[test]
fn o7_unsync_across_threads_is_refused_when_connecting() {
    let policy = Policy::buffer(4).lock(Lock::Unsync);
    let mut bench = Bench::new();
    let refused = bench.system.connect("A.n", "X.n", policy.clone());
    assert_eq!(
        refused.unwrap_err().to_string(),
        "`A.n` and `X.n` run in two threads, but their connection is `unsync`: make one the slave of the other, or \
         use a lock-free connection"
    );
    let mut run = bench.system.simulate();
    assert!(
        run.connect("A.n", "X.n", policy).is_err(),
        "while it runs, too"
    );
}

#[test]
fn o7_unsync_within_a_thread_carries_samples() {
    let mut bench = Bench::new();
    bench.system.add_slave("X", "A").unwrap();
    let policy = Policy::buffer(4).lock(Lock::Unsync);
    bench.system.connect("A.n", "X.n", policy).unwrap();
    let mut hands = bench.simulate();
    hands.write("A", 1..=6);
    assert_eq!(hands.read("X"), [1, 2, 3, 4]);
}

#[test]
fn o8_connections_into_a_port_that_share_its_queue_fill_it_together() {
    let each = Policy::buffer(3);
    let together = Policy::buffer(3).sharing(Sharing::PerInput);
    for (policy, expected) in [(each, vec![1, 2, 3, 11, 12, 13]), (together, vec![1, 2, 3])] {
        let mut hands = Bench::connected(&["A X", "B X"], &policy).simulate();
        hands.write("A", 1..=4);
        hands.write("B", 11..=14);
        assert_eq!(hands.read("X"), expected, "{policy:?}");
    }
}

#[test]
fn o8_readers_that_share_a_queue_take_turns() {
    let jobs = Policy::buffer(8);
    for policy in [
        jobs.clone().sharing(Sharing::PerOutput),
        jobs.shared("jobs"),
    ] {
        let mut hands = Bench::connected(&["A X", "A Y"], &policy).simulate();
        hands.write("A", 1..=3);
        assert_eq!((hands.read("Y"), hands.read("X")), (vec![1, 2, 3], vec![]));
        hands.write("A", 4..=5);
        assert_eq!((hands.read("X"), hands.read("Y")), (vec![4, 5], vec![]));
    }
}

#[test]
fn o8_all_who_share_one_queue_are_several_writers_and_several_readers() {
    for lock in [Lock::LockFree, Lock::Locked] {
        let policy = Policy::circular(3).shared("all").lock(lock);
        let ends = ["A X", "A Y", "B X", "B Y"];
        let mut hands = Bench::connected(&ends, &policy).simulate();
        hands.write("A", 1..=2);
        hands.write("B", 3..=4);
        assert_eq!((hands.read("X"), hands.read("Y")), (vec![2, 3, 4], vec![]));
    }
}

#[test]
fn o8_a_queue_in_common_has_one_policy() {
    let mut bench = Bench::new();
    let policy = Policy::buffer(3).sharing(Sharing::PerInput);
    bench.system.connect("A.n", "X.n", policy).unwrap();
    let other = Policy::circular(3).sharing(Sharing::PerInput);
    let refused = bench.system.connect("B.n", "X.n", other);
    assert_eq!(
        refused.unwrap_err().to_string(),
        "`B.n` and `X.n` cannot share a queue with the others, which have a queue of another policy"
    );
}

#[test]
fn o8_more_threads_than_allowed_are_refused() {
    let mut bench = Bench::new();
    let policy = Policy::buffer(3).sharing(Sharing::PerInput).max_threads(2);
    bench.system.connect("A.n", "X.n", policy.clone()).unwrap();
    let refused = bench.system.connect("B.n", "X.n", policy.clone());
    assert_eq!(
        refused.unwrap_err().to_string(),
        "3 threads use the queue of `X.n`, which allows 2"
    );
    // in the master's thread it is no third thread
    let mut bench = Bench::new();
    bench.system.add_slave("B", "A").unwrap();
    bench.system.connect("A.n", "X.n", policy.clone()).unwrap();
    bench.system.connect("B.n", "X.n", policy).unwrap();
}

#[test]
fn o8_mandatory_and_full_is_a_failure_of_the_writer_otherwise_it_is_a_counted_drop() {
    for lock in [Lock::LockFree, Lock::Locked] {
        for (policy, state) in [
            (Policy::buffer(2), State::Running),
            (Policy::buffer(2).mandatory(), State::RunTimeError),
            // the newest always fits: an older one is dropped
            (Policy::circular(2).mandatory(), State::Running),
        ] {
            let log = asmotion_runtime::Log::new();
            let mut bench = Bench::connected(&["A X"], &policy.clone().lock(lock));
            bench.system.observe(log.clone());
            let mut hands = bench.simulate();
            hands.write("A", 1..=3);
            assert_eq!(hands.run.state("A"), Some(state), "{policy:?}");
            assert_eq!(log.lines_with("A.n -> X.n: 1 dropped").len(), 1);
            let fault = (state == State::RunTimeError).then(|| Fault::NotDelivered {
                port: "n".to_owned(),
                to: "X.n".to_owned(),
            });
            assert_eq!(hands.run.fault("A"), fault);
        }
    }
}

#[test]
fn o9_a_locked_connection_loses_and_reorders_nothing_between_two_threads() {
    for lock in [Lock::LockFree, Lock::Locked] {
        let seen = Seen::default();
        let mut system = System::new();
        system
            .add("Counter", Activity::periodic(1.ms()), burst(50))
            .unwrap();
        system
            .add("Reader", Activity::event(), reader(&seen))
            .unwrap();
        let policy = Policy::buffer(100_000).lock(lock);
        system.connect("Counter.n", "Reader.n", policy).unwrap();
        let mut run = system.live();
        let limit = run.now() + 20.s();
        while seen.lock().unwrap().len() < 5_000 {
            assert!(run.now() < limit, "{lock:?}: nothing arrives");
            run.run_for(10.ms());
        }
        run.stop();
        let seen = taken(&seen);
        assert!(
            seen.iter().zip(1..).all(|(n, expected)| *n == expected),
            "{lock:?}"
        );
    }
}
