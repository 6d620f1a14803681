//! The successors of a round of states, found by several threads.

use super::steps::{GroundedSteps, KnownNodes, StepsOfStates};
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// Number of states that a thread takes at a time.
const PART_STATES: u32 = 256;

/// Finds the successors of consecutive states with several threads; returns them in order.
pub(crate) fn find_shared<const W: usize>(
    own: &mut GroundedSteps<'_, W>,
    others: &mut [GroundedSteps<'_, W>],
    states: Range<u32>,
    known: KnownNodes<'_, W>,
) -> Vec<StepsOfStates<W>> {
    let next = AtomicU32::new(states.start);
    let work = |steps: &mut GroundedSteps<'_, W>| {
        let mut done = Vec::new();
        loop {
            let start = next.fetch_add(PART_STATES, Ordering::Relaxed);
            if start >= states.end {
                return done;
            }
            let end = start.saturating_add(PART_STATES).min(states.end);
            done.push((start, steps.find_all(start..end, known)));
        }
    };
    let mut all = std::thread::scope(|scope| {
        let work = &work;
        let running = others
            .iter_mut()
            .map(|steps| scope.spawn(move || work(steps)));
        let running: Vec<_> = running.collect();
        let mut all = work(own);
        for thread in running {
            match thread.join() {
                Ok(done) => all.extend(done),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    });
    all.sort_by_key(|(start, _)| *start);
    all.into_iter().map(|(_, found)| found).collect()
}
