//! Services over a broker: replies before the deadline, at most one execution, detection of lost providers.

use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_amqp::AmqpBus;
use asmotion_broker::Vhost;
use asmotion_bus::{
    Bus, CallFailure, IncomingCall, Notifier, Payload, PendingCall, Request, SenderId,
    ServedAddress,
};
use asmotion_datum::Datum;

use crate::common::{LONG, connect, eventually, number, settings};

/// Two buses, as of two processes.
fn two(vhost: &Vhost<'_>) -> (AmqpBus, AmqpBus) {
    let one = || connect(settings(&vhost.url()));
    (one(), one())
}

fn serve(bus: &dyn Bus, size: usize) -> ServedAddress {
    bus.serve("planner.plan", size, Arc::new(Notifier::new()))
        .unwrap()
}

fn call(bus: &dyn Bus, n: i64, timeout: Duration) -> PendingCall {
    let request = Request::new(SenderId::new("Tester", 1), number(n), timeout);
    bus.call("planner.plan", request, Arc::new(Notifier::new()))
        .unwrap()
}

fn next(serving: &ServedAddress) -> IncomingCall {
    serving.next_within(LONG).expect("a request comes")
}

fn int(payload: &Payload) -> i64 {
    payload.to_datum().unwrap().as_int().unwrap()
}

#[test]
fn a_service_is_called_from_another_process() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (here, there) = two(&vhost);
    let serving = serve(&there, 8);
    assert!(matches!(
        here.serve("planner.plan", 8, Arc::new(Notifier::new()))
            .map(drop),
        Err(asmotion_bus::BusError::Served { .. })
    ));
    let pending = call(&here, 20, LONG);
    let request = next(&serving);
    assert_eq!(&*request.origin.source, "Tester");
    let answer = int(&request.argument) + 1;
    request.reply(Ok(number(answer)));
    assert_eq!(int(&pending.wait().unwrap()), 21);
    drop(serving);
    drop(serve(&here, 8));
}

#[test]
fn a_provider_killed_in_the_middle_of_a_call_is_missed_before_the_deadline() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (here, there) = two(&vhost);
    let serving = serve(&there, 8);
    let pending = call(&here, 1, 2 * LONG);
    let begun = next(&serving);
    // equivalent to killing it: its connection is cut, and it does not reconnect under this name
    std::mem::forget(begun);
    let at = Instant::now();
    drop(there);
    assert_eq!(pending.wait().unwrap_err(), CallFailure::Unavailable);
    assert!(at.elapsed() < Duration::from_secs(10), "{:?}", at.elapsed());
    drop(serving);
}

#[test]
fn a_provider_that_was_started_again_does_not_know_old_calls() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (here, there) = two(&vhost);
    let serving = serve(&there, 8);
    let pending = call(&here, 1, 2 * LONG);
    std::mem::forget(next(&serving));
    drop((serving, there));
    let again = connect(settings(&vhost.url()));
    let serving = serve(&again, 8);
    assert_eq!(pending.wait().unwrap_err(), CallFailure::Unavailable);
    assert!(serving.try_next().is_none(), "it was not executed again");
}

#[test]
fn a_request_is_executed_once_though_the_link_breaks_and_its_answer_comes() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (here, there) = two(&vhost);
    let serving = serve(&there, 8);
    let pending = call(&here, 20, 2 * LONG);
    let request = next(&serving);
    broker.close_connections().unwrap();
    // one reply is sent while the link is down,
    request.reply(Ok(number(21)));
    assert_eq!(int(&pending.wait().unwrap()), 21);
    // and another one after it is restored
    let up = |bus: &AmqpBus| bus.health().is_up();
    eventually("both are back", || up(&here) && up(&there));
    let pending = call(&here, 30, 2 * LONG);
    let request = next(&serving);
    broker.close_connections().unwrap();
    eventually("it is noticed", || !up(&here) || !up(&there));
    eventually("both are back", || up(&here) && up(&there));
    std::thread::sleep(Duration::from_millis(500));
    request.reply(Ok(number(31)));
    assert_eq!(int(&pending.wait().unwrap()), 31);
    assert!(serving.try_next().is_none(), "each was executed once");
}

#[test]
fn a_call_outlives_a_restart_of_the_broker() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (here, there) = two(&vhost);
    let serving = serve(&there, 8);
    let pending = call(&here, 1, 4 * LONG);
    let request = next(&serving);
    broker.kill().unwrap();
    broker.revive().unwrap();
    request.reply(Ok(number(2)));
    assert_eq!(int(&pending.wait().unwrap()), 2);
}

#[test]
fn c8_a_callback_finds_its_way_after_a_restart_of_the_broker() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (here, there) = two(&vhost);
    let serving = serve(&there, 8);
    let back = here.serve("back", 8, Arc::new(Notifier::new())).unwrap();
    let request = Request::new(SenderId::new("Tester", 1), number(1), LONG).with_callback("back");
    here.call_one_way("planner.plan", request, Arc::new(Notifier::new()))
        .unwrap()
        .wait()
        .unwrap();
    let callback = next(&serving).callback.clone().unwrap();
    broker.kill().unwrap();
    broker.revive().unwrap();
    let up = |bus: &AmqpBus| bus.health().is_up();
    eventually("both are back", || up(&here) && up(&there));
    // until the caller serves its callback address again, one-way requests fail and are repeated
    let mut told = 0;
    eventually("it is told", || {
        told += 1;
        let word = Request::new(SenderId::new("Planner", 1), number(3), LONG);
        let word = there
            .call_one_way(&callback, word, Arc::new(Notifier::new()))
            .unwrap();
        word.wait().is_ok()
    });
    assert_eq!(int(&next(&back).argument), 3);
    assert!(back.try_next().is_none(), "once, of {told}");
}

#[test]
fn a_frozen_broker_ends_a_call_at_its_deadline() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (here, there) = two(&vhost);
    let serving = serve(&there, 8);
    broker.freeze().unwrap();
    let at = Instant::now();
    let pending = call(&here, 1, Duration::from_millis(500));
    assert_eq!(pending.wait().unwrap_err(), CallFailure::Timeout);
    assert!(at.elapsed() < Duration::from_secs(2));
    broker.thaw().unwrap();
    // the request arrives now, but its caller has stopped waiting
    assert!(serving.next_within(Duration::from_secs(1)).is_none());
}

#[test]
fn a_fault_keeps_its_code_and_words_and_a_result_its_data() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = connect(settings(&vhost.url()));
    let serving = serve(&bus, 8);
    let pending = call(&bus, 1, LONG);
    let refusal = asmotion_bus::Refusal {
        code: "NO_PATH".to_owned(),
        detail: "ü: walls all around".to_owned(),
    };
    next(&serving).reply(Err(refusal.clone()));
    assert_eq!(pending.wait().unwrap_err(), CallFailure::Refused(refusal));
    let pending = call(&bus, 1, LONG);
    let record = Datum::record([("x", Datum::Float(f64::INFINITY))]);
    next(&serving).reply(Ok(Payload::of(record.clone())));
    assert_eq!(pending.wait().unwrap().to_datum().unwrap(), record);
}
