//! Packed states: a canonical encoding in bytes, for storing, comparing and looking up many states.
//!
//! A step needs values that it can access by one index, 16 bytes each. A model checker or a
//! recording needs states that are small, and equal exactly if the machine continues in the same
//! way. A [`PackedState`] is therefore a string of bytes in a canonical form:
//!
//! - A slot of a function with finitely many values takes as many bits as they need, including a
//!   code for `undef` and an escape code for any other value, which is then encoded in bytes. All
//!   other values are encoded in bytes; a small integer takes one.
//! - An interned or lazy location is encoded with its function and arguments, in their order, and
//!   only if its value differs from the initial one. A location that was never accessed and one that
//!   was reset to its initial value are therefore the same, and so are the states of machines that
//!   accessed locations in a different order.
//! - Locations that the environment is asked for in each step are not part of a state.
//! - Nothing in [`Memo`](crate::state::Memo) is: the results of earlier queries and computations.
//!
//! Atoms created from the reserve are distinguished by the order of their creation. Two states that
//! differ only in this order are isomorphic, but not equal.
//!
//! A packed state takes 16 bytes and one allocation. Without messages, interned and lazy locations,
//! the allocation contains three bytes in addition to the slots.

mod layout;
mod value;

pub(crate) use layout::Layout;
pub(crate) use value::{Reader, Writer};

use crate::state::{MachineState, dense};
use asmotion_ir::{DomainId, FunctionId, Program, Slot};
use asmotion_value::Value;
use layout::{Coding, ELSE};
use std::sync::Arc;

/// A state of a program in packed form. Equal states have equal bytes, regardless of the history of
/// the machines and of their back ends.
///
/// Only states of the same program can be compared: those of different programs may be equal by
/// coincidence.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct PackedState(Box<[u8]>);

impl PackedState {
    pub(crate) fn new(bytes: Vec<u8>) -> Self {
        Self(bytes.into_boxed_slice())
    }

    /// Returns the bytes. Their format depends on the program and on the version of this crate.
    pub fn as_bytes(&self) -> &[u8] {
        &self.0
    }
}

/// An interned or lazy location in the form in which it is packed.
struct Met<'a> {
    function: FunctionId,
    arguments: Vec<Value>,
    current: &'a Value,
    initially: &'a Value,
    was_queried: bool,
}

impl MachineState {
    /// Writes the parts of the state that determine its future.
    pub(crate) fn pack(&self, program: &Program, layout: &Layout, to: &mut Writer) {
        to.count(self.store.reserve.len());
        for (domain, _) in &self.store.reserve {
            to.count(domain.0 as usize);
        }
        self.pack_eager(layout, to);
        self.pack_met(program, layout, to, true);
        for domain in &layout.message_domains {
            let extent = self.initial.extents.get(domain.0 as usize);
            to.values(extent.map(|extent| extent.iter()).unwrap_or_default());
        }
        if layout.recalls {
            let eager = self.locations.eager as usize;
            let slots = self.initial.slots.get(..eager).unwrap_or_default();
            to.values(slots.iter());
            to.value(&Value::Int(self.initial.now_ns));
        }
    }

    fn pack_eager(&self, layout: &Layout, to: &mut Writer) {
        let mut rest: Vec<&Value> = Vec::new();
        to.bits(layout.bits, |bits| {
            for field in &layout.fields {
                for (index, slot) in field.slots().enumerate() {
                    let value = &self.store.slots[slot as usize];
                    match field.coding {
                        Coding::Bits { .. } => {
                            let code = field.coding.code(value);
                            bits.set(field.at(index), field.coding.width(), code);
                            if code == ELSE {
                                rest.push(value);
                            }
                        }
                        Coding::Bytes => rest.push(value),
                    }
                }
            }
        });
        for value in rest {
            to.value(value);
        }
    }

    /// Writes what listings of the state show in addition: the accessed locations with their
    /// initial values, and the initial values that depend on inputs.
    pub(crate) fn pack_history(&self, program: &Program, layout: &Layout, to: &mut Writer) {
        self.pack_met(program, layout, to, false);
        if !program.initial_inputs.is_empty() {
            let eager = self.locations.eager as usize;
            let slots = self.initial.slots.get(..eager).unwrap_or_default();
            to.values(slots.iter());
        }
    }

    fn pack_met(&self, program: &Program, layout: &Layout, to: &mut Writer, has_changed: bool) {
        let mut met: Vec<Met<'_>> = self
            .slots()
            .skip_while(|slot| *slot < self.locations.eager)
            .filter(|slot| self.has_changed(program, *slot) == has_changed)
            .filter_map(|slot| self.met(program, layout, slot))
            .collect();
        met.sort_by(|left, right| {
            let key = |met: &Met<'_>| met.function;
            key(left)
                .cmp(&key(right))
                .then_with(|| left.arguments.cmp(&right.arguments))
        });
        to.count(met.len());
        for met in met {
            to.count(met.function.0 as usize);
            to.values(met.arguments.iter());
            to.value(met.current);
            to.value(met.initially);
            to.value(&Value::Bool(met.was_queried));
        }
    }

    /// Returns `true` if an accessed location differs from one that was never accessed.
    fn has_changed(&self, program: &Program, slot: Slot) -> bool {
        // the reference has no initial state: a location exists from its first access on
        program.compatible
            || self.store.slots[slot as usize] != self.initial.slots[slot as usize]
            || self.initial.provided.contains(&slot)
    }

    fn met(&self, program: &Program, layout: &Layout, slot: Slot) -> Option<Met<'_>> {
        let now = &self.store.slots[slot as usize];
        let initially = &self.initial.slots[slot as usize];
        let was_heard = self.initial.provided.contains(&slot);
        let (function, arguments) = self.location(program, slot)?;
        (!layout.is_reread[function.0 as usize]).then_some(Met {
            function,
            arguments,
            current: now,
            initially,
            was_queried: was_heard,
        })
    }
}

/// Function, arguments, current value, initial value, and `true` if the environment provided the
/// latter.
type MetValue = (FunctionId, Vec<Value>, Value, Value, bool);

/// The contents of a packed state, complete and checked before a machine takes them over.
pub(crate) struct Unpacked {
    eager: Vec<(Slot, Value)>,
    interned: Vec<MetValue>,
    reserve: Vec<(DomainId, u32)>,
    extents: Vec<(DomainId, Vec<Value>)>,
    recalled: Option<(Vec<Value>, i64)>,
    initially: Vec<Value>,
}

impl Unpacked {
    /// Reads the output of [`MachineState::pack`]; returns `None` if the bytes do not fit the
    /// program.
    pub fn read(program: &Program, layout: &Layout, from: &mut Reader<'_>) -> Option<Self> {
        let mut reserve: Vec<(DomainId, u32)> = Vec::new();
        for _ in 0..from.count()? {
            let domain = DomainId(u32::try_from(from.count()?).ok()?);
            program.domains.get(domain.0 as usize)?;
            let known = reserve.iter().rev().find(|(known, _)| *known == domain);
            let number = known.map_or(1, |(_, number)| number + 1);
            reserve.push((domain, number));
        }
        from.set_atoms(program.atom_domains.len() + reserve.len());
        let eager = Self::read_eager(layout, from)?;
        let mut met = Vec::new();
        Self::read_met(program, from, &mut met)?;
        let mut extents = Vec::new();
        for &domain in &layout.message_domains {
            extents.push((domain, from.values()?));
        }
        let recalled = if layout.recalls {
            let slots = from.values()?;
            let Value::Int(now_ns) = from.value()? else {
                return None;
            };
            Some((slots, now_ns))
        } else {
            None
        };
        Some(Self {
            eager,
            interned: met,
            reserve,
            extents,
            recalled,
            initially: Vec::new(),
        })
    }

    /// Reads the output of [`MachineState::pack_history`].
    pub fn read_history(&mut self, program: &Program, from: &mut Reader<'_>) -> Option<()> {
        from.set_atoms(program.atom_domains.len() + self.reserve.len());
        Self::read_met(program, from, &mut self.interned)?;
        if !program.initial_inputs.is_empty() {
            self.initially = from.values()?;
        }
        Some(())
    }

    fn read_met(program: &Program, from: &mut Reader<'_>, met: &mut Vec<MetValue>) -> Option<()> {
        for _ in 0..from.count()? {
            let function = FunctionId(u32::try_from(from.count()?).ok()?);
            program.functions.get(function.0 as usize)?;
            let arguments = from.values()?;
            let fixed = dense(program, function, &arguments);
            fixed
                .is_none_or(|slot| slot >= program.eager)
                .then_some(())?;
            let (now, initially) = (from.value()?, from.value()?);
            let was_heard = from.value()? == Value::Bool(true);
            met.push((function, arguments, now, initially, was_heard));
        }
        Some(())
    }

    fn read_eager(layout: &Layout, from: &mut Reader<'_>) -> Option<Vec<(Slot, Value)>> {
        let bits = from.bits(layout.bits)?;
        let mut eager = Vec::new();
        for field in &layout.fields {
            for (index, slot) in field.slots().enumerate() {
                let value = match field.coding {
                    Coding::Bits { .. } => {
                        let code = bits.get(field.at(index), field.coding.width());
                        match code {
                            ELSE => from.value()?,
                            code => field.coding.value(code)?,
                        }
                    }
                    Coding::Bytes => from.value()?,
                };
                eager.push((slot, value));
            }
        }
        Some(eager)
    }
}

impl MachineState {
    /// Replaces the state by an unpacked one. Cached values are discarded, except those that hold
    /// in every state of the program.
    pub(crate) fn restore(
        &mut self,
        program: &Program,
        layout: &Layout,
        supers: &[Vec<DomainId>],
        unpacked: Unpacked,
    ) {
        self.forget_materialised();
        for &slot in &layout.reread {
            self.store.slots[slot as usize] = Value::Undef;
        }
        for (slot, value) in unpacked.eager {
            self.store.slots[slot as usize] = value;
        }
        let mut initially = unpacked.initially;
        if let Some((slots, now_ns)) = unpacked.recalled {
            initially = slots;
            self.initial.now_ns = now_ns;
        }
        for (slot, value) in self.initial.slots.iter_mut().zip(initially) {
            *slot = value;
        }
        for (domain, elements) in unpacked.extents {
            if let Some(extent) = self.initial.extents.get_mut(domain.0 as usize) {
                *extent = Arc::new(elements);
            }
        }
        self.store.extents.clone_from(&self.initial.extents);
        let declared = program.atom_domains.len() as u32;
        for (atom, (domain, _)) in (declared..).zip(&unpacked.reserve) {
            for &domain in &supers[domain.0 as usize] {
                let extent = &mut self.store.extents[domain.0 as usize];
                Arc::make_mut(extent).push(Value::Atom(asmotion_value::Atom(atom)));
            }
        }
        self.store.reserve = unpacked.reserve;
        for (function, arguments, now, initially, was_heard) in unpacked.interned {
            let slot = match dense(program, function, &arguments) {
                Some(slot) => {
                    self.materialise(slot, initially);
                    slot
                }
                None => {
                    // conservative: the domain is checked again before the next update
                    let outside = program.functions[function.0 as usize].narrow;
                    self.intern(function, &arguments, initially, outside)
                }
            };
            self.store.slots[slot as usize] = now;
            if was_heard {
                self.initial.provided.push(slot);
            }
        }
        self.commit();
    }
}
