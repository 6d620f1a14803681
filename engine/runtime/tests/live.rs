//! The live executor: real threads, real time. Bounds are wide because the machine may be busy.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::common::{
    Double, Number, behaviour, burst, counter, doubler, in_real_time, number, run_until,
};
use asmotion_component::{
    Activity, CallError, Component, Cycle, Fault, Interface, Overrun, Policy, Span, State, Time,
    Transition, Wire,
};
use asmotion_datum::Datum;
use asmotion_runtime::{Event, Log, Run, System};

/// Sleeps in the cycle with this number.
fn sleeping(cycle_number: u64, nap: Duration) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(move |_| {
        move |cycle| {
            if cycle.number() == cycle_number {
                std::thread::sleep(nap);
            }
            Ok(())
        }
    })
}

fn cycle_times(log: &Log, component: &str) -> Vec<Time> {
    let lines = log.lines_with(&format!("{component}: cycle"));
    let seconds = lines
        .iter()
        .map(|line| line.split(' ').next().unwrap().parse::<f64>().unwrap());
    seconds
        .map(|seconds| Time::ZERO + Duration::from_secs_f64(seconds))
        .collect()
}

#[test]
fn t6_deadlines_are_absolute_so_nothing_drifts() {
    in_real_time(|| {
        let log = Log::new();
        let mut system = System::new();
        system.observe(log.clone());
        system
            .add("Counter", Activity::periodic(10.ms()), counter())
            .unwrap();
        let mut run = system.live();
        run.run_for(2.s());
        run.stop();
        let times = cycle_times(&log, "Counter");
        let periods = u32::try_from(times.len() as u64 - 1 + run.overruns("Counter")).unwrap();
        let elapsed = *times.last().unwrap() - times[0];
        let drift = elapsed.abs_diff(10.ms() * periods);
        assert!(periods > 190, "{periods} periods in 2 s");
        assert!(drift < 10.ms(), "{drift:?} after {periods} periods");
    });
}

/// Provides `double`, and takes a while to start.
struct SlowToStart(Box<dyn Component>);

impl Component for SlowToStart {
    fn start(&mut self) -> Result<(), Fault> {
        std::thread::sleep(20.ms());
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.0.update(cycle)
    }
}

#[test]
fn a_call_in_the_first_cycle_finds_its_provider_in_any_order_of_the_components() {
    for (round, caller_first) in [true, false].into_iter().cycle().take(20).enumerate() {
        let answers = Arc::new(Mutex::new(Vec::new()));
        let taken = Arc::clone(&answers);
        let mut system = System::new();
        let caller = behaviour(move |interface| {
            let double = interface.require::<Double>("double", "another's sums");
            move |cycle| {
                if cycle.number() == 1 {
                    cycle.call(double, number(21));
                }
                let results = cycle.replies(double).into_iter().map(|reply| reply.result);
                taken.lock().unwrap().extend(results);
                Ok(())
            }
        });
        let provider = |interface: &mut Interface| -> Box<dyn Component> {
            Box::new(SlowToStart(doubler()(interface)))
        };
        if caller_first {
            system
                .add("Caller", Activity::periodic(5.ms()), caller)
                .unwrap();
            system.add("Sums", Activity::event(), provider).unwrap();
        } else {
            system.add("Sums", Activity::event(), provider).unwrap();
            system
                .add("Caller", Activity::periodic(5.ms()), caller)
                .unwrap();
        }
        system
            .wire("Caller.double", "Sums.sums", Wire::default())
            .unwrap();
        let mut run = system.live();
        let limit = run.now() + 20.s();
        while answers.lock().unwrap().is_empty() {
            assert!(run.now() < limit, "an answer in round {round}");
            run.run_for(2.ms());
        }
        assert_eq!(*answers.lock().unwrap(), [Ok(number(42))], "round {round}");
    }
}

#[test]
fn t6_an_overrun_is_counted_and_skipped() {
    let mut system = System::new();
    system
        .add("Slow", Activity::periodic(20.ms()), sleeping(2, 70.ms()))
        .unwrap();
    let mut run = system.live();
    let mut missed = 0;
    run.run_until_event(Time::ZERO + 5.s(), &mut |_, event| {
        if let Event::Overrun { missed: now, .. } = event {
            missed = *now;
        }
        missed >= 3
    });
    assert!(missed >= 3, "{missed} missed");
}

#[test]
fn t6_an_overrun_is_caught_up() {
    in_real_time(|| {
        let log = Log::new();
        let mut system = System::new();
        system.observe(log.clone());
        let activity = Activity::periodic(50.ms()).overrun(Overrun::CatchUp);
        system.add("Slow", activity, sleeping(2, 170.ms())).unwrap();
        let mut run = system.live();
        run.run_for(450.ms());
        run.stop();
        let times = cycle_times(&log, "Slow");
        // begins at 0 and 50 ms; at 220 ms the cycles of 100, 150 and 200 ms follow at once
        assert!(times[4] - times[2] < 100.ms(), "not at once: {times:?}");
        assert!(run.cycles("Slow") >= 8, "{times:?}");
        assert!(run.overruns("Slow") >= 3);
    });
}

#[test]
fn t6_an_overrun_can_be_a_failure() {
    let mut system = System::new();
    let activity = Activity::periodic(20.ms()).overrun(Overrun::Fail);
    system.add("Slow", activity, sleeping(2, 70.ms())).unwrap();
    let mut run = system.live();
    let mut failed = |_: Time, event: &Event<'_>| {
        matches!(
            event,
            Event::LifeCycle {
                to: State::Exception,
                ..
            }
        )
    };
    assert!(run.run_until_event(Time::ZERO + 30.s(), &mut failed));
    assert!(
        run.fault("Slow")
            .unwrap()
            .to_string()
            .starts_with("missed ")
    );
}

/// Latenesses of a component's cycles on a grid of periods since its first one, sorted.
fn latenesses(log: &Log, component: &str, period: Duration) -> Vec<Duration> {
    let times = cycle_times(log, component);
    let mut all: Vec<Duration> = times
        .iter()
        .map(|at| {
            let elapsed = *at - times[0];
            let whole = elapsed.as_nanos() / period.as_nanos();
            elapsed - period * u32::try_from(whole).unwrap()
        })
        .collect();
    all.sort();
    all
}

#[test]
fn t7_a_slow_component_does_not_delay_another() {
    in_real_time(|| {
        let log = Log::new();
        let mut system = System::new();
        system.observe(log.clone());
        let asleep = behaviour(|_| {
            |_| {
                std::thread::sleep(200.ms());
                Ok(())
            }
        });
        system
            .add("Asleep", Activity::periodic(10.ms()), asleep)
            .unwrap();
        system
            .add("Quick", Activity::periodic(10.ms()), counter())
            .unwrap();
        let mut run = system.live();
        run.run_for(1.s());
        run.stop();
        assert!(run.cycles("Asleep") < 10);
        assert!(run.cycles("Quick") > 95, "{} cycles", run.cycles("Quick"));
        // the first cycle can be late, too: then the others come up to that much before their place on the grid
        let late = latenesses(&log, "Quick", 10.ms());
        let median = late[late.len() / 2].min(10.ms() - late[late.len() / 2]);
        assert!(median < 1.ms(), "{median:?}");
    });
}

#[test]
fn t17_the_first_cycle_is_after_the_delay() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let activity = Activity::periodic(10.ms()).delay(100.ms());
    system.add("Counter", activity, counter()).unwrap();
    let mut run = system.live();
    run.run_for(200.ms());
    run.stop();
    assert!(cycle_times(&log, "Counter")[0] >= Time::ZERO + 100.ms());
}

#[test]
fn t17_an_event_driven_component_waits_for_its_delay_too_whatever_arrives_before() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("Counter", Activity::periodic(5.ms()), counter())
        .unwrap();
    let reader = behaviour(|interface| {
        let input = interface.input::<Number>("n", "numbers");
        move |cycle| {
            cycle.all(input);
            Ok(())
        }
    });
    system
        .add("Reader", Activity::event().delay(100.ms()), reader)
        .unwrap();
    system
        .connect("Counter.n", "Reader.n", Policy::buffer(64))
        .unwrap();
    let mut run = system.live();
    let limit = run.now() + 20.s();
    let mut has_cycled = |_: Time, event: &Event<'_>| matches!(event, Event::Cycle { component, .. } if *component == "Reader");
    assert!(run.run_until_event(limit, &mut has_cycled));
    run.stop();
    assert!(run.cycles("Counter") > 1, "it was triggered before");
    assert!(cycle_times(&log, "Reader")[0] >= Time::ZERO + 100.ms());
}

#[test]
fn t16_a_period_is_changed_while_running() {
    in_real_time(|| {
        let mut system = System::new();
        system
            .add("Counter", Activity::periodic(1.s()), counter())
            .unwrap();
        let mut run = system.live();
        run.run_for(700.ms());
        assert_eq!(run.cycles("Counter"), 1);
        run.set_period("Counter", 10.ms()).unwrap();
        run.run_for(300.ms());
        assert!(
            run.cycles("Counter") > 15,
            "{} cycles",
            run.cycles("Counter")
        );
        assert!(run.overruns("Counter") < 20, "the past is not made up for");
    });
}

#[test]
fn t4_t19_stopping_waits_for_a_cycle_or_interrupts_it_and_never_tears_it() {
    for may_interrupt in [false, true] {
        let log = Log::new();
        let mut system = System::new();
        system.observe(log.clone());
        let long = behaviour(|interface| {
            let out = interface.output::<Number>("n", "written at the end");
            move |cycle| {
                let begun = Instant::now();
                while begun.elapsed() < 500.ms() && !cycle.interrupted() {
                    std::thread::sleep(5.ms());
                }
                cycle.write(out, number(1));
                Ok(())
            }
        });
        let activity = Activity::manual().may_interrupt(may_interrupt);
        system.add("Long", activity, long).unwrap();
        let mut run = system.live();
        run.trigger("Long").unwrap();
        run.run_for(100.ms());
        let asked = Instant::now();
        run.transition("Long", Transition::Stop).unwrap();
        let waited = asked.elapsed();
        assert_eq!(waited > 200.ms(), !may_interrupt, "waited {waited:?}");
        assert_eq!(run.state("Long"), Some(State::Stopped));
        run.run_for(1.ms());
        assert_eq!(
            log.samples::<Number>("Long.n").len(),
            1,
            "either all of a cycle or nothing"
        );
    }
}

#[test]
fn t4_stopping_is_bounded_whatever_a_component_does() {
    let mut system = System::new();
    let let_go = Arc::new(AtomicBool::new(false));
    let gate = Arc::clone(&let_go);
    let stuck = behaviour(move |_| {
        move |_| {
            while !gate.load(Ordering::Relaxed) {
                std::thread::sleep(5.ms());
            }
            Ok(())
        }
    });
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    system.add("Stuck", Activity::event(), stuck).unwrap();
    let mut run = system.live();
    run.set_grace_period(100.ms());
    run.run_for(50.ms());
    let asked = Instant::now();
    assert_eq!(run.stop(), ["Stuck"]);
    assert_eq!(run.state("Counter"), Some(State::Stopped));
    drop(run);
    assert!(asked.elapsed() < 2.s());
    let_go.store(true, Ordering::Relaxed);
}

#[test]
fn t4_who_asks_does_not_wait_for_a_long_cycle() {
    in_real_time(|| {
        let mut system = System::new();
        let busy = sleeping(1, Duration::from_millis(600));
        system
            .add("Busy", Activity::periodic(10.ms()), busy)
            .unwrap();
        let mut run = system.live();
        while run.cycles("Busy") == 0 {
            std::thread::yield_now();
        }
        let at = Instant::now();
        let asked = run.begin_transition("Busy", Transition::Stop).unwrap();
        assert_eq!(asked.try_take(), None);
        assert!(run.properties("Busy").is_err());
        assert!(at.elapsed() < Duration::from_millis(300));
        let end = loop {
            if let Some(end) = asked.try_take() {
                break end;
            }
            run.run_for(10.ms());
        };
        assert_eq!((end, run.state("Busy")), (Ok(()), Some(State::Stopped)));
        let again = run.begin_transition("Busy", Transition::Stop).unwrap();
        run.run_for(50.ms());
        let refused = again.try_take().unwrap().unwrap_err();
        assert!(refused.to_string().contains("cannot stop"), "{refused}");
    });
}

#[test]
fn o4_an_event_driven_component_wakes_for_data_and_sleeps_otherwise() {
    let mut system = System::new();
    system.add("Burst", Activity::manual(), burst(1)).unwrap();
    let seen: Arc<Mutex<Vec<i64>>> = Arc::default();
    let keep = Arc::clone(&seen);
    let reading = behaviour(move |interface| {
        let input = interface.input::<Number>("n", "numbers");
        move |cycle| {
            keep.lock()
                .unwrap()
                .extend(cycle.all(input).iter().map(|sample| sample.n));
            Ok(())
        }
    });
    system.add("Reader", Activity::event(), reading).unwrap();
    system
        .connect("Burst.n", "Reader.n", Policy::buffer(8))
        .unwrap();
    let mut run = system.live();
    run_until(&mut run, |run| run.cycles("Reader") == 1);
    for n in 1..=3 {
        run.trigger("Burst").unwrap();
        run_until(&mut run, |run| run.cycles("Reader") > n);
        run.run_for(30.ms());
        assert_eq!(run.cycles("Reader"), 1 + n);
    }
    run.inject(Time::ZERO, "Reader.n", number(99)).unwrap();
    let later = run.now() + 200.ms();
    run.inject(later, "Reader.n", Datum::record([("n", Datum::Int(100))]))
        .unwrap();
    run_until(&mut run, |_| seen.lock().unwrap().len() >= 4);
    let has_both = seen.lock().unwrap().len() > 4;
    assert!(!has_both || run.now() >= later, "too early");
    run_until(&mut run, |_| seen.lock().unwrap().len() >= 5);
    assert!(run.now() >= later);
    assert_eq!(*seen.lock().unwrap(), [1, 2, 3, 99, 100]);
}

#[test]
fn c6_calls_end_with_an_answer_or_at_the_deadline() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let asking = behaviour(|interface| {
        let double = interface.require::<Double>("sums", "answered");
        let mute = interface.require::<Double>("mute", "never answered");
        let mut called = false;
        move |cycle| {
            if !std::mem::replace(&mut called, true) {
                cycle.call(double, number(21));
                cycle.call(mute, number(21));
            }
            for reply in cycle.replies(double) {
                cycle.report("answer", Datum::Int(reply.result?.n));
            }
            for reply in cycle.replies(mute) {
                assert_eq!(reply.result, Err(CallError::Timeout));
                cycle.report("timeout", Datum::Null);
            }
            Ok(())
        }
    });
    let silent = behaviour(|interface| {
        let double = interface.serve::<Double>("sums", "takes, never answers");
        move |cycle| {
            cycle.requests(double);
            Ok(())
        }
    });
    system.add("Doubler", Activity::event(), doubler()).unwrap();
    system.add("Silent", Activity::event(), silent).unwrap();
    system
        .add("Asking", Activity::event().delay(20.ms()), asking)
        .unwrap();
    system
        .wire("Asking.sums", "Doubler.sums", Wire::default())
        .unwrap();
    system
        .wire("Asking.mute", "Silent.sums", Wire::timeout(150.ms()))
        .unwrap();
    let mut run = system.live();
    let mut timeout = |_: Time, event: &Event<'_>| {
        matches!(
            event,
            Event::Report {
                kind: "timeout",
                ..
            }
        )
    };
    assert!(run.run_until_event(Time::ZERO + 5.s(), &mut timeout));
    assert!(run.now() >= Time::ZERO + 150.ms());
    assert_eq!(log.lines_with("answer: 42").len(), 1);
    assert!(run.is_running("Asking"), "{:?}", run.fault("Asking"));
}

#[test]
fn a_panicking_component_is_isolated() {
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
    let mut run = system.live();
    // it may have failed before anything can wait for the event, or much later
    while run.state("Failing") != Some(State::Exception) && run.now() < Time::ZERO + 30.s() {
        run.run_for(10.ms());
    }
    run.run_for(100.ms());
    assert_eq!(
        run.fault("Failing").unwrap().to_string(),
        "panicked: on purpose"
    );
    assert!(run.cycles("Counter") > 5);
    run.transition("Failing", Transition::ResetException)
        .unwrap();
    assert_eq!(run.state("Failing"), Some(State::PreOperational));
}

#[test]
fn properties_are_set_and_read_while_running() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let saying = behaviour(|interface| {
        let n = interface
            .setting("n", 1_i64, "what to say")
            .range(0..=9)
            .declare();
        let out = interface.output::<Number>("n", "number sent");
        move |cycle| {
            let n = cycle.property(n);
            cycle.write(out, number(n));
            Ok(())
        }
    });
    system
        .add("Saying", Activity::periodic(10.ms()), saying)
        .unwrap();
    let mut run = system.live();
    run.run_for(50.ms());
    run.set_properties("Saying", &[("n".into(), Datum::Int(7))])
        .unwrap();
    assert!(
        run.set_properties("Saying", &[("n".into(), Datum::Int(70))])
            .is_err()
    );
    run.run_for(100.ms());
    // on a busy machine a cycle may be under way
    let values = std::iter::repeat_with(|| run.properties("Saying"));
    let values = values.take(100).find_map(Result::ok);
    assert_eq!(values.unwrap(), [("n".to_owned(), Datum::Int(7))]);
    run.stop();
    let samples = log.samples::<Number>("Saying.n");
    assert_eq!(
        (samples[0].1, samples.last().unwrap().1),
        (number(1), number(7))
    );
}

#[test]
fn observers_that_fall_behind_lose_events_and_are_told_how_many() {
    let mut system = System::new();
    let lost = Arc::new(Mutex::new((0_u64, 0_u64)));
    let keep = Arc::clone(&lost);
    system.observe(move |_: Time, event: &Event<'_>| {
        let mut counts = keep.lock().unwrap();
        if let Event::Lost { count } = event {
            counts.1 += count;
        } else {
            counts.0 += u64::from(matches!(event, Event::Published { .. }));
        }
    });
    // more events in one cycle than the queue holds
    system
        .add("Burst", Activity::manual(), burst(100_000))
        .unwrap();
    let mut run = system.live();
    run.trigger("Burst").unwrap();
    std::thread::sleep(500.ms());
    run.run_for(50.ms());
    let (seen, lost) = *lost.lock().unwrap();
    assert!(seen > 60_000 && lost > 30_000, "{seen} seen, {lost} lost");
    assert!(seen + lost >= 100_000);
}

#[test]
fn a_component_requests_a_cycle_at_a_time() {
    in_real_time(|| {
        let times: Arc<Mutex<Vec<Time>>> = Arc::default();
        let keep = Arc::clone(&times);
        let mut system = System::new();
        let waiting = behaviour(move |_| {
            move |cycle| {
                let mut times = keep.lock().unwrap();
                times.push(cycle.now());
                if let [begin] = times[..] {
                    cycle.request_cycle_at(begin + 200.ms());
                    cycle.request_cycle_at(begin + 100.ms());
                }
                Ok(())
            }
        });
        system.add("Waiting", Activity::event(), waiting).unwrap();
        let mut run = system.live();
        run.run_for(400.ms());
        run.stop();
        let times = times.lock().unwrap();
        let [begin, end] = times[..] else {
            panic!("{times:?}");
        };
        let took = end.since(begin);
        assert!((100.ms()..120.ms()).contains(&took), "{took:?}");
    });
}
