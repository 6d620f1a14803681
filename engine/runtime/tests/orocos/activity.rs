//! Activities: O3.

use std::sync::{Arc, Mutex};
use std::thread::ThreadId;

use asmotion_component::{Activity, Component, Interface, Scheduler, Span, ThreadUse};
use asmotion_runtime::{BuildError, Log, Run, System};

use crate::common::{behaviour, in_real_time};

/// Cycles in order: name of the component, and its thread.
type Cycles = Arc<Mutex<Vec<(&'static str, ThreadId)>>>;

fn noting(
    name: &'static str,
    cycles: &Cycles,
) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let cycles = Arc::clone(cycles);
    behaviour(move |_| {
        move |_| {
            let mut cycles = cycles.lock().unwrap();
            cycles.push((name, std::thread::current().id()));
            Ok(())
        }
    })
}

/// A master, its slave, the slave's slave, and an independent component; the slaves are added before their master.
fn household(cycles: &Cycles) -> System {
    let mut system = System::new();
    for (name, activity) in [
        ("Grandchild", Activity::event()),
        ("Child", Activity::periodic(1.ms())),
        ("Master", Activity::periodic(10.ms()).thread(ThreadUse::Own)),
        ("Other", Activity::periodic(10.ms()).thread(ThreadUse::Own)),
    ] {
        system.add(name, activity, noting(name, cycles)).unwrap();
    }
    system.add_slave("Grandchild", "Child").unwrap();
    system.add_slave("Child", "Master").unwrap();
    system
}

#[test]
fn o3_a_slave_cycles_after_its_master_and_only_then() {
    let cycles = Cycles::default();
    let log = Log::new();
    let mut system = household(&cycles);
    system.observe(log.clone());
    system.simulate().run_for(25.ms());
    let order: Vec<_> = cycles
        .lock()
        .unwrap()
        .iter()
        .map(|(name, _)| *name)
        .collect();
    assert_eq!(order, ["Master", "Child", "Grandchild", "Other"].repeat(3));
    assert_eq!(
        log.lines_with("Child: cycle 3"),
        ["0.02 s Child: cycle 3"],
        "at one instant"
    );
}

#[test]
fn o3_a_slave_cycles_in_its_masters_thread() {
    in_real_time(|| {
        let cycles = Cycles::default();
        let mut run = household(&cycles).live();
        run.run_for(200.ms());
        run.stop();
        let cycles = cycles.lock().unwrap();
        let thread = |of: &str| {
            let mut threads: Vec<_> = cycles
                .iter()
                .filter(|(name, _)| *name == of)
                .map(|(_, id)| *id)
                .collect();
            threads.dedup();
            assert_eq!(threads.len(), 1, "{of} has one thread");
            threads[0]
        };
        assert_eq!(thread("Master"), thread("Child"));
        assert_eq!(thread("Master"), thread("Grandchild"));
        assert_ne!(thread("Master"), thread("Other"));
        let order: Vec<_> = cycles
            .iter()
            .map(|(name, _)| *name)
            .filter(|name| *name != "Other")
            .collect();
        assert!(order.len() > 15, "{order:?}");
        assert!(
            order
                .chunks(3)
                .all(|three| ["Master", "Child", "Grandchild"].starts_with(three))
        );
    });
}

#[test]
fn o3_a_slave_rests_when_its_master_does_or_itself_is_stopped() {
    use asmotion_component::Transition::{Start, Stop};
    let cycles = Cycles::default();
    let mut run = household(&cycles).simulate();
    let cycled = |run: &mut asmotion_runtime::Simulation| {
        run.run_for(10.ms());
        let cycles = std::mem::take(&mut *cycles.lock().unwrap());
        cycles.into_iter().map(|(name, _)| name).collect::<Vec<_>>()
    };
    run.run_for(5.ms());
    cycled(&mut run);
    run.transition("Child", Stop).unwrap();
    assert_eq!(cycled(&mut run), ["Master", "Other"]);
    run.transition("Child", Start).unwrap();
    run.transition("Master", Stop).unwrap();
    assert_eq!(cycled(&mut run), ["Other"]);
}

#[test]
fn o3_nobody_is_his_own_master() {
    let mut system = household(&Cycles::default());
    for (slave, master) in [("Master", "Master"), ("Master", "Grandchild")] {
        let refused = system.add_slave(slave, master);
        assert!(
            matches!(refused, Err(BuildError::MasterCycle { .. })),
            "{slave} {master}"
        );
    }
    let refused = system.add_slave("Other", "Mastr").unwrap_err();
    assert_eq!(
        refused.to_string(),
        "unknown component `Mastr`; did you mean `Master`?"
    );
}

/// The output of `chrt -p` and `taskset -p` for a thread.
fn asked(command: &str, thread: i32) -> Option<String> {
    let output = std::process::Command::new(command)
        .arg("-p")
        .arg(thread.to_string())
        .output()
        .ok()?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// A component that stores its kernel thread id.
fn telling(number: &Arc<Mutex<i32>>) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let number = Arc::clone(number);
    behaviour(move |_| {
        move |_| {
            let link = std::fs::read_link("/proc/thread-self")?;
            let last = link
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            *number.lock().unwrap() = last.parse()?;
            Ok(())
        }
    })
}

#[test]
fn o3_a_thread_is_in_the_class_and_on_the_processors_that_the_activity_names_where_permitted() {
    let number = Arc::new(Mutex::new(0));
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let activity = Activity::periodic(10.ms())
        .scheduler(Scheduler::Fifo)
        .priority(80)
        .cpus([0]);
    system.add("It", activity, telling(&number)).unwrap();
    let mut run = system.live();
    run.run_for(100.ms());
    let thread = *number.lock().unwrap();
    let denied = log.lines_with("It: FIFO 80 is not permitted");
    if let [denied] = &denied[..] {
        assert!(denied.ends_with("allow it by `ulimit -r 80`, or give the program CAP_SYS_NICE"));
        eprintln!("not tried: this program may not run at FIFO 80");
    } else if let Some(said) = asked("chrt", thread) {
        assert!(
            said.contains("SCHED_FIFO") && said.contains("priority: 80"),
            "{said}"
        );
    }
    if let Some(said) = asked("taskset", thread) {
        assert!(said.trim_end().ends_with("affinity mask: 1"), "{said}");
    }
}

#[test]
fn o3_what_is_not_permitted_is_told_with_a_way_out_and_the_component_runs() {
    let number = Arc::new(Mutex::new(0));
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    // no test machine has that many processors
    let activity = Activity::periodic(10.ms()).cpus([1023]);
    system.add("It", activity, telling(&number)).unwrap();
    let mut run = system.live();
    run.run_for(100.ms());
    assert!(run.cycles("It") > 3);
    let denied = log.lines_with("not permitted");
    let [denied] = &denied[..] else {
        panic!("{denied:?}")
    };
    assert!(
        denied.contains("It: processors [1023] is not permitted: "),
        "{denied}"
    );
    assert!(
        denied.contains("name processors that this machine has"),
        "{denied}"
    );
}
