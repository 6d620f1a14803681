//! Services: calls with a deadline, typed errors, cancellation. Virtual time, so deadlines are exact.

mod alternatives;
mod one_way;
mod refused;
mod stopped;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use crate::common::{Double, Number, Spell, Words, behaviour, doubler, number};
use asmotion_component::{
    Activity, CallError, Component, Interface, Reply, RequestId, ServiceFault, Span, State, Time,
    Transition, Wire,
};
use asmotion_datum::Datum;
use asmotion_runtime::{Log, Run, System};

type NewComponent = Box<dyn FnOnce(&mut Interface) -> Box<dyn Component>>;

type Replies = Arc<Mutex<Vec<(Time, Result<i64, CallError>)>>>;

/// Calls `double` once with 21, and records the reply.
fn caller(replies: &Replies) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let replies = Arc::clone(replies);
    behaviour(move |interface| {
        let double = interface.require::<Double>("sums", "to double");
        let mut called = false;
        move |cycle| {
            if !called {
                called = true;
                cycle.call(double, number(21));
            }
            let now = cycle.now();
            for Reply { result, .. } in cycle.replies(double) {
                replies
                    .lock()
                    .unwrap()
                    .push((now, result.map(|sample| sample.n)));
            }
            Ok(())
        }
    })
}

/// Takes requests and never replies.
fn mute() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let double = interface.serve::<Double>("sums", "never");
        move |cycle| {
            cycle.requests(double);
            Ok(())
        }
    })
}

fn wired(
    caller_activity: Activity,
    replies: &Replies,
    provider: (Activity, impl FnOnce(&mut Interface) -> Box<dyn Component>),
    wire: Wire,
) -> (System, Log) {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("Caller", caller_activity, caller(replies))
        .unwrap();
    system.add("Provider", provider.0, provider.1).unwrap();
    system.wire("Caller.sums", "Provider.sums", wire).unwrap();
    (system, log)
}

fn at(ms: u64) -> Time {
    Time::ZERO + ms.ms()
}

#[test]
fn t24_c6_a_reply_comes_in_a_later_cycle_of_the_caller() {
    let replies = Replies::default();
    let activity = Activity::periodic(10.ms());
    let provider = (Activity::event(), doubler());
    let (system, _) = wired(activity, &replies, provider, Wire::default());
    system.simulate().run_for(1.s());
    assert_eq!(*replies.lock().unwrap(), [(at(10), Ok(42))]);
}

#[test]
fn c6_a_caller_that_was_stopped_does_not_see_replies_to_its_former_life() {
    for (restarts, expected) in [(false, vec![Ok(42)]), (true, vec![])] {
        let (replies, reads) = (
            Arc::<Mutex<Vec<_>>>::default(),
            Arc::new(AtomicBool::new(false)),
        );
        let (taken, is_reading) = (Arc::clone(&replies), Arc::clone(&reads));
        let caller = behaviour(move |interface| {
            let double = interface.require::<Double>("sums", "to double");
            let mut called = false;
            move |cycle| {
                if !std::mem::replace(&mut called, true) {
                    cycle.call(double, number(21));
                }
                if is_reading.load(Ordering::Relaxed) {
                    let all = cycle.replies(double).into_iter();
                    let all = all.map(|reply| reply.result.map(|sample| sample.n));
                    taken.lock().unwrap().extend(all);
                }
                Ok(())
            }
        });
        let mut system = System::new();
        system
            .add("Caller", Activity::periodic(10.ms()), caller)
            .unwrap();
        system
            .add("Provider", Activity::event(), doubler())
            .unwrap();
        system
            .wire("Caller.sums", "Provider.sums", Wire::default())
            .unwrap();
        let mut run = system.simulate();
        // the reply is visible in the second cycle, and nobody takes it
        run.run_for(25.ms());
        if restarts {
            run.transition("Caller", Transition::Stop).unwrap();
            run.transition("Caller", Transition::Start).unwrap();
        }
        reads.store(true, Ordering::Relaxed);
        run.run_for(1.s());
        assert_eq!(*replies.lock().unwrap(), expected, "restarts: {restarts}");
    }
}

#[test]
fn c6_an_event_driven_caller_sees_its_reply_at_once() {
    let replies = Replies::default();
    let provider = (Activity::event(), doubler());
    let (system, _) = wired(Activity::event(), &replies, provider, Wire::default());
    system.simulate().run_for(1.s());
    assert_eq!(*replies.lock().unwrap(), [(at(0), Ok(42))]);
}

#[test]
fn c6_a_periodic_provider_answers_in_its_next_period() {
    let replies = Replies::default();
    let provider = (Activity::periodic(100.ms()).delay(30.ms()), doubler());
    let (system, _) = wired(Activity::event(), &replies, provider, Wire::default());
    system.simulate().run_for(1.s());
    assert_eq!(*replies.lock().unwrap(), [(at(30), Ok(42))]);
}

#[test]
fn c6_a_provider_that_never_answers_is_a_timeout_exactly_at_the_deadline() {
    let replies = Replies::default();
    let wire = Wire::timeout(137.ms());
    let (system, log) = wired(
        Activity::event(),
        &replies,
        (Activity::event(), mute()),
        wire,
    );
    system.simulate().run_for(1.s());
    assert_eq!(
        *replies.lock().unwrap(),
        [(at(137), Err(CallError::Timeout))]
    );
    assert_eq!(
        log.lines_with("ends"),
        ["0.137 s Caller.sums.double call 1 ends: no answer before the deadline"]
    );
}

#[test]
fn c6_a_periodic_caller_sees_the_timeout_in_its_cycle_at_the_deadline() {
    let replies = Replies::default();
    let activity = Activity::periodic(50.ms());
    let wire = Wire::timeout(100.ms());
    let (system, _) = wired(activity, &replies, (Activity::event(), mute()), wire);
    system.simulate().run_for(1.s());
    assert_eq!(
        *replies.lock().unwrap(),
        [(at(100), Err(CallError::Timeout))]
    );
}

#[test]
fn c6_a_provider_that_dies_mid_call_is_unavailable_at_once() {
    let replies = Replies::default();
    let dying = behaviour(|interface| {
        let double = interface.serve::<Double>("sums", "once too often");
        let mut taken = false;
        move |cycle| {
            assert!(!taken, "on purpose, with a request open");
            taken = !cycle.requests(double).is_empty();
            Ok(())
        }
    });
    let provider = (Activity::periodic(10.ms()), dying);
    let (system, _) = wired(
        Activity::event(),
        &replies,
        provider,
        Wire::timeout(500.ms()),
    );
    let mut run = system.simulate();
    run.run_for(1.s());
    assert_eq!(
        *replies.lock().unwrap(),
        [(at(10), Err(CallError::Stopped))]
    );
    assert_eq!(run.state("Provider"), Some(State::Exception));
}

#[test]
fn c6_t18_a_provider_that_was_not_started_refuses_at_once_until_it_is() {
    let replies = Replies::default();
    let provider = (Activity::event().run_on_startup(false), doubler());
    let (system, _) = wired(Activity::event(), &replies, provider, Wire::default());
    let mut run = system.simulate();
    run.run_for(10.ms());
    assert_eq!(*replies.lock().unwrap(), [(at(0), Err(CallError::Stopped))]);
    assert_eq!(run.state("Provider"), Some(State::Stopped));
    assert_eq!(run.cycles("Provider"), 0);
    run.transition("Provider", Transition::Start).unwrap();
    run.run_for(10.ms());
    assert_eq!(run.cycles("Provider"), 1);
}

#[test]
fn c6_a_reference_without_a_wire_is_unavailable() {
    let replies = Replies::default();
    let mut system = System::new();
    system
        .add("Caller", Activity::event(), caller(&replies))
        .unwrap();
    system.simulate().run_for(1.s());
    assert_eq!(
        *replies.lock().unwrap(),
        [(at(0), Err(CallError::Unavailable))]
    );
}

#[test]
fn c6_a_fault_of_the_provider_reaches_the_caller() {
    let replies = Replies::default();
    let refusing = behaviour(|interface| {
        let double = interface.serve::<Double>("sums", "refuses");
        move |cycle| {
            for request in cycle.requests(double) {
                let detail = format!("{} asked for {}", request.caller, request.argument.n);
                cycle.reply(double, request.id, Err(ServiceFault::new("NO_SUM", detail)));
            }
            Ok(())
        }
    });
    let provider = (Activity::event(), refusing);
    let (system, _) = wired(Activity::event(), &replies, provider, Wire::default());
    system.simulate().run_for(1.s());
    let fault = ServiceFault::new("NO_SUM", "Caller asked for 21");
    assert_eq!(
        *replies.lock().unwrap(),
        [(at(0), Err(CallError::Fault(fault)))]
    );
}

#[test]
fn c6_retries_follow_a_timeout_and_a_late_answer_counts_once() {
    let replies = Replies::default();
    // replies to the first attempt only after the second has begun
    let late = (Activity::periodic(150.ms()).delay(150.ms()), doubler());
    let wire = Wire {
        cancel_on_timeout: false,
        ..Wire::timeout(100.ms()).retries(2)
    };
    let (system, log) = wired(Activity::event(), &replies, late, wire);
    system.simulate().run_for(1.s());
    assert_eq!(*replies.lock().unwrap(), [(at(150), Ok(42))]);
    assert_eq!(log.lines_with("attempt").len(), 2);

    let replies = Replies::default();
    let wire = Wire::timeout(100.ms()).retries(2);
    let (system, log) = wired(
        Activity::event(),
        &replies,
        (Activity::event(), mute()),
        wire,
    );
    system.simulate().run_for(1.s());
    assert_eq!(
        *replies.lock().unwrap(),
        [(at(300), Err(CallError::Timeout))]
    );
    assert_eq!(log.lines_with("attempt").len(), 3);
}

#[test]
fn c6_an_attempt_is_made_again_after_a_rest_that_doubles() {
    let replies = Replies::default();
    let wire = Wire {
        backoff: 50.ms(),
        ..Wire::timeout(100.ms()).retries(2)
    };
    let (system, log) = wired(
        Activity::event(),
        &replies,
        (Activity::event(), mute()),
        wire,
    );
    system.simulate().run_for(1.s());
    // three attempts of 100 ms, rests of 50 ms and 100 ms
    let end = (at(450), Err(CallError::Timeout));
    assert_eq!(*replies.lock().unwrap(), [end]);
    assert_eq!(log.lines_with("attempt").len(), 3);
}

#[test]
fn c6_who_finds_nobody_tries_again_after_a_rest_and_not_at_once() {
    for (backoff, end) in [(0.ms(), Err(CallError::Stopped)), (80.ms(), Ok(42))] {
        let replies = Replies::default();
        let wire = Wire {
            backoff,
            ..Wire::timeout(100.ms()).retries(2)
        };
        let provider = (Activity::event(), doubler());
        let (system, _) = wired(Activity::event(), &replies, provider, wire);
        let mut run = system.simulate();
        run.transition("Provider", Transition::Stop).unwrap();
        run.run_for(50.ms());
        run.transition("Provider", Transition::Start).unwrap();
        run.run_for(1.s());
        let replies = replies.lock().unwrap();
        assert_eq!(
            replies.iter().map(|(_, end)| end).collect::<Vec<_>>(),
            [&end]
        );
    }
}

#[test]
fn a_provider_is_told_what_nobody_waits_for_any_more() {
    let replies = Replies::default();
    let told: Arc<Mutex<Vec<(Time, RequestId)>>> = Arc::default();
    let keep = Arc::clone(&told);
    let slow = behaviour(move |interface| {
        let double = interface.serve::<Double>("sums", "slow");
        move |cycle| {
            cycle.requests(double);
            let now = cycle.now();
            keep.lock()
                .unwrap()
                .extend(cycle.cancelled(double).iter().map(|id| (now, *id)));
            Ok(())
        }
    });
    let wire = Wire::timeout(100.ms());
    let (system, _) = wired(Activity::event(), &replies, (Activity::event(), slow), wire);
    system.simulate().run_for(1.s());
    assert_eq!(*told.lock().unwrap(), [(at(100), RequestId(1))]);
}

#[test]
fn a_cancelled_call_ends_cancelled_and_its_answer_goes_nowhere() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let changing_its_mind = behaviour(|interface| {
        let double = interface.require::<Double>("sums", "to double");
        let mut call = None;
        move |cycle| {
            match call {
                None => call = Some(cycle.call(double, number(1))),
                Some(call) => cycle.cancel(call),
            }
            for reply in cycle.replies(double) {
                cycle.report("reply", Datum::text(format!("{:?}", reply.result)));
            }
            Ok(())
        }
    });
    system
        .add("Caller", Activity::periodic(10.ms()), changing_its_mind)
        .unwrap();
    system
        .add(
            "Provider",
            Activity::periodic(25.ms()).delay(25.ms()),
            doubler(),
        )
        .unwrap();
    system
        .wire("Caller.sums", "Provider.sums", Wire::default())
        .unwrap();
    system.simulate().run_for(1.s());
    assert_eq!(
        log.lines_with("reply"),
        [r#"0.02 s Caller: reply: "Err(Cancelled)""#]
    );
    assert_eq!(log.lines_with("answers"), [""; 0]);
}

#[test]
fn a_service_has_several_operations_and_callers() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let serving = behaviour(|interface| {
        let double = interface.serve::<Double>("sums", "arithmetic");
        let spell = interface.serve::<Spell>("sums", "arithmetic");
        move |cycle| {
            for request in cycle.requests(spell) {
                let words = format!("{} for {}", request.argument.n, request.caller);
                cycle.reply(spell, request.id, Ok(Words { words }));
            }
            for request in cycle.requests(double) {
                cycle.reply(double, request.id, Ok(number(request.argument.n * 2)));
            }
            Ok(())
        }
    });
    let asking = |n: i64| {
        behaviour(move |interface| {
            // another order than the provider's
            let spell = interface.require::<Spell>("arithmetic", "spells");
            let double = interface.require::<Double>("arithmetic", "doubles");
            let mut called = false;
            move |cycle| {
                if !called {
                    called = true;
                    cycle.call(double, number(n));
                    cycle.call(spell, number(n));
                }
                for reply in cycle.replies(double) {
                    cycle.report("double", Datum::Int(reply.result?.n));
                }
                for reply in cycle.replies(spell) {
                    cycle.report("spelt", Datum::text(reply.result?.words));
                }
                Ok(())
            }
        })
    };
    system.add("A", Activity::event(), asking(1)).unwrap();
    system.add("B", Activity::event(), asking(2)).unwrap();
    system.add("Provider", Activity::event(), serving).unwrap();
    system
        .wire("A.arithmetic", "Provider.sums", Wire::default())
        .unwrap();
    system
        .wire("B.arithmetic", "Provider.sums", Wire::default())
        .unwrap();
    system.simulate().run_for(1.ms());
    assert_eq!(
        log.lines_with(": double"),
        ["0 s A: double: 2", "0 s B: double: 4"]
    );
    assert_eq!(
        log.lines_with(": spelt"),
        [r#"0 s A: spelt: "1 for A""#, r#"0 s B: spelt: "2 for B""#]
    );
}

#[test]
fn a_dynamic_reference_calls_a_typed_service_and_the_other_way_round() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let dynamic = |value: Datum| {
        behaviour(move |interface| {
            let double = interface.require_of("sums", "test/Arithmetic", "double", "to double");
            let mut argument = Some(value);
            move |cycle| {
                if let Some(argument) = argument.take() {
                    cycle.call(double, argument);
                }
                for reply in cycle.replies(double) {
                    let what = reply
                        .result
                        .unwrap_or_else(|error| Datum::text(error.to_string()));
                    cycle.report("got", what);
                }
                Ok(())
            }
        })
    };
    let good = Datum::record([("n", Datum::Int(4))]);
    let bad = Datum::record([("n", Datum::text("four"))]);
    let echoing = behaviour(|interface| {
        let double = interface.serve_of("sums", "test/Arithmetic", "double", "echoes");
        move |cycle| {
            for request in cycle.requests(double) {
                cycle.reply(double, request.id, Ok(request.argument));
            }
            Ok(())
        }
    });
    let replies = Replies::default();
    system
        .add("Good", Activity::event(), dynamic(good))
        .unwrap();
    system.add("Bad", Activity::event(), dynamic(bad)).unwrap();
    system.add("Doubler", Activity::event(), doubler()).unwrap();
    system
        .add("Typed", Activity::event(), caller(&replies))
        .unwrap();
    system.add("Echo", Activity::event(), echoing).unwrap();
    system
        .wire("Good.sums", "Doubler.sums", Wire::default())
        .unwrap();
    system
        .wire("Bad.sums", "Doubler.sums", Wire::default())
        .unwrap();
    system
        .wire("Typed.sums", "Echo.sums", Wire::default())
        .unwrap();
    system.simulate().run_for(1.ms());
    assert_eq!(log.lines_with("Good: got"), ["0 s Good: got: {n: 8}"]);
    let bad = log.lines_with("Bad: got");
    assert!(
        bad[0].contains("BAD_ARGUMENT: `n`: invalid type: string"),
        "{bad:?}"
    );
    assert_eq!(*replies.lock().unwrap(), [(at(0), Ok(21))]);
}

#[test]
fn t25_two_components_call_and_publish_to_each_other_without_deadlock() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let both = || {
        behaviour(|interface| {
            let out = interface.output::<Number>("n", "to the other");
            let input = interface.input::<Number>("other", "from the other");
            let served = interface.serve::<Double>("sums", "for the other");
            let called = interface.require::<Double>("others", "of the other");
            let mut first = true;
            move |cycle| {
                if std::mem::take(&mut first) {
                    cycle.write(out, number(1));
                    cycle.call(called, number(3));
                }
                for request in cycle.requests(served) {
                    cycle.reply(served, request.id, Ok(number(request.argument.n * 2)));
                }
                for reply in cycle.replies(called) {
                    let heard = cycle.read(input).any().map_or(0, |sample| sample.n);
                    cycle.report("done", Datum::Int(reply.result?.n + heard));
                }
                Ok(())
            }
        })
    };
    system.add("A", Activity::event(), both()).unwrap();
    system.add("B", Activity::event(), both()).unwrap();
    for (one, other) in [("A", "B"), ("B", "A")] {
        let (out, input) = (format!("{one}.n"), format!("{other}.other"));
        system
            .connect(&out, &input, asmotion_component::Policy::data())
            .unwrap();
        let (reference, service) = (format!("{one}.others"), format!("{other}.sums"));
        system.wire(&reference, &service, Wire::default()).unwrap();
    }
    system.simulate().run_for(1.s());
    assert_eq!(log.lines_with("done"), ["0 s A: done: 7", "0 s B: done: 7"]);
}
