//! Executor threads: components without real-time demands take turns in a few threads.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::ThreadId;
use std::time::Duration;

use asmotion_component::{
    Activity, Component, Cycle, Fault, Interface, NOTICE_REPORT, OnDeadline, Policy, Scheduler,
    Span, State, ThreadUse, Time,
};
use asmotion_runtime::{Event, Live, Run, System};

use crate::common::{Number, behaviour, counter, in_real_time, number, run_until};

/// The threads of this process whose names begin with `prefix`.
fn threads(prefix: &str) -> usize {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let names =
        tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok());
    names.filter(|name| name.starts_with(prefix)).count()
}

/// The threads in which components cycle, by their ids.
type Threads = Arc<Mutex<std::collections::BTreeMap<String, Vec<ThreadId>>>>;

/// Notes the thread of each cycle, and takes `nap`.
fn noting(
    name: &str,
    threads: &Threads,
    nap: Duration,
) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let (name, threads) = (name.to_owned(), Arc::clone(threads));
    behaviour(move |_| {
        move |_| {
            std::thread::sleep(nap);
            let mut threads = threads.lock().unwrap();
            let of = threads.entry(name.clone()).or_default();
            of.push(std::thread::current().id());
            Ok(())
        }
    })
}

#[test]
fn components_without_demands_share_a_few_threads_and_others_have_their_own() {
    let seen = Threads::default();
    let mut system = System::new();
    for number in 0..200 {
        let name = format!("Crowd{number}");
        let activity = Activity::periodic(20.ms());
        let made = noting(&name, &seen, Duration::ZERO);
        system.add(&name, activity, made).unwrap();
    }
    let periodic = || Activity::periodic(20.ms());
    let demanding = [
        ("Chosen", periodic().thread(ThreadUse::Own)),
        ("Urgent", periodic().scheduler(Scheduler::Fifo).priority(1)),
        ("Pinned", periodic().cpus([0])),
        ("Limited", periodic().deadline(5.s(), OnDeadline::Report)),
    ];
    for (name, activity) in demanding {
        let made = noting(name, &seen, Duration::ZERO);
        system.add(name, activity, made).unwrap();
    }
    let relaxed = periodic().deadline(5.s(), OnDeadline::Report);
    let relaxed = relaxed.thread(ThreadUse::Shared);
    let made = noting("Relaxed", &seen, Duration::ZERO);
    system.add("Relaxed", relaxed, made).unwrap();
    let mut run = system.live();
    run_until(&mut run, |run: &Live| {
        let mut all = run.components().into_iter();
        all.all(|it| run.cycles(&it) > 5)
    });
    for name in ["Crowd0", "Crowd199", "Relaxed"] {
        assert_eq!(run.thread_use(name), Some(ThreadUse::Shared), "{name}");
    }
    for name in ["Chosen", "Urgent", "Pinned", "Limited"] {
        assert_eq!(run.thread_use(name), Some(ThreadUse::Own), "{name}");
        assert_eq!(threads(name), 1, "{name}");
    }
    assert_eq!(run.thread_use("Nobody"), None);
    assert_eq!(threads("Crowd"), 0);
    drop(run);
    let seen = seen.lock().unwrap();
    let mut own: Vec<ThreadId> = Vec::new();
    for name in ["Chosen", "Urgent", "Pinned", "Limited"] {
        let mut threads = seen[name].clone();
        threads.dedup();
        assert_eq!(threads.len(), 1, "{name}");
        own.extend(threads);
    }
    let shared: std::collections::HashSet<_> = seen
        .iter()
        .filter(|(name, _)| name.starts_with("Crowd") || *name == "Relaxed")
        .flat_map(|(_, threads)| threads)
        .collect();
    assert!(own.iter().all(|it| !shared.contains(it)));
    assert!(
        shared.len() < 50,
        "{} threads for 201 components",
        shared.len()
    );
}

#[test]
fn virtual_time_has_one_thread() {
    let mut system = System::new();
    let activity = Activity::periodic(20.ms()).thread(ThreadUse::Own);
    system.add("Counter", activity, counter()).unwrap();
    let run = system.simulate();
    assert_eq!(run.thread_use("Counter"), None);
}

#[test]
fn components_that_block_are_named_and_delay_the_others_little() {
    in_real_time(|| {
        let processors = std::thread::available_parallelism().unwrap().get().max(2);
        let mut system = System::new();
        let notices: Arc<Mutex<Vec<(String, String)>>> = Arc::default();
        let told = Arc::clone(&notices);
        system.observe(move |_: Time, event: &Event<'_>| {
            if let Event::Report {
                component,
                kind,
                data,
            } = event
                && *kind == NOTICE_REPORT
            {
                told.lock()
                    .unwrap()
                    .push(((*component).to_owned(), data.to_string()));
            }
        });
        let unused = Threads::default();
        for number in 0..=processors {
            let name = format!("Asleep{number}");
            let activity = Activity::periodic(10.ms());
            let made = noting(&name, &unused, 300.ms());
            system.add(&name, activity, made).unwrap();
        }
        system
            .add("Quick", Activity::periodic(10.ms()), counter())
            .unwrap();
        let mut run = system.live();
        run.run_for(2.s());
        run.stop();
        assert!(run.cycles("Quick") > 40, "{} cycles", run.cycles("Quick"));
        assert!(run.cycles("Asleep0") > 2, "{}", run.cycles("Asleep0"));
        let mut notices = notices.lock().unwrap().clone();
        notices.sort();
        assert!(!notices.is_empty());
        assert!(
            notices.iter().all(|(component, text)| {
                component.starts_with("Asleep") && text.contains("`thread = \\\"own\\\"`")
            }),
            "{notices:?}"
        );
        let count = notices.len();
        notices.dedup_by(|one, other| one.0 == other.0);
        assert_eq!(notices.len(), count, "each is named once");
    });
}

/// Passes numbers on, one higher, to the next of a ring.
fn passing(
    begins: bool,
    passed: &Arc<AtomicU64>,
) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let passed = Arc::clone(passed);
    behaviour(move |interface| {
        let input = interface.input::<Number>("in", "from the one before");
        let output = interface.output::<Number>("out", "to the next one");
        move |cycle: &mut Cycle<'_>| {
            if begins && cycle.number() == 1 {
                cycle.write(output, number(0));
            }
            if let Some(got) = cycle.read(input).new() {
                let next = number(got.n + 1);
                cycle.write(output, next);
                passed.fetch_add(1, Ordering::Relaxed);
            }
            Ok(())
        }
    })
}

/// A wake-up that is lost ends the ring that it belongs to.
#[test]
fn no_wake_up_between_components_is_lost() {
    const RINGS: usize = 20;
    const MEMBERS: usize = 5;
    let rings: Vec<Arc<AtomicU64>> = (0..RINGS).map(|_| Arc::default()).collect();
    let mut system = System::new();
    for (ring, passed) in rings.iter().enumerate() {
        for member in 0..MEMBERS {
            // some with a thread of their own
            let use_ = if (ring + member) % 7 == 0 {
                ThreadUse::Own
            } else {
                ThreadUse::Shared
            };
            let activity = Activity::event().thread(use_);
            let made = passing(member == 0, passed);
            let name = format!("Ring{ring}Member{member}");
            system.add(&name, activity, made).unwrap();
        }
        for member in 0..MEMBERS {
            let from = format!("Ring{ring}Member{member}.out");
            let to = format!("Ring{ring}Member{}.in", (member + 1) % MEMBERS);
            system.connect(&from, &to, Policy::buffer(2)).unwrap();
        }
    }
    let mut run = system.live();
    for round in 1..=5 {
        let all_passed = |_: &Live| {
            rings
                .iter()
                .all(|passed| passed.load(Ordering::Relaxed) >= round * 400)
        };
        run_until(&mut run, all_passed);
    }
}

/// Panics in its third cycle.
struct Panics;

impl Component for Panics {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        assert!(cycle.number() < 3, "a panic on purpose");
        Ok(())
    }
}

#[test]
fn a_panic_stays_in_its_component_and_the_threads_go_on() {
    let mut system = System::new();
    for number in 0..20 {
        let activity = Activity::periodic(5.ms());
        let made = |_: &mut Interface| -> Box<dyn Component> { Box::new(Panics) };
        system
            .add(&format!("Panics{number}"), activity, made)
            .unwrap();
    }
    system
        .add("Counter", Activity::periodic(5.ms()), counter())
        .unwrap();
    let mut run = system.live();
    run_until(&mut run, |run: &Live| {
        (0..20).all(|it| run.state(&format!("Panics{it}")) == Some(State::Exception))
    });
    let cycles = run.cycles("Counter");
    run_until(&mut run, |run: &Live| run.cycles("Counter") > cycles + 20);
}

#[test]
fn a_first_cycle_of_a_thousand_components_is_soon_and_all_stop() {
    let mut system = System::new();
    for number in 0..1000 {
        let activity = Activity::periodic(100.ms());
        system
            .add(&format!("Crowd{number}"), activity, counter())
            .unwrap();
    }
    let mut run = system.live();
    run_until(&mut run, |run: &Live| {
        let mut all = run.components().into_iter();
        all.all(|it| run.cycles(&it) > 2)
    });
    assert_eq!(threads("Crowd"), 0);
    assert!(run.stop().is_empty());
    let states: Vec<_> = run.components().iter().map(|it| run.state(it)).collect();
    assert!(states.iter().all(|it| *it == Some(State::Stopped)));
}
