//! Background work: a cycle does not wait for it, and simulated runs stay equal.

use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::common::{Number, number, run_until};
use asmotion_component::{Activity, BackgroundWork, Component, Cycle, Fault, Out, Span, Time};
use asmotion_runtime::{Event, Run, System};

/// Spawns background work once and writes its result. Counts the cycles until then.
struct Spawner {
    out: Out<Number>,
    work: Option<Box<dyn FnOnce() -> i64 + Send>>,
    under_way: Option<BackgroundWork<i64>>,
    cycles: Arc<Mutex<u64>>,
}

impl Component for Spawner {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        *self.cycles.lock().unwrap() += 1;
        if let Some(work) = self.work.take() {
            self.under_way = Some(cycle.spawn(work));
        }
        if let Some(result) = self.under_way.as_mut().and_then(BackgroundWork::take) {
            cycle.write(self.out, number(result?));
        }
        Ok(())
    }
}

fn system(
    activity: Activity,
    work: impl FnOnce() -> i64 + Send + 'static,
) -> (System, Arc<Mutex<u64>>) {
    let (mut system, cycles) = (System::new(), Arc::new(Mutex::new(0)));
    let seen = Arc::clone(&cycles);
    system
        .add("Spawner", activity, move |interface| {
            Box::new(Spawner {
                out: interface.output("n", "the result"),
                work: Some(Box::new(work)),
                under_way: None,
                cycles: seen,
            })
        })
        .unwrap();
    (system, cycles)
}

fn is_written(event: &Event<'_>) -> bool {
    matches!(event, Event::Published { .. })
}

#[test]
fn in_simulated_time_the_result_comes_in_the_cycle_that_spawned() {
    let (system, cycles) = system(Activity::periodic(10.ms()), || 7);
    let mut run = system.simulate();
    assert!(run.run_until_event(Time::ZERO + 1.s(), &mut |_, event| is_written(event)));
    assert_eq!(*cycles.lock().unwrap(), 1);
}

/// Work that blocks until the test sends to `gate`.
fn gated(gate: Receiver<()>) -> impl FnOnce() -> i64 + Send {
    move || {
        gate.recv().unwrap();
        7
    }
}

#[test]
fn live_cycles_go_on_while_the_work_is_under_way() {
    let (open, gate) = channel();
    let (system, cycles) = system(Activity::periodic(1.ms()), gated(gate));
    let mut run = system.live();
    run_until(&mut run, |_| *cycles.lock().unwrap() > 3);
    open.send(()).unwrap();
    assert!(run.run_until_event(Time::ZERO + 10.s(), &mut |_, event| is_written(event)));
}

#[test]
fn live_the_end_of_the_work_triggers_an_event_driven_component() {
    let (open, gate) = channel();
    let (system, cycles) = system(Activity::event(), gated(gate));
    let mut run = system.live();
    run_until(&mut run, |_| *cycles.lock().unwrap() > 0);
    run.run_for(Duration::from_millis(30));
    assert_eq!(*cycles.lock().unwrap(), 1, "only the cycle of the start");
    open.send(()).unwrap();
    run_until(&mut run, |_| *cycles.lock().unwrap() == 2);
}

#[test]
#[allow(clippy::panic, reason = "the subject")]
fn work_that_panics_is_a_fault_of_the_component_that_takes_it() {
    let (system, _) = system(Activity::periodic(10.ms()), || panic!("no such map"));
    let mut run = system.simulate();
    run.run_for(20.ms());
    let fault = run.fault("Spawner").unwrap();
    assert_eq!(fault.to_string(), "panicked: no such map");
}
