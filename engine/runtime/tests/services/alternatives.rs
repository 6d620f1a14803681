//! References with several services, of which the first one that is available is called.

use super::{NewComponent, Replies, at, caller, mute};
use crate::common::{Double, behaviour, doubler};
use asmotion_component::{
    Activity, CallError, Component, Interface, NO_SERVER, ServiceFault, Span, Transition, Wire,
};
use asmotion_runtime::{Log, Run, System};

/// A system whose caller has these providers as alternatives, the first one first.
fn with_alternatives<C>(replies: &Replies, providers: Vec<(C, Wire)>) -> (System, Log)
where
    C: FnOnce(&mut Interface) -> Box<dyn Component>,
{
    let (log, mut system) = (Log::new(), System::new());
    system.observe(log.clone());
    system
        .add("Caller", Activity::event(), caller(replies))
        .unwrap();
    let mut wires = Vec::new();
    for (number, (provider, wire)) in (0..).zip(providers) {
        let name = format!("Provider{number}");
        system.add(&name, Activity::event(), provider).unwrap();
        wires.push((name, wire.alternative(number)));
    }
    // the positions count, not the order in which wires are made
    for (name, wire) in wires.into_iter().rev() {
        let service = format!("{name}.sums");
        system.wire("Caller.sums", &service, wire).unwrap();
    }
    (system, log)
}

#[test]
fn c4_a_call_goes_to_the_first_alternative_that_is_available() {
    for (stopped, expected, attempts) in [
        (&[][..], Ok(42), 1),
        (&["Provider0"], Ok(42), 2),
        (&["Provider0", "Provider1"], Ok(42), 3),
        (
            &["Provider0", "Provider1", "Provider2"],
            Err(CallError::Stopped),
            3,
        ),
    ] {
        let replies = Replies::default();
        let wire = || Wire::timeout(100.ms());
        let providers = (0..3).map(|_| (doubler(), wire())).collect();
        let (system, log) = with_alternatives(&replies, providers);
        let mut run = system.simulate();
        for provider in stopped {
            run.transition(provider, Transition::Stop).unwrap();
        }
        run.run_for(1.s());
        let replies = replies.lock().unwrap();
        let results: Vec<_> = replies.iter().map(|(_, result)| result.clone()).collect();
        assert_eq!(results, [expected], "{stopped:?}");
        assert_eq!(log.lines_with("attempt").len(), attempts, "{stopped:?}");
    }
}

/// A bridge to another system, where no server is.
fn bridge_without_server(code: &'static str) -> NewComponent {
    Box::new(behaviour(move |interface| {
        let double = interface.serve::<Double>("sums", "of another system");
        move |cycle| {
            for request in cycle.requests(double) {
                cycle.reply(double, request.id, Err(ServiceFault::new(code, "nobody")));
            }
            Ok(())
        }
    }))
}

#[test]
fn c4_a_bridge_without_a_server_lets_the_next_alternative_be_tried() {
    for (code, expected) in [
        (NO_SERVER, Ok(42)),
        (
            "REFUSED",
            Err(CallError::Fault(ServiceFault::new("REFUSED", "nobody"))),
        ),
    ] {
        let replies = Replies::default();
        let wire = || Wire::timeout(100.ms());
        let here: NewComponent = Box::new(doubler());
        let providers = vec![(bridge_without_server(code), wire()), (here, wire())];
        let (system, _) = with_alternatives(&replies, providers);
        system.simulate().run_for(1.s());
        assert_eq!(*replies.lock().unwrap(), [(at(0), expected)], "{code}");
    }
    // without another one, the fault is the end
    let replies = Replies::default();
    let providers = vec![(bridge_without_server(NO_SERVER), Wire::timeout(100.ms()))];
    let (system, _) = with_alternatives(&replies, providers);
    system.simulate().run_for(1.s());
    let fault = CallError::Fault(ServiceFault::new(NO_SERVER, "nobody"));
    assert_eq!(*replies.lock().unwrap(), [(at(0), Err(fault))]);
}

#[test]
fn c4_a_call_that_times_out_does_not_go_to_another_alternative() {
    let replies = Replies::default();
    let wire = Wire::timeout(100.ms()).retries(1);
    let providers = vec![(mute(), wire), (mute(), Wire::timeout(100.ms()))];
    let (system, log) = with_alternatives(&replies, providers);
    system.simulate().run_for(1.s());
    let timeout = (at(200), Err(CallError::Timeout));
    assert_eq!(*replies.lock().unwrap(), [timeout]);
    // both at the first one
    assert_eq!(log.lines_with("attempt").len(), 2);
}

#[test]
fn c4_alternatives_share_the_time_of_an_attempt() {
    for (first, second, end) in [(100, 300, 100), (300, 100, 100)] {
        let replies = Replies::default();
        let timeout = |ms: u64| Wire::timeout(ms.ms());
        let providers = vec![(mute(), timeout(first)), (mute(), timeout(second))];
        let (system, _) = with_alternatives(&replies, providers);
        let mut run = system.simulate();
        run.transition("Provider0", Transition::Stop).unwrap();
        run.run_for(1.s());
        let timeout = (at(end), Err(CallError::Timeout));
        assert_eq!(*replies.lock().unwrap(), [timeout], "{first} {second}");
    }
}

#[test]
fn c4_a_retry_begins_with_the_first_alternative() {
    let replies = Replies::default();
    let wire = Wire {
        backoff: 80.ms(),
        ..Wire::timeout(100.ms()).retries(2)
    };
    let providers = (0..2).map(|_| (doubler(), wire)).collect();
    let (system, _) = with_alternatives(&replies, providers);
    let mut run = system.simulate();
    for provider in ["Provider0", "Provider1"] {
        run.transition(provider, Transition::Stop).unwrap();
    }
    run.run_for(50.ms());
    run.transition("Provider0", Transition::Start).unwrap();
    run.run_for(1.s());
    assert_eq!(*replies.lock().unwrap(), [(at(80), Ok(42))]);
}

#[test]
fn c4_two_wires_of_one_alternative_are_refused() {
    let replies = Replies::default();
    let providers = vec![(doubler(), Wire::default()), (doubler(), Wire::default())];
    let (mut system, _) = with_alternatives(&replies, providers);
    system.add("More", Activity::event(), doubler()).unwrap();
    let again = system.wire("Caller.sums", "More.sums", Wire::default().alternative(1));
    assert!(again.is_err());
    let again = system.wire("Caller.sums", "More.sums", Wire::default().alternative(2));
    assert_eq!(again, Ok(()));
}
