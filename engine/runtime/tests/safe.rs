//! The last cycle: what a component says when it stops or fails, and the safe samples of its outputs.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::common::{Double, Number, Twist, number};

use asmotion_component::{
    Activity, AwaitedWriters, CallError, Component, Cycle, Fault, In, Interface, OnException, Out,
    Provided, RequestId, Span, State, Time, Transition,
};
use asmotion_datum::Datum;
use asmotion_port::Policy;
use asmotion_runtime::{BuildError, Change, Log, Run, System};

const DRIVES: Twist = Twist {
    linear: 1.0,
    angular: 0.5,
};

const STANDS: Twist = Twist {
    linear: 0.0,
    angular: 0.0,
};

/// End of a driver.
#[derive(Clone, Copy, PartialEq)]
enum Ending {
    Normal,
    Fault,
    Panic,
    PanicInStop,
}

/// Drives in every cycle, fails in its third if it is to, and answers its requests when it stops.
struct Driver {
    twist: Out<Twist>,
    log: Out<Number>,
    sums: Provided<Double>,
    waiting: Vec<RequestId>,
    ending: Ending,
}

impl Driver {
    fn construct(ending: Ending) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
        move |interface| {
            let twist = interface.output("twist", "velocity");
            Box::new(Self {
                twist: interface.safe(twist, STANDS),
                log: interface.output("log", "-1 when it stops"),
                sums: interface.serve("sums", "answers at the end"),
                waiting: Vec::new(),
                ending,
            })
        }
    }
}

impl Component for Driver {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let requests = cycle.requests(self.sums);
        self.waiting
            .extend(requests.iter().map(|request| request.id));
        cycle.write(self.twist, DRIVES);
        match self.ending {
            Ending::Fault if cycle.number() == 3 => Err(Fault::new("broken")),
            Ending::Panic if cycle.number() == 3 => panic!("broken"),
            Ending::Normal | Ending::Fault | Ending::Panic | Ending::PanicInStop => Ok(()),
        }
    }

    fn stop(&mut self, cycle: &mut Cycle<'_>) {
        cycle.write(self.log, number(-1));
        for request in self.waiting.drain(..) {
            cycle.reply(self.sums, request, Ok(number(-2)));
        }
        assert!(self.ending != Ending::PanicInStop, "broken");
    }
}

fn system(ending: Ending, activity: Activity) -> (System, Log) {
    let mut system = System::new();
    let log = Log::new();
    system.observe(log.clone());
    let driver = Driver::construct(ending);
    system.add("Driver", activity, driver).unwrap();
    (system, log)
}

fn twists(log: &Log) -> Vec<Twist> {
    let samples = log.samples::<Twist>("Driver.twist");
    samples.into_iter().map(|(_, twist)| twist).collect()
}

#[test]
fn a_stopped_component_says_its_last_words_and_the_engine_its_safe_ones() {
    let (system, log) = system(Ending::Normal, Activity::periodic(100.ms()));
    let mut run = system.simulate();
    let asked = run
        .send::<Double>("Driver.sums", number(1), 10.s())
        .unwrap();
    run.run_until(Time::ZERO + 150.ms());
    run.transition("Driver", Transition::Stop).unwrap();
    let stop = Time::ZERO + 150.ms();
    assert_eq!(log.samples("Driver.log"), [(stop, number(-1))]);
    assert_eq!(twists(&log), [DRIVES, DRIVES, STANDS]);
    assert_eq!(run.collect(asked), Ok(number(-2)));
    run.transition("Driver", Transition::Start).unwrap();
    run.run_for(50.ms());
    assert_eq!(twists(&log).last(), Some(&DRIVES), "it drives again");
}

#[test]
fn the_last_sample_of_a_failed_component_is_the_safe_one() {
    for ending in [Ending::Fault, Ending::Panic] {
        let (system, log) = system(ending, Activity::periodic(100.ms()));
        let mut run = system.simulate();
        run.run_for(1.s());
        assert_eq!(run.state("Driver"), Some(State::Exception));
        assert_eq!(twists(&log), [DRIVES, DRIVES, STANDS]);
    }
}

#[test]
fn a_reset_after_a_fault_starts_from_the_safe_sample() {
    let activity = Activity::periodic(100.ms()).on_exception(OnException::Reset);
    let (system, log) = system(Ending::Fault, activity);
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 300.ms());
    assert_eq!(run.state("Driver"), Some(State::Running));
    assert_eq!(&twists(&log)[..4], [DRIVES, DRIVES, STANDS, DRIVES]);
}

#[test]
fn a_panic_while_stopping_cannot_hold_back_the_safe_sample() {
    let (system, log) = system(Ending::PanicInStop, Activity::periodic(100.ms()));
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 50.ms());
    assert!(run.transition("Driver", Transition::Stop).is_err());
    assert_eq!(run.state("Driver"), Some(State::FatalError));
    assert_eq!(twists(&log).last(), Some(&STANDS));
    assert!(log.samples::<Number>("Driver.log").is_empty(), "discarded");
}

#[test]
fn the_end_of_a_run_stops_every_component_safely() {
    let (system, log) = system(Ending::Normal, Activity::periodic(100.ms()));
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 250.ms());
    assert!(run.stop().is_empty());
    assert_eq!(twists(&log), [DRIVES, DRIVES, DRIVES, STANDS]);
}

#[test]
fn the_end_of_a_live_run_stops_every_component_safely() {
    let (system, log) = system(Ending::Normal, Activity::periodic(10.ms()));
    let mut run = system.live();
    run.run_for(Duration::from_millis(100));
    assert!(twists(&log).contains(&DRIVES));
    // without a call of `stop`
    drop(run);
    assert_eq!(twists(&log).last(), Some(&STANDS));
}

#[test]
fn a_component_that_never_ran_says_nothing() {
    let activity = Activity::periodic(100.ms()).run_on_startup(false);
    let (system, log) = system(Ending::Normal, activity);
    let mut run = system.simulate();
    run.run_for(1.s());
    run.stop();
    assert_eq!(twists(&log), []);
}

#[test]
fn a_composite_chooses_another_safe_sample() {
    let (mut system, log) = system(Ending::Normal, Activity::periodic(100.ms()));
    let turns = Datum::record([("angular", Datum::Float(0.1))]);
    system.set_safe_sample("Driver.twist", &turns).unwrap();
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 50.ms());
    run.stop();
    let expected = Twist {
        angular: 0.1,
        ..STANDS
    };
    assert_eq!(twists(&log), [DRIVES, expected]);
}

#[test]
fn a_safe_sample_of_another_type_or_for_no_output_is_refused() {
    let (mut system, _) = system(Ending::Normal, Activity::manual());
    let wrong = Datum::record([("linear", Datum::text("fast"))]);
    let refused = system.set_safe_sample("Driver.twist", &wrong);
    assert!(
        matches!(refused, Err(BuildError::SafeSample { .. })),
        "{refused:?}"
    );
    let unknown = system.set_safe_sample("Driver.twits", &Datum::Null);
    let text = unknown.unwrap_err().to_string();
    assert_eq!(
        text,
        "unknown output `Driver.twits`; did you mean `Driver.twist`?"
    );
}

#[test]
fn calls_of_the_last_cycle_end_as_cancelled() {
    /// Calls when it stops, and keeps what becomes of it.
    struct Asker {
        sums: asmotion_component::Required<Double>,
        results: std::sync::Arc<std::sync::Mutex<Vec<CallError>>>,
    }

    impl Component for Asker {
        fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
            let failed = cycle.replies(self.sums).into_iter();
            let failed = failed.filter_map(|reply| reply.result.err());
            self.results.lock().unwrap().extend(failed);
            Ok(())
        }

        fn stop(&mut self, cycle: &mut Cycle<'_>) {
            cycle.call(self.sums, number(2));
        }
    }

    let (mut system, log) = system(Ending::Normal, Activity::periodic(100.ms()));
    let results = std::sync::Arc::default();
    let kept = std::sync::Arc::clone(&results);
    let asker = move |interface: &mut Interface| -> Box<dyn Component> {
        Box::new(Asker {
            sums: interface.require("sums", "asks"),
            results: kept,
        })
    };
    system
        .add("Asker", Activity::periodic(100.ms()), asker)
        .unwrap();
    let wire = asmotion_component::Wire::default();
    system.wire("Asker.sums", "Driver.sums", wire).unwrap();
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 150.ms());
    run.transition("Asker", Transition::Stop).unwrap();
    run.run_until(Time::ZERO + 250.ms());
    run.transition("Asker", Transition::Start).unwrap();
    run.run_for(1.s());
    assert_eq!(*results.lock().unwrap(), []);
    run.stop();
    // the call was never answered: its caller had stopped
    assert_eq!(log.samples::<Number>("Driver.log").len(), 1);
}

type Left = Arc<Mutex<Vec<Twist>>>;

/// Passes on what it takes, to another component and to the world outside.
struct Carrier {
    taken: In<Twist>,
    passed: Out<Twist>,
    awaited_writers: AwaitedWriters,
    left: Left,
}

impl Component for Carrier {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for sample in cycle.all(self.taken).to_vec() {
            self.left.lock().unwrap().push(sample);
            cycle.write(self.passed, sample);
        }
        Ok(())
    }

    fn awaited_writers(&self) -> AwaitedWriters {
        self.awaited_writers
    }
}

/// A system of a driver, a carrier `Near` that reads it, and a carrier `Far` that reads that one, added in this order. Returns it
/// with what leaves the two.
fn carried(order: [&str; 3], near: AwaitedWriters, far: AwaitedWriters) -> (System, [Left; 2]) {
    let (mut system, left) = (System::new(), [Left::default(), Left::default()]);
    for name in order {
        let activity = Activity::periodic(10.ms());
        if name == "Driver" {
            let driver = Driver::construct(Ending::Normal);
            system.add(name, activity, driver).unwrap();
            continue;
        }
        let (awaited_writers, place) = if name == "Near" { (near, 0) } else { (far, 1) };
        let left = Arc::clone(&left[place]);
        let carrier = move |interface: &mut Interface| -> Box<dyn Component> {
            Box::new(Carrier {
                taken: interface.input("taken", "velocity"),
                passed: interface.output("passed", "velocity"),
                awaited_writers,
                left,
            })
        };
        system.add(name, activity, carrier).unwrap();
    }
    let policy = Policy::buffer(64);
    system
        .connect("Driver.twist", "Near.taken", policy.clone())
        .unwrap();
    system.connect("Near.passed", "Far.taken", policy).unwrap();
    (system, left)
}

const ORDERS: [[&str; 3]; 6] = [
    ["Driver", "Near", "Far"],
    ["Driver", "Far", "Near"],
    ["Near", "Driver", "Far"],
    ["Near", "Far", "Driver"],
    ["Far", "Driver", "Near"],
    ["Far", "Near", "Driver"],
];

fn last_of(left: &Left) -> Option<Twist> {
    left.lock().unwrap().last().copied()
}

#[test]
fn the_safe_sample_passes_through_bridges_added_in_any_order() {
    for order in ORDERS {
        for near in [AwaitedWriters::Safe, AwaitedWriters::All] {
            let (system, left) = carried(order, near, AwaitedWriters::All);
            let mut run = system.simulate();
            run.run_until(Time::ZERO + 105.ms());
            run.stop();
            let last = left.each_ref().map(last_of);
            assert_eq!(last, [Some(STANDS); 2], "{order:?}, {near:?}");
            let (system, left) = carried(order, near, AwaitedWriters::All);
            let mut run = system.live();
            run.run_for(50.ms());
            drop(run);
            let last = left.each_ref().map(last_of);
            assert_eq!(last, [Some(STANDS); 2], "{order:?}, {near:?}");
        }
    }
}

#[test]
fn bridges_that_are_removed_take_the_safe_sample_first() {
    for order in ORDERS {
        let (system, left) = carried(order, AwaitedWriters::Safe, AwaitedWriters::All);
        let mut run = system.live();
        run.run_for(50.ms());
        let remove = |name: &str| Change::Remove {
            component: name.to_owned(),
        };
        let changes = ["Near", "Driver", "Far"].map(remove);
        run.change(&changes).unwrap();
        assert_eq!(last_of(&left[0]), Some(STANDS), "{order:?}");
    }
}

/// No order makes both right, so the one added last stops first.
#[test]
fn bridges_that_read_each_other_stop_all_the_same() {
    for order in ORDERS {
        let (mut system, left) = carried(order, AwaitedWriters::All, AwaitedWriters::All);
        let back = system.connect("Far.passed", "Near.taken", Policy::buffer(64));
        back.unwrap();
        let mut run = system.live();
        run.run_for(50.ms());
        assert!(run.stop().is_empty());
        for component in order {
            assert_eq!(run.state(component), Some(State::Stopped));
        }
        let near = left[0].lock().unwrap();
        assert!(near.contains(&STANDS), "{order:?}: {near:?}");
    }
}

#[test]
fn without_new_samples_a_bridge_has_no_further_cycle_and_others_never_have_one() {
    let (system, left) = carried(ORDERS[0], AwaitedWriters::None, AwaitedWriters::All);
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 105.ms());
    let cycles = ["Near", "Far"].map(|name| run.cycles(name));
    run.stop();
    assert_eq!(["Near", "Far"].map(|name| run.cycles(name)), cycles);
    assert_eq!(left.each_ref().map(last_of), [Some(DRIVES); 2]);
}
