//! The local bus passes the contract suite.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::sync::Arc;
use std::time::Duration;

use asmotion_bus::{
    Bus, BusError, Health, LocalBus, Notifier, Overflow, Pattern, Payload, PendingCall,
    PublishOptions, Publisher, PublisherCounts, QueuePolicy, Request, SenderId, ServedAddress,
    Subscription, contract,
};
use asmotion_datum::{Datum, Message};

#[test]
fn t29_the_local_bus_keeps_the_contract() {
    assert_eq!(contract::violations(&LocalBus::new(), "here"), []);
}

/// A faulty bus: of any three messages, it drops one and duplicates another.
struct Forgetful(LocalBus);

struct ForgetfulPublisher(Box<dyn Publisher>, u64);

impl Publisher for ForgetfulPublisher {
    fn publish_traced(
        &mut self,
        stamp: i64,
        payload: Payload,
        _: Option<asmotion_bus::TraceContext>,
    ) -> Result<(), BusError> {
        self.1 += 1;
        match self.1 % 3 {
            0 => Ok(()),
            1 => self.0.publish(stamp, payload),
            _ => {
                self.0.publish(stamp, payload.clone())?;
                self.0.publish(stamp, payload)
            }
        }
    }

    fn counts(&self) -> PublisherCounts {
        self.0.counts()
    }
}

impl Bus for Forgetful {
    fn publisher(
        &self,
        topic: &str,
        origin: &SenderId,
        schema: &asmotion_datum::Schema,
        sending: PublishOptions,
    ) -> Result<Box<dyn Publisher>, BusError> {
        let inner = self.0.publisher(topic, origin, schema, sending)?;
        Ok(Box::new(ForgetfulPublisher(inner, 0)))
    }

    fn subscribe(
        &self,
        reader: &str,
        pattern: &Pattern,
        queue: QueuePolicy,
        notifier: Arc<Notifier>,
    ) -> Result<Subscription, BusError> {
        self.0.subscribe(reader, pattern, queue, notifier)
    }

    fn serve(
        &self,
        address: &str,
        size: usize,
        notifier: Arc<Notifier>,
    ) -> Result<ServedAddress, BusError> {
        self.0.serve(address, size, notifier)
    }

    fn call(
        &self,
        address: &str,
        mut request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        request.timeout = Duration::ZERO;
        self.0.call(address, request, notifier)
    }

    fn call_one_way(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        self.0.call(address, request, notifier)
    }

    fn health(&self) -> Health {
        self.0.health()
    }

    fn notify_on_change(&self, notifier: &Arc<Notifier>) {
        self.0.notify_on_change(notifier);
    }

    fn republish_retained(&self) {
        self.0.republish_retained();
    }

    fn drain(&self, at_most: Duration) -> bool {
        self.0.drain(at_most)
    }
}

#[test]
fn the_contract_finds_out_a_bus_that_breaks_it() {
    let violations = contract::violations(&Forgetful(LocalBus::new()), "here");
    let cases: Vec<_> = violations.iter().map(|violation| violation.case).collect();
    for case in [
        "keeps the order of a publisher",
        "gives every subscriber every message",
        "drops the oldest and counts",
        "answers a request",
        "ends a call at its deadline",
        "sends a one-way call without waiting",
    ] {
        assert!(cases.contains(&case), "{case} is not among {cases:?}");
    }
}

#[test]
fn one_notifier_wakes_for_several_subscriptions() {
    let bus = LocalBus::new();
    let notifier = Arc::new(Notifier::new());
    let all = QueuePolicy::All {
        size: 8,
        overflow: Overflow::DropOldest,
    };
    let a = bus
        .subscribe("Tester", &Pattern::new("a"), all, Arc::clone(&notifier))
        .unwrap();
    let b = bus
        .subscribe("Tester", &Pattern::new("b"), all, Arc::clone(&notifier))
        .unwrap();
    let publishing = std::thread::spawn(move || {
        let origin = SenderId::new("Elsewhere", 1);
        std::thread::sleep(Duration::from_millis(50));
        let mut publisher = bus
            .publisher("b", &origin, Datum::schema(), PublishOptions::default())
            .unwrap();
        publisher.publish(0, Payload::of(Datum::Int(1))).unwrap();
    });
    assert!(notifier.wait(Duration::from_secs(10)));
    assert!(a.try_next().is_none());
    assert!(b.try_next().is_some());
    publishing.join().unwrap();
}

#[test]
fn payloads_are_shared_not_copied() {
    let bus = LocalBus::new();
    let subscription = bus
        .subscribe(
            "Tester",
            &Pattern::all(),
            QueuePolicy::Latest,
            Arc::new(Notifier::new()),
        )
        .unwrap();
    let sample: Arc<dyn asmotion_datum::Sample> = Arc::new(Datum::text("a big map"));
    let mut publisher = bus
        .publisher(
            "map",
            &SenderId::new("Maps", 1),
            Datum::schema(),
            PublishOptions::default(),
        )
        .unwrap();
    publisher
        .publish(0, Payload::Sample(Arc::clone(&sample)))
        .unwrap();
    let Some(Payload::Sample(came)) = subscription.try_next().map(|envelope| envelope.payload)
    else {
        unreachable!("a sample was published");
    };
    assert!(Arc::ptr_eq(&came, &sample));
}

#[test]
fn the_age_of_a_message_includes_its_time_in_the_queue() {
    let bus = LocalBus::new();
    let notifier = Arc::new(Notifier::new());
    let subscription = bus
        .subscribe(
            "reader",
            &Pattern::new("odom"),
            QueuePolicy::Latest,
            notifier,
        )
        .unwrap();
    let origin = SenderId::new("Driver", 1);
    let mut publisher = bus
        .publisher("odom", &origin, Datum::schema(), PublishOptions::default())
        .unwrap();
    publisher.publish(0, Payload::of(Datum::Int(1))).unwrap();
    std::thread::sleep(Duration::from_millis(50));
    let waited = subscription.try_next().unwrap().age;
    assert!(waited >= Duration::from_millis(50), "{waited:?}");
    publisher.publish(0, Payload::of(Datum::Int(2))).unwrap();
    let fresh = subscription.try_next().unwrap().age;
    assert!(fresh < Duration::from_millis(50), "{fresh:?}");
}
