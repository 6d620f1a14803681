//! Threads that are lent to a system: they run the cycles for which they have brought data.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::ThreadId;
use std::time::{Duration, Instant};

use asmotion_component::{
    Activity, Component, Cycle, Fault, In, Interface, Out, Policy, Setup, Span, State, ThreadUse,
    Transition,
};
use asmotion_runtime::{Live, Run, System};

use crate::common::{Number, number, run_until};

/// Time for what is soon on a machine that is not busy.
const LONG: Duration = Duration::from_secs(60);

type Lender = Arc<dyn Fn() + Send + Sync>;

/// What the components of a system tell.
#[derive(Default)]
struct Told {
    lender: Option<Lender>,
    /// The threads of the cycles, by component.
    cycles: BTreeMap<&'static str, Vec<ThreadId>>,
    /// The threads of the other hooks.
    hooks: Vec<(&'static str, ThreadId)>,
}

type Shared = Arc<Mutex<Told>>;

fn here() -> ThreadId {
    std::thread::current().id()
}

/// Writes the number of its cycle.
struct Bridge {
    out: Out<Number>,
    told: Shared,
}

impl Bridge {
    fn hook(&self, name: &'static str) {
        self.told.lock().unwrap().hooks.push((name, here()));
    }
}

impl Component for Bridge {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        self.told.lock().unwrap().lender = setup.thread_lender();
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        cycle.write(self.out, number(1));
        let mut told = self.told.lock().unwrap();
        told.cycles.entry("Bridge").or_default().push(here());
        Ok(())
    }

    fn stop(&mut self, _: &mut Cycle<'_>) {
        self.hook("stop");
    }

    fn cleanup(&mut self) {
        self.hook("cleanup");
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.hook("drop");
    }
}

/// Reads numbers, and takes its time.
struct Follower {
    input: In<Number>,
    nap: Duration,
    /// The number of the cycle that panics.
    panics_at: Option<usize>,
    told: Shared,
}

impl Component for Follower {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let _ = cycle.all(self.input).len();
        std::thread::sleep(self.nap);
        let mut told = self.told.lock().unwrap();
        let cycles = told.cycles.entry("Follower").or_default();
        cycles.push(here());
        let count = cycles.len();
        drop(told);
        assert!(Some(count) != self.panics_at, "in a thread that is lent");
        Ok(())
    }
}

/// A bridge and a follower.
fn system(of_bridge: Activity, nap: Duration) -> (System, Shared) {
    with_panic(of_bridge, nap, None)
}

/// A bridge and a follower, one of whose cycles panics.
fn with_panic(of_bridge: Activity, nap: Duration, panics_at: Option<usize>) -> (System, Shared) {
    let (mut system, told) = (System::new(), Shared::default());
    let of = Arc::clone(&told);
    let bridge = |interface: &mut Interface| -> Box<dyn Component> {
        let out = interface.output("out", "numbers");
        Box::new(Bridge { out, told: of })
    };
    system.add("Bridge", of_bridge, bridge).unwrap();
    let of = Arc::clone(&told);
    let follower = |interface: &mut Interface| -> Box<dyn Component> {
        let input = interface.input("in", "numbers");
        Box::new(Follower {
            input,
            nap,
            panics_at,
            told: of,
        })
    };
    system.add("Follower", Activity::event(), follower).unwrap();
    system
        .connect("Bridge.out", "Follower.in", Policy::buffer(16))
        .unwrap();
    (system, told)
}

fn lender(told: &Shared) -> Lender {
    told.lock().unwrap().lender.clone().unwrap()
}

/// Lends the current thread until so many cycles of a component have run.
fn lend_until(told: &Shared, component: &str, is_enough: impl Fn(&[ThreadId]) -> bool) {
    let (lender, until) = (lender(told), Instant::now() + LONG);
    loop {
        lender();
        let cycles = told.lock().unwrap().cycles.get(component).cloned();
        if is_enough(&cycles.unwrap_or_default()) {
            return;
        }
        assert!(Instant::now() < until, "{component}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_lent_thread_runs_the_cycle_and_those_that_it_triggers() {
    let (system, told) = system(Activity::event(), Duration::ZERO);
    let mut run = system.live();
    // as soon as the turns are known to be brief
    for component in ["Bridge", "Follower"] {
        lend_until(&told, component, |it| it.last() == Some(&here()));
    }
    // a request that is made elsewhere needs no lent thread
    let cycles = run.cycles("Follower");
    run.trigger("Bridge").unwrap();
    run_until(&mut run, |run: &Live| run.cycles("Follower") > cycles);
}

#[test]
fn a_cycle_that_takes_long_runs_elsewhere() {
    let (system, told) = system(Activity::event(), 2.ms());
    let _run = system.live();
    lend_until(&told, "Bridge", |it| it.last() == Some(&here()));
    lend_until(&told, "Follower", |it| it.len() >= 10);
    let told = told.lock().unwrap();
    assert!(!told.cycles["Follower"].contains(&here()));
}

/// It fails as elsewhere, and the thread goes on for the others.
#[test]
fn a_cycle_that_panics_leaves_the_lent_thread_to_the_others() {
    const PANIC: usize = 40;
    let (system, told) = with_panic(Activity::event(), Duration::ZERO, Some(PANIC));
    let mut run = system.live();
    lend_until(&told, "Follower", |it| it.len() >= PANIC);
    run_until(&mut run, |run: &Live| {
        run.state("Follower") == Some(State::Exception)
    });
    let before = told.lock().unwrap().cycles["Bridge"].len();
    lend_until(&told, "Bridge", |it| {
        it.len() > before + 20 && it.last() == Some(&here())
    });
    assert_eq!(told.lock().unwrap().cycles["Follower"].len(), PANIC);
}

#[test]
fn a_component_with_a_thread_of_its_own_keeps_it() {
    let (system, told) = system(Activity::event().thread(ThreadUse::Own), Duration::ZERO);
    let _run = system.live();
    lend_until(&told, "Bridge", |it| it.len() >= 5);
    assert!(!told.lock().unwrap().cycles["Bridge"].contains(&here()));
}

#[test]
fn virtual_time_takes_no_thread() {
    let (system, told) = system(Activity::event(), Duration::ZERO);
    let _run = system.simulate();
    assert!(told.lock().unwrap().lender.is_none());
}

/// Its owner may wait for the lent thread in these hooks.
#[test]
fn commands_are_carried_out_by_the_threads_of_the_system() {
    let (system, told) = system(Activity::event(), Duration::ZERO);
    let mut run = system.live();
    let ended = Arc::new(AtomicBool::new(false));
    let rounds = Arc::new(AtomicU64::new(0));
    let (lent, stop, count) = (lender(&told), Arc::clone(&ended), Arc::clone(&rounds));
    let thread = std::thread::spawn(move || {
        while !stop.load(Ordering::Relaxed) {
            lent();
            count.fetch_add(1, Ordering::Relaxed);
        }
    });
    for _ in 0..20 {
        let before = rounds.load(Ordering::Relaxed);
        run_until(&mut run, |_: &Live| {
            rounds.load(Ordering::Relaxed) > before + 20
        });
        for transition in [
            Transition::Stop,
            Transition::Cleanup,
            Transition::Configure,
            Transition::Start,
        ] {
            run.transition("Bridge", transition).unwrap();
        }
    }
    drop(run);
    // it goes on without effect
    let before = rounds.load(Ordering::Relaxed);
    let until = Instant::now() + LONG;
    while rounds.load(Ordering::Relaxed) < before + 20 {
        assert!(Instant::now() < until);
        std::thread::yield_now();
    }
    ended.store(true, Ordering::Relaxed);
    let lent = thread.thread().id();
    thread.join().unwrap();
    let told = told.lock().unwrap();
    let names: Vec<_> = told.hooks.iter().map(|(name, _)| *name).collect();
    assert_eq!(names.iter().filter(|it| **it == "stop").count(), 21);
    assert_eq!(names.last(), Some(&"drop"));
    let hooks = told.hooks.iter().filter(|(name, _)| *name != "drop");
    assert!(
        hooks.clone().all(|(_, thread)| *thread != lent),
        "{names:?}"
    );
}

/// Passes numbers on to the next of a ring.
struct Passing {
    input: In<Number>,
    output: Out<Number>,
    passed: Arc<AtomicU64>,
    told: Shared,
}

impl Component for Passing {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        self.told.lock().unwrap().lender = setup.thread_lender();
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if cycle.number() == 1 {
            cycle.write(self.output, number(0));
        }
        if let Some(got) = cycle.read(self.input).new() {
            cycle.write(self.output, number(got.n + 1));
            self.passed.fetch_add(1, Ordering::Relaxed);
        }
        Ok(())
    }
}

/// Lent threads, which come and go, and executor threads leave each other nothing behind.
#[test]
fn no_wake_up_is_lost_between_lent_threads_and_others() {
    const RINGS: usize = 8;
    let rings: Vec<(Arc<AtomicU64>, Shared)> = (0..RINGS).map(|_| Default::default()).collect();
    let mut system = System::new();
    for (ring, (passed, told)) in rings.iter().enumerate() {
        for member in 0..3 {
            let (passed, told) = (Arc::clone(passed), Arc::clone(told));
            let made = |interface: &mut Interface| -> Box<dyn Component> {
                Box::new(Passing {
                    input: interface.input("in", "from the one before"),
                    output: interface.output("out", "to the next one"),
                    passed,
                    told,
                })
            };
            let name = format!("Ring{ring}Member{member}");
            system.add(&name, Activity::event(), made).unwrap();
        }
        for member in 0..3 {
            let from = format!("Ring{ring}Member{member}.out");
            let to = format!("Ring{ring}Member{}.in", (member + 1) % 3);
            system.connect(&from, &to, Policy::buffer(4)).unwrap();
        }
    }
    let mut run = system.live();
    let ended = Arc::new(AtomicBool::new(false));
    let threads: Vec<_> = rings
        .iter()
        .take(3)
        .map(|(_, told)| {
            let (lent, stop) = (lender(told), Arc::clone(&ended));
            std::thread::spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    lent();
                    std::thread::sleep(Duration::from_micros(300));
                }
            })
        })
        .collect();
    for round in 1..=5 {
        run_until(&mut run, |_: &Live| {
            let mut rings = rings.iter();
            rings.all(|(passed, _)| passed.load(Ordering::Relaxed) >= round * 300)
        });
    }
    ended.store(true, Ordering::Relaxed);
    for thread in threads {
        thread.join().unwrap();
    }
}
