//! Indices of ranges: the elements of a range, grouped by their value under a function.
//!
//! An index belongs to one round, in which it describes the state before the step. It is built at its second use in a round:
//! the first one, which may be the last, visits the elements one by one.

use asmotion_ir::{BinderRange, DomainId, FunctionId};
use asmotion_value::Value;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// The function and the range of an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct IndexKey {
    function: FunctionId,
    range: IndexedRange,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum IndexedRange {
    Ints(i64, i64),
    Atoms(u32, u32),
    Domain(DomainId),
}

impl IndexKey {
    /// Returns the key for a range; `None` if ranges of this form have no index.
    pub fn of(function: FunctionId, range: &BinderRange) -> Option<Self> {
        let range = match range {
            BinderRange::Ints(low, high) => IndexedRange::Ints(*low, *high),
            BinderRange::Atoms(first, count) => IndexedRange::Atoms(*first, *count),
            BinderRange::Domain(domain) => IndexedRange::Domain(*domain),
            BinderRange::Bools | BinderRange::Elements(_) => return None,
        };
        Some(Self { function, range })
    }
}

/// The elements of a range, grouped by value. Within a group they are in ascending order.
#[derive(Debug, Default)]
pub(crate) struct RangeIndex {
    /// All elements, group by group.
    elements: Vec<Value>,
    /// The number of the group of each value.
    groups: FxHashMap<Value, u32>,
    /// The end of each group in `elements`; it begins where the one before it ends.
    ends: Vec<u32>,
}

impl RangeIndex {
    /// Groups the elements, which are given in ascending order with their values.
    pub fn build(&mut self, pairs: &mut Vec<(Value, Value)>) {
        self.elements.clear();
        self.groups.clear();
        self.ends.clear();
        let mut group_of = Vec::with_capacity(pairs.len());
        for (_, value) in &*pairs {
            let next = self.ends.len() as u32;
            let group = match self.groups.get(value) {
                Some(&group) => group,
                None => {
                    self.groups.insert(value.clone(), next);
                    self.ends.push(0);
                    next
                }
            };
            self.ends[group as usize] += 1;
            group_of.push(group);
        }
        let mut start = 0;
        for end in &mut self.ends {
            // the place of the group's next element; after the last one, its end
            start += std::mem::replace(end, start);
        }
        self.elements.resize(pairs.len(), Value::Undef);
        for ((element, _), group) in pairs.drain(..).zip(group_of) {
            let place = &mut self.ends[group as usize];
            self.elements[*place as usize] = element;
            *place += 1;
        }
    }

    /// Returns `true` if the range has no elements.
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// Returns the elements with this value, in ascending order.
    pub fn group(&self, value: &Value) -> &[Value] {
        let Some(&group) = self.groups.get(value) else {
            return &[];
        };
        let group = group as usize;
        let start = group.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.elements[start as usize..self.ends[group] as usize]
    }
}

/// The uses of an index in a round.
#[derive(Debug, Default)]
struct IndexUse {
    /// The round of the last use; 0 before the first.
    round: u64,
    /// The index of this or an earlier round, whose memory is used again.
    index: Option<Arc<RangeIndex>>,
    /// `true` if `index` is that of this round.
    is_built: bool,
    /// `true` if the index cannot be built in this round.
    is_refused: bool,
}

/// The state of an index at a use.
pub(crate) enum IndexState {
    /// The first use in the round: visiting each element costs less.
    First,
    Built(Arc<RangeIndex>),
    /// The index is to be built, in this buffer.
    Missing(Arc<RangeIndex>),
    /// The index cannot be built in this round.
    Refused,
}

/// All indices of a state.
#[derive(Debug, Default)]
pub(crate) struct RangeIndices {
    uses: FxHashMap<IndexKey, IndexUse>,
}

impl Clone for RangeIndices {
    /// Creates no indices: they are built again where they are needed.
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl RangeIndices {
    /// Returns the state of an index in a round.
    pub fn at(&mut self, key: IndexKey, round: u64) -> IndexState {
        let known = self.uses.entry(key).or_default();
        if known.round != round {
            known.round = round;
            known.is_refused = false;
            known.is_built = false;
            return IndexState::First;
        }
        if known.is_refused {
            return IndexState::Refused;
        }
        match &known.index {
            Some(index) if known.is_built => IndexState::Built(index.clone()),
            Some(_) | None => IndexState::Missing(known.index.take().unwrap_or_default()),
        }
    }

    /// Stores an index, or notes that it cannot be built in this round.
    pub fn set(&mut self, key: IndexKey, index: Option<Arc<RangeIndex>>) {
        let known = self.uses.entry(key).or_default();
        known.is_built = index.is_some();
        known.is_refused = index.is_none();
        known.index = index;
    }
}
