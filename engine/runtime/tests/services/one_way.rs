//! One-way calls: they return at once, reach several services, and lost ones are counted.

use std::sync::{Arc, Mutex};

use crate::common::{Double, behaviour, number};
use asmotion_component::{Activity, Component, Interface, ServiceFault, Span, Transition, Wire};
use asmotion_datum::Datum;
use asmotion_runtime::{Log, Run, System};

#[test]
fn c7_a_one_way_call_returns_at_once_and_a_lost_one_is_counted() {
    let got: Arc<Mutex<Vec<(i64, bool)>>> = Arc::default();
    let keep = Arc::clone(&got);
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let shouting = behaviour(|interface| {
        let double = interface.require::<Double>("sums", "shouts at");
        move |cycle| {
            cycle.call_one_way(double, number(5));
            assert!(cycle.replies(double).is_empty());
            Ok(())
        }
    });
    let listening = behaviour(move |interface| {
        let double = interface.serve::<Double>("sums", "listens");
        move |cycle| {
            for request in cycle.requests(double) {
                keep.lock()
                    .unwrap()
                    .push((request.argument.n, request.deadline.is_none()));
                cycle.reply(double, request.id, Ok(number(10)));
            }
            Ok(())
        }
    });
    system
        .add("Caller", Activity::periodic(10.ms()), shouting)
        .unwrap();
    system
        .add("Provider", Activity::event(), listening)
        .unwrap();
    system
        .wire("Caller.sums", "Provider.sums", Wire::default())
        .unwrap();
    let mut run = system.simulate();
    run.run_for(10.ms());
    assert_eq!(*got.lock().unwrap(), [(5, true), (5, true)]);
    assert_eq!(log.lines_with("answers"), [""; 0]);
    run.transition("Provider", Transition::Stop).unwrap();
    run.run_for(20.ms());
    assert_eq!(
        log.lines_with("dropped"),
        [
            "0.02 s Caller.sums -> Provider.sums: 1 dropped",
            "0.03 s Caller.sums -> Provider.sums: 2 dropped"
        ]
    );
}

#[test]
fn c7_a_refused_one_way_call_is_counted_and_its_cause_reported_once() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let asking = behaviour(|interface| {
        let double = interface.require::<Double>("sums", "asks");
        let mut n = 0;
        move |cycle| {
            n += 1;
            cycle.call_one_way(double, number(n));
            Ok(())
        }
    });
    let refusing = behaviour(|interface| {
        let double = interface.serve::<Double>("sums", "refuses");
        move |cycle| {
            for request in cycle.requests(double) {
                let result = match request.argument.n {
                    1 | 2 => Err(ServiceFault::new("SMALL", "less than three")),
                    3 => Err(ServiceFault::new("ODD", "three")),
                    n => Ok(number(2 * n)),
                };
                cycle.reply(double, request.id, result);
            }
            Ok(())
        }
    });
    let activity = Activity::periodic(10.ms());
    system.add("Caller", activity, asking).unwrap();
    system.add("Provider", Activity::event(), refusing).unwrap();
    system
        .wire("Caller.sums", "Provider.sums", Wire::default())
        .unwrap();
    let mut run = system.simulate();
    run.run_for(50.ms());
    assert_eq!(
        log.lines_with("notice"),
        [
            r#"0 s Provider: notice: "a one-way call of `sums.double` is refused: SMALL: less than three""#,
            r#"0.02 s Provider: notice: "a one-way call of `sums.double` is refused: ODD: three""#,
        ]
    );
    assert_eq!(run.losses("Provider").misfits, 3);
}

/// Makes one one-way call of `double`.
fn telling() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let double = interface.require::<Double>("listeners", "to hear it");
        let mut told = false;
        move |cycle| {
            if !std::mem::replace(&mut told, true) {
                cycle.call(double, number(21));
            }
            Ok(())
        }
    })
}

/// Reports each request it receives.
fn listening() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let double = interface.serve::<Double>("sums", "listens");
        move |cycle| {
            for request in cycle.requests(double) {
                cycle.report("told", Datum::Int(request.argument.n));
            }
            Ok(())
        }
    })
}

#[test]
fn y10_a_one_way_reference_reaches_each_of_its_services() {
    let (mut system, log) = (System::new(), Log::new());
    system.observe(log.clone());
    system.add("Teller", Activity::event(), telling()).unwrap();
    let startup = [("First", true), ("Absent", false), ("Last", true)];
    for (name, runs) in startup {
        let activity = Activity::event().run_on_startup(runs);
        system.add(name, activity, listening()).unwrap();
        let service = format!("{name}.sums");
        system
            .wire("Teller.listeners", &service, Wire::one_way())
            .unwrap();
    }
    system.simulate().run_for(1.s());
    assert_eq!(
        log.lines_with("told"),
        ["0 s First: told: 21", "0 s Last: told: 21"]
    );
    // only the call to the absent provider is lost and counted
    assert_eq!(
        log.lines_with("dropped"),
        ["0 s Teller.listeners -> Absent.sums: 1 dropped"]
    );
}

#[test]
fn a_reference_that_waits_for_an_answer_has_one_service() {
    let mut system = System::new();
    system.add("Teller", Activity::event(), telling()).unwrap();
    system.add("First", Activity::event(), listening()).unwrap();
    system.add("Last", Activity::event(), listening()).unwrap();
    let mut wire = |to, wire| system.wire("Teller.listeners", to, wire);
    wire("First.sums", Wire::one_way()).unwrap();
    let refused = ["`Teller.listeners` is already connected to `First.sums`"; 2];
    let said = [
        wire("Last.sums", Wire::default()),
        wire("First.sums", Wire::one_way()),
    ];
    assert_eq!(said.map(|it| it.unwrap_err().to_string()), refused);
}
