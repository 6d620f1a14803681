//! Windows: shortcuts to interned locations.
//!
//! Most functions over Integer are used with small numbers, like arrays. Their locations are
//! interned and found by hashing. A window over small arguments caches the slots of accessed
//! locations, which makes access as fast as with a finite domain.

use asmotion_ir::{
    AxisRange, DomainElements, Function, Program, Slot, SlotAxis, Storage, ValueShape,
};

/// Limit for the number of locations in the window of a function.
const MAX_SIZE: u32 = 1 << 16;

/// Least extent of a window along an axis for which it pays off.
const MIN_NUMBERS: u32 = 16;

/// Least number in a window.
const LEAST: i64 = -16;

/// Returns the window of each interned function that has one, with its index in [`Near`].
pub(crate) fn windows(program: &Program) -> Vec<Option<(usize, Vec<SlotAxis>)>> {
    let mut count = 0;
    let window = |function: &Function| {
        let axes = window(program, function)?;
        count += 1;
        Some((count - 1, axes))
    };
    program.functions.iter().map(window).collect()
}

/// Returns the axes of a function's window, if it has one.
fn window(program: &Program, function: &Function) -> Option<Vec<SlotAxis>> {
    if function.storage != Storage::Interned || function.parameters.len() > crate::limits::MAX_AXES
    {
        return None;
    }
    let known: Vec<Option<AxisRange>> = function
        .parameters
        .iter()
        .map(|shape| finite(program, shape))
        .collect::<Option<_>>()?;
    let finite = known
        .iter()
        .flatten()
        .try_fold(1u32, |product, range| product.checked_mul(range.count()));
    let open = known.iter().filter(|range| range.is_none()).count();
    let room = MAX_SIZE.checked_div(finite?)?;
    // divides the available locations evenly among the unbounded axes
    let numbers = f64::from(room).powf(1.0 / open as f64).floor() as u32;
    if open == 0 || numbers < MIN_NUMBERS {
        return None;
    }
    let mut stride = 1;
    let axes = known.into_iter().map(|range| {
        let over = range.unwrap_or(AxisRange::Ints {
            low: LEAST,
            count: numbers,
        });
        let axis = SlotAxis { over, stride };
        stride *= over.count();
        axis
    });
    Some(axes.collect())
}

/// Returns the range of an argument, `Some(None)` for integers, and `None` if a window does not
/// support it.
fn finite(program: &Program, shape: &ValueShape) -> Option<Option<AxisRange>> {
    match shape {
        ValueShape::Int | ValueShape::Natural => Some(None),
        ValueShape::Bool => Some(Some(AxisRange::Bool)),
        ValueShape::Domain(domain) => match program.domains[domain.0 as usize].elements {
            DomainElements::Atoms { first, count } if count > 0 => Some(Some(AxisRange::Atoms {
                first: first.0,
                count,
            })),
            DomainElements::Ints { .. } | DomainElements::Computed(_) => Some(None),
            DomainElements::Atoms { .. } | DomainElements::Undefined | DomainElements::Open => None,
        },
        ValueShape::Real
        | ValueShape::Char
        | ValueShape::Text
        | ValueShape::Complex
        | ValueShape::Rule
        | ValueShape::Tuple(_)
        | ValueShape::Seq(_)
        | ValueShape::Set(_)
        | ValueShape::Bag(_)
        | ValueShape::Map(..)
        | ValueShape::Any => None,
    }
}

/// The cached slots, by window and index within it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Near {
    slots: Vec<Vec<Option<Slot>>>,
    /// Greatest cached slot.
    greatest: Option<Slot>,
}

impl Near {
    /// Returns the cached slot at an index of a window.
    #[inline]
    pub fn find(&self, window: usize, index: u32) -> Option<Slot> {
        *self.slots.get(window)?.get(index as usize)?
    }

    /// Removes the slots from this one on.
    pub fn forget(&mut self, from: Slot) {
        if self.greatest < Some(from) {
            return;
        }
        for slot in self.slots.iter_mut().flatten() {
            if slot.is_some_and(|slot| slot >= from) {
                *slot = None;
            }
        }
        self.greatest = from.checked_sub(1);
    }

    /// Adds a slot to the cache.
    pub fn remember(&mut self, window: usize, index: u32, slot: Slot) {
        if self.slots.len() <= window {
            self.slots.resize(window + 1, Vec::new());
        }
        let slots = &mut self.slots[window];
        if slots.len() <= index as usize {
            slots.resize(index as usize + 1, None);
        }
        slots[index as usize] = Some(slot);
        self.greatest = self.greatest.max(Some(slot));
    }
}
