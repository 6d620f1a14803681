//! Locations with known slots or axes, accessed in place.

use crate::atoms::AtomRange;
use crate::emit::{Emitter, KnownValue, NativeInt, Ssa, UpdateMode};
use crate::frame::at;
use crate::static_analysis::is_repeatable;
use asmotion_ir::{
    AssignTarget, AxisRange, DomainElements, DomainId, FunctionId, Origin, Slot, Storage, Term,
    TermNode, ValueKind,
};
use asmotion_value::layout;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{I8, I32, I64, I64X2};
use cranelift_codegen::ir::{InstBuilder, Type};

/// The address of a location.
pub(crate) struct Located {
    /// Address from which `offset`, in bytes, leads to the slot.
    pointer: Ssa,
    offset: i32,
    /// The number of the slot, relative to `base`; `None` if it is constant.
    index: Option<Ssa>,
    base: i64,
    pub function: FunctionId,
    /// `true` if the location may still need its initial value.
    pub is_lazy: bool,
}

impl Located {
    /// Returns the number of the slot if it is constant.
    pub fn constant(&self) -> Option<i64> {
        self.index.is_none().then_some(self.base)
    }
}

impl Emitter<'_> {
    /// Generates the address of the location that a term denotes, if native code supports it.
    pub fn place_of(&mut self, term: &Term) -> Option<Located> {
        if let TermNode::Slot(function, slot) = &*term.node {
            (!self.is_input(*function)).then(|| self.fixed(*function, *slot))
        } else if let TermNode::Location(function, arguments) = &*term.node
            && !self.is_input(*function)
        {
            self.located(*function, arguments)
        } else {
            None
        }
    }

    /// Returns `true` if native code can compute the address of an update's location.
    pub fn is_place(&self, place: &AssignTarget) -> bool {
        match place {
            AssignTarget::Slot(function, _) => !self.is_input(*function),
            AssignTarget::Location(function, arguments) => {
                !self.is_input(*function) && self.has_axes(*function, arguments)
            }
            AssignTarget::Local(_) => false,
        }
    }

    /// Generates the address of an update's location; requires [`Emitter::is_place`].
    pub fn target(&mut self, place: &AssignTarget) -> Option<Located> {
        match place {
            AssignTarget::Slot(function, slot) => Some(self.fixed(*function, *slot)),
            AssignTarget::Location(function, arguments) => self.located(*function, arguments),
            AssignTarget::Local(_) => None,
        }
    }

    pub fn fixed(&mut self, function: FunctionId, slot: Slot) -> Located {
        Located {
            pointer: self.slots(),
            offset: (i64::from(slot) * at::VALUE_SIZE) as i32,
            index: None,
            base: slot.into(),
            function,
            is_lazy: false,
        }
    }

    fn has_axes(&self, function: FunctionId, arguments: &[Term]) -> bool {
        let Storage::Dense { axes, .. } = &self.program.functions[function.0 as usize].storage
        else {
            return false;
        };
        axes.len() == arguments.len()
            && axes.iter().zip(arguments).all(|(axis, argument)| {
                let expected = match axis.over {
                    AxisRange::Bool => ValueKind::Bool,
                    AxisRange::Ints { .. } => ValueKind::Int,
                    AxisRange::Atoms { .. } => ValueKind::Atom,
                };
                self.kind(argument) == expected && is_repeatable(self.program, argument)
            })
    }

    /// Generates the address of a location; leaves for the detour if an argument is off its axis.
    fn located(&mut self, function: FunctionId, arguments: &[Term]) -> Option<Located> {
        if !self.has_axes(function, arguments) {
            return None;
        }
        let Storage::Dense { base, axes, .. } =
            self.program.functions[function.0 as usize].storage.clone()
        else {
            return None;
        };
        let mut index: Option<Ssa> = None;
        let mut constant = i64::from(base);
        for (axis, argument) in axes.iter().zip(arguments) {
            let (along, offset) = match axis.over {
                AxisRange::Bool => {
                    let truth = self.truth(argument);
                    (Some(self.builder.ins().uextend(I64, truth)), 0)
                }
                AxisRange::Ints { low, count } => {
                    let number = self.integer(argument);
                    self.axis_offset(number, low, count)
                }
                AxisRange::Atoms { first, count } => {
                    let atom = self.atom(argument);
                    if let Some(AtomRange::Atoms(only, 1)) = atom.among
                        && let Some(offset) = only.checked_sub(first)
                        && offset < count
                    {
                        constant += i64::from(offset) * i64::from(axis.stride);
                        continue;
                    }
                    let along = self.builder.ins().iadd_imm_s(atom.value, -i64::from(first));
                    let inside = atom
                        .among
                        .is_some_and(|among| among.is_within(first, count));
                    if !inside {
                        self.bail_outside(along, count);
                    }
                    (Some(self.builder.ins().uextend(I64, along)), 0)
                }
            };
            constant += offset * i64::from(axis.stride);
            let Some(along) = along else {
                continue;
            };
            let step = match axis.stride {
                1 => along,
                stride => self.scaled(along, i64::from(stride)),
            };
            index = Some(match index {
                None => step,
                Some(sum) => self.builder.ins().iadd(sum, step),
            });
        }
        let slots = self.slots();
        let pointer = match index {
            None => slots,
            Some(index) => {
                let bytes = self.scaled(index, at::VALUE_SIZE);
                self.builder.ins().iadd(slots, bytes)
            }
        };
        Some(Located {
            pointer,
            offset: i32::try_from(constant * at::VALUE_SIZE).ok()?,
            index,
            base: constant,
            function,
            is_lazy: self.program.functions[function.0 as usize]
                .storage
                .is_lazy(),
        })
    }

    /// Returns the address of the slots.
    fn slots(&mut self) -> Ssa {
        match &self.direct {
            Some(direct) => direct.slots,
            None => self.field(I64, at::SLOTS),
        }
    }

    /// Generates the product of a number and a size in bytes or a stride.
    pub fn scaled(&mut self, number: Ssa, size: i64) -> Ssa {
        match size {
            1.. if size.count_ones() == 1 => {
                let bits = i64::from(size.trailing_zeros());
                self.builder.ins().ishl_imm_u(number, bits)
            }
            _ => self.builder.ins().imul_imm_s(number, size),
        }
    }

    /// Returns the position of a number on an axis as a sum of a value, if it is not constant, and a constant.
    fn axis_offset(&mut self, number: NativeInt, low: i64, count: u32) -> (Option<Ssa>, i64) {
        let high = low.saturating_add(i64::from(count) - 1);
        if let Some(constant) = number.constant().filter(|it| (low..=high).contains(it)) {
            return (None, constant - low);
        }
        let (root, offset) = number.root;
        if number.is_proven
            && number.interval.within(low, high)
            && let Some(offset) = offset.checked_sub(low)
            && i32::try_from(offset).is_ok()
        {
            return (Some(root), offset);
        }
        let along = self
            .builder
            .ins()
            .iadd_imm_s(number.value, low.wrapping_neg());
        self.bail_outside(along, count);
        (Some(along), 0)
    }

    fn bail_outside(&mut self, along: Ssa, count: u32) {
        let outside = self.compare(IntCC::UnsignedGreaterThanOrEqual, along, i64::from(count));
        self.bail_if(outside);
    }

    /// Loads the tag of a location's value.
    pub fn tag(&mut self, located: &Located) -> Ssa {
        if located.constant().is_none() && self.read_in_sequence(located, I8).is_some() {
            return self.number(I8, 0);
        }
        self.load(self.memory.slots, I8, located.pointer, located.offset)
    }

    /// Loads the payload of a location's value; leaves for the detour if the tag differs.
    pub fn read(&mut self, located: &Located, tag: u8, ty: Type) -> Ssa {
        let kind = match tag {
            layout::BOOL => ValueKind::Bool,
            layout::INT => ValueKind::Int,
            layout::ATOM => ValueKind::Atom,
            _ => ValueKind::Other,
        };
        if let Some(value) = self.read_in_sequence(located, ty) {
            return value;
        }
        if self.value_fact(located.function).is_always(kind) {
            return self.payload(located, ty);
        }
        self.expect(self.memory.slots, located.pointer, located.offset, tag, ty)
    }

    /// Loads the payload of a location's value, whose tag is known.
    pub fn payload(&mut self, located: &Located, ty: Type) -> Ssa {
        let offset = located.offset + at::PAYLOAD;
        let payload = self.load(self.memory.slots, ty, located.pointer, offset);
        if ty == I8 {
            // a truth value may be used as an index, which must be in bounds even if a fact about it is wrong
            return self.builder.ins().band_imm_s(payload, 1);
        }
        payload
    }

    /// Returns the number of the slot.
    pub fn slot(&mut self, located: &Located) -> Ssa {
        match located.index {
            None => self.number(I64, located.base),
            Some(index) => self.builder.ins().iadd_imm_s(index, located.base),
        }
    }

    /// Returns the domain to which values of a location are restricted.
    fn restricting_domain(&self, place: &AssignTarget) -> Option<DomainId> {
        match place {
            AssignTarget::Slot(function, _) | AssignTarget::Location(function, _) => {
                self.program.functions[function.0 as usize].within
            }
            AssignTarget::Local(_) => None,
        }
    }

    /// Returns `true` if native code can check a value of this kind against the location's domain.
    pub fn is_accepted(&self, place: &AssignTarget, kind: ValueKind) -> bool {
        let Some(domain) = self.restricting_domain(place) else {
            return true;
        };
        match self.program.domains[domain.0 as usize].elements {
            DomainElements::Ints { .. } => kind == ValueKind::Int,
            DomainElements::Atoms { .. } => kind == ValueKind::Atom,
            DomainElements::Open => true,
            DomainElements::Computed(_) | DomainElements::Undefined => false,
        }
    }

    /// Leaves for the detour if the value is not in the location's domain.
    pub fn check_domain(&mut self, place: &AssignTarget, value: KnownValue) {
        let Some(domain) = self.restricting_domain(place) else {
            return;
        };
        match (&self.program.domains[domain.0 as usize].elements, value) {
            (&DomainElements::Ints { low, high }, KnownValue::Int(int)) => {
                if int.interval.within(low, high) {
                    return;
                }
                let above = self.builder.ins().iadd_imm_s(int.value, low.wrapping_neg());
                let outside =
                    self.compare(IntCC::UnsignedGreaterThan, above, high.wrapping_sub(low));
                self.bail_if(outside);
            }
            (&DomainElements::Atoms { first, count }, KnownValue::Atom(atom)) => {
                self.check_atom(domain, first.0, count, atom);
            }
            _ => {}
        }
    }

    /// Adds an update; leaves for the detour if the location already has one.
    pub fn write(&mut self, located: &Located, value: KnownValue, origin: Origin) {
        if located.is_lazy {
            // undef may mean that a lazy location has no initial value yet, which a closure
            // computes
            let tag = self.tag(located);
            let unmet = self.compare(IntCC::Equal, tag, i64::from(layout::UNDEF));
            self.bail_if(unmet);
        }
        if self.writes_directly(located, value, origin) {
            return;
        }
        let slot = self.slot(located);
        let mark = self.mark(slot);
        let of = self.load(self.memory.updates, I32, mark, at::MARK_EPOCH);
        let epoch = self.field(I32, at::EPOCH);
        let again = self.builder.ins().icmp(IntCC::Equal, of, epoch);
        match self.mode {
            UpdateMode::Step => {
                let length = self.load(self.memory.length, I64, self.frame, at::LENGTH);
                let room = self.field(I64, at::ROOM);
                let full = self.builder.ins().icmp(IntCC::Equal, length, room);
                let odd = self.builder.ins().bor(again, full);
                self.bail_if(odd);
                let slot = self.builder.ins().ireduce(I32, slot);
                self.add(slot, mark, value, origin);
            }
            UpdateMode::Layer => {
                self.bail_if(again);
                self.write_outside(self.calls.write, slot, value, origin);
            }
            UpdateMode::Sequence => self.write_through(located, slot, mark, again, value, origin),
        }
    }

    /// Adds an update to the set of a sequence and writes the slot immediately.
    fn write_through(
        &mut self,
        located: &Located,
        slot: Ssa,
        mark: Ssa,
        again: Ssa,
        value: KnownValue,
        origin: Origin,
    ) {
        let (over, first, done) = (self.block(), self.block(), self.block());
        let (scalar, fits, outside) = (self.block(), self.block(), self.cold_block());
        // the old value is moved and overwritten without a drop, so it must be a scalar
        let tag = self.tag(located);
        let last_scalar = i64::from(layout::LAST_SCALAR);
        let is_scalar = self.compare(IntCC::UnsignedLessThanOrEqual, tag, last_scalar);
        self.branch(is_scalar, scalar, outside);
        self.begin(scalar);
        self.branch(again, over, first);
        self.begin(over);
        let index = self.load(self.memory.updates, I32, mark, at::MARK_INDEX);
        let index = self.builder.ins().uextend(I64, index);
        let update = self.entry(index);
        self.put_update(update, value, origin);
        self.store_scalar(self.memory.slots, located.pointer, located.offset, value);
        self.jump(done);
        self.begin(first);
        let room = self.load(self.memory.length, I64, self.frame, at::SEQUENCE_ROOM);
        self.branch(room, fits, outside);
        self.begin(fits);
        let room = self.builder.ins().iadd_imm_s(room, -1);
        self.store(self.memory.length, room, self.frame, at::SEQUENCE_ROOM);
        let slot_number = self.builder.ins().ireduce(I32, slot);
        self.hold(located, slot_number);
        self.cover(mark, slot_number);
        self.add(slot_number, mark, value, origin);
        self.store_scalar(self.memory.slots, located.pointer, located.offset, value);
        self.jump(done);
        self.begin(outside);
        self.write_outside(self.calls.write_through, slot, value, origin);
        self.jump(done);
        self.begin(done);
    }

    /// Saves the value of a slot until the sequence ends.
    fn hold(&mut self, located: &Located, slot: Ssa) {
        let held = self.next(at::HELD, at::HELD_LENGTH, at::HELD_SIZE);
        let value = self.load(self.memory.slots, I64X2, located.pointer, located.offset);
        self.store(self.memory.updates, value, held, at::HELD_VALUE);
        self.store(self.memory.updates, slot, held, at::HELD_SLOT);
    }

    /// Saves the mark of a slot until the sequence ends.
    fn cover(&mut self, mark: Ssa, slot: Ssa) {
        let covered = self.next(at::COVERED, at::COVERED_LENGTH, at::COVERED_SIZE);
        self.store(self.memory.updates, slot, covered, at::COVERED_SLOT);
        for (from, to) in [
            (at::MARK_EPOCH, at::COVERED_EPOCH),
            (at::MARK_INDEX, at::COVERED_INDEX),
        ] {
            let part = self.load(self.memory.updates, I32, mark, from);
            self.store(self.memory.updates, part, covered, to);
        }
    }

    /// Appends an update to the list and marks its slot.
    fn add(&mut self, slot: Ssa, mark: Ssa, value: KnownValue, origin: Origin) {
        let length = self.load(self.memory.length, I64, self.frame, at::LENGTH);
        let index = self.builder.ins().ireduce(I32, length);
        let epoch = self.field(I32, at::EPOCH);
        self.store(self.memory.updates, epoch, mark, at::MARK_EPOCH);
        self.store(self.memory.updates, index, mark, at::MARK_INDEX);
        let update = self.next(at::LIST, at::LENGTH, at::UPDATE_SIZE);
        self.store(self.memory.updates, slot, update, at::UPDATE_SLOT);
        self.put_update(update, value, origin);
    }

    /// Returns the address of the next element of a list, which has capacity for it.
    fn next(&mut self, list: i32, length: i32, size: i64) -> Ssa {
        let start = self.field(I64, list);
        let count = self.load(self.memory.length, I64, self.frame, length);
        let bytes = self.builder.ins().imul_imm_s(count, size);
        let more = self.builder.ins().iadd_imm_s(count, 1);
        self.store(self.memory.length, more, self.frame, length);
        self.builder.ins().iadd(start, bytes)
    }

    /// Calls a host function that writes; the value is passed in the frame.
    fn write_outside(
        &mut self,
        call: crate::emit::HostFunction,
        slot: Ssa,
        value: KnownValue,
        origin: Origin,
    ) {
        self.store_scalar(self.memory.frame, self.frame, at::GIVEN, value);
        let slot = self.builder.ins().ireduce(I32, slot);
        let origin = self.number(I32, i64::from(origin.0));
        self.call(call, &[slot, origin]);
    }

    pub fn mark(&mut self, slot: Ssa) -> Ssa {
        let marks = self.field(I64, at::MARKS);
        let bytes = self.scaled(slot, at::MARK_SIZE);
        self.builder.ins().iadd(marks, bytes)
    }

    fn entry(&mut self, index: Ssa) -> Ssa {
        let list = self.field(I64, at::LIST);
        let bytes = self.builder.ins().imul_imm_s(index, at::UPDATE_SIZE);
        self.builder.ins().iadd(list, bytes)
    }

    pub fn put_update(&mut self, update: Ssa, value: KnownValue, origin: Origin) {
        let origin = self.number(I32, i64::from(origin.0));
        self.store(self.memory.updates, origin, update, at::UPDATE_ORIGIN);
        self.store_scalar(self.memory.updates, update, at::UPDATE_VALUE, value);
    }

    /// Stores a scalar in memory that is uninitialised or holds a scalar.
    pub fn store_scalar(
        &mut self,
        memory: cranelift_codegen::ir::MemFlagsData,
        pointer: Ssa,
        offset: i32,
        value: KnownValue,
    ) {
        let Some((tag, payload)) = self.tag_and_payload(value) else {
            return;
        };
        // a single store, because a wider load of two recent narrow stores would stall (no store
        // forwarding)
        let tag = self.number(I64, i64::from(tag));
        let both = self.builder.ins().scalar_to_vector(I64X2, tag);
        let both = self.builder.ins().insertlane(both, payload, 1);
        self.store(memory, both, pointer, offset);
    }
}
