//! Update sets: collected in parallel, applied at once.
//!
//! The updates of a step form one list. For each slot, a mark holds the index of the slot's update,
//! valid if the mark's epoch is the current one. A clash is thus found by one comparison, and
//! incrementing the epoch starts a new set. Within `seq`, sets are nested: each rule of the
//! sequence has a layer, which is applied to the state when the rule ends and undone when the
//! sequence ends.

use crate::fault::FaultKind;
use asmotion_ir::{DomainId, Origin, Slot};
use asmotion_value::{Atom, Value};
use std::sync::Arc;

/// An update of a location.
#[derive(Clone, Debug, PartialEq)]
pub struct Update {
    /// Slot of the location.
    pub slot: Slot,
    /// Value of the location in the next state.
    pub value: Value,
    /// Place of the rule that produced it, so that a clash can show both writers.
    pub origin: Origin,
}

impl Update {
    /// Returns the fault for a second, different value of the same location.
    fn clash(&self, second: Value) -> FaultKind {
        FaultKind::Clash {
            slot: self.slot,
            first: self.value.clone(),
            first_origin: self.origin,
            second,
        }
    }
}

/// The update of a slot in the set of an epoch.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mark {
    /// Epoch of the set; the mark is void in any other.
    pub epoch: u32,
    /// Index of the update in the list.
    pub index: u32,
}

/// A mark of an outer set, saved because the current set has overwritten it. Native code writes it,
/// hence the layout.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CoveredMark {
    /// The slot whose mark was overwritten.
    pub slot: Slot,
    /// The slot's mark in the outer set.
    pub mark: Mark,
}

/// The value of a slot before a sequence changed it. Native code writes it, hence the layout.
#[derive(Debug)]
#[repr(C)]
pub struct SavedValue {
    /// The previous value, moved out of the slot.
    pub value: Value,
    /// The slot that was changed.
    pub slot: Slot,
}

/// Further changes to undo when an intermediate state is left.
#[derive(Debug)]
enum UndoEntry {
    /// The environment was asked for a slot; the previous round is restored.
    Read(Slot, u64),
    /// An element was appended to the extent of a domain.
    Extended(DomainId),
}

/// The intermediate state, while a term is evaluated in the state before the step.
#[derive(Debug)]
pub(crate) struct LeftState {
    /// Number of undo entries at the time of leaving.
    undo: usize,
    /// The elements removed from the extents, the one added first being last.
    joined: Vec<Value>,
}

/// The update set of the current step, with its nested layers.
#[derive(Debug, Default)]
pub(crate) struct Updates {
    /// The updates of all layers; those of the innermost one come last.
    pub list: Vec<Update>,
    /// The elements added to domains by all layers; those of the innermost one come last.
    pub extended: Vec<(DomainId, Atom)>,
    marks: Vec<Mark>,
    epoch: u32,
    /// The last epoch allocated.
    last_epoch: u32,
    covered: Vec<CoveredMark>,
    saved: Vec<SavedValue>,
    undo: Vec<UndoEntry>,
    depth: u32,
    /// Layers opened by native code, innermost last.
    pub layers: Vec<Layer>,
}

/// The lengths of the lists and the epoch at the start of a layer, restored at its end.
#[derive(Debug)]
pub(crate) struct Layer {
    start: usize,
    extended: usize,
    covered: usize,
    saved: usize,
    undo: usize,
    epoch: u32,
}

/// The parts of a state that updates change.
pub(crate) struct WritableState<'a> {
    pub slots: &'a mut [Value],
    pub extents: &'a mut [Arc<Vec<Value>>],
    /// Round in which each slot was last asked of the environment.
    pub read_in: &'a mut [u64],
    pub round: u64,
    /// For each domain, the domain itself and all domains it is a subset of.
    pub supers: &'a [Vec<DomainId>],
}

/// The lists of an update set, for native code, which may only
///
/// - append an update of a slot that has none in the innermost set, and set the slot's mark to the
///   epoch and the update's index;
/// - within a sequence, also save the slot's previous value and the mark that is overwritten.
///
/// An update of a slot whose mark has this epoch could be a clash, and is left to closures.
pub struct UpdateLists<'a> {
    /// The updates of all sets; those of the innermost set come last.
    pub updates: &'a mut Vec<Update>,
    /// Values of slots before the sequence, in order of change.
    pub saved: &'a mut Vec<SavedValue>,
    /// Overwritten marks of outer sets.
    pub covered: &'a mut Vec<CoveredMark>,
    /// The mark of each slot, indexed by slot.
    pub marks: &'a mut [Mark],
    /// Epoch of the innermost set; marks with another epoch are void.
    pub epoch: u32,
}

impl Updates {
    /// Starts the update set of a step. The layers of the previous step have restored their lists.
    #[inline]
    pub fn begin(&mut self, slots: usize) {
        self.extended.clear();
        if self.last_epoch > u32::MAX / 2 {
            // invalidates all marks before the epochs can wrap around
            self.marks.fill(Mark::default());
            self.last_epoch = 0;
        }
        self.new_epoch();
        self.grow(slots);
    }

    /// Starts the update set of a step after one without layers and new elements, with as many slots.
    #[inline]
    pub fn begin_again(&mut self) {
        if self.last_epoch > u32::MAX / 2 {
            self.begin(0);
        } else {
            self.new_epoch();
        }
    }

    /// Adds marks for newly interned slots.
    #[inline]
    pub fn grow(&mut self, slots: usize) {
        if self.marks.len() < slots {
            self.marks.resize(slots, Mark::default());
        }
    }

    fn new_epoch(&mut self) {
        // cannot overflow within a step: the limits on loops allow less than 2³¹ sets
        self.last_epoch = self.last_epoch.wrapping_add(1);
        self.epoch = self.last_epoch;
    }

    /// Adds an update to the innermost set.
    #[inline]
    pub fn write(
        &mut self,
        slot: Slot,
        value: Value,
        origin: Origin,
    ) -> Result<(), Box<FaultKind>> {
        let mark = self.marks[slot as usize];
        if mark.epoch == self.epoch {
            return self.write_again(mark.index, value);
        }
        self.mark(slot, self.list.len());
        self.list.push(Update {
            slot,
            value,
            origin,
        });
        Ok(())
    }

    /// Handles a second update of a location: a clash unless the values are equal.
    fn write_again(&self, index: u32, value: Value) -> Result<(), Box<FaultKind>> {
        let first = &self.list[index as usize];
        if first.value == value {
            return Ok(());
        }
        Err(Box::new(first.clash(value)))
    }

    fn mark(&mut self, slot: Slot, index: usize) {
        if self.depth > 0 {
            let mark = self.marks[slot as usize];
            self.covered.push(CoveredMark { slot, mark });
        }
        self.marks[slot as usize] = Mark {
            epoch: self.epoch,
            index: index as u32,
        };
    }

    /// Returns the lists for native code.
    #[inline]
    pub fn lists(&mut self) -> UpdateLists<'_> {
        UpdateLists {
            updates: &mut self.list,
            saved: &mut self.saved,
            covered: &mut self.covered,
            marks: &mut self.marks,
            epoch: self.epoch,
        }
    }

    /// Opens a layer within the current one.
    pub fn open(&mut self) -> Layer {
        let layer = Layer {
            start: self.list.len(),
            extended: self.extended.len(),
            covered: self.covered.len(),
            saved: self.saved.len(),
            undo: self.undo.len(),
            epoch: self.epoch,
        };
        self.depth += 1;
        self.new_epoch();
        layer
    }

    /// Returns `true` outside of sequences: the state is that before the step.
    #[inline]
    pub fn is_outermost(&self) -> bool {
        self.depth == 0
    }

    /// Returns `true` if the layer's set is empty.
    pub fn is_empty(&self, layer: &Layer) -> bool {
        self.list.len() == layer.start && self.extended.len() == layer.extended
    }

    /// Closes a layer within a sequence: applies its updates to the state, and lets them override
    /// those of the enclosing set.
    pub fn close_applying(&mut self, layer: Layer, written: &mut WritableState<'_>) {
        self.restore_marks(&layer);
        for index in layer.start..self.list.len() {
            let update = self.list[index].clone();
            let slot = update.slot as usize;
            let value = std::mem::replace(&mut written.slots[slot], update.value);
            self.saved.push(SavedValue {
                value,
                slot: update.slot,
            });
            // a location written in this step is no longer read from the environment
            if written.read_in[slot] != written.round {
                let before = std::mem::replace(&mut written.read_in[slot], written.round);
                self.undo.push(UndoEntry::Read(update.slot, before));
            }
        }
        for index in layer.extended..self.extended.len() {
            let (domain, atom) = self.extended[index];
            for &domain in &written.supers[domain.0 as usize] {
                let extent = &mut written.extents[domain.0 as usize];
                self.undo.push(UndoEntry::Extended(domain));
                Arc::make_mut(extent).push(Value::Atom(atom));
            }
        }
        // overriding cannot clash
        let _ = self.merge::<()>(layer.start, |known, update| {
            *known = update;
            Ok(())
        });
    }

    /// Adds an update in a sequence that is applied immediately, as if it had a layer of its own.
    pub fn write_through(
        &mut self,
        slot: Slot,
        value: Value,
        origin: Origin,
        written: &mut WritableState<'_>,
    ) {
        let mark = self.marks[slot as usize];
        let slot_value = &mut written.slots[slot as usize];
        if mark.epoch == self.epoch {
            // the value before the sequence is already saved
            let update = &mut self.list[mark.index as usize];
            slot_value.replace_by(value.clone());
            update.value.replace_by(value);
            update.origin = origin;
            return;
        }
        let before = std::mem::replace(slot_value, value.clone());
        self.saved.push(SavedValue {
            value: before,
            slot,
        });
        self.mark(slot, self.list.len());
        self.list.push(Update {
            slot,
            value,
            origin,
        });
    }

    /// Closes a sequence: restores the state before it and merges its net updates into the
    /// enclosing set.
    pub fn close_sequence(
        &mut self,
        layer: Layer,
        written: &mut WritableState<'_>,
    ) -> Result<(), (FaultKind, Origin)> {
        if self.depth > 1 || layer.start > 0 {
            return self.close_restoring(layer, written, |_| false);
        }
        // the enclosing set is that of the step and still empty, so the updates can stay where they
        // are
        self.restore_saved(layer.saved, layer.undo, written);
        self.covered.clear();
        self.depth = 0;
        Ok(())
    }

    /// Closes a sequence like [`Self::close_sequence`], but discards the updates of slots that are
    /// local to it.
    pub fn close_restoring(
        &mut self,
        layer: Layer,
        written: &mut WritableState<'_>,
        is_local: impl Fn(Slot) -> bool,
    ) -> Result<(), (FaultKind, Origin)> {
        self.restore_saved(layer.saved, layer.undo, written);
        self.restore_marks(&layer);
        let mut kept = layer.start;
        for index in layer.start..self.list.len() {
            if !is_local(self.list[index].slot) {
                if kept < index {
                    self.list.swap(kept, index);
                }
                kept += 1;
            }
        }
        self.list.truncate(kept);
        self.merge(layer.start, |known, update| {
            if known.value == update.value {
                return Ok(());
            }
            Err((known.clash(update.value), update.origin))
        })
    }

    /// Sets a slot without an update until the layer is closed.
    pub fn hide(&mut self, slot: Slot, value: Value, written: &mut WritableState<'_>) {
        let value = std::mem::replace(&mut written.slots[slot as usize], value);
        self.saved.push(SavedValue { value, slot });
    }

    /// Lets the environment be asked for a slot again once the intermediate state is undone.
    pub fn undo_read(&mut self, slot: Slot, before: u64) {
        if self.depth > 0 {
            self.undo.push(UndoEntry::Read(slot, before));
        }
    }

    /// Returns the value that the innermost set gives a slot, if any.
    pub fn written_value(&self, slot: Slot) -> Option<&Value> {
        let mark = self.marks[slot as usize];
        (mark.epoch == self.epoch).then(|| &self.list[mark.index as usize].value)
    }

    /// Returns the sizes of the set, for [`Self::abandon`].
    #[inline]
    pub fn grown(&self) -> (usize, usize) {
        (self.list.len(), self.extended.len())
    }

    /// Restores the state after a fault, and truncates the set to the sizes given by
    /// [`Self::grown`].
    pub fn abandon(
        &mut self,
        (updates, extended): (usize, usize),
        written: &mut WritableState<'_>,
    ) {
        self.restore_saved(0, 0, written);
        self.list.truncate(updates);
        self.extended.truncate(extended);
        self.covered.clear();
        self.layers.clear();
        self.depth = 0;
    }

    /// Exchanges the state for the one before all layers, while a term is evaluated.
    pub fn rewind(&mut self, written: &mut WritableState<'_>) -> LeftState {
        for SavedValue { value, slot } in self.saved.iter_mut().rev() {
            std::mem::swap(&mut written.slots[*slot as usize], value);
        }
        let joined = self.undo.iter().rev().filter_map(|undo| match undo {
            UndoEntry::Read(..) => None,
            UndoEntry::Extended(domain) => {
                Arc::make_mut(&mut written.extents[domain.0 as usize]).pop()
            }
        });
        LeftState {
            joined: joined.collect(),
            undo: self.undo.len(),
        }
    }

    /// Returns to the state left by [`Self::rewind`].
    pub fn fast_forward(&mut self, mut passed: LeftState, written: &mut WritableState<'_>) {
        for SavedValue { value, slot } in &mut self.saved {
            std::mem::swap(&mut written.slots[*slot as usize], value);
        }
        for undo in self.undo.iter().take(passed.undo) {
            match undo {
                UndoEntry::Read(..) => {}
                UndoEntry::Extended(domain) => {
                    let extent = Arc::make_mut(&mut written.extents[domain.0 as usize]);
                    extent.extend(passed.joined.pop());
                }
            }
        }
    }

    fn restore_saved(&mut self, held: usize, undo: usize, written: &mut WritableState<'_>) {
        for SavedValue { value, slot } in self.saved.drain(held..).rev() {
            written.slots[slot as usize].replace_by(value);
        }
        for undo in self.undo.drain(undo..).rev() {
            match undo {
                UndoEntry::Read(slot, before) => written.read_in[slot as usize] = before,
                UndoEntry::Extended(domain) => {
                    Arc::make_mut(&mut written.extents[domain.0 as usize]).pop();
                }
            }
        }
    }

    /// Restores the marks that the layer has overwritten.
    fn restore_marks(&mut self, layer: &Layer) {
        for CoveredMark { slot, mark } in self.covered.drain(layer.covered..).rev() {
            self.marks[slot as usize] = mark;
        }
        self.epoch = layer.epoch;
        self.depth -= 1;
    }

    /// Merges the updates from `start` on into the current set.
    fn merge<E>(
        &mut self,
        start: usize,
        mut conflict: impl FnMut(&mut Update, Update) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut kept = start;
        for index in start..self.list.len() {
            let slot = self.list[index].slot;
            let mark = self.marks[slot as usize];
            if mark.epoch == self.epoch {
                let update = self.list[index].clone();
                conflict(&mut self.list[mark.index as usize], update)?;
            } else {
                self.list.swap(kept, index);
                self.mark(slot, kept);
                kept += 1;
            }
        }
        self.list.truncate(kept);
        Ok(())
    }
}
