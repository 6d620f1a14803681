//! Activities in simulated time: periods, delays, triggers, order, loops, injections.

use std::sync::{Arc, Mutex};

use crate::common::{Number, Twist, behaviour, counter, number};
use asmotion_component::{Activity, Component, Interface, Policy, Span, State, Time, Transition};
use asmotion_datum::Datum;
use asmotion_runtime::{Event, Log, Pace, Run, System};

fn at(ms: u64) -> Time {
    Time::ZERO + ms.ms()
}

/// Passes each number on, incremented.
fn relay() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let input = interface.input::<Number>("in", "a number");
        let output = interface.output::<Number>("out", "the next one");
        move |cycle| {
            if let Some(sample) = cycle.read(input).new().copied() {
                cycle.write(output, number(sample.n + 1));
            }
            Ok(())
        }
    })
}

#[test]
fn t3_scheduling_twice_is_refused_and_gives_one_stream() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    let mut run = system.simulate();
    assert!(run.transition("Counter", Transition::Start).is_err());
    run.run_for(100.ms());
    assert_eq!(run.cycles("Counter"), 11);
}

#[test]
fn t4_t5_unscheduling_stops_and_scheduling_again_goes_on_with_one_stream() {
    let mut system = System::new();
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    let mut run = system.simulate();
    run.run_for(25.ms());
    run.transition("Counter", Transition::Stop).unwrap();
    assert!(!run.is_running("Counter"));
    run.run_for(1.s());
    assert_eq!(run.cycles("Counter"), 3);
    run.transition("Counter", Transition::Start).unwrap();
    run.run_for(25.ms());
    assert!(run.is_running("Counter"));
    assert_eq!(run.cycles("Counter"), 6);
}

#[test]
fn t6_periods_do_not_drift() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("Counter", Activity::periodic(7.ms()), counter())
        .unwrap();
    system.simulate().run_until(at(7000));
    let samples = log.samples::<Number>("Counter.n");
    assert!(
        samples
            .iter()
            .enumerate()
            .all(|(n, (time, _))| *time == at(7 * n as u64))
    );
    assert_eq!(samples.len(), 1001);
}

#[test]
fn t16_a_period_changes_from_the_next_cycle_on_and_zero_means_event_driven() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    let mut run = system.simulate();
    run.run_until(at(20));
    run.set_period("Counter", 50.ms()).unwrap();
    assert_eq!(run.period("Counter"), 50.ms());
    run.run_until(at(130));
    run.set_period("Counter", 0.ms()).unwrap();
    assert_eq!(run.period("Counter"), 0.ms());
    run.run_until(at(300));
    run.trigger("Counter").unwrap();
    run.run_until(at(400));
    let times: Vec<_> = log
        .samples::<Number>("Counter.n")
        .into_iter()
        .map(|(at, _)| at)
        .collect();
    assert_eq!(times, [at(0), at(10), at(20), at(70), at(120), at(300)]);
}

#[test]
fn t16_a_component_changes_its_own_period() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let slowing = behaviour(|interface| {
        let out = interface.output::<Number>("n", "ticks");
        move |cycle| {
            cycle.write(out, number(0));
            if cycle.number() == 3 {
                cycle.set_period(40.ms());
            }
            Ok(())
        }
    });
    system
        .add("Slowing", Activity::periodic(10.ms()), slowing)
        .unwrap();
    let mut run = system.simulate();
    run.run_until(at(110));
    assert_eq!(run.period("Slowing"), 40.ms());
    let times: Vec<_> = log
        .samples::<Number>("Slowing.n")
        .into_iter()
        .map(|(at, _)| at)
        .collect();
    assert_eq!(times, [at(0), at(10), at(20), at(60), at(100)]);
}

#[test]
fn t17_the_first_cycle_is_after_the_delay() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let activity = Activity::periodic(10.ms()).delay(35.ms());
    system.add("Counter", activity, counter()).unwrap();
    system.simulate().run_until(at(50));
    let times: Vec<_> = log
        .samples::<Number>("Counter.n")
        .into_iter()
        .map(|(at, _)| at)
        .collect();
    assert_eq!(times, [at(35), at(45)]);
}

#[test]
fn t18_what_does_not_run_on_startup_exists_and_waits() {
    let mut system = System::new();
    let activity = Activity::periodic(10.ms()).run_on_startup(false);
    system.add("Counter", activity, counter()).unwrap();
    let mut run = system.simulate();
    run.run_for(1.s());
    assert_eq!(run.state("Counter"), Some(State::Stopped));
    assert_eq!(run.cycles("Counter"), 0);
    assert_eq!(run.declaration("Counter").unwrap().outputs[0].name, "n");
}

#[test]
fn o4_an_event_port_triggers_without_a_period_and_a_silent_one_does_not() {
    let mut system = System::new();
    system
        .add(
            "Counter",
            Activity::periodic(10.ms()).delay(5.ms()),
            counter(),
        )
        .unwrap();
    system.add("Triggered", Activity::event(), relay()).unwrap();
    system.add("Silent", Activity::event(), relay()).unwrap();
    system
        .connect("Counter.n", "Triggered.in", Policy::data())
        .unwrap();
    system
        .connect("Counter.n", "Silent.in", Policy::data().silent())
        .unwrap();
    let mut run = system.simulate();
    run.run_until(at(25));
    // one cycle because of the start
    assert_eq!(run.cycles("Triggered"), 1 + 3);
    assert_eq!(run.cycles("Silent"), 1);
}

#[test]
fn at_one_instant_cycles_run_in_declaration_order() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    // declared after its reader, so the trigger follows the reader's own turn
    system.add("Last", Activity::event(), relay()).unwrap();
    system.add("Middle", Activity::event(), relay()).unwrap();
    system
        .add(
            "First",
            Activity::periodic(10.ms()).delay(10.ms()),
            counter(),
        )
        .unwrap();
    system
        .add(
            "Also",
            Activity::periodic(10.ms()).delay(10.ms()),
            counter(),
        )
        .unwrap();
    system
        .connect("First.n", "Middle.in", Policy::data())
        .unwrap();
    system
        .connect("Middle.out", "Last.in", Policy::data())
        .unwrap();
    system.simulate().run_until(at(10));
    assert_eq!(
        log.lines_with("0.01 s"),
        [
            "0.01 s First: cycle 1",
            "0.01 s First.n #1 = {n: 1}",
            "0.01 s Middle: cycle 2",
            "0.01 s Middle.out #1 = {n: 2}",
            "0.01 s Last: cycle 2",
            "0.01 s Last.out #1 = {n: 3}",
            "0.01 s Also: cycle 1",
            "0.01 s Also.n #1 = {n: 1}",
        ]
    );
}

#[test]
fn a_loop_at_one_instant_is_a_fault_that_names_its_components() {
    let mut system = System::new();
    system
        .add("Innocent", Activity::periodic(10.ms()), counter())
        .unwrap();
    system.add("Ping", Activity::event(), relay()).unwrap();
    system.add("Pong", Activity::event(), relay()).unwrap();
    system
        .connect("Ping.out", "Pong.in", Policy::data())
        .unwrap();
    system
        .connect("Pong.out", "Ping.in", Policy::data())
        .unwrap();
    let mut run = system.simulate();
    run.inject(at(15), "Ping.in", number(0)).unwrap();
    run.run_for(1.s());
    assert_eq!(run.state("Ping"), Some(State::Exception));
    assert_eq!(
        run.fault("Ping").unwrap().to_string(),
        "components trigger each other without end at 0.015 s: Ping, Pong"
    );
    assert_eq!(run.state("Pong"), Some(State::Running));
    assert_eq!(run.cycles("Innocent"), 101);
}

#[test]
fn samples_are_injected_at_their_time_before_the_cycles_of_that_time() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("Relay", Activity::periodic(10.ms()), relay())
        .unwrap();
    system
        .subscribe("numbers", "Relay.in", Policy::data())
        .unwrap();
    let mut run = system.simulate();
    run.inject(at(20), "Relay.in", number(1)).unwrap();
    run.publish(at(25), "numbers", Datum::record([("n", Datum::Int(5))]))
        .unwrap();
    run.run_for(1.s());
    assert_eq!(
        log.samples("Relay.out"),
        [(at(20), number(2)), (at(30), number(6))]
    );
    assert_eq!(
        log.lines_with("<-"),
        ["0.02 s Relay.in <- {n: 1}", "0.025 s numbers <- {n: 5}"]
    );

    let wrong = run.inject(at(0), "Relay.in", Twist::default()).unwrap_err();
    assert!(
        wrong
            .to_string()
            .starts_with("`Relay.in` takes test/Number: unknown field"),
        "{wrong}"
    );
    let unknown = run.publish(at(0), "number", number(1)).unwrap_err();
    assert_eq!(
        unknown.to_string(),
        "unknown topic `number`; did you mean `numbers`?"
    );
}

#[test]
fn a_run_goes_on_until_an_event() {
    let mut system = System::new();
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    let mut run = system.simulate();
    let mut third =
        |_: Time, event: &Event<'_>| matches!(event, Event::Published { sequence: 3, .. });
    assert!(run.run_until_event(at(1000), &mut third));
    assert_eq!(run.now(), at(20));
    assert!(!run.run_until_event(at(1000), &mut third));
    assert_eq!(run.now(), at(1000));
}

#[test]
fn a_run_steps_one_thing_at_a_time() {
    let mut system = System::new();
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    let mut run = system.simulate();
    assert_eq!(run.next_due(), Some(at(0)));
    assert_eq!(run.step(), Some(at(0)));
    assert_eq!(run.step(), Some(at(10)));
    run.stop();
    assert_eq!(run.step(), Some(at(20)), "the cycle that no longer happens");
    assert_eq!(run.step(), None);
    assert_eq!(run.cycles("Counter"), 2);
}

#[test]
fn a_pace_holds_virtual_time_back() {
    let mut system = System::new();
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    let mut run = system.simulate();
    run.set_pace(Pace::Factor(10.0));
    let began = std::time::Instant::now();
    run.run_for(500.ms());
    assert!(began.elapsed() >= 50.ms());
}

#[test]
fn the_same_system_runs_the_same_way_twice() {
    let once = || {
        let log = Log::new();
        let mut system = System::new();
        system.observe(log.clone());
        system.add("Ping", Activity::event(), relay()).unwrap();
        system
            .add(
                "Doubler",
                Activity::periodic(30.ms()),
                crate::common::doubler(),
            )
            .unwrap();
        system
            .add("Counter", Activity::periodic(7.ms()), counter())
            .unwrap();
        system
            .add("Slow", Activity::periodic(13.ms()).delay(3.ms()), relay())
            .unwrap();
        let asking = behaviour(|interface| {
            let double = interface.require::<crate::common::Double>("sums", "to double");
            let input = interface.input::<Number>("in", "numbers");
            move |cycle| {
                let samples: Vec<_> = cycle.all(input).to_vec();
                for sample in samples {
                    cycle.call(double, sample);
                }
                for reply in cycle.replies(double) {
                    cycle.report("doubled", Datum::text(format!("{:?}", reply.result)));
                }
                assert!(cycle.number() < 90, "on purpose");
                Ok(())
            }
        });
        system.add("Asking", Activity::event(), asking).unwrap();
        system.publish("Counter.n", "numbers").unwrap();
        system
            .subscribe("numbers", "Ping.in", Policy::data())
            .unwrap();
        system
            .subscribe("numbers", "Slow.in", Policy::circular(1))
            .unwrap();
        system
            .connect("Ping.out", "Asking.in", Policy::buffer(4))
            .unwrap();
        system
            .connect("Slow.out", "Asking.in", Policy::buffer(4))
            .unwrap();
        let wire = asmotion_component::Wire::timeout(8.ms()).retries(1);
        system.wire("Asking.sums", "Doubler.sums", wire).unwrap();
        let mut run = system.simulate();
        run.inject(at(50), "Ping.in", number(1000)).unwrap();
        run.run_for(2.s());
        run.stop();
        log.lines()
    };
    let (first, second) = (once(), once());
    assert!(first.len() > 1000, "{} lines", first.len());
    assert!(first.iter().any(|line| line.contains("Timeout")));
    assert_eq!(first, second);
}

#[test]
fn the_time_of_a_cycle_stands_still_and_grows_between_cycles() {
    let times: Arc<Mutex<Vec<Time>>> = Arc::default();
    let keep = Arc::clone(&times);
    let mut system = System::new();
    let looking = behaviour(move |_| {
        move |cycle| {
            let now = cycle.now();
            std::thread::sleep(1.ms());
            assert_eq!(cycle.now(), now);
            keep.lock().unwrap().push(now);
            Ok(())
        }
    });
    system
        .add("Looking", Activity::periodic(10.ms()), looking)
        .unwrap();
    system.simulate().run_until(at(20));
    assert_eq!(*times.lock().unwrap(), [at(0), at(10), at(20)]);
}

/// Requests a cycle at these times (ms), each list in the cycle with its number, and keeps the times of its cycles.
fn requesting(
    requests: &'static [&'static [i64]],
    times: &Arc<Mutex<Vec<Time>>>,
) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let times = Arc::clone(times);
    behaviour(move |interface| {
        interface.input::<Number>("in", "a trigger");
        move |cycle| {
            times.lock().unwrap().push(cycle.now());
            let index = usize::try_from(cycle.number() - 1).unwrap();
            for ms in requests.get(index).copied().unwrap_or_default() {
                cycle.request_cycle_at(Time::from_nanos(ms * 1_000_000));
            }
            Ok(())
        }
    })
}

/// The times (ms) of the cycles of an event-driven component that requests cycles at these times and is triggered at 30 ms.
fn requested(activity: Activity, requests: &'static [&'static [i64]]) -> Vec<u64> {
    let times = Arc::default();
    let mut system = System::new();
    system
        .add("Waiting", activity, requesting(requests, &times))
        .unwrap();
    let mut run = system.simulate();
    run.inject(at(30), "Waiting.in", number(1)).unwrap();
    run.run_until(at(1000));
    let times = times.lock().unwrap();
    let since = |time: &Time| u64::try_from(time.since(Time::ZERO).as_millis()).unwrap();
    times.iter().map(since).collect()
}

#[test]
fn a_component_requests_a_cycle_at_a_time() {
    let times = |requests| requested(Activity::event(), requests);
    // the earliest of several
    assert_eq!(times(&[&[70, 20, 50]]), [0, 20, 30]);
    // the trigger at 30 ms ends the request, unless it is made again
    assert_eq!(times(&[&[200]]), [0, 30]);
    assert_eq!(times(&[&[200], &[200]]), [0, 30, 200]);
    // a trigger at the same time is one cycle
    assert_eq!(times(&[&[30]]), [0, 30]);
    // a time that has passed: at once
    assert_eq!(times(&[&[200], &[10, -5]]), [0, 30, 30]);
    // an earlier request after a later one, and one that moves away
    assert_eq!(times(&[&[500], &[100], &[900]]), [0, 30, 100, 900]);
    // periodic components have no use for it
    assert_eq!(
        requested(Activity::periodic(400.ms()), &[&[10]]),
        [0, 400, 800]
    );
}

#[test]
fn a_stopped_component_has_no_cycle_that_it_requested() {
    let times = Arc::default();
    let mut system = System::new();
    system
        .add(
            "Waiting",
            Activity::event(),
            requesting(&[&[50], &[80]], &times),
        )
        .unwrap();
    let mut run = system.simulate();
    run.run_until(at(20));
    run.transition("Waiting", Transition::Stop).unwrap();
    run.run_until(at(60));
    run.transition("Waiting", Transition::Start).unwrap();
    run.run_until(at(1000));
    assert_eq!(*times.lock().unwrap(), [at(0), at(60), at(80)]);
}

#[test]
fn a_component_that_requests_the_present_for_ever_is_a_loop() {
    let mut system = System::new();
    let endless = behaviour(|_| {
        |cycle| {
            cycle.request_cycle_at(cycle.now());
            Ok(())
        }
    });
    system.add("Endless", Activity::event(), endless).unwrap();
    let mut run = system.simulate();
    run.run_for(1.s());
    assert_eq!(run.state("Endless"), Some(State::Exception));
}
