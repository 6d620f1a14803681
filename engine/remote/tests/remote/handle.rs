//! Observes and controls a system over the in-process bus.

use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use asmotion_bus::{Bus, LocalBus, Payload, PublishOptions, SenderId};
use asmotion_component::{CallError, SendStatus, State, Transition};
use asmotion_datum::{Datum, Numbers, Schema};
use asmotion_remote::{
    OrderErrorCode, PRESENCE, Presence, PresentComponent, PresentOperation, PresentService, Remote,
    RemoteComponent, RemoteError, key, presence_topic,
};

use crate::driver::{Joints, LONG_WAY, joints, open};
use crate::robot::Robot;

const PATIENCE: Duration = Duration::from_secs(5);

/// Waits for a property that has been set: it has its value from the next cycle on.
fn await_scale(driver: &RemoteComponent, scale: f64) {
    let set = Instant::now();
    while driver.get("scale") != Ok(scale) {
        assert!(set.elapsed() < PATIENCE, "{:?}", driver.get::<f64>("scale"));
    }
}

fn datum(joints: &Joints) -> Datum {
    Datum::of(joints).expect("data")
}

#[test]
fn j7_components_are_listed_and_found_by_name() {
    let robot = Robot::start();
    let remote = robot.remote();
    let names: Vec<_> = remote
        .components()
        .iter()
        .map(|it| it.full_name())
        .collect();
    assert_eq!(names, ["Driver"]);
    let driver = remote.component("Driver").expect("a component");
    assert_eq!((driver.robot(), driver.process()), ("", "arm"));
    let unknown = remote.component("Diver").map(|it| it.full_name());
    let nearest = Some("Driver".to_owned());
    let (what, name) = ("component", "Diver".to_owned());
    assert_eq!(
        unknown,
        Err(RemoteError::Unknown {
            what,
            name,
            nearest
        })
    );
    drop(robot);
    assert!(remote.components().is_empty(), "it said its last word");
    let gone = driver.state();
    assert!(matches!(gone, Err(RemoteError::Process { .. })), "{gone:?}");
}

#[test]
fn j7_two_systems_in_one_process() {
    let robots = [Robot::start(), Robot::start()];
    let drivers = robots
        .each_ref()
        .map(|robot| robot.remote().component("Driver").expect("a component"));
    drivers[0].set("scale", 3.0).expect("a property");
    await_scale(&drivers[0], 3.0);
    assert_eq!(drivers[1].get::<f64>("scale"), Ok(1.0));
}

#[test]
fn j8_the_life_cycle_is_driven_by_a_handle() {
    let robot = Robot::start();
    let driver = robot.remote().component("Driver").expect("a component");
    assert_eq!(driver.state(), Ok(State::Running));
    let way = [
        (Transition::Stop, State::Stopped),
        (Transition::Cleanup, State::PreOperational),
        (Transition::Configure, State::Stopped),
        (Transition::Start, State::Running),
    ];
    for (transition, state) in way {
        assert_eq!(driver.transition(transition), Ok(()), "{transition}");
        assert_eq!(driver.state(), Ok(state));
    }
    let refused = driver.transition(Transition::ResetException);
    let refused = refused.expect_err("there is no exception");
    assert!(refused.to_string().contains("it is Running"), "{refused}");
}

#[test]
fn j13_ports_are_written_read_and_watched_and_errors_have_types() {
    let robot = Robot::start();
    let driver = robot.remote().component("Driver").expect("a component");
    let refused = |result: Result<(), RemoteError>| match result {
        Err(RemoteError::Refused { reason, .. }) => reason,
        other => panic!("{other:?}"),
    };
    let read = |port: &str| driver.read::<Datum>(port).map(drop);
    assert_eq!(refused(read("status")), OrderErrorCode::NoData);
    assert_eq!(refused(read("state")), OrderErrorCode::UnknownPort);
    assert_eq!(refused(read("commands")), OrderErrorCode::WrongDirection);
    assert_eq!(
        refused(driver.write("commands", 1)),
        OrderErrorCode::WrongType
    );
    assert_eq!(
        refused(driver.write("status", 1)),
        OrderErrorCode::WrongDirection
    );
    assert_eq!(
        refused(driver.watch("statu").map(drop)),
        OrderErrorCode::UnknownPort
    );

    let mut watch = driver.watch("status").expect("an output");
    let ways = [[0.5, 1.0], [1.0, 1.5], [1.5, 2.0]];
    for way in ways {
        driver.write("commands", joints(way)).expect("an input");
        let seen = watch.next_within(PATIENCE).expect("a message");
        assert_eq!(seen.content.and_then(|seen| seen.to()), Ok(joints(way)));
    }
    assert_eq!(driver.read("status"), Ok(joints(ways[2])));
    let mut late = driver.watch("status").expect("an output");
    assert_eq!(
        late.next_within(Duration::ZERO),
        None,
        "it is watched already"
    );
}

#[test]
fn j15_what_is_seen_of_a_component_is_plain_data() {
    let robot = Robot::start();
    let driver = robot.remote().component("Driver").expect("a component");
    let declared = driver.declaration().expect("a declaration");
    assert_eq!(declared.inputs[0].name, "commands");
    assert_eq!(declared.services[0].operations[0].name, "mirror");
    let present = driver.refresh().expect("a look");
    assert_eq!(present.state, "Running");
    assert_eq!(present.period_ms, 10);
    let json = asmotion_datum::json::encode(&Datum::of(&present).expect("data")).expect("JSON");
    let back: asmotion_remote::PresentComponent =
        asmotion_datum::json::decode(&json).expect("the same");
    assert_eq!(back, present);
}

#[test]
fn properties_of_a_component_in_a_long_cycle_are_awaited() {
    let robot = Robot::start();
    let driver = robot.remote().component("Driver").expect("a component");
    driver
        .write("commands", joints(LONG_WAY))
        .expect("an input");
    // until it is in that cycle, which ends much later
    std::thread::sleep(Duration::from_millis(200));
    let busy = driver.refresh().expect("a look");
    assert_eq!(busy.properties, [], "it is not in a long cycle");
    let properties = driver.properties().expect("properties");
    assert_eq!(properties, [("scale".to_owned(), Datum::Float(1.0))]);
}

#[test]
fn j16_properties_are_got_and_set_all_or_none() {
    let robot = Robot::start();
    let driver = robot.remote().component("Driver").expect("a component");
    driver.set("scale", 0.5).expect("a property");
    await_scale(&driver, 0.5);
    let both = vec![
        ("scale".to_owned(), Datum::Float(2.0)),
        ("scael".to_owned(), Datum::Float(2.0)),
    ];
    let refused = driver.set_all(both).expect_err("there is no `scael`");
    assert!(refused.to_string().contains("`scale`"), "{refused}");
    assert_eq!(driver.get::<f64>("scale"), Ok(0.5));
    let unknown = driver.get::<f64>("scael").expect_err("there is none");
    assert!(
        unknown.to_string().contains("did you mean `scale`?"),
        "{unknown}"
    );
}

#[test]
fn j16_an_answer_is_told_when_it_is_there_without_a_poll_period() {
    let robot = Robot::start();
    let driver = robot.remote().component("Driver").expect("a component");
    let service = driver.service("mirror").expect("a service");
    assert_eq!(service.present().interface, "test/Mirror");
    let (argument, answer) = (datum(&joints([0.5, -1.0])), datum(&joints([-0.5, 1.0])));

    let called = service.call("mirror", argument.clone(), PATIENCE);
    assert_eq!(called, Ok(answer.clone()));

    let (tell, told) = mpsc::channel();
    let sent = service.send("mirror", argument.clone(), PATIENCE);
    let listener = move |answer| tell.send(answer).expect("somebody listens");
    sent.expect("a bus")
        .on_completion(listener)
        .expect("a thread");
    assert_eq!(told.recv_timeout(PATIENCE), Ok(Ok(answer.clone())));

    let mut sent = service
        .send("mirror", argument.clone(), PATIENCE)
        .expect("a bus");
    let collected = std::iter::repeat_with(|| sent.collect_if_done())
        .inspect(|_| std::thread::yield_now())
        .find(|status| *status != SendStatus::NotReady);
    assert_eq!(collected, Some(SendStatus::Success(answer)));
    assert_eq!(sent.collect_if_done(), SendStatus::Unknown);
}

#[test]
fn j16_a_call_that_has_no_answer_says_why() {
    let robot = Robot::start();
    let remote = robot.remote();
    let argument = || datum(&joints([0.0, 0.0]));
    let nobody = remote.call("Driver.mirror.miror", argument(), PATIENCE);
    let (operation, meant) = ("Driver.mirror.miror", "Driver.mirror.mirror");
    assert_eq!(
        nobody,
        Err(RemoteError::Nobody {
            operation: operation.to_owned(),
            nearest: Some(meant.to_owned())
        })
    );
    let wrong = remote.call(meant, Datum::text("up"), PATIENCE);
    let code = |fault: asmotion_component::ServiceFault| fault.code;
    match wrong {
        Err(RemoteError::Call(CallError::Fault(fault))) => assert_eq!(code(fault), "BAD_ARGUMENT"),
        other => panic!("{other:?}"),
    }
    let sent = remote.send(meant, argument(), PATIENCE).expect("a bus");
    sent.cancel();
    let cancelled = RemoteError::Call(CallError::Cancelled);
    let end = sent.collect();
    assert!(end == Err(cancelled) || end.is_ok(), "{end:?}");
}

#[test]
fn t18_a_call_of_a_stopped_component_names_it_at_once() {
    let robot = Robot::start();
    let remote = robot.remote();
    let driver = remote.component("Driver").expect("a component");
    driver.transition(Transition::Stop).expect("it ran");
    let begun = std::time::Instant::now();
    let stopped = remote.call("Driver.mirror.mirror", datum(&joints([0.0, 0.0])), PATIENCE);
    assert!(begun.elapsed() < PATIENCE / 2);
    let stopped = stopped.expect_err("it does not run").to_string();
    let expected = "`Driver.mirror.mirror`: component `Driver` does not run";
    assert_eq!(stopped, expected);
}

#[test]
fn c21_a_late_joiner_finds_a_service_by_its_interface() {
    let robot = Robot::start();
    let remote = robot.remote();
    let found = remote.service("test/Mirror").expect("one service");
    assert_eq!(found.address(), "Driver.mirror");
    assert_eq!((&*found.process, &*found.state), ("arm", "Running"));
    assert_eq!(remote.services("test/Mirror"), [found]);
    let operation = remote.operation_address("test/Mirror.mirror").expect("one");
    let answer = remote.call(&operation, datum(&joints([1.0, 0.5])), PATIENCE);
    assert_eq!(answer, Ok(datum(&joints([-1.0, -0.5]))));
    let unknown = remote.service("test/Miror").expect_err("nobody has it");
    let expected = "unknown interface `test/Miror`; did you mean `test/Mirror`?";
    assert_eq!(unknown.to_string(), expected);
    assert_eq!(remote.services("test/Miror"), []);
}

#[test]
fn c21_of_two_services_with_an_interface_both_are_named() {
    let bus: Arc<dyn Bus> = Arc::new(LocalBus::new());
    let remote = Remote::over_bus(Arc::clone(&bus), None).expect("a bus");
    let service = PresentService {
        name: "planning".to_owned(),
        interface: "nav/PlanService".to_owned(),
        ..PresentService::default()
    };
    let component = |name: &str| PresentComponent {
        name: name.to_owned(),
        services: vec![service.clone()],
        ..PresentComponent::default()
    };
    for (process, name) in [("one", "Planner"), ("two", "Spare")] {
        let presence = Presence {
            process: process.to_owned(),
            components: vec![component(name)],
            ..Presence::default()
        };
        let topic = key("rover", &presence_topic(process));
        let origin = SenderId::new(process, 0);
        let schema = Schema::opaque(PRESENCE);
        let publisher = bus.publisher(&topic, &origin, &schema, PublishOptions::state());
        let sample = Datum::of(&presence).expect("data");
        let mut publisher = publisher.expect("a topic");
        publisher.publish(0, Payload::of(sample)).expect("room");
    }
    let ambiguous = remote.service("nav/PlanService").expect_err("two");
    let expected = "ambiguous name `nav/PlanService`: rover.Planner.planning, rover.Spare.planning";
    assert_eq!(ambiguous.to_string(), expected);
    assert_eq!(remote.services("nav/PlanService").len(), 2);
}

/// A process whose presence is late is not left out where the processes are known.
#[test]
fn a_late_presence_is_awaited() {
    let bus: Arc<dyn Bus> = Arc::new(LocalBus::new());
    let remote = Remote::over_bus(Arc::clone(&bus), None).expect("a bus");
    let publish = move |process: &str| {
        let presence = Presence {
            process: process.to_owned(),
            ..Presence::default()
        };
        let topic = key("rover", &presence_topic(process));
        let origin = SenderId::new(process, 0);
        let schema = Schema::opaque(PRESENCE);
        let publisher = bus.publisher(&topic, &origin, &schema, PublishOptions::state());
        let sample = Payload::of(Datum::of(&presence).expect("data"));
        let sent = publisher.expect("a topic").publish(0, sample);
        assert!(sent.is_ok(), "{sent:?}");
    };
    publish("desk");
    let late = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(2000));
        publish("robot");
    });
    // who is there decides after 1.5 s
    assert_eq!(remote.processes().len(), 1);
    assert_eq!(remote.processes_until(|found| found.len() == 2).len(), 2);
    late.join().expect("a thread that publishes");
}

#[test]
fn t15_an_operation_is_named_by_the_id_of_its_component() {
    let bus: Arc<dyn Bus> = Arc::new(LocalBus::new());
    let remote = Remote::over_bus(Arc::clone(&bus), None).expect("a bus");
    let component = PresentComponent {
        name: "Planner".to_owned(),
        id: "planner".to_owned(),
        services: vec![PresentService {
            name: "planning".to_owned(),
            interface: "nav/PlanService".to_owned(),
            operations: vec![PresentOperation {
                name: "plan".to_owned(),
                ..PresentOperation::default()
            }],
            refused: 0,
            waiting: 0,
        }],
        ..PresentComponent::default()
    };
    let presence = Presence {
        process: "one".to_owned(),
        components: vec![component],
        ..Presence::default()
    };
    let topic = key("rover", &presence_topic("one"));
    let origin = SenderId::new("one", 0);
    let schema = Schema::opaque(PRESENCE);
    let publisher = bus.publisher(&topic, &origin, &schema, PublishOptions::state());
    let sample = Payload::of(Datum::of(&presence).expect("data"));
    let sent = publisher.expect("a topic").publish(0, sample);
    assert!(sent.is_ok(), "{sent:?}");
    for name in [
        "planner.plan",
        "planner.planning.plan",
        "rover.planner.plan",
        "Planner.plan",
    ] {
        let address = remote.short_operation_address(name);
        let expected = Some("rover.Planner.planning.plan".to_owned());
        assert_eq!(address, Ok(expected), "{name}");
    }
    assert_eq!(remote.short_operation_address("plan.plan"), Ok(None));
}

#[test]
fn j18_whatever_is_written_a_component_keeps_running() {
    let robot = Robot::start();
    let driver = robot.remote().component("Driver").expect("a component");
    let deep = (0..100).fold(Datum::Null, |inner, _| Datum::List(vec![inner]));
    let strange = [
        Datum::Null,
        Datum::Bool(true),
        Datum::Int(i64::MIN),
        Datum::text("uchar"),
        Datum::Bytes([0, 255].into()),
        Datum::Numbers(Numbers::F64([1.0].into())),
        Datum::List(vec![Datum::Null; 3]),
        deep,
        Datum::record([("position", Datum::text("up"))]),
        Datum::record([("position", Datum::List(vec![Datum::Float(1.0); 3]))]),
        Datum::record([("velocity", Datum::Float(1.0))]),
    ];
    for value in &strange {
        match driver.write("commands", value) {
            Err(RemoteError::Refused { reason, detail }) => {
                assert_eq!(reason, OrderErrorCode::WrongType, "{value}: {detail}");
                assert!(detail.contains("test/Joints"), "{value}: {detail}");
            }
            other => panic!("{value}: {other:?}"),
        }
    }
    // over its topic too, with a type that no process knows
    let unknown = Schema::opaque("strange/Type");
    let origin = SenderId::new("stranger", 1);
    let publisher = robot
        .bus
        .publisher("commands", &origin, &unknown, PublishOptions::state());
    let mut publisher = publisher.expect("a topic");
    for value in strange {
        publisher.publish(0, Payload::of(value)).expect("a bus");
    }
    driver
        .write("commands", joints([0.1, 0.2]))
        .expect("an input");
    let cycles = driver.refresh().expect("a look").cycles;
    std::thread::sleep(Duration::from_millis(100));
    let present = driver.refresh().expect("a look");
    assert_eq!(present.state, "Running");
    assert!(present.cycles > cycles, "{} after {cycles}", present.cycles);
    assert_eq!(driver.read("status"), Ok(joints([0.1, 0.2])));
}

#[test]
fn j20_the_endpoint_is_a_property_of_the_composite_and_an_argument_here() {
    let setting = ("broker".to_owned(), "amqp://arm2:5673/other".to_owned());
    let opened = open(&[setting]);
    let plan = opened.plan(None).expect("a plan");
    let url = plan.brokers[0].url.as_ref().expect("an address");
    assert_eq!(url.reveal(), "amqp://arm2:5673/other");
    let none = Remote::connect("arm2", None).map(drop);
    assert!(matches!(none, Err(RemoteError::Address(_))), "{none:?}");
}
