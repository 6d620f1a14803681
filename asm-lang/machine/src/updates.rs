//! Update sets: collected in parallel, applied at once.
//!
//! The updates of a step lie in one list. A mark a slot says which update of the list is the slot's,
//! as long as the mark's epoch is the current one: so a clash is found by one comparison, and a new
//! set begins by counting the epoch up. Within `seq` sets nest: a layer of its own for every rule of
//! the sequence, applied to the state when the rule is done and taken back when the sequence is.

use crate::fault::FaultKind;
use asmotion_ir::{DomainId, Origin, Slot};
use asmotion_value::{Atom, Value};
use std::sync::Arc;

/// One update.
#[derive(Clone, Debug, PartialEq)]
pub struct Update {
    /// The location.
    pub slot: Slot,
    /// Its new value.
    pub value: Value,
    /// The rule that wrote it, so that a clash can show both writers.
    pub origin: Origin,
}

impl Update {
    /// The fault that another value for the same location is.
    fn clash(&self, second: Value) -> FaultKind {
        FaultKind::Clash {
            slot: self.slot,
            first: self.value.clone(),
            first_origin: self.origin,
            second,
        }
    }
}

/// Which update is a slot's, in the set of which epoch.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mark {
    /// The epoch of the set.
    pub epoch: u32,
    /// The index of the update in the list.
    pub index: u32,
}

/// A mark of an outer set that the current one covers.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CoveredMark {
    /// The slot.
    pub slot: Slot,
    /// Its mark in the outer set.
    pub mark: Mark,
}

/// What a slot held in the state that a sequence began in.
#[derive(Debug)]
#[repr(C)]
pub struct SavedValue {
    /// What it held.
    pub value: Value,
    /// The slot.
    pub slot: Slot,
}

/// What else taking back an intermediate state must restore.
#[derive(Debug)]
enum UndoEntry {
    /// When a slot was asked of the environment.
    Asked(Slot, u64),
    /// The last element of a domain joined it.
    Joined(DomainId),
}

/// The intermediate state that was left for the one before the step.
#[derive(Debug)]
pub(crate) struct LeftState {
    /// How much there was to undo.
    undo: usize,
    /// The elements that had joined a domain, the first one last.
    joined: Vec<Value>,
}

/// The update set of a step while it grows.
#[derive(Debug, Default)]
pub(crate) struct Updates {
    /// The updates; those of the innermost layer last.
    pub list: Vec<Update>,
    /// New elements of domains, likewise.
    pub extended: Vec<(DomainId, Atom)>,
    marks: Vec<Mark>,
    epoch: u32,
    /// The last epoch given out.
    last_epoch: u32,
    covered: Vec<CoveredMark>,
    held: Vec<SavedValue>,
    undo: Vec<UndoEntry>,
    depth: u32,
    /// The layers that native code has open.
    pub layers: Vec<Layer>,
}

/// What a layer has to give back.
#[derive(Debug)]
pub(crate) struct Layer {
    start: usize,
    extended: usize,
    covered: usize,
    held: usize,
    undo: usize,
    epoch: u32,
}

/// The parts of a state that updates write.
pub(crate) struct WritableState<'a> {
    pub slots: &'a mut [Value],
    pub extents: &'a mut [Arc<Vec<Value>>],
    /// When each slot was last asked of the environment.
    pub asked: &'a mut [u64],
    /// What is asked now.
    pub round: u64,
    /// The domains an element of a domain belongs to, beginning with itself.
    pub supers: &'a [Vec<DomainId>],
}

/// The lists of an update set. Native code may
///
/// - add an update of a slot that has none in the innermost set, and set the slot's mark to the epoch
///   and the update's index;
/// - within a sequence also add what the slot held, and the mark that the new one covers.
///
/// Nothing else: an update that finds a mark of this epoch may be a clash, and is left to closures.
pub struct UpdateLists<'a> {
    /// The updates; those of the innermost set last.
    pub updates: &'a mut Vec<Update>,
    /// What slots held in the state that a sequence began in.
    pub held: &'a mut Vec<SavedValue>,
    /// Marks of outer sets that those of the innermost one cover.
    pub covered: &'a mut Vec<CoveredMark>,
    /// By slot, which update is the slot's.
    pub marks: &'a mut [Mark],
    /// The epoch of the innermost set: marks of another epoch do not count.
    pub epoch: u32,
}

impl Updates {
    /// Begins the update set of a step: what the layers of the last one needed they gave back.
    #[inline]
    pub fn begin(&mut self, slots: usize) {
        self.extended.clear();
        if self.last_epoch > u32::MAX / 2 {
            // no mark of an earlier step counts any more
            self.marks.fill(Mark::default());
            self.last_epoch = 0;
        }
        self.new_epoch();
        self.grow(slots);
    }

    /// Makes room for the marks of newly interned slots.
    #[inline]
    pub fn grow(&mut self, slots: usize) {
        if self.marks.len() < slots {
            self.marks.resize(slots, Mark::default());
        }
    }

    fn new_epoch(&mut self) {
        // a step does not open two thousand million sets: its loops end before
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

    /// The same value once more is no conflict.
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

    /// The lists, for native code.
    #[inline]
    pub fn lists(&mut self) -> UpdateLists<'_> {
        UpdateLists {
            updates: &mut self.list,
            held: &mut self.held,
            covered: &mut self.covered,
            marks: &mut self.marks,
            epoch: self.epoch,
        }
    }

    /// Begins a set within the current one.
    pub fn open(&mut self) -> Layer {
        let layer = Layer {
            start: self.list.len(),
            extended: self.extended.len(),
            covered: self.covered.len(),
            held: self.held.len(),
            undo: self.undo.len(),
            epoch: self.epoch,
        };
        self.depth += 1;
        self.new_epoch();
        layer
    }

    /// Whether the layer's set is empty.
    pub fn is_empty(&self, layer: &Layer) -> bool {
        self.list.len() == layer.start && self.extended.len() == layer.extended
    }

    /// Ends a layer within a sequence: its updates are applied to the state and override those of
    /// the set around it.
    pub fn close_applying(&mut self, layer: Layer, written: &mut WritableState<'_>) {
        self.uncover(&layer);
        for index in layer.start..self.list.len() {
            let update = self.list[index].clone();
            let slot = update.slot as usize;
            let value = std::mem::replace(&mut written.slots[slot], update.value);
            self.held.push(SavedValue {
                value,
                slot: update.slot,
            });
            // what was written in this step is not asked of the environment
            if written.asked[slot] != written.round {
                let before = std::mem::replace(&mut written.asked[slot], written.round);
                self.undo.push(UndoEntry::Asked(update.slot, before));
            }
        }
        for index in layer.extended..self.extended.len() {
            let (domain, atom) = self.extended[index];
            for &domain in &written.supers[domain.0 as usize] {
                let extent = &mut written.extents[domain.0 as usize];
                self.undo.push(UndoEntry::Joined(domain));
                Arc::make_mut(extent).push(Value::Atom(atom));
            }
        }
        // overriding never conflicts
        let _ = self.merge::<()>(layer.start, |known, update| {
            *known = update;
            Ok(())
        });
    }

    /// An update of a rule of a sequence that is applied at once, as if it were a set of its own.
    pub fn write_through(
        &mut self,
        slot: Slot,
        value: Value,
        origin: Origin,
        written: &mut WritableState<'_>,
    ) {
        let mark = self.marks[slot as usize];
        let held = &mut written.slots[slot as usize];
        if mark.epoch == self.epoch {
            // what the sequence found there is known already
            let known = &mut self.list[mark.index as usize];
            held.replace_by(value.clone());
            known.value.replace_by(value);
            known.origin = origin;
            return;
        }
        let before = std::mem::replace(held, value.clone());
        self.held.push(SavedValue {
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

    /// Ends a sequence: the state is as before it, its net updates join the set around it.
    pub fn close_sequence(
        &mut self,
        layer: Layer,
        written: &mut WritableState<'_>,
    ) -> Result<(), (FaultKind, Origin)> {
        if self.depth > 1 || layer.start > 0 {
            return self.close_restoring(layer, written, |_| false);
        }
        // the set around it is the step's and still empty: the sequence's takes its place
        self.take_back(layer.held, layer.undo, written);
        self.covered.clear();
        self.depth = 0;
        Ok(())
    }

    /// Ends a sequence as [`Self::close_sequence`] does, but for the updates of slots that are local to
    /// it: they are forgotten.
    pub fn close_restoring(
        &mut self,
        layer: Layer,
        written: &mut WritableState<'_>,
        is_local: impl Fn(Slot) -> bool,
    ) -> Result<(), (FaultKind, Origin)> {
        self.take_back(layer.held, layer.undo, written);
        self.uncover(&layer);
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

    /// Sets a slot for as long as the layer is open, without an update.
    pub fn hide(&mut self, slot: Slot, value: Value, written: &mut WritableState<'_>) {
        let value = std::mem::replace(&mut written.slots[slot as usize], value);
        self.held.push(SavedValue { value, slot });
    }

    /// Takes it back, with the intermediate state, that a slot was asked of the environment.
    pub fn forget_asking(&mut self, slot: Slot, before: u64) {
        if self.depth > 0 {
            self.undo.push(UndoEntry::Asked(slot, before));
        }
    }

    /// The value that the innermost set gives a slot.
    pub fn given(&self, slot: Slot) -> Option<&Value> {
        let mark = self.marks[slot as usize];
        (mark.epoch == self.epoch).then(|| &self.list[mark.index as usize].value)
    }

    /// How far the set has grown.
    #[inline]
    pub fn grown(&self) -> (usize, usize) {
        (self.list.len(), self.extended.len())
    }

    /// Restores the state after a fault, and the set as it was when it had grown so far.
    pub fn abandon(
        &mut self,
        (updates, extended): (usize, usize),
        written: &mut WritableState<'_>,
    ) {
        self.take_back(0, 0, written);
        self.list.truncate(updates);
        self.extended.truncate(extended);
        self.covered.clear();
        self.layers.clear();
        self.depth = 0;
    }

    /// Exchanges the state for the one before all layers, for as long as a term is evaluated.
    pub fn go_back(&mut self, written: &mut WritableState<'_>) -> LeftState {
        for SavedValue { value, slot } in self.held.iter_mut().rev() {
            std::mem::swap(&mut written.slots[*slot as usize], value);
        }
        let joined = self.undo.iter().rev().filter_map(|undo| match undo {
            UndoEntry::Asked(..) => None,
            UndoEntry::Joined(domain) => {
                Arc::make_mut(&mut written.extents[domain.0 as usize]).pop()
            }
        });
        LeftState {
            joined: joined.collect(),
            undo: self.undo.len(),
        }
    }

    /// Comes back to the state that was left.
    pub fn return_from(&mut self, mut passed: LeftState, written: &mut WritableState<'_>) {
        for SavedValue { value, slot } in &mut self.held {
            std::mem::swap(&mut written.slots[*slot as usize], value);
        }
        for undo in self.undo.iter().take(passed.undo) {
            match undo {
                UndoEntry::Asked(..) => {}
                UndoEntry::Joined(domain) => {
                    let extent = Arc::make_mut(&mut written.extents[domain.0 as usize]);
                    extent.extend(passed.joined.pop());
                }
            }
        }
    }

    fn take_back(&mut self, held: usize, undo: usize, written: &mut WritableState<'_>) {
        for SavedValue { value, slot } in self.held.drain(held..).rev() {
            written.slots[slot as usize].replace_by(value);
        }
        for undo in self.undo.drain(undo..).rev() {
            match undo {
                UndoEntry::Asked(slot, before) => written.asked[slot as usize] = before,
                UndoEntry::Joined(domain) => {
                    Arc::make_mut(&mut written.extents[domain.0 as usize]).pop();
                }
            }
        }
    }

    /// Gives the marks back that the layer covered.
    fn uncover(&mut self, layer: &Layer) {
        for CoveredMark { slot, mark } in self.covered.drain(layer.covered..).rev() {
            self.marks[slot as usize] = mark;
        }
        self.epoch = layer.epoch;
        self.depth -= 1;
    }

    /// Moves the updates from `start` on into the current set.
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
