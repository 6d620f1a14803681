//! The cases of the contract.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_datum::{Codec, Datum, Message, Schema};

use crate::bus::{Bus, BusError, Publisher};
use crate::envelope::{Envelope, Payload};
use crate::pattern::Pattern;
use crate::publish_options::PublishOptions;
use crate::queue::{Overflow, QueuePolicy, Subscription};
use crate::request::{CallFailure, PendingCall, Refusal, Request, ServedAddress};
use crate::sender_id::SenderId;
use crate::trace_context::SpanGenerator;
use asmotion_connection::Notifier;

/// A case: takes a bus and a unique name, and returns an explanation if the bus fails.
pub(super) type ContractCase = fn(&dyn Bus, &str) -> Result<(), String>;

pub(super) const CASES: &[(&str, ContractCase)] = &[
    ("delivers what is published", delivers),
    ("keeps the order of a publisher", keeps_order),
    ("numbers messages without gaps", numbers),
    ("carries the metadata of a message", carries_facts),
    ("carries data exactly", carries_exactly),
    ("gives every subscriber every message", fans_out),
    ("merges all publishers of a topic", joins_publishers),
    ("matches patterns", matches_patterns),
    ("keeps the latest", keeps_latest),
    ("drops the oldest and counts", drops_oldest),
    ("drops the newest and counts", drops_newest),
    ("delivers no earlier messages", has_no_past),
    ("repeats the last message to late subscribers", repeats_last),
    ("forgets subscribers that leave", forgets),
    (
        "is not stalled by a subscriber that does not read",
        never_stalls,
    ),
    ("answers a request", answers),
    ("passes on a refusal", refuses),
    ("ends a call at its deadline", times_out),
    ("reports that no server is available", unavailable),
    ("reports that the server's component is stopped", stopped),
    ("tells callers when a server leaves", server_leaves),
    (
        "tells the caller when a request is dropped",
        request_dropped,
    ),
    ("has one server at an address", one_server),
    ("limits the number of waiting requests", bounds_requests),
    ("drops expired requests", drops_expired),
    ("cancels a call", takes_back),
    ("sends a one-way call without waiting", tells),
    ("calls back", calls_back),
    ("carries a trace", carries_trace),
    ("confirms messages on request", confirms),
    ("is healthy", is_well),
];

/// Time within which a message crosses any bus.
const CROSSING: Duration = Duration::from_secs(5);
/// Time without a message after which a case assumes that none will arrive.
const SILENCE: Duration = Duration::from_millis(200);
const EVERY: QueuePolicy = QueuePolicy::All {
    size: 1000,
    overflow: Overflow::DropOldest,
};

/// A name below another one, unique within the case.
fn subtopic(name: &str, segment: &str) -> String {
    format!("{name}.{segment}")
}

fn origin() -> SenderId {
    SenderId::new("contract", 7)
}

fn publisher(bus: &dyn Bus, topic: &str) -> Result<Box<dyn Publisher>, String> {
    publisher_of(bus, topic, PublishOptions::default())
}

fn publisher_of(
    bus: &dyn Bus,
    topic: &str,
    options: PublishOptions,
) -> Result<Box<dyn Publisher>, String> {
    bus.publisher(topic, &origin(), &Schema::opaque("test/Number"), options)
        .map_err(error_text)
}

fn subscribe(bus: &dyn Bus, pattern: &str, queue: QueuePolicy) -> Result<Subscription, String> {
    bus.subscribe(
        "contract",
        &Pattern::new(pattern),
        queue,
        Arc::new(Notifier::new()),
    )
    .map_err(error_text)
}

fn error_text(error: BusError) -> String {
    error.to_string()
}

fn send(
    publisher: &mut dyn Publisher,
    numbers: impl IntoIterator<Item = i64>,
) -> Result<(), String> {
    numbers.into_iter().try_for_each(|n| {
        publisher
            .publish(n, Payload::of(Datum::Int(n)))
            .map_err(error_text)
    })
}

fn next(subscription: &Subscription) -> Result<Envelope, String> {
    let next = subscription.next_within(CROSSING);
    next.ok_or_else(|| "a message did not come".to_owned())
}

/// Receives `count` messages, then expects silence.
fn receive(subscription: &Subscription, count: usize) -> Result<Vec<i64>, String> {
    let mut numbers = Vec::new();
    for _ in 0..count {
        let datum = next(subscription)?.payload.to_datum();
        let datum = datum.map_err(|error| error.to_string())?;
        numbers.push(datum.as_int().ok_or("another payload than the one sent")?);
    }
    expect_silence(subscription)?;
    Ok(numbers)
}

fn expect_silence(subscription: &Subscription) -> Result<(), String> {
    match subscription.next_within(SILENCE) {
        None => Ok(()),
        Some(envelope) => Err(format!("a message too many: {envelope:?}")),
    }
}

fn expect<T: PartialEq + std::fmt::Debug>(actual: T, expected: T) -> Result<(), String> {
    if actual == expected {
        return Ok(());
    }
    Err(format!("{actual:?} instead of {expected:?}"))
}

fn delivers(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let subscription = subscribe(bus, name, EVERY)?;
    send(&mut *publisher(bus, name)?, [1])?;
    expect(receive(&subscription, 1)?, vec![1])
}

fn keeps_order(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let subscription = subscribe(bus, name, EVERY)?;
    send(&mut *publisher(bus, name)?, 0..500)?;
    expect(receive(&subscription, 500)?, (0..500).collect())
}

fn numbers(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let subscription = subscribe(bus, name, EVERY)?;
    send(&mut *publisher(bus, name)?, 0..20)?;
    for expected in 1..=20 {
        expect(next(&subscription)?.sequence, expected)?;
    }
    Ok(())
}

fn carries_facts(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let subscription = subscribe(bus, name, EVERY)?;
    send(&mut *publisher(bus, name)?, [42])?;
    let envelope = next(&subscription)?;
    expect(&*envelope.topic, name)?;
    expect(&*envelope.source, "contract")?;
    expect(envelope.incarnation, 7)?;
    expect(envelope.stamp, 42)?;
    expect(&*envelope.type_name, "test/Number")
}

fn carries_exactly(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let subscription = subscribe(bus, name, EVERY)?;
    let sent = Datum::record([
        ("tenth", Datum::Float(0.1)),
        ("tiny", Datum::Float(5e-324)),
        ("never", Datum::Float(f64::INFINITY)),
        ("words", Datum::text("grün")),
        ("bytes", Datum::Bytes(Arc::from([0, 255]))),
        ("many", Datum::List((0..1000).map(Datum::Int).collect())),
    ]);
    let bytes = Codec::Cbor
        .encode(&sent, Datum::schema())
        .map_err(|error| error.to_string())?;
    let payloads = [
        Payload::of(sent.clone()),
        Payload::Bytes {
            codec: Codec::Cbor,
            bytes: bytes.into(),
        },
    ];
    let mut publisher = publisher(bus, name)?;
    for payload in payloads {
        publisher.publish(0, payload).map_err(error_text)?;
        let received = next(&subscription)?.payload.to_datum();
        expect(received.map_err(|error| error.to_string())?, sent.clone())?;
    }
    Ok(())
}

fn fans_out(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let first = subscribe(bus, name, EVERY)?;
    let second = subscribe(bus, name, EVERY)?;
    send(&mut *publisher(bus, name)?, 0..10)?;
    expect(receive(&first, 10)?, (0..10).collect())?;
    expect(receive(&second, 10)?, (0..10).collect())
}

fn joins_publishers(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let subscription = subscribe(bus, name, EVERY)?;
    let (mut one, mut other) = (publisher(bus, name)?, publisher(bus, name)?);
    send(&mut *one, [1])?;
    send(&mut *other, [2])?;
    let mut both = receive(&subscription, 2)?;
    both.sort_unstable();
    expect(both, vec![1, 2])
}

fn matches_patterns(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let all = subscribe(bus, &subtopic(name, "#"), EVERY)?;
    let one = subscribe(bus, &subtopic(name, "*"), EVERY)?;
    let odom = subscribe(bus, &subtopic(name, "*.odom"), EVERY)?;
    for (n, word) in [(1, "a"), (2, "a.odom"), (3, "b.odom"), (4, "b.odom.raw")] {
        send(&mut *publisher(bus, &subtopic(name, word))?, [n])?;
    }
    let sorted = |subscription, count| {
        let mut numbers = receive(subscription, count)?;
        numbers.sort_unstable();
        Ok::<_, String>(numbers)
    };
    expect(sorted(&all, 4)?, vec![1, 2, 3, 4])?;
    expect(sorted(&one, 1)?, vec![1])?;
    expect(sorted(&odom, 2)?, vec![2, 3])
}

/// Sends `count` messages to a subscription that is not read, and waits until they have arrived at another one.
fn fill(bus: &dyn Bus, name: &str, queue: QueuePolicy, count: i64) -> Result<Subscription, String> {
    let subscription = subscribe(bus, name, queue)?;
    let witness = subscribe(bus, name, EVERY)?;
    send(&mut *publisher(bus, name)?, 0..count)?;
    for _ in 0..count {
        next(&witness)?;
    }
    std::thread::sleep(SILENCE);
    Ok(subscription)
}

fn keeps_latest(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let subscription = fill(bus, name, QueuePolicy::Latest, 10)?;
    expect(receive(&subscription, 1)?, vec![9])?;
    expect(subscription.dropped(), 0)
}

fn drops_oldest(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let queue = QueuePolicy::All {
        size: 3,
        overflow: Overflow::DropOldest,
    };
    let subscription = fill(bus, name, queue, 10)?;
    expect(receive(&subscription, 3)?, vec![7, 8, 9])?;
    expect(subscription.dropped(), 7)
}

fn drops_newest(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let queue = QueuePolicy::All {
        size: 3,
        overflow: Overflow::DropNewest,
    };
    let subscription = fill(bus, name, queue, 10)?;
    expect(receive(&subscription, 3)?, vec![0, 1, 2])?;
    expect(subscription.dropped(), 7)
}

fn has_no_past(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let mut publisher = publisher(bus, name)?;
    send(&mut *publisher, [1])?;
    std::thread::sleep(SILENCE);
    let subscription = subscribe(bus, name, EVERY)?;
    send(&mut *publisher, [2])?;
    expect(receive(&subscription, 1)?, vec![2])
}

fn repeats_last(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let early = subscribe(bus, name, EVERY)?;
    let mut state = publisher_of(bus, name, PublishOptions::state().init(true))?;
    let mut event = publisher(bus, name)?;
    send(&mut *state, 1..=2)?;
    expect(receive(&early, 2)?, vec![1, 2])?;
    send(&mut *event, 3..=3)?;
    expect(receive(&early, 1)?, vec![3])?;
    let late = subscribe(bus, name, EVERY)?;
    bus.republish_retained();
    expect(receive(&late, 1)?, vec![2])?;
    bus.republish_retained();
    expect_silence(&late)?;
    expect_silence(&early)
}

fn forgets(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let (stays, leaves) = (subscribe(bus, name, EVERY)?, subscribe(bus, name, EVERY)?);
    let mut publisher = publisher(bus, name)?;
    send(&mut *publisher, [1])?;
    expect(receive(&leaves, 1)?, vec![1])?;
    drop(leaves);
    send(&mut *publisher, [2])?;
    expect(receive(&stays, 2)?, vec![1, 2])
}

fn never_stalls(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let small = QueuePolicy::All {
        size: 1,
        overflow: Overflow::DropNewest,
    };
    let _never_read = subscribe(bus, name, small)?;
    keeps_order(bus, name)
}

fn serve(bus: &dyn Bus, address: &str, size: usize) -> Result<ServedAddress, String> {
    bus.serve(address, size, Arc::new(Notifier::new()))
        .map_err(error_text)
}

fn call(bus: &dyn Bus, address: &str, n: i64, timeout: Duration) -> Result<PendingCall, String> {
    bus.call(address, request(n, timeout), Arc::new(Notifier::new()))
        .map_err(error_text)
}

fn request(n: i64, timeout: Duration) -> Request {
    Request::new(origin(), Payload::of(Datum::Int(n)), timeout)
}

/// The outcome of a call, in comparable form.
fn outcome(pending: PendingCall) -> Result<Option<i64>, CallFailure> {
    let payload = pending.wait()?;
    Ok(payload.to_datum().ok().and_then(|datum| datum.as_int()))
}

fn next_call(serving: &ServedAddress) -> Result<crate::request::IncomingCall, String> {
    let next = serving.next_within(CROSSING);
    next.ok_or_else(|| "a request did not come".to_owned())
}

fn answers(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let serving = serve(bus, name, 8)?;
    let (one, other) = (call(bus, name, 1, CROSSING)?, call(bus, name, 2, CROSSING)?);
    for _ in 0..2 {
        let call = next_call(&serving)?;
        expect(&*call.origin.source, "contract")?;
        let pending = call
            .argument
            .to_datum()
            .ok()
            .and_then(|datum| datum.as_int());
        call.reply(Ok(Payload::of(Datum::Int(pending.unwrap_or(0) * 10))));
    }
    // each call gets its own reply, in whichever order they are read
    expect(outcome(other), Ok(Some(20)))?;
    expect(outcome(one), Ok(Some(10)))
}

fn refuses(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let serving = serve(bus, name, 8)?;
    let pending = call(bus, name, 1, CROSSING)?;
    let refusal = Refusal {
        code: "NO_PATH".to_owned(),
        detail: "walls all around".to_owned(),
    };
    next_call(&serving)?.reply(Err(refusal.clone()));
    expect(outcome(pending), Err(CallFailure::Refused(refusal)))
}

fn times_out(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let serving = serve(bus, name, 8)?;
    let started = Instant::now();
    let pending = call(bus, name, 1, SILENCE)?;
    let unanswered = next_call(&serving)?;
    expect(outcome(pending), Err(CallFailure::Timeout))?;
    let waited = started.elapsed();
    unanswered.reply(Ok(Payload::of(Datum::Null)));
    if waited < SILENCE || waited > SILENCE + CROSSING {
        return Err(format!("the deadline of {SILENCE:?} came after {waited:?}"));
    }
    Ok(())
}

fn unavailable(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let pending = call(bus, name, 1, 2 * CROSSING)?;
    let started = Instant::now();
    expect(outcome(pending), Err(CallFailure::Unavailable))?;
    if started.elapsed() > CROSSING {
        return Err("it took as long as a deadline".to_owned());
    }
    Ok(())
}

fn stopped(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let serving = serve(bus, name, 8)?;
    let pending = call(bus, name, 1, 2 * CROSSING)?;
    next_call(&serving)?.complete(Err(CallFailure::Stopped));
    expect(outcome(pending), Err(CallFailure::Stopped))
}

fn server_leaves(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let serving = serve(bus, name, 8)?;
    let pending = call(bus, name, 1, CROSSING)?;
    std::thread::sleep(SILENCE);
    drop(serving);
    expect(outcome(pending), Err(CallFailure::Unavailable))?;
    // the address is free again
    serve(bus, name, 8).map(drop)
}

fn request_dropped(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let serving = serve(bus, name, 8)?;
    let pending = call(bus, name, 1, 2 * CROSSING)?;
    drop(next_call(&serving)?);
    expect(outcome(pending), Err(CallFailure::Unavailable))
}

fn one_server(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let _first = serve(bus, name, 8)?;
    let second = bus.serve(name, 8, Arc::new(Notifier::new()));
    let address = name.to_owned();
    expect(second.err(), Some(BusError::Served { address }))
}

fn bounds_requests(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let serving = serve(bus, name, 2)?;
    let calls: Result<Vec<_>, _> = (0..3).map(|n| call(bus, name, n, CROSSING)).collect();
    let mut calls = calls?;
    std::thread::sleep(SILENCE);
    let third = calls.pop().ok_or("no third call")?;
    expect(outcome(third), Err(CallFailure::Unavailable))?;
    for pending in calls {
        next_call(&serving)?.reply(Ok(Payload::of(Datum::Int(1))));
        expect(outcome(pending), Ok(Some(1)))?;
    }
    Ok(())
}

fn drops_expired(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let serving = serve(bus, name, 8)?;
    let pending = call(bus, name, 1, SILENCE)?;
    expect(outcome(pending), Err(CallFailure::Timeout))?;
    match serving.next_within(SILENCE) {
        None => Ok(()),
        Some(call) => Err(format!("an expired request was handed out: {call:?}")),
    }
}

fn takes_back(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let serving = serve(bus, name, 8)?;
    let pending = call(bus, name, 1, CROSSING)?;
    let call = next_call(&serving)?;
    pending.cancel();
    expect(outcome(pending), Err(CallFailure::Cancelled))?;
    let until = Instant::now() + CROSSING;
    while call.is_awaited() {
        if Instant::now() > until {
            return Err("the server was not notified of the cancellation".to_owned());
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    Ok(())
}

fn tells(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let tell = |n| {
        bus.call_one_way(name, request(n, CROSSING), Arc::new(Notifier::new()))
            .map_err(error_text)
    };
    expect(outcome(tell(0)?), Err(CallFailure::Unavailable))?;
    let serving = serve(bus, name, 8)?;
    expect(outcome(tell(1)?), Ok(None))?;
    let call = next_call(&serving)?;
    expect(call.is_one_way(), true)?;
    // dropping the pending call does not cancel a one-way request
    drop(tell(2)?);
    let argument = next_call(&serving)?.argument.to_datum();
    expect(argument.ok().and_then(|datum| datum.as_int()), Some(2))
}

fn calls_back(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let back = subtopic(name, "back");
    let (serving, hearing) = (serve(bus, name, 8)?, serve(bus, &back, 8)?);
    let request = request(1, CROSSING).with_callback(&*back);
    let pending = bus
        .call(name, request, Arc::new(Notifier::new()))
        .map_err(error_text)?;
    let call = next_call(&serving)?;
    let callback = call.callback.clone().ok_or("no callback came")?;
    call.reply(Ok(Payload::of(Datum::Int(2))));
    expect(outcome(pending), Ok(Some(2)))?;
    let later = self::request(3, CROSSING);
    let pending = bus
        .call_one_way(&callback, later, Arc::new(Notifier::new()))
        .map_err(error_text)?;
    expect(outcome(pending), Ok(None))?;
    let argument = next_call(&hearing)?.argument.to_datum();
    expect(argument.ok().and_then(|datum| datum.as_int()), Some(3))
}

fn carries_trace(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let subscription = subscribe(bus, name, EVERY)?;
    let mut publisher = publisher(bus, name)?;
    let cause = SpanGenerator::new("somebody", 1, "elsewhere").of(1, None);
    let spans = SpanGenerator::new(&origin().source, origin().incarnation, name);
    for (number, cause) in (1..).zip([Some(cause), None]) {
        publisher
            .publish_traced(0, Payload::of(Datum::Int(1)), cause)
            .map_err(error_text)?;
        let trace = next(&subscription)?.trace;
        expect(trace, Some(spans.of(number, cause)))?;
    }
    let address = subtopic(name, "served");
    let serving = serve(bus, &address, 1)?;
    let request = request(1, CROSSING).with_trace(cause);
    let _pending = bus
        .call(&address, request, Arc::new(Notifier::new()))
        .map_err(error_text)?;
    expect(next_call(&serving)?.trace, Some(cause))
}

fn confirms(bus: &dyn Bus, name: &str) -> Result<(), String> {
    let subscription = subscribe(bus, name, EVERY)?;
    let sending = PublishOptions::events(NonZeroUsize::MIN.saturating_add(999));
    let mut publisher = publisher_of(bus, name, sending)?;
    send(&mut *publisher, 0..300)?;
    expect(bus.drain(CROSSING), true)?;
    let sent = publisher.counts();
    expect(
        (sent.published, sent.accepted, sent.pending()),
        (300, 300, 0),
    )?;
    expect(receive(&subscription, 300)?, (0..300).collect())
}

fn is_well(bus: &dyn Bus, _: &str) -> Result<(), String> {
    expect(bus.health().is_up(), true)
}
