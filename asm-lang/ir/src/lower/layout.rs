//! Layout: assigns slots to the locations of functions.

use super::{Lowering, domain, order, reach};
use crate::id::FunctionId;
use crate::program::{AxisRange, DomainElements, Function, FunctionKind, SlotAxis, Storage};
use asmotion_hir::{Meaning, Type, TypeId};
use asmotion_stdlib::MessageQuery;

/// Limit for the lazy slots of all functions over finite domains, as a multiple of the limit for one function.
const MAX_LARGE: u64 = 4;

/// Limit for the elements created by `extend` that a function has slots for; locations with others are interned.
pub const MAX_CREATED: u32 = 1 << 14;

/// Limit for the slots of such a function.
const MAX_CREATED_SLOTS: u32 = 1 << 16;

impl Lowering<'_> {
    /// Assigns storage to every function, in order of declaration.
    pub(super) fn layout(&mut self) {
        self.domains();
        for (index, function) in self.model.functions.iter().enumerate() {
            let id = asmotion_hir::FunctionId(index as u32);
            let is_result = self.model.reserved.result == Some(id);
            let stored = is_result || matches!(function.meaning, Meaning::State);
            // initial values that depend on others of the same function are computed on first
            // access
            let met = function.initial.is_some()
                && (self.model.compatible || order::is_recursive(self.model, id));
            let storage = match (stored, met) {
                (true, false) => self.storage(&function.parameters),
                (true, true) => Storage::Interned,
                (false, _) => Storage::None,
            };
            if let Storage::Dense { base, .. } = storage {
                self.program.dense.push(FunctionId(index as u32));
                if is_result {
                    self.program.result = base;
                }
            }
            let parameters = function
                .parameters
                .iter()
                .map(|&ty| self.shape(ty))
                .collect();
            self.program.functions.push(Function {
                kind: kind(function.kind),
                parameters,
                codomain: self.shape(function.codomain),
                within: self.membership(function.codomain),
                restricted: self.is_restricted(function.codomain),
                narrow: self.is_narrow(&function.parameters),
                open: self.is_open(function.codomain),
                storage,
                initial: None,
                clock: clock(&function.name).filter(|_| function.library),
                mail: message_query(function),
                own: !function.library && function.kind != asmotion_hir::FunctionKind::Local,
            });
        }
    }

    fn storage(&mut self, parameters: &[TypeId]) -> Storage {
        let ranges = parameters.iter().map(|&ty| self.axis(ty)).collect();
        match ranges {
            Some(ranges) => self.dense(ranges),
            None => Storage::Interned,
        }
    }

    /// Allocates lazy slots for functions over finite domains that are too large for eager ones.
    fn large_layout(&mut self) {
        let mut room = self.lazy.saturating_mul(MAX_LARGE);
        for (index, function) in self.model.functions.iter().enumerate() {
            let id = asmotion_hir::FunctionId(index as u32);
            let is_large = self.program.functions[index].storage == Storage::Interned
                && function.kind != asmotion_hir::FunctionKind::Local
                && !(function.initial.is_some() && order::is_recursive(self.model, id));
            let ranges = function.parameters.iter().map(|&ty| self.exact_axis(ty));
            let Some(ranges) = ranges.collect::<Option<Vec<_>>>().filter(|_| is_large) else {
                continue;
            };
            if let Storage::Dense {
                base, count, axes, ..
            } = self.dense_within(ranges, self.lazy.min(room))
            {
                room -= u64::from(count);
                self.program.dense.push(FunctionId(index as u32));
                self.program.functions[index].storage = Storage::Dense {
                    base,
                    count,
                    axes,
                    lazy: true,
                };
            }
        }
    }

    /// Allocates lazy slots for functions over a domain without constants that rules extend, for the first elements that
    /// they create.
    fn created_layout(&mut self) {
        let limit = self.lazy.min(u64::from(MAX_CREATED_SLOTS));
        for (index, function) in self.model.functions.iter().enumerate() {
            let id = asmotion_hir::FunctionId(index as u32);
            let is_suitable = self.program.functions[index].storage == Storage::Interned
                && matches!(
                    function.kind,
                    asmotion_hir::FunctionKind::Controlled | asmotion_hir::FunctionKind::Out
                )
                && !(function.initial.is_some() && order::is_recursive(self.model, id));
            if !is_suitable {
                continue;
            }
            let known = function.parameters.iter().map(|&ty| self.exact_axis(ty));
            let Some(mut ranges) = known.collect::<Option<Vec<_>>>() else {
                continue;
            };
            let is_growing =
                |(range, &ty): (&AxisRange, &TypeId)| range.count() == 0 && self.is_extended(ty);
            let mut growing = ranges
                .iter()
                .zip(&function.parameters)
                .enumerate()
                .filter(|(_, pair)| is_growing(*pair))
                .map(|(position, _)| position);
            let (Some(position), None) = (growing.next(), growing.next()) else {
                continue;
            };
            let others = ranges.iter().enumerate().filter(|(at, _)| *at != position);
            let others = others.map(|(_, range)| u64::from(range.count()));
            let room = limit
                .checked_div(others.product::<u64>())
                .unwrap_or_default();
            let count = room.min(u64::from(MAX_CREATED)) as u32;
            ranges[position] = AxisRange::Atoms {
                first: self.program.atom_domains.len() as u32,
                count,
            };
            if let Storage::Dense {
                base, count, axes, ..
            } = self.dense_within(ranges, limit)
            {
                self.program.dense.push(FunctionId(index as u32));
                self.program.functions[index].storage = Storage::Dense {
                    base,
                    count,
                    axes,
                    lazy: true,
                };
            }
        }
    }

    fn is_extended(&self, ty: TypeId) -> bool {
        let domain = self.model.types.get(ty).as_domain();
        domain.is_some_and(|it| self.program.domains[domain::id(it).0 as usize].is_extended)
    }

    fn dense(&mut self, ranges: Vec<AxisRange>) -> Storage {
        self.dense_within(ranges, self.dense)
    }

    /// Allocates slots for all locations with arguments in these ranges, unless there are more than `limit`.
    fn dense_within(&mut self, ranges: Vec<AxisRange>, limit: u64) -> Storage {
        let count = ranges.iter().try_fold(1u64, |product, range| {
            product
                .checked_mul(u64::from(range.count()))
                .filter(|&product| product <= limit)
        });
        let Some(count) = count.filter(|&count| count > 0) else {
            return Storage::Interned;
        };
        let base = self.program.slots;
        self.program.slots += count as u32;
        let mut stride = 1;
        let mut axes: Vec<SlotAxis> = ranges
            .into_iter()
            .rev()
            .map(|over| {
                let axis = SlotAxis { over, stride };
                stride *= over.count();
                axis
            })
            .collect();
        axes.reverse();
        Storage::Dense {
            base,
            count: count as u32,
            axes,
            lazy: false,
        }
    }

    /// Allocates lazy slots: for large functions, and for functions over infinite domains, for the arguments that the
    /// program is known to use. Such a location gets its value on first access, like an interned one.
    pub(super) fn lazy_layout(&mut self) {
        self.program.eager = self.program.slots;
        if self.model.compatible {
            // in this mode, the order of first accesses is observable
            return;
        }
        self.large_layout();
        self.created_layout();
        let used = reach::arguments(&self.program);
        for (id, used) in used {
            let index = id.0 as usize;
            let parameters = self.model.functions[index].parameters.clone();
            let ranges = parameters.iter().zip(used).map(|(&ty, used)| match used {
                Some(used) => used.axis(),
                None => self.axis(ty),
            });
            let Some(ranges) = ranges.collect() else {
                continue;
            };
            if let Storage::Dense {
                base, count, axes, ..
            } = self.dense(ranges)
            {
                self.program.dense.push(id);
                self.program.functions[index].storage = Storage::Dense {
                    base,
                    count,
                    axes,
                    lazy: true,
                };
            }
        }
    }

    /// Returns the range of an argument of this type if it has all elements of the type, and no others.
    fn exact_axis(&self, ty: TypeId) -> Option<AxisRange> {
        let domain = self.model.types.get(ty).as_domain();
        let elements = domain.map(|it| &self.program.domains[domain::id(it).0 as usize].elements);
        match elements {
            Some(DomainElements::Computed(_)) => None,
            Some(
                DomainElements::Ints { .. }
                | DomainElements::Atoms { .. }
                | DomainElements::Undefined
                | DomainElements::Open,
            )
            | None => self.axis(ty),
        }
    }

    /// Returns the range of an argument of this type if it is finite and known.
    fn axis(&self, ty: TypeId) -> Option<AxisRange> {
        let ty = self.model.types.get(ty);
        if *ty == Type::Boolean {
            return Some(AxisRange::Bool);
        }
        let declared = ty.as_domain()?;
        match &self.program.domains[domain::id(declared).0 as usize].elements {
            DomainElements::Ints { low, high } => {
                let count = u32::try_from(high.checked_sub(*low)?.checked_add(1)?).ok()?;
                Some(AxisRange::Ints { low: *low, count })
            }
            DomainElements::Atoms { first, count } => Some(AxisRange::Atoms {
                first: first.0,
                count: *count,
            }),
            DomainElements::Computed(_) | DomainElements::Undefined => {
                self.axis(self.model.domain(declared).kind.base()?)
            }
            DomainElements::Open => None,
        }
    }
}

/// Returns the nanoseconds in a unit of a clock function of the time libraries.
fn clock(name: &str) -> Option<i64> {
    const SECOND: i64 = 1_000_000_000;
    Some(match name {
        "mCurrTimeNanosecs" => 1,
        "mCurrTimeMillisecs" => SECOND / 1000,
        "mCurrTimeSecs" => SECOND,
        "mCurrTimeMins" => 60 * SECOND,
        "mCurrTimeHours" => 3600 * SECOND,
        _ => return None,
    })
}

fn kind(kind: asmotion_hir::FunctionKind) -> FunctionKind {
    match kind {
        asmotion_hir::FunctionKind::Static | asmotion_hir::FunctionKind::Derived => {
            FunctionKind::Fixed
        }
        asmotion_hir::FunctionKind::Monitored => FunctionKind::Monitored,
        asmotion_hir::FunctionKind::Controlled => FunctionKind::Controlled,
        asmotion_hir::FunctionKind::Local => FunctionKind::Local,
        asmotion_hir::FunctionKind::Shared => FunctionKind::Shared,
        asmotion_hir::FunctionKind::Out => FunctionKind::Out,
    }
}

/// Returns the query about messages that a function stands for.
fn message_query(function: &asmotion_hir::Function) -> Option<MessageQuery> {
    if function.library {
        MessageQuery::named(&function.name)
    } else {
        function.is_client.then_some(MessageQuery::Client)
    }
}
