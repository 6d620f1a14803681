//! Services, ports and topics over a bus behave like local ones.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::common::{Double, Number, behaviour, counter, doubler, number};
use asmotion_bus::{
    Bus, CallFailure, LocalBus, Notifier, Pattern, Payload, PublishOptions, QueuePolicy,
    RobotAddress, SenderId,
};
use asmotion_component::{
    Activity, CallError, Component, Interface, Policy, Reply, ServiceFault, Span, Time, Wire,
};
use asmotion_datum::Datum;
use asmotion_network::{AnnouncedOperation, AnnouncedService, Network, RobotService, port_topic};
use asmotion_runtime::{Event, Log, Run, System};

type Replies = Arc<Mutex<Vec<Result<i64, CallError>>>>;

/// Calls `double` once, and records the reply.
fn caller(replies: &Replies) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let replies = Arc::clone(replies);
    behaviour(move |interface| {
        let double = interface.require::<Double>("sums", "to double");
        let mut called = false;
        move |cycle| {
            if !std::mem::replace(&mut called, true) {
                cycle.call(double, number(21));
            }
            for Reply { result, .. } in cycle.replies(double) {
                cycle.report("replied", Datum::Null);
                replies.lock().unwrap().push(result.map(|sample| sample.n));
            }
            Ok(())
        }
    })
}

/// Provides `double` with the given answers; `None` is no reply.
fn provider(
    answer: impl Fn(i64) -> Option<Result<i64, ServiceFault>> + Send + 'static,
) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(move |interface| {
        let double = interface.serve::<Double>("sums", "in its own way");
        move |cycle| {
            for request in cycle.requests(double) {
                cycle.report("asked", Datum::Null);
                if let Some(result) = answer(request.argument.n) {
                    cycle.reply(double, request.id, result.map(number));
                }
            }
            for _ in 0..cycle.cancelled(double).len() {
                cycle.report("cancelled", Datum::Null);
            }
            Ok(())
        }
    })
}

/// A system that calls a remote service.
fn calling(bus: &LocalBus, replies: &Replies, wire: Wire) -> (System, Log) {
    let (mut system, log) = (System::new(), Log::new());
    system.observe(log.clone());
    system
        .add("Caller", Activity::event(), caller(replies))
        .unwrap();
    let mut network = Network::new();
    network
        .wire_remote(&mut system, "Caller.sums", "Provider.sums", wire)
        .unwrap();
    network
        .attach(&mut system, Arc::new(bus.clone()), 1)
        .unwrap();
    (system, log)
}

/// A system that offers a service.
fn offering(
    bus: &LocalBus,
    construct: impl FnOnce(&mut Interface) -> Box<dyn Component>,
) -> (System, Log) {
    let (mut system, log) = (System::new(), Log::new());
    system.observe(log.clone());
    system
        .add("Provider", Activity::event(), construct)
        .unwrap();
    let mut network = Network::new();
    network.offer(&system, "Provider.sums").unwrap();
    network
        .attach(&mut system, Arc::new(bus.clone()), 2)
        .unwrap();
    (system, log)
}

/// Runs until a component makes a report of this kind.
fn until_reported(run: &mut impl Run, kind: &str) {
    let mut seen =
        |_: Time, event: &Event<'_>| matches!(event, Event::Report { kind: it, .. } if *it == kind);
    let limit = run.now() + Duration::from_secs(20);
    assert!(
        run.run_until_event(limit, &mut seen),
        "`{kind}` is not reported"
    );
}

fn ends_with(
    construct: impl FnOnce(&mut Interface) -> Box<dyn Component>,
    wire: Wire,
) -> Vec<Result<i64, CallError>> {
    let (bus, replies) = (LocalBus::new(), Replies::default());
    let there = offering(&bus, construct).0.live();
    let mut here = calling(&bus, &replies, wire).0.live();
    until_reported(&mut here, "replied");
    drop(there);
    replies.lock().unwrap().clone()
}

#[test]
fn a_call_is_answered_by_another_system() {
    assert_eq!(ends_with(doubler(), Wire::default()), [Ok(42)]);
}

/// A server whose own call has timed out: the caller need not wait for its deadline.
#[test]
fn a_timeout_before_the_deadline_ends_the_attempt_at_once() {
    let (bus, replies) = (LocalBus::new(), Replies::default());
    let notifier = Arc::new(Notifier::new());
    let served = bus.serve("Provider.sums.double", 4, notifier).unwrap();
    let provides = std::thread::spawn(move || {
        for _ in 0..2 {
            let call = served.next_within(Duration::from_secs(20)).unwrap();
            call.complete(Err(CallFailure::Timeout));
        }
    });
    // a timeout is tried again
    let wire = Wire::timeout(120.s()).retries(1);
    let mut here = calling(&bus, &replies, wire).0.live();
    until_reported(&mut here, "replied");
    provides.join().unwrap();
    assert_eq!(*replies.lock().unwrap(), [Err(CallError::Timeout)]);
}

#[test]
fn a_fault_keeps_its_code() {
    let fault = ServiceFault::new("ODD", "21 is odd");
    let refusing = fault.clone();
    let refuses = provider(move |_| Some(Err(refusing.clone())));
    assert_eq!(
        ends_with(refuses, Wire::default()),
        [Err(CallError::Fault(fault))]
    );
}

#[test]
fn silence_is_a_timeout() {
    let wire = Wire::timeout(50.ms());
    assert_eq!(
        ends_with(provider(|_| None), wire),
        [Err(CallError::Timeout)]
    );
}

#[test]
fn where_nobody_is_a_call_ends_unavailable() {
    let (bus, replies) = (LocalBus::new(), Replies::default());
    let (system, _) = calling(&bus, &replies, Wire::default());
    system.simulate().run_for(1.s());
    assert_eq!(*replies.lock().unwrap(), [Err(CallError::Unavailable)]);
}

#[test]
fn t18_a_caller_of_a_service_that_stops_learns_it() {
    let (bus, replies) = (LocalBus::new(), Replies::default());
    let mut there = offering(&bus, provider(|_| None)).0.live();
    let mut here = calling(&bus, &replies, Wire::timeout(20.s())).0.live();
    until_reported(&mut there, "asked");
    there.stop();
    until_reported(&mut here, "replied");
    assert_eq!(*replies.lock().unwrap(), [Err(CallError::Stopped)]);
}

#[test]
fn a_provider_learns_that_nobody_waits() {
    let bus = LocalBus::new();
    let (system, log) = offering(&bus, provider(|_| None));
    let mut run = system.simulate();
    let request =
        asmotion_bus::Request::new(SenderId::new("Tool", 9), Payload::of(number(1)), 20.s());
    let pending = bus
        .call("Provider.sums.double", request, Arc::new(Notifier::new()))
        .unwrap();
    run.run_for(1.ms());
    pending.cancel();
    assert_eq!(
        pending.try_take().unwrap().unwrap_err(),
        CallFailure::Cancelled
    );
    run.trigger("Provider").unwrap();
    run.run_for(1.ms());
    assert_eq!(log.lines_with("cancelled").len(), 1);
}

#[test]
fn a_one_way_call_arrives_or_is_counted() {
    let (bus, replies) = (LocalBus::new(), Replies::default());
    let (system, log) = calling(&bus, &replies, Wire::one_way());
    system.simulate().run_for(1.s());
    let dropped = log.lines_with("dropped");
    assert!(dropped[0].contains("Provider.sums.double"), "{dropped:?}");

    let mut there = offering(&bus, provider(|_| None)).0.live();
    let here = calling(&bus, &replies, Wire::one_way()).0.live();
    until_reported(&mut there, "asked");
    drop(here);
    assert_eq!(*replies.lock().unwrap(), []);
}

#[test]
fn the_time_limit_of_a_one_way_wire_is_that_in_which_its_request_can_be_taken() {
    for limit in [Duration::from_secs(20), Duration::from_secs(200)] {
        let (bus, replies) = (LocalBus::new(), Replies::default());
        let served = bus
            .serve("Provider.sums.double", 4, Arc::new(Notifier::new()))
            .unwrap();
        let wire = Wire {
            timeout: limit,
            ..Wire::one_way()
        };
        let begun = Instant::now();
        calling(&bus, &replies, wire).0.simulate().run_for(10.ms());
        let given = served.try_next().unwrap().deadline - begun;
        let least = limit.saturating_sub(Duration::from_secs(1));
        assert!(
            (least..limit + begun.elapsed()).contains(&given),
            "{given:?}"
        );
    }
}

#[test]
fn one_system_reaches_itself_over_the_bus_the_same_way_each_time() {
    let lines = || {
        let (bus, replies) = (LocalBus::new(), Replies::default());
        let (mut system, log) = (System::new(), Log::new());
        system.observe(log.clone());
        system
            .add("Caller", Activity::periodic(10.ms()), caller(&replies))
            .unwrap();
        system
            .add("Provider", Activity::periodic(30.ms()), doubler())
            .unwrap();
        let mut network = Network::new();
        network
            .wire_remote(&mut system, "Caller.sums", "Provider.sums", Wire::default())
            .unwrap();
        network.offer(&system, "Provider.sums").unwrap();
        network.attach(&mut system, Arc::new(bus), 1).unwrap();
        system.simulate().run_for(1.s());
        assert_eq!(*replies.lock().unwrap(), [Ok(42)]);
        log.lines()
    };
    assert_eq!(lines(), lines());
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
fn y10_a_callback_reaches_listeners_inside_and_beyond_the_bus() {
    let bus = LocalBus::new();
    let replies = Replies::default();
    let (mut there, log_there) = (System::new(), Log::new());
    there.observe(log_there.clone());
    there.add("Far", Activity::event(), listening()).unwrap();
    let mut network = Network::new();
    network.offer(&there, "Far.sums").unwrap();
    network
        .attach(&mut there, Arc::new(bus.clone()), 1)
        .unwrap();
    let (mut here, log_here) = (System::new(), Log::new());
    here.observe(log_here.clone());
    here.add("Near", Activity::event(), listening()).unwrap();
    here.add("Caller", Activity::event(), caller(&replies))
        .unwrap();
    here.wire("Caller.sums", "Near.sums", Wire::one_way())
        .unwrap();
    let mut network = Network::new();
    network
        .wire_remote(&mut here, "Caller.sums", "Far.sums", Wire::one_way())
        .unwrap();
    network.attach(&mut here, Arc::new(bus), 2).unwrap();
    let (mut there, mut here) = (there.live(), here.live());
    for _ in 0..200 {
        here.run_for(10.ms());
        there.run_for(10.ms());
        if !log_here.lines_with("told").is_empty() && !log_there.lines_with("told").is_empty() {
            break;
        }
    }
    for (log, name) in [(log_here, "Near"), (log_there, "Far")] {
        let told = log.lines_with("told");
        assert!(
            matches!(told.as_slice(), [one] if one.contains(name)),
            "{told:?}"
        );
    }
    assert!(replies.lock().unwrap().is_empty());
}

/// Makes a report for every number it reads.
fn teller() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let input = interface.input::<Number>("n", "numbers");
        move |cycle| {
            for _ in 0..cycle.all(input).len() {
                cycle.report("heard", Datum::Null);
            }
            Ok(())
        }
    })
}

#[test]
fn a_port_is_connected_to_one_of_another_system() {
    let bus = LocalBus::new();
    let mut there = System::new();
    there
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    let mut network = Network::new();
    network
        .expose(&there, "Counter.n", PublishOptions::state())
        .unwrap();
    network
        .attach(&mut there, Arc::new(bus.clone()), 1)
        .unwrap();
    let mut here = System::new();
    // without an observer, no event before `run_until_event` is kept
    here.observe(Log::new());
    here.add("Teller", Activity::event(), teller()).unwrap();
    here.subscribe(&port_topic("Counter.n"), "Teller.n", Policy::data())
        .unwrap();
    Network::new().attach(&mut here, Arc::new(bus), 2).unwrap();
    let (mut here, there) = (here.live(), there.live());
    until_reported(&mut here, "heard");
    drop(there);
}

#[test]
fn topics_left_to_the_bus_reach_those_inside_by_it_and_only_once() {
    let bus = LocalBus::new();
    let tool = bus
        .subscribe(
            "Tester",
            &asmotion_bus::Pattern::new("numbers"),
            QueuePolicy::Latest,
            Arc::new(Notifier::new()),
        )
        .unwrap();
    let (mut system, log) = (System::new(), Log::new());
    system.observe(log.clone());
    system.leave_topics_to_adapters();
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    system.add("Teller", Activity::event(), teller()).unwrap();
    system.publish("Counter.n", "numbers").unwrap();
    system
        .subscribe("numbers", "Teller.n", Policy::buffer(4))
        .unwrap();
    Network::new()
        .attach(&mut system, Arc::new(bus), 1)
        .unwrap();
    let mut run = system.simulate();
    run.run_for(15.ms());
    assert_eq!(log.lines_with("heard").len(), 2);
    assert_eq!(log.lines_with("Teller.n <- ").len(), 2);
    assert_eq!(tool.try_next().unwrap().sequence, 2);
}

/// The result of calling `double` at an address.
fn doubled(bus: &LocalBus, address: &str, n: i64) -> Result<Payload, CallFailure> {
    let request =
        asmotion_bus::Request::new(SenderId::new("Tool", 9), Payload::of(number(n)), 20.s());
    bus.call(address, request, Arc::new(Notifier::new()))
        .unwrap()
        .wait()
}

#[test]
fn a_service_is_served_on_a_bus_that_carries_nothing_else() {
    for is_on_a_bus in [false, true] {
        let (own, counter_of) = (LocalBus::new(), LocalBus::new());
        let heard = Pattern::new("#");
        let notifier = Arc::new(Notifier::new());
        let heard = counter_of.subscribe("ear", &heard, QueuePolicy::Latest, notifier);
        let heard = heard.unwrap();
        let mut system = System::new();
        system.add("Doubler", Activity::event(), doubler()).unwrap();
        system
            .add("Counter", Activity::periodic(10.ms()), counter())
            .unwrap();
        system.publish("Counter.n", "count").unwrap();
        let mut network = Network::new();
        if is_on_a_bus {
            network.offer(&system, "Doubler.sums").unwrap();
            network
                .attach(&mut system, Arc::new(own.clone()), 1)
                .unwrap();
        }
        let bus = Arc::new(counter_of.clone());
        assert!(
            network
                .serve_on(&mut system, bus.clone(), &[("Doubler.sum", "x")])
                .is_err()
        );
        let served = [("Doubler.sums", "sums"), ("Doubler.sums", "more")];
        network.serve_on(&mut system, bus, &served).unwrap();
        let run = system.live();
        for address in ["sums.double", "more.double"] {
            let payload = doubled(&counter_of, address, 21).unwrap();
            assert_eq!(payload.read::<crate::common::Number>().unwrap(), number(42));
        }
        let of_own = doubled(&own, "Doubler.sums.double", 4);
        assert_eq!(of_own.is_ok(), is_on_a_bus);
        assert!(doubled(&own, "sums.double", 4).is_err());
        assert!(heard.try_next().is_none(), "no topic goes there");
        drop(run);
        let gone = doubled(&counter_of, "sums.double", 1).unwrap_err();
        assert_eq!(gone, CallFailure::Unavailable);
    }
}

const MAPS: &str = "robot://depot/Provider.sums";

/// A live caller of a service of another robot and its provider, and the service that the caller compares with
/// announcements.
struct Robots {
    here: Box<dyn Run>,
    there: Box<dyn Run>,
    service: Arc<RobotService>,
    replies: Replies,
}

impl Robots {
    /// `before` is done with the service before the caller's first cycle.
    fn start(before: impl FnOnce(&RobotService)) -> Self {
        let (bus, replies) = (LocalBus::new(), Replies::default());
        let mut there = System::new();
        there.add("Provider", Activity::event(), doubler()).unwrap();
        let mut network = Network::new();
        network
            .offer_as(&there, "Provider.sums", MAPS, None)
            .unwrap();
        network
            .attach(&mut there, Arc::new(bus.clone()), 2)
            .unwrap();
        let mut here = System::new();
        // without an observer, no event before `run_until_event` is kept
        here.observe(Log::new());
        here.add("Caller", Activity::event(), caller(&replies))
            .unwrap();
        let mut network = Network::new();
        let maps = RobotAddress::parse(MAPS).unwrap();
        let wire = Wire::timeout(20.s());
        network
            .wire_to_robot(&mut here, "Caller.sums", maps, wire, Some("cell"), &|_| {
                None
            })
            .unwrap();
        assert!(network.robot_services(Some("plant")).is_empty());
        let [service] = network
            .robot_services(Some("cell"))
            .try_into()
            .ok()
            .unwrap();
        before(&service);
        network.attach(&mut here, Arc::new(bus), 1).unwrap();
        Self {
            there: Box::new(there.live()),
            here: Box::new(here.live()),
            service,
            replies,
        }
    }

    fn reply(mut self) -> Result<i64, CallError> {
        let until = self.here.now() + 20.s();
        // the reply may have arrived already, so its event is not waited for
        while self.replies.lock().unwrap().is_empty() && self.here.now() < until {
            self.here.run_for(10.ms());
        }
        drop(self.there);
        let replies = self.replies.lock().unwrap();
        replies.first().unwrap().clone()
    }
}

fn announce(service: &RobotService, interface: &str, operations: &[(&str, &str, &str)]) {
    let operations = operations.iter();
    let operations: Vec<AnnouncedOperation<'_>> = operations
        .map(|(name, request, response)| AnnouncedOperation {
            name,
            request,
            response,
        })
        .collect();
    service.compare(&AnnouncedService {
        interface,
        operations: &operations,
    });
}

const DOUBLE: (&str, &str, &str) = ("double", "test/Number", "test/Number");

#[test]
fn n12_a_call_to_a_robot_must_fit_what_it_announces() {
    let call = |interface, operation| {
        let robots = Robots::start(|service| announce(service, interface, &[operation]));
        robots.reply()
    };
    assert_eq!(call("test/Arithmetic", DOUBLE), Ok(42));
    // types without a name fit
    assert_eq!(
        call("test/Arithmetic", ("double", "", "test/Number")),
        Ok(42)
    );
    for (interface, operation, code, detail) in [
        (
            "test/Sums",
            DOUBLE,
            "OTHER_INTERFACE",
            "`Provider.sums` of robot `depot` has the interface `test/Sums`, but `Caller.sums` expects `test/Arithmetic`",
        ),
        (
            "test/Arithmetic",
            ("halve", "test/Number", "test/Number"),
            "NO_OPERATION",
            "`Provider.sums` of robot `depot` has no operation `double`, which `Caller.sums` calls",
        ),
        (
            "test/Arithmetic",
            ("double", "test/Number", "test/Words"),
            "OTHER_TYPE",
            "`Provider.sums.double` of robot `depot` returns `test/Words`, but `Caller.sums` expects `test/Number`",
        ),
    ] {
        let fault = ServiceFault::new(code, detail);
        assert_eq!(call(interface, operation), Err(CallError::Fault(fault)));
    }
}

#[test]
fn n12_a_call_to_a_robot_waits_for_its_announcement() {
    let wait = |end: fn(&RobotService)| {
        let mut robots = Robots::start(RobotService::expect_announcement);
        robots.here.run_for(200.ms());
        assert!(robots.replies.lock().unwrap().is_empty(), "sent too early");
        end(&robots.service);
        robots.reply()
    };
    let other = wait(|service| announce(service, "test/Sums", &[DOUBLE]));
    assert!(matches!(other, Err(CallError::Fault(_))), "{other:?}");
    assert_eq!(
        wait(|service| announce(service, "test/Arithmetic", &[DOUBLE])),
        Ok(42)
    );
    let missing = wait(|service| service.set_missing(&["products".to_owned()]));
    let missing = missing.unwrap_err().to_string();
    assert!(
        missing.contains("its component provides products"),
        "{missing}"
    );
    // one that announces nothing is called all the same, at the end of the wait
    let silent = wait(|service| {
        service.end_wait();
        std::thread::sleep(Duration::from_millis(1400));
        service.end_wait();
    });
    assert_eq!(silent, Ok(42));
    // the announcement of a process that has left counts no longer
    let left = wait(|service| {
        service.forget();
    });
    assert_eq!(left, Ok(42));
}

#[test]
fn n12_a_reply_in_the_name_of_a_robot_must_have_the_type_of_the_operation() {
    let bus = LocalBus::new();
    let notifier = Arc::new(Notifier::new());
    let served = bus.serve(&format!("{MAPS}.double"), 4, notifier).unwrap();
    let replies = Replies::default();
    let mut here = System::new();
    // without an observer, no event before `run_until_event` is kept
    here.observe(Log::new());
    here.add("Caller", Activity::event(), caller(&replies))
        .unwrap();
    let mut network = Network::new();
    let maps = RobotAddress::parse(MAPS).unwrap();
    let wire = Wire::timeout(20.s());
    network
        .wire_to_robot(&mut here, "Caller.sums", maps, wire, None, &|_| None)
        .unwrap();
    network.attach(&mut here, Arc::new(bus), 1).unwrap();
    let mut here = here.live();
    let until = here.now() + 20.s();
    let call = loop {
        here.run_for(10.ms());
        if let Some(call) = served.try_next() {
            break call;
        }
        assert!(here.now() < until, "no call");
    };
    call.reply(Ok(Payload::of(Datum::text("forty-two"))));
    until_reported(&mut here, "replied");
    let replies = replies.lock().unwrap();
    let Err(CallError::Fault(fault)) = &replies[0] else {
        panic!("{replies:?}");
    };
    assert_eq!(fault.code, "BAD_REPLY");
    let names = "reply of `Provider.sums.double` of robot `depot`";
    assert!(fault.detail.contains(names), "{fault}");
}
