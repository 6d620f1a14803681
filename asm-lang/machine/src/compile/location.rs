//! Compilation of locations: computes the slot of a location and reads it.

use super::Compiler;
use crate::limits::MAX_AXES;
use crate::run::StepContext;
use crate::run::code::TermCode;
use asmotion_ir::{
    AxisRange, FunctionId, FunctionKind, Origin, Slot, SlotAxis, Storage, Term, TermNode, ValueKind,
};
use asmotion_value::Value;

/// Code that returns the slot of a location.
pub(super) type SlotCode = Box<dyn Fn(&mut StepContext<'_>) -> Slot + Send + Sync>;

/// Code that returns the index of an argument on its axis. If the argument is off the axis, it
/// returns [`MISS`] and leaves the argument on the stack.
type IndexCode = Box<dyn Fn(&mut StepContext<'_>) -> u32 + Send + Sync>;

/// Stands for no index; greater than any index, because axes are shorter.
const MISS: u32 = u32::MAX;

impl Compiler<'_> {
    /// Compiles a read of a known slot.
    pub(super) fn fixed(&self, function: FunctionId, slot: Slot, origin: Origin) -> TermCode {
        if self.is_input(function) {
            return Box::new(move |run| run.input(slot, function, origin));
        }
        let slot = slot as usize;
        Box::new(move |run| run.state.store.slots[slot].clone())
    }

    /// Compiles a read of a location with computed arguments.
    pub(super) fn location(
        &self,
        function: FunctionId,
        arguments: &[Term],
        origin: Origin,
    ) -> TermCode {
        let slot = self.slot(function, arguments);
        if self.is_input(function) {
            return Box::new(move |run| {
                let slot = slot(run);
                run.input(slot, function, origin)
            });
        }
        Box::new(move |run| {
            let slot = slot(run) as usize;
            run.state.store.slots[slot].clone()
        })
    }

    /// Compiles the slot of a term that is a location but no input: its value can be borrowed from
    /// the state.
    pub(super) fn stored(&self, term: &Term) -> Option<SlotCode> {
        let TermNode::Location(function, arguments) = &*term.node else {
            return None;
        };
        (!self.is_input(*function)).then(|| self.slot(*function, arguments))
    }

    pub(super) fn is_input(&self, function: FunctionId) -> bool {
        matches!(
            self.program.functions[function.0 as usize].kind,
            FunctionKind::Monitored | FunctionKind::Shared
        )
    }

    /// Compiles the slot of a function applied to arguments.
    pub(super) fn slot(&self, function: FunctionId, arguments: &[Term]) -> SlotCode {
        let storage = &self.program.functions[function.0 as usize].storage;
        match (storage, &self.windows[function.0 as usize]) {
            (
                Storage::Dense {
                    base, axes, lazy, ..
                },
                _,
            ) if axes.len() <= MAX_AXES => {
                let (base, lazy) = (*base, *lazy);
                on_axes(
                    function,
                    self.indices(arguments, axes),
                    move |run, index| {
                        let slot = base + index;
                        if lazy && !run.state.locations.is_materialised(slot) {
                            return intern_lazy(run, function, slot);
                        }
                        slot
                    },
                )
            }
            (_, Some((window, axes))) => {
                let (window, known) = (*window, axes.clone());
                on_axes(
                    function,
                    self.indices(arguments, axes),
                    move |run, index| match run.state.memo.windows.find(window, index) {
                        Some(slot) => slot,
                        None => intern_near(run, function, window, &known, index),
                    },
                )
            }
            (Storage::Dense { .. } | Storage::Interned | Storage::None, _) => {
                let arguments = self.values(arguments);
                Box::new(move |run| {
                    let from = arguments.push_all(run);
                    let slot = run.slot(function, from);
                    run.stack.truncate(from);
                    slot
                })
            }
        }
    }

    fn indices(&self, arguments: &[Term], axes: &[SlotAxis]) -> Vec<(IndexCode, SlotAxis)> {
        let pairs = arguments.iter().zip(axes);
        pairs
            .map(|(argument, axis)| (self.index(argument, axis.over), *axis))
            .collect()
    }

    fn index(&self, argument: &Term, over: AxisRange) -> IndexCode {
        match (&*argument.node, over) {
            (TermNode::Local(local), over) => {
                let local = *local;
                Box::new(move |run| match over.index(run.local(local)) {
                    Some(index) => index,
                    None => record_missed_index(run, run.local(local).clone()),
                })
            }
            (_, AxisRange::Ints { low, count }) if argument.kind == ValueKind::Int => {
                let integer = self.integer(argument);
                Box::new(move |run| {
                    let number = integer.get(run);
                    match number.and_then(|number| number.checked_sub(low)) {
                        Some(index) if (0..i64::from(count)).contains(&index) => index as u32,
                        _ => record_missed_index(run, number.map_or(Value::Undef, Value::Int)),
                    }
                })
            }
            (_, over) => {
                let argument = self.term(argument);
                Box::new(move |run| {
                    let argument = argument(run);
                    match over.index(&argument) {
                        Some(index) => index,
                        None => record_missed_index(run, argument),
                    }
                })
            }
        }
    }
}

#[cold]
fn record_missed_index(run: &mut StepContext<'_>, argument: Value) -> u32 {
    run.stack.push(argument);
    MISS
}

/// Computes the indices of all arguments, and the slot from them.
fn on_axes(
    function: FunctionId,
    mut axes: Vec<(IndexCode, SlotAxis)>,
    found: impl Fn(&mut StepContext<'_>, u32) -> Slot + Send + Sync + 'static,
) -> SlotCode {
    if axes.len() == 1
        && let Some((index, axis)) = axes.pop()
    {
        return Box::new(move |run| match index(run) {
            MISS => intern_off_axes(run, function, &[], &[]),
            index => found(run, index * axis.stride),
        });
    }
    Box::new(move |run| {
        let mut together = 0;
        let mut indices = [0; MAX_AXES];
        for (position, (index, axis)) in axes.iter().enumerate() {
            let index = index(run);
            if index == MISS {
                return intern_off_axes(run, function, &axes, &indices[..position]);
            }
            indices[position] = index;
            together += index * axis.stride;
        }
        found(run, together)
    })
}

/// Initialises a lazy slot on first access.
#[cold]
fn intern_lazy(run: &mut StepContext<'_>, function: FunctionId, slot: Slot) -> Slot {
    let from = run.stack.len();
    run.state.arguments(run.program, slot, run.stack);
    let slot = run.slot(function, from);
    run.stack.truncate(from);
    slot
}

/// Interns a location on first access and enters it in its window.
#[cold]
fn intern_near(
    run: &mut StepContext<'_>,
    function: FunctionId,
    window: usize,
    axes: &[SlotAxis],
    index: u32,
) -> Slot {
    let from = run.stack.len();
    let argument = |axis: &SlotAxis| axis.over.argument(index / axis.stride % axis.over.count());
    run.stack.extend(axes.iter().map(argument));
    let slot = run.slot(function, from);
    run.stack.truncate(from);
    run.state.memo.windows.remember(window, index, slot);
    slot
}

/// Returns the slot of a location with an argument off its axis. That argument is on the stack;
/// those before it are given by their indices, and those after it are still to be evaluated.
#[cold]
fn intern_off_axes(
    run: &mut StepContext<'_>,
    function: FunctionId,
    axes: &[(IndexCode, SlotAxis)],
    before: &[u32],
) -> Slot {
    let argument = run.stack.pop().unwrap_or_default();
    let from = run.stack.len();
    let known = axes
        .iter()
        .zip(before)
        .map(|((_, axis), &index)| axis.over.argument(index));
    run.stack.extend(known);
    run.stack.push(argument);
    for (index, axis) in axes.iter().skip(before.len() + 1) {
        match index(run) {
            MISS => {}
            index => run.stack.push(axis.over.argument(index)),
        }
    }
    let slot = run.slot(function, from);
    run.stack.truncate(from);
    slot
}
