//! The order in which the units of a simulation cycle, learned to prefetch the memory of those that are next.
//!
//! A system of thousands of components does not fit into the caches of the processor. In most systems the same unit follows
//! another one in each period, so the order of the last period tells which memory is needed next. The prefetches of a unit are
//! spread over the cycles of the units before it: each follows pointers that the one before has loaded. They are hints, so a
//! wrong prediction costs time and changes nothing.

use crate::component_unit::ComponentUnit;

/// Number of units from which on their memory may not be in the caches any more when they cycle again.
const MANY: usize = 64;

/// Number of prefetches of a unit, of which each follows one more pointer.
const DEPTHS: usize = 5;

/// For each unit, the one that cycled after it last. Not part of the frozen state: it influences nothing but time.
#[derive(Default)]
pub(super) struct CycleOrder {
    followers: Vec<u32>,
    last: usize,
}

impl CycleOrder {
    /// Prefetches memory of the units that probably cycle after this one, whose cycle begins.
    pub(super) fn prefetch_next(&mut self, units: &[ComponentUnit], component: usize) {
        if units.len() < MANY {
            return;
        }
        self.note(units.len(), component);
        let mut next = component;
        for ahead in 1..=DEPTHS {
            next = self.follower(next);
            if let Some(unit) = units.get(next) {
                unit.prefetch(DEPTHS - ahead);
            }
        }
    }

    fn note(&mut self, units: usize, component: usize) {
        if self.followers.len() < units {
            // until they are known, each is followed by itself: it is in the caches anyway
            let known = u32::try_from(self.followers.len()).unwrap_or(u32::MAX);
            self.followers
                .extend((known..).take(units - self.followers.len()));
        }
        if let (Some(follower), Ok(next)) =
            (self.followers.get_mut(self.last), u32::try_from(component))
        {
            *follower = next;
        }
        self.last = component;
    }

    fn follower(&self, component: usize) -> usize {
        let follower = self.followers.get(component);
        follower.map_or(component, |next| *next as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_that_followed_last_time_is_expected_next() {
        let mut order = CycleOrder::default();
        for component in [0, 3, 1, 2, 0] {
            order.note(4, component);
        }
        let expected: Vec<usize> = (0..4).map(|it| order.follower(it)).collect();
        assert_eq!(expected, [3, 2, 0, 1]);
        // a change is learned at once, and so is a new unit
        order.note(5, 4);
        order.note(5, 3);
        let expected: Vec<usize> = (0..5).map(|it| order.follower(it)).collect();
        assert_eq!(expected, [4, 2, 0, 1, 3]);
        assert_eq!(order.follower(9), 9);
    }
}
