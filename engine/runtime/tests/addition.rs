//! C18: components are added to a running system and removed from it.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::common::{Double, Number, behaviour, counter, doubler, in_real_time, number, run_until};
use asmotion_component::{
    Activity, CallError, Component, Cycle, Fault, Freeze, HEALTH_TOPIC, In, Interface, Out, Policy,
    Setup, Span, State, ThreadUse, Transition, Wire, freeze_by_fields,
};
use asmotion_datum::Datum;
use asmotion_runtime::{
    Change, ComponentAddition, Live, Log, Replacement, Run, Simulation, System,
};

/// The values that a reader has seen, in order.
type Seen = Arc<Mutex<Vec<i64>>>;

fn values(seen: &Seen) -> Vec<i64> {
    seen.lock().unwrap().clone()
}

/// Reads all numbers on its input `n`.
fn reader(seen: &Seen) -> impl FnOnce(&mut Interface) -> Box<dyn Component> + use<> {
    let seen = Arc::clone(seen);
    behaviour(move |interface| {
        let input = interface.input::<Number>("n", "numbers");
        move |cycle| {
            let all = cycle.all(input).iter().map(|sample| sample.n);
            seen.lock().unwrap().extend(all);
            Ok(())
        }
    })
}

/// Calls `double` for its count in every cycle, and keeps the results.
fn asker(replies: &Replies) -> impl FnOnce(&mut Interface) -> Box<dyn Component> + use<> {
    let replies = Arc::clone(replies);
    behaviour(|interface| {
        let double = interface.require::<Double>("sums", "who doubles");
        let mut n = 0;
        move |cycle| {
            let ended = cycle.replies(double).into_iter();
            let ended = ended.map(|reply| reply.result.map(|number| number.n));
            replies.lock().unwrap().extend(ended);
            n += 1;
            cycle.call(double, number(n));
            Ok(())
        }
    })
}

type Replies = Arc<Mutex<Vec<Result<i64, CallError>>>>;

/// Provides the service of `doubler`, and never replies.
fn idler() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let double = interface.serve::<Double>("sums", "does not double");
        move |cycle| {
            cycle.requests(double);
            Ok(())
        }
    })
}

fn add<C>(
    component: &str,
    activity: Activity,
    make: impl Fn() -> C + Send + Sync + 'static,
) -> Change
where
    C: FnOnce(&mut Interface) -> Box<dyn Component>,
{
    let by = ComponentAddition::new("a test", activity, move |interface: &mut Interface| {
        Ok(make()(interface))
    });
    addition(component, by)
}

fn addition(component: &str, by: ComponentAddition) -> Change {
    let component = component.to_owned();
    Change::Add { component, by }
}

fn add_reader(component: &str, seen: &Seen) -> Change {
    let seen = Arc::clone(seen);
    add(component, Activity::event(), move || reader(&seen))
}

fn remove(component: &str) -> Change {
    Change::Remove {
        component: component.to_owned(),
    }
}

fn connect(from: &str, to: &str) -> Change {
    Change::Connect {
        from: from.to_owned(),
        to: to.to_owned(),
        policy: Policy::buffer(100),
    }
}

fn disconnect(from: &str, to: &str) -> Change {
    Change::Disconnect {
        from: from.to_owned(),
        to: to.to_owned(),
    }
}

fn wire(reference: &str, service: &str) -> Change {
    Change::Wire {
        reference: reference.to_owned(),
        service: service.to_owned(),
        wire: Wire::default(),
    }
}

fn unwire(reference: &str, service: &str) -> Change {
    Change::Unwire {
        reference: reference.to_owned(),
        service: service.to_owned(),
    }
}

/// `Steady` counts, and `Witness` reads it.
fn system(witness: &Seen) -> (System, Log) {
    let (log, mut system) = (Log::new(), System::new());
    system.observe(log.clone());
    let activity = Activity::periodic(1.ms());
    system.add("Steady", activity, counter()).unwrap();
    let activity = Activity::periodic(5.ms());
    system.add("Witness", activity, reader(witness)).unwrap();
    let policy = Policy::buffer(1000);
    system.connect("Steady.n", "Witness.n", policy).unwrap();
    (system, log)
}

/// Returns whether the numbers follow each other without gaps.
fn is_gapless(values: &[i64]) -> bool {
    values.windows(2).all(|pair| pair[1] == pair[0] + 1)
}

/// Adds a reader, a provider and its caller; removes all of them; adds another component with the name of one.
fn additions_and_removals(run: &mut impl Run, witness: &Seen) {
    let (guest, replies) = (Seen::default(), Replies::default());
    let calls = Arc::clone(&replies);
    run.run_for(20.ms());
    let added = [
        add_reader("Guest", &guest),
        add("Doubler", Activity::event(), doubler),
        add("Asker", Activity::periodic(2.ms()), move || asker(&calls)),
        connect("Steady.n", "Guest.n"),
        wire("Asker.sums", "Doubler.sums"),
    ];
    assert!(run.check_change(&added).unwrap().is_empty());
    assert_eq!(run.components(), ["Steady", "Witness"]);
    run.change(&added).unwrap();
    let all = ["Steady", "Witness", "Guest", "Doubler", "Asker"];
    assert_eq!(run.components(), all);
    assert_eq!(run.state("Guest"), Some(State::Running));
    run.run_for(60.ms());
    run.inject(run.now(), "Guest.n", number(-7)).unwrap();
    run.run_for(20.ms());
    let seen = values(&guest);
    assert!(seen.contains(&-7), "an operator reaches it: {seen:?}");
    let counted: Vec<_> = seen.into_iter().filter(|n| *n != -7).collect();
    assert!(counted.len() > 20 && is_gapless(&counted), "{counted:?}");
    let answered = replies.lock().unwrap().clone();
    assert!(answered.len() > 10, "{answered:?}");
    let expected = (1..).map(|n| Ok(2 * n));
    assert!(answered.iter().cloned().zip(expected).all(|(a, b)| a == b));

    let removed = [
        disconnect("Steady.n", "Guest.n"),
        unwire("Asker.sums", "Doubler.sums"),
        remove("Guest"),
        remove("Doubler"),
        remove("Asker"),
    ];
    run.check_change(&removed).unwrap();
    assert_eq!(run.components(), all);
    run.change(&removed).unwrap();
    assert_eq!(run.components(), ["Steady", "Witness"]);
    assert_eq!(run.state("Guest"), None);
    run.run_for(10.ms());
    let before = values(&guest).len();
    run.run_for(20.ms());
    assert_eq!(values(&guest).len(), before, "it has ended");
    let unknown = run.inject(run.now(), "Guest.n", number(1)).unwrap_err();
    assert!(unknown.to_string().contains("unknown input"), "{unknown}");
    let unknown = run.trigger("Guest").unwrap_err().to_string();
    assert!(unknown.contains("unknown component `Guest`"), "{unknown}");

    let other = Seen::default();
    let reused = [add_reader("Asker", &other), connect("Steady.n", "Asker.n")];
    run.change(&reused).unwrap();
    run.run_for(40.ms());
    run.stop();
    let other = values(&other);
    assert!(other.len() > 10 && is_gapless(&other), "{other:?}");
    let witness = values(witness);
    assert!(witness.len() > 100 && is_gapless(&witness) && witness[0] == 1);
}

#[test]
fn c18_components_come_and_go_in_simulated_time() {
    let witness = Seen::default();
    let (system, log) = system(&witness);
    let mut run = system.simulate();
    additions_and_removals(&mut run, &witness);
    let lines = log.lines_with("Guest: ").into_iter();
    let lines: Vec<_> = lines.filter(|line| !line.contains("cycle")).collect();
    assert_eq!(
        lines,
        [
            "0.02 s Guest: added: \"a test\"",
            "0.02 s Guest: PreOperational -> Stopped",
            "0.02 s Guest: Stopped -> Running",
            "0.1 s Guest: Running -> Stopped",
            "0.1 s Guest: Stopped -> PreOperational",
            "0.1 s Guest: removed: \"from the running system\"",
        ]
    );
}

#[test]
fn c18_components_come_and_go_in_real_time() {
    in_real_time(|| {
        let witness = Seen::default();
        let (system, _) = system(&witness);
        let mut run = system.live();
        additions_and_removals(&mut run, &witness);
    });
}

#[test]
fn c18_additions_in_simulated_time_give_equal_events() {
    let events = || {
        let witness = Seen::default();
        let (system, log) = system(&witness);
        additions_and_removals(&mut system.simulate(), &witness);
        log.lines_with("")
    };
    assert_eq!(events(), events());
}

/// Unwires and removes a provider with a call under way.
fn removal_of_a_provider(system: impl FnOnce(System) -> Box<dyn Run>) {
    let (replies, mut built) = (Replies::default(), System::new());
    let activity = Activity::periodic(50.ms());
    built.add("Asker", activity, asker(&replies)).unwrap();
    built.add("Idler", Activity::event(), idler()).unwrap();
    let (from, to) = ("Asker.sums", "Idler.sums");
    built.wire(from, to, Wire::default()).unwrap();
    let mut run = system(built);
    run.run_for(20.ms());
    let used = run.change(&[remove("Idler")]).unwrap_err().to_string();
    let reason = "`Idler` cannot be removed: `Asker.sums` would lose it";
    assert_eq!(used, reason);
    run.change(&[unwire(from, to), remove("Idler")]).unwrap();
    run.run_for(100.ms());
    let replies = replies.lock().unwrap().clone();
    assert!(!replies.is_empty());
    let unavailable = |it: &Result<i64, _>| *it == Err(CallError::Unavailable);
    assert!(replies.iter().all(unavailable), "{replies:?}");
}

#[test]
fn c18_a_call_to_a_removed_component_ends_as_unavailable() {
    removal_of_a_provider(|system| Box::new(system.simulate()));
    removal_of_a_provider(|system| Box::new(system.live()));
}

/// Fails where it is told to, and counts its cleanups.
struct Faulty {
    fails: Transition,
    cleanups: Arc<AtomicU32>,
    out: Out<Number>,
}

impl Component for Faulty {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        cycle.write(self.out, number(-1));
        Ok(())
    }

    fn configure(&mut self, _: &mut Setup<'_>) -> Result<(), Fault> {
        match self.fails {
            Transition::Configure => Err(Fault::new("no device")),
            Transition::Start
            | Transition::Stop
            | Transition::Cleanup
            | Transition::Recover
            | Transition::ResetException => Ok(()),
        }
    }

    fn start(&mut self) -> Result<(), Fault> {
        match self.fails {
            Transition::Start => Err(Fault::new("no power")),
            Transition::Configure
            | Transition::Stop
            | Transition::Cleanup
            | Transition::Recover
            | Transition::ResetException => Ok(()),
        }
    }

    fn cleanup(&mut self) {
        self.cleanups.fetch_add(1, Ordering::Relaxed);
    }
}

fn faulty(fails: Transition, cleanups: &Arc<AtomicU32>) -> ComponentAddition {
    let cleanups = Arc::clone(cleanups);
    let activity = Activity::periodic(1.ms());
    ComponentAddition::new("a test", activity, move |interface: &mut Interface| {
        Ok(Box::new(Faulty {
            fails,
            cleanups: Arc::clone(&cleanups),
            out: interface.output("n", "minus one"),
        }))
    })
}

fn refused_constructor() -> ComponentAddition {
    ComponentAddition::new("a test", Activity::event(), |_: &mut Interface| {
        Err("there is none".to_owned())
    })
}

fn contradiction() -> ComponentAddition {
    ComponentAddition::new("a test", Activity::event(), |interface: &mut Interface| {
        interface.output::<Number>("n", "once");
        Ok(counter()(interface))
    })
}

/// Lists that are impossible because of their last addition, with the reasons, and how often `Good` is cleaned up.
fn impossible(cleanups: &Arc<AtomicU32>) -> Vec<(ComponentAddition, &'static str, u32)> {
    let never = faulty(Transition::Stop, cleanups);
    vec![
        (refused_constructor(), "cannot be added: there is none", 0),
        (contradiction(), "component `Bad`", 0),
        (never.clone().property("gain", Datum::Int(1)), "gain", 0),
        (never.clone().safe_sample("m", Datum::Null), "Bad.m", 0),
        (never.publish("n", HEALTH_TOPIC), HEALTH_TOPIC, 0),
        (
            faulty(Transition::Configure, cleanups),
            "`Bad` cannot be added: no device",
            1,
        ),
        (
            faulty(Transition::Start, cleanups),
            "`Bad` cannot be added: no power",
            2,
        ),
    ]
}

fn failures(run: &mut impl Run, witness: &Seen, log: &Log) {
    run.run_for(20.ms());
    let cleanups = Arc::new(AtomicU32::new(0));
    for (bad, reason, expected) in impossible(&cleanups) {
        let list = [
            disconnect("Steady.n", "Witness.n"),
            remove("Witness"),
            addition("Good", faulty(Transition::Stop, &cleanups)),
            addition("Bad", bad),
            add_reader("Witness", &Seen::default()),
            connect("Good.n", "Witness.n"),
        ];
        let error = run.change(&list).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
        assert_eq!(cleanups.swap(0, Ordering::Relaxed), expected, "{error}");
        assert_eq!(run.components(), ["Steady", "Witness"]);
        run.run_for(10.ms());
    }
    for name in ["Good", "Bad"] {
        assert!(
            log.lines_with(name).is_empty(),
            "{:?}",
            log.lines_with(name)
        );
    }
    run.change(&[addition("Good", faulty(Transition::Stop, &cleanups))])
        .unwrap();
    run.run_for(30.ms());
    assert!(run.cycles("Good") > 5);
    run.stop();
    let seen = values(witness);
    assert!(
        seen.len() > 50 && is_gapless(&seen) && seen[0] == 1,
        "{seen:?}"
    );
}

#[test]
fn c18_a_component_that_cannot_be_added_changes_nothing() {
    let witness = Seen::default();
    let (built, log) = system(&witness);
    failures(&mut built.simulate(), &witness, &log);
    in_real_time(|| {
        let witness = Seen::default();
        let (built, log) = system(&witness);
        failures(&mut built.live(), &witness, &log);
    });
}

/// A change whose last addition fails undoes the wires and topics of the changes before it.
#[test]
fn c18_a_failed_addition_leaves_wires_and_topics_as_they_were() {
    let (replies, first) = (Replies::default(), Seen::default());
    let mut built = System::new();
    let activity = Activity::periodic(10.ms());
    built
        .add("Asker", activity.clone(), asker(&replies))
        .unwrap();
    built.add("Idler", Activity::event(), idler()).unwrap();
    built
        .add("First", Activity::event(), reader(&first))
        .unwrap();
    built
        .wire("Asker.sums", "Idler.sums", Wire::default())
        .unwrap();
    built
        .subscribe("numbers", "First.n", Policy::buffer(8))
        .unwrap();
    let mut run = built.simulate();
    let talker = || {
        let made = |interface: &mut Interface| Ok(counter()(interface));
        ComponentAddition::new("a test", Activity::periodic(10.ms()), made).publish("n", "numbers")
    };
    let listener =
        ComponentAddition::new("a test", Activity::event(), |interface: &mut Interface| {
            Ok(reader(&Seen::default())(interface))
        });
    let listener = listener.subscribe("numbers", "n", Policy::buffer(8));
    let list = [
        unwire("Asker.sums", "Idler.sums"),
        remove("First"),
        remove("Idler"),
        addition("First", listener),
        add("Idler", Activity::event(), doubler),
        wire("Asker.sums", "Idler.sums"),
        addition("Talker", talker()),
    ];
    let cleanups = Arc::default();
    let mut failing = list.to_vec();
    failing.push(addition("Bad", faulty(Transition::Start, &cleanups)));
    run.change(&failing).unwrap_err();
    run.change(&[addition("Talker", talker())]).unwrap();
    run.run_for(25.ms());
    assert_eq!(values(&first), [1, 2, 3]);
    assert!(replies.lock().unwrap().is_empty(), "`Idler` does not reply");

    // names of removed components are free in the same change
    run.change(&list[..6]).unwrap();
    assert_eq!(run.components(), ["Asker", "Talker", "First", "Idler"]);
    run.run_for(30.ms());
    assert_eq!(values(&first).len(), 3);
    let replies = replies.lock().unwrap().clone();
    assert_eq!(replies[..3], [1, 2, 3].map(|_| Err(CallError::Unavailable)));
    assert_eq!(replies[3..], [Ok(8), Ok(10)]);
}

#[test]
fn c18_a_component_that_others_need_is_not_removed() {
    let witness = Seen::default();
    let (mut built, _) = system(&witness);
    built.add("Slave", Activity::event(), counter()).unwrap();
    built.add_slave("Slave", "Steady").unwrap();
    let mut run = built.simulate();
    for (changes, reason) in [
        (
            vec![remove("Steady")],
            "`Steady` cannot be removed: `Slave`, `Witness.n` would lose it",
        ),
        (
            vec![remove("Witness")],
            "`Witness` cannot be removed: `Steady.n` would lose it",
        ),
        (
            vec![remove("Witness"), connect("Steady.n", "Witness.n")],
            "unknown component `Witness`",
        ),
        (vec![remove("Guest")], "unknown component `Guest`"),
        (vec![remove("")], "unknown component ``"),
        (
            vec![add_reader("Guest", &witness), remove("Guest")],
            "`Guest` cannot be removed: the same change adds it",
        ),
        (
            vec![add_reader("Witness", &witness)],
            "invalid component name `Witness`: it is empty or taken",
        ),
        (
            vec![
                add_reader("Guest", &witness),
                Change::Replace {
                    component: "Guest".to_owned(),
                    by: Replacement::new("another", |interface: &mut Interface| {
                        Ok(counter()(interface))
                    }),
                },
            ],
            "`Guest` cannot be replaced: the same change adds it",
        ),
    ] {
        let error = run.change(&changes).unwrap_err().to_string();
        assert_eq!(error, reason);
        assert_eq!(run.check_change(&changes).unwrap_err().to_string(), reason);
    }
    assert_eq!(run.components(), ["Steady", "Witness", "Slave"]);
    run.run_for(20.ms());
    assert_eq!(values(&witness).len(), 21);
    run.change(&[remove("Steady"), remove("Slave"), remove("Witness")])
        .unwrap();
    assert!(run.components().is_empty());
    run.run_for(20.ms());
    assert_eq!(values(&witness).len(), 21);
}

#[test]
fn c18_topics_within_a_system_take_and_lose_components() {
    let (first, second) = (Seen::default(), Seen::default());
    let log = Log::new();
    let mut built = System::new();
    built.observe(log.clone());
    let activity = Activity::periodic(10.ms());
    built.add("One", activity.clone(), counter()).unwrap();
    built
        .add("First", Activity::event(), reader(&first))
        .unwrap();
    built.publish("One.n", "numbers").unwrap();
    built
        .subscribe("numbers", "First.n", Policy::buffer(8))
        .unwrap();
    let mut run = built.simulate();
    run.run_for(25.ms());
    let seen = Arc::clone(&second);
    let subscriber = ComponentAddition::new(
        "a test",
        Activity::event(),
        move |interface: &mut Interface| Ok(reader(&seen)(interface)),
    );
    let publisher = ComponentAddition::new("a test", activity, |interface: &mut Interface| {
        Ok(counter()(interface))
    });
    let added = [
        addition("Two", publisher.publish("n", "numbers")),
        addition(
            "Second",
            subscriber.subscribe("numbers", "n", Policy::buffer(8)),
        ),
    ];
    run.change(&added).unwrap();
    run.run_for(10.ms());
    run.publish(run.now(), "numbers", number(-7)).unwrap();
    run.run_for(10.ms());
    assert_eq!(values(&first), [1, 2, 3, 1, 4, 2, -7, 5, 3]);
    assert_eq!(values(&second), [1, 4, 2, -7, 5, 3]);
    run.change(&[remove("One"), remove("Second")]).unwrap();
    run.publish(run.now(), "numbers", number(-8)).unwrap();
    run.run_for(200.ms());
    assert_eq!(
        values(&first)[8..],
        [
            3, -8, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23
        ]
    );
    assert_eq!(values(&second).len(), 6);
    assert!(log.lines_with("dropped").is_empty());
}

/// Writes 1 in its cycles, and has the safe sample 0.
fn driver() -> ComponentAddition {
    let made = |interface: &mut Interface| -> Result<Box<dyn Component>, String> {
        Ok(behaviour(|interface| {
            let out = interface.output::<Number>("n", "a command");
            move |cycle| {
                cycle.write(out, number(1));
                Ok(())
            }
        })(interface))
    };
    let zero = Datum::record([("n", Datum::Int(0))]);
    ComponentAddition::new("a test", Activity::periodic(1.ms()), made).safe_sample("n", zero)
}

fn last_samples(run: &mut impl Run, seen: &Seen) {
    run.change(&[
        addition("Driver", driver()),
        connect("Driver.n", "Wheels.n"),
    ])
    .unwrap();
    run.run_for(20.ms());
    assert!(values(seen).len() > 5);
    run.change(&[disconnect("Driver.n", "Wheels.n"), remove("Driver")])
        .unwrap();
    run.run_for(20.ms());
    let seen = values(seen);
    assert_eq!(seen.last(), Some(&0), "{seen:?}");
    assert_eq!(seen.iter().filter(|n| **n == 0).count(), 1);
}

#[test]
fn c18_the_safe_sample_of_a_removed_component_arrives() {
    let built = |seen: &Seen| {
        let mut built = System::new();
        let activity = Activity::periodic(2.ms());
        built.add("Wheels", activity, reader(seen)).unwrap();
        built
    };
    let seen = Seen::default();
    last_samples(&mut built(&seen).simulate(), &seen);
    in_real_time(|| {
        let seen = Seen::default();
        last_samples(&mut built(&seen).live(), &seen);
    });
}

/// The names of the threads of this process.
fn threads(prefix: &str) -> usize {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let names =
        tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok());
    names.filter(|name| name.starts_with(prefix)).count()
}

/// Adds and removes a component and its slave in many rounds.
fn rounds(run: &mut impl Run, log: &Log) {
    for _ in 0..100 {
        let seen = Seen::default();
        let added = [
            add_reader("Passing", &seen),
            connect("Steady.n", "Passing.n"),
        ];
        run.change(&added).unwrap();
        run.run_for(2.ms());
        run.change(&[disconnect("Steady.n", "Passing.n"), remove("Passing")])
            .unwrap();
    }
    let seen = Seen::default();
    run.change(&[
        add_reader("Passing", &seen),
        connect("Steady.n", "Passing.n"),
    ])
    .unwrap();
    run.run_for(200.ms());
    assert!(values(&seen).len() > 20, "position 102 is triggered");
    assert!(log.lines_with("dropped").is_empty());
}

#[test]
fn c18_many_additions_and_removals_leave_nothing_behind() {
    let witness = Seen::default();
    let (built, log) = system(&witness);
    rounds(&mut built.simulate(), &log);
    let (built, log) = system(&witness);
    let mut run = built.live();
    rounds(&mut run, &log);
    let begun = Instant::now();
    while threads("Passing") > 1 {
        assert!(begun.elapsed() < Duration::from_secs(10), "threads remain");
        std::thread::sleep(Duration::from_millis(5));
    }
    drop(run);
    assert_eq!(threads("Passing"), 0);
}

#[test]
fn c18_a_slave_and_its_master_are_removed_with_their_thread() {
    let mut built = System::new();
    for name in ["Hare", "Tortoise"] {
        let activity = Activity::periodic(1.ms()).thread(ThreadUse::Own);
        built.add(name, activity, counter()).unwrap();
    }
    built.add_slave("Tortoise", "Hare").unwrap();
    let mut run = built.live();
    run_until(&mut run, |run: &Live| run.cycles("Tortoise") > 2);
    assert_eq!(threads("Hare"), 1);
    run.change(&[remove("Hare"), remove("Tortoise")]).unwrap();
    run_until(&mut run, |_| threads("Hare") == 0);
}

/// Counts, and can be frozen.
#[derive(Freeze)]
#[freeze(component = "test::Tally", version = 1)]
struct Tally {
    n: i64,
    #[freeze(skip)]
    input: In<Number>,
    #[freeze(skip)]
    out: Out<Number>,
}

impl Component for Tally {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.n += 1 + cycle.all(self.input).iter().map(|it| it.n).sum::<i64>();
        cycle.write(self.out, number(self.n));
        Ok(())
    }
}

fn tally() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    |interface| {
        let input = interface.input("in", "numbers");
        let out = interface.output("n", "the sum");
        Box::new(Tally { n: 0, input, out })
    }
}

fn tallies() -> (Simulation, Log) {
    let (log, mut system) = (Log::new(), System::new());
    system.observe(log.clone());
    for name in ["One", "Two"] {
        let activity = Activity::periodic(10.ms());
        system.add(name, activity, tally()).unwrap();
    }
    (system.simulate(), log)
}

#[test]
fn c18_a_simulation_with_vacant_positions_is_frozen_and_thawed() {
    let (mut run, log) = tallies();
    run.run_for(25.ms());
    let before = run.freeze().unwrap();
    let changes = [
        remove("One"),
        add("Three", Activity::periodic(10.ms()), tally),
        connect("Two.n", "Three.in"),
    ];
    run.change(&changes).unwrap();
    run.run_for(20.ms());
    let frozen = run.freeze().unwrap();
    run.run_for(50.ms());
    let expected = counts(&log, "Three.n");
    run.thaw(&frozen).unwrap();
    assert_eq!(run.freeze().unwrap(), frozen);
    run.run_for(50.ms());
    let continued = counts(&log, "Three.n");
    assert_eq!(continued[expected.len()..], expected[expected.len() - 5..]);
    let (mut other, _) = tallies();
    let refused = other.thaw(&frozen).unwrap_err().to_string();
    assert!(refused.contains("another system"), "{refused}");
    assert!(run.thaw(&before).is_err());
}

fn counts(log: &Log, port: &str) -> Vec<i64> {
    let samples = log.samples::<Number>(port).into_iter();
    samples.map(|(_, number)| number.n).collect()
}

/// Takes long to configure. Counts its threads: the hooks and cycles of a component run in one.
struct Slow {
    pause: Duration,
    threads: Arc<Mutex<Vec<std::thread::ThreadId>>>,
    cleanups: Arc<AtomicU32>,
}

impl Slow {
    fn note_thread(&self) {
        let mut threads = self.threads.lock().unwrap();
        threads.push(std::thread::current().id());
    }
}

impl Component for Slow {
    fn configure(&mut self, _: &mut Setup<'_>) -> Result<(), Fault> {
        self.note_thread();
        std::thread::sleep(self.pause);
        Ok(())
    }

    fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
        self.note_thread();
        Ok(())
    }

    fn cleanup(&mut self) {
        self.cleanups.fetch_add(1, Ordering::SeqCst);
    }
}

#[test]
fn c18_a_component_that_takes_too_long_to_configure_is_not_added() {
    let (threads, cleanups) = (Arc::default(), Arc::new(AtomicU32::new(0)));
    let slow = |pause: Duration| {
        let (threads, cleanups) = (Arc::clone(&threads), Arc::clone(&cleanups));
        let activity = Activity::periodic(2.ms()).thread(ThreadUse::Own);
        addition(
            "Slow",
            ComponentAddition::new("a test", activity, move |_: &mut Interface| {
                let (threads, cleanups) = (Arc::clone(&threads), Arc::clone(&cleanups));
                Ok(Box::new(Slow {
                    pause,
                    threads,
                    cleanups,
                }))
            }),
        )
    };
    let witness = Seen::default();
    let (system, _) = system(&witness);
    let mut run = system.live();
    run.set_grace_period(50.ms());
    let begin = Instant::now();
    let first = add("First", Activity::event(), counter);
    let refused = run.change(&[first.clone(), slow(1500.ms())]).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "`Slow` cannot be added: its `configure` takes longer than 50ms"
    );
    assert!(begin.elapsed() < 1.s(), "{:?}", begin.elapsed());
    assert_eq!(run.components(), ["Steady", "Witness"]);
    // positions and names are free, although the thread is still busy
    run.set_grace_period(5.s());
    run.change(&[first]).unwrap();
    assert_eq!(run.state("First"), Some(State::Running));
    while cleanups.load(Ordering::SeqCst) == 0 {
        assert!(begin.elapsed() < 60.s(), "it was never cleaned up");
        run.run_for(10.ms());
    }
    threads.lock().unwrap().clear();
    run.change(&[slow(1.ms())]).unwrap();
    while threads.lock().unwrap().len() < 3 {
        assert!(begin.elapsed() < 60.s(), "it has no cycles");
        run.run_for(10.ms());
    }
    let threads = threads.lock().unwrap().clone();
    assert!(threads.iter().all(|it| *it == threads[0]), "{threads:?}");
    assert_ne!(threads[0], std::thread::current().id());
    run.stop();
    assert!(is_gapless(&values(&witness)));
}
