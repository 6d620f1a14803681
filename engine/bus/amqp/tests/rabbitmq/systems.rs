//! Two systems, as two processes would be: their topics meet on a broker.

use std::sync::Arc;
use std::time::Duration;

use bus::{Payload, Sending};
use component::{
    Activity, Component, Cycle, Event, Fault, In, Out, Policy, Run, Span, System, Time,
};
use datum::{Codec, Datum};

use crate::common::{LONG, all, connect, events, eventually, settings, subscribe};

datum::message! {
    /// A count.
    pub struct Count = "test/Count" {
        /// so far
        pub count: i64,
    }
}

/// Counts, one a cycle.
struct Counter {
    count: i64,
    out: Out<Count>,
}

impl Component for Counter {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.count += 1;
        cycle.write(self.out, Count { count: self.count });
        Ok(())
    }
}

/// Reports what it reads.
struct Teller(In<Count>);

impl Component for Teller {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let heard: Vec<_> = cycle.all(self.0).iter().map(|count| count.count).collect();
        for count in heard {
            cycle.report("heard", Datum::Int(count));
        }
        Ok(())
    }
}

/// A system that counts, on a bus of its own.
fn counting(url: &str, sending: Sending) -> System {
    let mut system = System::new();
    let counter = |interface: &mut component::Interface| {
        let out = interface.output("out", "the count");
        Box::new(Counter { count: 0, out }) as Box<dyn Component>
    };
    (system.add("Counter", Activity::periodic(20.ms()), counter)).unwrap();
    system.publish("Counter.out", "counts").unwrap();
    system.sending("counts", sending);
    system.attach(Arc::new(connect(settings(url))), 1).unwrap();
    system
}

/// A system of components that tell what the other counts, on a bus of its own.
fn telling(url: &str, names: &[&str]) -> System {
    let mut system = System::new();
    for name in names {
        let teller = |interface: &mut component::Interface| {
            Box::new(Teller(interface.input("in", "counts"))) as Box<dyn Component>
        };
        system.add(name, Activity::event(), teller).unwrap();
        let end = format!("{name}.in");
        (system.subscribe("counts", &end, Policy::buffer(1000))).unwrap();
    }
    system.attach(Arc::new(connect(settings(url))), 2).unwrap();
    system
}

#[test]
fn a_topic_by_cdr_is_read_by_its_type() {
    let Some(broker) = broker::calm() else { return };
    let vhost = broker.vhost().unwrap();
    let spy = connect(settings(&vhost.url()));
    let seen = subscribe(&spy, "counts", all(1000));
    let mut above = telling(&vhost.url(), &["Teller"]).live();
    let _on_board = counting(&vhost.url(), events().by(Codec::Cdr)).live();
    let mut heard = |_: Time, event: &Event<'_>| matches!(event, Event::Report { kind: "heard", what, .. } if what.as_int() == Some(3));
    assert!(above.run_until_event(Time::ZERO + LONG, &mut heard));
    let envelope = seen.next_within(LONG).unwrap();
    let Payload::Bytes { codec, bytes } = &envelope.payload else {
        panic!("{envelope:?}");
    };
    assert_eq!(*codec, Codec::Cdr);
    assert_eq!(**bytes, [0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]);
    assert!(
        envelope.payload.to_datum().is_err(),
        "it does not say what it is"
    );
    assert_eq!(envelope.payload.read::<Count>().unwrap().count, 1);
}

#[test]
fn each_component_has_a_queue_of_its_own_for_a_topic() {
    let Some(broker) = broker::calm() else { return };
    let vhost = broker.vhost().unwrap();
    let above = telling(&vhost.url(), &["One", "Other"]).live();
    let mut queues = vhost.queues().unwrap();
    queues.sort();
    let names: Vec<_> = (queues.iter())
        .map(|queue| queue.split('.').take(3).collect::<Vec<_>>().join("."))
        .collect();
    assert_eq!(names, ["asmotion.One.counts", "asmotion.Other.counts"]);
    drop(above);
    eventually("they are gone", || vhost.queues().unwrap().is_empty());
}

#[test]
fn events_between_two_systems_outlive_the_broker() {
    let Some(broker) = broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let mut above = telling(&vhost.url(), &["Teller"]).live();
    let on_board = counting(&vhost.url(), events()).live();
    let mut heard = Vec::new();
    let mut until = |count: usize, heard: &mut Vec<i64>| {
        let mut enough = |_: Time, event: &Event<'_>| {
            if let Event::Report {
                kind: "heard",
                what,
                ..
            } = event
            {
                heard.extend(what.as_int());
            }
            heard.len() >= count
        };
        above.run_until_event(Time::ZERO + Duration::from_secs(120), &mut enough)
    };
    assert!(until(20, &mut heard));
    broker.kill().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    broker.revive().unwrap();
    assert!(until(300, &mut heard));
    drop(on_board);
    let counted: Vec<_> = (1..=i64::try_from(heard.len()).unwrap()).collect();
    assert_eq!(heard, counted, "none lost, none twice, in order");
}
