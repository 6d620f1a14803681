//! Two systems, as in two processes, whose topics are connected through a broker.

use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_bus::{Payload, PublishOptions};
use asmotion_component::{
    Activity, Component, Cycle, Fault, In, Operation, Out, Policy, Provided, Required, Span, Time,
    Wire,
};
use asmotion_datum::{Codec, Datum};
use asmotion_network::{Network, OuterName};
use asmotion_runtime::{Change, ComponentAddition, Event, Run, System};

use crate::common::{LONG, all, connect, events, eventually, is_down, settings, subscribe};

asmotion_datum::message! {
    /// A count.
    pub struct Count = "test/Count" {
        /// so far
        pub count: i64,
    }
}

/// Writes a count in each cycle.
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

/// Reports each count it reads.
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

/// A system with a counter, on its own bus.
fn counting(url: &str, sending: PublishOptions) -> System {
    let mut system = System::new();
    let counter = |interface: &mut asmotion_component::Interface| {
        let out = interface.output("out", "the count");
        Box::new(Counter { count: 0, out }) as Box<dyn Component>
    };
    system
        .add("Counter", Activity::periodic(20.ms()), counter)
        .unwrap();
    system.publish("Counter.out", "counts").unwrap();
    let mut network = Network::new();
    network.set_publish_options("counts", sending);
    let bus = Arc::new(connect(settings(url)));
    network.attach(&mut system, bus, 1).unwrap();
    system
}

/// A system of components that report the other system's count, on its own bus.
fn telling(url: &str, names: &[&str]) -> System {
    let mut system = System::new();
    for name in names {
        let teller = |interface: &mut asmotion_component::Interface| {
            Box::new(Teller(interface.input("in", "counts"))) as Box<dyn Component>
        };
        system.add(name, Activity::event(), teller).unwrap();
        let end = format!("{name}.in");
        system
            .subscribe("counts", &end, Policy::buffer(1000))
            .unwrap();
    }
    let bus = Arc::new(connect(settings(url)));
    Network::new().attach(&mut system, bus, 2).unwrap();
    system
}

/// Replies with the request.
struct Echo;

impl Operation for Echo {
    type Request = Count;
    type Response = Count;
    const INTERFACE: &'static str = "test/Echo";
    const NAME: &'static str = "echo";
}

/// Calls once, and reports the outcome.
struct Asker {
    echo: Required<Echo>,
    asked: bool,
}

impl Component for Asker {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if !std::mem::replace(&mut self.asked, true) {
            cycle.call(self.echo, Count { count: 7 });
        }
        for reply in cycle.replies(self.echo) {
            let said = match reply.result {
                Ok(count) => Datum::Int(count.count),
                Err(error) => Datum::text(error.to_string()),
            };
            cycle.report("replied", said);
        }
        Ok(())
    }
}

/// Replies to the third request, and ignores those before.
struct Sleepy {
    echo: Provided<Echo>,
    requests: i64,
}

impl Component for Sleepy {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for request in cycle.requests(self.echo) {
            self.requests += 1;
            if self.requests == 3 {
                cycle.reply(self.echo, request.id, Ok(request.argument));
            }
        }
        Ok(())
    }
}

#[test]
fn a_call_is_tried_again_over_the_broker() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = || Arc::new(connect(settings(&vhost.url())));
    let mut on_board = System::new();
    let sleepy = |interface: &mut asmotion_component::Interface| {
        let echo = interface.serve("echoing", "now and then");
        Box::new(Sleepy { echo, requests: 0 }) as Box<dyn Component>
    };
    on_board.add("Sleepy", Activity::event(), sleepy).unwrap();
    let mut network = Network::new();
    network.offer(&on_board, "Sleepy.echoing").unwrap();
    network.attach(&mut on_board, bus(), 1).unwrap();
    let mut above = System::new();
    let asker = |interface: &mut asmotion_component::Interface| {
        let echo = interface.require("echo", "a number");
        let asked = false;
        Box::new(Asker { echo, asked }) as Box<dyn Component>
    };
    above.add("Asker", Activity::event(), asker).unwrap();
    let wire = Wire {
        timeout: Duration::from_secs(1),
        retries: 2,
        backoff: Duration::ZERO,
        cancel_on_timeout: true,
        one_way: false,
        alternative: 0,
    };
    let mut network = Network::new();
    network
        .wire_remote(&mut above, "Asker.echo", "Sleepy.echoing", wire)
        .unwrap();
    network.attach(&mut above, bus(), 2).unwrap();
    let _on_board = on_board.live();
    let mut attempts = Vec::new();
    let mut said = None;
    let mut replied = |_: Time, event: &Event<'_>| {
        if let Event::Called { attempt, .. } = event {
            attempts.push(*attempt);
        }
        if let Event::Report { data: what, .. } = event {
            said = Some((*what).clone());
        }
        said.is_some()
    };
    assert!(
        above
            .live()
            .run_until_event(Time::ZERO + LONG, &mut replied)
    );
    assert_eq!(said, Some(Datum::Int(7)));
    // the first attempts may precede the observer
    assert_eq!(attempts.last(), Some(&3));
}

/// A system that calls once, with this timeout, on its own bus.
fn asking(url: &str, timeout: Duration) -> System {
    let mut system = System::new();
    let asker = |interface: &mut asmotion_component::Interface| {
        let echo = interface.require("echo", "a number");
        let asked = false;
        Box::new(Asker { echo, asked }) as Box<dyn Component>
    };
    system
        .add("Asker", Activity::periodic(20.ms()), asker)
        .unwrap();
    let wire = Wire {
        timeout,
        retries: 0,
        backoff: Duration::ZERO,
        cancel_on_timeout: true,
        one_way: false,
        alternative: 0,
    };
    let mut network = Network::new();
    network
        .wire_remote(&mut system, "Asker.echo", "Sleepy.echoing", wire)
        .unwrap();
    let bus = Arc::new(connect(settings(url)));
    network.attach(&mut system, bus, 2).unwrap();
    system
}

/// A system that replies to each request, on its own bus.
fn echoing(url: &str) -> System {
    let mut system = System::new();
    let awake = |interface: &mut asmotion_component::Interface| {
        let echo = interface.serve("echoing", "at once");
        Box::new(Sleepy { echo, requests: 2 }) as Box<dyn Component>
    };
    system.add("Sleepy", Activity::event(), awake).unwrap();
    let mut network = Network::new();
    network.offer(&system, "Sleepy.echoing").unwrap();
    let bus = Arc::new(connect(settings(url)));
    network.attach(&mut system, bus, 1).unwrap();
    system
}

/// Runs a system until its call has an outcome.
fn outcome(system: System) -> Option<Datum> {
    let mut outcome = None;
    let mut is_over = |_: Time, event: &Event<'_>| {
        if let Event::Report { data, .. } = event {
            outcome = Some((*data).clone());
        }
        outcome.is_some()
    };
    system
        .live()
        .run_until_event(Time::ZERO + LONG, &mut is_over);
    outcome
}

#[test]
fn a_call_waits_for_a_provider_whose_process_starts_later() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let late = Duration::from_millis(1500);
    for delay in [Duration::ZERO, late] {
        let vhost = broker.vhost().unwrap();
        let url = vhost.url();
        let (end, ended) = std::sync::mpsc::channel::<()>();
        let provider = std::thread::spawn(move || {
            std::thread::sleep(delay);
            let _provider = echoing(&url).live();
            // until the sender is dropped
            let _ = ended.recv();
        });
        let caller = asking(&vhost.url(), LONG);
        let begun = Instant::now();
        assert_eq!(outcome(caller), Some(Datum::Int(7)), "{delay:?}");
        assert!(begun.elapsed() < delay + LONG / 2, "{:?}", begun.elapsed());
        drop(end);
        provider.join().unwrap();
    }
}

#[test]
fn a_call_whose_provider_never_starts_ends_as_unavailable_before_its_deadline() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let caller = asking(&vhost.url(), Duration::from_secs(3));
    let expected = asmotion_component::CallError::Unavailable.to_string();
    assert_eq!(outcome(caller), Some(Datum::text(expected)));
}

#[test]
fn a_topic_by_cdr_is_read_by_its_type() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let spy = connect(settings(&vhost.url()));
    let seen = subscribe(&spy, "counts", all(1000));
    let mut above = telling(&vhost.url(), &["Teller"]).live();
    let _on_board = counting(&vhost.url(), events().with_codec(Codec::Cdr)).live();
    let mut heard = |_: Time, event: &Event<'_>| matches!(event, Event::Report { kind: "heard", data, .. } if data.as_int() == Some(3));
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
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let above = telling(&vhost.url(), &["One", "Other"]).live();
    let mut queues = vhost.queues().unwrap();
    queues.sort();
    let names: Vec<_> = queues
        .iter()
        .map(|queue| queue.split('.').take(3).collect::<Vec<_>>().join("."))
        .collect();
    assert_eq!(names, ["asmotion.One.counts", "asmotion.Other.counts"]);
    drop(above);
    eventually("they are gone", || vhost.queues().unwrap().is_empty());
}

#[test]
fn events_between_two_systems_outlive_the_broker() {
    let Some(broker) = asmotion_broker::alone() else {
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
                data: what,
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

#[test]
fn ends_that_are_joined_or_parted_while_the_broker_is_away_are_so_when_it_is_back() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let _there = counting(&vhost.url(), events()).live();
    let mut system = System::new();
    let bus = Arc::new(connect(settings(&vhost.url())));
    let mut network = Network::new();
    let attached: Arc<dyn asmotion_bus::Bus> = bus.clone();
    network.attach(&mut system, attached, 2).unwrap();
    let running = network.running();
    let mut run = system.live();
    let is_away = || {
        broker.kill().unwrap();
        eventually("it is away", || is_down(&bus));
    };
    let has_queue = || {
        let queues = vhost.queues().unwrap();
        queues.iter().any(|it| it.contains("Late"))
    };

    is_away();
    let name = OuterName {
        id: "Late",
        bus: None,
    };
    let end = running.subscribe(name, "counts", "Late.in", Policy::buffer(1000));
    let teller = |interface: &mut asmotion_component::Interface| {
        let teller = Teller(interface.input("in", "counts"));
        Ok(Box::new(teller) as Box<dyn Component>)
    };
    let by = ComponentAddition::new("a teller", Activity::event(), teller).joined(end.unwrap());
    let component = "Late".to_owned();
    run.change(&[Change::Add { component, by }]).unwrap();
    broker.revive().unwrap();
    let limit = run.now() + LONG;
    let mut hears =
        |_: Time, event: &Event<'_>| matches!(event, Event::Report { kind: "heard", .. });
    assert!(run.run_until_event(limit, &mut hears));
    assert!(has_queue());

    is_away();
    let component = "Late".to_owned();
    run.change(&[Change::Remove { component }]).unwrap();
    broker.revive().unwrap();
    // the queue has survived the broker
    eventually("it is back", || !is_down(&bus));
    eventually("the queue is gone", || !has_queue());
}
