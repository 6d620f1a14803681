//! Messages that do not fit, losses and notices.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_component::{Activity, Losses, Policy, Time};
use asmotion_datum::{Datum, OutlineKey, Schema, Shape};
use asmotion_ros_gateway::{
    CycleWakes, MappedTopic, MessageReceiver, MessageSender, RosBridge, RosConnection,
    RosDirection, RosMessage, RosTransport, Wake,
};
use asmotion_runtime::{Log, Run, System};

/// A transport in memory.
#[derive(Clone, Default)]
struct Memory(Arc<Mutex<State>>);

#[derive(Default)]
struct State {
    sent: Vec<Datum>,
    arrived: Vec<Datum>,
    notices: Vec<String>,
    wake: Option<Wake>,
}

impl Memory {
    fn with<T>(&self, use_state: impl FnOnce(&mut State) -> T) -> T {
        use_state(&mut self.0.lock().unwrap())
    }

    fn wake(&self) {
        let wake = self.with(|state| state.wake.clone());
        wake.unwrap()();
    }
}

fn record(name: &'static str, fields: &[(&'static str, Schema)]) -> Schema {
    let fields = fields.iter();
    let fields = fields.map(|(name, schema)| OutlineKey::new(*name, "", schema.clone()));
    Schema::record(name, fields.collect())
}

/// A header, with a sequence number or without.
fn stamped(has_sequence: bool) -> Schema {
    let seconds = (
        "sec",
        Schema::plain(if has_sequence { Shape::U32 } else { Shape::I32 }),
    );
    let mut header = vec![("stamp", record("builtin_interfaces/Time", &[seconds]))];
    if has_sequence {
        header.insert(0, ("seq", Schema::plain(Shape::U32)));
    }
    let header = record("std_msgs/Header", &header);
    record(
        "test/Stamped",
        &[("header", header), ("flag", Schema::plain(Shape::Bool))],
    )
}

impl RosTransport for Memory {
    fn schema(&self, kind: &str) -> Result<Schema, String> {
        assert_eq!(kind, "test/Stamped");
        Ok(stamped(true))
    }

    fn join(&self, wakes: CycleWakes) -> Result<Box<dyn RosConnection>, String> {
        self.with(|state| state.wake = Some(wakes.wake));
        Ok(Box::new(self.clone()))
    }
}

impl RosConnection for Memory {
    fn publish(&mut self, _: &MappedTopic) -> Result<Box<dyn MessageSender>, String> {
        Ok(Box::new(self.clone()))
    }

    fn subscribe(&mut self, _: &MappedTopic) -> Result<Box<dyn MessageReceiver>, String> {
        Ok(Box::new(self.clone()))
    }

    fn notices(&mut self) -> Vec<String> {
        self.with(|state| std::mem::take(&mut state.notices))
    }
}

impl MessageSender for Memory {
    fn send(&mut self, message: &Datum) -> Result<(), String> {
        self.with(|state| state.sent.push(message.clone()));
        Ok(())
    }

    fn finish(&mut self, _: Instant) {}

    fn losses(&self) -> Losses {
        Losses {
            dropped: 3,
            misfits: 0,
        }
    }
}

impl MessageReceiver for Memory {
    fn take(&mut self) -> Vec<RosMessage> {
        let arrived = self.with(|state| std::mem::take(&mut state.arrived));
        let new = |content| RosMessage {
            content,
            age: Duration::ZERO,
        };
        arrived.into_iter().map(new).collect()
    }

    fn losses(&self) -> Losses {
        Losses {
            dropped: 4,
            misfits: 1,
        }
    }
}

fn mapped(port: &str, direction: RosDirection) -> MappedTopic {
    MappedTopic {
        port: port.to_owned(),
        topic: None,
        schema: stamped(false),
        ros: format!("/{port}"),
        kind: "test/Stamped".to_owned(),
        queue: 10,
        is_latched: false,
        is_best_effort: false,
        deadline: None,
        lifespan: None,
        converters: Vec::new(),
        transform: None,
        direction,
    }
}

fn bridge(memory: &Memory) -> System {
    let mut system = System::new();
    let mapped = vec![
        mapped("to", RosDirection::ToRos),
        mapped("from", RosDirection::FromRos),
    ];
    let transport = Box::new(memory.clone());
    system
        .add("Bridge", Activity::event(), |interface| {
            Box::new(RosBridge::new(transport, mapped, interface).unwrap())
        })
        .unwrap();
    system
}

fn sample(seconds: i64) -> Datum {
    let stamp = Datum::record([("sec", Datum::Int(seconds))]);
    let header = Datum::record([("stamp", stamp)]);
    Datum::record([("header", header), ("flag", Datum::Bool(true))])
}

fn eventually(what: &str, mut is_so: impl FnMut() -> bool) {
    let until = Instant::now() + Duration::from_secs(20);
    while !is_so() {
        assert!(Instant::now() < until, "not soon: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn r8_what_does_not_fit_is_counted_and_reported_once_for_each_cause() {
    let memory = Memory::default();
    let mut system = bridge(&memory);
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.live();
    run.run_for(Duration::from_millis(50));
    // before 1970: ROS 1 has no such time
    for seconds in [1, -1, -1, 2] {
        let now = run.now();
        run.inject_sample(now, "Bridge.to", Arc::new(sample(seconds)))
            .unwrap();
        run.run_for(Duration::from_millis(20));
    }
    eventually("two messages", || {
        memory.with(|state| state.sent.len() == 2)
    });
    let sequences = memory.with(|state| {
        let sent = state.sent.iter();
        let header = sent.map(|it| it.get("header.seq").and_then(|it| it.as_int()));
        header.collect::<Vec<_>>()
    });
    assert_eq!(sequences, [Some(0), Some(1)]);
    assert_eq!(
        run.losses("Bridge"),
        Losses {
            dropped: 7,
            misfits: 3
        }
    );
    let reported = log.lines_with("was dropped");
    assert_eq!(reported.len(), 1, "{reported:?}");
    assert!(
        reported[0].contains("between `to` and `/to`") && reported[0].contains("sec"),
        "{reported:?}"
    );
    run.stop();
    // the last cycle has the inputs of the one before, which have been sent
    assert_eq!(memory.with(|state| state.sent.len()), 2);
}

#[test]
fn r5_messages_and_notices_wake_the_bridge() {
    let memory = Memory::default();
    let mut system = bridge(&memory);
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.live();
    let mut reader = run
        .reader::<Datum>("Bridge.from", Policy::buffer(8))
        .unwrap();
    run.run_for(Duration::from_millis(50));
    let stamp = Datum::record([("sec", Datum::Int(5))]);
    let header = Datum::record([("seq", Datum::Int(9)), ("stamp", stamp)]);
    let message = Datum::record([("header", header), ("flag", Datum::Bool(true))]);
    memory.with(|state| {
        state.arrived = vec![message, Datum::record([("flag", Datum::Int(3))])];
        state.notices = vec!["the master is away".to_owned()];
    });
    memory.wake();
    run.run_for(Duration::from_millis(100));
    let found = reader.read().new().cloned();
    assert_eq!(found, Some(sample(5)));
    assert_eq!(log.lines_with("the master is away").len(), 1);
    assert_eq!(run.losses("Bridge").misfits, 2);
    run.stop();
}

#[test]
fn r6_without_the_wall_clock_it_says_so() {
    let memory = Memory::default();
    let mut run = bridge(&memory).simulate();
    run.run_until(Time::ZERO + Duration::from_secs(1));
    let fault = run.fault("Bridge").map(|fault| fault.to_string());
    assert!(fault.is_some_and(|it| it.contains("a ros-bridge needs the wall clock")),);
}
