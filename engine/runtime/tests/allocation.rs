//! After warm-up, the framework's part of a cycle allocates no memory for messages that need none.
#![allow(
    unsafe_code,
    clippy::unwrap_used,
    reason = "tests; the counting allocator hands every request on to the system's"
)]

mod common;

use std::alloc::{GlobalAlloc, Layout, System as Heap};
use std::cell::Cell;

use asmotion_component::{Activity, OnStale, Policy, Span};
use asmotion_runtime::{Run, System};
use common::{Number, behaviour, counter, number};

/// Counts allocations per thread, because the test harness has threads too.
struct Counting;

thread_local! {
    static TAKEN: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every request is passed unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        TAKEN.set(TAKEN.get() + 1);
        // SAFETY: upheld by the caller
        unsafe { Heap.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: upheld by the caller
        unsafe { Heap.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_cycle_takes_no_memory_after_warm_up() {
    let mut system = System::new();
    system
        .add("Counter", Activity::periodic(10.ms()), counter())
        .unwrap();
    let relaying = || {
        behaviour(|interface| {
            let input = interface.input::<Number>("in", "numbers");
            let output = interface.output::<Number>("out", "the next ones");
            let step = interface.property("step", 1_i64, "how far to the next");
            move |cycle| {
                let sum: i64 = cycle.all(input).iter().map(|sample| sample.n).sum();
                let step = cycle.property(step);
                if !cycle.is_stale(input) {
                    cycle.write(output, number(sum + step));
                }
                Ok(())
            }
        })
    };
    system
        .add("Triggered", Activity::event(), relaying())
        .unwrap();
    system
        .add("Periodic", Activity::periodic(20.ms()), relaying())
        .unwrap();
    system.publish("Counter.n", "numbers").unwrap();
    let policy = Policy::data().max_age(100.ms()).on_stale(OnStale::Zero);
    system.subscribe("numbers", "Triggered.in", policy).unwrap();
    system
        .subscribe("numbers", "Periodic.in", Policy::circular(8))
        .unwrap();
    system
        .connect("Triggered.out", "Periodic.in", Policy::buffer(8))
        .unwrap();
    let mut run = system.simulate();
    run.run_for(1.s());
    let (before, cycles) = (TAKEN.get(), run.cycles("Triggered"));
    run.run_for(10.s());
    let taken = TAKEN.get() - before;
    assert_eq!(run.cycles("Triggered") - cycles, 1000);
    assert_eq!(taken, 0);
}
