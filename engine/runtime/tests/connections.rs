//! Connections, topics, properties and the errors of building a system.

use std::sync::{Arc, Mutex};

use crate::common::{Double, Number, Twist, Words, behaviour, burst, counter, number};
use asmotion_component::{
    Activity, Component, Cycle, Fault, Flow, Interface, OnStale, Policy, Property, Setup, Span,
    State, Time, Wire,
};
use asmotion_datum::{Datum, Schema};
use asmotion_runtime::{Log, Run, System};

type Seen<T> = Arc<Mutex<Vec<T>>>;

fn at(ms: u64) -> Time {
    Time::ZERO + ms.ms()
}

/// A driver that follows a command; records time, kind of flow, speed, and whether the command is stale.
fn driver(
    seen: &Seen<(Time, &'static str, f64, bool)>,
) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let seen = Arc::clone(seen);
    behaviour(move |interface| {
        let twist = interface.input::<Twist>("twist", "the command");
        move |cycle| {
            let (kind, speed) = match cycle.read(twist) {
                Flow::NoData => ("none", 0.0),
                Flow::OldData(twist) => ("old", twist.linear),
                Flow::NewData(twist) => ("new", twist.linear),
            };
            let entry = (cycle.now(), kind, speed, cycle.is_stale(twist));
            seen.lock().unwrap().push(entry);
            Ok(())
        }
    })
}

/// Writes one command in its first cycle.
fn commander() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let twist = interface.output::<Twist>("twist", "one command");
        move |cycle| {
            cycle.write(
                twist,
                Twist {
                    linear: 0.5,
                    angular: 0.0,
                },
            );
            Ok(())
        }
    })
}

#[test]
fn a_stale_command_is_kept_forgotten_or_becomes_zero_once() {
    for (on_stale, expected) in [
        (
            OnStale::Hold,
            [("new", 0.5), ("old", 0.5), ("old", 0.5), ("old", 0.5)],
        ),
        (
            OnStale::NoData,
            [("new", 0.5), ("old", 0.5), ("none", 0.0), ("none", 0.0)],
        ),
        (
            OnStale::Zero,
            [("new", 0.5), ("old", 0.5), ("new", 0.0), ("old", 0.0)],
        ),
    ] {
        let seen = Seen::default();
        let mut system = System::new();
        system
            .add("Commander", Activity::event(), commander())
            .unwrap();
        system
            .add("Driver", Activity::periodic(100.ms()), driver(&seen))
            .unwrap();
        let policy = Policy::data().max_age(150.ms()).on_stale(on_stale);
        system
            .connect("Commander.twist", "Driver.twist", policy)
            .unwrap();
        system.simulate().run_until(at(300));
        let seen = seen.lock().unwrap();
        let flows: Vec<_> = seen
            .iter()
            .map(|(_, kind, speed, _)| (*kind, *speed))
            .collect();
        assert_eq!(flows, expected, "{on_stale:?}");
        let stale: Vec<_> = seen.iter().map(|(.., stale)| *stale).collect();
        assert_eq!(stale, [false, false, true, true], "{on_stale:?}");
    }
}

#[test]
fn a_command_that_comes_again_is_fresh_again() {
    let seen = Seen::default();
    let mut system = System::new();
    system
        .add("Commander", Activity::manual(), commander())
        .unwrap();
    system
        .add("Driver", Activity::periodic(100.ms()), driver(&seen))
        .unwrap();
    let policy = Policy::data().max_age(50.ms()).on_stale(OnStale::Zero);
    system
        .connect("Commander.twist", "Driver.twist", policy)
        .unwrap();
    let mut run = system.simulate();
    for _ in 0..2 {
        run.run_for(190.ms());
        run.trigger("Commander").unwrap();
        run.run_for(110.ms());
    }
    let flows: Vec<_> = seen
        .lock()
        .unwrap()
        .iter()
        .map(|(_, kind, speed, _)| (*kind, *speed))
        .collect();
    let zero_after = ("new", 0.0);
    assert_eq!(
        flows[..4],
        [("none", 0.0), ("none", 0.0), ("new", 0.5), zero_after]
    );
    assert_eq!(flows[4..], [("old", 0.0), ("new", 0.5), zero_after]);
}

#[test]
fn o8_a_mandatory_connection_that_is_full_is_an_error_of_the_writer() {
    let mut system = System::new();
    system.add("Burst", Activity::manual(), burst(3)).unwrap();
    system
        .add("Reader", Activity::manual(), any_reader())
        .unwrap();
    system
        .connect("Burst.n", "Reader.n", Policy::buffer(2).mandatory())
        .unwrap();
    let mut run = system.simulate();
    run.trigger("Burst").unwrap();
    run.run_for(1.ms());
    assert_eq!(run.state("Burst"), Some(State::RunTimeError));
    assert_eq!(
        run.fault("Burst"),
        Some(Fault::NotDelivered {
            port: "n".into(),
            to: "Reader.n".into()
        })
    );
}

fn any_reader() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        interface.input::<Number>("n", "numbers");
        |_| Ok(())
    })
}

#[test]
fn o10_a_reader_that_does_not_read_costs_another_reader_nothing() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    system
        .add("Paused", Activity::manual(), any_reader())
        .unwrap();
    let all: Seen<i64> = Seen::default();
    let keep = Arc::clone(&all);
    let reading = behaviour(move |interface| {
        let input = interface.input::<Number>("n", "numbers");
        move |cycle| {
            keep.lock()
                .unwrap()
                .extend(cycle.all(input).iter().map(|sample| sample.n));
            Ok(())
        }
    });
    system
        .add("Local", Activity::periodic(50.ms()), reading)
        .unwrap();
    system
        .connect("Counter.n", "Paused.n", Policy::buffer(4))
        .unwrap();
    system
        .connect("Counter.n", "Local.n", Policy::buffer(8))
        .unwrap();
    system.simulate().run_until(at(1000));
    assert_eq!(*all.lock().unwrap(), (1..=101).collect::<Vec<_>>());
    assert!(log.lines_with("-> Local.n").is_empty());
    assert_eq!(log.lines_with("-> Paused.n").len(), 97);
}

#[test]
fn a_topic_joins_all_publishers_with_all_subscribers() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let saying = |n: i64| {
        behaviour(move |interface| {
            let out = interface.output::<Number>("n", "a number");
            move |cycle| {
                cycle.write(out, number(n));
                Ok(())
            }
        })
    };
    let adding = || {
        behaviour(|interface| {
            let input = interface.input::<Number>("n", "numbers");
            move |cycle| {
                let sum = cycle.all(input).iter().map(|sample| sample.n).sum();
                cycle.report("sum", Datum::Int(sum));
                Ok(())
            }
        })
    };
    system.add("A", Activity::event(), saying(1)).unwrap();
    system.add("B", Activity::event(), saying(20)).unwrap();
    system
        .add("X", Activity::periodic(1.s()), adding())
        .unwrap();
    system
        .add("Y", Activity::periodic(1.s()), adding())
        .unwrap();
    // the order of subscribing and publishing does not matter
    system
        .subscribe("numbers", "X.n", Policy::buffer(8))
        .unwrap();
    system.publish("A.n", "numbers").unwrap();
    system
        .subscribe("numbers", "Y.n", Policy::buffer(8))
        .unwrap();
    system.publish("B.n", "numbers").unwrap();
    system.simulate().run_until(at(10));
    assert_eq!(log.lines_with("sum"), ["0 s X: sum: 21", "0 s Y: sum: 21"]);
    assert_eq!(
        log.lines_with(".n #"),
        [
            "0 s A.n #1 on numbers = {n: 1}",
            "0 s B.n #1 on numbers = {n: 20}"
        ]
    );
}

/// A component with one of each kind of declaration.
fn everything() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        interface.input::<Number>("in", "numbers");
        interface.output::<Words>("words", "words");
        interface.output_of("opaque", Schema::opaque("test/Number"), "by name");
        interface.serve::<Double>("sums", "doubles");
        let other = interface.require::<Double>("others", "doubles elsewhere");
        interface.optional(other);
        let speed = interface
            .setting("speed_mps", 0.6, "cruise speed")
            .range(0.0..=5.0)
            .unit("m/s")
            .declare();
        interface
            .setting("algorithm", "astar".to_owned(), "how to search")
            .choices(["astar", "lattice"])
            .declare();
        interface.property("seeds", vec![1.0, 2.0], "numbers");
        let count = interface.property("count", 3_i64, "a number");
        move |cycle| {
            let sum = cycle.property(speed) + cycle.property(count) as f64;
            cycle.report("sum", Datum::Float(sum));
            Ok(())
        }
    })
}

#[test]
fn t8_t22_what_does_not_fit_is_an_error_before_anything_runs() {
    let mut system = System::new();
    system.add("It", Activity::event(), everything()).unwrap();
    system.add("Counter", Activity::event(), counter()).unwrap();
    system
        .add("Driver", Activity::event(), driver(&Seen::default()))
        .unwrap();
    system
        .add(
            "Nested.Doubler",
            Activity::event(),
            crate::common::doubler(),
        )
        .unwrap();
    let data = Policy::data;
    let mut errors = Vec::new();
    let mut refused = |result: Result<(), asmotion_runtime::BuildError>| {
        errors.push(result.unwrap_err().to_string())
    };
    refused(system.connect("Counter.n", "Driver.twist", data()));
    refused(system.connect("It.opaque", "Driver.twist", data()));
    refused(system.connect("Countr.n", "It.in", data()));
    refused(system.connect("Counter.m", "It.in", data()));
    refused(system.connect("It.in", "Counter.n", data()));
    refused(system.wire("It.others", "It.sum", Wire::default()));
    system.connect("It.opaque", "It.in", data()).unwrap();
    refused(system.connect("It.opaque", "It.in", data()));
    system
        .wire("It.others", "Nested.Doubler.sums", Wire::default())
        .unwrap();
    refused(system.wire("It.others", "It.sums", Wire::default()));
    system.publish("Counter.n", "numbers").unwrap();
    refused(system.publish("Counter.n", "more"));
    refused(system.subscribe("numbers", "Driver.twist", data()));
    system.subscribe("numbers", "It.in", data()).unwrap();
    refused(system.subscribe("numbers", "It.in", data()));
    assert_eq!(
        errors,
        [
            "`Counter.n` and `Driver.twist` differ: test/Number here, test/Twist there",
            "`It.opaque` and `Driver.twist` differ: test/Number here, test/Twist there",
            "unknown component `Countr`; did you mean `Counter`?",
            "unknown output `Counter.m`",
            "`It.in` is an input, not an output",
            "unknown service `It.sum`; did you mean `It.sums`?",
            "`It.opaque` is already connected to `It.in`",
            "`It.others` is already connected to `Nested.Doubler.sums`",
            "`Counter.n` is already connected to topic `numbers`",
            "`Counter.n` and `Driver.twist` differ: test/Number here, test/Twist there",
            "`It.in` is already connected to topic `numbers`",
        ]
    );
}

#[test]
fn t15_a_component_has_a_name_of_its_own() {
    let mut system = System::new();
    system.add("It", Activity::event(), counter()).unwrap();
    let twice = system.add("It", Activity::event(), counter()).unwrap_err();
    assert_eq!(
        twice.to_string(),
        "invalid component name `It`: it is empty or taken"
    );
    assert!(system.add("", Activity::event(), counter()).is_err());
    let confused = behaviour(|interface| {
        interface.output::<Number>("n", "once");
        interface.output::<Number>("n", "twice");
        |_| Ok(())
    });
    let error = system
        .add("Confused", Activity::event(), confused)
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "component `Confused`: duplicate output `n`"
    );
}

#[test]
fn c9_a_property_out_of_its_range_is_refused_with_the_range_shown() {
    let mut system = System::new();
    let it = system.add("It", Activity::event(), everything()).unwrap();
    let mut set = |name: &str, value: Datum| system.set_property(it, name, &value);
    assert_eq!(set("speed_mps", Datum::Float(5.0)), Ok(()));
    assert_eq!(
        set("speed_mps", Datum::Int(2)),
        Ok(()),
        "a whole number is a number"
    );
    assert_eq!(set("algorithm", "lattice".into()), Ok(()));
    assert_eq!(set("seeds", Datum::List(vec![Datum::Int(1)])), Ok(()));
    let errors = [
        ("speed_mps", Datum::Float(5.5)),
        ("speed_mps", Datum::Float(f64::NAN)),
        ("speed_mps", "fast".into()),
        ("algorithm", "dijkstra".into()),
        ("speed", Datum::Float(1.0)),
    ]
    .map(|(name, value)| set(name, value).unwrap_err().to_string());
    assert_eq!(
        errors,
        [
            "property `speed_mps` of `It` must be between 0.0 and 5.0 m/s, not 5.5",
            "property `speed_mps` of `It` must be between 0.0 and 5.0 m/s, not NaN",
            "property `speed_mps` of `It` must be float64: invalid type: string \"fast\", expected f64",
            "property `algorithm` of `It` must be one of \"astar\", \"lattice\", not \"dijkstra\"",
            "property `speed` of `It` does not exist",
        ]
    );
}

#[test]
fn t10_properties_are_there_when_a_component_is_configured() {
    struct Careful {
        radius: Property<f64>,
        seen: Arc<Mutex<Vec<(String, f64)>>>,
    }
    impl Component for Careful {
        fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
            let seen = (setup.name().to_owned(), setup.property(self.radius));
            self.seen.lock().unwrap().push(seen);
            Ok(())
        }

        fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
            Ok(())
        }
    }
    let seen: Arc<Mutex<Vec<(String, f64)>>> = Arc::default();
    let mut system = System::new();
    for name in ["A", "B"] {
        let seen = Arc::clone(&seen);
        let add = |interface: &mut Interface| -> Box<dyn Component> {
            let radius = interface
                .setting("radius_m", 0.3, "its radius")
                .unit("m")
                .declare();
            Box::new(Careful { radius, seen })
        };
        system.add(name, Activity::event(), add).unwrap();
    }
    let b = system.id("B").unwrap();
    system
        .set_property(b, "radius_m", &Datum::Float(0.5))
        .unwrap();
    system.simulate();
    assert_eq!(
        *seen.lock().unwrap(),
        [("A".to_owned(), 0.3), ("B".to_owned(), 0.5)]
    );
}

#[test]
fn o12_properties_change_at_cycle_borders_all_or_none() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("It", Activity::periodic(10.ms()), everything())
        .unwrap();
    let mut run = system.simulate();
    run.run_until(at(5));
    let values = |speed: f64, count: i64| {
        [
            ("speed_mps".to_owned(), Datum::Float(speed)),
            ("count".to_owned(), Datum::Int(count)),
        ]
    };
    run.set_properties("It", &values(1.0, 10)).unwrap();
    run.run_until(at(15));
    assert!(run.set_properties("It", &values(9.0, 20)).is_err());
    run.run_until(at(25));
    assert_eq!(
        log.lines_with("sum"),
        [
            "0 s It: sum: 3.6",
            "0.01 s It: sum: 11.0",
            "0.02 s It: sum: 11.0"
        ]
    );
    assert_eq!(
        log.lines_with(":="),
        ["0.01 s It.speed_mps := 1.0", "0.01 s It.count := 10"]
    );
    let (name, value) = run.properties("It").unwrap().swap_remove(0);
    assert_eq!((name.as_str(), value), ("speed_mps", Datum::Float(1.0)));
}

#[test]
fn a_declaration_is_plain_data() {
    let mut interface = Interface::new();
    everything()(&mut interface);
    let declaration = interface.declaration();
    assert_eq!(declaration.input("in").unwrap().schema.name, "test/Number");
    assert_eq!(
        declaration.output("opaque").unwrap().schema.to_string(),
        "test/Number"
    );
    assert_eq!(
        declaration.service("sums").unwrap().interface,
        "test/Arithmetic"
    );
    assert!(declaration.reference("others").unwrap().optional);
    let speed = declaration.property("speed_mps").unwrap();
    assert_eq!(speed.unit, "m/s");
    assert_eq!(speed.range, Some((Datum::Float(0.0), Datum::Float(5.0))));
    let text = asmotion_datum::json::encode(declaration).unwrap();
    assert_eq!(
        asmotion_datum::json::decode::<asmotion_component::Declaration>(&text).unwrap(),
        *declaration
    );
}
