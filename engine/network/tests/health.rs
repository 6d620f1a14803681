//! The state of the bus as a topic.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::common::{Number, behaviour, counter};
use asmotion_bus::{
    Bus, BusError, Health, LinkState, LocalBus, Notifier, Pattern, PendingCall, PublishOptions,
    Publisher, QueuePolicy, Request, SenderId, ServedAddress, Subscription,
};
use asmotion_component::{
    Activity, BusHealth, Component, HEALTH_TOPIC, Interface, Policy, Span, Time,
};
use asmotion_datum::Datum;
use asmotion_network::Network;
use asmotion_runtime::{BuildError, Event, Log, Run, System};

/// Reports the states of the bus.
fn watcher() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let health = interface.input::<BusHealth>("bus", "how it is");
        move |cycle| {
            for health in cycle.all(health).to_vec() {
                let said = format!("{} {}", health.state, health.reason);
                cycle.report("health", Datum::Text(said));
            }
            Ok(())
        }
    })
}

fn watched() -> (System, Log) {
    let (mut system, log) = (System::new(), Log::new());
    system.observe(log.clone());
    system.add("Watcher", Activity::event(), watcher()).unwrap();
    let policy = Policy::buffer(16);
    system
        .subscribe(HEALTH_TOPIC, "Watcher.bus", policy)
        .unwrap();
    (system, log)
}

fn said(event: &Event<'_>) -> Option<String> {
    let Event::Report {
        kind: "health",
        data: what,
        ..
    } = event
    else {
        return None;
    };
    what.as_text().map(str::to_owned)
}

/// The states of the bus that a system reports within a second.
fn heard(mut system: System) -> Vec<String> {
    let heard = Arc::new(Mutex::new(Vec::new()));
    let ear = Arc::clone(&heard);
    system.observe(move |_: Time, event: &Event<'_>| ear.lock().unwrap().extend(said(event)));
    system.simulate().run_for(1.s());
    heard.lock().unwrap().clone()
}

#[test]
fn a_system_is_told_once_that_its_bus_is_up_and_so_is_one_without() {
    assert_eq!(heard(watched().0), ["UP "]);
    let (mut system, _) = watched();
    let bus = LocalBus::new();
    let tool = bus
        .subscribe(
            "Tester",
            &Pattern::new("#"),
            QueuePolicy::Latest,
            Arc::new(Notifier::new()),
        )
        .unwrap();
    Network::new()
        .attach(&mut system, Arc::new(bus), 1)
        .unwrap();
    assert_eq!(heard(system), ["UP "]);
    assert!(tool.try_next().is_none(), "it stays inside");
}

/// A bus whose state the test sets.
#[derive(Clone)]
struct Moody {
    bus: LocalBus,
    health: Arc<Mutex<Health>>,
    notifier: Arc<Mutex<Option<Arc<Notifier>>>>,
}

impl Moody {
    fn set(&self, link: LinkState) {
        *self.health.lock().unwrap() = Health::now(link);
        self.notifier.lock().unwrap().as_ref().unwrap().notify();
    }
}

impl Bus for Moody {
    fn publisher(
        &self,
        topic: &str,
        origin: &SenderId,
        schema: &asmotion_datum::Schema,
        sending: PublishOptions,
    ) -> Result<Box<dyn Publisher>, BusError> {
        self.bus.publisher(topic, origin, schema, sending)
    }

    fn subscribe(
        &self,
        reader: &str,
        pattern: &Pattern,
        queue: QueuePolicy,
        notifier: Arc<Notifier>,
    ) -> Result<Subscription, BusError> {
        self.bus.subscribe(reader, pattern, queue, notifier)
    }

    fn serve(
        &self,
        address: &str,
        size: usize,
        notifier: Arc<Notifier>,
    ) -> Result<ServedAddress, BusError> {
        self.bus.serve(address, size, notifier)
    }

    fn call(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        self.bus.call(address, request, notifier)
    }

    fn call_one_way(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        self.bus.call_one_way(address, request, notifier)
    }

    fn health(&self) -> Health {
        self.health.lock().unwrap().clone()
    }

    fn notify_on_change(&self, notifier: &Arc<Notifier>) {
        *self.notifier.lock().unwrap() = Some(Arc::clone(notifier));
    }

    fn republish_retained(&self) {
        self.bus.republish_retained();
    }

    fn drain(&self, at_most: Duration) -> bool {
        self.bus.drain(at_most)
    }
}

#[test]
fn every_change_is_told_with_its_reason() {
    let bus = Moody {
        bus: LocalBus::new(),
        health: Arc::new(Mutex::new(Health::now(LinkState::Up))),
        notifier: Arc::default(),
    };
    let (mut system, _) = watched();
    Network::new()
        .attach(&mut system, Arc::new(bus.clone()), 1)
        .unwrap();
    let mut live = system.live();
    let mut told = |expected: &str| {
        let mut seen = |_: Time, event: &Event<'_>| said(event).as_deref() == Some(expected);
        let limit = live.now() + Duration::from_secs(20);
        assert!(live.run_until_event(limit, &mut seen), "{expected}");
    };
    bus.set(LinkState::Down {
        reason: "reset".into(),
    });
    told("DOWN reset");
    bus.set(LinkState::Blocked {
        reason: "memory".into(),
    });
    told("BLOCKED memory");
    bus.set(LinkState::Up);
    told("UP ");
}

#[test]
fn nobody_else_publishes_it_and_nobody_reads_something_else_there() {
    let (mut system, _) = watched();
    system.add("Counter", Activity::event(), counter()).unwrap();
    let published = system.publish("Counter.n", HEALTH_TOPIC).unwrap_err();
    assert!(matches!(published, BuildError::ReservedTopic { .. }));
    let reads_numbers = behaviour(|interface| {
        interface.input::<Number>("n", "numbers");
        |_| Ok(())
    });
    system
        .add("Other", Activity::event(), reads_numbers)
        .unwrap();
    let read = system.subscribe(HEALTH_TOPIC, "Other.n", Policy::data());
    assert!(matches!(read, Err(BuildError::TypeMismatch { .. })));
}
