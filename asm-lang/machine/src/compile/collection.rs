//! Compilation of collection terms.

use super::Compiler;
use super::range::Ranges;
use crate::fault::FaultKind;
use crate::limits::MAX_ELEMENTS;
use crate::run::code::TermCode;
use asmotion_ir::{Collection, Origin, Term};
use asmotion_value::{Real, Value};
use std::ops::ControlFlow;
use std::sync::Arc;

impl Compiler<'_> {
    pub(super) fn interval(
        &self,
        collection: Collection,
        from: &Term,
        to: &Term,
        step: Option<&Term>,
        origin: Origin,
    ) -> TermCode {
        let (from, to) = (self.term(from), self.term(to));
        let step = step.map(|step| self.term(step));
        Box::new(move |run| {
            let (from, to) = (from(run), to(run));
            let step = step.as_ref().map(|step| step(run));
            match listed(&from, &to, step.as_ref()) {
                Ok(Some(items)) => collect(collection, items),
                Ok(None) => Value::Undef,
                Err(count) => run.fail(FaultKind::TooLarge(count), origin),
            }
        })
    }

    pub(super) fn comprehension(
        &self,
        collection: Collection,
        ranges: Ranges,
        item: &Term,
        origin: Origin,
    ) -> TermCode {
        let item = self.term(item);
        Box::new(move |run| {
            let mut items = Vec::new();
            ranges.each(run, &mut |run| {
                items.push(item(run));
                if items.len() as u64 > MAX_ELEMENTS {
                    run.fail(FaultKind::TooLarge(items.len() as u64), origin);
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(())
            });
            collect(collection, items)
        })
    }
}

/// Builds a collection from its elements.
pub(super) fn collect(collection: Collection, items: Vec<Value>) -> Value {
    match collection {
        Collection::Set => Value::set(items),
        Collection::Seq => Value::Seq(Arc::new(items)),
        Collection::Bag => Value::bag(items),
    }
}

/// Lists the elements of `from : to, step`, including the bound if a step reaches it. Returns
/// `None` if a bound is undef, and the count as an error if there are too many elements.
fn listed(from: &Value, to: &Value, step: Option<&Value>) -> Result<Option<Vec<Value>>, u64> {
    match (from, to, step) {
        (Value::Int(from), Value::Int(to), None | Some(Value::Int(_))) => {
            let step = match step {
                Some(Value::Int(step)) => *step,
                _ => 1,
            };
            if step <= 0 || from > to {
                return Ok(Some(Vec::new()));
            }
            let count = (to.abs_diff(*from) / step.unsigned_abs()).saturating_add(1);
            if count > MAX_ELEMENTS {
                return Err(count);
            }
            Ok(Some(
                (0..count as i64)
                    .map(|index| Value::Int(from.wrapping_add(index.wrapping_mul(step))))
                    .collect(),
            ))
        }
        (Value::Real(from), Value::Real(to), None | Some(Value::Real(_))) => {
            let step = match step {
                Some(Value::Real(step)) => step.get(),
                _ => 1.0,
            };
            let count = ((to.get() - from.get()) / step + 1e-9).floor() + 1.0;
            if !(step > 0.0 && count >= 1.0) {
                return Ok(Some(Vec::new()));
            }
            if count > MAX_ELEMENTS as f64 {
                return Err(count as u64);
            }
            let decimals = decimals(from.get()).max(decimals(step));
            let number =
                |index: u64| Real::new(rounded(from.get() + index as f64 * step, decimals));
            Ok(Some(
                (0..count as u64)
                    .map(|index| Value::Real(number(index)))
                    .collect(),
            ))
        }
        _ => Ok(None),
    }
}

/// Returns the number of decimals in the shortest representation of a number.
fn decimals(number: f64) -> usize {
    let written = format!("{number}");
    written
        .split_once('.')
        .map_or(0, |(_, decimals)| decimals.len())
}

/// Rounds to a number of decimals: `0.1 + 2 · 0.1` gives `0.3`, as a reader expects.
fn rounded(number: f64, decimals: usize) -> f64 {
    format!("{number:.decimals$}").parse().unwrap_or(number)
}
