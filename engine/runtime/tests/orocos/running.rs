//! Connecting and disconnecting while both ends run: O8, O10.

use asmotion_component::{Activity, Lock, Policy, Span};
use asmotion_runtime::{BuildError, Run, System};

use super::support::{Bench, Seen, looker, reader, taken, writer};
use crate::common::counter;

#[test]
fn o8_a_connection_made_while_both_run_carries_what_is_written_from_then_on() {
    let mut hands = Bench::new().simulate();
    hands.write("A", [1]);
    hands.run.connect("A.n", "X.n", Policy::buffer(8)).unwrap();
    assert_eq!(hands.read("X"), [0; 0]);
    hands.write("A", [2, 3]);
    assert_eq!(hands.read("X"), [2, 3]);
    let twice = hands.run.connect("A.n", "X.n", Policy::data());
    assert_eq!(
        twice.unwrap_err().to_string(),
        "`A.n` is already connected to `X.n`"
    );
}

#[test]
fn o8_with_init_a_new_reader_has_what_was_last_written_before() {
    for policy in [Policy::data(), Policy::buffer(4), Policy::buffer(4).pull()] {
        let mut hands = Bench::new().simulate();
        hands.write("A", [1, 2]);
        hands
            .run
            .connect("A.n", "X.n", policy.clone().init())
            .unwrap();
        hands.run.connect("A.n", "Y.n", policy).unwrap();
        assert_eq!((hands.read("X"), hands.read("Y")), (vec![2], vec![]));
    }
}

#[test]
fn o8_a_connection_that_has_ended_carries_nothing_and_its_last_sample_is_gone() {
    let seen = Seen::default();
    let ready = Seen::default();
    let mut system = System::new();
    system.add("A", Activity::manual(), writer(&ready)).unwrap();
    system.add("X", Activity::manual(), looker(&seen)).unwrap();
    system.connect("A.n", "X.n", Policy::data()).unwrap();
    let mut run = system.simulate();
    let cycle = |run: &mut asmotion_runtime::Simulation| {
        ready.lock().unwrap().push(7);
        for who in ["A", "X"] {
            run.trigger(who).unwrap();
            run.run_for(1.ms());
        }
    };
    cycle(&mut run);
    run.disconnect("A.n", "X.n").unwrap();
    cycle(&mut run);
    run.connect("A.n", "X.n", Policy::data()).unwrap();
    cycle(&mut run);
    assert_eq!(taken(&seen), ["new 7", "no data", "new 7"]);
    run.disconnect("A.n", "X.n").unwrap();
    assert_eq!(
        run.disconnect("A.n", "X.n"),
        Err(BuildError::NotConnected {
            from: "A.n".to_owned(),
            to: "X.n".to_owned(),
        })
    );
}

#[test]
fn o8_a_sample_that_was_read_before_is_gone_with_its_connection_too() {
    let seen = Seen::default();
    let ready = Seen::default();
    let mut system = System::new();
    system.add("A", Activity::manual(), writer(&ready)).unwrap();
    system.add("X", Activity::manual(), looker(&seen)).unwrap();
    system.connect("A.n", "X.n", Policy::data()).unwrap();
    let mut run = system.simulate();
    ready.lock().unwrap().push(7);
    for who in ["A", "X", "X"] {
        run.trigger(who).unwrap();
        run.run_for(1.ms());
    }
    run.disconnect("A.n", "X.n").unwrap();
    run.trigger("X").unwrap();
    run.run_for(1.ms());
    assert_eq!(taken(&seen), ["new 7", "old 7", "no data"]);
}

#[test]
fn o8_one_who_leaves_a_queue_in_common_leaves_the_others_alone() {
    for lock in [Lock::LockFree, Lock::Locked] {
        let policy = Policy::buffer(8).shared("all").lock(lock);
        let ends = ["A X", "A Y", "B X", "B Y"];
        let mut hands = Bench::connected(&ends, &policy).simulate();
        hands.run.disconnect("A.n", "X.n").unwrap();
        hands.run.disconnect("B.n", "X.n").unwrap();
        hands.write("A", [1]);
        hands.write("B", [2]);
        assert_eq!((hands.read("X"), hands.read("Y")), (vec![], vec![1, 2]));
    }
}

#[test]
fn o8_connections_come_and_go_while_real_threads_run() {
    let seen = Seen::default();
    let mut system = System::new();
    system
        .add("Counter", Activity::periodic(1.ms()), counter())
        .unwrap();
    system
        .add("Steady", Activity::periodic(5.ms()), reader(&seen))
        .unwrap();
    let now_and_then = Seen::default();
    system
        .add("Guest", Activity::event(), reader(&now_and_then))
        .unwrap();
    system
        .connect("Counter.n", "Steady.n", Policy::buffer(1000))
        .unwrap();
    let mut run = system.live();
    let mut stays = Vec::new();
    for _ in 0..20 {
        run.connect("Counter.n", "Guest.n", Policy::buffer(100))
            .unwrap();
        run.run_for(20.ms());
        run.disconnect("Counter.n", "Guest.n").unwrap();
        run.run_for(5.ms());
        stays.push(taken(&now_and_then));
    }
    run.stop();
    let seen = taken(&seen);
    assert!(seen.len() > 100);
    assert!(
        seen.iter().zip(1..).all(|(n, expected)| *n == expected),
        "{seen:?}"
    );
    let guests = stays.iter().filter(|stay| !stay.is_empty()).count();
    assert!(guests > 10, "{guests} stays of 20 with samples");
    for stay in stays {
        assert!(
            stay.windows(2).all(|pair| pair[0] + 1 == pair[1]),
            "{stay:?}"
        );
    }
}

#[test]
fn a_type_that_does_not_fit_is_refused_while_running_too() {
    let mut system = System::new();
    system
        .add("Counter", Activity::manual(), counter())
        .unwrap();
    let driver = crate::common::behaviour(|interface| {
        interface.input::<crate::common::Twist>("twist", "commands");
        |_| Ok(())
    });
    system.add("Driver", Activity::manual(), driver).unwrap();
    let mut run = system.live();
    let refused = run.connect("Counter.n", "Driver.twist", Policy::data());
    assert!(matches!(refused, Err(BuildError::TypeMismatch { .. })));
}
