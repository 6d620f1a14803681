//! Without observers, a step of a coordinator allocates no memory, because it is not formatted.
#![allow(
    unsafe_code,
    clippy::unwrap_used,
    reason = "tests; the counting allocator hands every request on to the system's"
)]

use std::alloc::{GlobalAlloc, Layout, System as Heap};
use std::cell::Cell;

use asmotion_component::{Activity, Span, Time};
use asmotion_coordinator::{Binding, Coordinator, CoordinatorStatus, Interfaces, STEP_REPORT};
use asmotion_lang::MemoryFiles;
use asmotion_runtime::{Event, Observer, ReportInterest, Run, Simulation, System};

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

const CLOCK: &str = "
asm clock
import StandardLibrary
signature:
	controlled ticks: Integer
	controlled even: Boolean
definitions:
	main rule r_Main =
		par
			ticks := ticks + 1
			even := not even
		endpar
default init s0:
	function ticks = 0
	function even = true
";

/// A coordinator with a step every 10 ms that makes two updates.
fn clock() -> Simulation {
    let mut files = MemoryFiles::new();
    files.add("clock.asm", CLOCK);
    let specification = asmotion_lang::open("clock.asm", &files).unwrap();
    let mut system = System::new();
    let made = system.add("Clock", Activity::periodic(10.ms()), |interface| {
        let (binding, interfaces) = (Binding::default(), Interfaces::default());
        let made = Coordinator::new(specification, &binding, &interfaces, 1, interface);
        Box::new(made.unwrap())
    });
    made.unwrap();
    system.simulate()
}

/// Number of allocations in 10 s.
fn taken(run: &mut Simulation) -> u64 {
    run.run_for(1.s());
    let before = TAKEN.get();
    run.run_for(10.s());
    TAKEN.get() - before
}

#[test]
fn a_step_whose_text_nobody_uses_takes_no_memory() {
    let mut run = clock();
    let unused = ReportInterest::Except(&[STEP_REPORT]);
    run.observe((|_: Time, _: &Event<'_>| {}).using(unused));
    assert_eq!(taken(&mut run), 0);
}

#[test]
fn a_step_that_nobody_observes_takes_no_memory() {
    let mut run = clock();
    assert_eq!(taken(&mut run), 0);
    // the status contains the last update set all the same
    let status = CoordinatorStatus::of(&run.inspect("Clock").unwrap()).unwrap();
    let last = status.last_update.unwrap();
    assert_eq!((last.step, status.step), (1101, 1101));
    assert_eq!(
        (&*last.updates["ticks"], &*last.updates["even"]),
        ("1101", "false")
    );
    run.observe(|_: Time, _: &Event<'_>| {});
    assert!(
        taken(&mut run) > 1000,
        "an observer receives each step as text"
    );
}
