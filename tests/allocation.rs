//! A step of the coordinator allocates no memory. A separate binary, because the counting allocator is global.

#![allow(unsafe_code, reason = "a global allocator is unsafe to write")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

#[path = "../benches/machines/mission.rs"]
mod mission;

use asmotion_lang::{BackEnd, FirstChoice, MemoryFiles};
use mission::Mission;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator with a counter per thread, because the test harness has threads too.
struct Counted;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is passed unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        // SAFETY: the caller upholds the contract, which is the system allocator's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller upholds the contract, which is the system allocator's.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        // SAFETY: the caller upholds the contract, which is the system allocator's.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counted = Counted;

#[test]
fn a_step_asks_for_no_memory() {
    let mut files = MemoryFiles::new();
    files.add(
        "S1_navigate.asm",
        include_str!("../benches/machines/S1_navigate.asm"),
    );
    let specification = asmotion_lang::open("S1_navigate.asm", &files)
        .unwrap_or_else(|failure| panic!("{failure}"));
    // a machine that changes its back end while it runs allocates for the compilation
    for back_end in [BackEnd::Closures, BackEnd::Native] {
        let mut machine = specification.machine().unwrap();
        machine.set_back_end(back_end).unwrap();
        let mut mission = Mission::of(&machine);
        let mut steps = |count: usize| {
            for _ in 0..count {
                machine.step(&mut mission, &mut FirstChoice, 0).unwrap();
            }
        };
        steps(1_000);
        let before = COUNT.get();
        steps(10_000);
        assert_eq!(
            COUNT.get() - before,
            0,
            "allocations in 10,000 steps: {back_end:?}"
        );
    }
}
