//! What a component counts, declares and describes is what its runtime and its tools see.

use std::sync::{Arc, Mutex};

use crate::common::{Double, Number, behaviour, burst, number};
use asmotion_component::{
    Activity, Component, Cycle, Fault, Freeze, In, Interface, Losses, OnStale, Out, Policy,
    Properties, PropertySet, Provided, Span, Time, Transition, freeze_by_fields,
};
use asmotion_datum::Datum;
use asmotion_runtime::{Log, Run, Simulation, System};

/// Counts the samples of its input as lost, and sets its other losses in every second cycle.
fn losing() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let (used, unused) = (
            interface.input::<Number>("used", "used samples"),
            interface.input::<Number>("unused", "samples that are dropped"),
        );
        move |cycle: &mut Cycle<'_>| {
            let count = cycle.all(unused).len() as u64;
            cycle.count_lost(unused, count);
            let _ = cycle.all(used);
            if cycle.number() % 2 == 0 {
                let number = cycle.number();
                cycle.set_losses(Losses {
                    dropped: number,
                    misfits: 10 * number,
                });
            }
            Ok(())
        }
    })
}

#[test]
fn losses_are_those_of_the_inputs_and_those_that_the_component_sets() {
    let mut system = System::new();
    let periodic = || Activity::periodic(10.ms());
    system.add("Burst", periodic(), burst(3)).unwrap();
    system.add("Losing", periodic(), losing()).unwrap();
    for port in ["Losing.used", "Losing.unused"] {
        system.connect("Burst.n", port, Policy::buffer(8)).unwrap();
    }
    let mut run = system.simulate();
    // cycles at 0, 10, 20, 30 and 40 ms; each sees three samples of each input
    run.run_until(Time::ZERO + 45.ms());
    let inputs = run.lost("Losing");
    assert_eq!(inputs.len(), 2);
    let seen = inputs[1];
    assert!(
        inputs[0] == 0 && seen >= 12 && seen.is_multiple_of(3),
        "{inputs:?}"
    );
    let losses = Losses {
        dropped: seen + 4,
        misfits: 40,
    };
    assert_eq!(run.losses("Losing"), losses);
}

#[test]
fn a_component_reads_how_many_messages_each_of_its_inputs_has_lost() {
    let (mut system, seen) = (System::new(), Arc::new(Mutex::new(Vec::new())));
    let record = Arc::clone(&seen);
    let reader = behaviour(move |interface| {
        let inputs = ["narrow", "wide"].map(|name| interface.input::<Number>(name, name));
        move |cycle| {
            record.lock().unwrap().push(inputs.map(|it| cycle.lost(it)));
            for input in inputs {
                cycle.all(input);
            }
            Ok(())
        }
    });
    let periodic = || Activity::periodic(10.ms());
    system.add("Burst", periodic(), burst(3)).unwrap();
    system.add("Reader", periodic(), reader).unwrap();
    for (port, size) in [("Reader.narrow", 2), ("Reader.wide", 3)] {
        system
            .connect("Burst.n", port, Policy::buffer(size))
            .unwrap();
    }
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 25.ms());
    // each cycle follows three samples, of which the narrow queue has dropped one
    assert_eq!(*seen.lock().unwrap(), [[1, 0], [2, 0], [3, 0]]);
    assert_eq!(run.lost("Reader"), [3, 0]);
}

/// Takes odd numbers only.
fn picky() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let input = interface.input::<Number>("n", "odd numbers");
        move |cycle| {
            let all = cycle.all(input).iter().map(|number| number.n);
            let even: Vec<i64> = all.filter(|n| n % 2 == 0).collect();
            for _ in even {
                cycle.refuse(input, "expected an odd number, found an even one");
            }
            Ok(())
        }
    })
}

#[test]
fn samples_that_a_component_refuses_are_counted_and_their_cause_is_reported_once() {
    let (log, mut system) = (Log::new(), System::new());
    system.observe(log.clone());
    let periodic = || Activity::periodic(10.ms());
    system.add("Burst", periodic(), burst(4)).unwrap();
    system.add("Picky", periodic(), picky()).unwrap();
    system
        .connect("Burst.n", "Picky.n", Policy::buffer(8))
        .unwrap();
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 45.ms());
    // the component that is added first runs first, so each of 5 cycles sees four samples, of which two are even
    let losses = Losses {
        dropped: 0,
        misfits: 10,
    };
    assert_eq!(run.losses("Picky"), losses);
    let reports = log.lines_with("refuses");
    assert_eq!(reports.len(), 1, "{reports:?}");
    let text = "`n` refuses a message: expected an odd number, found an even one";
    assert!(reports[0].contains(text), "{reports:?}");
}

#[test]
fn each_sample_says_until_when_its_connection_allows_its_use() {
    let mut system = System::new();
    let seen = Arc::new(Mutex::new(Vec::new()));
    let record = Arc::clone(&seen);
    let reader = behaviour(move |interface| {
        let inputs = ["limited", "held", "free"].map(|name| interface.input::<Number>(name, name));
        move |cycle| {
            let expiries = inputs.map(|input| cycle.expiries(input).to_vec());
            record.lock().unwrap().push((cycle.now(), expiries));
            Ok(())
        }
    });
    let periodic = || Activity::periodic(10.ms());
    system.add("Burst", periodic(), burst(2)).unwrap();
    system.add("Reader", periodic(), reader).unwrap();
    let (aged, drops) = (Policy::buffer(8).max_age(30.ms()), OnStale::NoData);
    let policies = [
        ("limited", aged.clone().on_stale(drops)),
        ("held", aged),
        ("free", Policy::buffer(8)),
    ];
    for (input, policy) in policies {
        let input = format!("Reader.{input}");
        system.connect("Burst.n", &input, policy).unwrap();
    }
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 25.ms());
    let seen = seen.lock().unwrap();
    assert_eq!(seen.len(), 3);
    for (at, [limited, held, free]) in &*seen {
        assert_eq!(*limited, [Some(*at + 30.ms()); 2], "at {at}");
        // a connection that holds a stale sample sets no limit
        assert_eq!(*held, [None; 2], "at {at}");
        assert_eq!(*free, [None; 2], "at {at}");
    }
}

/// Replies with 1 while it runs, and with 0 while it is stopped.
struct Answering {
    double: Provided<Double>,
}

impl Answering {
    fn answer(&self, cycle: &mut Cycle<'_>) {
        let is_running = i64::from(cycle.is_running());
        for request in cycle.requests(self.double) {
            cycle.reply(self.double, request.id, Ok(number(is_running)));
        }
    }
}

impl Component for Answering {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.answer(cycle);
        Ok(())
    }

    fn serve(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.answer(cycle);
        Ok(())
    }
}

#[test]
fn a_cycle_knows_whether_its_component_runs() {
    let mut system = System::new();
    let answering = |interface: &mut Interface| -> Box<dyn Component> {
        let double = interface.serve::<Double>("sums", "tells whether it runs");
        Box::new(Answering {
            double: interface.while_stopped(double),
        })
    };
    system
        .add("Answering", Activity::periodic(10.ms()), answering)
        .unwrap();
    let mut run = system.simulate();
    let asked = |run: &mut Simulation| {
        let sent = run
            .send::<Double>("Answering.sums", number(7), 1.s())
            .unwrap();
        run.run_for(30.ms());
        run.collect(sent).unwrap().n
    };
    assert_eq!(asked(&mut run), 1);
    run.transition("Answering", Transition::Stop).unwrap();
    assert_eq!(asked(&mut run), 0);
    run.transition("Answering", Transition::Start).unwrap();
    assert_eq!(asked(&mut run), 1);
}

/// A component that describes nothing.
struct Plain;

impl Component for Plain {
    fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
        Ok(())
    }
}

#[test]
fn a_component_describes_nothing_by_default() {
    assert_eq!(Plain.inspect(), []);
}

#[test]
fn choices_set_by_a_component_are_declared_and_checked() {
    let declare = |interface: &mut Interface| {
        interface.property("gear", "low".to_owned(), "gear");
        interface.property("speed", 1_i64, "speed");
        interface.set_choices("gear", ["low", "high"]);
        interface.set_choices("absent", ["x"]);
    };
    let mut interface = Interface::new();
    declare(&mut interface);
    assert_eq!(interface.problems(), []);
    let choices = |name: &str| {
        interface
            .declaration()
            .property(name)
            .unwrap()
            .choices
            .clone()
    };
    assert_eq!(choices("gear"), ["low".into(), "high".into()]);
    assert_eq!(choices("speed"), []);
    // a default that is not among them
    interface.set_choices("speed", [2_i64, 3]);
    assert_eq!(interface.problems().len(), 1);

    let mut system = System::new();
    let component = system.add("Car", Activity::event(), |interface| {
        declare(interface);
        Box::new(Plain)
    });
    let car = component.unwrap();
    let mut set = |name: &str, value: Datum| system.set_property(car, name, &value);
    assert!(set("gear", "high".into()).is_ok());
    assert!(set("gear", "third".into()).is_err());
    assert!(set("speed", 9_i64.into()).is_ok());
}

#[test]
fn a_value_is_checked_by_converting_it_to_the_type_of_its_property() {
    let mut interface = Interface::new();
    interface.property("port", 80_u16, "port");
    let port = &interface.declaration().property("port").unwrap().conversion;
    assert!(port.check(&Datum::Int(443)).is_ok());
    for value in [Datum::Int(70_000), Datum::Int(-1), Datum::text("http")] {
        assert!(port.check(&value).is_err(), "{value:?}");
    }
    // without a known type, the schema alone decides
    let unknown = asmotion_component::PropertyConversion::default();
    assert!(unknown.check(&Datum::text("http")).is_ok());
}

#[derive(Clone, Debug, PartialEq, Properties)]
struct Settings {
    /// Step of the count.
    #[property(default = 1)]
    step: i64,
}

/// Adds the step that it read in its first cycle, and reads it again when it is told to.
#[derive(Freeze)]
#[freeze(component = "test::Stepping", version = 1)]
struct Stepping {
    #[freeze(skip)]
    out: Out<Number>,
    #[freeze(skip)]
    again: In<Number>,
    settings: PropertySet<Settings>,
    n: i64,
}

impl Component for Stepping {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if cycle.number() == 1 || !cycle.all(self.again).is_empty() {
            self.settings.refresh(cycle);
        }
        self.n += self.settings.step;
        cycle.write(self.out, number(self.n));
        Ok(())
    }
}

#[test]
fn properties_as_of_the_last_refresh_are_frozen_and_read_again_after_thawing() {
    let simulation = |log: &Log| {
        let mut system = System::new();
        system.observe(log.clone());
        let stepping = system.add("Stepping", Activity::periodic(10.ms()), |interface| {
            Box::new(Stepping {
                out: interface.output::<Number>("n", "the count"),
                again: interface.input::<Number>("again", "refreshes"),
                settings: interface.properties(),
                n: 0,
            })
        });
        let five = 5_i64.into();
        system
            .set_property(stepping.unwrap(), "step", &five)
            .unwrap();
        system.simulate()
    };
    let seen = |log: &Log| {
        let samples = log.samples::<Number>("Stepping.n");
        samples.iter().map(|(_, it)| it.n).collect::<Vec<i64>>()
    };
    let logs = [Log::new(), Log::new()];
    let mut original = simulation(&logs[0]);
    original.run_until(Time::ZERO + 5.ms());
    let seven = ("step".to_owned(), 7_i64.into());
    original.set_properties("Stepping", &[seven]).unwrap();
    original.run_until(Time::ZERO + 15.ms());
    // the component has not read its property again
    assert_eq!(seen(&logs[0]), [5, 10]);
    let mut thawed = simulation(&logs[1]);
    thawed.thaw(&original.freeze().unwrap()).unwrap();
    for run in [&mut original, &mut thawed] {
        run.run_until(Time::ZERO + 25.ms());
        run.inject(Time::ZERO + 35.ms(), "Stepping.again", number(0))
            .unwrap();
        run.run_until(Time::ZERO + 55.ms());
    }
    assert_eq!(seen(&logs[0]), [5, 10, 15, 20, 27, 34]);
    assert_eq!(seen(&logs[1]), [15, 20, 27, 34]);
}

/// What is common to several components.
#[derive(Clone, Debug, PartialEq, Properties)]
struct Limits {
    /// Largest value.
    #[property(default = 100)]
    most: i64,
}

#[derive(Clone, Debug, PartialEq, Properties)]
struct Counting {
    /// Step of the count.
    #[property(default = 1)]
    step: i64,
    #[property(flatten)]
    limits: Limits,
}

/// Adds the step that it read in its first cycle, up to the limit.
#[derive(Freeze)]
#[freeze(component = "test::Limited", version = 1)]
struct Limited {
    #[freeze(skip)]
    out: Out<Number>,
    settings: PropertySet<Counting>,
    n: i64,
}

impl Component for Limited {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if cycle.number() == 1 {
            self.settings.refresh(cycle);
        }
        self.n = (self.n + self.settings.step).min(self.settings.limits.most);
        cycle.write(self.out, number(self.n));
        Ok(())
    }
}

#[test]
fn a_group_of_properties_is_frozen_and_thawed_with_the_others() {
    let simulation = |log: &Log| {
        let mut system = System::new();
        system.observe(log.clone());
        let limited = system.add("Limited", Activity::periodic(10.ms()), |interface| {
            Box::new(Limited {
                out: interface.output::<Number>("n", "the count"),
                settings: interface.properties(),
                n: 0,
            })
        });
        let limited = limited.unwrap();
        for (name, value) in [("step", 3_i64), ("most", 7)] {
            system.set_property(limited, name, &value.into()).unwrap();
        }
        system.simulate()
    };
    let logs = [Log::new(), Log::new()];
    let mut original = simulation(&logs[0]);
    original.run_until(Time::ZERO + 5.ms());
    let mut thawed = simulation(&logs[1]);
    thawed.thaw(&original.freeze().unwrap()).unwrap();
    thawed.run_until(Time::ZERO + 35.ms());
    let seen = logs[1].samples::<Number>("Limited.n");
    let seen: Vec<i64> = seen.iter().map(|(_, it)| it.n).collect();
    assert_eq!(seen, [6, 7, 7]);
}
