//! O4 to O6, O10: ports and the guarantees of their connections.

use std::sync::Arc;

use asmotion_component::{Activity, Lock, Policy, Span};
use asmotion_runtime::{Run, System};

use super::support::{Bench, Seen, looker, reader, taken, writer};
use crate::common::{Twist, Words, behaviour, counter};

#[test]
fn o4_an_event_port_makes_its_component_cycle_and_a_silent_one_does_not() {
    let seen = Seen::default();
    let ready = Seen::default();
    for (policy, cycles) in [(Policy::data(), 2), (Policy::data().silent(), 1)] {
        let mut system = System::new();
        system.add("A", Activity::manual(), writer(&ready)).unwrap();
        system.add("X", Activity::event(), reader(&seen)).unwrap();
        system.connect("A.n", "X.n", policy).unwrap();
        let mut run = system.simulate();
        run.run_for(1.ms());
        ready.lock().unwrap().push(1);
        run.trigger("A").unwrap();
        run.run_for(1.s());
        // one cycle because of the start
        assert_eq!(run.cycles("X"), cycles);
    }
}

#[test]
fn o5_every_reader_of_the_newest_sample_has_its_own_no_old_and_new_data() {
    let ready = Seen::default();
    let seen: [Seen<String>; 2] = Default::default();
    for lock in [Lock::LockFree, Lock::Locked] {
        let mut system = System::new();
        system.add("A", Activity::manual(), writer(&ready)).unwrap();
        for (name, seen) in ["X", "Y"].iter().zip(&seen) {
            system.add(name, Activity::manual(), looker(seen)).unwrap();
            let policy = Policy::data().lock(lock);
            system.connect("A.n", &format!("{name}.n"), policy).unwrap();
        }
        let mut run = system.simulate();
        let mut cycle = |who: &[&str]| {
            for who in who {
                run.trigger(who).unwrap();
                run.run_for(1.ms());
            }
        };
        cycle(&["X"]);
        ready.lock().unwrap().extend([1, 2]);
        cycle(&["A", "X", "X", "Y"]);
        ready.lock().unwrap().push(3);
        cycle(&["A", "Y", "Y", "X"]);
        assert_eq!(taken(&seen[0]), ["no data", "new 2", "old 2", "new 3"]);
        assert_eq!(taken(&seen[1]), ["new 2", "new 3", "old 3"]);
    }
}

#[test]
fn o6_of_so_many_and_some_more_the_right_ones_survive() {
    for lock in [Lock::LockFree, Lock::Locked] {
        for (policy, kept) in [
            (Policy::buffer(4), [1, 2, 3, 4]),
            (Policy::circular(4), [4, 5, 6, 7]),
        ] {
            let mut hands = Bench::connected(&["A X"], &policy.lock(lock)).simulate();
            hands.write("A", 1..=7);
            assert_eq!(hands.read("X"), kept);
        }
    }
}

#[test]
fn o6_what_several_write_comes_in_the_order_in_which_it_was_written() {
    let mut hands = Bench::connected(&["A X", "B X"], &Policy::buffer(8)).simulate();
    hands.write("A", [1]);
    hands.write("B", [2, 3]);
    hands.write("A", [4]);
    assert_eq!(hands.read("X"), [1, 2, 3, 4]);
}

#[test]
fn o10_a_remote_reader_that_sleeps_costs_a_local_one_nothing() {
    let seen = Seen::default();
    let mut system = System::new();
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    system
        .add("Local", Activity::periodic(50.ms()), reader(&seen))
        .unwrap();
    system
        .connect("Counter.n", "Local.n", Policy::buffer(8))
        .unwrap();
    let mut run = system.simulate();
    let mut remote = run.reader("Counter.n", Policy::buffer(4)).unwrap();
    run.run_for(1.s());
    assert_eq!(taken(&seen), (1..=101).collect::<Vec<_>>());
    let read: Vec<i64> = remote
        .all()
        .iter()
        .map(|n: &crate::common::Number| n.n)
        .collect();
    assert_eq!((read.as_slice(), remote.dropped()), (&[1, 2, 3, 4][..], 97));
}

#[test]
fn o8_a_reader_that_pulls_converts_for_itself_and_one_that_cannot_read_is_told() {
    // one typed, the other by name: the connection converts
    let said: Seen<f64> = Seen::default();
    let mut system = System::new();
    let by_name = behaviour(|interface| {
        let out = interface.output_of(
            "twist",
            asmotion_datum::Schema::opaque("test/Twist".to_owned()),
            "a record",
        );
        move |cycle| {
            let good = asmotion_datum::Datum::of(&Twist {
                linear: 0.5,
                angular: 0.0,
            })?;
            cycle.write(out, good);
            cycle.write(out, asmotion_datum::Datum::Text("no twist".into()));
            Ok(())
        }
    });
    let keep = Arc::clone(&said);
    let by_type = behaviour(move |interface| {
        let input = interface.input::<Twist>("twist", "a command");
        move |cycle| {
            let all = cycle.all(input).iter().map(|twist| twist.linear);
            keep.lock().unwrap().extend(all);
            Ok(())
        }
    });
    let log = asmotion_runtime::Log::new();
    system.observe(log.clone());
    system.add("A", Activity::manual(), by_name).unwrap();
    system.add("X", Activity::manual(), by_type).unwrap();
    let policy = Policy::buffer(8).pull();
    system.connect("A.twist", "X.twist", policy).unwrap();
    let mut run = system.simulate();
    run.trigger("A").unwrap();
    run.run_for(1.ms());
    assert_eq!(log.lines_with("dropped"), [""; 0], "nobody has looked yet");
    run.trigger("X").unwrap();
    run.run_for(1.ms());
    assert_eq!(taken(&said), [0.5]);
    assert_eq!(log.lines_with("dropped").len(), 1);
}

#[test]
fn o8_a_large_sample_goes_by_pointer_to_those_who_take_one() {
    let written: Arc<Words> = Arc::new(Words {
        words: "large ".repeat(1 << 16),
    });
    let pointers: Seen<Arc<Words>> = Seen::default();
    let copies: Seen<Words> = Seen::default();
    let mut system = System::new();
    let ready = Arc::clone(&written);
    let writing = behaviour(move |interface| {
        let out = interface.output::<Arc<Words>>("words", "many");
        move |cycle| {
            cycle.write(out, Arc::clone(&ready));
            Ok(())
        }
    });
    system.add("A", Activity::manual(), writing).unwrap();
    for (name, pull) in [("X", false), ("Y", true)] {
        let keep = Arc::clone(&pointers);
        let pointing = behaviour(move |interface| {
            let input = interface.input::<Arc<Words>>("words", "many");
            move |cycle| {
                keep.lock().unwrap().extend_from_slice(cycle.all(input));
                Ok(())
            }
        });
        system.add(name, Activity::event(), pointing).unwrap();
        let policy = if pull {
            Policy::data().pull()
        } else {
            Policy::data()
        };
        system
            .connect("A.words", &format!("{name}.words"), policy)
            .unwrap();
    }
    let keep = Arc::clone(&copies);
    let copying = behaviour(move |interface| {
        let input = interface.input::<Words>("words", "a copy");
        move |cycle| {
            keep.lock().unwrap().extend_from_slice(cycle.all(input));
            Ok(())
        }
    });
    system.add("Z", Activity::event(), copying).unwrap();
    system
        .connect("A.words", "Z.words", Policy::data())
        .unwrap();
    let mut run = system.simulate();
    run.run_for(1.ms());
    run.trigger("A").unwrap();
    run.run_for(1.ms());
    let pointers = taken(&pointers);
    assert_eq!(pointers.len(), 2);
    assert!(
        pointers
            .iter()
            .all(|pointer| Arc::ptr_eq(pointer, &written))
    );
    assert_eq!(taken(&copies), [Words::clone(&written)]);
}
