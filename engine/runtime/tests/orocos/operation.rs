//! Operations: O11.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use asmotion_component::{
    Activity, CallError, CallId, Component, Interface, SendStatus, ServiceFault, Span, State,
    ThreadUse, Wire,
};
use asmotion_runtime::{Run, System};

use super::support::{Seen, taken};
use crate::common::{Double, behaviour, doubler, in_real_time, number};

/// Serves `double` in the caller's thread; its own cycles are slow.
fn serving_in_callers(nap: Duration) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(move |interface| {
        interface.serve_in_caller::<Double>("sums", "doubles at once", |asked| match asked.n {
            13 => Err(ServiceFault::new("UNLUCKY", "thirteen")),
            14 => panic!("on purpose"),
            n => Ok(number(n * 2)),
        });
        move |_| {
            std::thread::sleep(nap);
            Ok(())
        }
    })
}

/// Sends a call in its first cycle, and records its status in every cycle.
fn sender(seen: &Seen<String>) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let seen = Arc::clone(seen);
    let mut call: Option<CallId> = None;
    behaviour(move |interface| {
        let double = interface.require::<Double>("double", "doubles");
        move |cycle| {
            let call = *call.get_or_insert_with(|| cycle.call(double, number(21)));
            let status = match cycle.collect_if_done(double, call) {
                SendStatus::NotReady => "not ready".to_owned(),
                SendStatus::Success(sum) => sum.n.to_string(),
                SendStatus::Failure(error) => error.to_string(),
                SendStatus::Unknown => "collected".to_owned(),
            };
            seen.lock().unwrap().push(status);
            Ok(())
        }
    })
}

fn calling(
    seen: &Seen<String>,
    provider: Activity,
    construct: impl FnOnce(&mut Interface) -> Box<dyn Component>,
) -> System {
    let mut system = System::new();
    system
        .add(
            "Caller",
            Activity::periodic(10.ms()).thread(ThreadUse::Own),
            sender(seen),
        )
        .unwrap();
    system.add("Doubler", provider, construct).unwrap();
    system
        .wire("Caller.double", "Doubler.sums", Wire::default())
        .unwrap();
    system
}

#[test]
fn o11_what_is_sent_is_collected_when_it_is_done() {
    let seen = Seen::default();
    let provider = Activity::periodic(1.s()).delay(25.ms());
    calling(&seen, provider, doubler())
        .simulate()
        .run_for(40.ms());
    assert_eq!(
        taken(&seen),
        ["not ready", "not ready", "not ready", "42", "collected"],
        "the provider sees it at 25 ms"
    );
}

#[test]
fn o11_in_the_callers_thread_it_is_done_at_once_whatever_the_provider_does() {
    let seen = Seen::default();
    // it does not even run
    let provider = Activity::manual().run_on_startup(false);
    let mut run = calling(&seen, provider, serving_in_callers(Duration::ZERO)).simulate();
    run.run_for(20.ms());
    assert_eq!(run.state("Doubler"), Some(State::Stopped));
    assert_eq!(taken(&seen), ["not ready", "42", "collected"]);
}

#[test]
fn o11_in_the_own_thread_nothing_is_done_unless_the_provider_runs() {
    let seen = Seen::default();
    let provider = Activity::manual().run_on_startup(false);
    calling(&seen, provider, doubler())
        .simulate()
        .run_for(20.ms());
    let stopped = CallError::Stopped.to_string();
    assert_eq!(taken(&seen), ["not ready", &stopped, "collected"]);
}

fn provider(
    activity: Activity,
    construct: impl FnOnce(&mut Interface) -> Box<dyn Component>,
) -> System {
    let mut system = System::new();
    system.add("Doubler", activity, construct).unwrap();
    system
}

#[test]
fn o11_call_and_send_of_outsider() {
    let mut run = provider(Activity::periodic(10.ms()), doubler()).simulate();
    run.run_for(5.ms());
    // send, ask, collect
    let mut sent = run
        .send::<Double>("Doubler.sums", number(4), 1.s())
        .unwrap();
    assert_eq!(sent.collect_if_done(), SendStatus::NotReady);
    run.run_for(10.ms());
    assert_eq!(sent.collect_if_done(), SendStatus::Success(number(8)));
    assert_eq!(sent.collect_if_done(), SendStatus::Unknown);
    // call: both at once
    let sent = run
        .send::<Double>("Doubler.sums", number(5), 1.s())
        .unwrap();
    assert_eq!(run.collect(sent), Ok(number(10)));
    let unknown = run.send::<Double>("Doubler.sum", number(5), 1.s());
    assert_eq!(
        unknown.err().unwrap().to_string(),
        "unknown service `Doubler.sum`; did you mean `Doubler.sums`?"
    );
}

#[test]
fn o11_a_call_of_outsider_ends_by_its_deadline() {
    let mut run = provider(Activity::manual(), doubler()).simulate();
    let sent = run
        .send::<Double>("Doubler.sums", number(4), 1.s())
        .unwrap();
    let before = run.now();
    assert_eq!(run.collect(sent), Err(CallError::Timeout));
    assert_eq!(run.now() - before, 1.s());
    run.stop();
    let sent = run
        .send::<Double>("Doubler.sums", number(4), 1.s())
        .unwrap();
    assert_eq!(run.collect(sent), Err(CallError::Stopped));
}

#[test]
fn o11_live_a_slow_provider_keeps_nobody_waiting_who_serves_himself() {
    in_real_time(|| {
        let slow = || Activity::periodic(1.ms());
        let mut run = provider(slow(), serving_in_callers(300.ms())).live();
        run.run_for(20.ms());
        let begin = run.now();
        for n in 0..100 {
            let sent = run
                .send::<Double>("Doubler.sums", number(n), 10.s())
                .unwrap();
            match run.collect(sent) {
                Err(CallError::Fault(fault)) if n == 13 => assert_eq!(fault.code, "UNLUCKY"),
                Err(CallError::Fault(fault)) if n == 14 => assert_eq!(fault.code, "PANIC"),
                result => assert_eq!(result, Ok(number(n * 2))),
            }
        }
        assert!(run.now() - begin < 100.ms(), "{:?}", run.now() - begin);
        let mut run = provider(Activity::event(), doubler()).live();
        let sent = run
            .send::<Double>("Doubler.sums", number(21), 10.s())
            .unwrap();
        assert_eq!(run.collect(sent), Ok(number(42)));
    });
}

#[test]
fn o11_the_one_who_serves_himself_does_so_in_his_own_thread() {
    let threads: Arc<Mutex<Vec<Option<String>>>> = Arc::default();
    let keep = Arc::clone(&threads);
    let serving = behaviour(move |interface| {
        interface.serve_in_caller::<Double>("sums", "doubles", move |asked| {
            let name = std::thread::current().name().map(str::to_owned);
            keep.lock().unwrap().push(name);
            Ok(asked)
        });
        |_| Ok(())
    });
    let seen = Seen::default();
    let mut run = calling(&seen, Activity::manual(), serving).live();
    run.run_for(100.ms());
    run.stop();
    assert_eq!(*threads.lock().unwrap(), [Some("Caller".to_owned())]);
}
