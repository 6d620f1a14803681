//! Inputs for commands: what arrives while the component does not run is discarded when it starts.

use std::sync::{Arc, Mutex};

use asmotion_component::{
    Activity, Component, Interface, PeerStatus, Policy, Span, State, Transition,
};
use asmotion_runtime::{Event, Run, System};

use crate::common::{Number, behaviour, number};

type Numbers = Arc<Mutex<Vec<i64>>>;

/// Records what it reads from `command` and from `state`.
fn driver(read: &[Numbers; 2]) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let read = read.clone();
    behaviour(move |interface| {
        let command = interface.input::<Number>("command", "to be carried out");
        let inputs = [
            interface.command(command),
            interface.input::<Number>("state", "such as a map"),
        ];
        move |cycle| {
            for (input, read) in inputs.iter().zip(&read) {
                let all = cycle.all(*input).iter().map(|sample| sample.n);
                read.lock().unwrap().extend(all);
            }
            Ok(())
        }
    })
}

/// Writes the prepared numbers.
fn commander(ready: &Numbers) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let ready = Arc::clone(ready);
    behaviour(move |interface| {
        let out = interface.output::<Number>("n", "commands");
        move |cycle| {
            for n in std::mem::take(&mut *ready.lock().unwrap()) {
                cycle.write(out, number(n));
            }
            Ok(())
        }
    })
}

/// The driver in these periods, and a commander that writes to both of its inputs with this policy.
struct Bench {
    system: System,
    ready: Numbers,
    read: [Numbers; 2],
    dropped: Arc<Mutex<Vec<String>>>,
}

impl Bench {
    fn new(runs: bool, policy: &Policy) -> Self {
        let mut system = System::new();
        let (ready, read) = (Numbers::default(), <[Numbers; 2]>::default());
        let activity = Activity::periodic(10.ms());
        let added = system.add("Commander", activity.clone(), commander(&ready));
        added.unwrap();
        let activity = activity.run_on_startup(runs);
        system.add("Driver", activity, driver(&read)).unwrap();
        for input in ["Driver.command", "Driver.state"] {
            system
                .connect("Commander.n", input, policy.clone())
                .unwrap();
        }
        let dropped = Arc::<Mutex<Vec<String>>>::default();
        let told = Arc::clone(&dropped);
        system.observe(move |_, event: &Event<'_>| {
            if let Event::Dropped {
                port,
                total,
                reason,
                ..
            } = event
            {
                let reason = reason.map(ToString::to_string).unwrap_or_default();
                told.lock()
                    .unwrap()
                    .push(format!("{port} {total}: {reason}"));
            }
        });
        Self {
            system,
            ready,
            read,
            dropped,
        }
    }

    fn read(&self) -> [Vec<i64>; 2] {
        let read = self.read.each_ref();
        read.map(|numbers| std::mem::take(&mut *numbers.lock().unwrap()))
    }
}

fn prepare(ready: &Numbers, numbers: &[i64], run: &mut impl Run) {
    ready.lock().unwrap().extend(numbers);
    run.run_for(50.ms());
}

#[test]
fn a_component_that_starts_again_discards_the_commands_of_the_meantime_and_keeps_a_state() {
    for policy in [Policy::data(), Policy::buffer(8)] {
        let mut bench = Bench::new(true, &policy);
        let mut run = std::mem::take(&mut bench.system).simulate();
        prepare(&bench.ready, &[1], &mut run);
        assert_eq!(bench.read(), [[1], [1]]);
        run.transition("Driver", Transition::Stop).unwrap();
        for n in 2..=3 {
            prepare(&bench.ready, &[n], &mut run);
        }
        run.transition("Driver", Transition::Start).unwrap();
        prepare(&bench.ready, &[4], &mut run);
        let is_queue = policy.kind != asmotion_component::BufferKind::Data;
        let kept = if is_queue { vec![2, 3, 4] } else { vec![3, 4] };
        let lost = 1 + u64::from(is_queue);
        assert_eq!(bench.read(), [vec![4], kept], "{policy:?}");
        assert_eq!(run.losses("Driver").dropped, lost);
        let reason = format!("command {lost}: arrived before the component started");
        let dropped = bench.dropped.lock().unwrap();
        assert_eq!(dropped.len(), 1, "{dropped:?}");
        assert!(dropped[0].starts_with(&reason), "{dropped:?}");
    }
}

#[test]
fn a_component_that_starts_for_the_first_time_discards_them_too() {
    let mut bench = Bench::new(false, &Policy::data());
    let mut run = std::mem::take(&mut bench.system).simulate();
    prepare(&bench.ready, &[1], &mut run);
    run.transition("Driver", Transition::Start).unwrap();
    run.run_for(50.ms());
    assert_eq!(bench.read(), [vec![], vec![1]]);
    assert_eq!(run.losses("Driver").dropped, 1);
}

#[test]
fn a_connection_with_init_keeps_its_newest_command() {
    let mut bench = Bench::new(false, &Policy::data().init());
    let mut run = std::mem::take(&mut bench.system).simulate();
    prepare(&bench.ready, &[1], &mut run);
    run.transition("Driver", Transition::Start).unwrap();
    run.run_for(50.ms());
    assert_eq!(bench.read(), [[1], [1]]);
    assert_eq!(run.losses("Driver").dropped, 0);
}

#[test]
fn live_components_discard_them_as_simulated_ones_do() {
    let mut bench = Bench::new(false, &Policy::data());
    let mut run = std::mem::take(&mut bench.system).live();
    bench.ready.lock().unwrap().push(1);
    let written = |_, event: &Event<'_>| matches!(event, Event::Published { .. });
    let limit = run.now() + 10.s();
    assert!(run.run_until_event(limit, &mut { written }));
    run.transition("Driver", Transition::Start).unwrap();
    while run.cycles("Driver") < 2 {
        run.run_for(10.ms());
    }
    assert_eq!(bench.read(), [vec![], vec![1]]);
    assert_eq!(run.losses("Driver").dropped, 1);
}

/// Lets three commands wait for a component that is stopped, and then lets it read them. Returns how many wait each time.
fn waiting(mut run: impl Run, ready: &Numbers) -> [Vec<u64>; 2] {
    run.transition("Driver", Transition::Stop).unwrap();
    ready.lock().unwrap().extend([1, 2, 3]);
    while !ready.lock().unwrap().is_empty() {
        run.run_for(10.ms());
    }
    // the cycle that writes them has ended
    let cycles = run.cycles("Commander");
    while run.cycles("Commander") < cycles + 2 {
        run.run_for(10.ms());
    }
    let stopped = run.waiting("Driver");
    run.transition("Driver", Transition::Start).unwrap();
    let cycles = run.cycles("Driver");
    while run.cycles("Driver") < cycles + 2 {
        run.run_for(10.ms());
    }
    [stopped, run.waiting("Driver")]
}

#[test]
fn messages_that_wait_for_a_component_are_counted_also_in_other_threads() {
    for (policy, expected) in [
        (Policy::buffer(8), 3),
        (Policy::circular(2), 2),
        // the newest message alone is no queue
        (Policy::data(), 0),
    ] {
        let mut bench = Bench::new(true, &policy);
        let run = std::mem::take(&mut bench.system).simulate();
        let expected = [vec![expected; 2], vec![0; 2]];
        assert_eq!(waiting(run, &bench.ready), expected, "{policy:?}");
        let mut bench = Bench::new(true, &policy);
        let run = std::mem::take(&mut bench.system).live();
        assert_eq!(waiting(run, &bench.ready), expected, "{policy:?}");
    }
}

#[test]
fn a_component_sees_the_state_of_another_one_and_whether_it_reaches_what_it_stands_for() {
    let seen = Arc::<Mutex<Vec<Option<PeerStatus>>>>::default();
    let (written, reachable) = (Arc::clone(&seen), Arc::new(Mutex::new(true)));
    let set = Arc::clone(&reachable);
    let mut system = System::new();
    let activity = || Activity::periodic(10.ms());
    let stand_in = behaviour(move |_| {
        move |cycle| {
            cycle.set_reachable(*set.lock().unwrap());
            Ok(())
        }
    });
    system.add("Robot", activity(), stand_in).unwrap();
    let observer = behaviour(move |_| {
        move |cycle| {
            let peers = ["Robot", "Nobody"].map(|name| cycle.peer(name));
            written.lock().unwrap().extend(peers);
            Ok(())
        }
    });
    system.add("Observer", activity(), observer).unwrap();
    let mut run = system.simulate();
    let last = |run: &mut asmotion_runtime::Simulation| {
        run.run_for(20.ms());
        let mut seen = seen.lock().unwrap();
        assert_eq!(seen.pop(), Some(None), "there is no such component");
        seen.pop().flatten().unwrap()
    };
    let status = |state, is_reachable| PeerStatus {
        state,
        is_reachable,
    };
    assert_eq!(last(&mut run), status(State::Running, true));
    *reachable.lock().unwrap() = false;
    assert_eq!(last(&mut run), status(State::Running, false));
    run.transition("Robot", Transition::Stop).unwrap();
    assert_eq!(last(&mut run), status(State::Stopped, false));
}
