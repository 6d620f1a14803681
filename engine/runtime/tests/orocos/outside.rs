//! J9 to J14: outside programs write and read through connections of their own, as with JOrocos.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_component::{Activity, Lock, Policy, Span, State, Time};
use asmotion_runtime::{BuildError, Run, RunError, System, WriteError};

use super::support::{Seen, looker, reader, shown, taken};
use crate::common::{Number, Twist, behaviour, counter, in_real_time, number};

fn counting(period: Duration) -> System {
    let mut system = System::new();
    let activity = Activity::periodic(period);
    system.add("Counter", activity, counter()).unwrap();
    system
}

#[test]
fn j9_a_writer_of_outsider_has_a_connection_with_its_size() {
    let seen = Seen::default();
    let mut system = System::new();
    system.add("X", Activity::event(), reader(&seen)).unwrap();
    let mut run = system.simulate();
    run.run_for(1.ms());
    let mut writer = run.writer("X.n", Policy::buffer(4)).unwrap();
    for n in 1..=7 {
        writer.write(number(n)).unwrap();
    }
    assert_eq!(writer.dropped(), 3);
    run.run_for(1.ms());
    assert_eq!(
        taken(&seen),
        [1, 2, 3, 4],
        "and it has triggered the component"
    );
}

#[test]
fn j9_a_data_writer_leaves_the_newest() {
    let seen = Seen::default();
    let mut system = System::new();
    system.add("X", Activity::manual(), looker(&seen)).unwrap();
    let mut run = system.simulate();
    let mut writer = run.writer("X.n", Policy::data()).unwrap();
    let look = |run: &mut asmotion_runtime::Simulation| {
        run.trigger("X").unwrap();
        run.run_for(1.ms());
    };
    look(&mut run);
    writer.write(number(1)).unwrap();
    writer.write(number(2)).unwrap();
    look(&mut run);
    drop(writer);
    look(&mut run);
    assert_eq!(taken(&seen), ["no data", "new 2", "old 2"]);
}

#[test]
fn j9_writers_write_from_threads_of_their_own_into_a_live_system() {
    let seen = Seen::default();
    let mut system = System::new();
    system.add("X", Activity::event(), reader(&seen)).unwrap();
    let mut run = system.live();
    let threads: Vec<_> = (0..3)
        .map(|thread| {
            let mut writer = run.writer("X.n", Policy::buffer(1000)).unwrap();
            std::thread::spawn(move || {
                for n in 0..500 {
                    writer.write(number(thread * 1000 + n)).unwrap();
                }
            })
        })
        .collect();
    for thread in threads {
        thread.join().unwrap();
    }
    // the component reads them as soon as its thread runs, which a busy machine can delay
    for _ in 0..100 {
        run.run_for(100.ms());
        if seen.lock().unwrap().len() == 1500 {
            break;
        }
    }
    run.stop();
    let mut seen = taken(&seen);
    for thread in 0..3 {
        let of_it: Vec<_> = seen.extract_if(.., |n| *n / 1000 == thread).collect();
        assert_eq!(
            of_it,
            (0..500).map(|n| thread * 1000 + n).collect::<Vec<_>>()
        );
    }
}

/// The values that an observer with this period sees of a live counter in at least half a second.
fn polled(policy: Policy, looks: Duration) -> Vec<i64> {
    let mut run = counting(20.ms()).live();
    let seen = Seen::default();
    let keep = Arc::clone(&seen);
    let reader = run.reader("Counter.n", policy).unwrap();
    let polling = reader.every(looks, move |sample: &Number| {
        keep.lock().unwrap().push(sample.n);
    });
    run.run_for(650.ms());
    drop(polling);
    taken(&seen)
}

#[test]
fn j10_who_polls_five_times_too_seldom_sees_one_of_five() {
    in_real_time(|| {
        let seen = polled(Policy::data(), 100.ms());
        assert!((4..=8).contains(&seen.len()), "{seen:?} of 33");
        // a period of half the writer's sees every sample
        let seen = polled(Policy::data(), 10.ms());
        assert!(seen.len() >= 26, "{seen:?} of 33");
    });
}

#[test]
fn j10_by_default_samples_are_pushed() {
    in_real_time(|| {
        let mut run = counting(20.ms()).live();
        let late = Arc::new(Mutex::new(Vec::new()));
        let keep = Arc::clone(&late);
        let reader = run.reader("Counter.n", Policy::buffer(8)).unwrap();
        let begin = Instant::now();
        let subscription = reader.on_new_data(move |sample: &Number| {
            keep.lock().unwrap().push((sample.n, begin.elapsed()));
        });
        run.run_for(400.ms());
        drop(subscription);
        let seen = late.lock().unwrap();
        assert!(seen.len() >= 15, "{seen:?}");
        assert!(
            seen.windows(2).all(|pair| pair[0].0 + 1 == pair[1].0),
            "{seen:?}"
        );
    });
}

#[test]
fn j11_ten_samples_between_two_looks_are_all_there_if_the_buffer_has_sixteen() {
    let mut run = counting(10.ms()).simulate();
    let mut reader = run
        .reader::<Number>("Counter.n", Policy::buffer(16))
        .unwrap();
    let mut expected = 1..;
    // one cycle at zero, then ten between any two reads
    run.run_until(Time::ZERO);
    assert_eq!(reader.all().len(), expected.by_ref().take(1).count());
    for _ in 0..10 {
        run.run_for(100.ms());
        let seen: Vec<i64> = reader.all().iter().map(|sample| sample.n).collect();
        assert_eq!(seen, expected.by_ref().take(10).collect::<Vec<_>>());
    }
    assert_eq!(reader.dropped(), 0);
}

/// Number of this process' threads that read for a subscription to a port.
fn reading_threads(port: &str) -> usize {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let names =
        tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok());
    // Linux keeps 15 characters of a thread's name
    let name: String = format!("reads {port}").chars().take(15).collect();
    names.filter(|found| found.trim_end() == name).count()
}

#[test]
fn j12_to_unsubscribe_really_stops_even_when_nothing_comes() {
    let mut system = System::new();
    // never driven, so it never writes
    system
        .add("Silence", Activity::manual(), counter())
        .unwrap();
    let mut run = system.live();
    for _ in 0..3 {
        let [polls, listens] = [(); 2].map(|()| run.reader("Silence.n", Policy::data()).unwrap());
        let polling = polls.every(3600.s(), |_: &Number| {});
        let listening = listens.on_new_data(|_: &Number| panic!("nothing comes"));
        while reading_threads("Silence.n") < 2 {
            std::thread::sleep(1.ms());
        }
        let begin = Instant::now();
        drop((polling, listening));
        // the kernel lists a thread for a moment after it has ended
        while reading_threads("Silence.n") > 0 {
            assert!(begin.elapsed() < 10.s(), "it does not wait for a look");
            std::thread::sleep(1.ms());
        }
    }
}

#[test]
fn j12_an_observer_that_panics_ends_its_own_subscription_and_nothing_else() {
    let mut run = counting(5.ms()).live();
    let reader = run.reader("Counter.n", Policy::buffer(8)).unwrap();
    let told = Arc::new(AtomicBool::new(false));
    let telling = Arc::clone(&told);
    let subscription = reader.on_new_data(move |_: &Number| {
        telling.store(true, Ordering::Release);
        panic!("on purpose");
    });
    while !told.load(Ordering::Acquire) || reading_threads("Counter.n") > 0 {
        run.run_for(1.ms());
    }
    let before = run.cycles("Counter");
    while run.cycles("Counter") < before + 10 {
        run.run_for(1.ms());
    }
    assert_eq!(run.state("Counter"), Some(State::Running));
    drop(subscription);
}

#[test]
fn j13_each_way_in_which_writing_can_fail_has_its_error() {
    let seen = Seen::default();
    let mut system = counting(10.ms());
    system.add("X", Activity::manual(), reader(&seen)).unwrap();
    let mut run = system.simulate();
    let mut failures = Vec::new();
    let mut note = |error: String| failures.push(error);
    // 1 to 4: no such component, no such port, wrong direction, wrong type.
    for port in ["Xx.n", "X.m", "Counter.n"] {
        let refused = run.writer::<Number>(port, Policy::data());
        note(refused.err().unwrap().to_string());
    }
    let refused = run.writer::<Twist>("X.n", Policy::data());
    note(refused.err().unwrap().to_string());
    // 5: a sample of another type than the port's, whose type is known by name only
    let sample = Arc::new(Twist::default());
    note(
        run.inject_sample(Time::ZERO, "X.n", sample)
            .unwrap_err()
            .to_string(),
    );
    // 6: an input cannot be read
    let refused = run.reader::<Number>("X.n", Policy::data());
    note(refused.err().unwrap().to_string());
    // 7: full
    let mut writer = run.writer("X.n", Policy::buffer(1).mandatory()).unwrap();
    writer.write(number(1)).unwrap();
    note(writer.write(number(2)).unwrap_err().to_string());
    // 8: gone
    drop(run);
    note(writer.write(number(3)).unwrap_err().to_string());
    assert_eq!(
        failures,
        [
            "unknown component `Xx`",
            "unknown input `X.m`",
            "`Counter.n` is an output, not an input",
            "`the writer` and `X.n` differ: test/Twist here, test/Number there",
            "`X.n` takes test/Number: unknown field `linear`, expected `n`",
            "`X.n` is an input, not an output",
            "`X.n` is full",
            "`X.n` is closed: its system has ended",
        ]
    );
}

#[test]
fn j13_errors_are_typed() {
    let mut run = counting(10.ms()).live();
    let direction = run.writer::<Number>("Counter.n", Policy::data());
    assert!(matches!(
        direction.err(),
        Some(BuildError::Direction { .. })
    ));
    let unknown = run.inject(Time::ZERO, "Counter.m", number(1));
    assert!(matches!(
        unknown,
        Err(RunError::Unknown { kind: "input", .. })
    ));
    let busy = run.set_properties("Nobody", &[]);
    assert!(matches!(
        busy,
        Err(RunError::Unknown {
            kind: "component",
            ..
        })
    ));
    let quiet = behaviour(|interface| {
        interface.input_of(
            "any",
            asmotion_datum::Schema::opaque(String::new()),
            "whatever comes",
        );
        |_| Ok(())
    });
    let mut system = System::new();
    system.add("Any", Activity::manual(), quiet).unwrap();
    let mut run = system.live();
    let mut writer = run
        .writer("Any.any", Policy::buffer(1).mandatory())
        .unwrap();
    assert_eq!(writer.write(number(1)), Ok(()));
    let full = writer.write(number(2));
    assert_eq!(
        full,
        Err(WriteError::Full {
            port: "Any.any".to_owned()
        })
    );
}

#[test]
fn j14_what_is_read_has_a_status_by_every_policy() {
    for lock in [Lock::LockFree, Lock::Locked, Lock::Unsync] {
        // outside there is another thread, so `unsync` is replaced by lock-free
        for policy in [Policy::data(), Policy::buffer(4), Policy::circular(4)] {
            let mut run = counting(10.ms()).simulate();
            let mut reader = run.reader("Counter.n", policy.lock(lock)).unwrap();
            let mut seen = vec![shown(reader.read())];
            run.run_until(Time::ZERO);
            seen.push(shown(reader.read()));
            seen.push(shown(reader.read()));
            run.run_for(25.ms());
            seen.push(shown(reader.read()));
            assert_eq!(seen, ["no data", "new 1", "old 1", "new 3"]);
        }
    }
}
