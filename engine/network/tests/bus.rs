//! A system's topics on a bus: tools subscribe, and other processes take part.

use std::sync::Arc;
use std::time::Duration;

use crate::common::{Number, Words, behaviour, counter, number};
use asmotion_bus::{
    Bus, LocalBus, Notifier, Overflow, Pattern, Payload, PublishOptions, QueuePolicy, SenderId,
    Subscription,
};
use asmotion_component::{Activity, Component, Interface, OnStale, Policy, Span, Time};
use asmotion_datum::{Codec, Datum, Message};
use asmotion_network::Network;
use asmotion_runtime::{Event, Log, Run, System};

fn all(bus: &LocalBus, pattern: &str) -> Subscription {
    let queue = QueuePolicy::All {
        size: 64,
        overflow: Overflow::DropOldest,
    };
    bus.subscribe(
        "Tester",
        &Pattern::new(pattern),
        queue,
        Arc::new(Notifier::new()),
    )
    .unwrap()
}

/// Reports every number it reads.
fn telling() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let input = interface.input::<Number>("n", "numbers");
        move |cycle| {
            let heard: Vec<_> = cycle.all(input).iter().map(|sample| sample.n).collect();
            for n in heard {
                cycle.report("heard", Datum::Int(n));
            }
            Ok(())
        }
    })
}

/// A counter and a reader on topic `numbers`, attached to a bus.
fn attached(incarnation: u64, bus: &LocalBus) -> (System, Log) {
    attached_with(Policy::buffer(16), incarnation, bus)
}

fn attached_with(policy: Policy, incarnation: u64, bus: &LocalBus) -> (System, Log) {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    system.add("Teller", Activity::event(), telling()).unwrap();
    system.publish("Counter.n", "numbers").unwrap();
    system.subscribe("numbers", "Teller.n", policy).unwrap();
    Network::new()
        .attach(&mut system, Arc::new(bus.clone()), incarnation)
        .unwrap();
    (system, log)
}

#[test]
fn a_tool_hears_every_topic_without_being_declared() {
    let bus = LocalBus::new();
    let tool = all(&bus, "#");
    let (system, _) = attached(7, &bus);
    system.simulate().run_until(Time::ZERO + 20.ms());
    let envelopes: Vec<_> = std::iter::from_fn(|| tool.try_next()).collect();
    assert_eq!(envelopes.len(), 3);
    let last = &envelopes[2];
    assert_eq!(
        (&*last.topic, &*last.source, &*last.type_name),
        ("numbers", "Counter", "test/Number")
    );
    assert_eq!(
        (last.incarnation, last.sequence, last.stamp),
        (7, 3, 20_000_000)
    );
    assert_eq!(last.payload.read::<Number>().unwrap(), number(3));
}

#[test]
fn what_is_published_inside_is_heard_once() {
    let bus = LocalBus::new();
    let (system, log) = attached(7, &bus);
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 20.ms());
    assert_eq!(log.lines_with("heard").len(), 3);
}

#[test]
fn what_others_publish_comes_in_typed_or_encoded_and_what_does_not_fit_is_counted() {
    let bus = LocalBus::new();
    let (system, log) = attached(7, &bus);
    let mut run = system.simulate();
    run.transition("Counter", asmotion_component::Transition::Stop)
        .unwrap();
    let mut elsewhere = bus
        .publisher(
            "numbers",
            &SenderId::new("Elsewhere", 8),
            Number::schema(),
            PublishOptions::default(),
        )
        .unwrap();
    let encoded = |value: Datum| Payload::Bytes {
        codec: Codec::Json,
        bytes: Codec::Json.encode(&value, Datum::schema()).unwrap().into(),
    };
    let garbage = Payload::Bytes {
        codec: Codec::Cbor,
        bytes: Arc::from([0xff, 0x00]),
    };
    for payload in [
        Payload::of(number(100)),
        encoded(Datum::record([("n", Datum::Int(101))])),
        Payload::of(Words::default()),
        garbage,
    ] {
        elsewhere.publish(0, payload).unwrap();
    }
    run.run_for(1.ms());
    assert_eq!(
        log.lines_with("heard"),
        ["0 s Teller: heard: 100", "0 s Teller: heard: 101"]
    );
    let dropped = log.lines_with("dropped");
    assert!(
        dropped[0].contains("1 dropped: unknown field `words`"),
        "{dropped:?}"
    );
    assert!(
        dropped[1].contains("2 dropped: malformed CBOR"),
        "{dropped:?}"
    );
}

#[test]
fn what_is_lost_on_its_way_in_is_seen() {
    let bus = LocalBus::new();
    let (system, log) = attached(7, &bus);
    let mut run = system.simulate();
    run.transition("Counter", asmotion_component::Transition::Stop)
        .unwrap();
    let mut elsewhere = bus
        .publisher(
            "numbers",
            &SenderId::new("Elsewhere", 8),
            Number::schema(),
            PublishOptions::default(),
        )
        .unwrap();
    for n in 0..300 {
        elsewhere.publish(0, Payload::of(number(n))).unwrap();
    }
    run.run_for(1.ms());
    // 300 - 256 on the way, and of those 256 all but 16 at the port
    let dropped = log.lines_with("dropped");
    let last = dropped.last().unwrap();
    assert!(last.contains("284 dropped"), "{last}");
}

#[test]
fn a_buffer_keeps_the_oldest_messages_of_a_bus_and_a_circular_buffer_the_newest() {
    for (policy, first) in [(Policy::buffer(16), 0), (Policy::circular(16), 284)] {
        let bus = LocalBus::new();
        let (system, log) = attached_with(policy, 7, &bus);
        let mut run = system.simulate();
        run.transition("Counter", asmotion_component::Transition::Stop)
            .unwrap();
        let mut elsewhere = bus
            .publisher(
                "numbers",
                &SenderId::new("Elsewhere", 8),
                Number::schema(),
                PublishOptions::default(),
            )
            .unwrap();
        for n in 0..300 {
            elsewhere.publish(0, Payload::of(number(n))).unwrap();
        }
        run.run_for(1.ms());
        let heard = log.lines_with("heard");
        let expected = (first..first + 16).map(|n| format!("0 s Teller: heard: {n}"));
        assert_eq!(heard, expected.collect::<Vec<_>>());
    }
}

#[test]
fn what_comes_in_is_kept_by_the_subscribers_policy() {
    let bus = LocalBus::new();
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("Teller", Activity::periodic(100.ms()), telling())
        .unwrap();
    let policy = Policy::data().max_age(150.ms()).on_stale(OnStale::Zero);
    system.subscribe("numbers", "Teller.n", policy).unwrap();
    Network::new()
        .attach(&mut system, Arc::new(bus.clone()), 7)
        .unwrap();
    let mut run = system.simulate();
    let mut elsewhere = bus
        .publisher(
            "numbers",
            &SenderId::new("Elsewhere", 8),
            Number::schema(),
            PublishOptions::default(),
        )
        .unwrap();
    for n in 1..=3 {
        elsewhere.publish(0, Payload::of(number(n))).unwrap();
    }
    run.run_for(1.s());
    assert_eq!(
        log.lines_with("heard"),
        ["0 s Teller: heard: 3", "0.2 s Teller: heard: 0"]
    );
}

#[test]
fn two_live_systems_talk_over_a_bus() {
    let bus = LocalBus::new();
    let (one, _) = attached(7, &bus);
    let mut other = System::new();
    other.add("Teller", Activity::event(), telling()).unwrap();
    other
        .subscribe("numbers", "Teller.n", Policy::buffer(16))
        .unwrap();
    Network::new()
        .attach(&mut other, Arc::new(bus.clone()), 8)
        .unwrap();
    let mut other = other.live();
    let one = one.live();
    let mut heard = 0;
    let mut enough = |_: Time, event: &Event<'_>| {
        heard += i32::from(matches!(event, Event::Report { kind: "heard", .. }));
        heard >= 5
    };
    assert!(other.run_until_event(Time::ZERO + Duration::from_secs(20), &mut enough));
    drop(one);
}

#[test]
fn what_follows_from_a_message_is_in_its_trace() {
    let bus = LocalBus::new();
    let mut system = System::new();
    let relay = behaviour(|interface| {
        let from = interface.input::<Number>("from", "");
        let to = interface.output::<Number>("to", "");
        move |cycle| {
            for number in cycle.all(from).to_vec() {
                cycle.write(to, number);
            }
            Ok(())
        }
    });
    system.add("Relay", Activity::event(), relay).unwrap();
    system
        .subscribe("asked", "Relay.from", Policy::buffer(4))
        .unwrap();
    system.publish("Relay.to", "told").unwrap();
    Network::new()
        .attach(&mut system, Arc::new(bus.clone()), 7)
        .unwrap();
    let mut run = system.simulate();
    let told = all(&bus, "told");
    let origin = SenderId::new("Elsewhere", 8);
    let schema = Number::schema();
    let mut elsewhere = bus
        .publisher("asked", &origin, schema, PublishOptions::default())
        .unwrap();
    let mut spans = Vec::new();
    for cause in 1..=2 {
        let cause = asmotion_bus::TraceContext { id: cause, span: 9 };
        elsewhere
            .publish_traced(0, Payload::of(number(1)), Some(cause))
            .unwrap();
        run.run_for(1.ms());
        let trace = told.try_next().unwrap().trace.unwrap();
        assert_eq!(trace.id, cause.id);
        spans.push(trace.span);
    }
    let relay = asmotion_bus::SpanGenerator::new("Relay", 7, "told");
    assert_eq!(spans, [1, 2].map(|number| relay.of(number, None).span));
}
