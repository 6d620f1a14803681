//! The cycle: freeze, compute, commit all or nothing.

use std::sync::{Arc, Mutex};

use crate::common::{Number, behaviour, burst, counter, number, run_until};
use asmotion_component::{
    Activity, Component, Cycle, Fault, Flow, Interface, OnDeadline, OnException, Out, Policy, Span,
    State, Time,
};
use asmotion_datum::{Datum, Schema};
use asmotion_runtime::{Event, Log, Observer, ReportInterest, Run, System};

/// The values that a reader's cycles see.
type Seen<T> = Arc<Mutex<Vec<T>>>;

#[test]
fn t1_a_component_that_nobody_calls_publishes() {
    let mut system = System::new();
    let log = Log::new();
    system.observe(log.clone());
    system
        .add("Counter", Activity::periodic(100.ms()), counter())
        .unwrap();
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 950.ms());
    assert_eq!(log.samples::<Number>("Counter.n").len(), 10);
}

#[test]
fn t2_a_cycle_is_driven_by_hand_without_threads_and_brokers() {
    let mut system = System::new();
    let log = Log::new();
    system.observe(log.clone());
    system
        .add("Counter", Activity::manual(), counter())
        .unwrap();
    let mut run = system.simulate();
    run.run_for(1.s());
    assert_eq!(run.cycles("Counter"), 0);
    run.trigger("Counter").unwrap();
    assert_eq!(run.step(), Some(Time::ZERO + 1.s()));
    assert_eq!(log.samples("Counter.n"), [(Time::ZERO + 1.s(), number(1))]);
}

#[test]
fn t9_t20_a_component_runs_with_connections_in_the_process_only() {
    let seen: Seen<i64> = Seen::default();
    let mut system = System::new();
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    system
        .add("Reader", Activity::event(), reader(&seen))
        .unwrap();
    system
        .connect("Counter.n", "Reader.n", Policy::data())
        .unwrap();
    system.simulate().run_until(Time::ZERO + 25.ms());
    assert_eq!(*seen.lock().unwrap(), [1, 2, 3]);
}

fn reader(
    seen: &Seen<i64>,
) -> impl FnOnce(&mut asmotion_component::Interface) -> Box<dyn asmotion_component::Component> {
    let seen = Arc::clone(seen);
    behaviour(move |interface| {
        let input = interface.input::<Number>("n", "a count");
        move |cycle| {
            seen.lock()
                .unwrap()
                .extend(cycle.all(input).iter().map(|sample| sample.n));
            Ok(())
        }
    })
}

#[test]
fn t11_nothing_leaves_a_failed_cycle() {
    for panics in [false, true] {
        let seen: Seen<i64> = Seen::default();
        let log = Log::new();
        let mut system = System::new();
        system.observe(log.clone());
        let failing = behaviour(move |interface| {
            let out = interface.output::<Number>("n", "written, never sent");
            let called = interface.require::<crate::common::Double>("sums", "called, never sent");
            move |cycle| {
                cycle.write(out, number(7));
                cycle.call(called, number(7));
                // for observers, which no component is
                cycle.report("said", Datum::Null);
                assert!(!panics, "on purpose");
                Err(Fault::new("on purpose"))
            }
        });
        system
            .add("Failing", Activity::periodic(10.ms()), failing)
            .unwrap();
        system
            .add("Reader", Activity::event(), reader(&seen))
            .unwrap();
        system
            .add("Doubler", Activity::event(), crate::common::doubler())
            .unwrap();
        system
            .connect("Failing.n", "Reader.n", Policy::buffer(8))
            .unwrap();
        system
            .wire(
                "Failing.sums",
                "Doubler.sums",
                asmotion_component::Wire::default(),
            )
            .unwrap();
        let mut run = system.simulate();
        run.run_for(1.s());

        assert_eq!(run.state("Failing"), Some(State::Exception));
        assert_eq!(run.cycles("Failing"), 1);
        assert_eq!(*seen.lock().unwrap(), [0; 0]);
        assert_eq!(log.samples::<Number>("Failing.n"), []);
        assert_eq!(log.lines_with("said").len(), 1);
        assert_eq!(log.lines_with("call"), [""; 0]);
        let expected = if panics {
            "panicked: on purpose"
        } else {
            "on purpose"
        };
        assert_eq!(run.fault("Failing").unwrap().to_string(), expected);
    }
}

#[test]
fn a_failing_component_leaves_the_others_running() {
    let mut system = System::new();
    system
        .add(
            "Failing",
            Activity::periodic(10.ms()),
            behaviour(|_| |_| panic!("on purpose")),
        )
        .unwrap();
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    let mut run = system.simulate();
    run.run_for(1.s());
    assert_eq!(run.cycles("Counter"), 101);
    assert!(run.is_running("Counter") && !run.is_running("Failing"));
}

#[test]
fn t12_receive_last_gives_the_newest_then_the_old() {
    let flows: Seen<Flow<i64>> = Seen::default();
    let seen = Arc::clone(&flows);
    let mut system = System::new();
    system.add("Burst", Activity::manual(), burst(100)).unwrap();
    let reading = behaviour(move |interface| {
        let input = interface.input::<Number>("n", "a count");
        move |cycle| {
            seen.lock().unwrap().push(match cycle.read(input) {
                Flow::NoData => Flow::NoData,
                Flow::OldData(sample) => Flow::OldData(sample.n),
                Flow::NewData(sample) => Flow::NewData(sample.n),
            });
            Ok(())
        }
    });
    system
        .add("Reader", Activity::periodic(10.ms()), reading)
        .unwrap();
    system
        .connect("Burst.n", "Reader.n", Policy::data())
        .unwrap();
    let mut run = system.simulate();
    run.run_for(1.ms());
    run.trigger("Burst").unwrap();
    run.run_for(20.ms());
    assert_eq!(
        *flows.lock().unwrap(),
        [Flow::NoData, Flow::NewData(100), Flow::OldData(100)]
    );
}

#[test]
fn t13_receive_all_is_bounded_and_the_dropped_are_counted() {
    let seen: Seen<i64> = Seen::default();
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system.add("Burst", Activity::manual(), burst(100)).unwrap();
    system
        .add("Reader", Activity::manual(), reader(&seen))
        .unwrap();
    system
        .connect("Burst.n", "Reader.n", Policy::circular(64))
        .unwrap();
    let mut run = system.simulate();
    run.trigger("Burst").unwrap();
    run.trigger("Reader").unwrap();
    run.run_for(1.ms());
    assert_eq!(*seen.lock().unwrap(), (37..=100).collect::<Vec<_>>());
    assert_eq!(
        log.lines_with("dropped").last().unwrap(),
        "0 s Burst.n -> Reader.n: 36 dropped"
    );
}

#[test]
fn t14_sequence_numbers_have_no_gaps() {
    let mut numbers = Vec::new();
    let seen = Arc::new(Mutex::new(Vec::new()));
    let log = Arc::clone(&seen);
    let mut system = System::new();
    system.observe(move |_: Time, event: &asmotion_runtime::Event<'_>| {
        if let asmotion_runtime::Event::Published { sequence, .. } = event {
            log.lock().unwrap().push(*sequence);
        }
    });
    system
        .add("Burst", Activity::periodic(10.ms()), burst(3))
        .unwrap();
    system.simulate().run_for(100.ms());
    numbers.append(&mut seen.lock().unwrap());
    assert_eq!(numbers, (1..=33).collect::<Vec<_>>());
}

/// A component that notes each time whether its reports of the kind `mine` are used.
fn reporting() -> (System, Seen<bool>) {
    let seen: Seen<bool> = Seen::default();
    let noted = Arc::clone(&seen);
    let mut system = System::new();
    let noting = behaviour(move |_| {
        move |cycle| {
            noted.lock().unwrap().push(cycle.wants_report("mine"));
            Ok(())
        }
    });
    system
        .add("Noting", Activity::periodic(10.ms()), noting)
        .unwrap();
    (system, seen)
}

#[test]
fn a_component_knows_whether_anybody_receives_its_reports() {
    let (system, seen) = reporting();
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 15.ms());
    run.run_until_event(Time::ZERO + 25.ms(), &mut |_, _| false);
    run.run_until(Time::ZERO + 35.ms());
    run.observe(|_: Time, _: &Event<'_>| {});
    run.run_until(Time::ZERO + 45.ms());
    assert_eq!(*seen.lock().unwrap(), [false, false, true, false, true]);
    let (mut system, seen) = reporting();
    system.observe(|_: Time, _: &Event<'_>| {});
    system.simulate().run_until(Time::ZERO + 15.ms());
    assert_eq!(*seen.lock().unwrap(), [true, true]);
}

const USES: &[(ReportInterest, bool)] = &[
    (ReportInterest::NONE, false),
    (ReportInterest::Only(&["other"]), false),
    (ReportInterest::Except(&["mine", "other"]), false),
    (ReportInterest::Only(&["other", "mine"]), true),
    (ReportInterest::Except(&["other"]), true),
    (ReportInterest::All, true),
];

#[test]
fn a_component_knows_whether_anybody_uses_reports_of_a_kind() {
    for (reports, is_used) in USES {
        let (system, seen) = reporting();
        let mut run = system.simulate();
        run.run_until(Time::ZERO + 5.ms());
        run.observe((|_: Time, _: &Event<'_>| {}).using(*reports));
        run.run_until(Time::ZERO + 15.ms());
        assert_eq!(*seen.lock().unwrap(), [false, *is_used], "{reports:?}");
        // an observer that joins a run gets its reports, whatever others use
        run.observe((|_: Time, _: &Event<'_>| {}).using(ReportInterest::Only(&["mine"])));
        run.run_until(Time::ZERO + 25.ms());
        assert_eq!(seen.lock().unwrap().last(), Some(&true), "{reports:?}");
        // and one of a system from the beginning
        let (mut system, seen) = reporting();
        system.observe((|_: Time, _: &Event<'_>| {}).using(*reports));
        system.simulate().run_until(Time::ZERO + 5.ms());
        assert_eq!(*seen.lock().unwrap(), [*is_used], "{reports:?}");
    }
}

#[test]
fn a_component_knows_which_reports_a_predicate_uses() {
    for (reports, is_used) in USES {
        let (system, seen) = reporting();
        let mut run = system.simulate();
        run.run_until_event_among(Time::ZERO + 15.ms(), *reports, &mut |_, _| false);
        assert_eq!(*seen.lock().unwrap(), [*is_used; 2], "{reports:?}");
    }
}

#[test]
fn in_real_time_a_component_knows_whether_anybody_uses_reports_of_a_kind() {
    let (mut system, seen) = reporting();
    let unused = ReportInterest::Except(&["mine"]);
    system.observe((|_: Time, _: &Event<'_>| {}).using(unused));
    let mut run = system.live();
    let is_long = || seen.lock().unwrap().len() > 3;
    while !is_long() {
        let until = run.now() + 10.ms();
        run.run_until_event_among(until, unused, &mut |_, _| false);
    }
    assert!(!seen.lock().unwrap().contains(&true));
    run.observe((|_: Time, _: &Event<'_>| {}).using(ReportInterest::Only(&["mine"])));
    run_until(&mut run, |_| seen.lock().unwrap().last() == Some(&true));
    run.stop();
}

#[test]
fn in_real_time_a_component_knows_whether_anybody_receives_its_reports() {
    let (system, seen) = reporting();
    let mut run = system.live();
    run_until(&mut run, |_| !seen.lock().unwrap().is_empty());
    run.observe(|_: Time, _: &Event<'_>| {});
    run_until(&mut run, |_| seen.lock().unwrap().last() == Some(&true));
    run.stop();
    let seen = seen.lock().unwrap();
    let first = seen.iter().position(|it| *it).unwrap();
    assert!(first > 0 && seen[first..].iter().all(|it| *it));
}

#[test]
fn samples_of_several_connections_come_in_the_order_they_were_sent() {
    let seen: Seen<i64> = Seen::default();
    let mut system = System::new();
    let saying = |n: i64| {
        behaviour(move |interface| {
            let out = interface.output::<Number>("n", "always the same");
            move |cycle| {
                cycle.write(out, number(n));
                Ok(())
            }
        })
    };
    system
        .add("One", Activity::periodic(20.ms()), saying(1))
        .unwrap();
    system
        .add("Two", Activity::periodic(20.ms()).delay(10.ms()), saying(2))
        .unwrap();
    let late = Activity::periodic(100.ms()).delay(95.ms());
    system.add("Reader", late, reader(&seen)).unwrap();
    system
        .connect("Two.n", "Reader.n", Policy::buffer(32))
        .unwrap();
    system
        .connect("One.n", "Reader.n", Policy::buffer(32))
        .unwrap();
    system.simulate().run_until(Time::ZERO + 95.ms());
    assert_eq!(*seen.lock().unwrap(), [1, 2, 1, 2, 1, 2, 1, 2, 1, 2]);
}

#[test]
fn inputs_stand_still_during_a_cycle() {
    let mut system = System::new();
    let selfish = behaviour(|interface| {
        let out = interface.output::<Number>("n", "to itself");
        let input = interface.input::<Number>("back", "from itself");
        move |cycle| {
            let before = cycle.read(input).any().copied();
            cycle.write(out, number(before.map_or(1, |sample| sample.n + 1)));
            assert_eq!(cycle.read(input).any().copied(), before);
            Ok(())
        }
    });
    system
        .add("Selfish", Activity::periodic(10.ms()), selfish)
        .unwrap();
    system
        .connect("Selfish.n", "Selfish.back", Policy::data())
        .unwrap();
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.simulate();
    run.run_for(50.ms());
    assert!(run.is_running("Selfish"), "{:?}", run.fault("Selfish"));
    assert_eq!(
        log.samples::<Number>("Selfish.n").last().unwrap().1,
        number(6)
    );
}

#[test]
fn a_handle_of_another_component_is_a_fault_not_a_panic() {
    let stolen: Arc<Mutex<Option<Out<Number>>>> = Arc::default();
    let mut system = System::new();
    let keep = Arc::clone(&stolen);
    let owner = behaviour(move |interface| {
        *keep.lock().unwrap() = Some(interface.output("n", "mine"));
        |_| Ok(())
    });
    let thief = behaviour(move |interface| {
        let own = interface.output::<Number>("n", "its own");
        move |cycle| {
            cycle.write(own, number(1));
            cycle.write(stolen.lock().unwrap().unwrap(), number(2));
            Ok(())
        }
    });
    system.add("Owner", Activity::event(), owner).unwrap();
    system.add("Thief", Activity::event(), thief).unwrap();
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.simulate();
    run.run_for(1.ms());
    assert_eq!(run.state("Thief"), Some(State::Exception));
    assert_eq!(
        run.fault("Thief").unwrap().to_string(),
        "a handle of another component's output was used"
    );
    assert_eq!(log.samples::<Number>("Thief.n"), []);
}

#[test]
fn a_port_known_by_name_only_joins_a_typed_one_both_ways() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    let dynamic = behaviour(|interface| {
        let input = interface.input_of("in", Schema::opaque("test/Number"), "some number");
        let output = interface.output_of("out", Schema::opaque("test/Number"), "ten times as much");
        move |cycle| {
            if let Some(datum) = cycle.read(input).new() {
                let n = datum
                    .get("n")
                    .and_then(|n| n.as_int())
                    .ok_or(Fault::new("no n"))?;
                cycle.write(output, Datum::record([("n", Datum::Int(n * 10))]));
            }
            Ok(())
        }
    });
    system.add("Dynamic", Activity::event(), dynamic).unwrap();
    let seen: Seen<i64> = Seen::default();
    system
        .add("Reader", Activity::event(), reader(&seen))
        .unwrap();
    system
        .connect("Counter.n", "Dynamic.in", Policy::data())
        .unwrap();
    system
        .connect("Dynamic.out", "Reader.n", Policy::data())
        .unwrap();
    system.simulate().run_until(Time::ZERO + 20.ms());
    assert_eq!(*seen.lock().unwrap(), [10, 20, 30]);
}

#[test]
fn a_cycle_that_exceeds_the_deadline_of_its_activity_is_late() {
    for (on_deadline, cycles) in [
        (OnDeadline::Report, 4),
        (OnDeadline::Stop, 2),
        (OnDeadline::Fail, 2),
    ] {
        let mut system = System::new();
        let slow = behaviour(|_| {
            |cycle| {
                // the second cycle and later ones take too long
                cycle.set_duration(if cycle.number() > 1 { 6.ms() } else { 5.ms() });
                Ok(())
            }
        });
        let activity = Activity::periodic(100.ms()).deadline(5.ms(), on_deadline);
        system.add("Slow", activity, slow).unwrap();
        let mut run = system.simulate();
        run.run_until(Time::ZERO + 350.ms());
        assert_eq!(run.cycles("Slow"), cycles, "{on_deadline:?}");
        assert_eq!(run.late("Slow"), cycles - 1, "{on_deadline:?}");
    }
}

#[test]
fn a_cycle_knows_that_it_runs_and_when_its_samples_were_written() {
    type Times = Arc<Mutex<Vec<(bool, Option<Time>)>>>;
    let seen = Times::default();
    let mut system = System::new();
    system
        .add("Counter", Activity::periodic(100.ms()), counter())
        .unwrap();
    let times = Arc::clone(&seen);
    let reader = behaviour(move |interface| {
        let input = interface.input::<Number>("n", "a count");
        move |cycle| {
            let written = cycle.written_at(input);
            times.lock().unwrap().push((cycle.is_running(), written));
            Ok(())
        }
    });
    let activity = Activity::periodic(100.ms()).delay(50.ms());
    system.add("Reader", activity, reader).unwrap();
    system
        .connect("Counter.n", "Reader.n", Policy::data())
        .unwrap();
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 160.ms());
    let expected = [Time::ZERO, Time::ZERO + 100.ms()].map(|time| (true, Some(time)));
    assert_eq!(*seen.lock().unwrap(), expected);
    assert_eq!(run.inspect("Counter").unwrap(), []);
}

/// Fails in each cycle.
fn failing() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|_| |_: &mut Cycle<'_>| Err(Fault::new("the same as before")))
}

#[test]
fn what_stays_wrong_does_not_use_up_all_resets_at_once() {
    for (activity, expected) in [
        (Activity::periodic(30.ms()), ["0 s", "0.03 s", "0.06 s"]),
        (Activity::event(), ["0 s", "0.1 s", "0.2 s"]),
    ] {
        let activity = activity
            .on_exception(OnException::Reset)
            .max_resets(Some(2));
        let log = Log::new();
        let mut system = System::new();
        system.observe(log.clone());
        system.add("Failing", activity.clone(), failing()).unwrap();
        system.simulate().run_for(1.s());
        let faults = log.lines_with("fault");
        for (line, at) in faults.iter().zip(expected) {
            assert!(line.starts_with(at), "{line}, expected at {at}");
        }
        assert_eq!(faults.len(), 3, "{faults:?}");

        let mut system = System::new();
        system.add("Failing", activity, failing()).unwrap();
        let mut run = system.live();
        run.run_for(1.s());
        assert_eq!(run.cycles("Failing"), 3);
    }
}
